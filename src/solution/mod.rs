//! The solution of a solve: velocity, impulses, modes, status, error and work.

use crate::linalg::vector::zeros;
use crate::real::Real;
use core::fmt;
use heapless::Vec;
use nalgebra::SVector;

mod parts;
mod settings;

pub use parts::{ContactMode, ContactSolution, RowMode, RowSolution};
pub use settings::{Model, Settings, Work};

/// The end of a solve. [`crate::guide::tick`] says how a control loop responds to each.
///
/// ```
/// use stiction::{Solver, Status};
///
/// let solver = Solver::<f32, 3, 3, 1>::new();
/// assert_eq!(solver.solution().status, Status::Unsolved);
/// assert_eq!(solver.solution().status.to_string(), "nothing was solved yet");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Status {
    /// Nothing was solved yet, or a solve by [`crate::Solver::advance`] has not ended.
    Unsolved = 0, // so that a new solver is all zeros, and takes no flash
    /// The error is at most the tolerance.
    Solved = 1,
    /// The budget of the call was used up. The solution is the best so far: [`Solution::is_usable`] compares its error with
    /// one that you accept, and [`crate::Solver::resume`] continues.
    OutOfBudget = 4,
    /// The error is above the tolerance but near the limit of rounding in this number type, and no longer falls.
    PrecisionLimit = 2,
    /// No velocity satisfies all contacts and joint rows; [`Solution::certificate`] is the proof.
    Infeasible = 3,
    /// No solution was found, and friction locks bodies that the offsets push apart. [`Solution::certificate`] is the proof;
    /// [`crate::guide::error`] says what it proves.
    Jammed = 5,
    /// More limits are reached than there is room for ([`crate::Kernel::solve_with_limits`]). The solution obeys all else, and the error counts
    /// the limits that it violates.
    OutOfRows = 6,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unsolved => "nothing was solved yet",
            Self::Solved => "solved",
            Self::OutOfBudget => "out of budget",
            Self::PrecisionLimit => "at the limit of the number type",
            Self::Infeasible => "infeasible",
            Self::Jammed => "jammed by friction",
            Self::OutOfRows => "out of joint rows for limits",
        })
    }
}

/// The largest violations of Coulomb's law and of the laws of joint rows, see [`Solution::violation`].
///
/// Each field is the largest of all contacts or rows, and 0 if there is none. A contact or row breaks its law by a speed or by an impulse. Tangents
/// of a contact with a [`crate::Surface`] are measured in rows that are scaled so that its cone is round: there spin and roll are speeds of a length.
///
/// A contact under a load is told apart by the friction that would stop it: within `mu r_N` the contact has to stick, beyond it slides.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Violation<T> {
    /// Closing speed of a closed contact (m/s): `-u_N`.
    pub closing_speed: T,
    /// Normal impulse of a contact that opens (N·s): the smaller of `r_N` and the impulse that would stop the opening, `alpha u_N`.
    /// The convex relaxation opens what slides, and Coulomb's law does not.
    pub opening_impulse: T,
    /// Distance of an impulse from its friction cone (N·s): `|r_T| - mu r_N`, or `-r_N`.
    pub outside_cone: T,
    /// Speed along its tangents of a contact that friction could stop (m/s): `|u_T|`.
    pub creep: T,
    /// Friction that a sliding contact lacks (N·s): the distance of `r_T` from `mu r_N` against the slide. It is small where friction is as
    /// large as it can be, and points against the motion.
    pub missing_friction: T,
    /// Speed of a joint row against its law (rad/s, m/s): into a stop, against a bound, or any speed of a row that holds.
    pub row_speed: T,
    /// Impulse of a joint row against its law (N·m·s, N·s): its distance from the bound at which its speed puts it, or that of a stop which
    /// pushes what leaves it (as [`Self::opening_impulse`]). The impulse of a row always lies within its bounds.
    pub row_impulse: T,
}

/// The outcome of a solve: velocity, impulses, modes, status and error.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "T: Real + serde::Serialize",
        deserialize = "T: Real + serde::Deserialize<'de>"
    ))
)]
pub struct Solution<T: Real, const N: usize, const D: usize, const C: usize, const R: usize = 0> {
    /// Generalised velocity `v` at the end of the step (`N` entries, in the units of the scene); 0 behind the velocities of the scene
    /// ([`crate::Scene::set_velocities`]).
    pub velocity: SVector<T, N>,
    /// The contacts, in the order of the scene.
    pub contacts: Vec<ContactSolution<T, D>, C>,
    /// The joint rows, in the order of the scene, and after them the reached limits of [`crate::Kernel::solve_with_limits`].
    pub rows: Vec<RowSolution<T>, R>,
    /// How the solve ended.
    pub status: Status,
    /// The contact law that was solved.
    pub model: Model,
    /// Fingerprint of the scene of the solve.
    pub(crate) data: u64,
    /// Proof of [`Status::Infeasible`] or [`Status::Jammed`], otherwise empty: a vector `d_i` for each contact, in its friction cone and
    /// normal first. With the numbers `d_j` of [`Self::row_certificate`] it satisfies `Σ H_iᵀ d_i + Σ d_j row_jᵀ = 0` and
    /// `Σ w_i · d_i + Σ d_j offset_j < 0` (Farkas' lemma). The tangents of an infeasible scene are zero.
    pub certificate: Vec<SVector<T, D>, C>,
    /// The numbers `d_j` of the proof, one for each joint row: not negative for limits, of either sign for equalities, 0 for other rows.
    pub row_certificate: Vec<T, R>,
    /// Work of the solve, over all its calls.
    pub work: Work,
    /// Error of the solution (dimensionless): its violation of Coulomb's law and of the dynamics, relative to the impulses, with a bound on
    /// rounding ([`crate::guide::error`]). Before the first call it is 0, because a new solver is all zeros; later it is infinite while the
    /// status is [`Status::Unsolved`]. Ask [`Self::is_usable`], which is false in both cases.
    pub error: T,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize> Solution<T, N, D, C, R> {
    /// The first contact with this key, if there is one.
    #[must_use]
    pub fn contact_by_key(&self, key: u32) -> Option<&ContactSolution<T, D>> {
        self.contacts.iter().find(|contact| contact.key == key)
    }

    /// The first joint row with this key. There is none for a limit of [`crate::Kernel::solve_with_limits`] that is not reached.
    #[must_use]
    pub fn row_by_key(&self, key: u32) -> Option<&RowSolution<T>> {
        self.rows.iter().find(|row| row.key == key)
    }

    /// True if the error is at most the tolerance of the solve ([`Status::Solved`]).
    #[must_use]
    pub fn is_solved(&self) -> bool {
        self.status == Status::Solved
    }

    /// True if the scene is solved, or if the budget, the precision or the room for limits ended the solve at an error of at most `error`
    /// (dimensionless).
    ///
    /// It is false for [`Status::Infeasible`] and [`Status::Jammed`]: contradictory walls make impulses large, and so the error small.
    /// For the same reason it bounds no force of [`Model::ConvexRelaxation`]: large internal forces hide in their own error
    /// ([`crate::guide::forces`]).
    #[must_use]
    pub fn is_usable(&self, error: T) -> bool {
        match self.status {
            Status::Solved => true,
            Status::OutOfBudget | Status::PrecisionLimit | Status::OutOfRows => self.error <= error,
            Status::Infeasible | Status::Jammed | Status::Unsolved => false,
        }
    }

    /// Are velocity, contacts and joint rows finite?
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn has_numbers(&self) -> bool {
        let mut sum = T::ZERO;
        for &v in &self.velocity {
            sum += v;
        }
        for contact in &self.contacts {
            for (&impulse, &velocity) in contact.impulse.iter().zip(&contact.velocity) {
                sum += impulse + velocity;
            }
        }
        for row in &self.rows {
            sum += row.impulse + row.velocity;
        }
        sum.is_finite()
    }

    /// Marks it as unsolved, with an infinite error.
    pub(crate) fn invalidate(&mut self) {
        (self.status, self.error) = (Status::Unsolved, T::INFINITY);
    }

    /// Makes the solution empty, in place.
    pub(crate) fn empty(&mut self) {
        self.velocity.fill(T::ZERO);
        self.contacts.clear();
        self.rows.clear();
        self.certificate.clear();
        self.row_certificate.clear();
        self.work = Work::none();
        self.invalidate();
    }

    /// Makes the error infinite if nothing was solved yet: a new solver has 0 there.
    pub(crate) fn invalidate_if_unsolved(&mut self) {
        if self.status == Status::Unsolved {
            self.error = T::INFINITY;
        }
    }

    /// The solution before any solve.
    pub(crate) const fn none() -> Self {
        Self {
            velocity: zeros(),
            contacts: Vec::new(),
            status: Status::Unsolved,
            model: Model::Coulomb,
            data: 0,
            certificate: Vec::new(),
            row_certificate: Vec::new(),
            rows: Vec::new(),
            work: Work::none(),
            error: T::ZERO,
        }
    }
}
