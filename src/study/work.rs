//! What a long computation goes on in: its pieces are kept as they finish, it can be stopped between them, and somebody
//! is told how far it is.

use std::{
    io,
    path::PathBuf,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use serde::{Serialize, de::DeserializeOwned};

use super::checkpoint::Checkpoint;
use crate::error::{Error, Result};

/// What somebody who watches is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// So many items of the work are computed.
    Computed(usize),
    /// So many items were computed by a run before and are taken over.
    Kept(usize),
    /// The best value that a search has found so far.
    Best(f64),
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

/// An [`Error::Write`] that every thread can be told of.
struct Fault {
    file: PathBuf,
    kind: io::ErrorKind,
    words: String,
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

    /// Tells who watches.
    pub fn tell(&self, event: Event) {
        (self.shared.watch)(event);
    }

    /// Whether it is to go on.
    ///
    /// # Errors
    /// [`Error::Stopped`]; [`Error::Write`] once a piece could not be kept.
    pub fn check(&self) -> Result<()> {
        if let Some(Fault { file, kind, words }) = &*lock(&self.shared.fault) {
            return Err(Error::Write { file: file.clone(), source: io::Error::new(*kind, words.clone()) });
        }
        if self.shared.stop.load(Ordering::Relaxed) { Err(Error::Stopped) } else { Ok(()) }
    }

    /// The piece under `key`: what a run before computed, or what `compute` gives, which is then kept. `items` says
    /// how many items it holds; `compute` tells of them itself.
    ///
    /// # Errors
    /// The work was stopped, or the piece cannot be kept.
    pub fn piece<K: Serialize, T: Serialize + DeserializeOwned>(
        &self,
        key: &K,
        items: impl FnOnce(&T) -> usize,
        compute: impl FnOnce() -> T,
    ) -> Result<T> {
        self.check()?;
        let Some(checkpoint) = &self.shared.checkpoint else { return Ok(compute()) };
        let key = (&self.part, key);
        if let Some(piece) = lock(checkpoint).piece(&key)? {
            self.tell(Event::Kept(items(&piece)));
            return Ok(piece);
        }
        let piece = compute();
        let kept = lock(checkpoint).keep(&key, &piece);
        if let Err(Error::Write { file, source }) = &kept {
            let fault = Fault { file: file.clone(), kind: source.kind(), words: source.to_string() };
            lock(&self.shared.fault).get_or_insert(fault);
        }
        kept.map(|()| piece)
    }
}

/// What a panic elsewhere left is still whole: each piece is written at once.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
