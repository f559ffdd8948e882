//! Walking through two sequences side by side.

/// The items of two sequences side by side, as of [`std::iter::zip`]. That is not marked for inlining throughout, and a call
/// in the midst of vector instructions empties the registers.
#[inline(always)]
pub(crate) fn pairs<A: IntoIterator, B: IntoIterator>(a: A, b: B) -> Pairs<A::IntoIter, B::IntoIter> {
    Pairs(a.into_iter(), b.into_iter())
}

pub(crate) struct Pairs<A, B>(A, B);

impl<A: Iterator, B: Iterator> Iterator for Pairs<A, B> {
    type Item = (A::Item, B::Item);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        Some((self.0.next()?, self.1.next()?))
    }
}
