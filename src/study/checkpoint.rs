//! Finished pieces of a long run in a file, so that the run can go on after it was stopped or killed.
//!
//! The file is only ever appended to: after eight bytes that name the format come records of a length (4 bytes,
//! little-endian), the CRC-32 of the content (4 bytes) and the content, written with postcard. The first record says what
//! is computed, each other one holds the key of a piece and the piece. A record that was cut short does not match its
//! checksum; it is dropped and computed again.

use std::{
    collections::HashMap,
    fs::{File, OpenOptions, TryLockError},
    io::{BufReader, Error as IoError, Read, Result as IoResult, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize, de::DeserializeOwned};

use super::Inputs;
use crate::error::{Error, Result};

/// What decides the pieces.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// Version of the program.
    pub version: String,
    /// What is computed from.
    pub inputs: Inputs,
}

/// A file of pieces, each under a key.
#[derive(Debug)]
pub struct Checkpoint {
    file: File,
    path: PathBuf,
    /// Where the piece of each key is: offset and length.
    places: HashMap<Vec<u8>, (u64, u32)>,
    end: u64,
}

const FORMAT: [u8; 8] = *b"kstatrun";
/// No content is longer; a longer length is a damaged one.
const LONGEST: u32 = 1 << 28;

impl Checkpoint {
    /// A new file at `path`, in place of any other.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn create(path: &Path, origin: &Origin) -> Result<Self> {
        let fault = |source| Error::Write { file: path.to_path_buf(), source };
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(fault)?;
        alone(&file, path)?;
        file.set_len(0).map_err(fault)?;
        let mut checkpoint = Self { file, path: path.to_path_buf(), places: HashMap::new(), end: 0 };
        let head = encoded(origin).map_err(fault)?;
        checkpoint.append(&[FORMAT.as_slice(), &record(&head)].concat())?;
        Ok(checkpoint)
    }

    /// Opens the file at `path` and removes what was cut short at its end.
    ///
    /// # Errors
    /// It cannot be read or written, is no such file, or was made from something else; the message says what differs.
    pub fn resume(path: &Path, origin: &Origin) -> Result<Self> {
        let fault = |source| Error::Read { file: path.to_path_buf(), source };
        let refuse = |problem: String| Err(Error::Resume { file: path.to_path_buf(), problem });
        let file = OpenOptions::new().read(true).write(true).open(path).map_err(fault)?;
        alone(&file, path)?;
        let mut reader = BufReader::new(&file);
        let mut format = FORMAT.map(|_| 0);
        if !fill(&mut reader, &mut format).map_err(fault)? || format != FORMAT {
            return refuse("is not a file of an unfinished run".into());
        }
        let Some(head) = next_record(&mut reader).map_err(fault)? else {
            return refuse("was cut short before anything was computed: start anew".into());
        };
        match postcard::from_bytes::<Origin>(&head) {
            Ok(before) => {
                if let Some(change) = change(&before, origin) {
                    return refuse(format!("belongs to another run: {change}"));
                }
            }
            Err(_) => return refuse("was written by another version of the program".into()),
        }
        let mut end = (FORMAT.len() + HEAD + head.len()) as u64;
        let mut places = HashMap::new();
        while let Some(content) = next_record(&mut reader).map_err(fault)? {
            let Ok((key, piece)) = postcard::take_from_bytes::<Vec<u8>>(&content) else {
                return refuse("holds a record that cannot be read".into());
            };
            let start = content.len() - piece.len();
            places.insert(key, (end + (HEAD + start) as u64, piece.len() as u32));
            end += (HEAD + content.len()) as u64;
        }
        drop(reader);
        file.set_len(end).map_err(|source| Error::Write { file: path.to_path_buf(), source })?;
        Ok(Self { file, path: path.to_path_buf(), places, end })
    }

    /// Whether a run from `origin` could go on with the file at `path`.
    pub fn is_resumable(path: &Path, origin: &Origin) -> bool {
        path.is_file() && Self::resume(path, origin).is_ok_and(|checkpoint| !checkpoint.is_empty())
    }

    /// Removes the file: the run is done.
    ///
    /// # Errors
    /// It cannot be removed.
    pub fn remove(path: &Path) -> Result<()> {
        std::fs::remove_file(path).map_err(|source| Error::Write { file: path.to_path_buf(), source })
    }

    /// Number of pieces.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether it has no pieces.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The piece under `key`, if there is one.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn piece<K: Serialize, T: DeserializeOwned>(&mut self, key: &K) -> Result<Option<T>> {
        let fault = |path: &Path, source| Error::Read { file: path.to_path_buf(), source };
        let key = encoded(key).map_err(|source| fault(&self.path, source))?;
        let Some(&(offset, length)) = self.places.get(&key) else { return Ok(None) };
        let mut bytes = vec![0; length as usize];
        let read = self.file.seek(SeekFrom::Start(offset)).and_then(|_| self.file.read_exact(&mut bytes));
        read.map_err(|source| fault(&self.path, source))?;
        let piece = postcard::from_bytes(&bytes).map_err(|error| fault(&self.path, IoError::other(error)))?;
        Ok(Some(piece))
    }

    /// Appends a piece.
    ///
    /// # Errors
    /// It cannot be written; the file is as it was.
    pub fn keep<K: Serialize, T: Serialize>(&mut self, key: &K, piece: &T) -> Result<()> {
        let fault = |source| Error::Write { file: self.path.clone(), source };
        let key = encoded(key).map_err(fault)?;
        let (head, piece) = (encoded(&key).map_err(fault)?, encoded(piece).map_err(fault)?);
        let place = (self.end + (HEAD + head.len()) as u64, piece.len() as u32);
        self.append(&record(&[head, piece].concat()))?;
        self.places.insert(key, place);
        Ok(())
    }

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

/// Locks the file against other runs.
fn alone(file: &File, path: &Path) -> Result<()> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => {
            Err(Error::Resume { file: path.to_path_buf(), problem: "is in use by another run".into() })
        }
        Err(TryLockError::Error(source)) => Err(Error::Write { file: path.to_path_buf(), source }),
    }
}

/// Bytes before the content of a record.
const HEAD: usize = 8;

fn encoded<T: Serialize + ?Sized>(value: &T) -> IoResult<Vec<u8>> {
    postcard::to_stdvec(value).map_err(IoError::other)
}

fn record(content: &[u8]) -> Vec<u8> {
    let length = (content.len() as u32).to_le_bytes();
    [length.as_slice(), &crc32fast::hash(content).to_le_bytes(), content].concat()
}

/// The content of the next whole record; `None` at the end or at one that was cut short.
fn next_record(reader: &mut impl Read) -> IoResult<Option<Vec<u8>>> {
    let mut head = [0; HEAD];
    if !fill(reader, &mut head)? {
        return Ok(None);
    }
    let [a, b, c, d, e, f, g, h] = head;
    let (length, sum) = (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
    if length > LONGEST {
        return Ok(None);
    }
    let mut content = vec![0; length as usize];
    let is_whole = fill(reader, &mut content)? && crc32fast::hash(&content) == sum;
    Ok(is_whole.then_some(content))
}

/// Whether there were enough bytes to fill `buffer`.
fn fill(reader: &mut impl Read, buffer: &mut [u8]) -> IoResult<bool> {
    match reader.read_exact(buffer) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => Ok(false),
        Err(error) => Err(error),
    }
}

fn change(before: &Origin, now: &Origin) -> Option<String> {
    if before.version != now.version {
        return Some(format!("it was made by version {}, this is {}", before.version, now.version));
    }
    now.inputs.change_since(&before.inputs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin(text: &str) -> Origin {
        Origin { version: "1".into(), inputs: Inputs::of("study.toml", text) }
    }

    #[test]
    fn whole_pieces_survive_a_cut_at_any_byte() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        let mut checkpoint = Checkpoint::create(&path, &origin("a")).unwrap();
        let length = |path: &Path| std::fs::metadata(path).unwrap().len();
        let mut ends = vec![length(&path)];
        let pieces = [vec![1.0, 2.5], vec![], vec![-0.1; 5]];
        for (key, piece) in pieces.iter().enumerate() {
            checkpoint.keep(&("stage", key), piece).unwrap();
            ends.push(length(&path));
        }
        drop(checkpoint);
        let whole = std::fs::read(&path).unwrap();
        for cut in ends[0] as usize..=whole.len() {
            std::fs::write(&path, &whole[..cut]).unwrap();
            let mut checkpoint = Checkpoint::resume(&path, &origin("a")).unwrap();
            let kept = ends.iter().filter(|end| **end <= cut as u64).count() - 1;
            assert_eq!(checkpoint.len(), kept, "cut at {cut}");
            for (key, piece) in pieces.iter().enumerate() {
                let found: Option<Vec<f64>> = checkpoint.piece(&("stage", key)).unwrap();
                assert_eq!(found.as_ref(), (key < kept).then_some(piece), "cut at {cut}");
                if found.is_none() {
                    checkpoint.keep(&("stage", key), piece).unwrap();
                }
            }
            assert_eq!(std::fs::read(&path).unwrap(), whole, "cut at {cut}");
        }
    }

    #[test]
    fn a_damaged_byte_loses_the_records_from_there_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        let mut checkpoint = Checkpoint::create(&path, &origin("a")).unwrap();
        for key in 0..3_u8 {
            checkpoint.keep(&key, &vec![key; 100]).unwrap();
        }
        drop(checkpoint);
        let mut bytes = std::fs::read(&path).unwrap();
        let middle = bytes.len() - 150;
        bytes[middle] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        let mut checkpoint = Checkpoint::resume(&path, &origin("a")).unwrap();
        assert_eq!(checkpoint.piece::<_, Vec<u8>>(&0_u8).unwrap(), Some(vec![0; 100]));
        assert_eq!(checkpoint.len(), 1);
    }

    #[test]
    fn another_origin_is_refused_with_what_differs() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        let refused = |expected: &str| {
            let error = Checkpoint::resume(&path, &origin("a")).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        };
        Checkpoint::create(&path, &origin("b")).unwrap();
        refused("belongs to another run: study.toml, line 1: was `b`, is `a`");
        Checkpoint::create(&path, &Origin { version: "0".into(), ..origin("a") }).unwrap();
        refused("it was made by version 0, this is 1");
        std::fs::write(&path, b"nothing of the kind").unwrap();
        refused("is not a file of an unfinished run");
        std::fs::write(&path, FORMAT).unwrap();
        refused("was cut short before anything was computed");
    }
}
