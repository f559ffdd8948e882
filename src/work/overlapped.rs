//! Overlapped computing and writing of results too large for memory, block by block.

use crate::input::error::Result;

/// Computes `blocks` one after another, and gives the result of each to `take` while the next one is computed, so that memory does not grow
/// with their number. A block that another part computes (`None`) gives nothing.
///
/// # Errors
/// Errors of `compute` and of `take`.
pub(crate) fn compute_overlapped<B: Send, T: Send>(
    blocks: impl IntoIterator<Item = B>,
    mut compute: impl FnMut(B) -> Result<Option<T>> + Send,
    mut take: impl FnMut(T) -> Result<()> + Send,
) -> Result<()> {
    let mut computed: Option<T> = None;
    for block in blocks {
        let (next, taken) = rayon::join(|| compute(block), || computed.take().map_or(Ok(()), &mut take));
        taken?;
        computed = next?;
    }
    computed.map_or(Ok(()), take)
}
