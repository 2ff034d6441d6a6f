//! Gauss-Seidel's part of the default method.

use crate::gauss_seidel;
use crate::progress::{Phase, Progress};
use crate::refinement::Refinement;
use crate::search::Search;
use crate::workspace::Workspace;
use crate::{Factor, Real};
use core::mem;

/// Sweeps, from one to the next.
#[derive(Clone, Debug)]
pub(crate) struct Sweeping<T, const C: usize> {
    /// `λ` of each contact.
    drags: [T; C],
    /// Sweeps so far.
    done: usize,
    /// Did they begin at rest?
    rests: bool,
    /// If they are a side branch: the natural map that makes it worth staying there.
    bar: Option<T>,
}

impl<T: Real, const C: usize> Sweeping<T, C> {
    /// Of no solve yet.
    pub(crate) const fn none() -> Self {
        Self {
            drags: [T::ZERO; C],
            done: 0,
            rests: false,
            bar: None,
        }
    }
}

impl<T: Real, const D: usize, const C: usize> Progress<T, D, C> {
    /// Begins sweeps at the point.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn begin_sweeps(&mut self) {
        self.sweeping = Sweeping {
            rests: self.point.impulse == [[T::ZERO; D]; C],
            ..Sweeping::none()
        };
        self.phase = Phase::Sweep;
    }

    /// Begins sweeps at rest, which have to find something far better than what is here.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn sweep_from_rest<const N: usize>(&mut self, search: &Search<'_, '_, T, N, D, C>) {
        let bar = self.point.natural_map * T::literal(0.1);
        self.aside = Some((self.point.velocity, self.point.impulse));
        self.point.rest(search.problem);
        self.begin_sweeps();
        self.sweeping.bar = Some(bar);
    }

    /// Goes where 20 more sweeps lead than the last time.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn sweep_aside<const N: usize>(&mut self, search: &mut Search<'_, '_, T, N, D, C>) {
        self.point.impulse = self.swept;
        let (impulse, relative) = (&self.point.impulse, &mut self.point.relative);
        search.problem.natural_map(impulse, relative);
        self.sweeping = Sweeping::none();
        for _ in 0..20 {
            self.sweep(search);
        }
        self.swept = self.point.impulse;
        self.lift(search);
    }

    fn sweep<const N: usize>(&mut self, search: &mut Search<'_, '_, T, N, D, C>) {
        search.solution.iterations += 2;
        let (impulse, relative) = (&mut self.point.impulse, &mut self.point.relative);
        gauss_seidel::sweep(search.problem, impulse, relative, &mut self.sweeping.drags);
    }

    /// One sweep. A Newton step costs as much as five: they go on while they are fast, or while five
    /// more at this rate reach the end.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn sweep_on<const N: usize>(
        &mut self,
        search: &mut Search<'_, '_, T, N, D, C>,
        factor: &Factor<T, N, D, C>,
        workspace: &mut Workspace<T, D, C>,
    ) {
        self.sweep(search);
        let (impulse, relative) = (&self.point.impulse, &self.point.relative);
        let here = search.problem.natural_map_at(impulse, relative);
        let last = mem::replace(&mut self.point.natural_map, here);
        self.consider(search);
        if search.is_over() {
            return;
        }
        let sweeping = &mut self.sweeping;
        sweeping.done += 1;
        // Of rest the natural map says nothing.
        let first = sweeping.rests && sweeping.done == 1;
        let rate = if first { T::ZERO } else { here / last };
        let (problem, half) = (&search.problem, T::literal(0.5));
        let hyperstatic = problem.is_hyperstatic(impulse);
        let locked = hyperstatic && problem.is_locked(impulse);
        let fast = rate < half && sweeping.done < if locked { 2 } else { 3 };
        let (square, tolerance) = (rate * rate, search.tolerance());
        let in_reach = here * square * square * rate <= tolerance && sweeping.done < 20;
        if here > tolerance && (fast || in_reach) {
            return;
        }
        let rests = sweeping.rests;
        let far = locked || rate > half && (hyperstatic || here > T::literal(0.1));
        if let Some(bar) = sweeping.bar {
            self.end_side_branch(search, here < bar);
        } else if rests && far {
            self.point.rest(search.problem);
            self.approach(factor, workspace);
        } else if !rests && rate > T::ONE {
            self.begin_anew(search, factor, workspace);
        } else {
            let refinement = if rests {
                Refinement::new()
            } else {
                Refinement::warm(here, false)
            };
            self.settle(search, refinement);
        }
    }

    /// Stays where sweeps from rest have led, or goes back.
    fn end_side_branch<const N: usize>(
        &mut self,
        search: &Search<'_, '_, T, N, D, C>,
        is_better: bool,
    ) {
        match self.aside.take() {
            Some(last) if !is_better => {
                (self.point.velocity, self.point.impulse) = last;
                self.point.rebuild(search.problem, self.balance.scale);
                self.phase = Phase::Recover;
            }
            _ => {
                self.settle(search, Refinement::new());
            }
        }
    }

    /// Goes on with Newton's method from the impulses and `u` that sweeps or an impulse carried on have left.
    #[inline]
    pub(crate) fn settle<const N: usize>(
        &mut self,
        search: &Search<'_, '_, T, N, D, C>,
        refinement: Refinement<T>,
    ) {
        self.make_point(search);
        self.phase = Phase::Refine(refinement);
    }

    /// The point that has these impulses and `u`.
    #[cfg_attr(target_os = "none", inline(never))]
    fn make_point<const N: usize>(&mut self, search: &Search<'_, '_, T, N, D, C>) {
        self.lift(search);
        self.point.rebuild(search.problem, self.balance.scale);
    }

    /// Takes `û` for the velocity.
    fn lift<const N: usize>(&mut self, search: &Search<'_, '_, T, N, D, C>) {
        let point = &mut self.point;
        search.problem.lift(&point.relative, &mut point.velocity);
    }
}
