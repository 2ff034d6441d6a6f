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
//! [`RestQuestion`] is the state of the question. This file decides what follows, at the start of a solve, after a piece of work, after a
//! failure, and at the end of a call:
//!
//! | from | when | to |
//! |---|---|---|
//! | closed | the solve starts, and the last solution was at rest | pending |
//! | closed | the solve starts, and a rest that was disturbed is still a solution | centring |
//! | pending | a solution leaves the rest | open with a solution; the central path |
//! | pending | a solution stays | closed |
//! | pending | Newton's method fails from the last solution | open; Newton's method from there |
//! | open, with a solution or without | Newton's method fails from a cold start | the same; the central path |
//! | open, with a solution or without | the path jams, or not all bodies can stay | closed |
//! | open, with a solution or without | a solution at rest is exact enough | closed: solved |
//! | centring | any failure, or impulses farther inside are exact enough | closed: solved |
//! | open with a solution, centring | the call ends | closed: solved |
//!
//! `monitor` evaluates points while the question is open or impulses are centred: the relaxation is then solved in place of Coulomb's law.
//! `motion` says what moves and what may stay.

use crate::real::Real;
use crate::solution::Model;
use crate::solver::method::{Method, Phase};
use crate::solver::monitor::Monitor;
use crate::solver::newton::{Newton, Origin};
use crate::solver::phases::Phases;
use crate::solver::record::{Record, RestQuestion};
use crate::solver::warm_start::WarmStart;

mod monitor;
mod motion;

/// A body at rest was disturbed if the estimate of its last solution exceeds this.
const DISTURBED: f64 = 0.01;

impl<T: Real, const D: usize, const C: usize, const R: usize> Record<T, D, C, R> {
    /// Is the relaxation solved in place of Coulomb's law, because the question is open or impulses are centred?
    pub(super) fn solves_relaxation(&self) -> bool {
        self.has_fallback() || self.rest == RestQuestion::Open
    }

    /// Are the best impulses a solution, to fall back on if the rest question is closed without an answer?
    pub(super) fn has_fallback(&self) -> bool {
        matches!(self.rest, RestQuestion::OpenWithSolution | RestQuestion::Centring)
    }
}

impl<T: Real, const D: usize, const C: usize, const R: usize, P: Phases> Method<T, D, C, R, P> {
    /// Asks at the start of a solve, if the last solution was at rest. Returns the first phase if the question opens at once.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn ask_at_start<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        warm_start: &mut WarmStart<T, D, C, R>,
    ) -> Option<Phase> {
        let tolerance = monitor.tolerance();
        if monitor.problem.has_spare_rows()
            && (!monitor.is_over() || warm_start.has_crept(monitor.creeps(&self.state.point)))
            && warm_start.is_at_rest(monitor.problem, tolerance)
        {
            monitor.record.rest = RestQuestion::Pending;
            if monitor.leaves_rest(&self.state.point) {
                return Some(self.begin_path(monitor));
            }
            warm_start.is_disturbed |= self.state.point.estimate > T::literal(DISTURBED);
        }
        if warm_start.is_disturbed && monitor.is_over() {
            warm_start.is_disturbed = false;
            if monitor.problem.is_likely_to_stick() && warm_start.is_at_rest(monitor.problem, tolerance) {
                monitor.begin_centring();
                return Some(self.begin_guess(monitor, Newton::centring()));
            }
        }
        None
    }

    /// Asks after a piece of work: opens the question if the solution leaves a rest, and closes it once the answer is no.
    #[inline]
    pub(super) fn ask_after_piece<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        if monitor.record.rest != RestQuestion::Closed {
            self.open_or_close(monitor);
        }
    }

    /// The part of [`Self::ask_after_piece`] in which there is a question.
    #[cfg_attr(target_os = "none", inline(never))]
    fn open_or_close<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        if monitor.leaves_rest(&self.state.point) {
            self.phase = self.begin_path(monitor);
        } else if monitor.problem.is_relaxed() && monitor.cannot_rest(&self.state.point) {
            self.phase = self.close(monitor);
        }
    }

    /// Asks after a failure: a rejected step of Newton's method that began at `origin`, or without one a jam of the central path. Returns the next
    /// phase if the question decides it.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn ask_after_failure<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
        origin: Option<Origin>,
    ) -> Option<Phase> {
        match (monitor.record.rest, origin) {
            (RestQuestion::Pending, Some(Origin::LastSolution)) => {
                monitor.open_rest_question(RestQuestion::Open);
                Some(self.begin_newton(monitor, Newton::new()))
            }
            (RestQuestion::Closed | RestQuestion::Pending, _) => None,
            (RestQuestion::Centring, _) | (_, None) => Some(self.close(monitor)),
            (question, Some(Origin::Cold)) => {
                if question == RestQuestion::Open {
                    monitor.look_for_proof(); // where a solution is known there is no proof
                }
                Some(self.begin_path(monitor))
            }
            (_, Some(_)) => None,
        }
    }

    /// Closes the question: not all bodies can stay, or the answer was not found. Returns [`Phase::Idle`] if a solution is known,
    /// otherwise the first phase of the search for one.
    #[cfg_attr(target_os = "none", inline(never))]
    fn close<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) -> Phase {
        if let Some(solution) = monitor.close_rest_question() {
            let point = &mut self.state.point;
            point.r = solution; // the next solve starts there
            point.evaluate_impulses(monitor.problem);
            point.rebuild_from_velocity(monitor.problem);
            return Phase::Idle;
        }
        monitor.look_for_proof();
        self.state.point.set_zero_impulse(monitor.problem);
        self.begin_cold(monitor, false)
    }

    /// At the end of a call: closes an open question if a solution is known; otherwise lets the monitor evaluate impulses by
    /// Coulomb's law.
    pub(crate) fn end_rest_question<const N: usize, const S: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, R, S>,
    ) {
        if monitor.record.has_fallback() && !monitor.is_over() {
            self.phase = self.close(monitor);
        } else if monitor.problem.is_relaxed() {
            monitor.problem.set_law(Model::Coulomb);
        }
    }
}
