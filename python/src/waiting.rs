//! Long computations: on all processors, without the lock of the interpreter, ended by Ctrl-C.

use std::{
    panic::resume_unwind,
    process,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc::{RecvTimeoutError, channel},
    },
    thread,
    time::Duration,
};

use pyo3::{PyResult, Python};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::refused;

/// How often signals are looked at, and whoever waits is told how far it is.
const TICK: Duration = Duration::from_millis(50);

/// Computes while this thread waits, which calls `tick` from time to time. A signal (Ctrl-C), or an exception of `tick`, sets what `compute` is
/// given to end early.
///
/// # Errors
/// The exception of the signal or of `tick`; what was computed is then lost.
pub fn wait_for<T: Send>(
    py: Python<'_>,
    tick: impl FnMut(Python<'_>) -> PyResult<()>,
    compute: impl FnOnce(&Arc<AtomicBool>) -> T + Send,
) -> PyResult<T> {
    wait_on(py, &*pool_of(0)?, tick, compute)
}

/// The same on the threads of `pool`.
///
/// # Errors
/// As [`wait_for`].
pub fn wait_on<T: Send>(
    py: Python<'_>,
    pool: &ThreadPool,
    mut tick: impl FnMut(Python<'_>) -> PyResult<()>,
    compute: impl FnOnce(&Arc<AtomicBool>) -> T + Send,
) -> PyResult<T> {
    let stop = Arc::new(AtomicBool::new(false));
    thread::scope(|scope| {
        let (sender, mut receiver) = channel();
        let given = &stop;
        let worker = scope.spawn(move || {
            // Nobody listens if this thread is the last one to know.
            let _ = sender.send(pool.install(|| compute(given)));
        });
        let mut stopped = None;
        loop {
            let (got, back) = py.detach(move || (receiver.recv_timeout(TICK), receiver));
            receiver = back;
            match got {
                Ok(answer) => return stopped.map_or(Ok(answer), Err),
                Err(RecvTimeoutError::Timeout) if stopped.is_none() => {
                    stopped = py.check_signals().and_then(|()| tick(py)).err();
                    stop.store(stopped.is_some(), Ordering::Relaxed);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => match worker.join() {
                    Err(panic) => resume_unwind(panic),
                    Ok(()) => return Err(refused("worker", "ended without an answer")),
                },
            }
        }
    })
}

/// So many threads; 0 for those of this process: `RAYON_NUM_THREADS` of them, or as many as processors. Those of a process do not live in
/// one that was forked from it, which gets its own.
///
/// # Errors
/// They cannot be made.
pub fn pool_of(threads: usize) -> PyResult<Arc<ThreadPool>> {
    static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);
    let made = || {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map(Arc::new).map_err(|fault| refused("threads", &fault.to_string()))
    };
    if threads > 0 {
        return made();
    }
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((owner, own)) = &*pool
        && *owner == process::id()
    {
        return Ok(Arc::clone(own));
    }
    let own = made()?;
    // The threads of the process before the fork are not here: there is nothing to be ended.
    if let Some((_, gone)) = pool.replace((process::id(), Arc::clone(&own))) {
        std::mem::forget(gone);
    }
    Ok(own)
}
