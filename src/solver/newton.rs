//! Newton's part of the method: a step with the Jacobian that was kept or with a new one, and how far along it.

use crate::linalg::stacked::Stacked;
use crate::problem::Problem;
use crate::real::Real;
use crate::solver::monitor::Monitor;
use crate::solver::state::State;
use crate::solver::tuning;

/// Newton's method, from one step to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Newton {
    /// Steps left.
    left: u8,
    /// May the next full step raise the merit function?
    nonmonotone: bool,
    /// Is the Jacobian of an earlier point worth a step?
    reuse: bool,
    /// Are sweeps to come before a new Jacobian?
    sweeps_first: bool,
    origin: Origin,
}

/// Where Newton's method began.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Origin {
    /// At rest, or where sweeps of a cold start have led: there is no colder start.
    Cold,
    /// On the central path.
    Path,
    /// At the last solution.
    Last,
    /// At a point where all contacts stick; the merit function says nothing there.
    Guess,
}

/// What came of a step.
pub(crate) enum Outcome {
    /// There is another to come, unless the solve is over.
    Accepted(Newton),
    /// The kept Jacobian failed; a sweep finds the active set more cheaply than a new Jacobian.
    NoJacobian,
    /// No length was accepted, or there were too many steps.
    Rejected,
}

impl Newton {
    /// From rest, or from where sweeps of a cold start have led.
    pub(crate) fn new() -> Self {
        Self {
            left: u8::try_from(tuning::newton_steps()).unwrap_or(u8::MAX),
            nonmonotone: false,
            reuse: false,
            sweeps_first: false,
            origin: Origin::Cold,
        }
    }

    /// From the central path.
    pub(crate) fn finish() -> Self {
        Self {
            origin: Origin::Path,
            ..Self::new()
        }
    }

    /// From the guess that all contacts stick.
    pub(crate) fn guessed() -> Self {
        Self {
            nonmonotone: true,
            origin: Origin::Guess,
            ..Self::new()
        }
    }

    /// From the same guess, to centre impulses that are good enough: by one Jacobian.
    pub(crate) fn centring() -> Self {
        Self {
            left: 2,
            ..Self::guessed()
        }
    }

    /// From the last solution.
    pub(crate) fn warm(sweeps_first: bool) -> Self {
        Self {
            reuse: true,
            sweeps_first,
            origin: Origin::Last,
            ..Self::new()
        }
    }

    /// With one step left.
    #[cfg(test)]
    fn last() -> Self {
        Self {
            left: 1,
            ..Self::new()
        }
    }

    /// Levenberg and Marquardt's `λ`: falls with the error, down to a floor set by the rounding of `W`, so that the last
    /// steps are Newton's.
    fn damping<T: Real>(self, estimate: T, centred: bool) -> T {
        let share: T = match self.origin {
            Origin::Path => tuning::finish_damping(),
            // In hyperstatic scenes the null space changes from solve to solve, so damp more; not at a guess.
            _ if centred => tuning::hyperstatic_damping(),
            _ => tuning::damping(),
        };
        share * estimate.min(T::ONE) + T::literal(1e-12).max(T::EPSILON * T::literal(64.0))
    }

    /// Is there no step left?
    pub(crate) const fn is_spent(self) -> bool {
        self.left == 0
    }

    /// The kind of point at which it began.
    pub(crate) const fn origin(self) -> Origin {
        self.origin
    }
}

impl<T: Real, const D: usize, const C: usize, const R: usize> State<T, D, C, R> {
    /// Steps with the kept Jacobian, or a step with a new one.
    #[inline(never)]
    pub(super) fn step<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        mut newton: Newton,
    ) -> Outcome {
        let reused = if newton.reuse {
            self.reuse_jacobian(monitor, &mut newton.reuse)
        } else {
            None
        };
        let accepted = match reused {
            Some(true) => true,
            _ if newton.sweeps_first => return Outcome::NoJacobian,
            Some(false) => return Outcome::Accepted(newton),
            None => self.step_anew(monitor, &mut newton),
        };
        newton.left = newton.left.saturating_sub(1);
        if monitor.waits() || accepted && newton.left > 0 {
            Outcome::Accepted(newton)
        } else {
            Outcome::Rejected
        }
    }

    /// Up to [`tuning::chord_steps`] steps with the Jacobian of an earlier point, while the active set stays the same and the
    /// merit falls tenfold. Goes back and returns false if together they do not lower the merit; `None` if there is no such Jacobian.
    #[inline(never)]
    fn reuse_jacobian<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        again: &mut bool,
    ) -> Option<bool> {
        if !self.holds_jacobian || !self.has_same_active_set(monitor) {
            return None;
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
            if monitor.waits() {
                return Some(true);
            }
            if !*again {
                break;
            }
        }
        if self.point.merit < before {
            return Some(true);
        }
        *again = false;
        self.go_back(monitor, &start);
        Some(false)
    }

    /// Does everything do at the point what it did where the Jacobian was computed?
    fn has_same_active_set<const N: usize, const S: usize>(
        &self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> bool {
        let sets = &monitor.problem.sets;
        self.jacobian.has_same_active_set(sets, &self.point)
    }

    /// The step at the point with the Jacobian that is kept.
    fn chord_step<const N: usize, const S: usize>(
        &self,
        monitor: &Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Option<Stacked<T, D, C, R>> {
        let residual = &self.point.residual;
        let Problem { sets, factor, .. } = &*monitor.problem;
        let delassus = factor.delassus();
        self.jacobian.step(sets, delassus, residual, &self.matrix)
    }

    /// A step with a new Jacobian.
    #[inline(never)]
    fn step_anew<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        newton: &mut Newton,
    ) -> bool {
        monitor.solution.work.newton_steps += 1;
        let problem = &*monitor.problem;
        let settled = matches!(newton.origin, Origin::Last | Origin::Cold);
        let centred = settled && problem.is_hyperstatic(&self.point.r);
        let damping = newton.damping(self.point.estimate, centred);
        self.forget();
        let (jacobian, matrix) = (&mut self.jacobian, &mut self.matrix);
        let (sets, delassus) = (&problem.sets, problem.factor.delassus());
        let computed = jacobian.compute(sets, delassus, &self.point, damping, matrix);
        self.holds_jacobian = computed.is_some();
        let step = computed.and_then(|()| {
            let residual = if centred {
                self.jacobian.centred(&self.point)
            } else {
                self.point.residual
            };
            self.jacobian.step(sets, delassus, &residual, &self.matrix)
        });
        let before = self.point.merit;
        let rise = newton.nonmonotone.then(tuning::merit_growth);
        let length = step.and_then(|step| self.search_line(monitor, &step, rise));
        if length == Some(T::ONE) {
            newton.nonmonotone &= self.point.merit < before;
            newton.reuse = self.point.merit < before * tuning::chord_fall();
        }
        let lowers = self.point.merit < before * rise.unwrap_or(T::ONE);
        if monitor.waits() && !lowers {
            newton.left = 0; // rejected, unless it is good enough
        }
        if length.is_none() {
            monitor.note_failure();
        }
        length.is_some()
    }

    /// Takes the first of [`tuning::LENGTHS`] of a step that lowers the merit (a full one may raise it by a `rise`); if none
    /// does, stays.
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
            if self.point.merit < before * share || monitor.waits() {
                return Some(length);
            }
        }
        self.go_back(monitor, &start);
        None
    }

    /// Goes to `start + length step`, and shows what is there to the monitor.
    fn evaluate_at<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        start: &Stacked<T, D, C, R>,
        step: &Stacked<T, D, C, R>,
        length: T,
    ) {
        self.point.z = Stacked::along(start, step, length);
        self.point.update(monitor.problem);
        self.consider_answer(monitor);
    }

    /// Goes back to a `z` that was shown before.
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
