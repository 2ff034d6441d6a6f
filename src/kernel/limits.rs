//! Joint limits that take a row only when they are reached.

use super::Kernel;
use crate::error::{Error, Input, List};
use crate::linalg::vector::precision;
use crate::real::Real;
use crate::scene::{JointRow, RowLaw, check_finite};
use crate::solution::{Settings, Solution, Status};
use crate::solver::{Call, Phases};
use core::mem;
use nalgebra::SVector;

impl<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
    P: Phases,
> Kernel<T, N, D, C, R, S, P>
{
    /// Solves the scene together with a list of joint limits, as [`Self::solve`], and spends rows only on those that are reached.
    ///
    /// A robot has a dozen joint limits and reaches two. Limits that the free motion violates, and limits that pushed in the last solve (by
    /// [`JointRow::key`]), stand behind the scene's own joint rows from the start. A limit that a solution violates joins them. Every other
    /// limit costs one product `row · v`. The solution, its error and its promise are those of a scene with all limits:
    /// `row · v + offset >= 0` holds exactly for the others. [`Solution::row_by_key`] finds the reached limits: give each limit a key
    /// that no other limit and no row of the scene has. Rows of other laws than [`RowLaw::Limit`] always take a row.
    ///
    /// Afterwards the scene is as before. [`Self::resume`] refuses to continue such a solve: call this again, which starts where the last call
    /// ended.
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
    /// [`Error::InvalidLimit`]. [`Self::solution`] is then that of an earlier solve, or one without some of the limits, which is
    /// [`Status::Unsolved`] with an infinite error.
    pub fn solve_with_limits(
        &mut self,
        limits: &[JointRow<T, N>],
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C, R>, Error> {
        check_finite(free_impulse, Input::FreeImpulse)?;
        self.prepare()?;
        let (own, checkpoint) = (self.scene.rows().len(), self.factor.checkpoint());
        let (mut call, mut remembers) = (Call::Begin, true);
        let result = loop {
            let data = (limits, free_impulse, settings);
            let result = self.solve_reached(own, data, &mut call, remembers);
            self.scene.truncate_rows(own);
            self.factor.go_back(&checkpoint);
            // Perhaps those of the last solve alone take the room.
            let list = List::Rows;
            let is_full = matches!(result, Err(Error::ListFull { list: full, .. }) if full == list);
            if !(is_full && mem::take(&mut remembers)) {
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

    /// Solves, and adds violated limits, until none is violated.
    fn solve_reached(
        &mut self,
        own: usize,
        (limits, free_impulse, settings): (&[JointRow<T, N>], &SVector<T, N>, &Settings<T>),
        call: &mut Call,
        remembers: bool,
    ) -> Result<(), Error> {
        // Which limit stands in each place behind the scene's own rows.
        let mut reached = [usize::MAX; R];
        let velocity = self.factor.free_velocity(free_impulse);
        self.append((own, &mut reached), limits, &velocity, remembers)?;
        let mut first = own;
        loop {
            if self.scene.rows().len() > first {
                self.factor.extend(&self.scene, first)?;
            }
            let mut left = *settings;
            if *call == Call::Append {
                let spent = self.solver.solution().work.total();
                left.budget = settings.budget.saturating_sub(spent);
            }
            let data = (&self.scene, &self.factor, free_impulse, &left);
            let solution = self.solver.run(data, *call)?;
            *call = Call::Append;
            if solution.status == Status::Infeasible {
                return Ok(());
            }
            let velocity = solution.velocity;
            first = self.scene.rows().len();
            self.append((own, &mut reached), limits, &velocity, false)?;
            if self.scene.rows().len() == first {
                return Ok(());
            }
        }
    }

    /// Appends the limits that a velocity violates, and those that pushed in the last solve if it remembers them.
    fn append(
        &mut self,
        (own, reached): (usize, &mut [usize; R]),
        limits: &[JointRow<T, N>],
        velocity: &SVector<T, N>,
        remembers: bool,
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
                && !(remembers && self.solver.has_pushed(row.key));
            let behind = reached.get(own..self.scene.rows().len());
            if is_open || behind.is_some_and(|behind| behind.contains(&limit)) {
                continue;
            }
            let place = self
                .scene
                .place_row(row)
                .map_err(|error| named(error, limit))?;
            if let Some(place) = reached.get_mut(place) {
                *place = limit;
            }
        }
        Ok(())
    }
}

/// Names a limit that is refused.
fn named(error: Error, limit: usize) -> Error {
    match error {
        Error::NotFinite { row, column, .. } => Error::NotFinite {
            input: Input::Limit { limit },
            row,
            column,
        },
        Error::InvalidBounds { .. } | Error::InvalidRowCompliance { .. } => {
            Error::InvalidLimit { limit }
        }
        other => other,
    }
}
