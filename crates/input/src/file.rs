//! Reads input files, never more than a limit, and never devices or pipes, which may have no end.

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

/// Reads the bytes of a program, polyline or wrench table. Fails if it is no file, cannot be read or is longer than 1 GiB.
pub fn read(file: &Path) -> Result<Vec<u8>> {
    read_at_most(file, MAX_LENGTH)
}

/// Reads the bytes of an input file and remembers it for [`is_input`]; fails above `most` bytes, a multiple of 1 MiB.
pub fn read_at_most(file: &Path, most: u64) -> Result<Vec<u8>> {
    let bytes = read_bounded(file, most)?;
    input_files().extend(file.canonicalize());
    Ok(bytes)
}

/// Reads the bytes of a file without remembering it as an input; fails above `most` bytes, a multiple of 1 MiB.
pub fn read_bounded(file: &Path, most: u64) -> Result<Vec<u8>> {
    let fault = |source| Error::Read { file: file.to_path_buf(), source };
    let mut bytes = Vec::new();
    open(file)?.take(most + 1).read_to_end(&mut bytes).map_err(fault)?;
    if bytes.len() as u64 > most {
        return Err(fault(IoError::other(format!("longer than {} MiB", most >> 20))));
    }
    Ok(bytes)
}

/// Opens a `file` that is neither a device nor a pipe. Fails when it is one, or cannot be opened.
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
    file.canonicalize().is_ok_and(|file| input_files().contains(&file))
}

/// Locks the set of all input files read since the program began, by canonical path.
fn input_files() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    static INPUTS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    INPUTS.lock().unwrap_or_else(PoisonError::into_inner)
}
