//! Joint limits that take a joint row only when they are reached.

use super::Kernel;
use crate::error::{Error, Input, List};
use crate::linalg::vector::rounding_bound;
use crate::loads::LeastImpulses;
use crate::real::Real;
use crate::scene::{JointRow, RowLaw, check_entries};
use crate::solution::{Settings, Solution, Status};
use crate::solver::{Call, Phases};
use nalgebra::SVector;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize, P: Phases>
    Kernel<T, N, D, C, R, S, P>
{
    /// Solves the scene together with a list of joint limits, as [`Self::solve`]. Only reached limits take a joint row.
    ///
    /// A robot has a dozen joint limits and reaches two. The first pass appends two kinds of limits to the joint rows of the scene: those that
    /// the free motion violates, and those that pushed in the last solve (by [`JointRow::key`]). If its solution violates other limits, another
    /// pass appends them. A limit that is not reached costs one product `row · v`, and its key is compared with those before it.
    /// Solution, error and promise are those of a scene with all limits: `row · v + offset >= 0` holds exactly for limits that are not reached.
    /// A scene that is proved infeasible or jammed without some limits is so with them: then the call ends, and its velocity may violate them.
    ///
    /// [`Solution::row_by_key`] finds the reached limits: each limit has a key that no other limit and no joint row of the scene has. A row of
    /// another law than [`RowLaw::Limit`] is always appended.
    ///
    /// If more limits are reached than there is room for, the first of the list are obeyed, and the status is [`Status::OutOfRows`].
    ///
    /// The call does not change the scene. If the budget was used up, [`Self::resume_with_limits`] continues the solve, and [`Self::resume`]
    /// refuses to.
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
    /// As [`Self::solve`]; [`Error::LimitKeyTaken`]; [`Error::ListFull`] if a row of another law finds no room; [`Error::NotFinite`] with
    /// [`Input::Limit`]; [`Error::InvalidLimit`]. [`Self::solution`] is then the solution of an earlier solve, or [`Status::Unsolved`] with an infinite error
    /// and without some of the limits.
    pub fn solve_with_limits(
        &mut self,
        limits: &[JointRow<T, N>],
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C, R>, Error> {
        self.run_with_limits((limits, free_impulse, settings), false, true)?;
        Ok(self.solver.solution())
    }

    /// Continues a [`Self::solve_with_limits`] or [`Self::advance_with_limits`] whose budget was used up, as [`Self::resume`].
    ///
    /// The limits that the paused solve has reached have to be in the list as they were; the others may change. A solution that a pause writes
    /// obeys all limits. So several calls may append a limit sooner than one call, and give other bits.
    ///
    /// # Errors
    /// As [`Self::solve_with_limits`].
    pub fn resume_with_limits(
        &mut self,
        limits: &[JointRow<T, N>],
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C, R>, Error> {
        self.run_with_limits((limits, free_impulse, settings), true, true)?;
        Ok(self.solver.solution())
    }

    /// Works on a solve with limits for one [`Settings::budget`] and returns true if it has ended, as [`Self::advance`].
    ///
    /// The size of the pieces changes no bit, and a budget of 0 counts as 1. Each piece computes the rows of `W` of the reached limits again.
    ///
    /// ```
    /// use nalgebra::{Matrix2, vector};
    /// use stiction::time_stepping::JointLimit;
    /// use stiction::{Kernel, Settings};
    ///
    /// let mut kernel = Kernel::<f64, 2, 1, 0, 2>::new();
    /// kernel.scene_mut().set_mass(&Matrix2::identity())?;
    /// let limits = [JointLimit { distance: 2e-6, recovery: 0.1, reach: 100.0 }.row(vector![1.0, 0.0], 1e-3, 0)?];
    /// let push = vector![-0.01, 0.0];
    /// let piece = Settings { budget: 2, ..Settings::new(1e-9) };
    /// while !kernel.advance_with_limits(&limits, &push, &piece)? {
    ///     // other tasks
    /// }
    /// assert!(kernel.solution().is_solved());
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::solve_with_limits`].
    pub fn advance_with_limits(
        &mut self,
        limits: &[JointRow<T, N>],
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<bool, Error> {
        self.run_with_limits((limits, free_impulse, &settings.of_a_piece()), true, false)
    }

    /// [`Self::least_impulses`] of the last solve with limits, for the same list: contacts share a load with the limits that the solve has reached.
    ///
    /// # Errors
    /// As [`LeastImpulses::new`]: [`Error::SceneChanged`] also if a reached limit has changed or is not in the list.
    pub fn least_impulses_with_limits(
        &mut self,
        limits: &[JointRow<T, N>],
        settings: &Settings<T>,
    ) -> Result<LeastImpulses<T, D, C, R>, Error> {
        if !self.factor.is_current(&self.scene) {
            return Err(Error::StaleFactor);
        }
        let (scene_rows, checkpoint) = (self.scene.rows().len(), self.factor.checkpoint());
        self.append_reached(&mut [usize::MAX; R], limits);
        let extended = self.factor.extend(&self.scene, scene_rows);
        let least = extended.and_then(|()| self.least_impulses(settings));
        self.scene.truncate_rows(scene_rows);
        self.factor.restore(&checkpoint);
        least
    }

    /// Works on a solve with limits, and returns true if it has ended. `resumes`: continues a paused one if there is one. `writes`: writes a
    /// solution also at the end of the budget.
    fn run_with_limits(&mut self, data: Data<'_, T, N>, resumes: bool, writes: bool) -> Result<bool, Error> {
        check_entries::<T, N>(self.scene.used(data.1, 1), Input::FreeImpulse)?;
        let may_resume = resumes && self.solver.has_limits();
        self.prepare_to_solve(if may_resume { Call::Resume } else { Call::Begin })?;
        let mut start = if may_resume { Start::Paused } else { Start::Pushed };
        let (scene_rows, checkpoint) = (self.scene.rows().len(), self.factor.checkpoint());
        let mut call = Call::Begin;
        let result = loop {
            let result = self.solve_reached(data, &mut call, start, writes);
            self.scene.truncate_rows(scene_rows);
            self.factor.restore(&checkpoint);
            start = match (start, &result) {
                (Start::Paused, Ok(None)) => {
                    self.prepare_to_solve(Call::Begin)?;
                    Start::Pushed
                }
                // The limits that pushed in the last solve may take too many rows: try without them.
                (Start::Pushed, Err(Error::ListFull { list: List::Rows, .. })) => Start::Violated,
                _ => break result,
            };
        };
        if result.is_err() && matches!(call, Call::Append(_)) {
            self.solver.invalidate();
        }
        self.note_doubt(result.is_err());
        Ok(result? == Some(true))
    }

    /// Refuses a limit whose key is that of an earlier limit or of a joint row of the scene. A solve asks as it begins, and not in each piece.
    fn check_keys(&self, limits: &[JointRow<T, N>]) -> Result<(), Error> {
        for (limit, row) in limits.iter().enumerate() {
            let mut others = self.scene.rows().iter().chain(limits).take(self.scene.rows().len() + limit);
            if others.any(|other| other.key == row.key) {
                return Err(Error::LimitKeyTaken { limit });
            }
        }
        Ok(())
    }

    /// Solves and appends violated limits until none is violated. Returns whether the solve has ended, and `None` if the paused solve has
    /// other data.
    fn solve_reached(
        &mut self,
        (limits, free_impulse, settings): Data<'_, T, N>,
        call: &mut Call,
        start: Start,
        writes: bool,
    ) -> Result<Option<bool>, Error> {
        let mut first = self.scene.rows().len();
        let (mut reached, mut earlier_work) = ([usize::MAX; R], 0);
        if start == Start::Paused {
            self.append_reached(&mut reached, limits);
            let solver = &self.solver;
            if !solver.is_paused_with_limits(&self.scene, free_impulse, settings) {
                return Ok(None);
            }
            (*call, earlier_work) = (Call::Resume, solver.solution().work.total());
        } else {
            self.check_keys(limits)?;
            let velocity = self.factor.free_velocity(free_impulse);
            self.append(&mut reached, limits, &velocity, (start, start == Start::Pushed))?;
        }
        loop {
            if self.scene.rows().len() > first {
                self.factor.extend(&self.scene, first)?;
            }
            let budget = settings.budget.saturating_sub(call.spent());
            let data = (&self.scene, &self.factor, free_impulse, &Settings { budget, ..*settings });
            let is_over = self.solver.work(data, *call, writes)?;
            let solution = self.solver.solution();
            *call = Call::Append(solution.work.total().saturating_sub(earlier_work));
            first = self.scene.rows().len();
            let is_proved = matches!(solution.status, Status::Infeasible | Status::Jammed);
            if (is_over || writes) && !is_proved {
                let velocity = solution.velocity;
                let leaves_out = self.append(&mut reached, limits, &velocity, (start, false))?;
                if leaves_out && self.scene.rows().len() == first {
                    self.note_left_out(&reached, limits);
                }
            }
            if self.scene.rows().len() == first {
                self.solver.note_limits(&self.scene);
                return Ok(Some(is_over));
            }
        }
    }

    /// Appends the limits that the last solve has reached to the joint rows, in the same order.
    fn append_reached(&mut self, reached: &mut [usize; R], limits: &[JointRow<T, N>]) {
        let keys = self.solver.warm_start().row_keys().skip(self.scene.rows().len());
        for key in keys {
            let mut found = limits.iter().enumerate().filter(|(_, limit)| limit.key == key);
            if let Some((limit, row)) = found.next()
                && let Ok(index) = self.scene.place_row(row)
                && let Some(entry) = reached.get_mut(index)
            {
                *entry = limit;
            }
        }
    }

    /// Appends the limits that a velocity violates to the joint rows, and `with_pushed` also those that pushed in the last solve: a first pass
    /// asks for them, and a later one need not look. `reached`: the index of the limit of each appended joint row.
    ///
    /// Returns whether limits are left out for which there is no room. A call that starts with those that pushed is refused instead.
    fn append(
        &mut self,
        reached: &mut [usize; R],
        limits: &[JointRow<T, N>],
        velocity: &SVector<T, N>,
        (start, with_pushed): (Start, bool),
    ) -> Result<bool, Error> {
        let mut leaves_out = false;
        let velocity = self.scene.used(velocity, 1);
        let share = rounding_bound::<T>(velocity.len() + 1);
        for (limit, row) in limits.iter().enumerate() {
            let (mut speed, mut size) = (row.offset, row.offset.abs());
            for (&entry, &v) in row.row.as_slice().iter().zip(velocity) {
                // Most rows have one entry.
                if entry != T::ZERO {
                    let product = entry * v;
                    speed += product;
                    size += product.abs();
                }
            }
            let rounding = size * share;
            let is_open = speed >= rounding
                && speed.is_finite()
                && row.law == RowLaw::Limit
                && row.compliance >= T::ZERO
                && !(with_pushed && self.solver.warm_start().has_pushed(row.key));
            if is_open || reached.contains(&limit) {
                continue;
            }
            match self.scene.place_row(row) {
                Ok(index) => {
                    if let Some(entry) = reached.get_mut(index) {
                        *entry = limit;
                    }
                }
                Err(Error::ListFull { .. }) if row.law == RowLaw::Limit && start != Start::Pushed => {
                    leaves_out = true;
                }
                Err(error) => return Err(of_limit(error, limit)),
            }
        }
        Ok(leaves_out)
    }

    /// Adds the violation of limits that are left out to the error of the solution: the impulses that would stop it, as a share of all impulses
    /// of joint rows.
    #[cold]
    #[inline(never)]
    fn note_left_out(&mut self, reached: &[usize; R], limits: &[JointRow<T, N>]) {
        let solution = self.solver.solution();
        let mut missing = T::ZERO;
        for (limit, row) in limits.iter().enumerate() {
            let along = |start, velocity| {
                let pairs = row.row.iter().zip(self.scene.used(velocity, 1));
                pairs.fold(start, |sum, (&entry, &v)| sum + entry * v)
            };
            let speed = along(row.offset, &solution.velocity);
            if speed < T::ZERO && !reached.contains(&limit) {
                let impulse = speed / along(row.compliance, &self.factor.free_velocity(&row.row));
                missing += impulse * impulse;
            }
        }
        let size = solution.rows.iter().fold(missing, |sum, row| sum + row.impulse * row.impulse);
        let error = if size > T::ZERO { (missing / size).square_root() } else { T::ZERO };
        self.solver.note_left_out(if error.is_finite() { error } else { T::INFINITY });
    }
}

/// The data of a call: limits, free impulse and settings.
type Data<'a, T, const N: usize> = (&'a [JointRow<T, N>], &'a SVector<T, N>, &'a Settings<T>);

/// The limits with which a call starts.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Start {
    /// Those of the paused solve, which the call continues.
    Paused,
    /// Those that the free motion violates, and those that pushed in the last solve.
    Pushed,
    /// Those that the free motion violates.
    Violated,
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
