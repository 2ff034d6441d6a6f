//! Steps with the linearisation of an earlier point, each joined with those before it.
//!
//! Where the scene has turned under a kept matrix, the residual that a step leaves may be as large as
//! that which it took away, and nearly its opposite. So no step stands alone: a step `d` takes
//! `a = E(z) - E(z + d)` off the residual, both are made orthogonal to those of the steps before, and
//! the point goes along `d` to where `|E - t a|` is least. These are generalised conjugate residuals
//! (Eisenstat, Elman and Schultz, 1983), in the norm of the energy.

use crate::Real;
use crate::cholesky::{axpy, rolled};
use crate::contact_space::{ContactVector, product};
use crate::problem::Law;
use crate::progress::Progress;
use crate::search::Search;
use crate::solution::zeros;
use crate::workspace::Workspace;
use nalgebra::SVector;

/// So many steps cost as much as one with a new matrix.
const STEPS: usize = 4;

/// What has come of steps with a matrix that was kept.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Chord {
    /// Nothing: the point is where it was.
    Useless,
    /// The point is better, but the end was not in reach of this matrix.
    Spent,
    /// The matrix may be worth more steps.
    Good,
}

/// A step, and what it takes off the residual.
#[derive(Clone, Copy)]
struct Direction<T, const D: usize, const C: usize> {
    step: [SVector<T, D>; C],
    fall: ContactVector<T, D, C>,
    /// `|fall|²`
    square: T,
}

impl<T: Real, const D: usize, const C: usize> Direction<T, D, C> {
    const fn none() -> Self {
        Self {
            step: [zeros(); C],
            fall: [[T::ZERO; D]; C],
            square: T::ZERO,
        }
    }

    /// Of a step that led from one residual to another, apart from the directions before it.
    fn new(
        laws: &[Law<T, D>],
        step: [SVector<T, D>; C],
        from: &ContactVector<T, D, C>,
        to: &ContactVector<T, D, C>,
        before: &[Self],
    ) -> Self {
        let (mut step, mut fall) = (step, *from);
        axpy(-T::ONE, to.as_flattened(), fall.as_flattened_mut());
        for other in before {
            let share = inner(laws, &fall, &other.fall) / other.square;
            axpy(-share, other.fall.as_flattened(), fall.as_flattened_mut());
            for (step, other) in step.iter_mut().zip(&other.step) {
                rolled();
                *step -= other * share;
            }
        }
        let square = inner(laws, &fall, &fall);
        Self { step, fall, square }
    }
}

impl<T: Real, const D: usize, const C: usize> Progress<T, D, C> {
    /// Goes on with the linearisation that was kept, as long as [`STEPS`] of its steps can be hoped to
    /// reach the end.
    #[inline(never)]
    pub(crate) fn chord<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        workspace: &Workspace<T, D, C>,
    ) -> Chord {
        let (start, before) = (self.point.z, self.point.energy);
        let chord = self.chord_steps(search, workspace);
        let better = search.is_over() || self.point.energy < before * T::literal(0.04);
        match chord {
            Some(chord) if better => chord,
            _ => {
                self.go_back(search, &start);
                Chord::Useless
            }
        }
    }

    /// The steps; `None` if one is no number. If the end is not in reach the last step stays as it is,
    /// not joined.
    fn chord_steps<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        workspace: &Workspace<T, D, C>,
    ) -> Option<Chord> {
        let Workspace {
            linearisation,
            resolvent,
        } = workspace;
        let (mut directions, before) = ([Direction::none(); STEPS - 1], self.point.energy);
        let mut energy = before;
        for count in 0..STEPS {
            search.solution.iterations += 2;
            let (z, residual) = (self.point.z, self.point.residual);
            let step = linearisation.step(search.problem, &residual, &resolvent.matrix)?;
            self.visit(search, &z, &step, T::ONE);
            if search.is_over() {
                break;
            }
            let (point, laws) = (&mut self.point, search.problem.laws());
            let known = directions.get(..count)?;
            let direction = Direction::new(laws, step, &residual, &point.residual, known);
            let length = inner(laws, &residual, &direction.fall) / direction.square;
            energy -= length * length * direction.square;
            // Shares of the energy at the start. The natural map goes with its root.
            let lack = search.tolerance() / point.natural_map;
            let (reached, wanted) = (energy / before, lack * lack * point.energy / before);
            // At this rate all steps reach `reached^(STEPS / (count + 1))`. (What underflows is there.)
            let in_reach = power(reached, STEPS) <= power(wanted, count + 1);
            if !in_reach || !linearisation.suits(search.problem, point, self.balance.scale) {
                return Some(Chord::Spent);
            }
            let end = reached < wanted * T::literal(0.5);
            match directions.get_mut(count) {
                Some(place) if !end => {
                    point.go(&z, &direction.step, length);
                    point.residual = residual;
                    let fall = direction.fall.as_flattened();
                    axpy(-length, fall, point.residual.as_flattened_mut());
                    *place = direction;
                }
                _ => {
                    search.solution.iterations += 1;
                    self.visit(search, &z, &direction.step, length);
                    break;
                }
            }
        }
        Some(Chord::Good)
    }
}

/// `Σ alpha_i a_i·b_i`
#[inline(never)]
fn inner<T: Real, const D: usize>(laws: &[Law<T, D>], a: &[[T; D]], b: &[[T; D]]) -> T {
    let mut sum = T::ZERO;
    for (law, (a, b)) in laws.iter().zip(a.iter().zip(b)) {
        rolled();
        sum += law.step * product(a, b);
    }
    sum
}

/// `xⁿ`
fn power<T: Real>(x: T, n: usize) -> T {
    (0..n).fold(T::ONE, |power, _| power * x)
}
