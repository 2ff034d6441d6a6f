//! Limits that stay out of `W` until they are reached.

use super::Kernel;
use crate::linalg::hints::rolled;
use crate::scene::check_finite;
use crate::solver::Call;
use crate::{Error, Input, JointRow, Mixed, Real, RowLaw, Settings, Solution, Status};
use core::mem;
use nalgebra::SVector;

/// Which limit stands at each place of the slots behind the scene's own.
type Places<const D: usize, const C: usize> = [[Option<usize>; D]; C];

impl<T: Real, const N: usize, const D: usize, const C: usize> Kernel<T, N, D, C, Mixed> {
    /// Solves the scene with as many of these limits as are reached, as [`Self::solve`].
    ///
    /// A robot has a dozen joint limits and reaches two. Those that the free motion violates, and those that pushed in the last
    /// solve (by [`JointRow::key`]), stand behind the scene's own slots from the start, those that a solution violates from then on;
    /// the others cost one product `row · v` each. A slot takes up to `D` of them. The solution is that of a scene with all of
    /// them, and so are its error and its promise: `row · v + offset >= 0` holds exactly for what was left out.
    /// [`Solution::row_by_key`] tells what those do that were not (give each a key that no other limit and no row of the scene
    /// has). Rows of other laws than [`RowLaw::Limit`] are never left out.
    ///
    /// Afterwards the scene is what it was. [`Self::resume`] solves it without limits: after a budget, call this again, which
    /// starts where the last call ended.
    ///
    /// ```
    /// use nalgebra::{Matrix2, vector};
    /// use stiction::time_stepping::joint_limit;
    /// use stiction::{Kernel, RowMode, Settings};
    ///
    /// // Two joints, 1 ms. The first is 2 µrad from its lower stop and falls towards it at 10 mrad/s.
    /// let (h, mut kernel) = (1e-3, Kernel::<f64, 2, 1, 1, _>::mixed());
    /// kernel.scene_mut().set_mass(&Matrix2::identity())?;
    /// let limits = [
    ///     joint_limit(vector![1.0, 0.0], 2e-6, h, 0.1, 100.0, 0)?,
    ///     joint_limit(vector![-1.0, 0.0], 3.0, h, 0.1, 100.0, 1)?,
    ///     joint_limit(vector![0.0, 1.0], 1.5, h, 0.1, 100.0, 2)?,
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
    /// As [`Self::solve`], and as [`crate::Scene::push_row`] for a limit: [`Error::ContactListFull`] if more are reached on the way
    /// than there is room for, [`Error::NotFinite`] with [`Input::Limit`]. [`Self::solution`] is then that of an earlier solve,
    /// or without some of the limits: that one is [`Status::Unsolved`], with an infinite error.
    pub fn solve_with_limits(
        &mut self,
        limits: &[JointRow<T, N>],
        free_impulse: &SVector<T, N>,
        settings: &Settings<T>,
    ) -> Result<&Solution<T, N, D, C, Mixed>, Error> {
        check_finite(free_impulse, Input::FreeImpulse)?;
        self.prepare()?;
        let (own, extent) = (self.scene.contacts().len(), self.factor.extent());
        let (mut call, mut remembers) = (Call::Begin, true);
        let result = loop {
            let data = (limits, free_impulse, settings);
            let result = self.solve_reached(own, data, &mut call, remembers);
            self.scene.truncate(own);
            self.factor.shrink(&extent);
            // Perhaps those of the last solve alone take the room.
            let is_full = matches!(result, Err(Error::ContactListFull { .. }));
            if !(is_full && mem::take(&mut remembers)) {
                break result;
            }
        };
        if result.is_err() && call == Call::Again {
            self.solver.disown();
        }
        result?;
        Ok(self.solver.solution())
    }

    /// Solves, and takes in what is violated, until nothing is.
    fn solve_reached(
        &mut self,
        own: usize,
        (limits, free_impulse, settings): (&[JointRow<T, N>], &SVector<T, N>, &Settings<T>),
        call: &mut Call,
        remembers: bool,
    ) -> Result<(), Error> {
        let mut places = [[None; D]; C];
        let velocity = self.factor.free_velocity(free_impulse);
        let mut first = self.take_in((own, &mut places), limits, &velocity, remembers)?;
        loop {
            if let Some(first) = first {
                self.factor.extend(&self.scene, first)?;
            }
            let mut left = *settings;
            if *call == Call::Again {
                let spent = self.solver.solution().work.total();
                left.budget = settings.budget.saturating_sub(spent);
            }
            let data = (&self.scene, &self.factor, free_impulse, &left);
            let solution = self.solver.run(data, *call)?;
            *call = Call::Again;
            if solution.status == Status::Infeasible {
                return Ok(());
            }
            let velocity = solution.velocity;
            first = self.take_in((own, &mut places), limits, &velocity, false)?;
            if first.is_none() {
                return Ok(());
            }
        }
    }

    /// Pushes the limits that a velocity violates, and those that pushed in the last solve if it remembers them. Returns the
    /// first slot that has changed.
    fn take_in(
        &mut self,
        (own, places): (usize, &mut Places<D, C>),
        limits: &[JointRow<T, N>],
        velocity: &SVector<T, N>,
        remembers: bool,
    ) -> Result<Option<usize>, Error> {
        let mut first = None;
        for (limit, row) in limits.iter().enumerate() {
            let (mut speed, mut size) = (row.offset, row.offset.abs());
            for (&entry, &v) in row.row.as_slice().iter().zip(velocity.as_slice()) {
                rolled();
                let product = entry * v;
                speed += product;
                size += product.abs();
            }
            // Rounding may hide as much: half an `eps` for each operation that a term takes part in.
            let rounding = size * (T::EPSILON * T::count(N + 1) * T::literal(0.5));
            let is_open = speed >= rounding
                && speed.is_finite()
                && row.law == RowLaw::Limit
                && row.compliance >= T::ZERO
                && !(remembers && self.solver.has_pushed(row.key));
            if is_open || places.as_flattened().contains(&Some(limit)) {
                continue;
            }
            let slot = self.scene.room_behind(own);
            let placed = self.scene.place_row(slot, row);
            let index = placed.map_err(|error| named(error, limit))?;
            let place = places.get_mut(index.slot);
            if let Some(place) = place.and_then(|places| places.get_mut(index.row)) {
                *place = Some(limit);
            }
            first = Some(first.map_or(index.slot, |first: usize| first.min(index.slot)));
        }
        Ok(first)
    }
}

/// Names a limit that is not made of numbers.
fn named(error: Error, limit: usize) -> Error {
    match error {
        Error::NotFinite { row, column, .. } => Error::NotFinite {
            input: Input::Limit { limit },
            row,
            column,
        },
        other => other,
    }
}
