//! Bytes of input files, never more than a limit, and never of anything but files: a name may lead to a device that has no
//! end, or to a pipe that nobody writes to.

use std::{
    collections::BTreeSet,
    fs::File,
    io::{Error as IoError, Read},
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

use crate::error::{Error, Result};

/// A longer file is no program, polyline or wrench table, bytes: 20 million lines of 53.
const MAX_LENGTH: u64 = 1 << 30;

/// The bytes of a program, polyline or wrench table.
///
/// # Errors
/// A file that cannot be read or is longer than 1 GiB; anything that is no file.
pub fn read(file: &Path) -> Result<Vec<u8>> {
    read_at_most(file, MAX_LENGTH)
}

/// The bytes of the input `file`; it may have `most`, a multiple of 1 MiB.
pub fn read_at_most(file: &Path, most: u64) -> Result<Vec<u8>> {
    let bytes = bounded(file, most)?;
    inputs().extend(file.canonicalize());
    Ok(bytes)
}

/// The bytes of a `file` that may be written over; it may have `most`, a multiple of 1 MiB.
pub fn bounded(file: &Path, most: u64) -> Result<Vec<u8>> {
    let fault = |source| Error::Read { file: file.to_path_buf(), source };
    let mut bytes = Vec::new();
    open(file)?.take(most + 1).read_to_end(&mut bytes).map_err(fault)?;
    if bytes.len() as u64 > most {
        return Err(fault(IoError::other(format!("longer than {} MiB", most >> 20))));
    }
    Ok(bytes)
}

/// Opens a `file` that is neither a device nor a pipe.
///
/// # Errors
/// It is one, or cannot be opened.
pub fn open(file: &Path) -> Result<File> {
    let fault = |source| Error::Read { file: file.to_path_buf(), source };
    let kind = std::fs::metadata(file).map_err(fault)?.file_type();
    if !kind.is_file() && !kind.is_dir() {
        return Err(fault(IoError::other("is a device or a pipe, expected a file")));
    }
    File::open(file).map_err(fault)
}

/// Whether `file`, by this name or another, was read as an input since the program began.
pub fn is_input(file: &Path) -> bool {
    file.canonicalize().is_ok_and(|file| inputs().contains(&file))
}

/// The inputs read so far. One list for the whole program, since nothing that reads may be forgotten.
fn inputs() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    static INPUTS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    INPUTS.lock().unwrap_or_else(PoisonError::into_inner)
}
