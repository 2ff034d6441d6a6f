//! The scene: generalised mass matrix, contacts and joint rows.

use crate::error::Error;
use crate::linalg::sparsity::Support;
use crate::linalg::stacked::Counts;
use crate::real::Real;
use checks::{check_mass, copy_and_hash, fingerprint, is_finite_and_symmetric};
use nalgebra::{ArrayStorage, SMatrix};
use refused::Refused;
pub(crate) use surface::Scaling;

mod checks;
mod contact;
mod contacts;
mod joint_row;
mod refused;
mod rows;
mod surface;

pub(crate) use checks::{check_entries, check_finite};
pub use contact::{Contact, contact_frame};
pub use joint_row::{JointRow, RowLaw};
pub use surface::Surface;

/// A generalised mass matrix, up to `C` contacts of `D` rows each and up to `R` joint rows, over up to `N` velocities. Up to `S`
/// contacts may have a [`Surface`] of their own.
///
/// The sizes are chosen at compile time, the number of contacts, rows and velocities ([`Self::set_velocities`]) in use at run time. A scene can stand in a `static`. It checks all
/// data as it is filled. If it refuses a contact, a joint row or a mass matrix, no solve takes it ([`Error::SceneIncomplete`]) until
/// [`Self::clear`], or for the mass until another one is set.
///
/// All data can be replaced in place. Costs before the next solve, with `m` contact and joint rows:
///
/// | change | then call | multiplications |
/// |---|---|---|
/// | the free impulse; an offset, [`Self::set_offset`]; a friction coefficient, [`Self::set_friction`]; a joint row's offset and law, [`Self::set_row_offset`], [`Self::set_row_law`] | nothing | 0 |
/// | `M`, [`Self::set_mass`]; a Jacobian or a compliance, [`Self::set_jacobian`], [`Self::set_row_jacobian`], [`Self::set_row_compliance`]; the contacts and rows in use | [`crate::Factor::prepare`], in place | `N³/6 + m N²/2 + m² N/2` |
/// | the number of velocities, [`Self::set_velocities`] | fill the scene, and prepare | the same |
/// | the same, for [`crate::AdmmSolver`] | [`crate::AdmmFactor::prepare`], in place | `m³/2` more |
/// | the penalty of ADMM | [`crate::AdmmFactor::set_penalty`] | `m³/2` |
///
/// Push contacts that come and go with the same [`Contact::key`] each time. To keep a contact that opens for a while is cheaper: give it its
/// gap as an offset ([`crate::time_stepping::Gap`]).
///
/// ```
/// use nalgebra::{Matrix2, matrix, vector};
/// use stiction::{Contact, Error, List, Scene};
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
/// assert_eq!(scene.push(&floor), Err(Error::ListFull { list: List::Contacts, capacity: 1 }));
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize = 0,
    const S: usize = 0,
> {
    /// Zero outside of the first rows and columns, if not all velocities are in use.
    mass: SMatrix<T, N, N>,
    contacts: [Contact<T, N, D>; C],
    /// Scales and compliance of the rows of contacts with surfaces, in the order of the contacts.
    scalings: [Scaling<T, D>; S],
    /// Nonzero columns of the contacts' Jacobians.
    supports: [Support; C],
    rows: [JointRow<T, N>; R],
    /// Of each contact the number of its surface, from 1, or 0 without one.
    surface_numbers: [u8; C],
    /// Contacts and rows in use.
    counts: Counts,
    /// Velocities that are not in use. (0 in a new scene, which is all zeros.)
    unused: usize,
    /// Surfaces in use.
    surfaces: u8,
    refused: Refused,
    /// Fingerprint of `M`; `None` as long as no mass was set, and then no other is known either.
    mass_print: Option<u64>,
    /// Sums of the fingerprints of contacts and of joint rows.
    contacts_print: u64,
    rows_print: u64,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Scene<T, N, D, C, R, S>
{
    /// A scene without mass, contacts and joint rows. Set a mass matrix before the first solve.
    #[must_use]
    pub const fn new() -> Self {
        const {
            assert!(N >= 1 && C + R >= 1, "a scene has velocities, and room for a contact or a joint row");
            assert!(S <= C, "there is room for more surfaces than contacts");
            assert!(S < 256, "there is room for more than 255 surfaces");
            assert!(
                matches!(D, 1..=4 | 6),
                "a contact has 1, 2, 3, 4 or 6 rows: normal, tangents, spin, two rolls"
            );
        }
        Self {
            mass: SMatrix::from_array_storage(ArrayStorage([[T::ZERO; N]; N])),
            contacts: [const { Contact::none() }; C],
            scalings: [Scaling::none(); S],
            supports: [Support::none(); C],
            rows: [const { JointRow::none() }; R],
            surface_numbers: [0; C],
            counts: Counts { contacts: 0, rows: 0 },
            unused: 0,
            surfaces: 0,
            refused: Refused::none(),
            mass_print: None,
            contacts_print: 0,
            rows_print: 0,
        }
    }

    /// Sets the generalised mass matrix `M` (`N × N`; kg, kg m, kg m² by the units of the dofs). A stored factor is
    /// stale then, see [`Self::set_jacobian`].
    ///
    /// If `M_ij` and `M_ji` differ by less than `sqrt(eps |M_ii M_jj|)`, the entry above the diagonal replaces the other one.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::MassNotSymmetric`] if two entries differ by more. [`crate::Factor::prepare`] checks whether `M` is positive
    /// definite.
    pub fn set_mass(&mut self, mass: &SMatrix<T, N, N>) -> Result<(), Error> {
        self.refused.mass = true; // until it is accepted below
        let n = self.velocities();
        let is_symmetric = is_finite_and_symmetric(mass, n);
        if !is_symmetric {
            check_mass(mass, n)?;
        }
        if self.mass_print.is_none() {
            self.contacts_print = self.prints_of_contacts();
            self.rows_print = self.prints_of_rows();
        }
        let mut print = if n < N {
            self.copy_first(mass, n)
        } else {
            copy_and_hash(self.mass.as_mut_slice(), mass.as_slice(), C + R)
        };
        if !is_symmetric {
            self.mass.fill_lower_triangle_with_upper_triangle();
            print = fingerprint(self.used(&self.mass, N), C + R);
        }
        self.mass_print = Some(print);
        self.refused.mass = false;
        Ok(())
    }

    /// Copies the first `n` rows and columns of a mass matrix, and returns its fingerprint.
    #[cold]
    #[inline(never)]
    fn copy_first(&mut self, mass: &SMatrix<T, N, N>, n: usize) -> u64 {
        for (target, column) in self.mass.data.0.iter_mut().zip(&mass.data.0).take(n) {
            for (target, &entry) in target.iter_mut().zip(column).take(n) {
                *target = entry;
            }
        }
        fingerprint(self.used(&self.mass, N), C + R)
    }

    /// Sets the number of velocities, from 1 to `N`: room for velocities is filled in part, as room for contacts. A new scene has `N`.
    ///
    /// Of all data over the velocities the first count from now on: the first rows and columns of `M`, the first columns of Jacobians, the
    /// first entries of joint rows, limits and the free impulse. What stands behind them is not read, and may be no number. The velocities of a
    /// solution and the gradients of a derivative are 0 there.
    ///
    /// A number that is not the last one removes `M`, contacts and joint rows. A stored factor is stale then. A warm start still follows the
    /// keys of contacts: [`crate::Solver::reset`] forgets those of another robot.
    ///
    /// A scene has the bits of a kernel with as many velocities as it has, and takes little more time ([`crate::guide::rows`] has numbers).
    ///
    /// ```
    /// use nalgebra::{SMatrix, SVector, vector};
    /// use stiction::{Contact, Kernel, Settings};
    ///
    /// let mut kernel = Kernel::<f64, 30, 3, 12>::new(); // room for several robots
    /// let scene = kernel.scene_mut();
    /// scene.set_velocities(3)?; // a point mass of 2 kg over a floor
    /// scene.set_mass(&(SMatrix::identity() * 2.0))?;
    /// let mut jacobian = SMatrix::zeros();
    /// for (row, axis) in [2, 0, 1].into_iter().enumerate() {
    ///     jacobian[(row, axis)] = 1.0; // normal row first
    /// }
    /// scene.push(&Contact { jacobian, offset: vector![0.0, 0.0, 0.0], mu: 0.5, key: 0 })?;
    /// let mut free_impulse = SVector::zeros();
    /// free_impulse[2] = -0.2;
    /// let solution = kernel.solve(&free_impulse, &Settings::default())?;
    /// assert!((solution.contacts[0].impulse[0] - 0.2).abs() < 1e-5);
    /// assert_eq!(kernel.scene_mut().set_velocities(31).unwrap_err().to_string(), "a scene cannot have 31 velocities (1 to 30)");
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::InvalidVelocityCount`] if it is 0 or above `N`. The scene is then as it was.
    pub fn set_velocities(&mut self, velocities: usize) -> Result<(), Error> {
        let unused = N.checked_sub(velocities).filter(|&unused| unused < N);
        let unused = unused.ok_or(Error::InvalidVelocityCount { velocities, capacity: N })?;
        if unused != self.unused {
            self.reset();
            // What later data do not use stays zero.
            for contact in &mut self.contacts {
                contact.jacobian.fill(T::ZERO);
            }
            for row in &mut self.rows {
                row.row.fill(T::ZERO);
            }
            self.unused = unused;
        }
        Ok(())
    }

    /// The number of velocities, [`Self::set_velocities`].
    #[must_use]
    #[inline]
    pub const fn velocities(&self) -> usize {
        N.saturating_sub(self.unused)
    }

    /// Velocities that are not in use.
    #[inline]
    pub(crate) const fn unused(&self) -> usize {
        self.unused
    }

    /// The columns in use, of a matrix with `rows` rows.
    #[inline]
    pub(crate) fn used<'a, const K: usize, const L: usize>(
        &self,
        matrix: &'a SMatrix<T, K, L>,
        rows: usize,
    ) -> &'a [T] {
        let entries = matrix.as_slice();
        entries.get(..rows * self.velocities()).unwrap_or(entries)
    }

    /// Removes all contacts and joint rows. `M` stays, and a warm start still follows the keys of contacts that come again.
    pub fn clear(&mut self) {
        self.clear_contacts();
        self.clear_rows();
    }

    /// Makes the scene as new, in place.
    pub(crate) fn reset(&mut self) {
        self.clear();
        self.mass.fill(T::ZERO);
        self.mass_print = None;
        self.refused.mass = false;
        self.unused = 0;
    }

    /// The power of two below `M_00`: a mass that changes with the unit of mass, and scales numbers without rounding.
    pub(crate) fn reference_mass(&self) -> T {
        let first = self.mass.as_slice().first();
        first.map_or(T::ONE, |mass| T::power_of_two(mass.exponent()))
    }

    /// 64-bit hash of `M`, `H`, joint rows and compliance. Not 0. (Of 32 bits two scenes of a
    /// simulation have the same one every few hours.)
    pub(crate) fn fingerprint(&self) -> u64 {
        let [mass, contacts, rows] = match self.mass_print {
            Some(mass) => [mass, self.contacts_print, self.rows_print],
            None => [
                fingerprint(self.used(&self.mass, N), C + R),
                self.prints_of_contacts(),
                self.prints_of_rows(),
            ],
        };
        let sum = mass.wrapping_add(contacts).wrapping_add(rows);
        sum.max(1)
    }

    /// Fingerprint of all data of the scene, and of what was hashed before.
    pub(crate) fn data_fingerprint(&self, mut hash: u64) -> u64 {
        for contact in self.contacts() {
            hash = contact.mu.hash(hash ^ u64::from(contact.key));
            hash = contact.offset.iter().fold(hash, |hash, offset| offset.hash(hash));
        }
        for row in self.rows() {
            let [lower, upper] = row.law.bounds();
            hash = row.offset.hash(lower.hash(upper.hash(hash ^ u64::from(row.key))));
        }
        hash.wrapping_add(self.fingerprint())
    }

    /// Contacts and rows in use.
    pub(crate) const fn counts(&self) -> Counts {
        self.counts
    }

    /// The generalised mass matrix `M`.
    #[must_use]
    pub const fn mass(&self) -> &SMatrix<T, N, N> {
        &self.mass
    }

    /// Is there anything but rigid contacts of one friction coefficient?
    #[inline]
    pub(crate) const fn is_mixed(&self) -> bool {
        S > 0 && self.surfaces > 0 || R > 0 && self.counts.rows > 0
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize> Default
    for Scene<T, N, D, C, R, S>
{
    fn default() -> Self {
        Self::new()
    }
}

/// Moves the first element to the end, and all others up by one.
fn move_up<V>(elements: Option<&mut [V]>) {
    if let Some(elements) = elements
        && !elements.is_empty()
    {
        elements.rotate_left(1);
    }
}
