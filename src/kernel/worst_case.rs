//! Bounds on the time of a call, and the budget that fits a time.

use super::Kernel;
use crate::real::Real;
use crate::solver::{JAM_BUDGET, Phases};

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Kernel<T, N, D, C, R, S, P>
{
    /// Largest [`crate::Settings::budget`] with which [`Self::solve`] takes at most `microseconds` at a clock of `megahertz`; 0 if none fits.
    ///
    /// [`Self::worst_cycles`] of this budget fit the time; they include [`Self::prepare`], but not the filling of the scene. If the core waits
    /// for its memory, pass a slower clock.
    ///
    /// ```
    /// use stiction::{Kernel, Settings, SweepsAndNewton};
    ///
    /// type Robot = Kernel<f32, 18, 3, 4, 0, 0, SweepsAndNewton>;
    /// const BUDGET: usize = Robot::budget_within(2_000, 168);
    /// const { assert!(BUDGET > 0, "no budget fits") }
    /// const TICK: Settings<f32> = Settings { budget: BUDGET, ..Settings::new(1e-4) };
    /// assert!(TICK.budget < 100);
    /// ```
    #[must_use]
    pub const fn budget_within(microseconds: usize, megahertz: usize) -> usize {
        let cycles = microseconds.saturating_mul(megahertz);
        let spare = cycles.saturating_sub(Self::WITHOUT_BUDGET + Self::ONCE);
        let budget = spare.div_euclid(Self::UNIT);
        if budget < JAM_BUDGET {
            return budget;
        }
        let dearer = spare.saturating_sub(Self::JAM).div_euclid(Self::UNIT);
        if dearer < JAM_BUDGET { JAM_BUDGET - 1 } else { dearer }
    }

    /// Bound on the cycles of a call of [`Self::solve`] or [`Self::resume`] with this budget, in `f32` on a Cortex-M4F without wait states,
    /// with all velocities, contacts and joint rows in use. Fewer ([`crate::Scene::set_velocities`]) take less; the bound stays that of the
    /// full size.
    ///
    /// It includes [`Self::prepare`], but neither the filling of the scene nor the passes of [`Self::solve_with_limits`] after the first. It
    /// holds for any data and tolerance, and depends on the phases of the kernel. Most solves take a tenth of it. A kernel of `f64` takes
    /// longer. [`crate::guide::tick`] has its formula and its measurement.
    #[must_use]
    pub const fn worst_cycles(budget: usize) -> usize {
        let mut cycles = Self::WITHOUT_BUDGET;
        if budget > 0 {
            cycles = cycles.saturating_add(Self::ONCE);
            cycles = cycles.saturating_add(budget.saturating_mul(Self::UNIT));
        }
        if budget >= JAM_BUDGET {
            cycles = cycles.saturating_add(Self::JAM);
        }
        cycles
    }

    /// Number of contact rows and joint rows.
    const ROWS: usize = D * C + R;

    /// Cycles of a call without a budget: the factor, the velocities of the free motion, and the error of the best known point.
    const WITHOUT_BUDGET: usize = {
        let (n, m) = (N, Self::ROWS);
        let prepare = (n * n * n + 3 * m * n * (m + n)).div_euclid(2);
        prepare + 330 * n * n + 220 * m * m + 1_500 * m + 16_000 + 2_000 * Self::MIXED
    };

    /// Number of rows if there are joint rows or surfaces, whose error takes longer; otherwise 0.
    const MIXED: usize = if R + S > 0 { Self::ROWS } else { 0 };

    /// Cycles that any budget above 0 adds: a call may exceed its budget by one piece of work, and a search for a proof follows once.
    const ONCE: usize = {
        let proof = if P::CENTRAL_PATH { 3_600 * Self::ROWS + 100 * C * C * C } else { 0 };
        9 * Self::UNIT + 6_000 * Self::MIXED + proof
    };

    /// Cycles of a unit of work.
    const UNIT: usize = {
        let m = Self::ROWS;
        // The slip of a contact that spins or rolls is found by iteration.
        let slip = match D {
            0..=3 => 0,
            4 => 1_500 * C,
            _ => 15_000 * C,
        };
        slip + 250
            + if P::CENTRAL_PATH {
                450 * m + (3 * m * m * m).div_euclid(8)
            } else if P::NEWTON {
                400 * m + (m * m * m).div_euclid(8)
            } else {
                500 * m
            }
    };

    /// Cycles of the search for a proof of a jam.
    const JAM: usize = {
        let (n, m) = (N, Self::ROWS);
        if P::CENTRAL_PATH { 700 * n * m * if n < m { n } else { m } } else { 0 }
    };
}
