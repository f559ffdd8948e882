//! Overlapped computing and writing of results too large for memory, block by block.

use crate::input::error::Result;

/// Computes `blocks` one after another, and gives what comes of each to `take` while the next one is computed, so that memory does not grow with
/// their number. A block that others compute gives nothing.
///
/// # Errors
/// Of `compute` and of `take`.
pub(crate) fn compute_overlapped<B: Send, T: Send>(
    blocks: impl IntoIterator<Item = B>,
    mut compute: impl FnMut(B) -> Result<Option<T>> + Send,
    mut take: impl FnMut(T) -> Result<()> + Send,
) -> Result<()> {
    let mut done: Option<T> = None;
    for block in blocks {
        let (next, taken) = rayon::join(|| compute(block), || done.take().map_or(Ok(()), &mut take));
        taken?;
        done = next?;
    }
    done.map_or(Ok(()), take)
}
