//! What sweeps of all laws share: the way from contact to contact.

use crate::laws::{Laws, Room};
use crate::linalg::blocks::{ContactVector, block, subtract_rows};
use crate::linalg::hints::rolled;
use crate::problem::Problem;
use crate::solver::row_sweep;
use crate::{FrictionCone, Real};
use core::hint::black_box;

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
    let contacts = laws.iter().zip(delassus).zip(masses).enumerate();
    for ((i, ((law, rows), mass)), (impulse, lambda)) in
        contacts.zip(impulse.iter_mut().zip(lambdas))
    {
        if let Some(bounds) = law.rows.get() {
            let back = row_sweep::push((bounds, law.alpha), i, (delassus, mass), relative, impulse);
            if back != [T::ZERO; D] {
                take_back(relative, &back, rows, laws.len());
            }
            continue;
        }
        let (Some(own), Some(&u)) = (block(delassus, i, i), relative.get(i)) else {
            return;
        };
        let old = *impulse;
        *impulse = push(&law.cone, &own, mass, &u, &old, lambda);
        let mut back = old;
        for (back, &new) in back.iter_mut().zip(&*impulse) {
            *back -= new;
        }
        if back != [T::ZERO; D] {
            take_back(relative, &back, rows, laws.len());
        }
    }
}

/// Keeps `u = W r + q` of some contacts when one contact, of these rows of `W`, takes back an impulse.
#[inline(never)]
fn take_back<T: Real, const D: usize, const C: usize>(
    relative: &mut ContactVector<T, D, C>,
    back: &[T; D],
    rows: &[ContactVector<T, D, C>; D],
    contacts: usize,
) {
    if cfg!(not(target_os = "none")) {
        // From a 0 that it knows a compiler makes a loop without vectors.
        subtract_rows(relative, back, rows, black_box(0), D * contacts);
        return;
    }
    for (j, u) in relative.iter_mut().enumerate().take(contacts) {
        rolled();
        for (&back, row) in back.iter().zip(rows) {
            let Some(block) = row.get(j) else { break };
            for (u, &entry) in u.iter_mut().zip(block) {
                *u -= back * entry;
            }
        }
    }
}
