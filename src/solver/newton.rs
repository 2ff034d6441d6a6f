//! Newton's method: steps with the kept Jacobian or with a new one, and their lengths.
//!
//! A *chord step* uses the Jacobian of an earlier point: it factorises nothing. The *active set* is the mode of every contact and joint row.
//! The *merit* is the energy `Σ alpha_i |E_i|²` of the residual, which steps reduce ([`crate::guide::method`]).

use crate::linalg::stacked::Stacked;
use crate::problem::Problem;
use crate::real::Real;
use crate::solver::phases::Phases;
use crate::solver::solve::Solve;
use crate::solver::state::{Newton, Origin};
use crate::solver::tuning;

/// The outcome of a step.
pub(crate) enum Outcome {
    /// The step was accepted. Another one follows unless the solve is over.
    Accepted(Newton),
    /// The kept Jacobian failed. Sweeps find the active set more cheaply than a new Jacobian.
    NoJacobian,
    /// No length was accepted, or there were too many steps.
    Rejected,
}

/// The outcome of chord steps.
enum Chord {
    /// None was made: no Jacobian is kept, or the active set has changed.
    Unavailable,
    /// They lowered the merit, or the monitor has to look at the point.
    Accepted,
    /// They did not lower the merit, and the point is where it was.
    Undone,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Solve<'_, '_, T, N, D, C, R, S, P>
{
    /// Makes chord steps, or a step with a new Jacobian.
    #[inline(never)]
    pub(super) fn step(&mut self, mut newton: Newton) -> Outcome {
        let chord = if newton.reuse { self.chord_steps(&mut newton.reuse) } else { Chord::Unavailable };
        let accepted = match chord {
            Chord::Accepted => true,
            _ if newton.sweeps_first => return Outcome::NoJacobian,
            Chord::Undone => return Outcome::Accepted(newton),
            Chord::Unavailable => self.step_anew(&mut newton),
        };
        newton.remaining_steps = newton.remaining_steps.saturating_sub(1);
        if self.monitor.must_return() || accepted && newton.remaining_steps > 0 {
            Outcome::Accepted(newton)
        } else {
            Outcome::Rejected
        }
    }

    /// Makes up to [`tuning::chord_steps`] chord steps, while the active set stays the same and each lowers the merit tenfold. `again` tells
    /// whether the next step begins with chord steps, too.
    #[inline(never)]
    fn chord_steps(&mut self, again: &mut bool) -> Chord {
        if !self.state.holds_jacobian || !self.has_same_active_set() {
            return Chord::Unavailable;
        }
        let (start, before) = (self.state.point.z, self.state.point.merit);
        *again = true;
        for _ in 0..tuning::chord_steps() {
            self.monitor.solution.work.chord_steps += 1;
            let (z, merit) = (self.state.point.z, self.state.point.merit);
            let Some(step) = self.chord_step() else {
                self.go_back(&start);
                break;
            };
            self.evaluate_at(&z, &step, T::ONE);
            let fast = self.state.point.merit < merit * tuning::chord_fall();
            *again = fast && self.has_same_active_set();
            if self.monitor.must_return() {
                return Chord::Accepted;
            }
            if !*again {
                break;
            }
        }
        if self.state.point.merit < before {
            return Chord::Accepted;
        }
        *again = false;
        self.go_back(&start);
        Chord::Undone
    }

    /// Is the active set at the point that of the kept Jacobian?
    fn has_same_active_set(&self) -> bool {
        let sets = &self.monitor.problem.sets;
        self.state.jacobian.has_same_active_set(sets, &self.state.point)
    }

    /// The chord step at the point.
    fn chord_step(&self) -> Option<Stacked<T, D, C, R>> {
        let residual = &self.state.point.residual;
        let Problem { sets, factor, .. } = &*self.monitor.problem;
        let delassus = factor.delassus();
        self.state.jacobian.step(sets, delassus, residual, &self.state.matrix)
    }

    /// Makes a step with a new Jacobian. Returns true if a length was accepted.
    #[inline(never)]
    fn step_anew(&mut self, newton: &mut Newton) -> bool {
        self.monitor.solution.work.newton_steps += 1;
        let problem = &*self.monitor.problem;
        let may_centre = matches!(newton.origin, Origin::LastSolution | Origin::Cold);
        let centred = may_centre
            && problem.is_hyperstatic(&self.state.point.r, problem.sets.holding_rows(&self.state.point.r));
        let damping = newton.damping(self.state.point.estimate);
        self.state.forget();
        let (jacobian, matrix) = (&mut self.state.jacobian, &mut self.state.matrix);
        let (sets, delassus) = (&problem.sets, problem.factor.delassus());
        let computed = jacobian.compute(sets, delassus, &self.state.point, damping, matrix);
        self.state.holds_jacobian = computed.is_some();
        let step = computed.and_then(|()| {
            let residual = if centred {
                self.state.jacobian.centred(&self.state.point)
            } else {
                self.state.point.residual
            };
            self.state.jacobian.step(sets, delassus, &residual, &self.state.matrix)
        });
        let before = self.state.point.merit;
        let rise = newton.may_raise_merit.then(tuning::merit_growth);
        let length = step.and_then(|step| self.search_line(&step, rise));
        if length == Some(T::ONE) {
            newton.may_raise_merit &= self.state.point.merit < before;
            newton.reuse = self.state.point.merit < before * tuning::chord_fall();
        }
        let lowers = self.state.point.merit < before * rise.unwrap_or(T::ONE);
        if self.monitor.must_return() && !lowers {
            newton.remaining_steps = 0; // rejected, unless the check finds a solution
        }
        if length.is_none() {
            self.monitor.note_failure();
        }
        length.is_some()
    }

    /// Takes the first of [`tuning::LENGTHS`] of a step that lowers the merit, and returns it. A full step may raise the merit by the factor
    /// `rise`. If no length is accepted, the point stays where it was.
    #[inline(never)]
    fn search_line(&mut self, step: &Stacked<T, D, C, R>, rise: Option<T>) -> Option<T> {
        let (start, before) = (self.state.point.z, self.state.point.merit);
        for length in tuning::LENGTHS {
            let length = T::literal(length);
            self.evaluate_at(&start, step, length);
            let share = rise.filter(|_| length == T::ONE).unwrap_or(T::ONE);
            if self.state.point.merit < before * share || self.monitor.must_return() {
                return Some(length);
            }
        }
        self.go_back(&start);
        None
    }

    /// Moves the point to `start + length step`, and shows it to the monitor.
    fn evaluate_at(&mut self, start: &Stacked<T, D, C, R>, step: &Stacked<T, D, C, R>, length: T) {
        self.state.point.z = Stacked::along(start, step, length);
        self.evaluate_z();
        self.consider();
    }

    /// Moves the point back to an earlier `z`.
    fn go_back(&mut self, start: &Stacked<T, D, C, R>) {
        self.state.point.z = *start;
        self.evaluate_z();
    }
}

#[cfg(test)]
mod tests;
