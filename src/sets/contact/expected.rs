//! The sizes of impulses that are expected beside `|r0|`: what would stop the motion, and what momenta carry.

use crate::linalg::sparsity::{GROUP, add_sizes};
use crate::linalg::vector::{at_least, larger, square, unit};
use crate::real::Real;
use crate::scene::Scene;
use crate::sets::{ContactSet, RowSet};
use nalgebra::{ComplexField, SVector};

/// Impulses are never compared with less than this share of the impulse that would stop the motion.
pub(crate) const SHARE: f64 = 1e-2;

/// `|stop|` (N·s)
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn stopping_impulse<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
>(
    scene: &Scene<T, N, D, C, R, S>,
    sets: &[ContactSet<T, D>],
    free: &[T; N],
) -> T {
    let (groups, last) = free.as_chunks::<GROUP>();
    let mut speeds = [[T::ZERO; D]; C];
    let mut largest = T::ZERO;
    let contacts = scene.supported().zip(sets).zip(&mut speeds);
    for (i, (((contact, support), set), speeds)) in contacts.enumerate() {
        *speeds = without_gap(&contact.offset).abs().into();
        let (columns, rest) = contact.jacobian.data.0.as_chunks::<GROUP>();
        for group in support.groups::<N>() {
            if let (Some(columns), Some(free)) = (columns.get(group), groups.get(group)) {
                add_sizes(columns, free, speeds);
            }
        }
        add_sizes(rest, last, speeds);
        *speeds = scene.scale(i, *speeds).map(|speed| speed * set.alpha);
        largest = larger(largest, speeds, T::ONE);
    }
    let unit = unit(largest);
    let mut squares = T::ZERO;
    for speeds in speeds.iter().take(sets.len()) {
        squares += square(&speeds.map(|speed| speed * unit));
    }
    squares.square_root() * (T::literal(SHARE) / unit)
}

/// Entries of the rows of a contact that are lengths: no spin and no roll.
fn lengths<T>(entries: &[T]) -> &[T] {
    entries.get(..3).unwrap_or(entries)
}

/// The impulse (N·s) that the momentum of one dof asks of the contact with the longest lever on it, and that which gives the dof the
/// fastest offset: the largest of `(p_j + M_jj s / h_j) / h_j` with `s = max |w|` and `h_j = max_k |H_kj|`. The momentum `p_j` is that
/// of the free motion and of joint rows, each as if it were alone, by their sizes. In a stack a light body carries a heavy one, and a
/// spring presses a body at rest onto its contacts: of both `|r0|` knows nothing. A dof counts if its lever is more than 1e-7 of what
/// the most mobile contact would have if it moved this dof alone.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn carried_impulse<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
>(
    scene: &Scene<T, N, D, C, R, S>,
    (contacts, rows): (&[ContactSet<T, D>], &[RowSet<T>]),
    free: &[T; N],
) -> T {
    let (mut levers, mut fastest, mut mobility) = ([T::ZERO; N], T::ZERO, T::ZERO);
    for (i, (contact, set)) in scene.contacts().iter().zip(contacts).enumerate() {
        let mut offset = without_gap(&contact.offset);
        for (offset, &share) in offset.iter_mut().zip(&scene.scale(i, [T::ONE; D])) {
            if share == T::ZERO {
                *offset = T::ZERO; // nothing can push along it
            }
        }
        fastest = larger(fastest, lengths(offset.as_slice()), T::ONE);
        mobility = at_least(set.inverse_mass(), mobility);
        for (lever, column) in levers.iter_mut().zip(&contact.jacobian.data.0) {
            *lever = larger(*lever, lengths(column), T::ONE);
        }
    }
    let mut momenta = free.map(ComplexField::abs);
    for (set, row) in rows.iter().zip(scene.rows()) {
        let alone = set.alone();
        for (momentum, &entry) in momenta.iter_mut().zip(&row.row) {
            *momentum += (entry * alone).abs();
        }
    }
    let mut largest = T::ZERO;
    let masses = scene.mass().data.0.iter().enumerate();
    for ((&lever, &momentum), (j, column)) in levers.iter().zip(&momenta).zip(masses) {
        let mass = column.get(j).copied().unwrap_or(T::ZERO);
        if lever > T::literal(1e-7) * (mass * mobility).square_root() {
            largest = at_least((momentum + mass * fastest / lever) / lever, largest);
        }
    }
    largest
}

/// An offset with a positive normal entry (a gap) replaced by 0.
pub(crate) fn without_gap<T: Real, const D: usize>(offset: &SVector<T, D>) -> SVector<T, D> {
    let mut offset = *offset;
    if let Some(normal) = offset.as_mut_slice().first_mut() {
        *normal = normal.min(T::ZERO);
    }
    offset
}
