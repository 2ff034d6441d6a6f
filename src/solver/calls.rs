//! The common part of all solvers: the last solution, the warm start, and solves in several calls.

use crate::laws::{Coulomb, Laws};
use crate::problem::Problem;
use crate::solver::monitor::Monitor;
use crate::solver::record::Record;
use crate::solver::warm_start::WarmStart;
use crate::{Error, Factor, Real, Scene, Settings, Solution, Status};
use nalgebra::SVector;

/// The data of a call: scene, factor, free impulse and settings.
pub(crate) type Data<'a, T, const N: usize, const D: usize, const C: usize, L> = (
    &'a Scene<T, N, D, C, L>,
    &'a Factor<T, N, D, C, L>,
    &'a SVector<T, N>,
    &'a Settings<T>,
);

/// What a call does with the last solve.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Call {
    /// It begins another one.
    Begin,
    /// It begins again, with slots more.
    Again,
    /// It goes on.
    Resume,
}

/// A method of solution, one piece of work after the other.
pub(crate) trait Method<T: Real, const D: usize, const C: usize, L: Laws = Coulomb> {
    /// Does a solve that ends unsolved look for a proof of infeasibility?
    const SEEKS_PROOF: bool;

    /// Begins a solve, at the last solution if its error is less than that of zero impulses.
    fn begin<const N: usize>(
        &mut self,
        monitor: &mut Monitor<'_, '_, T, N, D, C, L>,
        warm_start: &mut WarmStart<T, D, C, L>,
    );

    /// Does one piece of work.
    fn advance<const N: usize>(&mut self, monitor: &mut Monitor<'_, '_, T, N, D, C, L>);

    /// `ũ` and `r` of each contact as they stand.
    fn contacts<const N: usize>(
        &self,
        problem: &Problem<'_, T, N, D, C, L>,
    ) -> impl Iterator<Item = (SVector<T, D>, SVector<T, D>)>;

    /// `r` of each contact as they stand.
    fn impulses(&self) -> impl Iterator<Item = SVector<T, D>>;
}

/// What a solver keeps from call to call, whatever its method.
#[derive(Clone, Debug)]
pub(crate) struct Calls<T: Real, const N: usize, const D: usize, const C: usize, L: Laws = Coulomb>
{
    pub(super) warm_start: WarmStart<T, D, C, L>,
    pub(crate) solution: Solution<T, N, D, C, L>,
    record: Record<T, D, C>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Calls<T, N, D, C, L> {
    /// Nothing solved yet.
    pub(crate) const fn none() -> Self {
        Self {
            warm_start: WarmStart::cold(),
            solution: Solution::none(),
            record: Record::none(),
        }
    }

    /// Forgets the last solve, except its solution.
    pub(crate) fn reset(&mut self) {
        self.warm_start = WarmStart::cold();
        self.record.forget();
    }

    /// Takes back what the last solution claims, and forgets how its solve went.
    pub(crate) fn disown(&mut self) {
        self.record.forget();
        (self.solution.status, self.solution.error) = (Status::Unsolved, T::ONE / T::ZERO);
    }

    /// Forgets the last solve, and starts the next at these impulses.
    pub(crate) fn set_impulses(&mut self, impulses: &[(u32, SVector<T, D>)]) -> Result<(), Error> {
        self.warm_start.set(impulses)?;
        self.record.forget();
        Ok(())
    }

    /// Goes on with the last solve if it was paused, or begins one.
    pub(crate) fn resume<M: Method<T, D, C, L>>(
        &mut self,
        method: &mut M,
        data: Data<'_, T, N, D, C, L>,
    ) -> Result<&Solution<T, N, D, C, L>, Error> {
        let (_, factor, _, _) = data;
        let same = self.solution.contacts.len() == factor.contacts();
        let call = if same && self.record.is_paused() {
            Call::Resume
        } else {
            Call::Begin
        };
        self.run(method, data, call)
    }

    /// Begins a solve, begins again, or goes on.
    pub(crate) fn run<M: Method<T, D, C, L>>(
        &mut self,
        method: &mut M,
        (scene, factor, free_impulse, settings): Data<'_, T, N, D, C, L>,
        call: Call,
    ) -> Result<&Solution<T, N, D, C, L>, Error> {
        Problem::check(scene, factor, free_impulse, settings)?;
        if call != Call::Resume {
            self.record.begin();
        }
        // There is no work left for a search.
        self.record.has_sought_proof |= call == Call::Again && settings.budget == 0;
        let mut problem = Problem::new(scene, factor, free_impulse, settings.model);
        problem.fill(M::SEEKS_PROOF);
        let (solution, record) = (&mut self.solution, &mut self.record);
        let mut monitor = Monitor::new(&mut problem, settings, solution, record, call);
        if call != Call::Resume {
            method.begin(&mut monitor, &mut self.warm_start);
        }
        while monitor.is_running() {
            method.advance(&mut monitor);
        }
        monitor.finish(method.impulses());
        if M::SEEKS_PROOF {
            monitor.doubt();
        }
        let contacts = method.contacts(&problem);
        let replaces = call != Call::Begin;
        self.warm_start.keep((scene, factor), contacts, replaces);
        Ok(&self.solution)
    }
}
