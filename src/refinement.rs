//! Newton's part of the default method.

use crate::cholesky::rolled;
use crate::chord::Chord;
use crate::progress::{Phase, Progress};
use crate::search::Search;
use crate::workspace::Workspace;
use crate::{Factor, Real};
use nalgebra::SVector;

/// Newton's method, from one piece of work to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refinement<T> {
    /// At most so many more pieces, as long as they are accepted.
    left: u8,
    /// So many full steps may raise the energy. From the last solution to one in which a contact does
    /// something else, that is the way.
    bold: u8,
    /// Is the last linearisation worth another step?
    again: bool,
    /// Are sweeps to come before a new linearisation?
    sweeps: bool,
    origin: Origin<T>,
}

/// Where a refinement began.
#[derive(Clone, Copy, Debug)]
enum Origin<T> {
    /// Somewhere near a solution.
    Near,
    /// At the last solution, with the natural map it has now.
    Last(T),
    /// At a guess, of which the energy says nothing.
    Guess,
}

impl<T: Real> Refinement<T> {
    /// From somewhere near a solution.
    pub(crate) const fn new() -> Self {
        Self {
            left: 30,
            bold: 0,
            again: false,
            sweeps: false,
            origin: Origin::Near,
        }
    }

    /// From a guess.
    pub(crate) const fn guessed() -> Self {
        Self {
            left: 6,
            bold: 1,
            origin: Origin::Guess,
            ..Self::new()
        }
    }

    /// From the last solution, with the natural map it has now; no longer than what a cold start may
    /// well take.
    pub(crate) const fn warm(natural_map: T, sweeps: bool) -> Self {
        Self {
            left: 6,
            bold: 2,
            again: true,
            sweeps,
            origin: Origin::Last(natural_map),
        }
    }
}

impl<T: Real, const D: usize, const C: usize> Progress<T, D, C> {
    /// Steps with the linearisation that was kept, or where that is no good a Newton step.
    #[inline(never)]
    pub(crate) fn refine<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
        mut refinement: Refinement<T>,
    ) {
        let again = self.step_again(search, workspace, &mut refinement);
        if !again && refinement.sweeps {
            // They find out for less than a Newton step what a contact does now.
            workspace.forget();
            self.begin_sweeps();
            return;
        }
        let accepted = again || self.step(search, workspace, &mut refinement);
        refinement.left -= u8::from(refinement.left > 0);
        if accepted && refinement.left > 0 {
            self.phase = Phase::Refine(refinement);
            return;
        }
        match refinement.origin {
            Origin::Near => self.phase = Phase::Recover,
            Origin::Last(_) | Origin::Guess => self.begin_anew(search, factor, workspace),
        }
    }

    /// Steps with the linearisation of an earlier point, if it is worth that.
    fn step_again<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        workspace: &Workspace<T, D, C>,
        refinement: &mut Refinement<T>,
    ) -> bool {
        let (linearisation, scale) = (&workspace.linearisation, self.balance.scale);
        if !refinement.again || !linearisation.suits(search.problem, &self.point, scale) {
            return false;
        }
        let chord = self.chord(search, workspace);
        refinement.again = chord == Chord::Good;
        chord != Chord::Useless
    }

    #[inline(never)]
    fn step<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
        refinement: &mut Refinement<T>,
    ) -> bool {
        search.solution.newton_steps += 1;
        let Workspace {
            linearisation,
            resolvent,
        } = workspace;
        // What is kept for the next solve has to be regularised like its first step.
        let (natural_map, is_warm) = match refinement.origin {
            Origin::Last(natural_map) => (natural_map, true),
            Origin::Near | Origin::Guess => (self.point.natural_map, false),
        };
        let regularisation = self.caution.regularisation(natural_map);
        let (problem, scale, matrix) =
            (&*search.problem, self.balance.scale, &mut resolvent.matrix);
        let computed = linearisation.compute(problem, &self.point, scale, regularisation, matrix);
        let redundant = problem.is_hyperstatic(&self.point.impulse);
        let residual = if redundant && is_warm {
            linearisation.centred(&self.point)
        } else {
            self.point.residual
        };
        let step = computed.and_then(|()| linearisation.step(problem, &residual, matrix));
        let before = self.point.energy;
        let rise = match refinement.origin {
            _ if refinement.bold == 0 => None,
            Origin::Guess => Some(T::literal(1e5)),
            Origin::Near | Origin::Last(_) => Some(T::literal(1e2)),
        };
        let gone = step.and_then(|step| self.go(search, &step, rise));
        if gone == Some(T::ONE) {
            refinement.bold -= u8::from(self.point.energy >= before && rise.is_some());
            self.caution.relax();
            refinement.again = self.point.energy < before * T::literal(0.01);
        }
        if gone.is_none() {
            self.caution.reject(before);
            if self.caution.is_first_rejection() {
                search.look_for_proof();
            }
            search.fail();
        }
        gone.is_some()
    }

    /// Goes along a step by the first of some lengths at which the energy falls, unless a full step may
    /// raise it, so many times at most; if by none, stays.
    #[inline(never)]
    fn go<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        step: &[SVector<T, D>; C],
        rise: Option<T>,
    ) -> Option<T> {
        let (start, before) = (self.point.z, self.point.energy);
        let lengths = [
            T::ONE,
            T::literal(0.5),
            T::literal(0.25),
            T::literal(0.1),
            T::literal(0.02),
        ];
        let tried = if self.balance.has_ever_restarted() {
            5
        } else {
            2
        };
        for &length in lengths.get(..tried)? {
            rolled();
            self.visit(search, &start, step, length);
            let fall = T::ONE - T::literal(2e-4) * length;
            let enough = rise.filter(|_| length == T::ONE).unwrap_or(fall);
            if self.point.energy < before * enough || search.is_over() {
                return Some(length);
            }
        }
        self.go_back(search, &start);
        None
    }
}
