//! What comes out of a solve.

use crate::linalg::vector::zeros;
use crate::real::Real;
use core::fmt;
use heapless::Vec;
use nalgebra::SVector;

mod parts;
mod settings;

pub use parts::{ContactMode, ContactSolution, RowMode, RowSolution};
pub use settings::{Model, Settings, Work};

/// How a solve ended. [`crate::guide::tick`] says what a control loop does with each.
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
    /// No solution was found, and friction locks what is to be pushed apart: [`Solution::certificate`] is the proof. See
    /// [`crate::guide::error`] for what it proves.
    Jammed = 5,
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
        })
    }
}

/// The worst violation of a contact's and of a joint row's law, see [`Solution::violation`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Violation<T> {
    /// The largest speed at which a contact that is closed closes further (m/s): the largest `-u_N`.
    pub closing_speed: T,
    /// How far an impulse lies outside of its friction cone (N·s): the largest `|r_T| - mu r_N`, or `-r_N`. On a surface in
    /// the rows in which its cone is round.
    pub outside_cone: T,
    /// The largest speed at which a joint row goes where it must not (rad/s, m/s): a stop or a bound gives way, or what holds moves. Its
    /// impulse always lies within its bounds.
    pub row_speed: T,
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
pub struct Solution<T: Real, const N: usize, const D: usize, const C: usize, const R: usize = 0> {
    /// Generalised velocity `v` at the end of the step.
    pub velocity: SVector<T, N>,
    /// The contacts, in the order of the scene.
    pub contacts: Vec<ContactSolution<T, D>, C>,
    /// The joint rows, in the order of the scene; behind them limits that were reached
    /// ([`crate::Kernel::solve_with_limits`]).
    pub rows: Vec<RowSolution<T>, R>,
    /// How the solve ended.
    pub status: Status,
    /// Proof of [`Status::Infeasible`] or [`Status::Jammed`], otherwise empty: for each contact a `d_i` in its friction cone,
    /// normal first, and in [`Self::row_certificate`] one `d_j` a joint row, with `Σ H_iᵀ d_i + Σ d_j row_jᵀ = 0` and
    /// `Σ w_i · d_i + Σ d_j offset_j < 0` (Farkas' lemma). Of an infeasible scene all tangents are zero.
    pub certificate: Vec<SVector<T, D>, C>,
    /// The joint rows' part of the proof: not negative of limits, of any sign of equalities, 0 of others.
    pub row_certificate: Vec<T, R>,
    /// Work of the solve, over all its calls.
    pub work: Work,
    /// How far the solution is from Coulomb's law and the dynamics, relative to the impulses (dimensionless), with a
    /// bound on rounding: see [`crate::guide::error`]. Infinite while the status is [`Status::Unsolved`]; only a solver that
    /// was never called has 0 (so that its `static` is all zeros): ask [`Self::is_usable`].
    pub error: T,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>
    Solution<T, N, D, C, R>
{
    /// The first contact with this key.
    #[must_use]
    pub fn contact_by_key(&self, key: u32) -> Option<&ContactSolution<T, D>> {
        self.contacts.iter().find(|contact| contact.key == key)
    }

    /// The first joint row with this key; `None` of a limit that [`crate::Kernel::solve_with_limits`] has left out.
    #[must_use]
    pub fn row_by_key(&self, key: u32) -> Option<&RowSolution<T>> {
        self.rows.iter().find(|row| row.key == key)
    }

    /// True if the error is at most the tolerance of the solve ([`Status::Solved`]).
    #[must_use]
    pub fn is_solved(&self) -> bool {
        self.status == Status::Solved
    }

    /// True if solved, or ended by the budget or the number type at an error of at most `error` (dimensionless).
    ///
    /// Never true for [`Status::Infeasible`] and [`Status::Jammed`]: contradictory walls make impulses grow, and an error relative to them small.
    #[must_use]
    pub fn is_usable(&self, error: T) -> bool {
        match self.status {
            Status::Solved => true,
            Status::OutOfBudget | Status::PrecisionLimit => self.error <= error,
            Status::Infeasible | Status::Jammed | Status::Unsolved => false,
        }
    }

    /// Is all of it finite?
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

    /// Claims nothing any more.
    pub(crate) fn disown(&mut self) {
        (self.status, self.error) = (Status::Unsolved, T::INFINITY);
    }

    /// Claims nothing if nothing was solved yet: the zeros of a new solver are no exact solution.
    pub(crate) fn disown_nothing(&mut self) {
        if self.status == Status::Unsolved {
            self.error = T::INFINITY;
        }
    }

    /// The solution of nothing.
    pub(crate) const fn none() -> Self {
        Self {
            velocity: zeros(),
            contacts: Vec::new(),
            status: Status::Unsolved,
            certificate: Vec::new(),
            row_certificate: Vec::new(),
            rows: Vec::new(),
            work: Work::none(),
            error: T::ZERO,
        }
    }
}
