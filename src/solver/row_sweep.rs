//! Gauss-Seidel over joint rows: a slot at once if all of its rows hold, otherwise row by row.

use crate::Real;
use crate::linalg::blocks::product;
use crate::problem::row_laws::{RowLaws, clamped};

/// The impulses of a slot of joint rows, which have unit `W_jj`, from the velocity that they have with the old ones.
pub(super) fn push<T: Real, const D: usize>(
    laws: &RowLaws<T, D>,
    own: &[[T; D]; D],
    mass: &[[T; D]; D],
    u: &[T; D],
    old: &[T; D],
) -> [T; D] {
    // Open stops stay open and saturated motors saturated: most rows of a robot most of the time.
    let rows = old.iter().zip(u).zip(&laws.bounds);
    if rows
        .into_iter()
        .all(|((&r, &u), bounds)| clamped(r - u, bounds) == r)
    {
        return *old;
    }
    let mut impulse = *old;
    for (impulse, mass) in impulse.iter_mut().zip(mass) {
        *impulse -= product(mass, u);
    }
    let holding = laws.holding(&impulse);
    let mut holding = holding.iter().take(laws.count());
    // Without an inverse, `mass` is zero.
    let regular = mass.first().and_then(|row| row.first()) != Some(&T::ZERO);
    if regular && holding.all(|&holds| holds) {
        for (impulse, _) in impulse
            .iter_mut()
            .zip(0..)
            .filter(|&(_, k)| k >= laws.count())
        {
            *impulse = T::ZERO;
        }
        return impulse;
    }
    let (mut impulse, mut back) = (*old, [T::ZERO; D]);
    for (k, (bounds, own)) in laws.bounds.iter().zip(own).enumerate() {
        let velocity = u.get(k).copied().unwrap_or(T::ZERO) + product(own, &back);
        if let (Some(r), Some(back)) = (impulse.get_mut(k), back.get_mut(k)) {
            let new = clamped(*r - velocity, bounds);
            *back = new - *r;
            *r = new;
        }
    }
    impulse
}
