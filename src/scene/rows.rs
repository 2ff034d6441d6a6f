//! Scenes of contacts and joint rows.

use super::slot::Slot;
use super::{Scene, check_finite};
use crate::laws::Mixed;
use crate::{Contact, Error, Input, JointRow, Real, RowIndex, RowLaw, Surface};

impl<T: Real, const N: usize, const D: usize, const C: usize> Scene<T, N, D, C, Mixed> {
    /// A scene for contacts and joint rows, without mass and without either.
    ///
    /// Each of its `C` slots holds one contact or up to `D` joint rows. [`Self::contacts`] has all slots, one that holds
    /// joint rows as a contact whose Jacobian has them.
    ///
    /// ```
    /// use nalgebra::{Matrix1, vector};
    /// use stiction::{Factor, JointRow, RowLaw, RowMode, Scene, Settings, Solver};
    ///
    /// // A pendulum of 0.5 kg m² falls at 2 rad/s onto its stop.
    /// let mut scene = Scene::<f64, 1, 1, 1, _>::mixed();
    /// scene.set_mass(&Matrix1::new(0.5))?;
    /// let stop = scene.push_row(&JointRow {
    ///     row: vector![1.0],
    ///     offset: 0.0,
    ///     law: RowLaw::Limit,
    ///     compliance: 0.0,
    ///     key: 0,
    /// })?;
    /// let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
    /// let solution = solver.solve(&scene, &factor, &vector![-1.0], &Settings::new(1e-9))?;
    /// let stop = solution.row(stop).unwrap();
    /// assert_eq!(stop.mode, RowMode::AtLimit);
    /// assert!((stop.impulse - 1.0).abs() < 1e-9); // N·m·s
    /// # Ok::<(), stiction::Error>(())
    /// ```
    #[must_use]
    pub const fn mixed() -> Self {
        Self::empty()
    }

    /// Adds a contact with a surface of its own, which stands in for its [`Contact::mu`], and returns its slot.
    ///
    /// # Errors
    /// As [`Self::push`]; [`Error::InvalidCompliance`].
    pub fn push_on(
        &mut self,
        contact: &Contact<T, N, D>,
        surface: &Surface<T>,
    ) -> Result<usize, Error> {
        surface.check(self.count)?;
        let (mu, scales) = (surface.reference::<D>(), surface.scales());
        let index = self.push(&Contact {
            mu,
            ..contact.clone()
        })?;
        let slot = Slot {
            scales,
            compliance: surface.compliances(&scales),
            rows: None,
        };
        self.refill(index, |_, place| *place = Some(slot));
        Ok(index)
    }

    /// Adds a joint row, in the first slot of joint rows that has room or else in a new one.
    ///
    /// # Errors
    /// [`Error::ContactListFull`] if there is no slot left, [`Error::NotFinite`], [`Error::InvalidBounds`],
    /// [`Error::InvalidCompliance`].
    pub fn push_row(&mut self, row: &JointRow<T, N>) -> Result<RowIndex, Error> {
        let (slot, before) = (self.room_behind(0), self.contacts_print);
        if slot < self.count {
            self.contacts_print = before.wrapping_sub(self.contact_print(slot));
        }
        let placed = self.place_row(slot, row);
        self.contacts_print = match placed {
            Ok(_) => self.contacts_print.wrapping_add(self.contact_print(slot)),
            Err(_) => before,
        };
        placed
    }

    /// The first slot from `first` on that has room for a joint row.
    pub(crate) fn room_behind(&self, first: usize) -> usize {
        let has_room = |slot: &usize| self.slot(*slot).is_some_and(Slot::has_room);
        (first..self.count).find(has_room).unwrap_or(self.count)
    }

    /// Adds a joint row to a slot that has room or is the next one. The fingerprint stays what it is.
    pub(crate) fn place_row(
        &mut self,
        slot: usize,
        row: &JointRow<T, N>,
    ) -> Result<RowIndex, Error> {
        let is_new = slot == self.count;
        let place = self.slot(slot).filter(|_| !is_new);
        let index = RowIndex {
            slot,
            row: place.map_or(0, Slot::count),
        };
        check_finite(&row.row, Input::JointRow { row: index })?;
        check_row(row, index)?;
        let entries = self.contacts.get_mut(slot).zip(self.slots.get_mut(slot));
        let Some((contact, place)) = entries else {
            return Err(Error::ContactListFull { capacity: C });
        };
        if is_new {
            *contact = Contact::none();
            contact.key = u32::MAX;
            *place = Some(Slot::rows());
            self.count += 1;
        }
        for (column, &entry) in contact.jacobian.data.0.iter_mut().zip(row.row.iter()) {
            if let Some(place) = column.get_mut(index.row) {
                *place = entry;
            }
        }
        if let Some(offset) = contact.offset.as_mut_slice().get_mut(index.row) {
            *offset = row.offset;
        }
        if let Some(slot) = place {
            slot.add(row);
        }
        self.support(slot);
        Ok(index)
    }

    /// Keeps the first slots alone, behind which rows were placed.
    pub(crate) const fn truncate(&mut self, count: usize) {
        self.count = count;
    }

    /// Replaces the offset of a joint row; a stored factor stays valid.
    ///
    /// # Errors
    /// [`Error::NoSuchRow`], [`Error::NotFinite`].
    pub fn set_row_offset(&mut self, row: RowIndex, offset: T) -> Result<(), Error> {
        if !offset.is_finite() {
            return Err(not_finite(row));
        }
        self.law_mut(row)?;
        let entries = self.contacts.get_mut(row.slot);
        let entry = entries.and_then(|contact| contact.offset.as_mut_slice().get_mut(row.row));
        *entry.ok_or(Error::NoSuchRow { row })? = offset;
        Ok(())
    }

    /// Replaces the law of a joint row; a stored factor stays valid.
    ///
    /// # Errors
    /// [`Error::NoSuchRow`], [`Error::InvalidBounds`].
    pub fn set_row_law(&mut self, row: RowIndex, law: RowLaw<T>) -> Result<(), Error> {
        let bounds = self.law_mut(row)?;
        if !law.is_valid() {
            return Err(Error::InvalidBounds { row });
        }
        *bounds = law.bounds();
        Ok(())
    }

    /// The bounds of a joint row.
    fn law_mut(&mut self, row: RowIndex) -> Result<&mut [T; 2], Error> {
        let used = self.slots.get_mut(..self.count).unwrap_or_default();
        let slot = used.get_mut(row.slot).and_then(Option::as_mut);
        let rows = slot.and_then(|slot| slot.rows.as_mut());
        let rows = rows.filter(|rows| row.row < rows.count);
        let bounds = rows.and_then(|rows| rows.bounds.get_mut(row.row));
        bounds.ok_or(Error::NoSuchRow { row })
    }

    /// Changes what a slot in use has, and its fingerprint.
    fn refill(
        &mut self,
        index: usize,
        change: impl FnOnce(&mut Contact<T, N, D>, &mut Option<Slot<T, D>>),
    ) {
        let before = self.contact_print(index);
        let slot = self.contacts.get_mut(index).zip(self.slots.get_mut(index));
        if let Some((contact, place)) = slot {
            change(contact, place);
        }
        let print = self.contacts_print.wrapping_sub(before);
        self.contacts_print = print.wrapping_add(self.contact_print(index));
    }
}

impl<T: Real, const D: usize> Slot<T, D> {
    /// Joint rows in it.
    fn count(&self) -> usize {
        self.rows.map_or(0, |rows| rows.count)
    }

    /// Is there room for another joint row?
    fn has_room(&self) -> bool {
        self.rows.is_some_and(|rows| rows.count < D)
    }

    /// Adds the law of a joint row.
    fn add<const N: usize>(&mut self, row: &JointRow<T, N>) {
        let Some(rows) = &mut self.rows else { return };
        let place = rows.count;
        let targets = self
            .compliance
            .get_mut(place)
            .zip(rows.bounds.get_mut(place));
        if let Some(((compliance, bounds), key)) = targets.zip(rows.keys.get_mut(place)) {
            (*compliance, *bounds, *key) = (row.compliance, row.law.bounds(), row.key);
            rows.count += 1;
        }
    }
}

/// What can be wrong with the numbers of a row.
fn check_row<T: Real, const N: usize>(row: &JointRow<T, N>, index: RowIndex) -> Result<(), Error> {
    if !row.offset.is_finite() {
        return Err(not_finite(index));
    }
    if !row.law.is_valid() {
        return Err(Error::InvalidBounds { row: index });
    }
    if !(row.compliance >= T::ZERO && row.compliance.is_finite()) {
        return Err(Error::InvalidCompliance { slot: index.slot });
    }
    Ok(())
}

/// The offset of a row is no number.
fn not_finite(row: RowIndex) -> Error {
    Error::NotFinite {
        input: Input::JointRow { row },
        row: 0,
        column: 0,
    }
}
