//! Springs that are all inside their sets: one linear system, with an unknown for each direction in which an impulse may change.
//!
//! From impulses `s` that carry the load, `r = s - ε q` with `(W + ε / k) q = s / k`: what is internal to `s` goes. A further round takes `ε q` for
//! `s`; what is missed of the load falls by a factor of `ε` each time.

use super::spring::Bearing;
use super::springs::Springs;
use crate::linalg::blocks::product;
use crate::linalg::cholesky::{axpy, factorise};
use crate::linalg::stacked::Stacked;
use crate::linalg::substitution::{solve_lower, solve_upper};
use crate::linalg::vector::square;
use crate::linalg::zip::{zip3, zip4};
use crate::real::Real;

/// Rounds at most.
const MOST_ROUNDS: usize = 3;

/// Internal impulses up to this share of all leave no rounding behind that matters.
const NEGLIGIBLE: f64 = 1e-3;

/// The system over the unknowns in use, at most as many as velocities.
struct System<T, const N: usize> {
    /// `W + ε / k` in the lower triangle.
    matrix: [[T; N]; N],
    /// `s`
    impulses: [T; N],
    /// `ε / k`
    weights: [T; N],
    count: usize,
}

/// `x - y`
fn difference<T: Real, const N: usize>(x: &[T; N], y: &[T; N]) -> [T; N] {
    let mut difference = *x;
    for (x, &y) in difference.iter_mut().zip(y) {
        *x -= y;
    }
    difference
}

impl<T: Real, const N: usize> System<T, N> {
    /// Adds an unknown with its impulse and its spring, and returns the place for its row of `W`.
    #[inline]
    fn add(&mut self, impulse: T, stiffness: T) -> Option<&mut [T; N]> {
        let place = self.count;
        let row = self.matrix.get_mut(place)?;
        *self.impulses.get_mut(place)? = impulse;
        *self.weights.get_mut(place)? = T::ONE / stiffness;
        self.count += 1;
        Some(row)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Springs<'_, T, N, D, C, R> {
    /// The impulses of springs that are inside their sets, from those that are known to carry the load. Returns the square of what they miss of it;
    /// `None` if a spring is at the boundary of its set, if one has compliance, or if there are more unknowns than velocities.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn carry_freely(&mut self, goal: T) -> Option<T> {
        let known = self.known.filter(|_| !self.pushes_at_rest)?;
        let mut system =
            System { matrix: [[T::ZERO; N]; N], impulses: [T::ZERO; N], weights: [T::ZERO; N], count: 0 };
        self.fill(&known, &mut system)?;
        let System { matrix, impulses, weights, count } = &mut system;
        for (k, row, weight) in zip3(0..*count, &mut *matrix, &mut *weights) {
            *weight *= self.softness;
            *row.get_mut(k)? += *weight;
        }
        self.is_of_all = false; // the place of the last matrix is taken
        factorise((matrix, *count), T::ZERO, &mut self.lower, &mut [usize::MAX; N]).ok()?;
        let known = *impulses;
        let mut internal = known;
        let negligible = T::literal(NEGLIGIBLE * NEGLIGIBLE);
        let mut missed = T::INFINITY;
        for _ in 0..MOST_ROUNDS {
            self.find_internal(&mut internal, (weights, *count));
            *impulses = difference(&known, &internal);
            // Large internal impulses leave rounding of theirs behind.
            if square(&internal) > negligible * square(impulses) {
                internal = *impulses;
                self.find_internal(&mut internal, (weights, *count));
                *impulses = difference(impulses, &internal);
            }
            self.write(impulses)?;
            self.carried = [T::ZERO; N];
            self.factor.add_whitened(&self.impulses, &mut self.carried);
            missed = self.factor.energy(&self.missed());
            if missed <= goal {
                break;
            }
            internal = difference(&known, impulses);
        }
        Some(missed)
    }

    /// Leaves of impulses, over the unknowns, what is internal: `ε q`, twice.
    #[cfg_attr(target_os = "none", inline(never))]
    fn find_internal(&self, impulses: &mut [T; N], (weights, count): (&[T; N], usize)) {
        for _ in 0..2 {
            for (impulse, &weight) in impulses.iter_mut().zip(weights) {
                *impulse *= weight;
            }
            solve_upper(&self.lower, impulses, count);
            solve_lower(&self.lower, impulses, count);
        }
    }

    /// Fills the system; `None` if there is no room for all unknowns.
    #[cfg_attr(target_os = "none", inline(never))]
    fn fill(&self, known: &Stacked<T, D, C, R>, system: &mut System<T, N>) -> Option<()> {
        let delassus = self.factor.delassus();
        for (i, spring, rows, known) in zip4(1.., &self.contacts, &delassus.contacts, &known.contacts) {
            match &spring.bearing {
                Bearing::Known => {}
                Bearing::Cone => {
                    for (row, &impulse) in rows.iter().zip(known) {
                        self.copy(row, i, system.add(impulse, spring.stiffness)?);
                    }
                }
                Bearing::Ray(ray) => {
                    let mut row = [[T::ZERO; D]; C];
                    for (&x, own) in ray.iter().zip(rows) {
                        axpy(x, own.as_flattened(), row.as_flattened_mut());
                    }
                    self.copy(&row, i, system.add(product(ray, known), spring.stiffness)?);
                }
            }
        }
        for (spring, row, &known) in zip3(&self.rows, &delassus.rows, &known.rows) {
            if spring.stiffness > T::ZERO {
                let target = system.add(known, spring.stiffness)?;
                let mut rest = self.copy(&row.contacts, C, target).iter_mut();
                for (other, &w) in self.rows.iter().zip(&row.rows) {
                    if other.stiffness > T::ZERO
                        && let Some(entry) = rest.next()
                    {
                        *entry = w;
                    }
                }
            }
        }
        Some(())
    }

    /// Copies the entries of a row of `W` along the unknowns of the first `count` contacts, and returns the place behind them.
    #[inline]
    fn copy<'a>(&self, row: &[[T; D]; C], count: usize, target: &'a mut [T; N]) -> &'a mut [T] {
        let mut rest = target.as_mut_slice();
        for (spring, w) in self.contacts.iter().zip(row).take(count) {
            rest = match (&spring.bearing, rest) {
                (Bearing::Known, rest) => rest,
                (Bearing::Ray(ray), [entry, rest @ ..]) => {
                    *entry = product(ray, w);
                    rest
                }
                (_, rest) => {
                    for (entry, &w) in rest.iter_mut().zip(w) {
                        *entry = w;
                    }
                    rest.get_mut(D..).unwrap_or_default()
                }
            };
        }
        rest
    }

    /// Writes the impulses of the unknowns; `None` if one is outside of its set.
    #[cfg_attr(target_os = "none", inline(never))]
    fn write(&mut self, impulses: &[T; N]) -> Option<()> {
        let mut impulses = impulses.iter();
        for (spring, r) in self.contacts.iter().zip(&mut self.impulses.contacts) {
            match &spring.bearing {
                Bearing::Known => {}
                Bearing::Cone => {
                    for (r, &impulse) in r.iter_mut().zip(impulses.by_ref()) {
                        *r = impulse;
                    }
                    spring.cone.has(&(*r).into()).then_some(())?;
                }
                Bearing::Ray(ray) => {
                    let length = *impulses.next()?;
                    (length >= T::ZERO).then_some(())?;
                    *r = ray.map(|ray| ray * length);
                }
            }
        }
        for (spring, r) in self.rows.iter().zip(&mut self.impulses.rows) {
            if spring.stiffness > T::ZERO {
                *r = *impulses.next()?;
                (spring.project(*r) == *r).then_some(())?;
            }
        }
        Some(())
    }
}
