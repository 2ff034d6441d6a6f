//! Several lists at once: iterators over flat tuples, up to the end of the shortest list. A range as one of the lists counts them.

use core::iter::zip;

/// Three lists at once.
#[inline]
pub(crate) fn zip3<A: IntoIterator, B: IntoIterator, C: IntoIterator>(
    a: A,
    b: B,
    c: C,
) -> impl Iterator<Item = (A::Item, B::Item, C::Item)> {
    zip(zip(a, b), c).map(|((a, b), c)| (a, b, c))
}

/// Four lists at once.
#[inline]
pub(crate) fn zip4<A: IntoIterator, B: IntoIterator, C: IntoIterator, D: IntoIterator>(
    a: A,
    b: B,
    c: C,
    d: D,
) -> impl Iterator<Item = (A::Item, B::Item, C::Item, D::Item)> {
    zip(zip(a, b), zip(c, d)).map(|((a, b), (c, d))| (a, b, c, d))
}

/// Five lists at once.
#[inline]
#[allow(clippy::type_complexity)] // the lists have no more in common than their length
pub(crate) fn zip5<A: IntoIterator, B: IntoIterator, C: IntoIterator, D: IntoIterator, E: IntoIterator>(
    a: A,
    b: B,
    c: C,
    d: D,
    last: E,
) -> impl Iterator<Item = (A::Item, B::Item, C::Item, D::Item, E::Item)> {
    zip(zip4(a, b, c, d), last).map(|((a, b, c, d), last)| (a, b, c, d, last))
}
