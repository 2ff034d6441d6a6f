//! One time step: a scene, its factor and a free impulse, brought into contact space.

use crate::cone::{add_to_normal, norm, split, square};
use crate::linalg::blocks::ContactVector;
use crate::linalg::hints::{opaque, opaque_mut, rolled};
use crate::scene::check_finite;
use crate::solution::zeros;
use crate::{Contact, Error, Factor, FrictionCone, Input, Real, Scene, Settings, SlipUpdate};
use nalgebra::SVector;

mod evaluation;
pub(crate) mod infeasibility;
pub(crate) mod residual;
pub(crate) mod rounding;

/// What a solve needs to know of one contact, besides the factor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactLaw<T, const D: usize> {
    /// Factor of the De Saxcé shift: `mu_i`, or 0 in the convex relaxation.
    pub(crate) shift_factor: T,
    /// The cone `K` the impulse lies in.
    pub(crate) cone: FrictionCone<T>,
    /// Step `alpha_i` (kg) of the natural map, see [`Factor::step`].
    pub(crate) alpha: T,
    /// `q_i = H_i v_free + w_i`.
    pub(crate) q: SVector<T, D>,
}

impl<T: Real, const D: usize> ContactLaw<T, D> {
    /// What stands in a place that is not used.
    const fn none() -> Self {
        Self {
            shift_factor: T::ZERO,
            cone: FrictionCone::frictionless(),
            alpha: T::ZERO,
            q: zeros(),
        }
    }

    /// Rows along which it may push.
    pub(crate) fn rows(&self) -> usize {
        if self.cone.friction() > T::ZERO { D } else { 1 }
    }

    /// De Saxcé shift `mu_i |u_Ti|`, what `û` adds to the normal velocity.
    pub(crate) fn shift(&self, u: &SVector<T, D>) -> T {
        let (_, tangent) = split(u);
        self.shift_factor * norm(tangent)
    }

    /// Augmented velocity `û_i = u_i + mu_i |u_Ti| e_N`.
    #[inline]
    pub(crate) fn augmented(&self, u: &SVector<T, D>) -> SVector<T, D> {
        let mut augmented = *u;
        add_to_normal(&mut augmented, self.shift(u));
        augmented
    }
}

/// The data of one solve.
pub(crate) struct Problem<'a, T, const N: usize, const D: usize, const C: usize> {
    pub(crate) scene: &'a Scene<T, N, D, C>,
    pub(crate) factor: &'a Factor<T, N, D, C>,
    pub(crate) f: &'a SVector<T, N>,
    pub(crate) slip: SlipUpdate,
    /// The free impulse `-f`, whitened.
    pub(crate) whitened: [T; N],
    laws: [ContactLaw<T, D>; C],
    /// `|alpha q|`: the size of the impulses to expect.
    pub(crate) size: T,
}

impl<'a, T: Real, const N: usize, const D: usize, const C: usize> Problem<'a, T, N, D, C> {
    /// What can be wrong with the data of a solve.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn check(
        scene: &Scene<T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        f: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<(), Error> {
        let tolerance = settings.tolerance;
        if !tolerance.is_finite() || tolerance < T::ZERO {
            return Err(Error::InvalidTolerance);
        }
        check_finite(f, Input::FreeImpulse)?;
        let contacts = scene.contacts();
        if contacts.len() != factor.contacts() {
            return Err(Error::FactorMismatch {
                scene: contacts.len(),
                factor: factor.contacts(),
            });
        }
        if !factor.is_current(scene) {
            return Err(Error::StaleFactor);
        }
        let invalid = |contact: &Contact<T, N, D>| !FrictionCone::is_valid(contact.mu);
        match opaque(contacts).iter().position(invalid) {
            Some(contact) => Err(Error::InvalidFriction { contact }),
            None => Ok(()),
        }
    }

    /// The problem of data that [`Self::check`] has seen, to be filled. (In two steps, for it would
    /// stand on the stack twice if it were filled and then moved.)
    #[inline]
    pub(crate) fn new(
        scene: &'a Scene<T, N, D, C>,
        factor: &'a Factor<T, N, D, C>,
        f: &'a SVector<T, N>,
        slip: SlipUpdate,
    ) -> Self {
        Self {
            scene,
            factor,
            f,
            slip,
            whitened: [T::ZERO; N],
            laws: [ContactLaw::none(); C],
            size: T::ZERO,
        }
    }

    /// The free motion and the laws of the contacts.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn fill(&mut self) {
        let (f, factor) = (opaque(self.f.as_slice()), self.factor);
        for (push, &f) in self.whitened.iter_mut().zip(f) {
            rolled();
            *push = -f;
        }
        factor.whiten(&mut self.whitened);
        let mut moved = [[T::ONE; D]; C];
        factor.contact_velocity(&self.whitened, &mut moved);
        let is_coulomb = self.slip != SlipUpdate::Never;
        let sources = opaque(self.scene.contacts()).iter().zip(&moved);
        let pairs = opaque_mut(&mut self.laws).iter_mut().zip(sources);
        for (i, (law, (contact, &moved))) in pairs.enumerate() {
            rolled();
            let mu = contact.mu;
            *law = ContactLaw {
                shift_factor: if is_coulomb { mu } else { T::ZERO },
                cone: FrictionCone::new(mu).unwrap_or(FrictionCone::frictionless()),
                alpha: factor.step(i),
                q: contact.offset + SVector::from(moved),
            };
        }
        self.size = size(self.laws());
    }

    /// The contacts in use.
    #[inline]
    pub(crate) fn laws(&self) -> &[ContactLaw<T, D>] {
        let laws = self.laws.get(..self.factor.contacts());
        laws.unwrap_or_default()
    }

    /// Fills `u = W r + q`; returns the first part of the error.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn natural_map(
        &self,
        r: &ContactVector<T, D, C>,
        u: &mut ContactVector<T, D, C>,
    ) -> T {
        let contacts = ..self.factor.contacts();
        let r = opaque(r.get(contacts).unwrap_or_default());
        let u = opaque_mut(u.get_mut(contacts).unwrap_or_default());
        self.factor.delassus_times(r, u);
        for (u, law) in u.iter_mut().zip(opaque(self.laws())) {
            rolled();
            for (u, &q) in u.iter_mut().zip(law.q.iter()) {
                *u += q;
            }
        }
        self.natural_map_at(r, u)
    }

    /// First part of the error, from `u = W r + q`.
    #[inline]
    pub(crate) fn natural_map_at(&self, r: &[[T; D]], u: &[[T; D]]) -> T {
        residual::natural_map(self.laws(), self.size, u, r, &[])
    }

    /// Gauss-Seidel solves Coulomb's law for contacts of up to two tangents.
    pub(crate) fn can_be_swept(&self) -> bool {
        D <= 3 && self.slip != SlipUpdate::Never
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

    /// `q`, as it has been corrected.
    pub(crate) fn q(&self) -> ContactVector<T, D, C> {
        self.laws.map(|law| law.q.into())
    }

    /// Takes another `q`.
    pub(crate) fn set_q(&mut self, q: &ContactVector<T, D, C>) {
        for (law, &q) in self.laws.iter_mut().zip(q) {
            rolled();
            law.q = q.into();
        }
    }

    /// Adds to `q_i`.
    pub(crate) fn correct(&mut self, contact: usize, difference: SVector<T, D>) {
        if let Some(law) = self.laws.get_mut(contact) {
            law.q += difference;
        }
    }
}

/// `|alpha q|`
#[cfg_attr(target_os = "none", inline(never))]
fn size<T: Real, const D: usize>(laws: &[ContactLaw<T, D>]) -> T {
    let laws = opaque(laws);
    let mut largest = T::ZERO;
    for law in laws {
        rolled();
        largest = residual::larger(largest, law.q.as_slice(), law.alpha);
    }
    let unit = residual::unit(largest);
    let mut squares = T::ZERO;
    for law in laws {
        rolled();
        let size = law.q * (law.alpha * unit);
        squares += square(size.as_slice());
    }
    squares.square_root() / unit
}
