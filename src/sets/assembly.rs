//! The matrix of a linearised equation, transposed ([`crate::linalg::elimination`]): a row has the entries of one unknown in the equations of
//! contacts and joint rows. One assembly serves Newton's method and the central path.

use crate::factor::Delassus;
use crate::linalg::elimination::Elimination;
use crate::linalg::stacked::StackedMatrix;
use crate::linalg::zip::zip3;
use crate::real::Real;

/// The unknowns and equations of one contact. An unknown is an impulse, along a row of the contact or along several; an equation is
/// a sum over its rows.
pub(super) trait Linear<T, const D: usize> {
    /// Number of unknowns, and of equations.
    fn count(&self) -> usize;

    /// The equations' sums over one velocity of each row; 0 behind the last equation.
    fn tested(&self, velocities: &[T; D]) -> [T; D];

    /// What unknown `k` does, from what an impulse along each row does to `L` velocities.
    fn pushed<const L: usize>(&self, k: usize, velocities: &[[T; L]; D]) -> [T; L];

    /// Adds to what unknown `k` does in the contact's own equations all that does not come from `W`.
    fn add_own(&self, k: usize, entries: &mut [T; D]);
}

/// Assembles the matrix of contacts and joint rows. `rows` are the indices of the joint rows, with a function that adds to the diagonal entry of
/// a row what does not come from `W`. The blocks below the diagonal of a `symmetric` matrix are not written.
#[inline]
pub(super) fn assemble<T: Real, L: Linear<T, D>, const D: usize, const C: usize, const R: usize>(
    (delassus, matrix): (&Delassus<T, D, C, R>, &mut StackedMatrix<T, D, C, R>),
    elimination: &Elimination<T, D, C, R>,
    contacts: &(impl Iterator<Item = L> + Clone),
    (rows, add_own): (impl Iterator<Item = usize> + Clone, impl Fn(usize, &mut T) -> Option<()>),
    symmetric: bool,
) -> Option<()> {
    for (j, equations) in contacts.clone().enumerate() {
        if equations.count() == 0 {
            continue;
        }
        let start = elimination.columns(j).start;
        for (i, target, unknowns) in zip3(0..C, &mut matrix.contacts, contacts.clone()) {
            if symmetric && i > j {
                break;
            }
            if unknowns.count() == 0 {
                continue;
            }
            let mut block = [[T::ZERO; D]; D];
            for (entries, source) in block.iter_mut().zip(delassus.contacts.get(i)?) {
                *entries = equations.tested(source.get(j)?);
            }
            for (k, row) in target.iter_mut().enumerate() {
                let mut entries = [T::ZERO; D];
                if k < unknowns.count() {
                    entries = unknowns.pushed(k, &block);
                    if i == j {
                        unknowns.add_own(k, &mut entries);
                    }
                }
                // Zeros behind the columns of the contact: the next contact overwrites them.
                let target = row.contacts.as_flattened_mut().get_mut(start..)?;
                *target.first_chunk_mut()? = entries;
            }
        }
    }
    for (index, j) in rows.clone().enumerate() {
        let sources = delassus.rows.get(j)?;
        let target = matrix.rows.get_mut(index)?;
        for (entry, k) in target.rows.iter_mut().zip(rows.clone()) {
            *entry = *sources.rows.get(k)?;
        }
        add_own(j, target.rows.get_mut(index)?)?;
        for (i, contact, source) in zip3(0..C, contacts.clone(), &sources.contacts) {
            if contact.count() == 0 {
                continue;
            }
            if !symmetric {
                let start = elimination.columns(i).start;
                let target = target.contacts.as_flattened_mut().get_mut(start..)?;
                *target.first_chunk_mut()? = contact.tested(source);
            }
            let velocities = source.map(|velocity| [velocity]);
            for (k, row) in matrix.contacts.get_mut(i)?.iter_mut().enumerate() {
                let used = k < contact.count();
                let [entry] = if used { contact.pushed(k, &velocities) } else { [T::ZERO] };
                *row.rows.get_mut(index)? = entry;
            }
        }
    }
    Some(())
}
