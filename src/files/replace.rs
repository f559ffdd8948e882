//! Which files may be replaced: those that this program wrote, and that this command does not read.

use std::{
    io::{Error as IoError, ErrorKind},
    path::Path,
};

use crate::input::{
    error::{Error, Result},
    file::is_input,
};

/// What becomes of a file that this program did not write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Foreign {
    /// It stays.
    Kept,
    /// It stays, and the command says how it is replaced: with `--force`.
    KeptUnlessForced,
    /// It is replaced.
    Replaced,
}

impl Foreign {
    /// For a command that has `--force`.
    pub fn forced(force: bool) -> Self {
        if force { Self::Replaced } else { Self::KeptUnlessForced }
    }
}

/// Refuses `path` as the place of a new file where something else stands. `is_ours` says whether a file there was written
/// by this program; what becomes of it otherwise, `foreign` says.
///
/// # Errors
/// There is an input of this command, a file of somebody else, one that may not be written, a link, a folder or a device; or no
/// file can have this name.
pub fn may_replace(path: &Path, foreign: Foreign, is_ours: impl FnOnce() -> bool) -> Result<()> {
    let refuse = |source| Err(Error::Write { file: path.to_path_buf(), source });
    let found = match std::fs::symlink_metadata(path) {
        Ok(found) => found,
        Err(source) if source.kind() == ErrorKind::NotFound => return Ok(()),
        Err(source) => return refuse(source),
    };
    let kind = found.file_type();
    let problem = if is_input(path) {
        "is an input of this command; expected another place"
    } else if kind.is_dir() {
        "is a folder, expected a file or the name of a new one"
    } else if kind.is_symlink() {
        "is a link, which is left as it is; expected another place"
    } else if !kind.is_file() {
        "is a device or a pipe, expected a file or the name of a new one"
    } else if found.permissions().readonly() {
        "is read-only and left as it is; expected another place"
    } else if foreign == Foreign::Replaced || is_ours() {
        return Ok(());
    } else if foreign == Foreign::KeptUnlessForced {
        "was not written by kinetostat, or was changed since; expected another place, or --force to replace it"
    } else {
        "was not written by kinetostat, or was changed since; expected another place, or that it is removed"
    };
    refuse(IoError::other(problem))
}
