//! What sweeps of all laws share: the way from contact to contact.

use crate::laws::{Laws, Room};
use crate::linalg::blocks::{ContactVector, block, subtract_rows};
use crate::problem::Problem;
use crate::solver::row_sweep;
use crate::{FrictionCone, Real};
use core::hint::black_box;
use core::ops::Range;

/// Goes from contact to contact, and pushes each: given are its cone, `W_ii`, `W_ii⁻¹`, velocity, impulse and `λ`.
#[inline(always)]
#[allow(clippy::inline_always)] // one loop for each law
pub(super) fn each<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>(
    problem: &Problem<'_, T, N, D, C, L>,
    impulse: &mut ContactVector<T, D, C>,
    relative: &mut ContactVector<T, D, C>,
    lambdas: &mut [T; C],
    push: impl Fn(&FrictionCone<T>, &[[T; D]; D], &[[T; D]; D], &[T; D], &[T; D], &mut T) -> [T; D],
) {
    let (laws, delassus) = (problem.laws(), problem.factor.delassus());
    let masses = problem.factor.effective_mass();
    // From a 0 that it knows a compiler makes a loop without vectors.
    let all = black_box(0)..D * laws.len();
    let contacts = laws.iter().zip(delassus).zip(masses).enumerate();
    for ((i, ((law, rows), mass)), (impulse, lambda)) in
        contacts.zip(impulse.iter_mut().zip(lambdas))
    {
        let (Some(own), Some(&u)) = (block(delassus, i, i), relative.get(i)) else {
            return;
        };
        let old = *impulse;
        *impulse = match law.rows.get() {
            Some(rows) => row_sweep::push(rows, &own, mass, &u, &old),
            None => push(&law.cone, &own, mass, &u, &old, lambda),
        };
        let mut back = old;
        for (back, &new) in back.iter_mut().zip(&*impulse) {
            *back -= new;
        }
        if back != [T::ZERO; D] {
            take_back(relative, &back, rows, &all);
        }
    }
}

/// Keeps `u = W r + q` in some of its rows when a contact, of these rows of `W`, takes back an impulse.
#[inline(never)]
fn take_back<T: Real, const D: usize, const C: usize>(
    relative: &mut ContactVector<T, D, C>,
    back: &[T; D],
    rows: &[ContactVector<T, D, C>; D],
    range: &Range<usize>,
) {
    subtract_rows(relative, back, rows, range.start, range.end);
}
