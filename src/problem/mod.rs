//! One time step: a scene, its factor and a free impulse, brought into contact space.

use crate::cone::square;
use crate::laws::{Coulomb, Laws, Room};
use crate::linalg::blocks::{ContactVector, block};
use crate::linalg::hints::{opaque, opaque_mut, rolled};
use crate::scene::check_finite;
use crate::{Contact, Error, Factor, FrictionCone, Input, Model, Real, Scene, Settings};
pub(crate) use contact_law::ContactLaw;
use energies::Energies;
use nalgebra::SVector;

mod contact_law;
mod dynamics;
pub(crate) mod energies;
mod evaluation;
pub(crate) mod infeasibility;
mod proof_search;
pub(crate) mod residual;
pub(crate) mod rounding;
pub(crate) mod row_laws;
mod slots;

/// The data of one solve.
pub(crate) struct Problem<
    'a,
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    L: Laws = Coulomb,
> {
    pub(crate) scene: &'a Scene<T, N, D, C, L>,
    pub(crate) factor: &'a Factor<T, N, D, C, L>,
    /// `p = M v_free`, minus the `f` of the note.
    pub(crate) free_impulse: &'a SVector<T, N>,
    pub(crate) model: Model,
    /// The free impulse, whitened.
    pub(crate) whitened: [T; N],
    laws: [ContactLaw<T, D, L>; C],
    /// `|r0|` (N·s): the impulses that contacts would take if each were alone.
    pub(crate) alone: T,
    /// An upper bound on `|stop|²`, up to a constant factor.
    stopping_bound: T,
    /// Does `|stop|` count in the size?
    pub(crate) counts_stopping: bool,
    /// The larger of `|r0|` and `|stop|` (N·s): the expected size of the impulses, see [`residual`].
    pub(crate) size: T,
    /// Does nothing move a contact or a row, although it asks for another velocity?
    is_hopeless: bool,
    /// Are velocities those of a momentum, and not of `W`? See [`Self::velocities`].
    by_momentum: bool,
    /// What the error of joint rows is relative to.
    pub(crate) energies: L::Room<Energies<T>>,
}

impl<'a, T: Real, const N: usize, const D: usize, const C: usize, L: Laws>
    Problem<'a, T, N, D, C, L>
{
    /// Checks the data of a solve.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn check(
        scene: &Scene<T, N, D, C, L>,
        factor: &Factor<T, N, D, C, L>,
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<(), Error> {
        let tolerance = settings.tolerance;
        if !tolerance.is_finite() || tolerance < T::ZERO {
            return Err(Error::InvalidTolerance);
        }
        check_finite(free_impulse, Input::FreeImpulse)?;
        if !factor.is_current(scene) {
            return Err(Error::StaleFactor);
        }
        let invalid = |contact: &Contact<T, N, D>| !FrictionCone::is_valid(contact.mu);
        match opaque(scene.contacts()).iter().position(invalid) {
            Some(contact) => Err(Error::InvalidFriction { contact }),
            None => Ok(()),
        }
    }

    /// An empty problem of data that [`Self::check`] has accepted; [`Self::fill`] fills it. (Filled here and then moved, it
    /// would stand on the stack twice.)
    #[inline]
    pub(crate) fn new(
        scene: &'a Scene<T, N, D, C, L>,
        factor: &'a Factor<T, N, D, C, L>,
        free_impulse: &'a SVector<T, N>,
        model: Model,
    ) -> Self {
        Self {
            scene,
            factor,
            free_impulse,
            model,
            whitened: [T::ZERO; N],
            laws: [ContactLaw::none(); C],
            alone: T::ZERO,
            stopping_bound: T::ZERO,
            counts_stopping: false,
            size: T::ZERO,
            is_hopeless: false,
            by_momentum: false,
            energies: L::Room::EMPTY,
        }
    }

    /// The free motion and the laws of the contacts. `may_use_momentum`: see [`Self::velocities`].
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn fill(&mut self, may_use_momentum: bool) {
        let factor = self.factor;
        let [free_impulse] = self.free_impulse.data.0;
        self.whitened = free_impulse;
        factor.whiten(&mut self.whitened);
        let mut moved = [[T::ONE; D]; C];
        let energy = factor.contact_velocity(&self.whitened, &mut moved);
        let sources = opaque(self.scene.contacts()).iter().zip(&moved);
        let pairs = opaque_mut(&mut self.laws).iter_mut().zip(sources);
        for (i, (law, (contact, &moved))) in pairs.enumerate() {
            rolled();
            *law = ContactLaw::new(
                contact,
                self.model,
                factor.natural_map_step(i),
                moved.into(),
            );
            if let (Some(slot), Some(scales)) = (self.scene.slot(i), factor.scales(i)) {
                let own = block(factor.delassus(), i, i).unwrap_or([[T::ZERO; D]; D]);
                let scales = (scales, self.scene.reference_mass());
                law.take(slot, scales, &own, contact.offset, moved.into());
                if let Some(rows) = law.rows.get() {
                    self.is_hopeless |= rows.is_hopeless;
                    continue;
                }
            }
            self.is_hopeless |= law.is_hopeless_at(&law.q);
            let offset = factor.scaled(i, residual::without_gap(&contact.offset));
            let moves = T::count(D) * energy + law.alpha * square(offset.as_slice());
            self.stopping_bound += law.alpha * moves;
        }
        self.alone = residual::alone(self.laws());
        self.size = self.alone;
        if may_use_momentum && self.may_be_hyperstatic() {
            self.by_momentum = true;
            let sources = self.scene.contacts().iter().enumerate();
            for (law, (i, contact)) in self.laws.iter_mut().zip(sources) {
                law.base = factor.scaled(i, contact.offset);
            }
        }
        if self.scene.is_mixed() {
            let energies = Energies::new(self.laws(), energy, self.scene.reference_mass());
            self.energies = L::Room::with(energies);
        }
    }

    /// Cheap upper bound: could counting `|stop|` bring this natural map within tolerance? Computing `|stop|` costs a sweep,
    /// so it is postponed; until it counts, the error is at most too large.
    ///
    /// `|H_i v|² <= trace(W_ii) v·M v` for the free motion, four times as much because `abs` is taken entry by entry.
    pub(crate) fn may_be_within(&self, natural_map: T, tolerance: T) -> bool {
        let four = T::literal(4.0 * residual::SHARE);
        let residual = natural_map * self.size;
        !self.counts_stopping
            && residual * residual <= self.stopping_bound * (four * tolerance) * (four * tolerance)
    }

    /// Counts `|stop|` in the expected size of the impulses.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn count_stopping(&mut self) {
        let mut free = [T::ZERO; N];
        self.factor.velocity(&self.whitened, &[], &mut free);
        let stopping = residual::stopping(self.scene, self.laws(), &free);
        self.size = self.alone.max(stopping);
        self.counts_stopping = true;
    }

    /// The contacts in use.
    #[inline]
    pub(crate) fn laws(&self) -> &[ContactLaw<T, D, L>] {
        let laws = self.laws.get(..self.factor.contacts());
        laws.unwrap_or_default()
    }

    /// Fills `u = W r + q`.
    ///
    /// Impulses of a hyperstatic scene can change without moving anything. Rounding of `W r + q` asks for such changes, tick
    /// by tick, until a body at rest has carried its internal forces to the boundaries of their cones. So in such a scene `u` is
    /// `H M⁻¹ (Hᵀ r + p) + w`: all contacts see the motion of one momentum, which is rounded once, and where nothing moves
    /// nothing is left to be rounded. With more rows than dofs that costs no more.
    #[cfg_attr(target_os = "none", inline(never))]
    fn velocities(&self, r: &[[T; D]], u: &mut [[T; D]]) {
        if self.by_momentum {
            self.factor.impulse_velocity(&self.whitened, r, u);
            for (i, (u, r)) in u.iter_mut().zip(r).enumerate() {
                if let (Some(slot), Some(scales)) = (self.scene.slot(i), self.factor.scales(i)) {
                    slot.comply(scales, r, u);
                }
            }
        } else {
            self.factor.delassus_times(r, u);
        }
        for (u, law) in u.iter_mut().zip(opaque(self.laws())) {
            rolled();
            for (u, &base) in u.iter_mut().zip(law.base.iter()) {
                *u += base;
            }
        }
    }

    /// Velocities without impulses, `q`, with its corrections.
    pub(crate) fn free_velocities(&self, u: &mut ContactVector<T, D, C>) {
        let contacts = ..self.factor.contacts();
        let none = [[T::ZERO; D]; C];
        let none = none.get(contacts).unwrap_or_default();
        self.velocities(none, u.get_mut(contacts).unwrap_or_default());
    }

    /// [`Self::velocities`]; returns the first part of the error.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn natural_map(
        &self,
        r: &ContactVector<T, D, C>,
        u: &mut ContactVector<T, D, C>,
    ) -> T {
        let contacts = ..self.factor.contacts();
        let r = opaque(r.get(contacts).unwrap_or_default());
        let u = opaque_mut(u.get_mut(contacts).unwrap_or_default());
        self.velocities(r, u);
        self.natural_map_at(r, u)
    }

    /// First part of the error, from `u = W r + q`.
    #[inline]
    pub(crate) fn natural_map_at(&self, r: &[[T; D]], u: &[[T; D]]) -> T {
        if self.is_hopeless {
            return T::ONE / T::ZERO;
        }
        let contacts = residual::natural_map(self.laws(), self.size, u, r, &[]);
        match self.energies.get() {
            Some(energies) => energies.larger(contacts, self.laws(), (u, r), &[], |_| None),
            None => contacts,
        }
    }

    /// The expected size of the impulses of a slot, in its scaled rows.
    pub(crate) fn expected(&self, law: &ContactLaw<T, D, L>) -> T {
        let energies = self.energies.get();
        energies.map_or(self.size, |energies| energies.expected(law.alpha))
    }

    /// Are impulses more than so many times as large as expected?
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn exceeds(&self, r: &ContactVector<T, D, C>, times: T) -> bool {
        if let Some(energies) = self.energies.get() {
            return energies.share(self.laws(), r.iter().copied()) > times;
        }
        let sum = r.iter().fold(T::ZERO, |sum, r| {
            rolled();
            sum + square(r)
        });
        let bound = self.size * times;
        sum > bound * bound
    }

    /// Gauss-Seidel solves Coulomb's law, and its relaxation with up to two tangents.
    pub(crate) fn can_be_swept(&self) -> bool {
        self.model == Model::Coulomb || D <= 3
    }

    /// Fills the augmented velocity `û` of all contacts.
    pub(crate) fn augmented_velocity(
        &self,
        u: &ContactVector<T, D, C>,
        augmented: &mut [SVector<T, D>; C],
    ) {
        for ((augmented, &u), law) in augmented.iter_mut().zip(u).zip(self.laws()) {
            rolled();
            *augmented = law.augmented(&u.into());
        }
    }

    /// What is added to velocities of impulses, with its corrections.
    pub(crate) fn bases(&self) -> ContactVector<T, D, C> {
        self.laws.map(|law| law.base.into())
    }

    /// Takes others.
    pub(crate) fn set_bases(&mut self, bases: &ContactVector<T, D, C>) {
        for (law, &base) in self.laws.iter_mut().zip(bases) {
            rolled();
            law.base = base.into();
        }
    }

    /// Adds to the velocity of a contact.
    pub(crate) fn correct(&mut self, contact: usize, difference: SVector<T, D>) {
        if let Some(law) = self.laws.get_mut(contact) {
            law.base += difference;
        }
    }
}

#[cfg(test)]
mod tests;
