//! Part files (the pieces that one part of a computation has found), and the collection of all parts.
//!
//! After eight bytes that name the format come records (`records.rs`): the first says which part of what it is and how many pieces there are, each
//! other one holds the key of a piece and the piece, in the order of the keys. The same part has the same bytes whatever the number of threads. A
//! file that is not whole is refused: a part is computed again, not mended.

use std::{
    collections::HashMap,
    io::{BufReader, Cursor, Read, Seek, SeekFrom, Write},
    path::PathBuf,
    sync::Arc,
};

use serde::{Deserialize, Serialize};

use super::{
    checkpoint::Origin,
    records::{HEAD, Record, encode, fill, next_record, record},
    share::Share,
};
use crate::input::{
    error::{Error, Result},
    file,
};

/// Head of a part file: by which program it was computed, from what, and which part it is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartHead {
    /// Version and build of the program that computed it.
    pub program: String,
    /// Names of the inputs of the study and the SHA-256 of each, hexadecimal.
    pub inputs: Vec<(String, String)>,
    /// Name of the study.
    pub study: String,
    /// How the study was opened, for whoever opens it again.
    pub opened: String,
    /// Which part.
    pub share: Share,
    /// Which round, from 1, of a computation in which what comes next depends on what all parts before have found.
    pub round: u32,
    /// Whether nothing was left to other parts or to a later round.
    pub is_complete: bool,
    /// Whether it is no part, but an excerpt of all parts so far: what the next round needs of them.
    pub is_excerpt: bool,
    /// Number of its pieces.
    pub pieces: u64,
}

const FORMAT: [u8; 8] = *b"kpart-2\n";

/// Source of the bytes of a part: a file or memory.
#[derive(Debug, Clone)]
pub enum PartSource {
    /// In a file.
    File(PathBuf),
    /// In memory, called so in messages.
    Bytes(String, Arc<[u8]>),
}

trait ReadSeek: Read + Seek {}
impl<T: Read + Seek> ReadSeek for T {}

impl PartSource {
    /// Returns the name of the source in messages.
    fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Bytes(name, _) => name.clone(),
        }
    }

    /// Opens the source for reading; returns the reader and its length in bytes.
    fn open(&self) -> Result<(Box<dyn ReadSeek + '_>, u64)> {
        match self {
            Self::File(path) => {
                let opened = file::open(path)?;
                let length = opened.metadata().map_err(|cause| self.read_error(cause))?.len();
                Ok((Box::new(opened), length))
            }
            Self::Bytes(_, bytes) => Ok((Box::new(Cursor::new(bytes)), bytes.len() as u64)),
        }
    }

    /// Returns the error that this part cannot be read because of `cause`.
    fn read_error(&self, cause: std::io::Error) -> Error {
        Error::Read { file: self.name().into(), source: cause }
    }

    /// Returns the error that the source is refused because of `problem`.
    fn refuse<T>(&self, problem: impl Into<String>) -> Result<T> {
        Err(Error::Syntax { file: self.name(), line: None, key: String::new(), problem: problem.into() })
    }
}

/// A part file that is whole.
#[derive(Debug)]
pub struct Part {
    source: PartSource,
    head: PartHead,
    /// Keys, and where their pieces are: offset and length.
    piece_locations: Vec<(Vec<u8>, u64, u32)>,
}

impl Part {
    /// Reads all of `source` once; pieces are read again when they are wanted.
    ///
    /// # Errors
    /// It cannot be read, is no part, was cut short or damaged.
    pub fn read(source: PartSource) -> Result<Self> {
        let (reader, length) = source.open()?;
        if length < FORMAT.len() as u64 {
            return source.refuse(format!("is cut short or damaged: it has {length} bytes; compute that part again"));
        }
        let mut reader = BufReader::new(reader);
        let mut format = [0; FORMAT.len()];
        if !fill(&mut reader, &mut format).map_err(|fault| source.read_error(fault))? || format != FORMAT {
            return source.refuse("is not a part of a study that this version of the program computed");
        }
        let mut offset = FORMAT.len() as u64;
        let mut next = |offset: &mut u64| -> Result<Option<Vec<u8>>> {
            let record =
                next_record(&mut reader, length.saturating_sub(*offset)).map_err(|fault| source.read_error(fault))?;
            let Record::Whole(content) = record else { return Ok(None) };
            *offset += (HEAD + content.len()) as u64;
            Ok(Some(content))
        };
        let head = next(&mut offset)?.and_then(|head| postcard::from_bytes::<PartHead>(&head).ok());
        let Some(head) = head else { return source.refuse("is cut short or damaged where it says which part it is") };
        let mut piece_locations = Vec::new();
        for number in 0..head.pieces {
            let start = offset;
            let content = next(&mut offset)?;
            let location = content.as_ref().and_then(|content| {
                let (key, piece) = postcard::take_from_bytes::<Vec<u8>>(content).ok()?;
                Some((key, start + (HEAD + content.len() - piece.len()) as u64, piece.len() as u32))
            });
            let Some(location) = location else {
                let (share, pieces) = (head.share, head.pieces);
                return source.refuse(format!(
                    "is cut short or damaged: {number} of the {pieces} pieces of part {share} are whole; \
                     compute that part again"
                ));
            };
            piece_locations.push(location);
        }
        drop(reader);
        if offset != length {
            return source.refuse(format!("has {} bytes behind its end: it was damaged", length - offset));
        }
        Ok(Self { source, head, piece_locations })
    }

    /// Returns round and number of the part, both from 1.
    fn round_and_number(&self) -> (u32, u32) {
        (self.head.round, self.head.share.part())
    }

    /// Returns the number of the part in words, as in `3 of 10`.
    #[must_use]
    pub fn text(&self) -> String {
        match self.head.round {
            1 => self.head.share.to_string(),
            round => format!("{} of round {round}", self.head.share),
        }
    }

    /// Returns the head of the part.
    #[must_use]
    pub fn head(&self) -> &PartHead {
        &self.head
    }

    /// Checks that this build computed the part, from the inputs of `origin`.
    ///
    /// # Errors
    /// It did not; the message says what differs.
    pub fn check(&self, origin: &Origin) -> Result<()> {
        let PartHead { program, inputs, study, .. } = &self.head;
        if *program != origin.program {
            return self.source.refuse(format!("was computed by {program}, this program is {}", origin.program));
        }
        let expected = origin.inputs.digests();
        if !inputs.iter().map(|(name, _)| name).eq(expected.iter().map(|(name, _)| name)) {
            let names = |inputs: &[(String, String)]| {
                inputs.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ")
            };
            let (found, expected) = (names(inputs), names(&expected));
            return self.source.refuse(format!(
                "is a part of {study} and was computed from other inputs: {found}; those of the study are {expected}"
            ));
        }
        match inputs.iter().zip(&expected).find(|(found, expected)| found != expected) {
            None => Ok(()),
            Some(((name, found), (_, expected))) => self.source.refuse(format!(
                "is a part of {study} and was computed from other inputs: its {name} has the SHA-256 {}…, that of the study {}…",
                &found.chars().take(12).collect::<String>(),
                &expected[..12]
            )),
        }
    }
}

/// Writes to `to` a part file with `head` and the pieces under `keys`, in the order of their bytes, which `bytes` reads.
///
/// # Errors
/// A piece cannot be read, or `to` not written.
pub(super) fn write(
    mut head: PartHead,
    keys: Vec<Vec<u8>>,
    mut bytes: impl FnMut(&Vec<u8>) -> Result<Option<Vec<u8>>>,
    to: &mut impl Write,
) -> Result<()> {
    head.pieces = keys.len() as u64;
    let stem = head.share.stem(head.round);
    let fault = |source| Error::Write { file: stem.clone().into(), source };
    to.write_all(&FORMAT).map_err(fault)?;
    to.write_all(&encode(&head).and_then(|head| record(&head)).map_err(fault)?).map_err(fault)?;
    for key in keys {
        let Some(piece) = bytes(&key)? else { continue };
        let content = [encode(&key).map_err(fault)?, piece].concat();
        to.write_all(&record(&content).map_err(fault)?).map_err(fault)?;
    }
    Ok(())
}

/// All parts of one or several rounds of a computation.
#[derive(Debug)]
pub struct Parts {
    sources: Vec<PartSource>,
    /// Where the piece of each key is: number of the source, offset and length.
    piece_locations: HashMap<Vec<u8>, (usize, u64, u32)>,
    part_count: u32,
    rounds: u32,
}

/// Most missing parts that a message names.
const NAMED: usize = 20;

impl Parts {
    /// Collects all `parts`, in any order, of the computation from `origin`.
    ///
    /// # Errors
    /// `parts` is empty; a part belongs to another computation or another division; a part is missing or given twice.
    pub fn new(mut parts: Vec<Part>, origin: &Origin) -> Result<Self> {
        let Some(first) = parts.first() else {
            return Err(Error::argument("parts", "expected all parts of a study, got none"));
        };
        let (share, name) = (first.head.share, first.source.name());
        if let Some(other) = parts.iter().find(|part| part.head.is_excerpt) {
            let round = other.head.round + 1;
            return other.source.refuse(format!("is what round {round} needs of the parts before: expected parts"));
        }
        if let Some(other) = parts.iter().find(|part| part.head.share.of() != share.of()) {
            let problem =
                format!("is part {}, {name} is part {share}: expected parts of one division", other.head.share);
            return other.source.refuse(problem);
        }
        parts.iter().try_for_each(|part| part.check(origin))?;
        parts.sort_by_key(Part::round_and_number);
        for pair in parts.windows(2) {
            if pair[0].round_and_number() == pair[1].round_and_number() {
                let problem = format!("is part {}, which {} is, too", pair[1].text(), pair[0].source.name());
                return pair[1].source.refuse(problem);
            }
        }
        let rounds = parts.last().map_or(0, |part| part.head.round);
        (1..=rounds).try_for_each(|round| check_complete(&parts, round, share.of()))?;
        Ok(Self::from_checked(parts, share.of(), rounds))
    }

    /// Collects the pieces in `before`, of the computation from `origin`: all parts of the rounds before, or their excerpt.
    ///
    /// # Errors
    /// As [`Parts::new`]; an excerpt of another computation.
    pub fn before(before: Vec<Part>, origin: &Origin) -> Result<Self> {
        match before.as_slice() {
            [one] if one.head.is_excerpt => {
                one.check(origin)?;
                let (of, rounds) = (one.head.share.of(), one.head.round);
                Ok(Self::from_checked(before, of, rounds))
            }
            _ => Self::new(before, origin),
        }
    }

    /// Collects the pieces of `parts`, which were checked as in [`Parts::new`].
    fn from_checked(parts: Vec<Part>, part_count: u32, rounds: u32) -> Self {
        let mut piece_locations = HashMap::new();
        let mut sources = Vec::with_capacity(parts.len());
        for (number, Part { source, piece_locations: locations, .. }) in parts.into_iter().enumerate() {
            sources.push(source);
            piece_locations.extend(locations.into_iter().map(|(key, offset, length)| (key, (number, offset, length))));
        }
        Self { sources, piece_locations, part_count, rounds }
    }

    /// Returns the number of parts in a round.
    #[must_use]
    pub fn part_count(&self) -> u32 {
        self.part_count
    }

    /// Returns the number of rounds.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        self.rounds
    }

    /// Returns the piece under `key` as it was encoded; `None` if there is none.
    ///
    /// # Errors
    /// It cannot be read any more.
    pub(super) fn bytes(&self, key: &[u8]) -> Result<Option<Vec<u8>>> {
        let Some(&(source, offset, length)) = self.piece_locations.get(key) else { return Ok(None) };
        let source = &self.sources[source];
        let (mut reader, _) = source.open()?;
        let mut bytes = vec![0; length as usize];
        let read = reader.seek(SeekFrom::Start(offset)).and_then(|_| reader.read_exact(&mut bytes));
        read.map_err(|fault| source.read_error(fault))?;
        Ok(Some(bytes))
    }
}

/// Returns an error that names the missing parts if a round lacks some of its `of` parts.
fn check_complete(parts: &[Part], round: u32, of: u32) -> Result<()> {
    let is_there = |number: &u32| parts.binary_search_by_key(&(round, *number), Part::round_and_number).is_ok();
    let missing: Vec<u32> = (1..=of).filter(|number| !is_there(number)).collect();
    let named: Vec<String> = missing.iter().take(NAMED).map(u32::to_string).collect();
    let (parts, verb) = match missing.as_slice() {
        [] => return Ok(()),
        [one] => (format!("part {one} of {of}"), "is"),
        all if all.len() > NAMED => (format!("parts {}, … of {of}", named.join(", ")), "are"),
        _ => (format!("parts {} of {of}", named.join(", ")), "are"),
    };
    let argument = if round == 1 { parts } else { format!("{parts} of round {round}") };
    Err(Error::argument(argument, format!("{verb} missing: expected all {of}, got {}", of as usize - missing.len())))
}
