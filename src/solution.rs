//! Settings of a solve, and its solution.

use crate::Real;
use crate::laws::{Coulomb, Laws, Room};
use core::fmt;
use heapless::Vec;
use nalgebra::{ArrayStorage, SVector};

mod rows;

pub(crate) use rows::SlotSolution;

/// The contact law that is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Model {
    /// Coulomb's law, with the De Saxcé shift `mu |u_T|` (default).
    Coulomb,
    /// Its convex relaxation, without the shift: a sliding contact separates with normal speed `mu |u_T|`. `error` then
    /// measures the relaxed law. [`crate::guide::forces`] shares out forces with it; an example stands at [`Settings`].
    ConvexRelaxation,
}

/// How exactly and how long to solve, and which law.
///
/// ```
/// use stiction::{Model, Settings};
///
/// let tick = Settings { budget: 100, ..Settings::new(1e-4) }; // Coulomb's law
/// let relaxed = Settings { model: Model::ConvexRelaxation, ..tick };
/// assert_eq!(Settings::<f32>::default().budget, 1_000);
/// # assert_eq!(relaxed.tolerance, 1e-4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings<T> {
    /// Error up to which a solution counts as solved (dimensionless, not negative), see [`Solution::error`].
    pub tolerance: T,
    /// Work that one call may do, in units of [`Work::total`]. A call may exceed it by 27. [`crate::guide::error`] says
    /// how to choose it from the time of a tick, and how to continue in the next one.
    pub budget: usize,
    /// The contact law that is solved.
    pub model: Model,
}

impl<T> Settings<T> {
    /// Settings for Coulomb's law with a budget of 1,000, enough for 99.5 % of random scenes, most of which were made to be
    /// hard (see [`crate::guide::numbers`]).
    pub const fn new(tolerance: T) -> Self {
        Self {
            tolerance,
            budget: 1_000,
            model: Model::Coulomb,
        }
    }
}

impl<T: Real> Default for Settings<T> {
    /// Tolerance 1e-4, which `f32` reaches as well.
    fn default() -> Self {
        Self::new(T::literal(1e-4))
    }
}

/// How a solve ended. [`crate::guide::error`] says what a control loop does with each.
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
    /// Nothing was solved yet.
    Unsolved = 0, // so that a new solver is all zeros, and takes no flash
    /// The error is at most the tolerance.
    Solved = 1,
    /// The budget of the call was used up. The solution is the best so far: [`Solution::is_usable`] compares its error with
    /// one that you accept, and [`crate::Solver::resume`] continues.
    OutOfBudget = 4,
    /// The error is above the tolerance but near what rounding in this number type allows, and no longer falls.
    PrecisionLimit = 2,
    /// No velocity satisfies all contacts and joint rows; [`Solution::certificate`] is the proof.
    Infeasible = 3,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unsolved => "nothing was solved yet",
            Self::Solved => "solved",
            Self::OutOfBudget => "out of budget",
            Self::PrecisionLimit => "at the limit of the number type",
            Self::Infeasible => "infeasible",
        })
    }
}

/// The work of a solve, by kind.
///
/// ```
/// use stiction::Work;
///
/// let work = Work { sweeps: 3, newton_steps: 1, ..Work::default() };
/// assert_eq!(work.total(), 16); // of `Settings::budget`
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Work {
    /// Iterations of ADMM.
    pub iterations: usize,
    /// Gauss-Seidel sweeps.
    pub sweeps: usize,
    /// Newton steps with a Jacobian that was kept.
    pub chord_steps: usize,
    /// Newton steps with a new Jacobian, and steps of the interior point.
    pub newton_steps: usize,
    /// Searches for a proof that a scene is infeasible, at most one in a solve.
    pub proof_searches: usize,
}

impl Work {
    /// None.
    pub(crate) const fn none() -> Self {
        Self {
            iterations: 0,
            sweeps: 0,
            chord_steps: 0,
            newton_steps: 0,
            proof_searches: 0,
        }
    }

    /// Its sum, in iterations of ADMM: a sweep and a chord step count 2; a Newton step, a step of the interior point and a
    /// search for a proof count 10.
    #[must_use]
    pub const fn total(&self) -> usize {
        let factorisations = self.newton_steps + self.proof_searches;
        self.iterations + 2 * (self.sweeps + self.chord_steps) + 10 * factorisations
    }
}

/// What a contact does.
///
/// No tolerance decides it. A contact without impulse is open. One whose `r_i - alpha_i û_i` lies strictly inside the
/// friction cone sticks, also if a velocity of the size of the error is left. Every other one slips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactMode {
    /// No impulse, exactly zero.
    Open,
    /// An impulse inside the friction cone, no relative velocity up to the error (on a [`crate::Surface`] along the rows that
    /// have friction).
    Stick,
    /// An impulse on the boundary of the friction cone, up to the error.
    Slip,
}

/// One contact of a [`Solution`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "T: Real + serde::Serialize",
        deserialize = "T: Real + serde::Deserialize<'de>"
    ))
)]
pub struct ContactSolution<T, const D: usize> {
    /// Which contact it is: the [`crate::Contact::key`] that it had in the scene.
    pub key: u32,
    /// Contact impulse `r_i` (N·s), normal first.
    pub impulse: SVector<T, D>,
    /// Relative velocity `u_i = H_i v + w_i` (m/s), normal first.
    pub velocity: SVector<T, D>,
    /// Open, stick or slip.
    pub mode: ContactMode,
}

/// The outcome of a solve.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "T: Real + serde::Serialize",
        deserialize = "T: Real + serde::Deserialize<'de>"
    ))
)]
pub struct Solution<T: Real, const N: usize, const D: usize, const C: usize, L: Laws = Coulomb> {
    /// Generalised velocity `v` at the end of the step.
    pub velocity: SVector<T, N>,
    /// The contacts, in the order of the scene. (A slot of joint rows stands among them with the key [`u32::MAX`]:
    /// [`Self::row`] tells what they do.)
    pub contacts: Vec<ContactSolution<T, D>, C>,
    /// How the solve ended.
    pub status: Status,
    /// Proof of [`Status::Infeasible`], otherwise empty: one `d_i >= 0` a contact with
    /// `Σ d_i H_Niᵀ = 0` and `Σ d_i w_Ni < 0` (Farkas' lemma). Joint rows count in both sums, with
    /// [`crate::RowSolution::certificate`].
    pub certificate: Vec<T, C>,
    /// What joint rows do, and their part of the proof.
    #[cfg_attr(feature = "serde", serde(skip, default = "no_rows::<T, D, C, L>"))]
    pub(crate) rows: [L::Room<SlotSolution<T, D>>; C],
    /// Work of the solve, over all its calls.
    pub work: Work,
    /// How far the solution is from Coulomb's law and the dynamics, relative to the impulses (dimensionless), with a
    /// bound on rounding: see [`crate::guide::error`]. No meaning while the status is [`Status::Unsolved`].
    pub error: T,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Solution<T, N, D, C, L> {
    /// True if the error is at most the tolerance of the solve ([`Status::Solved`]).
    #[must_use]
    pub fn is_solved(&self) -> bool {
        self.status == Status::Solved
    }

    /// True if solved, or ended by the budget or the number type at an error of at most `error` (dimensionless).
    ///
    /// Never true for [`Status::Infeasible`]: contradictory walls make impulses grow, and an error relative to them small.
    #[must_use]
    pub fn is_usable(&self, error: T) -> bool {
        match self.status {
            Status::Solved => true,
            Status::OutOfBudget | Status::PrecisionLimit => self.error <= error,
            Status::Infeasible | Status::Unsolved => false,
        }
    }

    /// Is all of it finite?
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn has_numbers(&self) -> bool {
        let contacts = self
            .contacts
            .iter()
            .map(|c| c.impulse.sum() + c.velocity.sum());
        contacts.fold(self.velocity.sum(), T::add).is_finite()
    }

    /// The solution of nothing.
    pub(crate) const fn none() -> Self {
        Self {
            velocity: zeros(),
            contacts: Vec::new(),
            status: Status::Unsolved,
            certificate: Vec::new(),
            rows: [const { L::Room::EMPTY }; C],
            work: Work::none(),
            error: T::ZERO,
        }
    }
}

/// No joint rows.
#[cfg(feature = "serde")]
fn no_rows<T: Real, const D: usize, const C: usize, L: Laws>() -> [L::Room<SlotSolution<T, D>>; C] {
    [const { L::Room::EMPTY }; C]
}

/// A vector of zeros in a constant.
pub(crate) const fn zeros<T: Real, const K: usize>() -> SVector<T, K> {
    SVector::from_array_storage(ArrayStorage([[T::ZERO; K]; 1]))
}
