//! Files appear whole or not at all.

use std::{
    ffi::OsStr,
    io::{Error as IoError, ErrorKind, Write},
    path::{Path, PathBuf},
};

use tempfile::{NamedTempFile, TempDir, TempPath};

use crate::input::error::{Error, Result};

/// A file to be written below a result folder.
#[derive(Debug)]
pub struct OutputFile {
    /// Name relative to the folder.
    pub name: String,
    content: Content,
}

#[derive(Debug)]
enum Content {
    Bytes(Vec<u8>),
    /// A temporary file in the result folder, which disappears unless it is given its name.
    File(NamedTempFile),
}

impl OutputFile {
    /// A file called `name` with these bytes.
    pub fn new(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { name: name.into(), content: Content::Bytes(bytes.into()) }
    }

    /// A file that is to be called `name`; it is in the result folder already, see [`temporary_file`].
    pub fn written(name: impl Into<String>, file: NamedTempFile) -> Self {
        Self { name: name.into(), content: Content::File(file) }
    }
}

impl OutputFile {
    /// Its text, if it is one in memory.
    pub fn text(&self) -> Option<String> {
        match &self.content {
            Content::Bytes(bytes) => String::from_utf8(bytes.clone()).ok(),
            Content::File(_) => None,
        }
    }
}

/// Begin of the names of temporary files.
const TEMPORARY: &str = ".partial-";

/// Makes `folder` and finds out, before anything is computed, whether files can be written there.
///
/// # Errors
/// They cannot.
pub fn prepare(folder: &Path) -> Result<()> {
    let fault = |source| Error::Write { file: folder.to_path_buf(), source };
    if folder.is_file() {
        return Err(fault(std::io::Error::other("is a file, expected a folder or the name of a new one")));
    }
    std::fs::create_dir_all(folder).map_err(fault)?;
    temporary_file(folder).map(drop).map_err(fault)?;
    // Files in a folder in it: some systems have an end to the length of a path.
    room_for_a_name(folder, &"x".repeat(LONGEST_NAME))
}

/// Length that no name in a result folder, with that of a temporary folder before it, exceeds.
const LONGEST_NAME: usize = 200;

/// Whether a file in `folder` can have this name.
fn room_for_a_name(folder: &Path, name: &str) -> Result<()> {
    match std::fs::symlink_metadata(folder.join(name)) {
        Err(source) if source.kind() != ErrorKind::NotFound => Err(Error::Write { file: folder.join(name), source }),
        _ => Ok(()),
    }
}

/// Finds out, before anything is computed, whether `file` can be written with [`write_beside`]; its folder need not exist.
/// Removes what a command left that was killed while it wrote this file. Gives the name of the file.
///
/// # Errors
/// It cannot be written.
pub fn prepare_beside(file: &Path) -> Result<&str> {
    let fault = |source| Error::Write { file: file.to_path_buf(), source };
    let Some(name) = file.file_name().and_then(OsStr::to_str) else {
        return Err(fault(IoError::other("expected the name of a file, of letters that can be read")));
    };
    let folder = file.ancestors().skip(1).find(|folder| folder.as_os_str().is_empty() || folder.exists());
    let folder = folder.filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(Error::Write {
            file: folder.to_path_buf(),
            source: IoError::other("is a file, expected a folder"),
        });
    }
    let prefix = beside(name);
    room_for_a_name(folder, &format!("{prefix}000000"))?;
    temporary(folder, &prefix).map(drop).map_err(fault)?;
    if file.parent().is_some_and(|parent| parent == folder || parent.as_os_str().is_empty()) {
        clean_of(folder, &prefix)?;
    }
    Ok(name)
}

/// Begin of the names of temporary files of a file called `name`: other commands that write into its folder leave them.
fn beside(name: &str) -> String {
    format!(".{name}{TEMPORARY}")
}

/// A folder in `folder` in which files are made before they take the places of others.
///
/// # Errors
/// It cannot be made.
pub fn staging(folder: &Path) -> Result<TempDir> {
    let made = tempfile::Builder::new().prefix(TEMPORARY).tempdir_in(folder);
    made.map_err(|source| Error::Write { file: folder.to_path_buf(), source })
}

/// Removes temporary files that a run left in `folder` when it was killed. No other run must be using the folder.
///
/// # Errors
/// The folder cannot be read, or a file cannot be removed.
pub fn clean(folder: &Path) -> Result<()> {
    clean_of(folder, TEMPORARY)
}

fn clean_of(folder: &Path, prefix: &str) -> Result<()> {
    let fault = |source| Error::Read { file: folder.to_path_buf(), source };
    for entry in std::fs::read_dir(folder).map_err(fault)? {
        let entry = entry.map_err(fault)?;
        if !entry.file_name().to_string_lossy().starts_with(prefix) {
            continue;
        }
        if entry.file_type().map_err(fault)?.is_dir() {
            let path = entry.path();
            std::fs::remove_dir_all(&path).map_err(|source| Error::Write { file: path, source })?;
        } else {
            remove(&entry.path())?;
        }
    }
    Ok(())
}

/// Writes `files` into `folder`: all of them are made before the first takes its place.
///
/// # Errors
/// The folder or a file cannot be written; no half-written file remains.
pub fn write_all(folder: &Path, files: Vec<OutputFile>) -> Result<()> {
    Transaction::within(folder)?.place_all(files)?.commit()
}

/// Writes `files` into the folder of `file`; see [`write_all`] and [`prepare_beside`].
///
/// # Errors
/// As [`write_all`].
pub fn write_beside(file: &Path, files: Vec<OutputFile>) -> Result<()> {
    Transaction::beside(file)?.place_all(files)?.commit()
}

/// Changes of files in a folder, made one after another once all of them are ready. Whatever leaves files goes through one; where they belong
/// together, its first change says that they are not complete, and its last that they are.
#[derive(Debug)]
pub struct Transaction {
    folder: PathBuf,
    /// Begin of the names of files that are not in their places yet.
    prefix: String,
    /// The changes, in their order.
    pub steps: Vec<Step>,
}

/// A change of one file that comes whole or not at all.
#[derive(Debug)]
pub enum Step {
    /// A temporary file gets its name.
    Name(TempPath, PathBuf),
    /// A file made elsewhere takes its place.
    Move(PathBuf, PathBuf),
    /// A file is removed, if it is there.
    Remove(PathBuf),
}

impl Transaction {
    /// In `folder`, which is made if need be.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn within(folder: &Path) -> Result<Self> {
        Self::new(folder, TEMPORARY.into())
    }

    /// In the folder of `file`, which is made if need be.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn beside(file: &Path) -> Result<Self> {
        Self::new(folder_of(file), beside_file(file))
    }

    fn new(folder: &Path, prefix: String) -> Result<Self> {
        std::fs::create_dir_all(folder).map_err(|source| Error::Write { file: folder.to_path_buf(), source })?;
        Ok(Self { folder: folder.to_path_buf(), prefix, steps: Vec::new() })
    }

    /// `file` takes its place; it is made now.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn place(&mut self, file: OutputFile) -> Result<()> {
        let path = self.folder.join(&file.name);
        let made = match file.content {
            Content::File(made) => Ok(made),
            Content::Bytes(bytes) => {
                temporary(&self.folder, &self.prefix).and_then(|mut made| made.write_all(&bytes).map(|()| made))
            }
        };
        let made = made.map_err(|source| Error::Write { file: path.clone(), source })?;
        self.steps.push(Step::Name(made.into_temp_path(), path));
        Ok(())
    }

    /// As [`Transaction::place`], of all `files`.
    ///
    /// # Errors
    /// As there.
    pub fn place_all(mut self, files: Vec<OutputFile>) -> Result<Self> {
        files.into_iter().try_for_each(|file| self.place(file)).map(|()| self)
    }

    /// The file called `name` that is in the folder `made` takes its place.
    pub fn place_made(&mut self, made: &Path, name: &str) {
        self.steps.push(Step::Move(made.join(name), self.folder.join(name)));
    }

    /// The file called `name` is removed.
    pub fn remove(&mut self, name: &str) {
        self.steps.push(Step::Remove(self.folder.join(name)));
    }

    /// Makes all changes.
    ///
    /// # Errors
    /// One cannot be made; those before are.
    pub fn commit(self) -> Result<()> {
        self.steps.into_iter().try_for_each(Step::take)
    }
}

impl Step {
    /// Makes the change.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn take(self) -> Result<()> {
        match self {
            Self::Name(made, path) => made.persist(&path).map_err(|e| Error::Write { file: path, source: e.error }),
            Self::Move(made, path) => {
                std::fs::rename(made, &path).map_err(|source| Error::Write { file: path, source })
            }
            Self::Remove(path) => remove(&path),
        }
    }
}

/// As [`staging`], beside `file`, whose folder is made if need be.
///
/// # Errors
/// It cannot be made.
pub fn staging_beside(file: &Path) -> Result<TempDir> {
    let fault = |source| Error::Write { file: file.to_path_buf(), source };
    let folder = folder_of(file);
    std::fs::create_dir_all(folder).map_err(fault)?;
    tempfile::Builder::new().prefix(&beside_file(file)).tempdir_in(folder).map_err(fault)
}

fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn beside_file(file: &Path) -> String {
    beside(&file.file_name().unwrap_or_default().to_string_lossy())
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
///
/// # Errors
/// It cannot be made.
pub fn temporary_file(folder: &Path) -> std::io::Result<NamedTempFile> {
    temporary(folder, TEMPORARY)
}

/// As [`temporary_file`], beside `file`.
///
/// # Errors
/// It cannot be made.
pub(crate) fn temporary_beside(file: &Path) -> std::io::Result<NamedTempFile> {
    temporary(folder_of(file), &beside_file(file))
}

fn temporary(folder: &Path, prefix: &str) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    builder.tempfile_in(folder)
}

/// The folders that had to be made for results. Those that are still empty when this goes out of scope are removed.
#[derive(Debug)]
pub struct PreparedFolder {
    /// The innermost first.
    made: Vec<PathBuf>,
}

impl PreparedFolder {
    /// Makes `folder`, as [`prepare`] does.
    ///
    /// # Errors
    /// As [`prepare`].
    pub fn new(folder: &Path) -> Result<Self> {
        let missing = folder.ancestors().take_while(|part| !part.as_os_str().is_empty() && !part.exists());
        let prepared = Self { made: missing.map(Path::to_path_buf).collect() };
        prepare(folder)?;
        Ok(prepared)
    }
}

impl Drop for PreparedFolder {
    fn drop(&mut self) {
        // One that holds something cannot be removed, and neither can those around it.
        let _ = self.made.iter().try_for_each(std::fs::remove_dir);
    }
}
