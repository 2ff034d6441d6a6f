//! The monitor's doubts: impulses that run away, and scenes that have no solution.

use crate::laws::{Laws, Room};
use crate::linalg::blocks::ContactVector;
use crate::problem::residual::quotient;
use crate::problem::{infeasibility, row_proof};
use crate::solver::monitor::Monitor;
use crate::solver::tuning;
use crate::{Real, Status};

/// Impulses above this many times the expected size make a solution doubtful. (A tenth of it would search solved impacts for
/// a proof; five times as much would call slow walls solved.)
const EXCESSIVE: f64 = 20.0;

/// Impulses this many times as large as expected are rejected, unless error times impulse is small, too.
pub(super) const LOST: f64 = 1e8;

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws>
    Monitor<'_, '_, T, N, D, C, L>
{
    /// Size of the impulses, in units of the expected size (`r0` or `stop`).
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

    /// Are the impulses much larger than expected? If walls close on a body they grow without bound, and an error relative to
    /// them says nothing.
    fn impulse_is_excessive(&self) -> bool {
        self.impulse() > T::literal(EXCESSIVE)
    }

    /// Is the error small only because the impulses diverge? Then it is not small relative to the expected size.
    pub(super) fn runs_away(&mut self, r: &ContactVector<T, D, C>) -> bool {
        let impulse = self.impulse();
        if impulse > T::literal(LOST) {
            // With the finest bound on rounding.
            self.problem.evaluate(r, T::ZERO, self.solution);
            return impulse * self.solution.error > T::literal(0.1);
        }
        false
    }

    /// Looks for a proof if sweeps have led to impulses that are larger than expected: if walls close on a body, each sweep
    /// adds to them.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn suspect(&mut self, r: &ContactVector<T, D, C>) {
        if self.problem.exceeds(r, tuning::diverging()) {
            self.look_for_proof();
        }
    }

    /// Stops the monitor if the scene is infeasible, and writes down the certificate. Once in a solve, for it depends on
    /// the scene alone.
    pub(crate) fn look_for_proof(&mut self) {
        if self.record.has_sought_proof {
            return;
        }
        let scene = self.problem.scene;
        let conceivable = if L::MIXED {
            row_proof::is_conceivable(scene)
        } else {
            infeasibility::is_conceivable(scene.contacts())
        };
        if !conceivable {
            return;
        }
        self.record.has_sought_proof = true;
        self.solution.work.proof_searches += 1;
        let proved = if L::MIXED {
            self.prove_with_rows()
        } else {
            self.prove()
        };
        if proved.is_some() {
            self.stop(Status::Infeasible);
        }
    }

    /// Writes down a certificate, if there is one.
    #[inline]
    fn prove(&mut self) -> Option<()> {
        let proof = infeasibility::certificate(self.problem)?;
        self.solution.certificate.clear();
        for &d in proof.iter().take(self.problem.laws().len()) {
            // There is room: a solution holds as many contacts as a scene.
            let _ = self.solution.certificate.push(d);
        }
        Some(())
    }

    /// Looks for a proof that the scene is infeasible, unless the solution is convincing.
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
