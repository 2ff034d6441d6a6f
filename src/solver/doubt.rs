//! The monitor's doubts: impulses that run away, and scenes that have no solution.

use crate::laws::{Laws, Room};
use crate::linalg::blocks::ContactVector;
use crate::problem::infeasibility;
use crate::problem::residual::quotient;
use crate::solution::SlotSolution;
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
            return energies.share(self.problem.laws(), self.shown().into_iter());
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
        if !infeasibility::is_conceivable(self.problem.scene) {
            return;
        }
        self.record.has_sought_proof = true;
        self.solution.work.proof_searches += 1;
        let proved = if L::MIXED {
            self.prove::<D>()
        } else {
            self.prove::<1>()
        };
        if proved.is_some() {
            self.stop(Status::Infeasible);
        }
    }

    /// Writes down a certificate, if there is one with `K` rows a slot.
    #[inline]
    fn prove<const K: usize>(&mut self) -> Option<()> {
        let proof = infeasibility::certificate::<T, N, D, C, L, K>(self.problem)?;
        self.solution.certificate.clear();
        let slots = proof.iter().zip(&mut self.solution.rows);
        for (law, (d, rows)) in self.problem.laws().iter().zip(slots) {
            let normal = if law.rows.get().is_some() {
                None
            } else {
                d.first()
            };
            // There is room: a solution holds as many slots as a scene.
            let _ = self
                .solution
                .certificate
                .push(normal.copied().unwrap_or(T::ZERO));
            if L::MIXED {
                let mut slot = rows.get().copied().unwrap_or(SlotSolution::none());
                for (entry, &d) in slot.certificate.iter_mut().zip(d) {
                    *entry = d;
                }
                *rows = L::Room::with(slot);
            }
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
