//! Which files may be replaced: those that this program wrote, and that this command does not read.

use std::{
    io::{Error as IoError, ErrorKind},
    path::Path,
};

use crate::input::{
    error::{Error, Result},
    file::is_input,
};

/// Refuses `path` as the place of a new file where something else stands. `is_ours` says whether a file there was written
/// by this program.
///
/// # Errors
/// There is an input of this command, a file of somebody else, a link, a folder or a device; or no file can have this name.
pub fn may_replace(path: &Path, is_ours: impl FnOnce() -> bool) -> Result<()> {
    let refuse = |source| Err(Error::Write { file: path.to_path_buf(), source });
    let kind = match std::fs::symlink_metadata(path) {
        Ok(found) => found.file_type(),
        Err(source) if source.kind() == ErrorKind::NotFound => return Ok(()),
        Err(source) => return refuse(source),
    };
    let problem = if is_input(path) {
        "is an input of this command; expected another place"
    } else if kind.is_dir() {
        "is a folder, expected a file or the name of a new one"
    } else if kind.is_symlink() {
        "is a link, which is left as it is; expected another place"
    } else if !kind.is_file() {
        "is a device or a pipe, expected a file or the name of a new one"
    } else if !is_ours() {
        "was not written by kinetostat, or was changed since; expected another place, or that it is removed"
    } else {
        return Ok(());
    };
    refuse(IoError::other(problem))
}
