//! Where a solve stands: all that one piece of work leaves for the next.
//!
//! The pieces are one ADMM iteration, steps with the matrix that was kept and where they are no good
//! sweeps or a Newton step, and another attempt. Because nothing else is carried from one to the next,
//! a solve can stop after any of them and go on later with the same bits.

use crate::admm::{Acceleration, Iterate, Restart};
use crate::cholesky::rolled;
use crate::contact_space::ContactVector;
use crate::gauss_seidel;
use crate::linearisation::Linearisation;
use crate::newton::Point;
use crate::problem::is_hyperstatic;
use crate::refinement::Refinement;
use crate::resolvent::Resolvent;
use crate::safeguard::{Balance, Caution};
use crate::search::Search;
use crate::state::State;
use crate::{Factor, Real};
use nalgebra::SVector;

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
    Refine(Refinement<T>),
    /// Another attempt, with other penalties or from elsewhere.
    Recover,
}

/// A solve by the default method: Algorithm 2 for a start, semismooth Newton to the end.
#[derive(Clone, Debug)]
pub(crate) struct Progress<T, const D: usize, const C: usize> {
    pub(crate) phase: Phase<T>,
    pub(crate) point: Point<T, D, C>,
    iterates: [Iterate<T, D>; C],
    acceleration: Restart<T>,
    pub(crate) caution: Caution<T>,
    pub(crate) balance: Balance<T>,
    /// Does the workspace hold the resolvent of adapted penalties?
    adapted: bool,
    /// Have sweeps from rest been tried?
    has_swept: bool,
    /// What was left for a side branch.
    aside: Option<Corner<T, D, C>>,
    /// The impulses that sweeps have come to; a side branch goes on from the last one.
    swept: [[T; D]; C],
    /// Iterations of the next approach.
    length: usize,
}

/// `P` and `r` of a point.
type Corner<T, const D: usize, const C: usize> = ([SVector<T, D>; C], [[T; D]; C]);

/// One matrix in contact space, by turns that of a Newton step and the resolvent of an adapted
/// penalty.
#[derive(Clone, Debug)]
pub(crate) struct Workspace<T, const D: usize, const C: usize> {
    pub(crate) resolvent: Resolvent<T, D, C>,
    pub(crate) linearisation: Linearisation<T, D, C>,
}

impl<T: Real, const D: usize, const C: usize> Workspace<T, D, C> {
    pub(crate) const fn empty() -> Self {
        Self {
            resolvent: Resolvent::empty(),
            linearisation: Linearisation::none(),
        }
    }

    /// The resolvent in use: this one if it is of adapted penalties, or that of the factor.
    fn resolvent<'a, const N: usize>(
        &'a self,
        adapted: bool,
        factor: &'a Factor<T, N, D, C>,
    ) -> &'a Resolvent<T, D, C> {
        if adapted {
            &self.resolvent
        } else {
            factor.resolvent()
        }
    }

    /// Forgets the last linearisation.
    pub(crate) fn forget(&mut self) {
        self.linearisation.forget();
    }
}

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
            adapted: false,
            has_swept: false,
            aside: None,
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
        self.adapted = false;
        self.has_swept = false;
        self.aside = None;
        self.swept = [[T::ZERO; D]; C];
        self.length = 5;
        let (problem, tolerance) = (&*search.problem, search.tolerance());
        if let Some(places) = state.follow(problem.scene.contacts()) {
            workspace.linearisation.follow(&places);
        }
        let eager = state.point(problem, self.balance.scale, tolerance, &mut self.point);
        self.consider(search);
        if eager {
            if self.point.natural_map <= tolerance && !search.is_over() {
                // Good enough for contact space, but not once its velocity was known.
                self.point.rebuild(search.problem, self.balance.scale);
            }
            self.caution = Caution::warm();
            // Where impulses are not unique, those of sweeps are lopsided.
            let unique = !is_hyperstatic::<T, N, D, C>(&self.point.impulse);
            self.phase = Phase::Refine(Refinement::warm(self.point.natural_map, unique));
        } else {
            self.approach(factor.resolvent());
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
            Phase::Approach { left } => {
                let resolvent = workspace.resolvent(self.adapted, factor);
                let (iterates, acceleration) = (&mut self.iterates, &mut self.acceleration);
                let change = search.iterate(resolvent, iterates, acceleration);
                self.balance.observe(&change);
                if left > 1 || search.is_over() {
                    self.phase = Phase::Approach {
                        left: left.saturating_sub(1),
                    };
                } else {
                    self.arrive(search);
                }
            }
            Phase::Refine(refinement) => self.refine(search, factor, workspace, refinement),
            Phase::Recover => self.recover(search, factor, workspace),
        }
    }

    /// Starts Algorithm 2 at the point.
    pub(crate) fn approach(&mut self, resolvent: &Resolvent<T, D, C>) {
        let pairs = self.point.velocity.iter().zip(&self.point.impulse);
        let pairs = pairs.zip(&resolvent.penalties);
        for (iterate, ((velocity, &impulse), &penalty)) in self.iterates.iter_mut().zip(pairs) {
            rolled();
            *iterate = Iterate::at(*velocity, impulse.into(), penalty);
        }
        self.acceleration = Restart::START;
        self.phase = Phase::Approach { left: self.length };
    }

    /// From the last iterates of Algorithm 2 to a point.
    #[inline(never)]
    fn arrive<const N: usize>(&mut self, search: &mut Search<'_, '_, T, N, D, C>) {
        let targets = self.point.velocity.iter_mut();
        let targets = targets.zip(&mut self.point.impulse);
        for ((velocity, impulse), iterate) in targets.zip(&self.iterates) {
            rolled();
            *velocity = iterate.u;
            *impulse = iterate.impulse().into();
        }
        self.point.rebuild(search.problem, self.balance.scale);
        self.consider(search);
        self.phase = if self.caution.allows(&self.point) {
            Phase::Refine(Refinement::new())
        } else {
            Phase::Recover
        };
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
    #[inline(never)]
    fn recover<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
    ) {
        if search.solution.factorizations > 0 {
            self.balance.update(search.cost());
        } else if !self.has_swept && self.sweep(search) {
            return;
        }
        let penalties = search.problem.penalties(self.balance.scale);
        workspace.forget();
        let (delassus, contacts) = (factor.delassus(), factor.contacts());
        let computed = workspace.resolvent.compute(delassus, contacts, &penalties);
        self.adapted = computed.is_ok();
        search.solution.factorizations += 1;
        self.length = 8;
        if self.balance.has_restarted() {
            self.caution.forget();
            self.length = 20;
            // Now and then from elsewhere; if that does not help, back to where it was.
            if let Some(last) = self.aside.take() {
                (self.point.velocity, self.point.impulse) = last;
            } else if self.balance.turns_aside() {
                self.aside = Some((self.point.velocity, self.point.impulse));
                let (_, u) = self.sweep_times(20, search);
                self.go_to_swept(search, &u);
            }
            self.point.rebuild(search.problem, self.balance.scale);
        }
        if search.take_lost() {
            self.point.rest(search.problem);
        }
        self.approach(workspace.resolvent(self.adapted, factor));
    }

    /// Gauss-Seidel from rest, for as long as two sweeps make the error three times smaller; goes
    /// there, if that is far better than here.
    #[inline(never)]
    fn sweep<const N: usize>(&mut self, search: &mut Search<'_, '_, T, N, D, C>) -> bool {
        self.has_swept = true;
        let here = self.point.natural_map;
        let mut last = here * T::literal(3.0);
        for _ in 0..3 {
            let (natural_map, moved) = self.try_sweeps(2, search);
            if moved {
                self.phase = Phase::Refine(Refinement::new());
                return true;
            }
            if natural_map * T::literal(3.0) > last {
                break;
            }
            last = natural_map;
        }
        self.swept = [[T::ZERO; D]; C];
        false
    }

    /// One or two sweeps from here, where the matrix that was kept is no good: they find out for less
    /// than a Newton step what a contact does now.
    pub(crate) fn sweep_on<const N: usize>(&mut self, search: &mut Search<'_, '_, T, N, D, C>) {
        let here = self.point.natural_map;
        self.swept = self.point.impulse;
        let (natural_map, _) = self.try_sweeps(1, search);
        if natural_map < here * T::literal(0.3) && !search.is_over() {
            self.try_sweeps(1, search);
        }
        self.swept = [[T::ZERO; D]; C];
    }

    /// Sweeps, and goes where they lead if that is the end or far better than here. Returns the first
    /// part of the error there, and whether it went.
    #[inline(never)]
    fn try_sweeps<const N: usize>(
        &mut self,
        count: usize,
        search: &mut Search<'_, '_, T, N, D, C>,
    ) -> (T, bool) {
        let (natural_map, u) = self.sweep_times(count, search);
        search.consider(&self.swept, &u, natural_map);
        let far_better = natural_map < self.point.natural_map * T::literal(0.1);
        let moved = far_better || search.is_over();
        if moved {
            self.go_to_swept(search, &u);
        }
        if moved && !search.is_over() {
            self.point.rebuild(search.problem, self.balance.scale);
        }
        (natural_map, moved)
    }

    /// Sweeps. Returns the first part of the error there, and `u`.
    fn sweep_times<const N: usize>(
        &mut self,
        count: usize,
        search: &mut Search<'_, '_, T, N, D, C>,
    ) -> (T, ContactVector<T, D, C>) {
        for _ in 0..count {
            search.solution.iterations += 2;
            gauss_seidel::sweep(search.problem, &mut self.swept);
        }
        let mut u = [[T::ZERO; D]; C];
        let natural_map = search.problem.natural_map(&self.swept, &mut u);
        (natural_map, u)
    }

    /// Takes the impulses that sweeps have come to, and their `û`.
    fn go_to_swept<const N: usize>(
        &mut self,
        search: &Search<'_, '_, T, N, D, C>,
        u: &ContactVector<T, D, C>,
    ) {
        search.problem.lift(u, &mut self.point.velocity);
        self.point.impulse = self.swept;
    }

    /// `ũ` and `r` of each contact as they stand.
    pub(crate) fn contacts(&self) -> impl Iterator<Item = (SVector<T, D>, SVector<T, D>)> {
        let iterating = matches!(self.phase, Phase::Approach { .. });
        let points = self.point.velocity.iter().zip(&self.point.impulse);
        points.zip(&self.iterates).map(move |((&u, &r), iterate)| {
            if iterating {
                (iterate.u, iterate.impulse())
            } else {
                (u, r.into())
            }
        })
    }

    /// `r` as it stands.
    pub(crate) fn impulse(&self) -> [[T; D]; C] {
        let mut impulse = [[T::ZERO; D]; C];
        for (impulse, (_, r)) in impulse.iter_mut().zip(self.contacts()) {
            rolled();
            *impulse = r.into();
        }
        impulse
    }
}
