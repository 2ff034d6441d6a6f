//! Joint limits that take a joint row only when they are reached.

use super::Kernel;
use crate::error::{Error, Input, List};
use crate::linalg::vector::precision;
use crate::real::Real;
use crate::scene::{JointRow, RowLaw, check_finite};
use crate::solution::{Settings, Solution, Status};
use crate::solver::{Call, Phases};
use core::mem;
use nalgebra::SVector;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Kernel<T, N, D, C, R, S, P>
{
    /// Solves the scene together with a list of joint limits, as [`Self::solve`]. Only reached limits take a joint row.
    ///
    /// A robot has a dozen joint limits and reaches two. The first pass appends two kinds of limits to the joint rows of the scene: those that
    /// the free motion violates, and those that pushed in the last solve (by [`JointRow::key`]). If its solution violates other limits, another
    /// pass appends them. A limit that is not reached costs one product `row · v`. Solution, error and promise are those of a scene with
    /// all limits: `row · v + offset >= 0` holds exactly for limits that are not reached.
    ///
    /// [`Solution::row_by_key`] finds the reached limits: give each limit a key that no other limit and no row of the scene has. A row of
    /// another law than [`RowLaw::Limit`] is always appended.
    ///
    /// The call does not change the scene. [`Self::resume`] refuses to continue such a solve. Call this method again: it starts where the
    /// last call ended.
    ///
    /// ```
    /// use nalgebra::{Matrix2, vector};
    /// use stiction::time_stepping::JointLimit;
    /// use stiction::{Kernel, RowMode, Settings};
    ///
    /// // Two joints, 1 ms. The first is 2 µrad from its lower stop and falls towards it at 10 mrad/s.
    /// let (h, mut kernel) = (1e-3, Kernel::<f64, 2, 1, 0, 2>::new());
    /// kernel.scene_mut().set_mass(&Matrix2::identity())?;
    /// let stop = |distance| JointLimit { distance, recovery: 0.1, reach: 100.0 };
    /// let limits = [
    ///     stop(2e-6).row(vector![1.0, 0.0], h, 0)?,
    ///     stop(3.0).row(vector![-1.0, 0.0], h, 1)?,
    ///     stop(1.5).row(vector![0.0, 1.0], h, 2)?,
    /// ];
    /// let solution = kernel.solve_with_limits(&limits, &vector![-0.01, 0.0], &Settings::new(1e-9))?;
    /// let reached = solution.row_by_key(0).expect("reached");
    /// assert_eq!(reached.mode, RowMode::AtLimit);
    /// assert!((solution.velocity[0] + 0.002).abs() < 1e-9); // 2 µrad in 1 ms
    /// assert!(solution.row_by_key(1).is_none() && solution.row_by_key(2).is_none());
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::solve`]; [`Error::ListFull`] if more limits are reached than there is room for; [`Error::NotFinite`] with [`Input::Limit`];
    /// [`Error::InvalidLimit`]. [`Self::solution`] is then the solution of an earlier solve, or [`Status::Unsolved`] with an infinite error
    /// and without some of the limits.
    pub fn solve_with_limits(
        &mut self,
        limits: &[JointRow<T, N>],
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C, R>, Error> {
        check_finite(free_impulse, Input::FreeImpulse)?;
        self.prepare()?;
        let (scene_rows, checkpoint) = (self.scene.rows().len(), self.factor.checkpoint());
        let (mut call, mut with_pushed) = (Call::Begin, true);
        let result = loop {
            let data = (limits, free_impulse, settings);
            let result = self.solve_reached(data, &mut call, with_pushed);
            self.scene.truncate_rows(scene_rows);
            self.factor.restore(&checkpoint);
            // The limits that pushed in the last solve may take too many rows: try without them.
            let list = List::Rows;
            let is_full = matches!(result, Err(Error::ListFull { list: full, .. }) if full == list);
            if !(is_full && mem::take(&mut with_pushed)) {
                break result;
            }
        };
        if result.is_err() && call == Call::Append {
            self.solver.invalidate();
        }
        result?;
        self.solver.note_limits();
        Ok(self.solver.solution())
    }

    /// Solves and appends violated limits until none is violated. `with_pushed`: also appends the limits that pushed in the last solve.
    fn solve_reached(
        &mut self,
        (limits, free_impulse, settings): (&[JointRow<T, N>], &SVector<T, N>, &Settings<T>),
        call: &mut Call,
        with_pushed: bool,
    ) -> Result<(), Error> {
        let mut first = self.scene.rows().len();
        let mut reached = [usize::MAX; R];
        let velocity = self.factor.free_velocity(free_impulse);
        self.append(&mut reached, limits, &velocity, with_pushed)?;
        loop {
            if self.scene.rows().len() > first {
                self.factor.extend(&self.scene, first)?;
            }
            let mut remaining = *settings;
            if *call == Call::Append {
                let spent = self.solver.solution().work.total();
                remaining.budget = settings.budget.saturating_sub(spent);
            }
            let data = (&self.scene, &self.factor, free_impulse, &remaining);
            let solution = self.solver.run(data, *call)?;
            *call = Call::Append;
            if solution.status == Status::Infeasible {
                return Ok(());
            }
            let velocity = solution.velocity;
            first = self.scene.rows().len();
            self.append(&mut reached, limits, &velocity, false)?;
            if self.scene.rows().len() == first {
                return Ok(());
            }
        }
    }

    /// Appends the limits that a velocity violates to the joint rows, and `with_pushed` also those that pushed in the last solve. `reached`:
    /// the index of the limit of each appended joint row.
    fn append(
        &mut self,
        reached: &mut [usize; R],
        limits: &[JointRow<T, N>],
        velocity: &SVector<T, N>,
        with_pushed: bool,
    ) -> Result<(), Error> {
        for (limit, row) in limits.iter().enumerate() {
            let (mut speed, mut size) = (row.offset, row.offset.abs());
            for (&entry, &v) in row.row.as_slice().iter().zip(velocity.as_slice()) {
                // Most rows have one entry.
                if entry != T::ZERO {
                    let product = entry * v;
                    speed += product;
                    size += product.abs();
                }
            }
            let rounding = size * precision(N + 1);
            let is_open = speed >= rounding
                && speed.is_finite()
                && row.law == RowLaw::Limit
                && row.compliance >= T::ZERO
                && !(with_pushed && self.solver.has_pushed(row.key));
            if is_open || reached.contains(&limit) {
                continue;
            }
            let index = self.scene.place_row(row).map_err(|error| of_limit(error, limit))?;
            if let Some(entry) = reached.get_mut(index) {
                *entry = limit;
            }
        }
        Ok(())
    }
}

/// The error of a refused joint row as an error of a limit.
fn of_limit(error: Error, limit: usize) -> Error {
    match error {
        Error::NotFinite { row, column, .. } => {
            Error::NotFinite { input: Input::Limit { limit }, row, column }
        }
        Error::InvalidBounds { .. } | Error::InvalidRowCompliance { .. } => Error::InvalidLimit { limit },
        other => other,
    }
}
