//! The springs of contacts and joint rows, all of one stiffness, and the motion that loads them.
//!
//! Of all impulses `r` that carry a momentum `b`, those of least `Σ |r_i|² / m_i` belong to one small motion `ν` of all bodies: contact `i` is a
//! spring of stiffness `m_i`, and `r_i` is the impulse nearest to `m_i u_i(ν)` in its set. With whitened momenta (`X` is the whitened `Hᵀ`,
//! `P` has the reciprocal pivots of `M`) the motion solves
//!
//! `F(ν) = X r(ν) + ε ν - b = 0`, `r_i(ν) = Π_i(k_i (X_iᵀ P ν + a_i))`,
//!
//! the gradient of a convex function. Newton's method finds it; its matrix `X k ∂Π Xᵀ + ε P⁻¹` is symmetric. The small `ε` stands for a decision on
//! rank: what less than its root would move does not move. It costs momentum `ε ν`, which further rounds ask for again.
//!
//! A contact with compliance `c` has `k = 1 / (1/m + c/ε)` and `a = c r / ε`: its velocity says what it bears.

use super::spring::{Bearing, ContactSpring, RowSpring, add_outer};
use crate::factor::Factor;
use crate::linalg::blocks::product;
use crate::linalg::cholesky::factorise;
use crate::linalg::sparsity::Support;
use crate::linalg::stacked::Stacked;
use crate::linalg::substitution::{solve_lower, solve_upper};
use crate::linalg::vector::{add, norm, quotient, square};
use crate::linalg::zip::{zip3, zip4, zip5};
use crate::real::Real;

/// Newton steps of a round at most. The hardest of 500 bodies at rest took 11.
const MOST_STEPS: usize = 30;

/// Share of a load that a reserve may miss, over its accuracy.
const MISSED: f64 = 0.01;

/// Length of a step below which no step helps.
const SHORTEST_STEP: f64 = 1e-10;

/// Largest impulses that correct missed momentum, over it: larger ones would be internal.
const LARGEST_CORRECTION: f64 = 64.0;

/// Largest energy of what a round misses, over that of the round before: a larger one is no progress.
const PROGRESS: f64 = 0.64;

/// Share of the decrease that the slope promises, with which a step is content.
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Rounds at most.
const MOST_ROUNDS: usize = 8;

/// Contacts and joint rows as springs, and the motion `ν` that loads them.
pub(super) struct Springs<'a, T: Real, const N: usize, const D: usize, const C: usize, const R: usize> {
    pub(super) factor: &'a Factor<T, N, D, C, R>,
    pub(super) contacts: [ContactSpring<T, D>; C],
    pub(super) rows: [RowSpring<T>; R],
    /// `ε`
    pub(super) softness: T,
    /// Square of what rounding misses of the load, where large impulses cancel each other.
    pub(super) noise: T,
    /// May a spring have an impulse where nothing moves?
    pub(super) pushes_at_rest: bool,
    /// Square of what springs that can carry the load miss of it in a round.
    pub(super) most_missed: T,
    /// `b`, the whitened momentum that is to be carried.
    pub(super) load: [T; N],
    /// Impulses that carry it, if some are known.
    pub(super) known: Option<Stacked<T, D, C, R>>,
    /// `ν`, a whitened momentum.
    pub(super) motion: [T; N],
    /// `r(ν)`
    pub(super) impulses: Stacked<T, D, C, R>,
    /// `X r(ν)`
    pub(super) carried: [T; N],
    /// The Cholesky factor of the last matrix.
    pub(super) lower: [[T; N]; N],
    /// Is the last matrix that of all springs, none of them at the boundary of its set?
    pub(super) is_of_all: bool,
}

/// A point of the search.
struct Point<T, const N: usize> {
    /// `F(ν)`, whitened.
    gradient: [T; N],
    /// The convex function.
    value: T,
    /// Is each impulse its spring's, without a projection?
    is_free: bool,
}

impl<'a, T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Springs<'a, T, N, D, C, R> {
    /// Springs that bear nothing yet.
    pub(super) fn new(factor: &'a Factor<T, N, D, C, R>) -> Self {
        Self {
            factor,
            contacts: [ContactSpring::none(); C],
            rows: [RowSpring::none(); R],
            softness: T::EPSILON.square_root() * T::literal(0.125),
            noise: T::ZERO,
            pushes_at_rest: false,
            most_missed: T::INFINITY,
            load: [T::ZERO; N],
            known: None,
            motion: [T::ZERO; N],
            impulses: Stacked::zero(),
            carried: [T::ZERO; N],
            lower: [[T::ZERO; N]; N],
            is_of_all: false,
        }
    }

    /// Finds the motion under which the springs carry the load, and returns the share of the load that they miss. It works until that is at
    /// most `share`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn settle(&mut self, share: T) -> T {
        let size = self.factor.energy(&self.load);
        let goal = share * share * size + self.noise;
        if let Some(missed) = self.carry_freely(goal) {
            return quotient(missed, size).square_root();
        }
        let stop = goal * T::literal(0.25);
        let mut target = self.load;
        self.motion = [T::ZERO; N];
        let mut point = if self.pushes_at_rest { self.point(&target) } else { self.origin() };
        let mut last = T::INFINITY;
        for _ in 0..MOST_ROUNDS {
            self.descend(&target, &mut point, stop);
            let missed = self.missed();
            let energy = self.factor.energy(&missed);
            // If a round brings it no nearer, the springs cannot carry the load; nor can they if they miss more than `ε` accounts for.
            if energy <= goal || energy > (last * T::literal(PROGRESS)).min(self.most_missed) {
                last = energy;
                break;
            }
            last = energy;
            let pivots = self.factor.reciprocal_pivots();
            for (target, gradient, &missed, motion, reciprocal) in
                zip5(&mut target, &mut point.gradient, &missed, &self.motion, pivots)
            {
                *target += missed;
                *gradient -= missed;
                point.value -= *motion * reciprocal * missed;
            }
        }
        quotient(last, size).square_root()
    }

    /// The point where nothing moves, if no spring is anchored and no row has to push.
    fn origin(&mut self) -> Point<T, N> {
        self.impulses = Stacked::zero();
        self.carried = [T::ZERO; N];
        Point { gradient: self.load.map(|x| -x), value: T::ZERO, is_free: true }
    }

    /// Adds the least impulses that carry what is missed, also where they leave the sets: a slide is as exact as its solution, and momentum more
    /// so. Returns the share of the load that is still missed.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn restore(&mut self) -> T {
        for spring in &mut self.contacts {
            if matches!(spring.bearing, Bearing::Ray(_)) && spring.cone.friction() > T::ZERO {
                spring.bearing = Bearing::Cone;
            }
        }
        self.is_of_all = false;
        self.carried = [T::ZERO; N];
        self.factor.add_whitened(&self.impulses, &mut self.carried);
        let point = Point { gradient: self.load, value: T::ZERO, is_free: true };
        if self.factorise(&point).is_some() {
            for _ in 0..MOST_ROUNDS {
                let mut motion = self.missed();
                let energy = self.factor.energy(&motion);
                if energy <= self.noise {
                    break;
                }
                self.solve(&mut motion);
                if !self.yield_to(&motion, energy * T::literal(LARGEST_CORRECTION * LARGEST_CORRECTION)) {
                    break;
                }
            }
        }
        quotient(self.factor.energy(&self.missed()), self.factor.energy(&self.load)).square_root()
    }

    /// Solves with the last matrix, in place. The result is a whitened momentum.
    fn solve(&self, x: &mut [T; N]) {
        let n = self.factor.velocities();
        solve_upper(&self.lower, x, n);
        solve_lower(&self.lower, x, n);
        for (x, reciprocal) in x.iter_mut().zip(self.factor.reciprocal_pivots()) {
            *x /= reciprocal;
        }
    }

    /// Adds the impulses of springs that a motion strains, without a projection, unless they store more than an energy.
    fn yield_to(&mut self, motion: &[T; N], most: T) -> bool {
        let (mut strain, mut energy) = (Stacked::zero(), T::ZERO);
        self.factor.contact_velocity(motion, &mut strain);
        for (spring, strain) in self.contacts.iter().zip(&mut strain.contacts) {
            let u = match &spring.bearing {
                Bearing::Known => [T::ZERO; D],
                Bearing::Cone => *strain,
                Bearing::Ray(ray) => ray.map(|x| x * product(ray, strain)),
            };
            energy += square(&u) * spring.stiffness;
            *strain = u.map(|u| u * spring.stiffness);
        }
        for (spring, strain) in self.rows.iter().zip(&mut strain.rows) {
            energy += *strain * *strain * spring.stiffness;
            *strain *= spring.stiffness;
        }
        let is_small = energy <= most;
        if is_small {
            add(self.impulses.contacts.as_flattened_mut(), strain.contacts.as_flattened());
            add(&mut self.impulses.rows, &strain.rows);
            self.factor.add_whitened(&strain, &mut self.carried);
        }
        is_small
    }

    /// Can the springs carry the load, for a reserve of this accuracy? A friction that misses a share of the load is a larger share of itself.
    pub(super) fn carry(&mut self, accuracy: T) -> bool {
        let share = accuracy * T::literal(MISSED);
        self.settle(share) <= share
    }

    /// The largest share of its cone in `whole` that a contact uses.
    pub(super) fn largest_use(&self, whole: &[ContactSpring<T, D>; C]) -> T {
        let mut largest = T::ZERO;
        for (spring, r) in whole.iter().zip(&self.impulses.contacts) {
            if let (Bearing::Cone, [load, tangent @ ..]) = (&spring.bearing, r.as_slice()) {
                let (grip, rub) = (spring.cone.friction() * *load, norm(tangent));
                if rub > T::ZERO {
                    largest = largest.max(quotient(rub, grip));
                }
            }
        }
        largest
    }

    /// What the springs miss of the load, whitened.
    pub(super) fn missed(&self) -> [T; N] {
        let mut missed = self.load;
        for (missed, &carried) in missed.iter_mut().zip(&self.carried) {
            *missed -= carried;
        }
        missed
    }

    /// Newton's method for `F = 0`, with a line search. Where the value is mere rounding, the gradient has to fall.
    fn descend(&mut self, target: &[T; N], point: &mut Point<T, N>, stop: T) {
        for _ in 0..MOST_STEPS {
            let size = self.factor.energy(&point.gradient);
            if size <= stop || self.factorise(point).is_none() {
                return;
            }
            let mut step = point.gradient.map(|x| -x);
            self.solve(&mut step);
            let slope = self.slope(&step, &point.gradient);
            let start = self.motion;
            let mut length = T::ONE;
            loop {
                for (motion, start, step) in zip3(&mut self.motion, &start, &step) {
                    *motion = *start + *step * length;
                }
                let next = self.point(target);
                let rounding = T::EPSILON * T::literal(64.0) * (next.value.abs() + point.value.abs());
                let is_rounding = -slope <= rounding;
                let helps = if is_rounding {
                    self.factor.energy(&next.gradient) <= size * T::literal(0.25)
                } else {
                    next.value <= point.value + slope * length * T::literal(SUFFICIENT_DECREASE) + rounding
                };
                if helps {
                    *point = next;
                    break;
                }
                if is_rounding || length < T::literal(SHORTEST_STEP) {
                    self.motion = start;
                    *point = self.point(target);
                    return;
                }
                // A secant of the slope, which springs at the boundaries of their sets make steep.
                let steepens = slope - self.slope(&step, &next.gradient);
                length *= (slope / steepens).min(T::literal(0.5)).max(T::literal(0.0625));
            }
        }
    }

    /// Slope of the convex function along a step where it has this gradient.
    fn slope(&self, step: &[T; N], gradient: &[T; N]) -> T {
        let mut slope = T::ZERO;
        for (step, gradient, reciprocal) in zip3(step, gradient, self.factor.reciprocal_pivots()) {
            slope += *step * reciprocal * *gradient;
        }
        slope
    }

    /// Impulses and gradient at the present motion.
    #[cfg_attr(target_os = "none", inline(never))]
    fn point(&mut self, target: &[T; N]) -> Point<T, N> {
        let (half, mut value, mut is_free) = (T::literal(0.5), T::ZERO, true);
        let mut u = Stacked::zero();
        let energy = self.factor.contact_velocity(&self.motion, &mut u);
        for (spring, u, r) in zip3(&self.contacts, &u.contacts, &mut self.impulses.contacts) {
            if spring.bearing == Bearing::Known {
                continue;
            }
            let z = spring.pull(u);
            *r = spring.project(z);
            is_free &= *r == z || matches!(spring.bearing, Bearing::Ray(_)) && *r != [T::ZERO; D];
            value += (product(&z, r) - half * square(r)) / spring.stiffness;
        }
        for (spring, &u, r) in zip3(&self.rows, &u.rows, &mut self.impulses.rows) {
            if spring.stiffness > T::ZERO {
                let z = (u + spring.anchor) * spring.stiffness;
                *r = spring.project(z);
                is_free &= *r == z;
                value += (z * *r - half * *r * *r) / spring.stiffness;
            }
        }
        self.carried = [T::ZERO; N];
        self.factor.add_whitened(&self.impulses, &mut self.carried);
        let mut gradient = self.carried;
        for (gradient, motion, target, reciprocal) in
            zip4(&mut gradient, &self.motion, target, self.factor.reciprocal_pivots())
        {
            *gradient += self.softness * *motion - *target;
            value -= *motion * reciprocal * *target;
        }
        Point { gradient, value: value + half * self.softness * energy, is_free }
    }

    /// Factorises the matrix at the present motion. The first one, and any where no spring is at a boundary, is that of all springs.
    fn factorise(&mut self, point: &Point<T, N>) -> Option<()> {
        let is_first = self.motion.iter().all(|&x| x == T::ZERO);
        let is_of_all = is_first || point.is_free;
        if is_of_all && self.is_of_all {
            return Some(());
        }
        let n = self.factor.velocities();
        let mut matrix = [[T::ZERO; N]; N];
        for (k, row, reciprocal) in zip3(0..n, &mut matrix, self.factor.reciprocal_pivots()) {
            *row.get_mut(k)? = self.softness / reciprocal;
        }
        let mut u = Stacked::zero();
        if !is_of_all {
            self.factor.contact_velocity(&self.motion, &mut u);
        }
        for (spring, u, columns) in zip3(&self.contacts, &u.contacts, self.factor.supported_contacts()) {
            spring.add_slope(&spring.pull(u), is_of_all, columns, &mut matrix);
        }
        for (spring, &u, column) in zip3(&self.rows, &u.rows, self.factor.whitened_row_columns()) {
            if is_of_all || spring.is_inside((u + spring.anchor) * spring.stiffness) {
                let all = Support::all().groups::<N>(n);
                add_outer(|[x]| [*x * spring.stiffness], (column, all), &mut matrix);
            }
        }
        self.is_of_all = is_of_all;
        factorise((&matrix, n), T::ZERO, &mut self.lower, &mut [usize::MAX; N]).ok()
    }
}
