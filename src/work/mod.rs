//! What a long computation goes on in: its pieces are kept as they finish, it can be stopped between them, and somebody
//! is told how far it is.

pub mod checkpoint;

use std::{
    io,
    path::PathBuf,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use serde::{Serialize, de::DeserializeOwned};

use crate::{
    input::error::{Error, Result},
    work::checkpoint::{Checkpoint, decoded, encoded},
};

/// What somebody who watches is told.
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
    /// At the begin of a run into a folder: so many pieces of a run before are there to be taken over (none in a new one), and
    /// so many were damaged.
    Resumed {
        /// Whole ones.
        pieces: usize,
        /// Damaged ones, which are computed again.
        lost: usize,
    },
    /// Another part of the work begins, whose items are counted anew.
    Stage(Stage),
}

/// A part of the work whose items are counted by themselves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stage {
    /// What its items are called.
    pub of: &'static str,
    /// Their number.
    pub items: usize,
}

/// A computation in progress. Clones are the same one; any thread may use it.
#[derive(Clone)]
pub struct Work {
    shared: Arc<Shared>,
    /// Part of the computation: begin of every key.
    part: String,
}

struct Shared {
    checkpoint: Option<Mutex<Checkpoint>>,
    /// Set by somebody else.
    stop: Arc<AtomicBool>,
    /// Why pieces can no longer be kept.
    fault: Mutex<Option<Fault>>,
    watch: Box<dyn Fn(Event) + Send + Sync>,
}

/// An [`Error::Write`] or [`Error::Read`] that every thread can be told of.
struct Fault {
    is_writing: bool,
    file: PathBuf,
    kind: io::ErrorKind,
    words: String,
}

impl Fault {
    fn of(error: &Error) -> Option<Self> {
        let (is_writing, file, source) = match error {
            Error::Write { file, source } => (true, file, source),
            Error::Read { file, source } => (false, file, source),
            _ => return None,
        };
        Some(Self { is_writing, file: file.clone(), kind: source.kind(), words: source.to_string() })
    }

    fn error(&self) -> Error {
        let (file, source) = (self.file.clone(), io::Error::new(self.kind, self.words.clone()));
        if self.is_writing { Error::Write { file, source } } else { Error::Read { file, source } }
    }
}

impl Default for Work {
    /// Work that is not kept, cannot be stopped, and that nobody watches.
    fn default() -> Self {
        Self::new(None, Arc::default(), Box::new(|_| ()))
    }
}

impl Work {
    /// Work that is kept in `checkpoint`, stopped by setting `stop`, and watched by `watch`.
    pub fn new(checkpoint: Option<Checkpoint>, stop: Arc<AtomicBool>, watch: Box<dyn Fn(Event) + Send + Sync>) -> Self {
        let shared = Shared { checkpoint: checkpoint.map(Mutex::new), stop, fault: Mutex::new(None), watch };
        Self { shared: Arc::new(shared), part: String::new() }
    }

    /// The part called `name`: its keys are its own.
    #[must_use]
    pub fn part(&self, name: &str) -> Self {
        Self { shared: Arc::clone(&self.shared), part: format!("{}{name}/", self.part) }
    }

    /// Number of pieces that are kept.
    pub fn pieces(&self) -> usize {
        self.shared.checkpoint.as_ref().map_or(0, |checkpoint| lock(checkpoint).len())
    }

    /// Tells who watches.
    pub fn tell(&self, event: Event) {
        (self.shared.watch)(event);
    }

    /// Whether it is to go on.
    ///
    /// # Errors
    /// [`Error::Stopped`]; [`Error::Write`] or [`Error::Read`] once a piece could not be kept or read.
    pub fn check(&self) -> Result<()> {
        if let Some(fault) = &*lock(&self.shared.fault) {
            return Err(fault.error());
        }
        if self.shared.stop.load(Ordering::Relaxed) { Err(Error::Stopped) } else { Ok(()) }
    }

    /// The piece under `key`: what a run before computed, or what `compute` gives, which is then kept. `items` says
    /// how many items it holds; `compute` tells of them itself, and may end early with the error of [`Work::check`].
    ///
    /// # Errors
    /// Of `compute`; the work was stopped, or pieces cannot be kept or read.
    pub fn piece<K: Serialize, T: Serialize + DeserializeOwned>(
        &self,
        key: &K,
        items: impl FnOnce(&T) -> usize,
        compute: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        self.check()?;
        let Some(checkpoint) = &self.shared.checkpoint else { return compute() };
        let fault = |error: Error| {
            let mut first = lock(&self.shared.fault);
            *first = first.take().or_else(|| Fault::of(&error));
            error
        };
        let key = encoded(&(&self.part, key)).map_err(|source| fault(in_memory(source)))?;
        let bytes = lock(checkpoint).bytes(&key).map_err(fault)?;
        // One that does not decode is computed again.
        if let Some(piece) = bytes.and_then(|bytes| decoded(&bytes)) {
            let items = items(&piece);
            if items > 0 {
                self.tell(Event::Kept(items));
            }
            return Ok(piece);
        }
        let piece = compute()?;
        let bytes = encoded(&piece).map_err(|source| fault(in_memory(source)))?;
        lock(checkpoint).keep(&key, &bytes).map_err(fault)?;
        Ok(piece)
    }
}

fn in_memory(source: io::Error) -> Error {
    Error::Write { file: "a piece of the work".into(), source }
}

/// What a panic elsewhere left is still whole: each piece is written at once.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
