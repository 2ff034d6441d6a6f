//! Bounds on the time of a call, and the budget that fits a time.

use super::Kernel;
use crate::solver::{JAM_BUDGET, Phases};

impl<const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Kernel<f32, N, D, C, R, S, P>
{
    /// Largest [`crate::Settings::budget`] with which [`Self::solve`] takes at most `microseconds` at a clock of `megahertz`; 0 if none fits.
    ///
    /// [`Self::worst_cycles`] of this budget fit the time; they include [`Self::prepare`], but not the filling of the scene. `wait_percent`
    /// are the cycles in which the core waits for its memory, as a share of those in which it works (%): 0 where code and data lie in memory
    /// without wait states, 55 with five wait states of the flash and no cache.
    ///
    /// ```
    /// use stiction::{Kernel, Settings, SweepsOnly};
    ///
    /// type Robot = Kernel<f32, 18, 3, 4, 0, 0, SweepsOnly>;
    /// const BUDGET: usize = Robot::budget_within(2_000, 168, 0);
    /// const { assert!(BUDGET > 0, "no budget fits") }
    /// const TICK: Settings<f32> = Settings { budget: BUDGET, ..Settings::new(1e-4) };
    /// assert!(TICK.budget < 100);
    /// ```
    #[must_use]
    pub const fn budget_within(microseconds: usize, megahertz: usize, wait_percent: usize) -> usize {
        let cycles = microseconds.saturating_mul(megahertz);
        // `100 cycles / share` in two parts: the product may need more than 32 bits.
        let share = wait_percent.saturating_add(100);
        let (whole, rest) = (cycles.div_euclid(share), cycles.rem_euclid(share));
        let cycles = whole.saturating_mul(100).saturating_add(rest.saturating_mul(100).div_euclid(share));
        let spare = cycles.saturating_sub(Self::PREPARE + Self::CALL + Self::ONCE);
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
    /// holds for any data, model and tolerance, and depends on the phases of the kernel. Most solves take a tenth of it.
    /// [`crate::guide::tick`] has its formula and its measurement.
    #[must_use]
    pub const fn worst_cycles(budget: usize) -> usize {
        Self::PREPARE.saturating_add(Self::worst_call(budget))
    }

    /// Bound on the cycles of a call of [`Self::advance`] with this budget (0 counts as 1), as [`Self::worst_cycles`], of a scene that
    /// [`Self::prepare`] has seen. So it bounds all slices of a solve after the first, and the first if the tick has called `prepare`, and has
    /// not given up a solve between two slices (give up by [`Self::resume`] with a budget of 0).
    #[must_use]
    pub const fn worst_slice_cycles(budget: usize) -> usize {
        Self::worst_call(if budget == 0 { 1 } else { budget })
    }

    /// The bound without preparing.
    const fn worst_call(budget: usize) -> usize {
        let mut cycles = Self::CALL;
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

    /// Number of rows if there are joint rows or surfaces, which take longer; otherwise 0.
    const MIXED: usize = if R + S > 0 { Self::ROWS } else { 0 };

    /// Cycles of [`Self::prepare`].
    const PREPARE: usize = {
        let (n, m) = (N, Self::ROWS);
        6 * n * n * n + (9 * m * n * (m + n)).div_euclid(2)
    };

    /// Cycles of a call without a budget: the velocities of the free motion, and the error of the best known point.
    const CALL: usize = {
        let mixed = if P::CENTRAL_PATH { 3_900 } else { 2_200 };
        20 * N * Self::ROWS + 3_700 * Self::ROWS + 4_400 + mixed * Self::MIXED
    };

    /// Cycles that any budget above 0 adds: a call may exceed its budget by one piece of work, and a search for a proof follows once.
    const ONCE: usize = {
        let (n, m) = (N, Self::ROWS);
        9 * Self::SLIP
            + if P::CENTRAL_PATH {
                300 * n * m + 9_500 * m + 110 * C * C * C + 13_000 * Self::MIXED
            } else if P::NEWTON {
                130 * n * n + 420 * n * m + 1_000 * m + 4_500 * Self::MIXED
            } else {
                40 * n * n + 2_000 * Self::MIXED
            }
    };

    /// Cycles of a unit of work.
    const UNIT: usize = {
        let (n, m) = (N, Self::ROWS);
        Self::SLIP
            + if P::CENTRAL_PATH {
                (m * m * m).div_euclid(4) + 6 * n * m + 400 * m + 200 + 160 * Self::MIXED
            } else if P::NEWTON {
                11 * m * m + 2 * n * m + 150 * m + 1_200 + 260 * Self::MIXED
            } else {
                12 * n * m + 200 * m + 1_300 + 150 * Self::MIXED
            }
    };

    /// Cycles by which a unit of work takes longer where contacts spin or roll: their slip is found by iteration.
    const SLIP: usize = match D {
        0..=3 => 0,
        4 => 1_500 * C,
        _ => 22_000 * C,
    };

    /// Cycles of the search for a proof of a jam.
    const JAM: usize = {
        let (n, m) = (N, Self::ROWS);
        if P::CENTRAL_PATH { 1_500 * n * m * if n < m { n } else { m } } else { 0 }
    };
}
