//! One time step: a scene, its factor and a free impulse, brought into contact space.

use crate::error::{Error, Input};
use crate::factor::Factor;
use crate::linalg::stacked::Stacked;
use crate::real::Real;
use crate::scene::{Scene, check_finite};
use crate::sets::contact::{expected, natural_map};
use crate::sets::energy::EnergyScale;
use crate::sets::{ContactSet, RowSet, Sets};
use crate::solution::{Model, Settings};
use core::cell::Cell;
use nalgebra::SVector;

mod infeasibility;
pub(crate) mod judge;

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
    pub(crate) model: Model,
    /// The free impulse, whitened.
    pub(crate) whitened: [T; N],
    pub(crate) sets: Sets<T, D, C, R>,
    /// `|r0|` (N·s): the impulses that contacts would take if each were alone.
    pub(crate) r0_norm: T,
    /// An upper bound on `|stop|²`, up to a constant factor.
    stopping_bound: T,
    /// Does `|stop|` count in the size?
    pub(crate) counts_stopping: bool,
    /// The larger of `|r0|` and `|stop|` (N·s): the expected size of the impulses of contacts, see [`natural_map`].
    pub(crate) reference_impulse: T,
    /// What [`expected::carried_impulse`] gives, once it was needed.
    carried: Cell<Option<T>>,
    /// Does nothing move a contact or a row, although it asks for another velocity?
    is_immovable_and_violated: bool,
    /// Are velocities those of a momentum, and not of `W`? See [`Self::velocities`].
    by_momentum: bool,
    /// What the error of joint rows is relative to, in a scene that is mixed.
    pub(crate) energy: EnergyScale<T>,
}

impl<'a, T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'a, T, N, D, C, R, S>
{
    /// Checks the data of a solve.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn check(
        scene: &Scene<T, N, D, C, R, S>,
        factor: &Factor<T, N, D, C, R>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<(), Error> {
        scene.check_complete()?;
        let tolerance = settings.tolerance;
        if !tolerance.is_finite() || tolerance < T::ZERO {
            return Err(Error::InvalidTolerance);
        }
        check_finite(free_impulse, Input::FreeImpulse)?;
        if !factor.is_current(scene) {
            return Err(Error::StaleFactor);
        }
        Ok(())
    }

    /// An empty problem of data that [`Self::check`] has accepted; [`Self::fill`] fills it. (Filled here and then moved, it
    /// would stand on the stack twice.)
    #[inline]
    pub(crate) fn new(
        scene: &'a Scene<T, N, D, C, R, S>,
        factor: &'a Factor<T, N, D, C, R>,
        free_impulse: &'a SVector<T, N>,
        model: Model,
    ) -> Self {
        Self {
            scene,
            factor,
            free_impulse,
            model,
            whitened: [T::ZERO; N],
            sets: Sets::of(scene.counts()),
            r0_norm: T::ZERO,
            stopping_bound: T::ZERO,
            counts_stopping: false,
            reference_impulse: T::ZERO,
            carried: Cell::new(None),
            is_immovable_and_violated: false,
            by_momentum: false,
            energy: EnergyScale::none(),
        }
    }

    /// The free motion and the sets. `may_use_momentum`: see [`Self::velocities`].
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn fill(&mut self, may_use_momentum: bool) {
        let (scene, factor) = (self.scene, self.factor);
        let [free_impulse] = &self.free_impulse.data.0;
        self.whitened.copy_from_slice(free_impulse); // an assignment might move what overlaps: `memmove`
        factor.whiten(&mut self.whitened);
        let mut moved = Stacked::zero();
        let energy = factor.contact_velocity(&self.whitened, &mut moved);
        let sources = scene.contacts().iter().zip(&moved.contacts);
        let places = self.sets.contacts_mut().iter_mut().zip(sources);
        for (i, (set, (contact, &moved))) in places.enumerate() {
            let offset: SVector<T, D> = scene.scale(i, contact.offset.into()).into();
            let q = offset + SVector::from(moved);
            *set = ContactSet::new(contact, self.model, factor.mean_effective_mass(i), q);
            let offset = expected::without_gap(&contact.offset);
            let offset = scene.scale(i, offset.into());
            self.stopping_bound += set.stopping_bound(&offset, energy);
            self.is_immovable_and_violated |= set.is_immovable_and_violated(&q);
        }
        let sources = scene.rows().iter().zip(&moved.rows);
        let places = self.sets.rows_mut().iter_mut().zip(sources);
        for (j, (set, (row, &moved))) in places.enumerate() {
            *set = RowSet::new(row, factor.row_effective_mass(j), row.offset + moved);
            self.is_immovable_and_violated |= set.is_immovable_and_violated;
        }
        self.r0_norm = natural_map::r0_norm(self.sets.contacts());
        self.reference_impulse = self.r0_norm;
        if may_use_momentum && self.may_be_hyperstatic() {
            self.by_momentum = true;
            let sources = scene.contacts().iter().enumerate();
            for (set, (i, contact)) in self.sets.contacts_mut().iter_mut().zip(sources) {
                set.base = scene.scale(i, contact.offset.into()).into();
            }
            for (set, row) in self.sets.rows_mut().iter_mut().zip(scene.rows()) {
                set.base = row.offset;
            }
        }
        if self.scene.is_mixed() {
            self.energy = EnergyScale::new(&self.sets, energy);
        }
    }

    /// Is it hyperstatic: have contacts and joint rows that hold with these impulses rows >= moved dofs + D? Then impulses are far
    /// from unique: they can change without moving a body.
    pub(crate) fn is_hyperstatic(&self, r: &Stacked<T, D, C, R>) -> bool {
        self.is_redundant(self.sets.holding_rows(r))
    }

    /// May it be hyperstatic, if all contacts and rows push?
    pub(crate) fn may_be_hyperstatic(&self) -> bool {
        self.is_redundant(self.sets.pushing_rows())
    }

    /// Are there more rows than dofs, so that impulses may change without moving a body? Then Coulomb's law may have a second solution.
    pub(crate) fn may_be_redundant(&self) -> bool {
        self.sets.pushing_rows() > self.factor.moved()
    }

    /// Is rows >= moved dofs + D?
    pub(crate) fn is_redundant(&self, rows: usize) -> bool {
        rows >= self.factor.moved().saturating_add(D)
    }

    /// Is an impulse asked for that has lost digits at the end of the range, or vanished?
    fn loses_digits(&self) -> bool {
        self.reference_impulse * T::EPSILON < T::least_normal() && self.needs_impulses()
    }

    /// Is any impulse of a contact asked for?
    #[cfg_attr(target_os = "none", inline(never))]
    fn needs_impulses(&self) -> bool {
        let mut contacts = self.sets.contacts().iter();
        contacts.any(|set| set.is_violated(&set.q))
    }

    /// Cheap upper bound: could counting `|stop|` bring this natural map within tolerance? Computing `|stop|` costs a sweep,
    /// so it is postponed; until it counts, the error is at most too large, unless it [expects none](Self::expects_none_of).
    ///
    /// `|H_i v|² <= trace(W_ii) v·M v` for the free motion, four times as much because `abs` is taken entry by entry.
    pub(crate) fn may_be_within(&self, natural_map: T, tolerance: T) -> bool {
        let four = T::literal(4.0 * expected::SHARE);
        let residual = natural_map * self.reference_impulse;
        !self.counts_stopping
            && residual * residual <= self.stopping_bound * (four * tolerance) * (four * tolerance)
    }

    /// Is there an impulse where none is expected: no contact would take one if it were alone, and `|stop|` does not count yet? The size of
    /// such impulses would be judged by nothing but themselves.
    pub(crate) fn expects_none_of(&self, r: &Stacked<T, D, C, R>) -> bool {
        self.r0_norm == T::ZERO && !self.counts_stopping && !self.sets.are_at_rest(r)
    }

    /// Counts `|stop|` in the expected size of the impulses.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn count_stopping(&mut self) {
        let mut free = [T::ZERO; N];
        self.factor
            .velocity(&self.whitened, &Stacked::zero(), &mut free);
        let stopping = expected::stopping_impulse(self.scene, self.sets.contacts(), &free);
        self.reference_impulse = self.r0_norm.max(stopping);
        self.counts_stopping = true;
    }

    /// Fills `u = W r + q`.
    ///
    /// Impulses of a hyperstatic scene can change without moving anything. Rounding of `W r + q` asks for such changes, tick
    /// by tick, until a body at rest has carried its internal forces to the boundaries of their cones. So in such a scene `u` is
    /// `H M⁻¹ (Hᵀ r + p) + w`: all contacts see the motion of one momentum, which is rounded once, and where nothing moves
    /// nothing is left to be rounded. With more rows than dofs that costs no more.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn velocities(&self, r: &Stacked<T, D, C, R>, u: &mut Stacked<T, D, C, R>) {
        if self.by_momentum {
            self.factor.impulse_velocity(&self.whitened, r, u);
            for (i, (u, r)) in u.contacts.iter_mut().zip(&r.contacts).enumerate() {
                if let Some(scaling) = self.scene.scaling(i) {
                    for ((u, &r), &compliance) in u.iter_mut().zip(r).zip(&scaling.compliance) {
                        *u += compliance * r;
                    }
                }
            }
            self.scene.add_row_compliance(&r.rows, &mut u.rows);
        } else {
            self.factor.delassus().times(r, u, self.sets.counts());
        }
        for (u, set) in u.contacts.iter_mut().zip(self.sets.contacts()) {
            for (u, &base) in u.iter_mut().zip(set.base.iter()) {
                *u += base;
            }
        }
        for (u, set) in u.rows.iter_mut().zip(self.sets.rows()) {
            *u += set.base;
        }
    }

    /// [`Self::velocities`] of the impulses nearest to 0.
    pub(crate) fn velocities_at_rest(&self, r: &Stacked<T, D, C, R>, u: &mut Stacked<T, D, C, R>) {
        if self.by_momentum || r.rows.iter().any(|&r| r != T::ZERO) {
            self.velocities(r, u);
            return;
        }
        self.sets.copy_bases(u);
    }

    /// [`Self::velocities`]; returns the first part of the error.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn natural_map(&self, r: &Stacked<T, D, C, R>, u: &mut Stacked<T, D, C, R>) -> T {
        self.velocities(r, u);
        self.natural_map_at(r, u)
    }

    /// First part of the error, from `u = W r + q`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn natural_map_at(&self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) -> T {
        if self.is_immovable_and_violated {
            return T::INFINITY;
        }
        let contacts = self.contact_error(u, r, &[]);
        if R > 0 && self.scene.is_mixed() {
            return self.energy.larger_error(contacts, &self.sets, (u, r), None);
        }
        contacts
    }

    /// The error of contacts, with bounds on the rounding of velocities.
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
                let sets = (self.sets.contacts(), self.sets.rows());
                let carried = expected::carried_impulse(self.scene, sets, free);
                self.carried.set(Some(carried));
                carried
            })
        };
        self.sets
            .contact_error(self.reference_impulse, u, r, noise, &carried)
    }

    /// Are impulses more than so many times as large as expected?
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn exceeds(&self, r: &Stacked<T, D, C, R>, times: T) -> bool {
        if self.scene.is_mixed() {
            return self.energy.ratio(&self.sets, r) > times;
        }
        let bound = self.reference_impulse * times;
        r.contact_square() > bound * bound
    }

    /// The impulse to expect of a contact, and that of a joint row.
    pub(crate) fn expected(&self, alpha: T) -> T {
        if self.scene.is_mixed() {
            self.energy.expected(alpha)
        } else {
            self.reference_impulse
        }
    }

    /// Gauss-Seidel solves Coulomb's law, and its relaxation with up to two tangents.
    pub(crate) fn can_be_swept(&self) -> bool {
        self.model == Model::Coulomb || D <= 3
    }
}

#[cfg(test)]
mod tests;
