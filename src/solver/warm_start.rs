//! Warm start: the velocities and impulses of the last solve, by key ([`crate::guide::method`]). `start.rs` begins there.
//!
//! `ũ` is the augmented velocity at the end of the last solve: the `P` of Newton's method, which lies in the dual cones.

use crate::error::{Error, Input, List};
use crate::linalg::stacked::Stacked;
use crate::linalg::zip::{zip3, zip4};
use crate::real::Real;
use crate::scene::{Scene, check_finite};
use crate::sets::jacobian::EarlierIndices;
use core::array::from_fn;
use nalgebra::SVector;
use table::{Entry, Table};

mod table;
mod words;

/// Number of creeping ticks in a row after which a body asks the [rest question](super::rest).
const CREEPING_TICKS: u8 = 4;

/// The kind of start of a solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WarmStartKind {
    /// Cold: without impulses.
    None,
    /// At the last solution. Its impulses are unique, so sweeps may continue from it.
    Isostatic,
    /// At the last solution. Its impulses are not unique.
    Hyperstatic,
}

/// Where the next solve starts: velocities and impulses of the last solve by key, and the impulses of the solve before.
///
/// A solver that is given it ([`crate::Solver::set_warm_start`]) goes on as the one that it comes from.
///
/// ```
/// # use stiction::{Kernel, WarmStart};
/// let kernel = Kernel::<f32, 6, 3, 4>::new();
/// let words = kernel.solver().warm_start().words().collect::<Vec<u64>>(); // for a file, or another process
/// let mut other = Kernel::<f32, 6, 3, 4>::new();
/// other.solver_mut().set_warm_start(WarmStart::from_words(words).expect("of the same sizes"));
/// ```
#[derive(Clone, Debug)]
pub struct WarmStart<T, const D: usize, const C: usize, const R: usize> {
    contacts: Table<T, D, C>,
    rows: Table<T, 1, R>,
    /// Was the last solve solved?
    pub(super) is_solved: bool,
    /// Did the caller declare that nothing moved before the next solve?
    pub(super) presumes_rest: bool,
    /// Was a rest disturbed, and were the internal forces not centred since?
    pub(super) is_disturbed: bool,
    /// Number of creeping ticks in a row.
    creeping_ticks: u8,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> WarmStart<T, D, C, R> {
    /// The warm start before any solve.
    pub(crate) const fn cold() -> Self {
        Self {
            contacts: Table::empty(),
            rows: Table::empty(),
            is_solved: false,
            presumes_rest: false,
            is_disturbed: false,
            creeping_ticks: 0,
        }
    }

    /// Counts creeping ticks in a row, among the ticks that are solved at their start. Returns true in the last of
    /// [`CREEPING_TICKS`].
    pub(super) fn has_crept(&mut self, creeps: bool) -> bool {
        self.creeping_ticks = if creeps { self.creeping_ticks + 1 } else { 0 };
        if self.creeping_ticks < CREEPING_TICKS {
            return false;
        }
        self.creeping_ticks = 0;
        true
    }

    /// Replaces the last solve by given impulses, each with the key of its contact or joint row.
    pub(crate) fn set(&mut self, contacts: &[(u32, SVector<T, D>)], rows: &[(u32, T)]) -> Result<(), Error> {
        let fits = |given: usize, list: List, capacity: usize| {
            let full = Error::ListFull { list, capacity };
            (given <= capacity).then_some(()).ok_or(full)
        };
        fits(contacts.len(), List::InitialImpulses, C)?;
        fits(rows.len(), List::InitialRowImpulses, R)?;
        for (contact, r) in contacts.iter().map(|(_, r)| r).enumerate() {
            check_finite(r, Input::InitialImpulse { contact })?;
        }
        for (row, &r) in rows.iter().map(|(_, r)| r).enumerate() {
            check_finite(&SVector::from([r]), Input::InitialRowImpulse { row })?;
        }
        self.is_solved = false;
        self.contacts.set(contacts.iter().map(|&(key, r)| (key, r.into())));
        self.rows.set(rows.iter().map(|&(key, r)| (key, [r])));
        Ok(())
    }

    /// Is there no last solve?
    pub(super) fn is_cold(&self) -> bool {
        self.contacts.known().next().is_none() && self.rows.known().next().is_none()
    }

    /// Sorts the tables into the order of the next scene. Returns the old indices of its contacts and joint rows if any index has changed.
    pub(crate) fn follow<const N: usize, const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
    ) -> Option<EarlierIndices<C, R>> {
        let contacts = || scene.contacts().iter().map(|contact| contact.key);
        let rows = || scene.rows().iter().map(|row| row.key);
        let moved = self.contacts.is_out_of_order(contacts());
        let rows_moved = self.rows.is_out_of_order(rows());
        if self.is_cold() || !moved && !rows_moved {
            return None;
        }
        let mut earlier_indices = EarlierIndices { contacts: from_fn(|i| i), rows: from_fn(|j| j) };
        if moved {
            earlier_indices.contacts = self.contacts.reorder(contacts());
        }
        if rows_moved {
            earlier_indices.rows = self.rows.reorder(rows());
        }
        Some(earlier_indices)
    }

    /// Keeps `ũ` and `r` of a solve, given in scaled rows. If it `replaces` the last call, that call belongs to the same solve.
    pub(crate) fn keep<const N: usize, const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, R, S>,
        u: &Stacked<T, D, C, R>,
        r: &Stacked<T, D, C, R>,
        replaces: bool,
    ) {
        self.presumes_rest = false;
        for (i, contact, &u, &r) in zip4(0..C, scene.contacts(), &u.contacts, &r.contacts) {
            let (u, r) = (scene.physical_velocity(i, u), scene.physical_impulse(i, r));
            self.contacts.keep(i, contact.key, u, r, replaces);
        }
        for (j, row, &u, &r) in zip4(0..R, scene.rows(), &u.rows, &r.rows) {
            self.rows.keep(j, row.key, [u], [r], replaces);
        }
    }

    /// The keys of the joint rows of the last solve, in their order.
    pub(crate) fn row_keys(&self) -> impl Iterator<Item = u32> {
        self.rows.known().map(|entry| entry.key)
    }

    /// Did a joint row with this key push in the last solve?
    pub(crate) fn has_pushed(&self, key: u32) -> bool {
        let mut rows = self.rows.known();
        rows.any(|entry| entry.key == key && entry.r != [T::ZERO])
    }

    /// Fills `u` with `ũ` and `r` with the impulses of the last solve, in scaled rows. A new contact or joint row gets zeros.
    #[inline]
    pub(crate) fn recall<const N: usize, const S: usize>(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        u: &mut Stacked<T, D, C, R>,
        r: &mut Stacked<T, D, C, R>,
    ) {
        for (i, u, r, entry) in zip4(0..C, &mut u.contacts, &mut r.contacts, &self.contacts.entries) {
            let known = entry
                .as_ref()
                .map(|entry| (scene.scaled_velocity(i, entry.u), scene.scaled_impulse(i, entry.r)));
            (*u, *r) = known.unwrap_or(([T::ZERO; D], [T::ZERO; D]));
        }
        for (u, r, entry) in zip3(&mut u.rows, &mut r.rows, &self.rows.entries) {
            let known = entry.as_ref().map(|&Entry { u: [u], r: [r], .. }| (u, r));
            (*u, *r) = known.unwrap_or((T::ZERO, T::ZERO));
        }
    }

    /// Fills `r` with the last impulses, or the extrapolated ones if `onwards`, in scaled rows. A new contact or joint row keeps what it has.
    #[inline]
    pub(super) fn impulses<const N: usize, const S: usize>(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        onwards: bool,
        r: &mut Stacked<T, D, C, R>,
    ) {
        for (i, r, entry) in zip3(0..C, &mut r.contacts, &self.contacts.entries) {
            if let Some(entry) = entry {
                *r = scene.scaled_impulse(i, entry.impulse(onwards));
            }
        }
        for (r, entry) in r.rows.iter_mut().zip(&self.rows.entries) {
            if let Some(entry) = entry {
                [*r] = entry.impulse(onwards);
            }
        }
    }

    /// Did a contact push in the last solve?
    pub(super) fn has_contact_pushed(&self) -> bool {
        self.contacts.known().any(|entry| entry.solves > 0 && entry.r != [T::ZERO; D])
    }

    /// Do all `ũ` and `r` come from a solve? (Given impulses have no `ũ`.)
    pub(super) fn is_a_solution(&self) -> bool {
        self.contacts.known().all(|entry| entry.solves > 0) && self.rows.known().all(|entry| entry.solves > 0)
    }
}

#[cfg(test)]
mod tests;
