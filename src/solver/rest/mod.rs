//! The rest question: can all bodies stay at rest?
//!
//! Coulomb's law may have two solutions where a body rests: one in which it stays, and one in which it slides. The solver returns the
//! first if there is one ("At rest" in [`crate::guide::error`]).
//!
//! If all loaded contacts stick, their De Saxcé shift `mu |u_T|` is 0. Then the solution also solves the convex relaxation, provided that each
//! contact without load separates with `u_N >= mu |u_T|`. (One that grazes slower makes the answer a false no.) The velocities of the
//! relaxation are unique. So the question is convex: does the solution of the relaxation obey Coulomb's law? A solve that begins at
//! rest opens the question if its solution does not solve the relaxation. The central path then solves the relaxation.
//!
//! The answer may be known early. If every `r_i` lies in its cone and every `u_i` in the dual, with `u = W r + q`, the duality
//! gap `r · u` bounds the distance to the solution `r*`, `u*` of the relaxation: `½ |r - r*|_W² <= r · u`, so
//! `alpha_i |u_i - u*_i|² <= 2 D (r · u)`.
//!
//! [`RestQuestion`] is the state of the question. It is asked after the start of a solve and after each piece of work
//! ([`Solve::ask_rest_question`]), and at the end of a call:
//!
//! | from | when | to |
//! |---|---|---|
//! | closed | the solve starts, and the last solution was at rest | pending |
//! | closed | the solve starts, and a rest that was disturbed is still a solution | centring |
//! | closed | the central path has jammed, and standing still obeys all laws | open after a jam; the central path |
//! | pending | a solution leaves the rest | open with a solution; the central path |
//! | pending | a solution stays | answered |
//! | pending | Newton's method fails from the last solution | open; Newton's method from there |
//! | open, with a solution or without | Newton's method fails from a cold start | the same; the central path |
//! | open, with a solution or without | the path jams, or not all bodies can stay | answered |
//! | open, with a solution or without | a solution at rest is exact enough | answered: solved |
//! | centring | any failure, or impulses farther inside are exact enough | answered: solved |
//! | open with a solution, centring | the call ends | answered: solved |
//!
//! `monitor` evaluates points while the question is open or impulses are centred: the relaxation is then solved in place of Coulomb's law.
//! `motion` says what moves and what may stay.

use crate::real::Real;
use crate::solution::Model;
use crate::solver::phases::Phases;
use crate::solver::record::{Record, RestQuestion};
use crate::solver::solve::Solve;
use crate::solver::state::{Failure, Newton, Next, Origin, Phase};

mod monitor;
mod motion;

/// A body at rest was disturbed if the estimate of its last solution exceeds this.
const DISTURBED: f64 = 0.01;

impl<T: Real, const D: usize, const C: usize, const R: usize> Record<T, D, C, R> {
    /// Is the relaxation solved in place of Coulomb's law, because the question is open or impulses are centred?
    pub(super) fn solves_relaxation(&self) -> bool {
        self.has_fallback() || matches!(self.rest, RestQuestion::Open | RestQuestion::OpenAfterJam)
    }

    /// Are the best impulses a solution, to fall back on if the rest question is closed without an answer?
    pub(super) fn has_fallback(&self) -> bool {
        matches!(self.rest, RestQuestion::OpenWithSolution | RestQuestion::Centring)
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Solve<'_, '_, T, N, D, C, R, S, P>
{
    /// Asks after a piece of work that leads to `next`, and returns what follows.
    #[inline]
    pub(super) fn ask_rest_question(&mut self, next: Next) -> Next {
        if let Ok(Phase::Start(_)) = next {
            return self.ask_at_start().map_or(next, Ok);
        }
        match self.monitor.record.rest {
            RestQuestion::Closed if matches!(next, Err(Failure::Jammed)) => self.ask_after_jam(next),
            RestQuestion::Closed | RestQuestion::Answered => next,
            _ => self.ask_on(next),
        }
    }

    /// Asks at the start of a solve, if the last solution was at rest. Returns the first phase if the question opens at once.
    fn ask_at_start(&mut self) -> Option<Phase> {
        if self.monitor.problem.has_spare_rows()
            && (!self.monitor.is_over() || self.warm_start.has_crept(self.monitor.creeps(&self.state.point)))
            && self.was_at_rest()
        {
            self.monitor.record.rest = RestQuestion::Pending;
            if self.monitor.leaves_rest(&self.state.point) {
                return Some(self.begin_path());
            }
            self.warm_start.is_disturbed |= self.state.point.estimate > T::literal(DISTURBED);
        }
        if self.warm_start.is_disturbed && self.monitor.is_over() {
            self.warm_start.is_disturbed = false;
            if self.monitor.problem.is_likely_to_stick() && self.was_at_rest() {
                self.monitor.begin_centring();
                return Some(self.begin_guess(Newton::centring()));
            }
        }
        None
    }

    /// Asks after the first jam: friction may lock what a path does not find.
    fn ask_after_jam(&mut self, next: Next) -> Next {
        let problem = &*self.monitor.problem;
        if self.monitor.is_over() || problem.model != Model::Coulomb || !problem.can_stand_still() {
            return next;
        }
        self.monitor.open_rest_question(RestQuestion::OpenAfterJam);
        self.evaluate_impulses();
        Ok(self.begin_path())
    }

    /// Asks where there is a question: opens it if the solution leaves a rest, and closes it once the answer is no.
    fn ask_on(&mut self, next: Next) -> Next {
        if self.monitor.leaves_rest(&self.state.point) {
            return Ok(self.begin_path());
        }
        if self.monitor.is_over() && !self.monitor.record.has_fallback() {
            return next; // proved infeasible
        }
        let next = match (self.monitor.record.rest, next) {
            (RestQuestion::Pending, Err(Failure::Rejected(Origin::LastSolution))) => {
                self.monitor.open_rest_question(RestQuestion::Open);
                Ok(self.begin_newton(Newton::new()))
            }
            (RestQuestion::Closed | RestQuestion::Answered | RestQuestion::Pending, _) => return next,
            (RestQuestion::Centring, Err(_)) | (_, Err(Failure::Jammed)) => return Ok(self.close()),
            (_, Err(Failure::Rejected(Origin::Cold))) => Ok(self.begin_path()),
            (_, next) => next,
        };
        if self.monitor.cannot_rest(&self.state.point) { Ok(self.close()) } else { next }
    }

    /// Closes the question: not all bodies can stay, or the answer was not found. Returns [`Phase::Idle`] if a solution is known,
    /// otherwise the first phase of the search for one.
    fn close(&mut self) -> Phase {
        let has_jammed = self.monitor.record.rest == RestQuestion::OpenAfterJam;
        if self.monitor.close_rest_question() {
            // The next solve starts there. (A solution has no estimate if it was found at the start.)
            self.state.point.r.copy_from(&self.monitor.record.best);
            self.evaluate_impulses();
            self.rebuild_from_velocity();
            return Phase::Idle;
        }
        if has_jammed {
            self.set_best_impulses();
            return self.leave_jam();
        }
        self.set_zero_impulse();
        self.begin_cold(false)
    }

    /// At the end of a call: closes an open question if a solution is known; otherwise lets the monitor evaluate impulses by
    /// Coulomb's law.
    pub(super) fn end_rest_question(&mut self) {
        if self.monitor.record.has_fallback() && !self.monitor.is_over() {
            self.state.phase = self.close();
        } else if self.monitor.problem.is_relaxed() {
            self.monitor.problem.set_law(Model::Coulomb);
        }
    }
}
