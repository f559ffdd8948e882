//! Checkpoints: finished pieces of a long run in a file, so that the run can go on after it was stopped or killed.
//!
//! The file is only ever appended to: after eight bytes that name the format come records (`records.rs`). The first one
//! says what is computed, each other one holds the key of a piece and the piece. A record that was cut short or damaged
//! does not match its checksum; it is left out and computed again.

use std::{
    collections::HashMap,
    fs::{File, OpenOptions, TryLockError},
    io::{BufReader, Read, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
    sync::OnceLock,
};

use serde::{Deserialize, Serialize};

use super::records::{HEAD, Record, encode, fill, next_record, record};
use crate::{
    input::Inputs,
    input::error::{Error, Remedy, Result},
};

/// Program and inputs of which pieces are computed: others may give other pieces.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// Version and build of the program: another build may compute or write otherwise.
    pub program: String,
    /// What is computed from.
    pub inputs: Inputs,
}

impl Origin {
    /// Returns the origin of pieces computed from `inputs` by the build that `program` names, or else by the executable that is running.
    ///
    /// # Errors
    /// The executable cannot be read.
    pub fn of(program: Option<&str>, inputs: Inputs) -> Result<Self> {
        Ok(Self { program: program.map_or_else(executable_version, |program| Ok(program.to_string()))?, inputs })
    }

    /// Returns in words what differs from the origin `before`; `None` if nothing does.
    fn change_since(&self, before: &Origin) -> Option<String> {
        if before.program != self.program {
            return Some(format!("the run was made by {}, this program is {}", before.program, self.program));
        }
        self.inputs.change_since(&before.inputs)
    }
}

/// A file of pieces, each under a key.
#[derive(Debug)]
pub struct Checkpoint {
    file: File,
    path: PathBuf,
    /// Where the piece of each key is: offset and length.
    places: HashMap<Vec<u8>, (u64, u32)>,
    /// Where the next record goes.
    end: u64,
    damaged: usize,
}

/// Returns version and checksum of the executable that is running; computed once.
fn executable_version() -> Result<String> {
    static BUILD: OnceLock<String> = OnceLock::new();
    if let Some(build) = BUILD.get() {
        return Ok(build.clone());
    }
    let fault = |file: &Path, source| Error::Read { file: file.to_path_buf(), source };
    let file = std::env::current_exe().map_err(|source| fault(Path::new("this program"), source))?;
    let bytes = std::fs::read(&file).map_err(|source| fault(&file, source))?;
    let build = format!("version {} (build {:08x})", env!("CARGO_PKG_VERSION"), crc32fast::hash(&bytes));
    Ok(BUILD.get_or_init(|| build).clone())
}

/// Pieces that a file holds, as a run sees them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ExistingPieces {
    /// There is none, or nothing in it.
    Nothing,
    /// Pieces that the run can go on with.
    Same,
    /// Pieces of another run; what differs.
    Other(String),
}

const FORMAT: [u8; 8] = *b"kstat-1\n";

impl Checkpoint {
    /// Creates a file at `path`, in place of any other.
    ///
    /// # Errors
    /// It cannot be written, or another run uses it.
    pub fn create(path: &Path, origin: &Origin) -> Result<Self> {
        let fault = |source| Error::Write { file: path.to_path_buf(), source };
        check_regular_file(path)?;
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(fault)?;
        lock_exclusively(&file, path)?;
        Self { file, path: path.to_path_buf(), places: HashMap::new(), end: 0, damaged: 0 }.start_records(origin)
    }

    /// Empties the file and writes its first record.
    fn start_records(mut self, origin: &Origin) -> Result<Self> {
        let fault = |source| Error::Write { file: self.path.clone(), source };
        self.file.set_len(0).map_err(fault)?;
        let head = record(&encode(origin).map_err(fault)?).map_err(fault)?;
        self.append(&[FORMAT.as_slice(), &head].concat())?;
        Ok(self)
    }

    /// Creates a temporary file without a name, which is gone with the program.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn unnamed(origin: &Origin) -> Result<Self> {
        let path = PathBuf::from("a temporary file");
        let file = tempfile::tempfile().map_err(|source| Error::Write { file: path.clone(), source })?;
        Self { file, path, places: HashMap::new(), end: 0, damaged: 0 }.start_records(origin)
    }

    /// Opens the file at `path` to go on from its pieces; one without a first record is started.
    ///
    /// # Errors
    /// It cannot be read or written, another run uses it, it is no such file, or it was made from something else; the message says what differs.
    pub fn resume(path: &Path, origin: &Origin) -> Result<Self> {
        let fault = |source| Error::Read { file: path.to_path_buf(), source };
        check_regular_file(path)?;
        let file = OpenOptions::new().read(true).write(true).open(path).map_err(fault)?;
        lock_exclusively(&file, path)?;
        let contents = contents(&file, path)?;
        let mut checkpoint = Self { file, path: path.to_path_buf(), places: HashMap::new(), end: 0, damaged: 0 };
        let Some(contents) = contents else { return checkpoint.start_records(origin) };
        if let Some(change) = origin.change_since(&contents.origin) {
            let problem = format!("belongs to another run: {change}");
            return Err(Error::Resume { file: checkpoint.path, problem, remedy: Remedy::Restart });
        }
        let cut = checkpoint.file.set_len(contents.end);
        cut.map_err(|source| Error::Write { file: path.to_path_buf(), source })?;
        (checkpoint.places, checkpoint.end, checkpoint.damaged) = (contents.places, contents.end, contents.damaged);
        Ok(checkpoint)
    }

    /// Returns what the file at `path` holds for a run from `origin`. Changes nothing.
    ///
    /// # Errors
    /// It cannot be read, another run uses it, or it is no such file.
    pub fn find(path: &Path, origin: &Origin) -> Result<ExistingPieces> {
        check_regular_file(path)?;
        if !path.is_file() {
            return Ok(ExistingPieces::Nothing);
        }
        let file = File::open(path).map_err(|source| Error::Read { file: path.to_path_buf(), source })?;
        lock_exclusively(&file, path)?;
        Ok(match contents(&file, path)? {
            Some(contents) if contents.places.is_empty() => ExistingPieces::Nothing,
            Some(contents) => origin.change_since(&contents.origin).map_or(ExistingPieces::Same, ExistingPieces::Other),
            None => ExistingPieces::Nothing,
        })
    }

    /// Returns the number of pieces in the file.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Returns whether the file has no pieces.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The keys, in the order of their bytes.
    pub fn keys(&self) -> Vec<Vec<u8>> {
        let mut keys: Vec<Vec<u8>> = self.places.keys().cloned().collect();
        keys.sort_unstable();
        keys
    }

    /// Number of damaged records among those read.
    pub fn damaged_count(&self) -> usize {
        self.damaged
    }

    /// Returns the piece under `key` as it was encoded; `None` if there is none.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn bytes(&mut self, key: &[u8]) -> Result<Option<Vec<u8>>> {
        let Some(&(offset, length)) = self.places.get(key) else { return Ok(None) };
        let mut bytes = vec![0; length as usize];
        let read = self.file.seek(SeekFrom::Start(offset)).and_then(|_| self.file.read_exact(&mut bytes));
        read.map_err(|source| Error::Read { file: self.path.clone(), source })?;
        Ok(Some(bytes))
    }

    /// Appends an encoded piece under `key`.
    ///
    /// # Errors
    /// It cannot be written; the file is then as it was.
    pub fn append_piece(&mut self, key: &[u8], piece: &[u8]) -> Result<()> {
        let fault = |source| Error::Write { file: self.path.clone(), source };
        let head = encode(key).map_err(fault)?;
        let place = (self.end + (HEAD + head.len()) as u64, piece.len() as u32);
        let record = record(&[&head, piece].concat()).map_err(fault)?;
        self.append(&record)?;
        self.places.insert(key.to_vec(), place);
        Ok(())
    }

    /// Writes `bytes` at the end of the records; where that fails, the file is cut back to them.
    fn append(&mut self, bytes: &[u8]) -> Result<()> {
        let written = self.file.seek(SeekFrom::Start(self.end)).and_then(|_| self.file.write_all(bytes));
        match written {
            Ok(()) => {
                self.end += bytes.len() as u64;
                Ok(())
            }
            Err(source) => {
                // What is there of the record would be dropped by its checksum as well.
                let _ = self.file.set_len(self.end);
                Err(Error::Write { file: self.path.clone(), source })
            }
        }
    }
}

/// Places of the pieces that a file holds.
struct Contents {
    origin: Origin,
    places: HashMap<Vec<u8>, (u64, u32)>,
    /// End of the last whole record.
    end: u64,
    /// Damaged records before that.
    damaged: usize,
}

/// Reads which pieces a file holds; `None` if it ends before its first record. An error if it is no checkpoint, or damaged there.
fn contents(file: &File, path: &Path) -> Result<Option<Contents>> {
    let fault = |source| Error::Read { file: path.to_path_buf(), source };
    let refuse =
        |what: &str| Err(Error::Resume { file: path.to_path_buf(), problem: what.into(), remedy: Remedy::Restart });
    let size = file.metadata().map_err(fault)?.len();
    let mut reader = BufReader::new(file);
    let mut format = [0; FORMAT.len()];
    let is_begun = fill(&mut reader, &mut format).map_err(fault)?;
    let format_length = if is_begun { format.len() } else { size as usize };
    if format[..format_length] != FORMAT[..format_length] {
        return refuse("is not a file of an unfinished run of this version");
    }
    let mut at = FORMAT.len() as u64;
    let head = match next_record(&mut reader, size.saturating_sub(at)).map_err(fault)? {
        Record::Whole(head) => head,
        Record::Damaged(_) => return refuse("is damaged where it says what was computed"),
        Record::End => return Ok(None),
    };
    at += (HEAD + head.len()) as u64;
    let Ok(origin) = postcard::from_bytes::<Origin>(&head) else {
        return refuse("is not a file of an unfinished run of this version");
    };
    let mut contents = Contents { origin, places: HashMap::new(), end: at, damaged: 0 };
    let mut damaged = 0;
    loop {
        match next_record(&mut reader, size.saturating_sub(at)).map_err(fault)? {
            Record::End => return Ok(Some(contents)),
            Record::Damaged(length) => {
                damaged += 1;
                at += HEAD as u64 + length;
            }
            Record::Whole(content) => {
                let place = postcard::take_from_bytes::<Vec<u8>>(&content)
                    .map(|(key, piece)| (key, (at + (HEAD + content.len() - piece.len()) as u64, piece.len() as u32)));
                at += (HEAD + content.len()) as u64;
                contents.places.extend(place.ok());
                (contents.end, contents.damaged) = (at, damaged);
            }
        }
    }
}

/// Returns an error if anything but a regular file is at `path`: what a link or a device leads to is not ours to write.
fn check_regular_file(path: &Path) -> Result<()> {
    if std::fs::symlink_metadata(path).is_ok_and(|found| !found.is_file()) {
        let problem = "is a link, a folder or a device, expected a file: remove it, or choose another folder".into();
        return Err(Error::Resume { file: path.to_path_buf(), problem, remedy: Remedy::Elsewhere });
    }
    Ok(())
}

/// Locks the file against other runs; `Err` if one uses it.
fn lock_exclusively(file: &File, path: &Path) -> Result<()> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => {
            let (file, problem) = (path.to_path_buf(), "is in use by another run".into());
            Err(Error::Resume { file, problem, remedy: Remedy::Elsewhere })
        }
        Err(TryLockError::Error(source)) => Err(Error::Write { file: path.to_path_buf(), source }),
    }
}
