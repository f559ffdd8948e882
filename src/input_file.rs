//! Bytes of input files, never more than a limit: a name may lead to a device that has no end.

use std::{fs::File, io::Read, path::Path};

use crate::error::{Error, Result};

/// A longer file is no program, polyline or wrench table, bytes: 2 million lines of 64.
const MAX_LENGTH: u64 = 128 << 20;

/// The bytes of a program, polyline or wrench table.
///
/// # Errors
/// A file that cannot be read or is longer than 128 MiB.
pub fn read(file: &Path) -> Result<Vec<u8>> {
    read_at_most(file, MAX_LENGTH)
}

/// The bytes of `file`; it may have `most`, a multiple of 1 MiB.
pub(crate) fn read_at_most(file: &Path, most: u64) -> Result<Vec<u8>> {
    let fault = |source| Error::Read { file: file.to_path_buf(), source };
    let mut bytes = Vec::new();
    File::open(file).map_err(fault)?.take(most + 1).read_to_end(&mut bytes).map_err(fault)?;
    if bytes.len() as u64 > most {
        return Err(fault(std::io::Error::other(format!("longer than {} MiB", most >> 20))));
    }
    Ok(bytes)
}
