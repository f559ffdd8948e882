//! Overwrite protection: a command replaces files that this program wrote, others only with `--force`, those that it reads never.

use std::{
    io::{Error as IoError, ErrorKind},
    path::Path,
};

use crate::input::{
    error::{Error, Result},
    file::is_input,
};

/// What happens to a file that this program did not write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Foreign {
    /// It is kept.
    Kept,
    /// It is kept, and the error says that `--force` would replace it.
    KeptUnlessForced,
    /// It is replaced.
    Replaced,
}

impl Foreign {
    /// Returns the rule for a command with the option `--force`.
    pub fn forced(force: bool) -> Self {
        if force { Self::Replaced } else { Self::KeptUnlessForced }
    }
}

/// Checks that a new file may take the place of what is at `path`. `is_ours` says whether this program wrote a file there; `foreign`
/// decides about any other file. `Err` for an input of this command, a file to be kept or not writable, a link, a folder or a device.
pub fn check_may_replace(path: &Path, foreign: Foreign, is_ours: impl FnOnce() -> bool) -> Result<()> {
    let refuse = |source| Err(Error::Write { file: path.to_path_buf(), source });
    let metadata = match std::fs::symlink_metadata(path) {
        Ok(metadata) => metadata,
        Err(source) if source.kind() == ErrorKind::NotFound => return Ok(()),
        Err(source) => return refuse(source),
    };
    let kind = metadata.file_type();
    let problem = if is_input(path) {
        "is an input of this command; expected another place"
    } else if kind.is_dir() {
        "is a folder, expected a file or the name of a new one"
    } else if kind.is_symlink() {
        "is a link, which is left as it is; expected another place"
    } else if !kind.is_file() {
        "is a device or a pipe, expected a file or the name of a new one"
    } else if metadata.permissions().readonly() {
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
