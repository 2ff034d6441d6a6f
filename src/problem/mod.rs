//! One time step in contact space: the data of a solve, and the sets of its contacts and joint rows.

use crate::error::{Error, Input};
use crate::factor::Factor;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::add;
use crate::linalg::zip::{zip3, zip4};
use crate::real::Real;
use crate::scene::{Scene, check_entries};
use crate::sets::contact::{expected, natural_map};
use crate::sets::energy::EnergyScale;
use crate::sets::{ContactSet, RowSet, Sets};
use crate::solution::{Model, Settings};
use core::cell::Cell;
use nalgebra::SVector;

mod expected_size;
mod hyperstatic;
mod infeasibility;
pub(crate) mod judge;

/// Was the factor computed for this solve, or for an earlier one? In the memory of an old factor a bit may have flipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Age {
    New = 0, // so that a new solver is all zeros, and takes no flash
    Old = 1,
}

/// The data of one solve.
pub(crate) struct Problem<
    'a,
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
> {
    pub(crate) scene: &'a Scene<T, N, D, C, R, S>,
    pub(crate) factor: &'a Factor<T, N, D, C, R>,
    /// `p = M v_free`, minus the `f` of the note.
    pub(crate) free_impulse: &'a SVector<T, N>,
    /// The law that a solution has to obey.
    pub(crate) model: Model,
    /// The law that is solved at present: `model`, or the relaxation while bodies may stay at rest (`src/solver/rest`).
    law: Model,
    /// [`Settings::still`] (m/s).
    pub(crate) still: T,
    pub(crate) factor_age: Age,
    /// The whitened free impulse: `p` multiplied by the inverse Cholesky factor of `M`.
    pub(crate) whitened: [T; N],
    /// `pᵀ M⁻¹ p`, twice the kinetic energy of the free motion.
    pub(crate) free_energy: T,
    pub(crate) sets: Sets<T, D, C, R>,
    /// `|r0|` (N·s), see [`crate::guide::error`].
    pub(crate) r0_norm: T,
    /// Estimate of `|stop|²` from above, up to a constant factor, see [`Problem::may_be_within`].
    stopping_bound: T,
    /// Is `|stop|` included in `expected_size`?
    pub(crate) counts_stopping: bool,
    /// Expected impulse of all contacts (N·s): `|r0|`, or the larger of `|r0|` and `|stop|`.
    pub(crate) expected_size: T,
    /// Result of [`Scene::carried_impulse`], once it was computed.
    carried: Cell<Option<T>>,
    /// Is there a contact or a joint row that nothing moves, although its law is violated?
    is_immovable_and_violated: bool,
    /// Are velocities computed from one momentum, and not by `W`? See [`Self::velocities`].
    by_momentum: bool,
    /// The scale of the error of joint rows; used in a mixed scene alone.
    pub(crate) energy: EnergyScale<T>,
}

impl<'a, T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'a, T, N, D, C, R, S>
{
    /// Checks the data of a solve.
    pub(crate) fn check(
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<(), Error> {
        scene.check_complete()?;
        settings.check()?;
        check_entries::<T, N>(scene.used(free_impulse, 1), Input::FreeImpulse)?;
        if !factor.is_current(scene) {
            return Err(Error::StaleFactor);
        }
        Ok(())
    }

    /// Fingerprint of all data of a solve.
    pub(crate) fn fingerprint(
        scene: &Scene<T, N, D, C, R, S>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> u64 {
        let hash = settings.tolerance.hash(u64::from(settings.model == Model::Coulomb));
        let free_impulse = scene.used(free_impulse, 1).iter();
        scene.data_fingerprint(free_impulse.fold(hash, |hash, entry| entry.hash(hash)))
    }

    /// A problem of data that [`Self::check`] has accepted, to be filled by [`Self::fill`]. (A filled problem, returned by value,
    /// would take its size on the stack twice.)
    #[inline]
    pub(crate) fn new(
        scene: &'a Scene<T, N, D, C, R, S>,
        factor: &'a Factor<T, N, D, C, R>,
        free_impulse: &'a SVector<T, N>,
        &Settings { model, still, .. }: &Settings<T>,
        factor_age: Age,
    ) -> Self {
        Self {
            scene,
            factor,
            free_impulse,
            model,
            law: model,
            still,
            factor_age,
            whitened: [T::ZERO; N],
            free_energy: T::ZERO,
            sets: Sets::of(scene.counts()),
            r0_norm: T::ZERO,
            stopping_bound: T::ZERO,
            counts_stopping: false,
            expected_size: T::ZERO,
            carried: Cell::new(None),
            is_immovable_and_violated: false,
            by_momentum: false,
            energy: EnergyScale::none(),
        }
    }

    /// Computes the free motion and the sets. `may_use_momentum` allows velocities from one momentum, see [`Self::velocities`].
    pub(crate) fn fill(&mut self, may_use_momentum: bool) {
        let (scene, factor) = (self.scene, self.factor);
        let [free_impulse] = &self.free_impulse.data.0;
        self.whitened.copy_from_slice(free_impulse); // an assignment of the array might call `memmove`
        factor.whiten(&mut self.whitened);
        let mut moved = Stacked::zero();
        let energy = factor.contact_velocity(&self.whitened, &mut moved);
        self.free_energy = energy;
        let sets = self.sets.contacts_mut();
        for (i, set, contact, &moved) in zip4(0..C, sets, scene.contacts(), &moved.contacts) {
            let q = scene.scaled_velocity(i, contact.offset) + SVector::from(moved);
            *set = ContactSet::new(contact, self.model, factor.mean_effective_mass(i), q);
            let offset = scene.scaled_velocity(i, expected::without_gap(&contact.offset));
            self.stopping_bound += set.stopping_bound(&offset.into(), energy);
            self.is_immovable_and_violated |= set.is_immovable_and_violated(&q);
        }
        for (j, set, row, &moved) in zip4(0..R, self.sets.rows_mut(), scene.rows(), &moved.rows) {
            *set = RowSet::new(row, factor.row_effective_mass(j), row.offset + moved);
            self.is_immovable_and_violated |= set.is_immovable_and_violated;
        }
        self.r0_norm = natural_map::r0_norm(self.sets.contacts());
        self.expected_size = self.r0_norm;
        if may_use_momentum && self.may_be_hyperstatic() {
            self.by_momentum = true;
            for (i, set, contact) in zip3(0..C, self.sets.contacts_mut(), scene.contacts()) {
                set.base = scene.scaled_velocity(i, contact.offset);
            }
            for (set, row) in self.sets.rows_mut().iter_mut().zip(scene.rows()) {
                set.base = row.offset;
            }
        }
        if self.scene.is_mixed() {
            self.energy = EnergyScale::new(&self.sets, energy);
        }
    }

    /// Solves this law from now on. Only if the model is Coulomb's law.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn set_law(&mut self, law: Model) {
        self.law = law;
        for set in self.sets.contacts_mut() {
            set.set_law(law);
        }
    }

    /// Is the relaxation solved in place of Coulomb's law?
    pub(crate) fn is_relaxed(&self) -> bool {
        self.law != self.model
    }

    /// [`Self::error_estimate`] by another law than the one that is solved. Only if the model is Coulomb's law.
    pub(crate) fn estimate_by(&mut self, law: Model, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) -> T {
        let solved = self.law;
        self.set_law(law);
        let estimate = self.error_estimate(r, u);
        self.set_law(solved);
        estimate
    }

    /// Fills `u` with the velocities `W r + q` of contacts and joint rows.
    ///
    /// Impulses of a hyperstatic scene can change without moving a body. Rounding of `W r + q` causes such changes in each tick, until
    /// the internal forces of a body at rest reach the boundaries of their cones. So in such a scene `u` is computed as
    /// `H M⁻¹ (Hᵀ r + p) + w`: one momentum, rounded once, moves all contacts, and a body without momentum moves none. With more rows
    /// than dofs that costs no more.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn velocities(&self, r: &Stacked<T, D, C, R>, u: &mut Stacked<T, D, C, R>) {
        if self.by_momentum {
            self.factor.impulse_velocity(&self.whitened, r, u);
            for (i, u, r) in zip3(0..C, &mut u.contacts, &r.contacts) {
                if let Some(scaling) = self.scene.scaling(i) {
                    for (u, &r, &compliance) in zip3(u, r, &scaling.compliance) {
                        *u += compliance * r;
                    }
                }
            }
            self.scene.add_row_compliance(&r.rows, &mut u.rows);
        } else {
            self.factor.delassus().times(r, u, self.sets.counts());
        }
        for (u, set) in u.contacts.iter_mut().zip(self.sets.contacts()) {
            add(u, set.base.as_slice());
        }
        for (u, set) in u.rows.iter_mut().zip(self.sets.rows()) {
            *u += set.base;
        }
    }

    /// [`Self::velocities`] for zero impulses, or the least ones of joint rows.
    pub(crate) fn velocities_of_least(&self, r: &Stacked<T, D, C, R>, u: &mut Stacked<T, D, C, R>) {
        if self.by_momentum || r.rows.iter().any(|&r| r != T::ZERO) {
            self.velocities(r, u);
            return;
        }
        self.sets.copy_bases(u);
    }

    /// Fills `u` by [`Self::velocities`], and returns [`Self::error_estimate`] there.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn velocities_and_estimate(&self, r: &Stacked<T, D, C, R>, u: &mut Stacked<T, D, C, R>) -> T {
        self.velocities(r, u);
        self.error_estimate(r, u)
    }

    /// Estimate of the error in contact space, from `u = W r + q`: the parts of contacts and joint rows, without momentum and rounding.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn error_estimate(&self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) -> T {
        if self.is_immovable_and_violated {
            return T::INFINITY;
        }
        let contacts = self.contact_error(u, r, &[]);
        if R > 0 && self.scene.is_mixed() {
            return self.energy.larger_error(contacts, &self.sets, (u, r), None);
        }
        contacts
    }

    /// First part of the error, that of contacts. `noise` has bounds on the rounding of velocities, see
    /// [`natural_map::error`].
    #[inline]
    pub(crate) fn contact_error(
        &self,
        u: &Stacked<T, D, C, R>,
        r: &Stacked<T, D, C, R>,
        noise: &[[T; 2]],
    ) -> T {
        let carried = || {
            self.carried.get().unwrap_or_else(|| {
                let [free] = &self.free_impulse.data.0;
                let carried = self.scene.carried_impulse(&self.sets, free);
                self.carried.set(Some(carried));
                carried
            })
        };
        self.sets.contact_error(self.expected_size, u, r, noise, &carried)
    }

    /// Can Gauss-Seidel sweeps solve the problem? They solve Coulomb's law, and the relaxation with up to two tangents.
    pub(crate) fn can_be_swept(&self) -> bool {
        self.model == Model::Coulomb || D <= 3
    }
}

#[cfg(test)]
mod tests;
