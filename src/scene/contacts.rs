//! The contacts of a scene: pushed, changed, removed.

use super::checks::{check_entries, check_finite, copy_and_hash, fingerprint};
use super::surface::Scaling;
use super::{Contact, Scene, Surface, move_up};
use crate::cone::FrictionCone;
use crate::error::{Error, Input, List};
use crate::linalg::sparsity::{GROUP, Support};
use crate::real::Real;
use core::mem;
use nalgebra::{SMatrix, SVector};

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Scene<T, N, D, C, R, S>
{
    /// Adds a contact and returns its index. A contact with rows for spin or roll needs [`Self::push_on`].
    ///
    /// # Errors
    /// [`Error::ListFull`], [`Error::NotFinite`], [`Error::InvalidFriction`].
    pub fn push(&mut self, contact: &Contact<T, N, D>) -> Result<usize, Error> {
        const { assert!(D <= 3, "spin and roll have lengths: Scene::push_on") }
        self.append(contact, contact.mu, None).inspect_err(|_| self.refused.contact = true)
    }

    /// Adds a contact with a [`Surface`] in place of its [`Contact::mu`] and returns its index. Up to `S` contacts may have one, in any place.
    ///
    /// # Errors
    /// As [`Self::push`]; [`Error::InvalidCompliance`].
    pub fn push_on(&mut self, contact: &Contact<T, N, D>, surface: &Surface<T>) -> Result<usize, Error> {
        self.append_on(contact, surface).inspect_err(|_| self.refused.contact = true)
    }

    /// Adds a contact with a surface of its own.
    fn append_on(&mut self, contact: &Contact<T, N, D>, surface: &Surface<T>) -> Result<usize, Error> {
        surface.check(self.counts.contacts)?;
        if usize::from(self.surfaces) >= S && self.counts.contacts < C {
            let (list, capacity) = (List::Surfaces, S);
            return Err(Error::ListFull { list, capacity });
        }
        let scaling = Scaling::of(surface);
        self.append(contact, surface.reference::<D>(), Some(&scaling))
    }

    /// Adds a contact with this friction coefficient.
    fn append(
        &mut self,
        contact: &Contact<T, N, D>,
        mu: T,
        scaling: Option<&Scaling<T, D>>,
    ) -> Result<usize, Error> {
        let (index, used) = (self.counts.contacts, D * self.velocities());
        let Some(target) = self.contacts.get_mut(index) else {
            return Err(Error::ListFull { list: List::Contacts, capacity: C });
        };
        let input = Input::Jacobian { contact: index };
        let entries = contact.jacobian.as_slice();
        let entries = entries.get(..used).unwrap_or(entries);
        check_entries::<T, D>(entries, input)?;
        let mut print = copy_and_hash(target.jacobian.as_mut_slice(), entries, index);
        check_finite(&contact.offset, Input::Offset { contact: index })?;
        if !FrictionCone::is_valid(mu) {
            return Err(Error::InvalidFriction { contact: index, row: 1 });
        }
        (target.offset, target.mu, target.key) = (contact.offset, mu, contact.key);
        if let Some(scaling) = scaling {
            self.store_scaling(index, scaling);
            print = scaling.fingerprint(print);
        }
        self.contacts_print = self.contacts_print.wrapping_add(print);
        self.counts.contacts += 1;
        self.find_support(index);
        Ok(index)
    }

    /// Stores the scaling of a contact.
    fn store_scaling(&mut self, contact: usize, scaling: &Scaling<T, D>) {
        let unused = self.scalings.get_mut(usize::from(self.surfaces));
        if let (Some(target), Some(number)) = (unused, self.surface_numbers.get_mut(contact)) {
            *target = *scaling;
            self.surfaces += 1;
            *number = self.surfaces;
        }
    }

    /// Removes the scaling of a contact, if it has one.
    fn remove_scaling(&mut self, contact: usize) {
        let number = self.surface_numbers.get_mut(contact);
        let number = number.map(mem::take).unwrap_or_default();
        if let Some(first) = usize::from(number).checked_sub(1) {
            move_up(self.scalings.get_mut(first..usize::from(self.surfaces)));
            self.surfaces -= 1;
            for other in &mut self.surface_numbers {
                *other -= u8::from(*other > number);
            }
        }
    }

    /// Removes all contacts; joint rows stay.
    pub fn clear_contacts(&mut self) {
        self.counts.contacts = 0;
        self.contacts_print = 0;
        if S > 0 && self.surfaces > 0 {
            self.surfaces = 0;
            self.surface_numbers = [0; C];
        }
        self.refused.contact = false;
    }

    /// Removes a contact. The index of each later contact falls by one.
    ///
    /// # Errors
    /// [`Error::NoSuchContact`].
    pub fn remove_contact(&mut self, contact: usize) -> Result<(), Error> {
        self.contact_mut(contact)?;
        let last = self.counts.contacts;
        move_up(self.contacts.get_mut(contact..last));
        move_up(self.supports.get_mut(contact..last));
        self.remove_scaling(contact);
        move_up(self.surface_numbers.get_mut(contact..last));
        self.counts.contacts = last - 1;
        self.contacts_print = self.prints_of_contacts();
        Ok(())
    }

    /// Replaces the Jacobian `H_i` of a contact (`D × N`). A stored factor is stale then: a solve refuses it
    /// ([`Error::StaleFactor`]) until it is prepared again.
    ///
    /// # Errors
    /// [`Error::NoSuchContact`], [`Error::NotFinite`].
    pub fn set_jacobian(&mut self, contact: usize, jacobian: &SMatrix<T, D, N>) -> Result<(), Error> {
        let used = self.used(jacobian, D);
        check_entries::<T, D>(used, Input::Jacobian { contact })?;
        self.contact_mut(contact)?;
        let before = self.contact_print(contact);
        let target = self.contact_mut(contact)?.jacobian.as_mut_slice();
        for (target, &entry) in target.iter_mut().zip(used) {
            *target = entry;
        }
        self.find_support(contact);
        let print = self.contacts_print.wrapping_sub(before);
        self.contacts_print = print.wrapping_add(self.contact_print(contact));
        Ok(())
    }

    /// Replaces the offset `w_i` of a contact (m/s). A stored factor stays valid.
    ///
    /// # Errors
    /// [`Error::NoSuchContact`], [`Error::NotFinite`].
    pub fn set_offset(&mut self, contact: usize, offset: &SVector<T, D>) -> Result<(), Error> {
        check_finite(offset, Input::Offset { contact })?;
        self.contact_mut(contact)?.offset = *offset;
        Ok(())
    }

    /// Replaces the friction coefficient `mu_i` of a contact. A stored factor stays valid. For a surface it replaces the larger coefficient and
    /// scales the others with it; it cannot change to 0 or from 0.
    ///
    /// # Errors
    /// [`Error::NoSuchContact`], [`Error::InvalidFriction`].
    pub fn set_friction(&mut self, contact: usize, mu: T) -> Result<(), Error> {
        let surface = self.scaling(contact).copied();
        let current = &mut self.contact_mut(contact)?.mu;
        let fits = surface.is_none_or(|scaling| scaling.has_tangents() && mu > T::ZERO && *current > T::ZERO);
        if !FrictionCone::is_valid(mu) || !fits {
            return Err(Error::InvalidFriction { contact, row: 1 });
        }
        *current = mu;
        Ok(())
    }

    /// The contacts, in the order they were added.
    #[must_use]
    pub fn contacts(&self) -> &[Contact<T, N, D>] {
        self.contacts.get(..self.counts.contacts).unwrap_or_default()
    }

    /// Index of the first contact with this [`Contact::key`].
    ///
    /// ```
    /// # use nalgebra::{matrix, vector};
    /// # use stiction::{Contact, Scene};
    /// # let mut scene = Scene::<f64, 2, 2, 2>::new();
    /// # let foot = |key| Contact { jacobian: matrix![0.0, 1.0; 1.0, 0.0], offset: vector![0.0, 0.0], mu: 0.5, key };
    /// # for key in [7, 8] { scene.push(&foot(key))?; }
    /// // The foot with key 7 is gone.
    /// if let Some(contact) = scene.contact_index(7) {
    ///     scene.remove_contact(contact)?;
    /// }
    /// assert_eq!(scene.contact_index(8), Some(0)); // it has moved up
    /// # Ok::<(), stiction::Error>(())
    /// ```
    #[must_use]
    pub fn contact_index(&self, key: u32) -> Option<usize> {
        let mut contacts = self.contacts().iter();
        contacts.position(|contact| contact.key == key)
    }

    /// Scales and compliance of a contact that has a surface.
    #[inline]
    pub(crate) fn scaling(&self, contact: usize) -> Option<&Scaling<T, D>> {
        let number = self.surface_numbers.get(contact).filter(|_| S > 0)?;
        self.scalings.get(usize::from(*number).wrapping_sub(1))
    }

    /// The supports of the contacts' Jacobians.
    #[inline]
    pub(crate) const fn supports(&self) -> &[Support; C] {
        &self.supports
    }

    /// Sum of the fingerprints of the contacts in use.
    pub(super) fn prints_of_contacts(&self) -> u64 {
        let prints = (0..self.counts.contacts).map(|contact| self.contact_print(contact));
        prints.fold(0, u64::wrapping_add)
    }

    /// Fingerprint of a contact and its index.
    fn contact_print(&self, contact: usize) -> u64 {
        let jacobian = self.contacts.get(contact).map(|contact| &contact.jacobian);
        let print = jacobian.map_or(0, |jacobian| fingerprint(self.used(jacobian, D), contact));
        let scaling = self.scaling(contact);
        scaling.map_or(print, |scaling| scaling.fingerprint(print))
    }

    /// A contact in use.
    fn contact_mut(&mut self, contact: usize) -> Result<&mut Contact<T, N, D>, Error> {
        let contacts = self.contacts.get_mut(..self.counts.contacts).unwrap_or_default();
        contacts.get_mut(contact).ok_or(Error::NoSuchContact { contact })
    }

    /// Finds the columns of a Jacobian that are not zero.
    fn find_support(&mut self, contact: usize) {
        let supports = self.supports.get_mut(contact);
        if let (Some(support), Some(contact)) = (supports, self.contacts.get(contact)) {
            let groups = contact.jacobian.as_slice().chunks_exact(GROUP * D).enumerate();
            let moved = groups.filter(|(_, group)| group.iter().any(|&entry| entry != T::ZERO));
            *support = Support::of::<N>(moved.map(|(group, _)| group * GROUP));
        }
    }
}
