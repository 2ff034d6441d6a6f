//! Gauss-Seidel sweep: solves contact by contact and joint row by joint row, each with the latest impulses of the others.

use crate::factor::Factor;
use crate::linalg::blocks::{block, subtract};
use crate::linalg::cholesky::axpy;
use crate::linalg::stacked::Stacked;
use crate::linalg::zip::{zip4, zip5};
use crate::real::Real;
use crate::sets::Sets;
use crate::sets::contact::local::Local;
use crate::sets::contact::{coulomb_sweep, relaxed_sweep};
use crate::solution::Model;

/// One sweep. It updates `r`, and `u` to `W r + q`. The slip multiplier `λ` of each contact starts at that of the last sweep.
pub(crate) fn sweep<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    sets: &Sets<T, D, C, R>,
    factor: &Factor<T, N, D, C, R>,
    model: Model,
    r: &mut Stacked<T, D, C, R>,
    u: &mut Stacked<T, D, C, R>,
    multipliers: &mut [T; C],
) {
    match model {
        Model::Coulomb => each(sets, factor, r, u, multipliers, |local, multiplier| {
            coulomb_sweep::solve_local(local, multiplier)
        }),
        Model::ConvexRelaxation => {
            each(sets, factor, r, u, multipliers, |local, _| relaxed_sweep::solve_local(local));
        }
    }
}

/// Square of the residual of Coulomb's law after a sweep (N²s²), an estimate of that of the natural map.
pub(crate) fn residual_square<T: Real, const D: usize, const C: usize, const R: usize>(
    sets: &Sets<T, D, C, R>,
    r: &Stacked<T, D, C, R>,
    u: &Stacked<T, D, C, R>,
    multipliers: &[T; C],
) -> T {
    let contacts = zip4(sets.contacts(), &u.contacts, &r.contacts, multipliers);
    contacts.fold(T::ZERO, |sum, (set, u, r, &multiplier)| {
        sum + coulomb_sweep::residual_square(set, u, r, multiplier)
    })
}

/// Solves all contacts in their order by `solve_local`, then all joint rows.
#[inline(always)]
#[allow(clippy::inline_always)] // one loop for each law
fn each<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    sets: &Sets<T, D, C, R>,
    factor: &Factor<T, N, D, C, R>,
    impulses: &mut Stacked<T, D, C, R>,
    velocities: &mut Stacked<T, D, C, R>,
    multipliers: &mut [T; C],
    solve_local: impl Fn(&Local<'_, T, D>, &mut T) -> [T; D],
) {
    let delassus = factor.delassus();
    let counts = sets.counts();
    let (masses, targets) = (factor.effective_mass(), &mut impulses.contacts);
    for (i, set, rows, mass, r) in zip5(0..C, sets.contacts(), &delassus.contacts, masses, targets) {
        let (block, u) = (block(&delassus.contacts, i, i), velocities.contacts.get(i));
        let (Some(block), Some(&u), Some(multiplier)) = (block, u, multipliers.get_mut(i)) else {
            return;
        };
        let local = Local { set, block, mass, u, r: *r };
        let new = solve_local(&local, multiplier);
        let mut taken = *r;
        for (taken, &new) in taken.iter_mut().zip(&new) {
            *taken -= new;
        }
        *r = new;
        if taken != [T::ZERO; D] {
            let contacts = velocities.contacts.iter_mut().enumerate();
            for (j, u) in contacts.take(counts.contacts) {
                for (k, u) in u.iter_mut().enumerate() {
                    subtract(Some(u), &taken, rows, |row| row.get(j)?.get(k));
                }
            }
            let rows = delassus.rows.iter().zip(&mut velocities.rows);
            for (row, u) in rows.take(counts.rows) {
                for (&taken, &entry) in taken.iter().zip(row.contacts.get(i).into_iter().flatten()) {
                    *u -= taken * entry;
                }
            }
        }
    }
    for (j, set, row, r) in zip4(0..R, sets.rows(), &delassus.rows, &mut impulses.rows) {
        let Some(&u) = velocities.rows.get(j) else {
            return;
        };
        let new = set.solve_local(*r, u);
        let change = new - *r;
        // Most rows do not change: open stops stay open, and saturated motors stay saturated.
        if change != T::ZERO {
            *r = new;
            let contacts = velocities.contacts.as_flattened_mut();
            let used = contacts.get_mut(..D * counts.contacts).unwrap_or_default();
            axpy(change, row.contacts.as_flattened(), used);
            let used = velocities.rows.get_mut(..counts.rows).unwrap_or_default();
            axpy(change, &row.rows, used);
        }
    }
}
