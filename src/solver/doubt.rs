//! The monitor's doubts: impulses that run away, and scenes that have no solution.

use crate::cone::square;
use crate::laws::{Laws, Room};
use crate::linalg::blocks::ContactVector;
use crate::linalg::hints::rolled;
use crate::problem::infeasibility;
use crate::problem::residual::quotient;
use crate::solver::monitor::Monitor;
use crate::solver::tuning;
use crate::{Real, Status};

/// Impulses so many times those that contacts would take alone make a solution doubtful. (A tenth of it searches solved
/// impacts for a proof, five times as much calls slow walls solved.)
const EXCESSIVE: f64 = 20.0;

/// Impulses so many times as large are no solution, unless their error is small beside the others, too.
const LOST: f64 = 1e8;

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>
    Monitor<'_, '_, T, N, D, C, L>
{
    /// Size of the impulses, in units of what the velocities to be changed explain.
    fn impulse(&self) -> T {
        if let Some(energies) = self.problem.energies.get() {
            let slots = self.solution.contacts.iter().enumerate();
            let unscaled = |(i, contact)| self.unscaled(i, contact);
            return energies.share(self.problem.laws(), slots.map(unscaled));
        }
        let contacts = self.solution.contacts.iter();
        let square = contacts.fold(T::ZERO, |sum, contact| sum + contact.impulse.norm_squared());
        quotient(square.square_root(), self.problem.size)
    }

    /// Are the impulses much larger than the velocities to be changed explain? Where walls close
    /// on a body they grow without bound, and an error relative to them says nothing.
    fn impulse_is_excessive(&self) -> bool {
        self.impulse() > T::literal(EXCESSIVE)
    }

    /// Is the error small only because the impulses run away? Then it is not small beside the
    /// velocities to be changed.
    pub(super) fn runs_away(&mut self, r: &ContactVector<T, D, C>) -> bool {
        let impulse = self.impulse();
        if impulse > T::literal(LOST) {
            // With as fine a bound on rounding as there is.
            self.problem.evaluate(r, T::ZERO, self.solution);
            return impulse * self.solution.error > T::literal(0.1);
        }
        false
    }

    /// Looks for a proof if sweeps have led to impulses that are larger than to be expected: where walls close on a body,
    /// each sweep adds to them.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn suspect(&mut self, r: &ContactVector<T, D, C>) {
        if let Some(energies) = self.problem.energies.get() {
            let share = energies.share(self.problem.laws(), r.iter().copied());
            if share > tuning::diverging() {
                self.look_for_proof();
            }
            return;
        }
        let sum = r.iter().fold(T::ZERO, |sum, r| {
            rolled();
            sum + square(r)
        });
        let bound = self.problem.size * tuning::diverging();
        if sum > bound * bound {
            self.look_for_proof();
        }
    }

    /// Stops the monitor if the scene is infeasible, and writes down the certificate. Once in a solve, for it depends on
    /// the scene alone.
    pub(crate) fn look_for_proof(&mut self) {
        if L::MIXED {
            self.look_for_proof_of_rows();
            return;
        }
        if self.record.has_sought_proof
            || !infeasibility::is_conceivable(self.problem.scene.contacts())
        {
            return;
        }
        self.record.has_sought_proof = true;
        self.solution.work.proof_searches += 1;
        let Some(proof) = infeasibility::certificate(self.problem) else {
            return;
        };
        self.solution.certificate.clear();
        for &d in proof.iter().take(self.problem.laws().len()) {
            // There is room: a solution holds as many contacts as a scene.
            let _ = self.solution.certificate.push(d);
        }
        self.stop(Status::Infeasible);
    }

    /// Looks for a proof that there is nothing to be found, where what was found gives cause.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn doubt(&mut self) {
        let convincing = match self.record.status {
            Status::Solved => !self.impulse_is_excessive(),
            status => status == Status::Infeasible,
        };
        if !convincing {
            self.look_for_proof();
            if self.record.status == Status::Infeasible {
                self.solution.status = Status::Infeasible;
            }
        }
    }
}
