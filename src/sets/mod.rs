//! The sets that impulses lie in: friction cones of contacts, intervals of joint rows.
//!
//! A solver asks both kinds of set for the same list of quantities. The files of this folder compute them for all sets of a scene,
//! the folders `contact` and `row` for one set. [`crate::guide::error`] explains the natural map, the augmented velocity and the De
//! Saxcé shift, [`crate::guide::method`] the sweeps, the linearisation and the central path.
//!
//! | quantity | contact (cone, De Saxcé shift) | joint row (interval) |
//! |---|---|---|
//! | nearest impulse, natural map, mode | `contact`, `contact::natural_map` | `row` |
//! | augmented velocity `û` | `u + mu \|u_T\| e_N` | `u` |
//! | impulse while the others are held (`sweep`) | `contact::coulomb_sweep`, `contact::relaxed_sweep` | `row` |
//! | linearisation (`jacobian`) | `contact::frame` | holds or not |
//! | central path (`pairs`, `path_system`) | `contact::pair` | `row::pair` |
//! | unknowns and equations of both (`assembly`) | `Linear` | one of each |
//! | denominator of its error | `contact::natural_map`, `contact::expected` | `energy` |

use crate::cone::add_to_normal;
use crate::linalg::stacked::{Counts, Stacked};
use crate::linalg::vector::square;
use crate::linalg::zip::{zip3, zip4, zip5};
use crate::real::Real;
use contact::natural_map;

mod assembly;
pub(crate) mod contact;
pub(crate) mod energy;
pub(crate) mod jacobian;
pub(crate) mod pairs;
pub(crate) mod path_system;
pub(crate) mod point;
pub(crate) mod row;
pub(crate) mod sweep;

pub(crate) use contact::ContactSet;
pub(crate) use row::RowSet;

/// The sets of all contacts and joint rows of a solve.
#[derive(Clone, Debug)]
pub(crate) struct Sets<T: Real, const D: usize, const C: usize, const R: usize> {
    contacts: [ContactSet<T, D>; C],
    rows: [RowSet<T>; R],
    counts: Counts,
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Sets<T, D, C, R> {
    /// Empty sets for as many contacts and joint rows as `counts` says.
    pub(crate) const fn of(counts: Counts) -> Self {
        Self { contacts: [ContactSet::none(); C], rows: [RowSet::none(); R], counts }
    }

    /// Numbers of contacts and joint rows in use.
    pub(crate) const fn counts(&self) -> Counts {
        self.counts
    }

    /// Sets of the contacts in use.
    #[inline]
    pub(crate) fn contacts(&self) -> &[ContactSet<T, D>] {
        self.contacts.get(..self.counts.contacts).unwrap_or_default()
    }

    /// Sets of the contacts in use, mutable.
    #[inline]
    pub(crate) fn contacts_mut(&mut self) -> &mut [ContactSet<T, D>] {
        let used = self.contacts.get_mut(..self.counts.contacts);
        used.unwrap_or_default()
    }

    /// Sets of the joint rows in use.
    #[inline]
    pub(crate) fn rows(&self) -> &[RowSet<T>] {
        self.rows.get(..self.counts.rows).unwrap_or_default()
    }

    /// Sets of the joint rows in use, mutable.
    #[inline]
    pub(crate) fn rows_mut(&mut self) -> &mut [RowSet<T>] {
        self.rows.get_mut(..self.counts.rows).unwrap_or_default()
    }

    /// Copies the constant terms of the velocities, see [`ContactSet::base`].
    pub(crate) fn copy_bases(&self, bases: &mut Stacked<T, D, C, R>) {
        for (base, set) in bases.contacts.iter_mut().zip(self.contacts()) {
            *base = set.base.into();
        }
        for (base, set) in bases.rows.iter_mut().zip(self.rows()) {
            *base = set.base;
        }
    }

    /// Replaces the constant terms of the velocities, see [`ContactSet::base`].
    pub(crate) fn set_bases(&mut self, bases: &Stacked<T, D, C, R>) {
        for (set, &base) in self.contacts_mut().iter_mut().zip(&bases.contacts) {
            set.base = base.into();
        }
        for (set, &base) in self.rows_mut().iter_mut().zip(&bases.rows) {
            set.base = base;
        }
    }

    /// Number of rows along which impulses may act: `D` for a contact with friction, 1 for a frictionless contact, 1 for a joint row.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn pushing_rows(&self) -> usize {
        let contacts = self.contacts().iter().map(ContactSet::pushing_rows);
        contacts.sum::<usize>() + self.counts.rows
    }

    /// The rows whose impulses are unknown near the impulses `r`: those of contacts that push, and the joint rows between their bounds. (The
    /// impulse of a row at its bound is known.)
    pub(crate) fn holding(&self, r: &Stacked<T, D, C, R>) -> Stacked<bool, D, C, R> {
        let mut holding = Stacked { contacts: [[false; D]; C], rows: [false; R] };
        for (holding, set, r) in zip3(&mut holding.contacts, self.contacts(), &r.contacts) {
            let rows = if *r == [T::ZERO; D] { 0 } else { set.pushing_rows() };
            holding.iter_mut().take(rows).for_each(|holds| *holds = true);
        }
        for (holds, set, &r) in zip3(&mut holding.rows, self.rows(), &r.rows) {
            *holds = set.holds(r);
        }
        holding
    }

    /// Number of [`Self::holding`] rows.
    pub(crate) fn holding_rows(&self, r: &Stacked<T, D, C, R>) -> usize {
        self.holding(r).iter().filter(|&&holds| holds).count()
    }

    /// [`Self::holding_rows`], but one row for a contact that slips: its friction follows from its normal impulse.
    pub(crate) fn free_rows(&self, r: &Stacked<T, D, C, R>) -> usize {
        let contacts = self.contacts().iter().zip(&r.contacts);
        let slipping = contacts.filter(|(set, r)| set.slips(r)).count();
        self.holding_rows(r) - slipping * (D - 1)
    }

    /// Replaces impulses by the nearest ones in the sets.
    pub(crate) fn project(&self, r: &mut Stacked<T, D, C, R>) {
        for (r, set) in r.contacts.iter_mut().zip(self.contacts()) {
            *r = set.cone.nearest(&(*r).into()).into();
        }
        for (r, set) in r.rows.iter_mut().zip(self.rows()) {
            *r = set.project(*r);
        }
    }

    /// Square of the norm of the impulses of contacts.
    #[inline]
    pub(crate) fn contact_square(&self, r: &Stacked<T, D, C, R>) -> T {
        let used = r.contacts.get(..self.counts.contacts).unwrap_or_default();
        used.iter().fold(T::ZERO, |sum, r| sum + square(r))
    }

    /// Is each impulse the one nearest to 0 in its set?
    pub(crate) fn are_least(&self, r: &Stacked<T, D, C, R>) -> bool {
        let mut contacts = r.contacts.iter().take(self.counts.contacts);
        let mut rows = self.rows().iter().zip(&r.rows);
        contacts.all(|r| *r == [T::ZERO; D]) && rows.all(|(set, &r)| r == set.project(T::ZERO))
    }

    /// Fills the augmented velocities `û`.
    pub(crate) fn augment(&self, u: &Stacked<T, D, C, R>, augmented: &mut Stacked<T, D, C, R>) {
        for (augmented, &u, set) in zip3(&mut augmented.contacts, &u.contacts, self.contacts()) {
            *augmented = set.augmented(&u.into()).into();
        }
        augmented.rows = u.rows;
    }

    /// Fills `z_i = P_i - r_i / alpha_i`, the inverse of [`Self::split`].
    pub(crate) fn join(&self, p: &Stacked<T, D, C, R>, r: &Stacked<T, D, C, R>, z: &mut Stacked<T, D, C, R>) {
        for (z, velocity, impulse, set) in zip4(&mut z.contacts, &p.contacts, &r.contacts, self.contacts()) {
            *z = *velocity;
            if set.alpha > T::ZERO {
                let scale = T::ONE / set.alpha;
                for (z, &impulse) in z.iter_mut().zip(impulse) {
                    *z -= impulse * scale;
                }
            }
        }
        for (z, &velocity, &impulse, set) in zip4(&mut z.rows, &p.rows, &r.rows, self.rows()) {
            *z = velocity;
            if set.alpha > T::ZERO {
                *z -= impulse / set.alpha;
            }
        }
    }

    /// Splits `z_i = P_i - r_i / alpha_i` into a velocity `P_i` and an impulse `r_i` that are complementary (Moreau), and fills the
    /// residual with `S - P`.
    pub(crate) fn split(
        &self,
        z: &Stacked<T, D, C, R>,
        p: &mut Stacked<T, D, C, R>,
        r: &mut Stacked<T, D, C, R>,
        residual: &mut Stacked<T, D, C, R>,
    ) {
        for (set, &z, velocity, impulse, residual) in
            zip5(self.contacts(), &z.contacts, &mut p.contacts, &mut r.contacts, &mut residual.contacts)
        {
            let z = z.into();
            let (projection, slip) = set.cone.dual().project_with_length(&z);
            *velocity = projection.into();
            *impulse = ((projection - z) * set.alpha).into();
            let mut shifted = -projection;
            add_to_normal(&mut shifted, set.shift_factor * slip);
            *residual = shifted.into();
        }
        for (set, &z, velocity, impulse, residual) in
            zip5(self.rows(), &z.rows, &mut p.rows, &mut r.rows, &mut residual.rows)
        {
            *impulse = set.project(-z * set.alpha);
            // The velocity of a row between its bounds is exactly 0.
            *velocity = if set.holds(*impulse) {
                T::ZERO
            } else if set.alpha > T::ZERO {
                z + *impulse / set.alpha
            } else {
                z
            };
            *residual = -*velocity;
        }
    }

    /// Merit function `Σ alpha_i |E_i|²`. It is an energy and not its root, so a power of two as a unit changes exponents alone.
    pub(crate) fn merit(&self, residual: &Stacked<T, D, C, R>) -> T {
        let contacts = self.contacts().iter().zip(&residual.contacts);
        let merit = contacts.fold(T::ZERO, |sum, (set, e)| sum + set.alpha * square(e));
        let rows = self.rows().iter().zip(&residual.rows);
        rows.fold(merit, |sum, (set, &e)| sum + set.alpha * (e * e))
    }

    /// First part of the error, see [`natural_map::error`].
    #[inline]
    pub(crate) fn contact_error(
        &self,
        size: T,
        u: &Stacked<T, D, C, R>,
        r: &Stacked<T, D, C, R>,
        noise: &[[T; 2]],
        carried: &dyn Fn() -> T,
    ) -> T {
        natural_map::error(self.contacts(), size, &u.contacts, &r.contacts, noise, carried)
    }
}
