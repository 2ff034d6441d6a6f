//! Where a solve stands: all that one piece of work leaves for the next.
//!
//! The pieces are one Gauss-Seidel sweep, one ADMM iteration, steps with the matrix that was kept and
//! where they are no good a Newton step, and another attempt. Because nothing else is carried from one to the next,
//! a solve can stop after any of them and go on later with the same bits.

use crate::admm::{Iterate, Restart};
use crate::cholesky::rolled;
use crate::contact_space::ContactVector;
use crate::newton::Point;
use crate::outlook::Outlook;
use crate::refinement::Refinement;
use crate::safeguard::{Balance, Caution};
use crate::search::Search;
use crate::state::{Start, State};
use crate::sweeping::Sweeping;
use crate::workspace::Workspace;
use crate::{Factor, Real};
use nalgebra::SVector;

mod approach;

/// What comes next.
#[derive(Clone, Copy, Debug)]
#[repr(u8)] // so that `Idle` is zero, and a new solver takes no flash
pub(crate) enum Phase<T> {
    /// Nothing: no solve was begun.
    Idle,
    /// So many more iterations of Algorithm 2.
    Approach {
        left: usize,
    },
    /// More sweeps.
    Sweep,
    Refine(Refinement<T>),
    /// Another attempt, with other penalties or from elsewhere.
    Recover,
}

/// A solve by the default method: sweeps or Algorithm 2 for a start, semismooth Newton to the end.
#[derive(Clone, Debug)]
pub(crate) struct Progress<T, const D: usize, const C: usize> {
    pub(crate) phase: Phase<T>,
    pub(crate) point: Point<T, D, C>,
    iterates: [Iterate<T, D>; C],
    acceleration: Restart<T>,
    pub(crate) caution: Caution<T>,
    pub(crate) balance: Balance<T>,
    /// Does the workspace hold the resolvent in use?
    has_own: bool,
    /// Have there been other attempts?
    has_recovered: bool,
    /// Have sweeps from rest been tried, or are they of no use?
    has_swept: bool,
    /// What was left for a side branch.
    pub(crate) aside: Option<Corner<T, D, C>>,
    pub(crate) sweeping: Sweeping<T, C>,
    /// The impulses of the last side branch, from which the next one goes on.
    pub(crate) swept: ContactVector<T, D, C>,
    /// Iterations of the next approach.
    length: usize,
}

/// `P` and `r` of a point.
type Corner<T, const D: usize, const C: usize> = ([SVector<T, D>; C], [[T; D]; C]);

impl<T: Real, const D: usize, const C: usize> Progress<T, D, C> {
    /// Of no solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            phase: Phase::Idle,
            point: Point::zero(),
            iterates: [const { Iterate::none() }; C],
            acceleration: Restart::none(),
            caution: Caution::none(),
            balance: Balance::none(),
            has_own: false,
            has_recovered: false,
            has_swept: false,
            aside: None,
            sweeping: Sweeping::none(),
            swept: [[T::ZERO; D]; C],
            length: 0,
        }
    }

    /// Begins a solve at the last solution, or at rest.
    pub(crate) fn begin<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
        state: &mut State<T, D, C>,
    ) {
        self.balance = Balance::new();
        self.caution = Caution::new();
        self.has_own = false;
        self.has_recovered = false;
        self.has_swept = !search.problem.can_be_swept();
        self.aside = None;
        self.swept = [[T::ZERO; D]; C];
        self.length = 5;
        if let Some(places) = state.follow(search.problem.scene.contacts()) {
            workspace.linearisation.follow(&places);
        }
        let (scale, tolerance) = (self.balance.scale, search.tolerance());
        let start = state.start(search.problem, scale, tolerance, &mut self.point);
        self.consider(search);
        // Good enough for contact space, but not once its velocity was known?
        let corrected = self.point.natural_map <= tolerance && !search.is_over();
        let refinement = Refinement::warm(self.point.natural_map, start == Start::Unique);
        match start {
            Start::Rest if !corrected => self.set_off(search, factor, workspace, true),
            Start::Unique if !corrected && !workspace.linearisation.is_kept() => {
                self.begin_sweeps();
            }
            Start::Rest | Start::Unique => {
                self.settle(search, refinement);
            }
            Start::Redundant => {
                self.caution = Caution::warm();
                self.phase = Phase::Refine(refinement);
                if corrected {
                    self.point.rebuild(search.problem, scale);
                }
            }
        }
    }

    /// Is there no solve to go on with?
    pub(crate) fn is_idle(&self) -> bool {
        matches!(self.phase, Phase::Idle)
    }

    /// Leaves the solve.
    pub(crate) fn stop(&mut self) {
        self.phase = Phase::Idle;
    }

    /// One piece of work.
    pub(crate) fn advance<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
    ) {
        match self.phase {
            Phase::Idle => {}
            Phase::Approach { left } => self.iterate(search, factor, workspace, left),
            Phase::Sweep => self.sweep_on(search, factor, workspace),
            Phase::Refine(refinement) => self.refine(search, factor, workspace, refinement),
            Phase::Recover => self.recover(search, factor, workspace),
        }
    }

    /// Leaves a last solution, or a guess, that was misleading, for rest.
    pub(crate) fn begin_anew<const N: usize>(
        &mut self,
        search: &Search<'_, '_, T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
    ) {
        self.caution = Caution::new();
        self.point.rest(search.problem);
        self.set_off(search, factor, workspace, false);
    }

    /// Sets off from rest, or from a guess if it may.
    fn set_off<const N: usize>(
        &mut self,
        search: &Search<'_, '_, T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
        may_guess: bool,
    ) {
        match search.problem.outlook() {
            Outlook::Unique if search.problem.can_be_swept() => {
                self.has_swept = true;
                self.begin_sweeps();
            }
            Outlook::Held if may_guess => {
                search.problem.stand(&mut self.point.z);
                self.point.update(search.problem, self.balance.scale);
                self.phase = Phase::Refine(Refinement::guessed());
            }
            _ => self.approach(factor, workspace),
        }
    }

    /// Goes to `start + step length`, and considers what is there.
    pub(crate) fn visit<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        start: &[SVector<T, D>; C],
        step: &[SVector<T, D>; C],
        length: T,
    ) {
        self.point.go(start, step, length);
        self.point.update(search.problem, self.balance.scale);
        self.consider(search);
    }

    /// Goes back to a `z` that was considered before.
    pub(crate) fn go_back<const N: usize>(
        &mut self,
        search: &Search<'_, '_, T, N, D, C>,
        start: &[SVector<T, D>; C],
    ) {
        self.point.z = *start;
        self.point.update(search.problem, self.balance.scale);
    }

    pub(crate) fn consider<const N: usize>(&self, search: &mut Search<'_, '_, T, N, D, C>) {
        let point = &self.point;
        search.consider(&point.impulse, &point.relative, point.natural_map);
    }

    /// What Newton leaves goes back to ADMM, with penalties that its residuals balance.
    #[cfg_attr(target_os = "none", inline(never))]
    fn recover<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
    ) {
        if self.has_recovered {
            self.balance.update(search.cost());
        } else if !self.has_swept {
            self.has_swept = true;
            self.sweep_from_rest(search);
            return;
        }
        self.has_recovered = true;
        let penalties = search.problem.penalties(self.balance.scale);
        self.resolve(search, factor, workspace, &penalties);
        self.length = 8;
        if self.balance.has_restarted() {
            self.caution.forget();
            self.length = 20;
            // Now and then from elsewhere; if that does not help, back to where it was.
            if let Some(last) = self.aside.take() {
                (self.point.velocity, self.point.impulse) = last;
            } else if self.balance.turns_aside() && search.problem.can_be_swept() {
                self.aside = Some((self.point.velocity, self.point.impulse));
                self.sweep_aside(search);
            }
            self.point.rebuild(search.problem, self.balance.scale);
        }
        if search.take_lost() {
            self.point.rest(search.problem);
        }
        self.approach(factor, workspace);
    }

    /// `ũ` and `r` of each contact as they stand.
    pub(crate) fn contacts(&self) -> impl Iterator<Item = (SVector<T, D>, SVector<T, D>)> {
        let point = &self.point;
        let points = point.velocity.iter().zip(&point.impulse);
        let contacts = points.zip(&point.relative).zip(&self.iterates);
        contacts.map(|(((&velocity, &r), &u), iterate)| match self.phase {
            Phase::Approach { .. } => (iterate.u, iterate.impulse()),
            Phase::Sweep => (u.into(), r.into()),
            _ => (velocity, r.into()),
        })
    }

    /// Ends a call.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn finish<const N: usize>(&self, search: &mut Search<'_, '_, T, N, D, C>) {
        search.finish(&self.impulse());
        search.doubt();
    }

    /// `r` as it stands.
    fn impulse(&self) -> [[T; D]; C] {
        let mut impulse = [[T::ZERO; D]; C];
        for (impulse, (_, r)) in impulse.iter_mut().zip(self.contacts()) {
            rolled();
            *impulse = r.into();
        }
        impulse
    }
}
