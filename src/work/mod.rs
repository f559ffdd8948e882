//! Long computations in pieces: kept, stopped, resumed and shared among computers. Pieces are kept as they finish, it can be
//! stopped between them, and somebody is told how far it is.
//!
//! A unit of work has these words:
//!
//! | word | what it is |
//! |---|---|
//! | block | neighbouring points of a grid or a path that are solved together: as many whatever the number of threads, so that results do not depend on it |
//! | piece | what is kept of a block, or of a step of a search, under a key; a run that was stopped goes on with its pieces ([`checkpoint`]) |
//! | shard | the work on a numbered piece that needs no other: by these numbers a computation is shared ([`Work::shard`]) |
//! | share | the shards of one computer: part i of n ([`share::Share`]) |
//! | part | the file with the pieces of a share ([`part_file`]); merged, all parts are to the whole what an unfinished run is to the one that goes on with it |
//!
//! Where a computation is one part of several, a piece of another part is not computed: its place stays empty ([`if_this_shard`]), and where all of
//! them are needed the part ends ([`Work::barrier`]). What the next round of parts needs of those before is an excerpt: the pieces that a replay asks
//! for ([`Work::replay`]), and summaries in place of many ([`Work::summary`]).

pub mod checkpoint;
mod overlapped;
pub mod part_file;
mod records;
pub mod share;

use std::{
    collections::BTreeMap,
    io,
    path::PathBuf,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

pub(crate) use overlapped::compute_overlapped;
use serde::{Serialize, de::DeserializeOwned};

use crate::{
    input::error::{Error, Result},
    work::{
        checkpoint::Checkpoint,
        part_file::{PartHead, Parts},
        records::{decode, encode},
        share::Share,
    },
};

/// Progress of a computation, as reported to its observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// So many items of the work are computed.
    Computed(usize),
    /// So many of them have no answer.
    Unsolved(usize),
    /// So many items were computed by a run before and are taken over.
    Kept(usize),
    /// The best value that a search has found so far.
    Best(f64),
    /// At the begin of a run into a folder: so many pieces of a run before are there to be taken over (none in a new
    /// one), and so many were damaged.
    Resumed {
        /// Whole ones.
        pieces: usize,
        /// Damaged ones, which are computed again.
        lost: usize,
    },
    /// Before stock is cut: how large its cells are, and how much memory it takes at most.
    Stock {
        /// Size of a cell, mm.
        cell_mm: f64,
        /// Memory, bytes.
        bytes: u64,
    },
    /// Another part of the work begins, whose items are counted anew.
    Stage(Stage),
    /// One of the pieces that a [`Share`] holds is there.
    Shard {
        /// Whether a run before has computed it.
        is_kept: bool,
    },
}

/// A stage of the work whose items are counted by themselves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stage {
    /// What its items are called.
    pub of: &'static str,
    /// Their number.
    pub items: usize,
}

/// A computation in progress. Clones are the same computation; any thread may use it.
#[derive(Clone)]
pub struct Work {
    shared: Arc<Shared>,
    /// Part of the computation: beginning of every key.
    part: String,
    /// Number of its first piece.
    first: usize,
    sharded: Option<Sharded>,
}

/// State that all clones of a [`Work`] share.
struct Shared {
    checkpoint: Option<Mutex<Checkpoint>>,
    /// What parts have computed.
    parts: Option<Parts>,
    share: Option<Share>,
    /// Of a replay: keys of the pieces that were asked for and are known, and the summaries that were made of others.
    asked: Option<Mutex<Asked>>,
    /// Whether a piece was asked for that another part computes.
    needs_other: AtomicBool,
    /// Set by somebody else.
    stop: Arc<AtomicBool>,
    /// Why pieces can no longer be kept.
    fault: Mutex<Option<SharedError>>,
    watch: Watch,
}

type Watch = Box<dyn Fn(Event) + Send + Sync>;
/// Keys, with the bytes of summaries; those of pieces are in the parts.
type Asked = BTreeMap<Vec<u8>, Option<Vec<u8>>>;

/// A numbered piece of a computation that is shared among parts.
#[derive(Clone)]
struct Sharded {
    /// Whether this part computes it.
    is_own: bool,
    /// Whether a piece of it was asked for that is not known.
    needs_other: Arc<AtomicBool>,
}

/// An [`Error::Write`] or [`Error::Read`] of which every thread can get a copy.
struct SharedError {
    is_writing: bool,
    file: PathBuf,
    kind: io::ErrorKind,
    words: String,
}

impl SharedError {
    /// Returns a copy of what an error of writing or reading says; `None` for other errors.
    fn of(error: &Error) -> Option<Self> {
        let (is_writing, file, source) = match error {
            Error::Write { file, source } => (true, file, source),
            Error::Read { file, source } => (false, file, source),
            _ => return None,
        };
        Some(Self { is_writing, file: file.clone(), kind: source.kind(), words: source.to_string() })
    }

    /// Returns a new error that says the same.
    fn error(&self) -> Error {
        let (file, source) = (self.file.clone(), io::Error::new(self.kind, self.words.clone()));
        if self.is_writing { Error::Write { file, source } } else { Error::Read { file, source } }
    }
}

impl Default for Work {
    /// Returns work that is not kept, cannot be stopped, and has no observer.
    fn default() -> Self {
        Self::new(None, Arc::default(), Box::new(|_| ()))
    }
}

impl Work {
    /// Returns work that is kept in `checkpoint`, stopped by setting `stop`, and observed by `watch`.
    pub fn new(checkpoint: Option<Checkpoint>, stop: Arc<AtomicBool>, watch: Watch) -> Self {
        Self::with_parts(checkpoint, None, None, stop, watch)
    }

    /// Returns work as [`Work::new`] does, but the pieces of `parts`, found before, need not be computed, and of sharded pieces only those
    /// that `share` holds are computed.
    pub fn with_parts(
        checkpoint: Option<Checkpoint>,
        parts: Option<Parts>,
        share: Option<Share>,
        stop: Arc<AtomicBool>,
        watch: Watch,
    ) -> Self {
        let (needs_other, fault) = (AtomicBool::new(false), Mutex::new(None));
        let checkpoint = checkpoint.map(Mutex::new);
        let shared = Shared { checkpoint, parts, share, asked: None, needs_other, stop, fault, watch };
        Self { shared: Arc::new(shared), part: String::new(), first: 0, sharded: None }
    }

    /// Returns work that computes no piece, and records which of `parts` it is asked for, for [`Work::write_excerpt`]; `stop` stops it.
    pub fn replay(parts: Parts, stop: Arc<AtomicBool>) -> Self {
        let (needs_other, fault) = (AtomicBool::new(false), Mutex::new(None));
        let (parts, asked, watch) = (Some(parts), Some(Mutex::default()), Box::new(|_| ()));
        let shared = Shared { checkpoint: None, parts, share: None, asked, needs_other, stop, fault, watch };
        Self { shared: Arc::new(shared), part: String::new(), first: 0, sharded: None }
    }

    /// Returns work on the part called `name`: the keys of its pieces begin with that name.
    #[must_use]
    pub fn part(&self, name: &str) -> Self {
        Self { part: format!("{}{name}/", self.part), ..self.clone() }
    }

    /// Returns this work with its shards numbered behind `pieces` others.
    #[must_use]
    pub fn numbered_after(&self, pieces: usize) -> Self {
        Self { first: self.first + pieces, ..self.clone() }
    }

    /// Returns work on piece number `number` of those that do not need one another: where the computation is shared, it belongs to one
    /// part, and so does everything that is asked of what is returned.
    #[must_use]
    pub fn shard(&self, number: usize) -> Self {
        let mut shard = self.clone();
        let is_shared = self.shared.share.is_some() || self.shared.asked.is_some();
        if is_shared && self.sharded.is_none() {
            let is_own = self.shared.share.is_some_and(|share| share.holds(self.first + number));
            shard.sharded = Some(Sharded { is_own, needs_other: Arc::default() });
        }
        shard
    }

    /// Checks that all pieces asked for so far are there; what needs all of them calls this first.
    ///
    /// # Errors
    /// [`Error::OtherShard`] if another part computes one of them; as [`Work::check`].
    pub fn barrier(&self) -> Result<()> {
        self.check()?;
        let needs_other = self.sharded.is_none() && self.shared.needs_other.load(Ordering::Relaxed);
        if needs_other { Err(Error::OtherShard) } else { Ok(()) }
    }

    /// Returns what `compute` makes of pieces under `name`, once all of them are there. Where an excerpt has what a [`Work::replay`] made
    /// of them, they need not be known.
    ///
    /// # Errors
    /// Errors of `compute`; as [`Work::barrier`]; the excerpt cannot be read.
    pub fn summary<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        compute: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        if self.shared.parts.is_none() || self.sharded.is_some() {
            return compute();
        }
        let key = self.encoded(&(&self.part, "summary", name))?;
        if let Some(summary) = self.bytes_in_parts(&key)?.and_then(|bytes| decode(&bytes)) {
            self.record_asked(key, None);
            return Ok(summary);
        }
        let before = self.shared.asked.as_ref().map(|asked| lock(asked).clone());
        let summary = compute()?;
        self.barrier()?;
        if let (Some(before), Some(asked)) = (before, &self.shared.asked) {
            *lock(asked) = before;
            self.record_asked(key, Some(self.encoded(&summary)?));
        }
        Ok(summary)
    }

    /// Records that a replay was asked for `key`; `summary` has the bytes of a summary, `None` for a piece of the parts.
    fn record_asked(&self, key: Vec<u8>, summary: Option<Vec<u8>>) {
        if let Some(asked) = &self.shared.asked {
            lock(asked).insert(key, summary);
        }
    }

    /// Writes the pieces that are kept as a part file with `head` to `to`.
    ///
    /// # Errors
    /// They cannot be read, or `to` not written.
    pub fn write_part(&self, head: PartHead, to: &mut impl io::Write) -> Result<()> {
        let Some(checkpoint) = &self.shared.checkpoint else { return Ok(()) };
        let mut checkpoint = lock(checkpoint);
        part_file::write(head, checkpoint.keys(), |key| checkpoint.bytes(key), to)
    }

    /// Writes what a [`Work::replay`] was asked for as a part file with `head` to `to`.
    ///
    /// # Errors
    /// As [`Work::write_part`].
    pub fn write_excerpt(&self, head: PartHead, to: &mut impl io::Write) -> Result<()> {
        let (Some(asked), Some(parts)) = (&self.shared.asked, &self.shared.parts) else { return Ok(()) };
        let asked = lock(asked);
        let bytes = |key: &Vec<u8>| match asked.get(key) {
            Some(Some(made)) => Ok(Some(made.clone())),
            _ => parts.bytes(key),
        };
        part_file::write(head, asked.keys().cloned().collect(), bytes, to)
    }

    /// Returns the number of pieces that are kept; 0 without a checkpoint.
    pub fn pieces(&self) -> usize {
        self.shared.checkpoint.as_ref().map_or(0, |checkpoint| lock(checkpoint).len())
    }

    /// Reports `event` to the observer.
    pub fn tell(&self, event: Event) {
        (self.shared.watch)(event);
    }

    /// Checks that the work may go on.
    ///
    /// # Errors
    /// [`Error::Stopped`]; [`Error::Write`] or [`Error::Read`] once a piece could not be kept or read; [`Error::OtherShard`] once
    /// what was [sharded](Work::shard) needs a piece of another part.
    pub fn check(&self) -> Result<()> {
        if let Some(fault) = &*lock(&self.shared.fault) {
            return Err(fault.error());
        }
        if self.shared.stop.load(Ordering::Relaxed) {
            return Err(Error::Stopped);
        }
        match &self.sharded {
            Some(sharded) if sharded.needs_other.load(Ordering::Relaxed) => Err(Error::OtherShard),
            _ => Ok(()),
        }
    }

    /// Returns the piece under `key`: what a run before computed, or what `compute` gives, which is then kept. `items` says how many items it
    /// holds; `compute` tells of them itself, and may end early with the error of [`Work::check`].
    ///
    /// # Errors
    /// Of `compute`; the work was stopped, pieces cannot be kept or read, or another part computes it.
    pub fn piece<K: Serialize, T: Serialize + DeserializeOwned>(
        &self,
        key: &K,
        items: impl FnOnce(&T) -> usize,
        compute: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        self.check()?;
        if self.shared.asked.is_some() {
            return self.replayed_piece(key);
        }
        let Some(checkpoint) = &self.shared.checkpoint else { return compute() };
        let key = self.encoded(&(&self.part, key))?;
        // One that does not decode is computed again.
        let kept = lock(checkpoint).bytes(&key).map_err(|error| self.record_fault(error))?;
        let is_own = kept.is_some();
        let kept = if is_own { kept } else { self.bytes_in_parts(&key)? };
        if let Some(piece) = kept.and_then(|bytes| decode(&bytes)) {
            let items = items(&piece);
            if items > 0 {
                self.tell(Event::Kept(items));
            }
            if is_own {
                self.tell_shard(true);
            }
            return Ok(piece);
        }
        self.check_own_shard()?;
        let piece = compute()?;
        let bytes = self.encoded(&piece)?;
        lock(checkpoint).append_piece(&key, &bytes).map_err(|error| self.record_fault(error))?;
        self.tell_shard(false);
        Ok(piece)
    }

    /// Returns the piece under `key` from the parts, and records that it was asked for; `Err` if no part has it.
    fn replayed_piece<K: Serialize, T: DeserializeOwned>(&self, key: &K) -> Result<T> {
        let key = self.encoded(&(&self.part, key))?;
        if let Some(piece) = self.bytes_in_parts(&key)?.and_then(|bytes| decode(&bytes)) {
            self.record_asked(key, None);
            return Ok(piece);
        }
        self.check_own_shard()?;
        self.shared.needs_other.store(true, Ordering::Relaxed);
        Err(Error::OtherShard)
    }

    /// Returns the bytes of `value`, a key or a piece; `Err` if it cannot be encoded, which is recorded.
    fn encoded(&self, value: &impl Serialize) -> Result<Vec<u8>> {
        encode(value).map_err(|source| self.record_fault(Error::Write { file: "a piece of the work".into(), source }))
    }

    /// Returns the bytes under `key` in the parts; `None` without parts or if none has it; `Err` if they cannot be read, which is recorded.
    fn bytes_in_parts(&self, key: &[u8]) -> Result<Option<Vec<u8>>> {
        let parts = self.shared.parts.as_ref();
        parts.map_or(Ok(None), |parts| parts.bytes(key)).map_err(|error| self.record_fault(error))
    }

    /// Records why pieces can no longer be kept, and returns `error`.
    fn record_fault(&self, error: Error) -> Error {
        let mut first = lock(&self.shared.fault);
        *first = first.take().or_else(|| SharedError::of(&error));
        error
    }

    /// Returns [`Error::OtherShard`], and records it, if the piece belongs to another part.
    fn check_own_shard(&self) -> Result<()> {
        match &self.sharded {
            Some(sharded) if !sharded.is_own => {
                sharded.needs_other.store(true, Ordering::Relaxed);
                self.shared.needs_other.store(true, Ordering::Relaxed);
                Err(Error::OtherShard)
            }
            _ => Ok(()),
        }
    }

    /// Reports that a piece of this part's share is there, if the work is such a piece.
    fn tell_shard(&self, is_kept: bool) {
        if self.sharded.as_ref().is_some_and(|sharded| sharded.is_own) {
            self.tell(Event::Shard { is_kept });
        }
    }
}

/// Returns `None` for [`Error::OtherShard`]: another part computes what is asked for.
///
/// # Errors
/// All others.
pub fn if_this_shard<T>(result: Result<T>) -> Result<Option<T>> {
    match result {
        Err(Error::OtherShard) => Ok(None),
        other => other.map(Some),
    }
}

/// Locks `mutex`, also after a panic elsewhere: each piece is written at once, so that what it left is whole.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
