//! Newton's method: steps with the kept Jacobian or with a new one, and their lengths.
//!
//! A *chord step* uses the Jacobian of an earlier point: it factorises nothing. The *active set* is the mode of every contact and joint row.
//! The *merit* is the energy `Σ alpha_i |E_i|²` of the residual, which steps reduce ([`crate::guide::method`]).

use crate::linalg::stacked::Stacked;
use crate::problem::Problem;
use crate::real::Real;
use crate::solver::monitor::Monitor;
use crate::solver::state::State;
use crate::solver::tuning;

/// The state of Newton's method between two steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Newton {
    /// Number of steps that it may still make.
    remaining_steps: u8,
    /// May the next full step raise the merit?
    may_raise_merit: bool,
    /// Does the next step begin with chord steps?
    reuse: bool,
    /// Do sweeps come before a new Jacobian?
    sweeps_first: bool,
    pub(super) origin: Origin,
}

/// The kind of point at which Newton's method began.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Origin {
    /// At zero impulses, or after sweeps: there is no other start.
    Cold,
    /// On the central path.
    Path,
    /// At the last solution.
    LastSolution,
    /// At the guess that all contacts stick, where the merit tells nothing.
    Guess,
}

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

impl Newton {
    /// Begins at zero impulses, or after sweeps of a cold start.
    pub(crate) fn new() -> Self {
        Self {
            remaining_steps: u8::try_from(tuning::newton_steps()).unwrap_or(u8::MAX),
            may_raise_merit: false,
            reuse: false,
            sweeps_first: false,
            origin: Origin::Cold,
        }
    }

    /// Begins after sweeps.
    pub(crate) fn after_sweeps() -> Self {
        Self { reuse: true, ..Self::new() }
    }

    /// Begins on the central path.
    pub(crate) fn finish() -> Self {
        Self { origin: Origin::Path, ..Self::new() }
    }

    /// Begins at the guess that all contacts stick.
    pub(crate) fn guessed() -> Self {
        Self { may_raise_merit: true, origin: Origin::Guess, ..Self::new() }
    }

    /// Begins at the same guess, to move impulses away from the boundaries of their cones with one Jacobian.
    pub(crate) fn centring() -> Self {
        Self { remaining_steps: 2, ..Self::guessed() }
    }

    /// Begins at the last solution.
    pub(crate) fn warm(sweeps_first: bool) -> Self {
        Self { reuse: true, sweeps_first, origin: Origin::LastSolution, ..Self::new() }
    }

    /// Newton's method with one remaining step.
    #[cfg(test)]
    fn with_one_step() -> Self {
        Self { remaining_steps: 1, ..Self::new() }
    }

    /// Damping `δ` after Levenberg and Marquardt. It falls with the estimate of the error to a floor of 1e-12 (f32: 64 eps),
    /// about the rounding of a well-conditioned `W`, so that the last steps are hardly damped.
    fn damping<T: Real>(self, estimate: T, centred: bool) -> T {
        let share: T = match self.origin {
            Origin::Path => tuning::finish_damping(),
            // The null space of a hyperstatic scene changes from solve to solve.
            _ if centred => tuning::hyperstatic_damping(),
            _ => tuning::damping(),
        };
        share * estimate.min(T::ONE) + T::literal(1e-12).max(T::EPSILON * T::literal(64.0))
    }

    /// May it make no more steps?
    pub(crate) const fn is_spent(self) -> bool {
        self.remaining_steps == 0
    }
}

impl<T: Real, const D: usize, const C: usize, const R: usize> State<T, D, C, R> {
    /// Makes chord steps, or a step with a new Jacobian.
    #[inline(never)]
    pub(super) fn step<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        mut newton: Newton,
    ) -> Outcome {
        let chord =
            if newton.reuse { self.chord_steps(monitor, &mut newton.reuse) } else { Chord::Unavailable };
        let accepted = match chord {
            Chord::Accepted => true,
            _ if newton.sweeps_first => return Outcome::NoJacobian,
            Chord::Undone => return Outcome::Accepted(newton),
            Chord::Unavailable => self.step_anew(monitor, &mut newton),
        };
        newton.remaining_steps = newton.remaining_steps.saturating_sub(1);
        if monitor.must_return() || accepted && newton.remaining_steps > 0 {
            Outcome::Accepted(newton)
        } else {
            Outcome::Rejected
        }
    }

    /// Makes up to [`tuning::chord_steps`] chord steps, while the active set stays the same and each lowers the merit tenfold. `again` tells
    /// whether the next step begins with chord steps, too.
    #[inline(never)]
    fn chord_steps<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        again: &mut bool,
    ) -> Chord {
        if !self.holds_jacobian || !self.has_same_active_set(monitor) {
            return Chord::Unavailable;
        }
        let (start, before) = (self.point.z, self.point.merit);
        *again = true;
        for _ in 0..tuning::chord_steps() {
            monitor.solution.work.chord_steps += 1;
            let (z, merit) = (self.point.z, self.point.merit);
            let Some(step) = self.chord_step(monitor) else {
                self.go_back(monitor, &start);
                break;
            };
            self.evaluate_at(monitor, &z, &step, T::ONE);
            let fast = self.point.merit < merit * tuning::chord_fall();
            *again = fast && self.has_same_active_set(monitor);
            if monitor.must_return() {
                return Chord::Accepted;
            }
            if !*again {
                break;
            }
        }
        if self.point.merit < before {
            return Chord::Accepted;
        }
        *again = false;
        self.go_back(monitor, &start);
        Chord::Undone
    }

    /// Is the active set at the point that of the kept Jacobian?
    fn has_same_active_set<const N: usize, const S: usize>(
        &self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> bool {
        let sets = &monitor.problem.sets;
        self.jacobian.has_same_active_set(sets, &self.point)
    }

    /// The chord step at the point.
    fn chord_step<const N: usize, const S: usize>(
        &self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Option<Stacked<T, D, C, R>> {
        let residual = &self.point.residual;
        let Problem { sets, factor, .. } = &*monitor.problem;
        let delassus = factor.delassus();
        self.jacobian.step(sets, delassus, residual, &self.matrix)
    }

    /// Makes a step with a new Jacobian. Returns true if a length was accepted.
    #[inline(never)]
    fn step_anew<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        newton: &mut Newton,
    ) -> bool {
        monitor.solution.work.newton_steps += 1;
        let problem = &*monitor.problem;
        let may_centre = matches!(newton.origin, Origin::LastSolution | Origin::Cold);
        let centred =
            may_centre && problem.is_hyperstatic(&self.point.r, problem.sets.holding_rows(&self.point.r));
        let damping = newton.damping(self.point.estimate, centred);
        self.forget();
        let (jacobian, matrix) = (&mut self.jacobian, &mut self.matrix);
        let (sets, delassus) = (&problem.sets, problem.factor.delassus());
        let computed = jacobian.compute(sets, delassus, &self.point, damping, matrix);
        self.holds_jacobian = computed.is_some();
        let step = computed.and_then(|()| {
            let residual = if centred { self.jacobian.centred(&self.point) } else { self.point.residual };
            self.jacobian.step(sets, delassus, &residual, &self.matrix)
        });
        let before = self.point.merit;
        let rise = newton.may_raise_merit.then(tuning::merit_growth);
        let length = step.and_then(|step| self.search_line(monitor, &step, rise));
        if length == Some(T::ONE) {
            newton.may_raise_merit &= self.point.merit < before;
            newton.reuse = self.point.merit < before * tuning::chord_fall();
        }
        let lowers = self.point.merit < before * rise.unwrap_or(T::ONE);
        if monitor.must_return() && !lowers {
            newton.remaining_steps = 0; // rejected, unless the check finds a solution
        }
        if length.is_none() {
            monitor.note_failure();
        }
        length.is_some()
    }

    /// Takes the first of [`tuning::LENGTHS`] of a step that lowers the merit, and returns it. A full step may raise the merit by the factor
    /// `rise`. If no length is accepted, the point stays where it was.
    #[inline(never)]
    fn search_line<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        step: &Stacked<T, D, C, R>,
        rise: Option<T>,
    ) -> Option<T> {
        let (start, before) = (self.point.z, self.point.merit);
        for length in tuning::LENGTHS {
            let length = T::literal(length);
            self.evaluate_at(monitor, &start, step, length);
            let share = rise.filter(|_| length == T::ONE).unwrap_or(T::ONE);
            if self.point.merit < before * share || monitor.must_return() {
                return Some(length);
            }
        }
        self.go_back(monitor, &start);
        None
    }

    /// Moves the point to `start + length step`, and shows it to the monitor.
    fn evaluate_at<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        start: &Stacked<T, D, C, R>,
        step: &Stacked<T, D, C, R>,
        length: T,
    ) {
        self.point.z = Stacked::along(start, step, length);
        self.point.update(monitor.problem);
        self.consider(monitor);
    }

    /// Moves the point back to an earlier `z`.
    fn go_back<const N: usize, const S: usize>(
        &mut self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
        start: &Stacked<T, D, C, R>,
    ) {
        self.point.z = *start;
        self.point.update(monitor.problem);
    }
}

#[cfg(test)]
mod tests;
