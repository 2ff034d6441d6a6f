//! The joint rows of a scene: pushed, changed, removed.

use super::checks::{check_entries, fingerprint};
use super::{JointRow, RowLaw, Scene, move_up};
use crate::error::{Error, Input, List};
use crate::linalg::zip::zip3;
use crate::real::Real;
use nalgebra::SVector;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Scene<T, N, D, C, R, S>
{
    /// Adds a joint row and returns its index.
    ///
    /// ```
    /// use nalgebra::{Matrix1, vector};
    /// use stiction::{JointRow, Kernel, RowLaw, RowMode, Settings};
    ///
    /// // A pendulum of 0.5 kg m² falls at 2 rad/s onto its stop.
    /// let mut kernel = Kernel::<f64, 1, 1, 0, 1>::new(); // no contact, one joint row
    /// let scene = kernel.scene_mut();
    /// scene.set_mass(&Matrix1::new(0.5))?;
    /// let (row, offset) = (vector![1.0], 0.0);
    /// scene.push_row(&JointRow { row, offset, law: RowLaw::Limit, compliance: 0.0, key: 0 })?;
    /// let solution = kernel.solve(&vector![-1.0], &Settings::new(1e-9))?;
    /// assert_eq!(solution.rows[0].mode, RowMode::AtLimit);
    /// assert!((solution.rows[0].impulse - 1.0).abs() < 1e-9); // N·m·s
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::ListFull`], [`Error::NotFinite`], [`Error::InvalidBounds`], [`Error::InvalidRowCompliance`].
    pub fn push_row(&mut self, row: &JointRow<T, N>) -> Result<usize, Error> {
        let index = self.place_row(row).inspect_err(|_| self.refused.row = true)?;
        self.rows_print = self.rows_print.wrapping_add(self.row_print(index));
        Ok(index)
    }

    /// Adds a joint row behind the others, without a change of the fingerprint.
    pub(crate) fn place_row(&mut self, row: &JointRow<T, N>) -> Result<usize, Error> {
        let (index, velocities) = (self.counts.rows, self.velocities());
        check_entries::<T, N>(self.used(&row.row, 1), Input::JointRow { row: index })?;
        check_offset::<T, N>(row.offset, index)?;
        if !row.law.is_valid() {
            return Err(Error::InvalidBounds { row: index });
        }
        check_compliance(row.compliance, index)?;
        let target = self.rows.get_mut(index).ok_or(Error::ListFull { list: List::Rows, capacity: R })?;
        target.clone_from(row);
        let unused = target.row.as_mut_slice().get_mut(velocities..);
        unused.unwrap_or_default().fill(T::ZERO);
        self.counts.rows += 1;
        Ok(index)
    }

    /// Keeps the first `count` rows, and drops those behind them that [`Self::place_row`] has added.
    pub(crate) const fn truncate_rows(&mut self, count: usize) {
        self.counts.rows = count;
    }

    /// Removes all joint rows; contacts stay.
    pub fn clear_rows(&mut self) {
        self.counts.rows = 0;
        self.rows_print = 0;
        self.refused.row = false;
    }

    /// Removes a joint row. The index of each later row falls by one.
    ///
    /// # Errors
    /// [`Error::NoSuchRow`].
    pub fn remove_row(&mut self, row: usize) -> Result<(), Error> {
        self.row_mut(row)?;
        let last = self.counts.rows;
        move_up(self.rows.get_mut(row..last));
        self.counts.rows = last - 1;
        self.rows_print = self.prints_of_rows();
        Ok(())
    }

    /// Replaces the row of a joint row over the `N` velocities. A stored factor is then stale, as after [`Self::set_jacobian`].
    ///
    /// # Errors
    /// [`Error::NoSuchRow`], [`Error::NotFinite`].
    pub fn set_row_jacobian(&mut self, row: usize, jacobian: &SVector<T, N>) -> Result<(), Error> {
        let velocities = self.velocities();
        check_entries::<T, N>(self.used(jacobian, 1), Input::JointRow { row })?;
        self.replace_in_row(row, |target| {
            let entries = target.row.iter_mut().zip(jacobian.iter()).take(velocities);
            entries.for_each(|(target, &entry)| *target = entry);
        })
    }

    /// Replaces the compliance of a joint row. A stored factor is then stale, as after [`Self::set_jacobian`].
    ///
    /// # Errors
    /// [`Error::NoSuchRow`], [`Error::InvalidRowCompliance`].
    pub fn set_row_compliance(&mut self, row: usize, compliance: T) -> Result<(), Error> {
        check_compliance(compliance, row)?;
        self.replace_in_row(row, |target| target.compliance = compliance)
    }

    /// Replaces the offset of a joint row (rad/s, m/s). A stored factor stays valid.
    ///
    /// # Errors
    /// [`Error::NoSuchRow`], [`Error::NotFinite`].
    pub fn set_row_offset(&mut self, row: usize, offset: T) -> Result<(), Error> {
        check_offset::<T, N>(offset, row)?;
        self.row_mut(row)?.offset = offset;
        Ok(())
    }

    /// Replaces the law of a joint row. A stored factor stays valid.
    ///
    /// # Errors
    /// [`Error::NoSuchRow`], [`Error::InvalidBounds`].
    pub fn set_row_law(&mut self, row: usize, law: RowLaw<T>) -> Result<(), Error> {
        let target = self.row_mut(row)?;
        if !law.is_valid() {
            return Err(Error::InvalidBounds { row });
        }
        target.law = law;
        Ok(())
    }

    /// The joint rows, in the order they were added.
    #[must_use]
    pub fn rows(&self) -> &[JointRow<T, N>] {
        self.rows.get(..self.counts.rows).unwrap_or_default()
    }

    /// Index of the first joint row with this [`JointRow::key`].
    #[must_use]
    pub fn row_index(&self, key: u32) -> Option<usize> {
        self.rows().iter().position(|row| row.key == key)
    }

    /// Adds the velocities of compliance to the velocities of joint rows.
    #[inline]
    pub(crate) fn add_row_compliance(&self, r: &[T; R], u: &mut [T; R]) {
        for (u, &r, row) in zip3(u, r, self.rows()) {
            *u += row.compliance * r;
        }
    }

    /// Sum of the fingerprints of the joint rows in use.
    pub(crate) fn prints_of_rows(&self) -> u64 {
        let prints = (0..self.counts.rows).map(|row| self.row_print(row));
        prints.fold(0, u64::wrapping_add)
    }

    /// Fingerprint of a joint row, its compliance and its index behind the contacts.
    fn row_print(&self, index: usize) -> u64 {
        self.rows.get(index).map_or(0, |row| {
            let print = fingerprint(row.row.as_slice(), C + index);
            print.wrapping_add(row.compliance.hash(print))
        })
    }

    /// A joint row in use.
    fn row_mut(&mut self, row: usize) -> Result<&mut JointRow<T, N>, Error> {
        let rows = self.rows.get_mut(..self.counts.rows).unwrap_or_default();
        rows.get_mut(row).ok_or(Error::NoSuchRow { row })
    }

    /// Changes a part of a joint row that belongs to the fingerprint.
    fn replace_in_row(&mut self, row: usize, change: impl FnOnce(&mut JointRow<T, N>)) -> Result<(), Error> {
        change(self.row_mut(row)?);
        self.rows_print = self.prints_of_rows();
        Ok(())
    }
}

/// The offset of a row over `N` velocities is a number.
fn check_offset<T: Real, const N: usize>(offset: T, row: usize) -> Result<(), Error> {
    let refused = Error::NotFinite { input: Input::JointRow { row }, row: N, column: 0 };
    offset.is_finite().then_some(()).ok_or(refused)
}

/// The compliance of a row is a number, and not negative.
fn check_compliance<T: Real>(compliance: T, row: usize) -> Result<(), Error> {
    let usable = compliance >= T::ZERO && compliance.is_finite();
    usable.then_some(()).ok_or(Error::InvalidRowCompliance { row })
}
