//! The folder that an input's file names are relative to: on disk, or in memory.

use std::{
    collections::BTreeMap,
    io::ErrorKind,
    path::{Component, Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use crate::input::error::{Error, Result};

/// A folder of input files, on disk or in memory; file names are relative to it.
#[derive(Debug, Clone)]
pub struct Folder {
    path: PathBuf,
    /// The files, if they are in memory.
    memory: Option<Arc<BTreeMap<PathBuf, Vec<u8>>>>,
    /// The files read so far, if they are recorded.
    recorded: Option<Recording>,
}

/// The files read from a folder, with their bytes.
#[derive(Debug, Clone)]
struct Recording {
    folder: PathBuf,
    files: Arc<Mutex<BTreeMap<String, Vec<u8>>>>,
}

impl Folder {
    /// Creates a folder of files in memory, by names relative to it, with `/` between the parts of a name.
    pub fn in_memory(files: impl IntoIterator<Item = (String, Vec<u8>)>) -> Self {
        let files = files.into_iter().map(|(name, bytes)| (normalized(Path::new(&name)), bytes)).collect();
        Self { path: PathBuf::new(), memory: Some(Arc::new(files)), recorded: None }
    }

    /// Returns the same folder, which records every file that is read from now on through it and folders made from it.
    #[must_use]
    pub fn recording(self) -> Self {
        let recorded = Recording { folder: self.path.clone(), files: Arc::default() };
        Self { recorded: Some(recorded), ..self }
    }

    /// Returns the same folder, of which nothing is recorded.
    pub(crate) fn unrecorded(&self) -> Self {
        Self { recorded: None, ..self.clone() }
    }

    /// Returns the files read since [`Folder::recording`], by names relative to that folder; none if nothing is recorded.
    pub fn recorded(&self) -> BTreeMap<String, Vec<u8>> {
        let files = self.recorded.as_ref().map(|own| own.files.lock().unwrap_or_else(PoisonError::into_inner).clone());
        files.unwrap_or_default()
    }

    /// Whether files that are read are recorded.
    pub(crate) fn is_recording(&self) -> bool {
        self.recorded.is_some()
    }

    /// Records `bytes` as those of the file called `name`, instead of what was read from it.
    pub(crate) fn record(&self, name: &str, bytes: &[u8]) {
        let Some(recorded) = &self.recorded else { return };
        let path = self.path(name);
        let name = path.strip_prefix(&recorded.folder).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        recorded.files.lock().unwrap_or_else(PoisonError::into_inner).insert(name, bytes.to_vec());
    }

    /// Returns the path of the file called `name`.
    pub fn path(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Returns the path of the folder itself.
    pub fn root(&self) -> &Path {
        &self.path
    }

    /// Returns the folder that contains the file called `name`, in memory or on disk as this one, with the same recording.
    pub fn of(&self, name: &str) -> Self {
        let path = self.path(name).parent().map(Path::to_path_buf).unwrap_or_default();
        Self { path, ..self.clone() }
    }

    /// Whether `name` is a file in memory or, on disk, anything but a folder: devices and pipes are refused when read, with a message.
    pub fn has_file(&self, name: &str) -> bool {
        let path = self.path(name);
        match &self.memory {
            Some(files) => files.contains_key(&normalized(&path)),
            None => is_file(&path),
        }
    }

    /// Reads the bytes of a program, polyline or wrench table. Fails if there is no such file, or it cannot be read or is longer than 1 GiB.
    pub fn bytes(&self, name: &str) -> Result<Vec<u8>> {
        self.read(name, read_program)
    }

    /// Reads the text of a TOML file. Fails if there is no such file, or it cannot be read, is longer than 1 MiB or is no text.
    pub fn text(&self, name: &str) -> Result<String> {
        super::toml_file::text(self.read(name, read_text)?, &self.path(name))
    }

    /// Reads a file from memory, or from disk by `from_disk`, and records it.
    fn read(&self, name: &str, from_disk: impl Fn(&Path) -> Result<Vec<u8>>) -> Result<Vec<u8>> {
        let path = self.path(name);
        let bytes = match &self.memory {
            Some(files) => files
                .get(&normalized(&path))
                .cloned()
                .ok_or_else(|| Error::Read { file: path, source: ErrorKind::NotFound.into() }),
            None => from_disk(&path),
        }?;
        self.record(name, &bytes);
        Ok(bytes)
    }
}

/// Returns `path` with `.` and `..` resolved.
fn normalized(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut plain, part| {
        match part {
            Component::CurDir => {}
            Component::ParentDir if plain.file_name().is_some() => {
                plain.pop();
            }
            part => plain.push(part),
        }
        plain
    })
}

mod disk {
    use super::{Folder, Path, PathBuf, Result};
    use crate::input::{file, toml_file};

    impl From<&Path> for Folder {
        fn from(path: &Path) -> Self {
            Self { path: path.to_path_buf(), memory: None, recorded: None }
        }
    }

    impl From<PathBuf> for Folder {
        fn from(path: PathBuf) -> Self {
            Self { path, memory: None, recorded: None }
        }
    }

    impl From<&PathBuf> for Folder {
        fn from(path: &PathBuf) -> Self {
            path.as_path().into()
        }
    }

    /// Whether there is something else than a folder at `path` on disk.
    pub(super) fn is_file(path: &Path) -> bool {
        path.exists() && !path.is_dir()
    }

    /// Reads a program, polyline or wrench table from disk.
    pub(super) fn read_program(path: &Path) -> Result<Vec<u8>> {
        file::read(path)
    }

    /// Reads a TOML file from disk, at most 1 MiB.
    pub(super) fn read_text(path: &Path) -> Result<Vec<u8>> {
        file::read_at_most(path, toml_file::MAX_LENGTH)
    }
}

use disk::{is_file, read_program, read_text};
