//! Gauss-Seidel over joint rows: a slot at once if all of its rows hold, otherwise row by row.

use crate::Real;
use crate::linalg::blocks::{ContactMatrix, ContactVector, block, product};
use crate::problem::row_laws::{RowLaws, clamped};

/// Pushes a slot of joint rows, which have `W_jj = 1 / alpha`; returns what that takes away from their impulses.
#[inline(never)] // a sweep over contacts has no register to spare
pub(super) fn push<T: Real, const D: usize, const C: usize>(
    (laws, alpha): (&RowLaws<T, D>, T),
    slot: usize,
    (delassus, mass): (&ContactMatrix<T, D, C>, &[[T; D]; D]),
    relative: &ContactVector<T, D, C>,
    impulse: &mut [T; D],
) -> [T; D] {
    let (mut back, old) = ([T::ZERO; D], *impulse);
    let (Some(own), Some(u)) = (block(delassus, slot, slot), relative.get(slot)) else {
        return back;
    };
    // Open stops stay open and saturated motors saturated: most rows of a robot most of the time.
    let mut rows = old.iter().zip(u).zip(&laws.bounds);
    if rows.all(|((&r, &u), bounds)| clamped(r - alpha * u, bounds) == r) {
        return back;
    }
    for (impulse, mass) in impulse.iter_mut().zip(mass) {
        *impulse -= product(mass, u);
    }
    let holding = laws.holding(impulse);
    let mut holding = holding.iter().take(laws.count());
    // Without an inverse, `mass` is zero.
    let regular = mass.first().and_then(|row| row.first()) != Some(&T::ZERO);
    if regular && holding.all(|&holds| holds) {
        for unused in impulse.iter_mut().skip(laws.count()) {
            *unused = T::ZERO;
        }
        for ((back, &old), &new) in back.iter_mut().zip(&old).zip(&*impulse) {
            *back = old - new;
        }
        return back;
    }
    *impulse = old;
    for (k, (bounds, own)) in laws.bounds.iter().zip(own).enumerate() {
        let velocity = u.get(k).copied().unwrap_or(T::ZERO) - product(&own, &back);
        if let (Some(r), Some(back)) = (impulse.get_mut(k), back.get_mut(k)) {
            let new = clamped(*r - alpha * velocity, bounds);
            *back = *r - new;
            *r = new;
        }
    }
    back
}
