//! Proof that friction locks what is to be pushed apart: Farkas' lemma over the friction cones.
//!
//! No velocity has `H v + w` in the dual cones `K*` if some `d` in the cones `K_mu` has `Hᵀ d = 0` and `w · d < 0`: impulses
//! in balance that work against what the offsets ask for. The projection of `-w` onto the `d` in balance is the steepest of
//! them; where it leaves the cones, projections onto cones (a little narrower, so that the last one stays inside) and onto
//! balance take turns (von Neumann, 1950). No matrix is needed: conjugate gradients find balance in as many steps as bodies
//! have velocities, and two more for rounding.

use crate::cone::FrictionCone;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::square;
use crate::problem::Problem;
use crate::problem::infeasibility::is_strong;
use crate::problem::infeasibility::search::Demand;
use crate::real::Real;
use crate::scene::Scaling;
use nalgebra::SVector;

/// Projections onto the cones, at most.
const ROUNDS: usize = 16;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Looks for a `d` that proves a jam, in the rows as they were given; `None` if there is none to be found.
    #[inline(never)]
    pub(crate) fn jam(&self) -> Option<Stacked<T, D, C, R>> {
        let demands = self.scene.demands();
        // `d = weights x`: roots of effective masses over the reference mass, 0 where nothing can be part of a jam.
        let mass = self.scene.reference_mass();
        let mut weights = Stacked::zero();
        let mut offsets = Stacked::zero();
        let contacts = self.scene.contacts().iter().enumerate();
        for ((i, contact), set) in contacts.zip(self.sets.contacts()) {
            let places = weights.contacts.get_mut(i).zip(offsets.contacts.get_mut(i));
            let is_rigid = !self.scene.scaling(i).is_some_and(Scaling::is_compliant);
            if let Some((weights, offsets)) = places.filter(|_| is_rigid) {
                let rows = if contact.mu > T::ZERO { D } else { 1 };
                let weight = (set.alpha / mass).square_root();
                weights.iter_mut().take(rows).for_each(|x| *x = weight);
                *offsets = self.scene.scale(i, contact.offset.into());
            }
        }
        let rows = weights.rows.iter_mut().zip(&mut offsets.rows);
        let sources = self.scene.rows().iter().zip(self.sets.rows());
        for ((weight, offset), ((row, set), demand)) in rows.zip(sources.zip(&demands.rows)) {
            if *demand != Demand::Nothing {
                *weight = (set.alpha / mass).square_root();
                *offset = row.offset;
            }
        }
        weigh(&mut offsets, &weights);
        let mut x = Stacked::zero();
        add(&mut x, &offsets, -T::ONE);
        self.balance(&weights, &mut x);
        let least = dot(&x, &x) * T::literal(1e-6);
        for round in 0.. {
            if self.is_in_cones(&demands.rows, &x) {
                break;
            }
            if round == ROUNDS || dot(&x, &x) <= least {
                return None;
            }
            for (i, contact) in self.scene.contacts().iter().enumerate() {
                let places = x.contacts.get_mut(i).zip(weights.contacts.get_mut(i));
                let cone = FrictionCone::new(contact.mu * T::literal(63.0 / 64.0));
                if let Some(((x, weights), cone)) = places.zip(cone) {
                    *x = cone.nearest(&SVector::from(*x)).into();
                    if 2 * round >= ROUNDS && *x == [T::ZERO; D] {
                        *weights = [T::ZERO; D]; // has no part in it
                    }
                }
            }
            let rows = x.rows.iter_mut().zip(&mut weights.rows);
            for ((x, weight), demand) in rows.zip(&demands.rows) {
                if *demand == Demand::NotNegative && *x <= T::ZERO {
                    *x = T::ZERO;
                    if 2 * round >= ROUNDS {
                        *weight = T::ZERO;
                    }
                }
            }
            self.balance(&weights, &mut x);
        }
        let approach = -dot(&offsets, &x);
        let leak = self.products(&weights, &mut { x });
        let leak = leak.max(T::ZERO).square_root();
        if !is_strong(leak, approach, &offsets, &x) {
            return None;
        }
        let mut proof = x;
        weigh(&mut proof, &weights);
        for (i, d) in proof.contacts.iter_mut().enumerate() {
            *d = self.scene.scale(i, *d);
        }
        self.scene.cancels(&proof, &x).then_some(proof)
    }

    /// Is it in the friction cones, and not negative in limits?
    fn is_in_cones(&self, demands: &[Demand; R], x: &Stacked<T, D, C, R>) -> bool {
        let mut contacts = self.scene.contacts().iter().zip(&x.contacts);
        let mut rows = demands.iter().zip(&x.rows);
        contacts.all(|(contact, &x)| {
            FrictionCone::new(contact.mu).is_some_and(|cone| cone.holds(&SVector::from(x)))
        }) && rows.all(|(demand, &x)| *demand != Demand::NotNegative || x >= T::ZERO)
    }

    /// Takes away from `x` what moves anything: conjugate gradients on `|Hᵀ weights x|²` in the norm of `M⁻¹`.
    #[inline(never)]
    fn balance(&self, weights: &Stacked<T, D, C, R>, x: &mut Stacked<T, D, C, R>) {
        let mut direction = Stacked::zero();
        let mut last = T::ZERO;
        let counts = self.sets.counts();
        let most = N.min(D * counts.contacts + counts.rows) + 2;
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

    /// Replaces `x` by `weights m W weights x` with the reference mass `m`, without compliance; returns `xᵀ` times that.
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

    /// Do these impulses throw the bodies? They are far larger than expected, and add more energy than stopping the free motion
    /// and doing all that the offsets ask for would take.
    #[inline(never)]
    pub(crate) fn throws(&self, r: &Stacked<T, D, C, R>, most: T) -> bool {
        if !self.exceeds(r, most) {
            return false;
        }
        let mut allowed = self.factor.energy(&self.whitened);
        let contacts = self.scene.contacts().iter().enumerate();
        for ((i, contact), set) in contacts.zip(self.sets.contacts()) {
            let offset = self.scene.scale(i, contact.offset.into());
            allowed += set.alpha * square(&offset);
        }
        for (row, set) in self.scene.rows().iter().zip(self.sets.rows()) {
            allowed += set.alpha * row.offset * row.offset;
        }
        let mut momentum = self.whitened;
        self.factor.add_whitened(r, &mut momentum);
        let energy = self.factor.energy(&momentum);
        energy > allowed * T::literal(4.0) || !energy.is_finite()
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

/// Multiplies entry by entry.
#[inline(never)]
fn weigh<T: Real, const D: usize, const C: usize, const R: usize>(
    x: &mut Stacked<T, D, C, R>,
    weights: &Stacked<T, D, C, R>,
) {
    for (x, &weight) in x.iter_mut().zip(weights.iter()) {
        *x *= weight;
    }
}

#[inline(never)]
fn dot<T: Real, const D: usize, const C: usize, const R: usize>(
    x: &Stacked<T, D, C, R>,
    y: &Stacked<T, D, C, R>,
) -> T {
    x.iter()
        .zip(y.iter())
        .fold(T::ZERO, |sum, (&x, &y)| sum + x * y)
}
