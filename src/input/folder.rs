//! Where the files are that an input names: a folder on disk, or files in memory.

use std::{
    collections::BTreeMap,
    io::{Error as IoError, ErrorKind},
    path::{Component, Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use crate::input::error::{Error, Result};

/// A folder of input files. Names are relative to it.
#[derive(Debug, Clone)]
pub struct Folder {
    path: PathBuf,
    /// The files, if they are in memory.
    memory: Option<Arc<BTreeMap<PathBuf, Vec<u8>>>>,
    /// Where what is read is noted, if it is.
    noted: Option<Noted>,
}

/// The files that were read of a folder.
#[derive(Debug, Clone)]
struct Noted {
    folder: PathBuf,
    files: Arc<Mutex<BTreeMap<String, Vec<u8>>>>,
}

impl Folder {
    /// Files in memory, by names relative to the folder, with `/` between the parts of a name.
    pub fn in_memory(files: impl IntoIterator<Item = (String, Vec<u8>)>) -> Self {
        let files = files.into_iter().map(|(name, bytes)| (plain(Path::new(&name)), bytes)).collect();
        Self { path: PathBuf::new(), memory: Some(Arc::new(files)), noted: None }
    }

    /// The same folder, which notes every file that is read from now on of it and of folders made of it.
    #[must_use]
    pub fn noting(self) -> Self {
        let noted = Noted { folder: self.path.clone(), files: Arc::default() };
        Self { noted: Some(noted), ..self }
    }

    /// The files read since [`Folder::noting`], by names relative to that folder; none where nothing is noted.
    pub fn noted(&self) -> BTreeMap<String, Vec<u8>> {
        let files = self.noted.as_ref().map(|noted| noted.files.lock().unwrap_or_else(PoisonError::into_inner).clone());
        files.unwrap_or_default()
    }

    /// Whether files are noted.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn is_noting(&self) -> bool {
        self.noted.is_some()
    }

    /// Notes `bytes` for the file called `name`, whatever was read of it.
    pub(crate) fn note(&self, name: &str, bytes: &[u8]) {
        let Some(noted) = &self.noted else { return };
        let path = self.path(name);
        let name = path.strip_prefix(&noted.folder).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        noted.files.lock().unwrap_or_else(PoisonError::into_inner).insert(name, bytes.to_vec());
    }

    /// The file called `name`, as messages have it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// The folder itself.
    pub fn here(&self) -> &Path {
        &self.path
    }

    /// The folder in which the file called `name` is.
    pub fn of(&self, name: &str) -> Self {
        let path = self.path(name).parent().map(Path::to_path_buf).unwrap_or_default();
        Self { path, ..self.clone() }
    }

    /// Whether there is a file called `name`.
    pub fn has(&self, name: &str) -> bool {
        let path = self.path(name);
        match &self.memory {
            Some(files) => files.contains_key(&plain(&path)),
            None => is_file(&path),
        }
    }

    /// The bytes of a program, polyline or wrench table.
    ///
    /// # Errors
    /// No such file, or one that cannot be read or is longer than 1 GiB.
    pub fn bytes(&self, name: &str) -> Result<Vec<u8>> {
        self.read(name, read_program)
    }

    /// The text of a TOML file.
    ///
    /// # Errors
    /// No such file, or one that cannot be read, is longer than 1 MiB or is no text.
    pub fn text(&self, name: &str) -> Result<String> {
        super::toml_file::text(self.read(name, read_text)?, &self.path(name))
    }

    fn read(&self, name: &str, from_disk: impl Fn(&Path) -> Result<Vec<u8>>) -> Result<Vec<u8>> {
        let path = self.path(name);
        let bytes = match &self.memory {
            Some(files) => files.get(&plain(&path)).cloned().ok_or_else(|| missing(&path)),
            None => from_disk(&path),
        }?;
        self.note(name, &bytes);
        Ok(bytes)
    }
}

/// `path` without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
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

fn missing(file: &Path) -> Error {
    Error::Read { file: file.to_path_buf(), source: IoError::from(ErrorKind::NotFound) }
}

mod disk {
    use super::{Folder, Path, PathBuf, Result};
    use crate::input::{file, toml_file};

    impl From<&Path> for Folder {
        fn from(path: &Path) -> Self {
            Self { path: path.to_path_buf(), memory: None, noted: None }
        }
    }

    impl From<PathBuf> for Folder {
        fn from(path: PathBuf) -> Self {
            Self { path, memory: None, noted: None }
        }
    }

    impl From<&PathBuf> for Folder {
        fn from(path: &PathBuf) -> Self {
            path.as_path().into()
        }
    }

    pub(super) fn is_file(path: &Path) -> bool {
        path.is_file()
    }

    pub(super) fn read_program(path: &Path) -> Result<Vec<u8>> {
        file::read(path)
    }

    pub(super) fn read_text(path: &Path) -> Result<Vec<u8>> {
        file::read_at_most(path, toml_file::MAX_LENGTH)
    }
}

use disk::{is_file, read_program, read_text};
