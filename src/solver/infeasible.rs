//! When the monitor doubts a solution: scenes that have none.

use crate::real::Real;
use crate::solution::Status;
use crate::solver::monitor::Monitor;

/// Impulses above this many times the expected size make a solution doubtful. (A tenth of it would search solved impacts for
/// a proof; five times as much would call slow walls solved.)
const DOUBTFUL_IMPULSE_RATIO: f64 = 20.0;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Monitor<'_, '_, T, N, D, C, R, S>
{
    /// Stops the monitor if the scene is infeasible, and writes down the certificate. Once in a solve, for it depends on
    /// the scene alone.
    pub(crate) fn look_for_proof(&mut self) {
        if self.record.has_sought_proof {
            return;
        }
        if !self.problem.scene.is_conceivably_infeasible() {
            return;
        }
        self.record.has_sought_proof = true;
        self.solution.work.proof_searches += 1;
        let Some(proof) = self.problem.certificate() else {
            return;
        };
        // There is room: a solution holds as many as a scene.
        let counts = self.problem.sets.counts();
        self.solution.certificate.clear();
        for [d] in proof.contacts.into_iter().take(counts.contacts) {
            let _ = self.solution.certificate.push(d);
        }
        self.solution.row_certificate.clear();
        for d in proof.rows.into_iter().take(counts.rows) {
            let _ = self.solution.row_certificate.push(d);
        }
        self.stop(Status::Infeasible);
    }

    /// Looks for a proof that the scene is infeasible, unless the solution is convincing.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn check_infeasibility(&mut self) {
        let convincing = match self.record.status {
            Status::Solved => {
                let ratio = self.problem.impulse_ratio(&self.record.best);
                ratio <= T::literal(DOUBTFUL_IMPULSE_RATIO)
            }
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
