//! Files appear whole or not at all.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use crate::error::{Error, Result};

/// A file to be written below a result folder.
#[derive(Debug, Clone)]
pub struct OutputFile {
    /// Name relative to the folder.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl OutputFile {
    /// A file called `name`.
    pub fn new(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { name: name.into(), bytes: bytes.into() }
    }
}

/// Makes `folder` and finds out, before anything is computed, whether files can be written there.
///
/// # Errors
/// They cannot.
pub fn prepare(folder: &Path) -> Result<()> {
    let fault = |source| Error::Write { file: folder.to_path_buf(), source };
    std::fs::create_dir_all(folder).map_err(fault)?;
    temporary_file(folder).map(drop).map_err(fault)
}

/// Writes `files` into `folder`, each first to a temporary file beside its place and then renamed.
///
/// # Errors
/// The folder or a file cannot be written; no half-written file remains.
pub fn write_all(folder: &Path, files: &[OutputFile]) -> Result<Vec<PathBuf>> {
    let fault = |file: &Path, source| Error::Write { file: file.to_path_buf(), source };
    std::fs::create_dir_all(folder).map_err(|e| fault(folder, e))?;
    let mut written = Vec::new();
    for file in files {
        let path = folder.join(&file.name);
        let mut temporary = temporary_file(folder).map_err(|e| fault(&path, e))?;
        temporary.write_all(&file.bytes).map_err(|e| fault(&path, e))?;
        temporary.persist(&path).map_err(|e| fault(&path, e.error))?;
        written.push(path);
    }
    Ok(written)
}

/// Removes a file; one that is not there is no fault.
///
/// # Errors
/// It cannot be removed.
pub fn remove(file: &Path) -> Result<()> {
    match std::fs::remove_file(file) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::Write { file: file.to_path_buf(), source })
        }
        _ => Ok(()),
    }
}

/// A file that disappears unless it is given its name. Temporary files are private by default; results are not.
fn temporary_file(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".partial-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_cannot_be_made_is_an_error_naming_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("taken");
        std::fs::write(&file, b"x").unwrap();
        let below = file.join("below");
        let written = write_all(&below, &[OutputFile::new("a.csv", "1")]).map(drop);
        for error in [written.unwrap_err(), prepare(&below).unwrap_err()] {
            assert!(error.to_string().contains("taken/below: cannot be written"), "{error}");
        }
    }

    #[test]
    fn writing_replaces_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        prepare(folder.path()).unwrap();
        for content in ["1", "2"] {
            write_all(folder.path(), &[OutputFile::new("a.csv", content)]).unwrap();
        }
        assert_eq!(std::fs::read_to_string(folder.path().join("a.csv")).unwrap(), "2");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
