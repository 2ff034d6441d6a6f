//! Newton's part of the default method.

use crate::cholesky::rolled;
use crate::chord::Chord;
use crate::progress::{Phase, Progress, Workspace};
use crate::search::Search;
use crate::{Factor, Real};
use nalgebra::SVector;

/// Newton's method, from one piece of work to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refinement<T> {
    /// At most so many more pieces, as long as they are accepted.
    left: usize,
    /// So many full steps may raise the energy, each a hundredfold at most. From the last solution to
    /// one in which a contact does something else, that is the way.
    bold: usize,
    /// Is the last linearisation worth another step?
    again: bool,
    /// Are sweeps to come before a new linearisation?
    sweeps: bool,
    /// The natural map it began with, if it began at the last solution.
    warm: Option<T>,
}

impl<T: Real> Refinement<T> {
    /// From somewhere near a solution.
    pub(crate) const fn new() -> Self {
        Self {
            left: 30,
            bold: 0,
            again: false,
            sweeps: false,
            warm: None,
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
            warm: Some(natural_map),
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
        refinement.left -= usize::from(refinement.left > 0);
        if accepted && refinement.left > 0 {
            self.phase = Phase::Refine(refinement);
        } else if refinement.warm.is_some() {
            self.begin_anew(search, factor, workspace);
        } else {
            self.phase = Phase::Recover;
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
        let natural_map = refinement.warm.unwrap_or(self.point.natural_map);
        let regularisation = self.caution.regularisation(natural_map);
        let (problem, scale, matrix) =
            (&*search.problem, self.balance.scale, &mut resolvent.matrix);
        let computed = linearisation.compute(problem, &self.point, scale, regularisation, matrix);
        let redundant = problem.is_hyperstatic(&self.point.impulse);
        let residual = if redundant && refinement.warm.is_some() {
            linearisation.centred(&self.point)
        } else {
            self.point.residual
        };
        let step = computed.and_then(|()| linearisation.step(problem, &residual, matrix));
        let before = self.point.energy;
        let bold = refinement.bold > 0;
        let gone = step.and_then(|step| self.go(search, &step, bold));
        if gone == Some(T::ONE) {
            refinement.bold -= usize::from(self.point.energy >= before && bold);
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

    /// Goes along a step by the first of some lengths at which the energy falls, and if `bold` a full
    /// step may raise it; if by none, stays.
    #[inline(never)]
    fn go<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        step: &[SVector<T, D>; C],
        bold: bool,
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
            let enough = if bold && length == T::ONE {
                T::literal(1e2)
            } else {
                T::ONE - T::literal(2e-4) * length
            };
            if self.point.energy < before * enough || search.is_over() {
                return Some(length);
            }
        }
        self.go_back(search, &start);
        None
    }
}
