//! What a command has made and not finished: files in marked folders, which go with it however it ends and tell other commands that it runs.

use std::{
    ffi::OsStr,
    fs::{File, TryLockError},
    io::{Error as IoError, ErrorKind, Result as IoResult, Write},
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

use tempfile::TempDir;

use super::write::PreparedFolder;
use crate::input::error::{Error, Result};

/// The file by which a folder of unfinished files is known, not by its name, and what is in it. Who makes the folder has it locked.
const MARK: (&str, &str) =
    ("kinetostat_unfinished", "Files that kinetostat has not finished: they go with its next run.\n");
/// How often a folder is made that another command takes away as if it were left.
const TRIES: usize = 16;
/// Number of letters and digits drawn for the name of a folder of unfinished files.
pub(super) const DRAWN: usize = 12;
/// The name of a file while it is being made.
const MADE: &str = "made";

/// Paths of what is unfinished in this process, in the order in which it was made.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
/// Held while files take their places, which no signal interrupts.
static COMMITTING: Mutex<()> = Mutex::new(());

/// Locks `mutex`; one whose holder has panicked is as good.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns a guard while which the process does not end by [`remove_unfinished`].
pub(super) fn committing() -> MutexGuard<'static, ()> {
    lock(&COMMITTING)
}

/// Removes what is unfinished in this process, which must end then: nothing more can be begun. What cannot be removed stays for the next command.
pub fn remove_unfinished() {
    let (committing, all) = (committing(), lock(&UNFINISHED));
    for path in all.iter().rev() {
        _ = if is_unfinished(path) { std::fs::remove_dir_all(path) } else { std::fs::remove_dir(path) };
    }
    std::mem::forget((committing, all));
}

/// A folder that is unfinished until this is dropped.
#[derive(Debug)]
pub(super) struct Unfinished(PathBuf);

impl Unfinished {
    /// Notes `folder`.
    pub fn new(folder: &Path) -> Self {
        lock(&UNFINISHED).push(folder.to_path_buf());
        Self(folder.to_path_buf())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        lock(&UNFINISHED).retain(|folder| *folder != self.0);
    }
}

/// A folder in which files are made before they take their places. It goes with all that is left in it.
#[derive(Debug)]
pub struct Staging {
    _mark: File,
    folder: TempDir,
    _unfinished: Unfinished,
}

impl Staging {
    /// Creates one in `folder` whose name begins with `prefix`.
    pub(super) fn new(folder: &Path, prefix: &str) -> IoResult<Self> {
        let mut tries = 0;
        loop {
            let made = tempfile::Builder::new().prefix(prefix).rand_bytes(DRAWN).tempdir_in(folder)?;
            let unfinished = Unfinished::new(made.path());
            let mark = Self::mark(&made.path().join(MARK.0));
            tries += 1;
            // Another command may take a folder for left until it is locked.
            if tries == TRIES || made.path().join(MARK.0).exists() || mark.is_err() && made.path().exists() {
                return Ok(Self { _mark: mark?, folder: made, _unfinished: unfinished });
            }
        }
    }

    /// Creates the mark `path` and locks it.
    fn mark(path: &Path) -> IoResult<File> {
        let mut mark = File::create(path)?;
        mark.lock()?;
        mark.write_all(MARK.1.as_bytes())?;
        Ok(mark)
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Whether this program made `folder`; a command that was killed may have left the mark half-written.
fn is_unfinished(folder: &Path) -> bool {
    std::fs::read(folder.join(MARK.0)).is_ok_and(|mark| MARK.1.as_bytes().starts_with(&mark))
}

/// Whether `folder` is what a command leaves that is killed before the mark: nothing in it, and `drawn` a name that was drawn.
fn is_hardly_begun(folder: &Path, drawn: &str) -> bool {
    drawn.len() == DRAWN
        && drawn.chars().all(|letter| letter.is_ascii_alphanumeric())
        && std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none())
}

/// A file that is being made, in a folder of its own; it goes with that unless it gets its name.
#[derive(Debug)]
pub struct PartialFile {
    /// The file.
    pub file: File,
    /// Its folder.
    pub folder: Staging,
}

impl PartialFile {
    /// Creates an empty one in `folder`, that of its own with `prefix`.
    pub(super) fn new(folder: &Path, prefix: &str) -> IoResult<Self> {
        let folder = Staging::new(folder, prefix)?;
        Ok(Self { file: File::create(folder.path().join(MADE))?, folder })
    }

    /// Moves the file in the folder of one, which is closed, to `path`.
    pub(super) fn name(folder: &Staging, path: &Path) -> IoResult<()> {
        std::fs::rename(folder.path().join(MADE), path)
    }
}

impl Write for PartialFile {
    fn write(&mut self, bytes: &[u8]) -> IoResult<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> IoResult<()> {
        self.file.flush()
    }
}

/// Holds an output against other commands, which are refused until it is dropped.
#[derive(Debug)]
pub struct OutputLock {
    _own: Staging,
    _folder: PreparedFolder,
}

impl OutputLock {
    /// Locks what is made in `folder`, created if need be, with names that begin with `prefix`, for the output `shown`; removes what a killed command left.
    pub(super) fn new(folder: &Path, prefix: &str, shown: &Path) -> Result<Self> {
        let prepared = PreparedFolder::missing(folder)?;
        check_left(folder, prefix, shown, None)?;
        let own = Staging::new(folder, prefix).map_err(|source| Error::Write { file: shown.to_path_buf(), source })?;
        // Of two that begin at once, both may be refused.
        check_left(folder, prefix, shown, own.path().file_name())?;
        Ok(Self { _own: own, _folder: prepared })
    }
}

/// Removes folders that killed commands left in `folder` with names that begin with `prefix`; `Err` where one of a running command is, but for `own`.
fn check_left(folder: &Path, prefix: &str, shown: &Path, own: Option<&OsStr>) -> Result<()> {
    let fault = |source| Error::Read { file: folder.to_path_buf(), source };
    for entry in std::fs::read_dir(folder).map_err(fault)? {
        let entry = entry.map_err(fault)?;
        let (name, path) = (entry.file_name(), entry.path());
        let is_folder = || entry.file_type().is_ok_and(|kind| kind.is_dir());
        let name_text = name.to_string_lossy();
        let Some(drawn) = name_text.strip_prefix(prefix).filter(|_| own != Some(name.as_os_str()) && is_folder())
        else {
            continue;
        };
        if is_hardly_begun(&path, drawn) {
            // One that is no longer empty is that of a command which begins.
            _ = std::fs::remove_dir(&path);
            continue;
        }
        if !is_unfinished(&path) {
            continue;
        }
        // It stays locked until it has gone.
        let unlocked = File::open(path.join(MARK.0)).map_err(TryLockError::Error);
        match unlocked.and_then(|mark| mark.try_lock().map(|()| mark)) {
            Ok(_mark) => match std::fs::remove_dir_all(&path) {
                Err(source) if source.kind() != ErrorKind::NotFound => return Err(Error::Write { file: path, source }),
                _ => {}
            },
            Err(TryLockError::WouldBlock) => {
                let problem = "is being written by another command: expected another place, or this after its end";
                return Err(Error::Write { file: shown.to_path_buf(), source: IoError::other(problem) });
            }
            // It has just gone.
            Err(TryLockError::Error(source)) if source.kind() == ErrorKind::NotFound => {}
            Err(TryLockError::Error(source)) => return Err(Error::Write { file: path, source }),
        }
    }
    Ok(())
}
