//! Proof of a jam, in which friction locks a body that the offsets push out: Farkas' lemma over the friction cones.
//!
//! No velocity has `H v + w` in the dual cones `K*` if there are impulses `d` in the cones `K_mu` with `Hᵀ d = 0` (in balance) and
//! `w · d < 0` ([`crate::guide::error`], "Jammed scenes"). The search starts at the projection of `-w` onto the impulses in balance.
//! While that is outside the cones, it is projected onto the cones and onto balance in turn (Cheney and Goldstein, 1959). The cones are a
//! little narrower there, so that the last projection stays inside. No matrix is needed: conjugate gradients find balance in as many
//! steps as bodies have velocities, and two more for rounding.

use crate::cone::FrictionCone;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::at_least;
use crate::linalg::zip::{zip3, zip4, zip5};
use crate::problem::Problem;
use crate::problem::infeasibility::search::Demand;
use crate::problem::infeasibility::{dot, is_strong, violation, weigh};
use crate::real::Real;
use crate::scene::{RowLaw, Scaling};
use nalgebra::SVector;

/// Most projections onto the cones.
const ROUNDS: usize = 16;

/// The variables `x` of the search, with `d = weights x`.
struct Weighted<T, const D: usize, const C: usize, const R: usize> {
    /// Roots of effective masses over the reference mass; 0 where no impulse can be part of a jam.
    weights: Stacked<T, D, C, R>,
    /// `w`, multiplied by the weights.
    offsets: Stacked<T, D, C, R>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Searches for a `d` that proves a jam, in physical rows; `None` if it finds none.
    ///
    /// It begins at `-w`, or at impulses of a path that grow without bound: in a jam they grow along a proof.
    #[inline(never)]
    pub(crate) fn jam(&self, grown: Option<&Stacked<T, D, C, R>>) -> Option<Stacked<T, D, C, R>> {
        let demands = self.scene.demands();
        let Weighted { mut weights, offsets } = self.weighted(&demands.rows);
        let mut x = Stacked::zero();
        if let Some(grown) = grown {
            for (x, &r, &weight) in zip3(x.iter_mut(), grown.iter(), weights.iter()) {
                *x = if weight > T::ZERO { r / weight } else { T::ZERO };
            }
        } else {
            add(&mut x, &offsets, -T::ONE);
        }
        self.balance(&weights, &mut x);
        let least = dot(&x, &x) * T::literal(1e-6);
        for round in 0.. {
            if self.is_in_cones(&demands.rows, &x) {
                break;
            }
            if round == ROUNDS || dot(&x, &x) <= least {
                return None;
            }
            // In the second half of the rounds impulses of 0 take no further part.
            let drops = 2 * round >= ROUNDS;
            self.project_onto_cones(&demands.rows, drops, &mut weights, &mut x);
            self.balance(&weights, &mut x);
        }
        let approach = -dot(&offsets, &x);
        let mut proof = x;
        weigh(&mut proof, &weights);
        for (i, d) in proof.contacts.iter_mut().enumerate() {
            *d = self.scene.physical_impulse(i, *d);
        }
        let is_strong = is_strong(self.leak(&proof), approach, &offsets, &x);
        (is_strong && self.scene.cancels(&proof, &x)).then_some(proof)
    }

    /// The weights, and the offsets multiplied by them.
    #[inline]
    fn weighted(&self, demands: &[Demand; R]) -> Weighted<T, D, C, R> {
        let mass = self.scene.reference_mass();
        let mut weights = Stacked::zero();
        let mut offsets = Stacked::zero();
        let (contacts, sets) = (self.scene.contacts(), self.sets.contacts());
        for (i, contact, set, weights, offsets) in
            zip5(0..C, contacts, sets, &mut weights.contacts, &mut offsets.contacts)
        {
            if !self.scene.scaling(i).is_some_and(Scaling::is_compliant) {
                let rows = if contact.mu > T::ZERO { D } else { 1 };
                let weight = (set.alpha / mass).square_root();
                weights.iter_mut().take(rows).for_each(|x| *x = weight);
                *offsets = self.scene.scaled_velocity(i, contact.offset).into();
            }
        }
        for (row, set, demand, weight, offset) in
            zip5(self.scene.rows(), self.sets.rows(), demands, &mut weights.rows, &mut offsets.rows)
        {
            if *demand != Demand::Nothing {
                *weight = (set.alpha / mass).square_root();
                *offset = row.offset;
            }
        }
        weigh(&mut offsets, &weights);
        Weighted { weights, offsets }
    }

    /// Projects `x` onto narrower friction cones, and the rows of limits onto 0 and above. With `drops` it sets the weights of impulses
    /// that become 0 to 0.
    #[inline]
    fn project_onto_cones(
        &self,
        demands: &[Demand; R],
        drops: bool,
        weights: &mut Stacked<T, D, C, R>,
        x: &mut Stacked<T, D, C, R>,
    ) {
        for (contact, x, weights) in zip3(self.scene.contacts(), &mut x.contacts, &mut weights.contacts) {
            if let Some(cone) = FrictionCone::new(contact.mu * T::literal(63.0 / 64.0)) {
                *x = cone.nearest(&SVector::from(*x)).into();
                if drops && *x == [T::ZERO; D] {
                    *weights = [T::ZERO; D];
                }
            }
        }
        for (x, weight, demand) in zip3(&mut x.rows, &mut weights.rows, demands) {
            if *demand == Demand::NotNegative && *x <= T::ZERO {
                *x = T::ZERO;
                if drops {
                    *weight = T::ZERO;
                }
            }
        }
    }

    /// Is `x` in the friction cones, and not negative in the rows of limits?
    fn is_in_cones(&self, demands: &[Demand; R], x: &Stacked<T, D, C, R>) -> bool {
        let mut contacts = self.scene.contacts().iter().zip(&x.contacts);
        let mut rows = demands.iter().zip(&x.rows);
        contacts.all(|(contact, &x)| {
            FrictionCone::new(contact.mu).is_some_and(|cone| cone.has(&SVector::from(x)))
        }) && rows.all(|(demand, &x)| *demand != Demand::NotNegative || x >= T::ZERO)
    }

    /// Projects `x` onto the impulses in balance, by conjugate gradients on `|Hᵀ weights x|²` in the norm of `M⁻¹`.
    #[inline(never)]
    fn balance(&self, weights: &Stacked<T, D, C, R>, x: &mut Stacked<T, D, C, R>) {
        let mut direction = Stacked::zero();
        let mut last = T::ZERO;
        let counts = self.sets.counts();
        let most = self.scene.velocities().min(D * counts.contacts + counts.rows) + 2;
        for _ in 0..most {
            let mut slope = *x;
            self.products(weights, &mut slope);
            let steepness = dot(&slope, &slope);
            if steepness <= dot(x, x) * T::EPSILON * T::EPSILON {
                return; // in balance
            }
            if last > T::ZERO {
                add(&mut slope, &direction, steepness / last);
            }
            (direction, last) = (slope, steepness);
            let curvature = self.products(weights, &mut slope);
            let length = steepness / curvature;
            if !length.is_finite() {
                return;
            }
            add(x, &direction, -length);
        }
    }

    /// Replaces `x` by `y = weights m W weights x` with the reference mass `m`, without compliance, and returns `xᵀ y`.
    #[inline(never)]
    fn products(&self, weights: &Stacked<T, D, C, R>, x: &mut Stacked<T, D, C, R>) -> T {
        let mut impulses = *x;
        weigh(&mut impulses, weights);
        *x = Stacked::zero();
        let energy = self.factor.impulse_velocity(&[T::ZERO; N], &impulses, x);
        weigh(x, weights);
        let mass = self.scene.reference_mass();
        x.iter_mut().for_each(|x| *x *= mass);
        energy * mass
    }

    /// Do large impulses let walls close: do contacts or joint rows violate their laws by more than a tenth of what the offsets ask for?
    /// `u` are their velocities. Offsets below a thousandth of the free velocities are noise.
    #[inline(never)]
    pub(crate) fn lets_walls_close(&self, u: &Stacked<T, D, C, R>) -> bool {
        let scene = self.scene;
        if !scene.is_conceivably_infeasible() {
            return false;
        }
        // Largest energies `alpha s²` of violations `s`: by the velocities, by the offsets, and of the free velocities.
        let [mut closing, mut asked, mut free] = [T::ZERO; 3];
        let mut take_in = |alpha: T, law: RowLaw<T>, [u, offset, q]: [T; 3]| {
            let energy = |violation: T| alpha * violation * violation;
            closing = at_least(energy(violation(law, u)), closing);
            asked = at_least(energy(violation(law, offset)), asked);
            free = at_least(energy(q), free);
        };
        for (contact, set, u) in zip3(scene.contacts(), self.sets.contacts(), &u.contacts) {
            let normal = |x: &[T]| x.first().copied().unwrap_or(T::ZERO);
            take_in(set.alpha, RowLaw::Limit, [u, contact.offset.as_slice(), set.q.as_slice()].map(normal));
        }
        for (row, set, &u) in zip3(scene.rows(), self.sets.rows(), &u.rows) {
            take_in(set.alpha, row.law, [u, row.offset, set.q]);
        }
        closing * T::literal(100.0) > asked && asked * T::literal(1e6) > free
    }

    /// Do large impulses throw the bodies? Then the bodies have four times the energy of the free motion and of the velocities that the
    /// offsets ask for. `u` are their velocities.
    #[inline(never)]
    pub(crate) fn throws(&self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) -> bool {
        let free = self.factor.energy(&self.whitened);
        // `rᵀ (H v + H v_free)` more are those of the impulses, the energy of springs included.
        let [mut asked, mut gained] = [T::ZERO; 2];
        let mut take_in = |alpha: T, [r, u, q, offset]: [T; 4]| {
            asked += alpha * offset * offset;
            gained += r * (u - offset + (q - offset));
        };
        let contacts = zip3(&r.contacts, &u.contacts, self.sets.contacts());
        for (i, (r, u, set), contact) in zip3(0..C, contacts, self.scene.contacts()) {
            let offset = self.scene.scaled_velocity(i, contact.offset);
            for (&r, &u, &q, &offset) in zip4(r, u, &set.q, &offset) {
                take_in(set.alpha, [r, u, q, offset]);
            }
        }
        for (&r, &u, set, row) in zip4(&r.rows, &u.rows, self.sets.rows(), self.scene.rows()) {
            take_in(set.alpha, [r, u, set.q, row.offset]);
        }
        let energy = free + gained;
        energy > (free + asked) * T::literal(4.0) || !energy.is_finite()
    }
}

/// `x += step length`
#[inline(never)]
fn add<T: Real, const D: usize, const C: usize, const R: usize>(
    x: &mut Stacked<T, D, C, R>,
    step: &Stacked<T, D, C, R>,
    length: T,
) {
    for (x, &step) in x.iter_mut().zip(step.iter()) {
        *x += step * length;
    }
}
