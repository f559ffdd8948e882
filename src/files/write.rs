//! Writing of files so that each appears whole or not at all.

use std::{
    ffi::OsStr,
    io::{Error as IoError, ErrorKind, Write},
    path::{Path, PathBuf},
};

use super::unfinished::{DRAWN, OutputLock, PartialFile, Staging, Unfinished, committing};
use crate::input::error::{Error, Result};

/// A file to be written into a result folder.
#[derive(Debug)]
pub struct OutputFile {
    /// Name relative to the folder.
    pub name: String,
    content: Content,
}

/// Content of a file, in memory or already on disk.
#[derive(Debug)]
enum Content {
    Bytes(Vec<u8>),
    /// A temporary file in the result folder, which is removed unless it gets its name.
    File(PartialFile),
}

impl OutputFile {
    /// Returns a file called `name` with these bytes.
    pub fn new(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { name: name.into(), content: Content::Bytes(bytes.into()) }
    }

    /// Returns a file to be called `name` whose content is already in a temporary file of the folder; see [`temporary_file`].
    pub fn from_temporary(name: impl Into<String>, file: PartialFile) -> Self {
        Self { name: name.into(), content: Content::File(file) }
    }
}

/// Beginning of the names of temporary files.
const TEMPORARY: &str = ".partial-";

/// Creates `folder` and checks, before anything is computed, that files can be written there; `Err` when they cannot.
pub fn prepare(folder: &Path) -> Result<()> {
    let fault = |source| Error::Write { file: folder.to_path_buf(), source };
    create(folder)?;
    tempfile::NamedTempFile::new_in(folder).map(drop).map_err(fault)?;
    // Files in a folder in it: some systems have an end to the length of a path.
    check_name_fits(folder, &"x".repeat(LONGEST_NAME))
}

/// Creates `folder`, unless it is there.
fn create(folder: &Path) -> Result<()> {
    let fault = |source| Error::Write { file: folder.to_path_buf(), source };
    if folder.is_file() {
        return Err(fault(IoError::other("is a file, expected a folder or the name of a new one")));
    }
    std::fs::create_dir_all(folder).map_err(fault)
}

/// Most bytes of a name in a result folder, including that of a temporary folder.
const LONGEST_NAME: usize = 200;

/// Returns an error if a file in `folder` cannot have this name, for instance as the path would be too long.
fn check_name_fits(folder: &Path, name: &str) -> Result<()> {
    match std::fs::symlink_metadata(folder.join(name)) {
        Err(source) if source.kind() != ErrorKind::NotFound => Err(Error::Write { file: folder.join(name), source }),
        _ => Ok(()),
    }
}

/// Checks, before anything is computed, that [`write_beside`] can write `file`, whose folder need not exist, and returns its name and its lock; `Err`
/// when it cannot, or another command is writing it. Removes temporary files that a killed command left of it.
pub fn prepare_beside(file: &Path) -> Result<(&str, OutputLock)> {
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
    let prefix = temporary_prefix(name);
    check_name_fits(folder, &format!("{prefix}{}", "0".repeat(DRAWN)))?;
    let lock = OutputLock::new(folder_of(file), &prefix, file)?;
    Ok((name, lock))
}

/// Returns the beginning of the names of temporary files for a file called `name`, which other commands in its folder leave alone.
fn temporary_prefix(name: &str) -> String {
    format!(".{name}{TEMPORARY}")
}

/// Creates a temporary folder in `folder`, in which files are made before they are moved into place; `Err` when it cannot.
pub fn staging(folder: &Path) -> Result<Staging> {
    Staging::new(folder, TEMPORARY).map_err(|source| Error::Write { file: folder.to_path_buf(), source })
}

/// Locks the results in `folder` against other commands, and removes temporary files that a killed one left there; `Err` when one cannot be
/// removed, or another command is writing there.
pub fn lock_folder(folder: &Path) -> Result<OutputLock> {
    OutputLock::new(folder, TEMPORARY, folder)
}

/// Writes `files` into `folder`: all of them are complete before the first is moved into place. `Err` when one cannot be written; no
/// half-written file remains.
pub fn write_all(folder: &Path, files: Vec<OutputFile>) -> Result<()> {
    Transaction::within(folder)?.place_all(files)?.commit()
}

/// Writes `files` into the folder of `file`, with errors as [`write_all`]; see [`prepare_beside`].
pub fn write_beside(file: &Path, files: Vec<OutputFile>) -> Result<()> {
    Transaction::beside(file)?.place_all(files)?.commit()
}

/// Changes of files in a folder, made one after another once all are ready. All results are written through one; where files belong
/// together, its first change marks them as incomplete, and its last as complete.
#[derive(Debug)]
pub struct Transaction {
    folder: PathBuf,
    /// Beginning of the names of files that are not in place yet.
    prefix: String,
    /// Changes in the order in which they are made.
    pub steps: Vec<Step>,
}

/// A change of one file, which happens completely or not at all.
#[derive(Debug)]
pub enum Step {
    /// Gives a temporary file its final path.
    Name(Staging, PathBuf),
    /// Moves a finished file to its final path.
    Move(PathBuf, PathBuf),
    /// Removes a file, if it exists.
    Remove(PathBuf),
}

impl Transaction {
    /// Starts a transaction in `folder`, which is created if need be; `Err` when it cannot be created.
    pub fn within(folder: &Path) -> Result<Self> {
        Self::new(folder, TEMPORARY.into())
    }

    /// Starts a transaction in the folder of `file`, which is created if need be; `Err` when it cannot be created.
    pub fn beside(file: &Path) -> Result<Self> {
        Self::new(folder_of(file), prefix_beside(file))
    }

    /// Creates the folder if need be, and returns a transaction without changes.
    fn new(folder: &Path, prefix: String) -> Result<Self> {
        std::fs::create_dir_all(folder).map_err(|source| Error::Write { file: folder.to_path_buf(), source })?;
        Ok(Self { folder: folder.to_path_buf(), prefix, steps: Vec::new() })
    }

    /// Writes `file` to a temporary file now, and adds the change that moves it into place; `Err` when it cannot be written.
    pub fn place(&mut self, file: OutputFile) -> Result<()> {
        let path = self.folder.join(&file.name);
        let made = match file.content {
            Content::File(made) => Ok(made),
            Content::Bytes(bytes) => {
                PartialFile::new(&self.folder, &self.prefix).and_then(|mut made| made.write_all(&bytes).map(|()| made))
            }
        };
        let made = made.map_err(|source| Error::Write { file: path.clone(), source })?;
        self.steps.push(Step::Name(made.folder, path));
        Ok(())
    }

    /// Adds all `files` as [`Transaction::place`] does, with the same errors.
    pub fn place_all(mut self, files: Vec<OutputFile>) -> Result<Self> {
        files.into_iter().try_for_each(|file| self.place(file)).map(|()| self)
    }

    /// Adds the change that moves the file `name` from the folder `made` into place.
    pub fn place_made(&mut self, made: &Path, name: &str) {
        self.steps.push(Step::Move(made.join(name), self.folder.join(name)));
    }

    /// Adds the change that removes the file called `name`.
    pub fn remove(&mut self, name: &str) {
        self.steps.push(Step::Remove(self.folder.join(name)));
    }

    /// Makes all changes in order; `Err` when one cannot be made, with those before it made.
    pub fn commit(self) -> Result<()> {
        let _committing = committing();
        self.steps.into_iter().try_for_each(Step::apply)
    }
}

impl Step {
    /// Makes the change; `Err` when it cannot be made.
    pub fn apply(self) -> Result<()> {
        match self {
            Self::Name(made, path) => {
                PartialFile::name(&made, &path).map_err(|source| Error::Write { file: path, source })
            }
            Self::Move(made, path) => {
                std::fs::rename(made, &path).map_err(|source| Error::Write { file: path, source })
            }
            Self::Remove(path) => remove(&path),
        }
    }
}

/// Creates a temporary folder as [`staging`] does, in the folder of `file`, which is created if need be.
pub fn staging_beside(file: &Path) -> Result<Staging> {
    let fault = |source| Error::Write { file: file.to_path_buf(), source };
    let folder = folder_of(file);
    std::fs::create_dir_all(folder).map_err(fault)?;
    Staging::new(folder, &prefix_beside(file)).map_err(fault)
}

/// Returns the folder of a file; `.` for a bare name.
fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Returns the beginning of the names of temporary files for `file`.
fn prefix_beside(file: &Path) -> String {
    temporary_prefix(&file.file_name().unwrap_or_default().to_string_lossy())
}

/// Removes a file; `Err` when it cannot be removed, but not when there is none.
pub fn remove(file: &Path) -> Result<()> {
    match std::fs::remove_file(file) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::Write { file: file.to_path_buf(), source })
        }
        _ => Ok(()),
    }
}

/// Creates a file in `folder` that is removed unless it gets its name.
pub fn temporary_file(folder: &Path) -> std::io::Result<PartialFile> {
    PartialFile::new(folder, TEMPORARY)
}

/// Creates a temporary file as [`temporary_file`] does, in the folder of `file`.
pub(crate) fn temporary_beside(file: &Path) -> std::io::Result<PartialFile> {
    PartialFile::new(folder_of(file), &prefix_beside(file))
}

/// Folders created for results. When it is dropped, those that are still empty are removed.
#[derive(Debug)]
pub struct PreparedFolder {
    /// Folders created, the innermost first.
    made: Vec<PathBuf>,
    _unfinished: Vec<Unfinished>,
}

impl PreparedFolder {
    /// Creates and checks `folder` as [`prepare`] does, with the same errors.
    pub fn new(folder: &Path) -> Result<Self> {
        let prepared = Self::missing(folder)?;
        prepare(folder)?;
        Ok(prepared)
    }

    /// Creates `folder`, and checks nothing.
    pub(super) fn missing(folder: &Path) -> Result<Self> {
        let missing = folder.ancestors().take_while(|part| !part.as_os_str().is_empty() && !part.exists());
        let made: Vec<PathBuf> = missing.map(Path::to_path_buf).collect();
        let unfinished = made.iter().rev().map(|folder| Unfinished::new(folder)).collect();
        let prepared = Self { made, _unfinished: unfinished };
        create(folder)?;
        Ok(prepared)
    }
}

impl Drop for PreparedFolder {
    fn drop(&mut self) {
        // One that holds something cannot be removed, and neither can those around it.
        let _ = self.made.iter().try_for_each(std::fs::remove_dir);
    }
}
