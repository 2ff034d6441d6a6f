//! The scene: generalised mass matrix and contacts, checked where they enter.

use crate::laws::{Coulomb, Laws, NoRoom, Room};
use crate::linalg::hints::opaque;
use crate::linalg::sparsity::{GROUP, Support};
use crate::{Error, FrictionCone, Input, Real};
use checks::{check_symmetric, fingerprint, take};
use nalgebra::{ArrayStorage, SMatrix, SVector};
use slot::Slot;

mod checks;
mod contact;
mod delassus;
mod rows;
pub(crate) mod slot;

pub(crate) use checks::check_finite;
pub use contact::Contact;

/// A generalised mass matrix and up to `C` contacts of `D` rows each over `N` velocities.
///
/// The number of contacts is chosen at run time, the sizes at compile time. A scene can stand in
/// a `static`. What is in it has been checked; but after an `Err` halfway through filling it is half a scene, which a
/// solve would solve: call [`Self::clear_contacts`] then.
///
/// Everything is replaced in place. What a change costs before the next solve, with `m` contact rows:
///
/// | change | to be done | multiplications |
/// |---|---|---|
/// | the free impulse; an offset `w_i`, [`Self::set_offset`]; a friction coefficient, [`Self::set_friction`] | nothing | 0 |
/// | `M`, [`Self::set_mass`]; a Jacobian, [`Self::set_jacobian`]; the contacts in use, each step | [`crate::Factor::prepare`], in place | `N³/6 + m N²/2 + m² N/2` |
/// | the same, for [`crate::AdmmSolver`] | [`crate::AdmmFactor::prepare`], in place | `m³/2` more |
/// | the penalty of ADMM | [`crate::AdmmFactor::set_penalty`] | `m³/2` |
///
/// Contacts that come and go are pushed again, with the keys they had ([`Contact::key`]). A contact that opens for a while
/// is cheaper kept, with its gap as an offset ([`crate::time_stepping::gap`]).
///
/// ```
/// use nalgebra::{Matrix2, matrix, vector};
/// use stiction::{Contact, Error, Scene};
///
/// // A 2 kg point mass in the plane (x, height) over a floor.
/// let mut scene = Scene::<f32, 2, 2, 1>::new();
/// scene.set_mass(&(Matrix2::identity() * 2.0))?;
/// let floor = Contact {
///     jacobian: matrix![0.0, 1.0; 1.0, 0.0], // normal row first
///     offset: vector![0.0, 0.0],
///     mu: 0.5,
///     key: 0,
/// };
/// assert_eq!(scene.push(&floor), Ok(0));
/// assert_eq!(scene.push(&floor), Err(Error::ContactListFull { capacity: 1 }));
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene<T: Real, const N: usize, const D: usize, const C: usize, L: Laws = Coulomb> {
    mass: SMatrix<T, N, N>,
    contacts: [Contact<T, N, D>; C],
    /// Nonzero columns of their Jacobians.
    supports: [Support; C],
    /// Contacts in use.
    count: usize,
    /// Fingerprint of `M`.
    mass_print: u64,
    /// Sum of the fingerprints of the contacts' Jacobians.
    contacts_print: u64,
    /// By how much `H Hᵀ` differs from a `W` that was given, relative to its diagonal; 0 if none was.
    delassus_gap: T,
    /// What a slot has that a contact alone has not.
    slots: [L::Room<Slot<T, D>>; C],
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Scene<T, N, D, C> {
    /// A scene without mass and without contacts; give it a mass matrix before it is factorised.
    #[must_use]
    pub const fn new() -> Self {
        Self::empty()
    }

    /// A scene with all its `C` contacts from constants, to stand in a `static`.
    ///
    /// Unchecked: use numbers that [`Self::set_mass`] and [`Self::push`] accepted on the host (`examples/bake`, and the
    /// example of [`crate::Factor::from_parts`]). Other numbers end in an error or a status other than
    /// [`crate::Status::Solved`], never in a panic. A factor that is computed for such a scene is not told from that of another
    /// one with as many contacts.
    #[must_use]
    pub const fn from_parts(mass: SMatrix<T, N, N>, contacts: [Contact<T, N, D>; C]) -> Self {
        Self {
            mass,
            contacts,
            supports: [Support::all(); C],
            count: C,
            mass_print: 1,
            contacts_print: 0,
            delassus_gap: T::ZERO,
            slots: [const { NoRoom::EMPTY }; C],
        }
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Scene<T, N, D, C, L> {
    /// Without mass, and without contacts or rows.
    const fn empty() -> Self {
        const { assert!(N >= 1 && D >= 1 && C >= 1, "N, D and C are at least 1") }
        Self {
            mass: SMatrix::from_array_storage(ArrayStorage([[T::ZERO; N]; N])),
            contacts: [const { Contact::none() }; C],
            supports: [Support::none(); C],
            count: 0,
            mass_print: 0,
            contacts_print: 0,
            delassus_gap: T::ZERO,
            slots: [const { L::Room::EMPTY }; C],
        }
    }

    /// Sets the generalised mass matrix `M` (`N × N`; kg, kg m, kg m² by the units of the dofs). A stored factor is
    /// stale then, see [`Self::set_jacobian`].
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::MassNotSymmetric`] if `M_ij` and `M_ji` differ by more than `sqrt(eps |M_ii M_jj|)`.
    /// Whether `M` is positive definite is checked by [`crate::Factor::prepare`].
    pub fn set_mass(&mut self, mass: &SMatrix<T, N, N>) -> Result<(), Error> {
        check_finite(mass, Input::Mass)?;
        check_symmetric(mass)?;
        self.mass_print = take(self.mass.as_mut_slice(), mass.as_slice(), C);
        self.delassus_gap = T::ZERO;
        Ok(())
    }

    /// Adds a contact and returns its index.
    ///
    /// # Errors
    /// [`Error::ContactListFull`], [`Error::NotFinite`], [`Error::InvalidFriction`].
    pub fn push(&mut self, contact: &Contact<T, N, D>) -> Result<usize, Error> {
        let index = self.count;
        let Some(slot) = self.contacts.get_mut(index) else {
            return Err(Error::ContactListFull { capacity: C });
        };
        check_finite(&contact.jacobian, Input::Jacobian { contact: index })?;
        check_finite(&contact.offset, Input::Offset { contact: index })?;
        if FrictionCone::new(contact.mu).is_none() {
            return Err(Error::InvalidFriction { contact: index });
        }
        (slot.offset, slot.mu, slot.key) = (contact.offset, contact.mu, contact.key);
        let (target, numbers) = (slot.jacobian.as_mut_slice(), contact.jacobian.as_slice());
        let print = take(target, numbers, index);
        self.contacts_print = self.contacts_print.wrapping_add(print);
        if let Some(place) = self.slots.get_mut(index) {
            *place = L::Room::EMPTY;
        }
        self.count += 1;
        self.support(index);
        Ok(index)
    }

    /// Removes all contacts.
    pub fn clear_contacts(&mut self) {
        self.count = 0;
        self.contacts_print = 0;
        self.delassus_gap = T::ZERO;
    }

    /// Replaces the Jacobian `H_i` of a contact (`D × N`). A stored factor is stale then: a solve refuses it
    /// ([`Error::StaleFactor`]) until it is prepared again. A factor from [`crate::Factor::from_parts`] is never refused: do
    /// not change Jacobians with it.
    ///
    /// # Errors
    /// [`Error::NoSuchContact`], [`Error::NotFinite`].
    pub fn set_jacobian(
        &mut self,
        contact: usize,
        jacobian: &SMatrix<T, D, N>,
    ) -> Result<(), Error> {
        check_finite(jacobian, Input::Jacobian { contact })?;
        self.contact_mut(contact)?;
        let before = self.contact_print(contact);
        self.contact_mut(contact)?.jacobian.copy_from(jacobian);
        self.support(contact);
        let print = self.contacts_print.wrapping_sub(before);
        self.contacts_print = print.wrapping_add(self.contact_print(contact));
        Ok(())
    }

    /// Replaces the offset `w_i` of a contact; a stored factor stays valid.
    ///
    /// # Errors
    /// [`Error::NoSuchContact`], [`Error::NotFinite`].
    pub fn set_offset(&mut self, contact: usize, offset: &SVector<T, D>) -> Result<(), Error> {
        check_finite(offset, Input::Offset { contact })?;
        let slot = self.contact_mut(contact)?;
        slot.offset = *offset;
        Ok(())
    }

    /// Replaces the friction coefficient `mu_i` of a contact; a stored factor stays valid. It is the larger one of a surface of
    /// `push_on`, which scales the others with it, and there it cannot become 0 or cease to be: push the contact anew.
    ///
    /// # Errors
    /// [`Error::NoSuchContact`], [`Error::InvalidFriction`].
    pub fn set_friction(&mut self, contact: usize, mu: T) -> Result<(), Error> {
        let slot = self.slots.get(contact).and_then(Room::get);
        let is_replaceable = slot.map(|slot| slot.has_tangents() && mu > T::ZERO);
        let place = &mut self.contact_mut(contact)?.mu;
        let fits = is_replaceable.is_none_or(|fits| fits && *place > T::ZERO);
        if FrictionCone::new(mu).is_none() || !fits {
            return Err(Error::InvalidFriction { contact });
        }
        *place = mu;
        Ok(())
    }

    /// A mass that changes with the unit of mass as all others do: the power of two below `M_00`. What is scaled by it does
    /// so exactly.
    pub(crate) fn reference_mass(&self) -> T {
        let first = self.mass.as_slice().first();
        first.map_or(T::ONE, |mass| T::power_of_two(mass.exponent()))
    }

    /// By how much `H Hᵀ` differs from a `W` that was given: `W_ab` by so many `sqrt(W_aa W_bb)` at most.
    pub(crate) const fn delassus_gap(&self) -> T {
        self.delassus_gap
    }

    /// 64-bit hash of `M` and `H`. Neither 0 nor the largest number. (Of 32 bits two scenes of a simulation have the same one
    /// every few hours.)
    pub(crate) fn fingerprint(&self) -> u64 {
        let sum = self.mass_print.wrapping_add(self.contacts_print);
        sum.clamp(1, u64::MAX - 1)
    }

    /// Fingerprint of a Jacobian and its place.
    fn contact_print(&self, contact: usize) -> u64 {
        let jacobian = self.contacts.get(contact).map(|contact| &contact.jacobian);
        let own = jacobian.map_or(0, |jacobian| fingerprint(jacobian.as_slice(), contact));
        let slot = self.slots.get(contact).and_then(Room::get);
        slot.map_or(own, |slot| own.wrapping_add(slot.fingerprint(contact)))
    }

    /// A contact in use; a slot of joint rows is none.
    fn contact_mut(&mut self, contact: usize) -> Result<&mut Contact<T, N, D>, Error> {
        let holds_rows = self.slot(contact).is_some_and(|slot| slot.rows.is_some());
        let contacts = self.contacts.get_mut(..self.count).unwrap_or_default();
        let found = contacts.get_mut(contact).filter(|_| !holds_rows);
        found.ok_or(Error::NoSuchContact { contact })
    }

    /// Finds out what a Jacobian moves.
    fn support(&mut self, contact: usize) {
        let supports = self.supports.get_mut(contact);
        if let (Some(support), Some(contact)) = (supports, self.contacts.get(contact)) {
            let groups = contact
                .jacobian
                .as_slice()
                .chunks_exact(GROUP * D)
                .enumerate();
            let moved = groups.filter(|(_, group)| group.iter().any(|&entry| entry != T::ZERO));
            *support = Support::of::<N>(moved.map(|(group, _)| group * GROUP));
        }
    }

    /// The generalised mass matrix `M`.
    #[must_use]
    pub const fn mass(&self) -> &SMatrix<T, N, N> {
        &self.mass
    }

    /// The contacts, in the order they were added.
    #[must_use]
    pub fn contacts(&self) -> &[Contact<T, N, D>] {
        self.contacts.get(..self.count).unwrap_or_default()
    }

    /// What a slot has that a contact alone has not.
    #[inline]
    pub(crate) fn slot(&self, index: usize) -> Option<&Slot<T, D>> {
        self.slots.get(index).and_then(Room::get)
    }

    /// Is there anything but rigid contacts of one friction coefficient? If not, it is a scene of [`Coulomb`] laws.
    #[inline]
    pub(crate) fn is_mixed(&self) -> bool {
        L::MIXED && (0..self.count).any(|slot| self.slot(slot).is_some())
    }

    /// The contacts, each with where its Jacobian has entries.
    #[inline]
    pub(crate) fn supported(&self) -> impl Iterator<Item = (&Contact<T, N, D>, Support)> {
        let contacts = opaque(self.contacts()).iter();
        contacts.zip(self.supports.iter().copied())
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Default for Scene<T, N, D, C> {
    fn default() -> Self {
        Self::new()
    }
}
