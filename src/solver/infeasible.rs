//! The decision when to look for a proof that a scene is infeasible or jammed ([`crate::guide::error`]).

use crate::linalg::stacked::Stacked;
use crate::real::Real;
use crate::solution::Status;
use crate::solver::monitor::Monitor;
use crate::solver::phases::Phases;
use crate::solver::solve::Solve;
use crate::solver::state::{Failure, Origin, Phase};

/// Least budget with which the solver looks for a proof of a jam. The search takes as long as hundreds of sweeps.
pub(crate) const JAM_BUDGET: usize = 1_000;

/// A proof of infeasibility is looked for before any path if the least estimate exceeds this.
const FAR: f64 = 0.01;

/// Doubtful impulses that exceed those of the last solution by more than this factor are doubted anew.
const GROWTH: f64 = 2.0;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Monitor<'_, '_, T, N, D, C, R, S>
{
    /// Looks for a proof that the scene is infeasible, once in a solve: it depends on the scene alone. If it finds one, it writes the
    /// certificate and ends the solve.
    pub(super) fn look_for_proof(&mut self) {
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
        self.write_certificate(&proof);
        self.stop(Status::Infeasible);
    }

    /// Writes a proof to the solution.
    #[cfg_attr(target_os = "none", inline(never))]
    fn write_certificate(&mut self, proof: &Stacked<T, D, C, R>) {
        // No `push` fails: a solution has room for as many as a scene.
        let counts = self.problem.sets.counts();
        self.solution.certificate.clear();
        for &d in proof.contacts.iter().take(counts.contacts) {
            let _ = self.solution.certificate.push(d.into());
        }
        self.solution.row_certificate.clear();
        for &d in proof.rows.iter().take(counts.rows) {
            let _ = self.solution.row_certificate.push(d);
        }
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Solve<'_, '_, T, N, D, C, R, S, P>
{
    /// Ends the solve after a rejected step of a cold start if the best impulses solve the scene, and if a proof shows that none do. The proof is
    /// looked for after a path has jammed, or before if the best impulses are far from a solution. Nothing is asked where a solution is known.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn examine_failure(&mut self, failure: Failure) {
        let monitor = &mut self.monitor;
        let looks = match failure {
            _ if monitor.record.has_fallback() => return,
            Failure::Jammed => true,
            Failure::Rejected(origin @ (Origin::Cold | Origin::Guess)) if !monitor.problem.is_relaxed() => {
                if matches!(origin, Origin::Cold) {
                    monitor.check_best();
                }
                monitor.record.best_estimate.is_none_or(|estimate| estimate > T::literal(FAR))
            }
            Failure::Rejected(_) => return,
        };
        if looks && !monitor.is_over() {
            monitor.look_for_proof();
        }
        if self.monitor.is_over() {
            self.go_to_best(); // the next solve starts there
            self.state.phase = Phase::Sweeps; // of the point `r` and `u` are read
        }
    }

    /// Looks for a proof that the scene is infeasible or jammed, unless it is solved with impulses that are not doubtful, or hardly larger than
    /// those that solved the last scene: so a grip is not asked in each tick.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn check_infeasibility(&mut self) {
        let (monitor, present) = (&self.monitor, &self.state.point.r);
        let convincing = match monitor.record.status {
            Status::Solved => !monitor.is_doubtful(&monitor.record.best) || self.was_borne(),
            status => status == Status::Infeasible,
        };
        if convincing {
            return;
        }
        let has_doubted = monitor.record.has_doubted || monitor.is_doubtful(present);
        let monitor = &mut self.monitor;
        monitor.look_for_proof();
        if monitor.record.status == Status::Infeasible {
            monitor.solution.status = Status::Infeasible;
            return;
        }
        let may_be_jammed =
            monitor.record.status != Status::Solved && monitor.record.has_sought_proof && has_doubted;
        // The proof does not end the solve, because a solution may exist.
        if may_be_jammed
            && monitor.budget().saturating_add(monitor.call.spent()) >= JAM_BUDGET
            && let Some(proof) =
                monitor.problem.jam(None).or_else(|| monitor.problem.jam(Some(&self.state.point.r)))
        {
            monitor.write_certificate(&proof);
            monitor.solution.status = Status::Jammed;
        }
    }

    /// Did doubtful impulses solve the last scene that are hardly smaller than the best?
    fn was_borne(&self) -> bool {
        let (monitor, problem) = (&self.monitor, &*self.monitor.problem);
        let mut borne = Stacked::zero();
        self.warm_start.impulses(problem.scene, false, &mut borne);
        problem.sets.project(&mut borne);
        self.warm_start.is_solved
            && monitor.is_doubtful(&borne)
            && !problem.exceeds_others(&monitor.record.best, &borne, T::literal(GROWTH))
    }
}
