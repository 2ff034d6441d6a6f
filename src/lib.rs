//! Coulomb friction with unilateral contact, for microcontrollers.
//!
//! A scene has `N` generalised velocities, up to `C` contacts of `D` rows each (1 frictionless,
//! 2 planar, 3 spatial, 4 with a torsional row, 6 with rolling ones) and up to `R` joint rows (0 by default). For a mass matrix `M`, a free impulse
//! `M v_free`, contact Jacobians `H_i`, offsets `w_i` and friction coefficients `mu_i` the
//! kernel finds the velocity `v` and the contact impulses `r_i` with
//!
//! `M v = M v_free + Hᵀ r`, `u_i = H_i v + w_i`, `K*_mu ∋ u_i + mu_i |u_Ti| e_N ⟂ r_i ∈ K_mu`
//!
//! and tells which contacts stick, which slip and which let go; joint limits, dry friction, motors, loops and
//! compliance are solved with them ([`guide::rows`]). All sizes are known at compile
//! time; nothing allocates and nothing panics.
//!
//! ```
//! use nalgebra::{Matrix3, matrix, vector};
//! use stiction::{Contact, ContactMode, Factor, Scene, Settings, Solver, Status};
//!
//! // A 2 kg point mass on the floor, pushed sideways for 1 ms with 30 N: more than mu m g holds.
//! let mut scene = Scene::<f32, 3, 3, 1>::new();
//! scene.set_mass(&(Matrix3::identity() * 2.0))?;
//! scene.push(&Contact {
//!     jacobian: matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0], // normal row first
//!     offset: vector![0.0, 0.0, 0.0],
//!     mu: 0.8,
//!     key: 0, // which contact it is, for a warm start
//! })?;
//! let factor = Factor::new(&scene)?; // all that depends on M and H
//! let mut solver = Solver::new(); // keeps what a warm start needs
//!
//! let push = vector![30.0e-3, 0.0, -2.0 * 9.81e-3]; // the free impulse, N·s
//! let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-5))?;
//!
//! assert_eq!(solution.status, Status::Solved);
//! assert_eq!(solution.contacts[0].mode, ContactMode::Slip);
//! # Ok::<(), stiction::Error>(())
//! ```
//!
//! # Data flow
//!
//! [`Kernel`] holds all of it in one value: [`Scene`] (checked as it is filled) → [`Factor`] (all that depends on `M` and `H`; read-only)
//! → [`Solver`] (the one mutable thing) → [`Solution`] with its [`Status`] and its error.
//!
//! | folder or file | idea | in the note |
//! |---|---|---|
//! | `cone` | `K`, `K*`, projections | Eqs. (1), (2), (6), (8)-(10) |
//! | `admm` | one iteration: plain, Algorithm 1, Algorithm 2; a solver of its own | steps 2-15 |
//! | `scene` | contacts, joint rows and surfaces, checked where they come in | |
//! | `factor` | Cholesky factor of `M`, Delassus operator `W`, for ADMM the resolvent `(I + rho W)⁻¹`: computed once | step 2 |
//! | `sets` | what a solve asks of a contact (a cone) and of a joint row (an interval). **Coulomb's law**: `contact/natural_map` checks it, `contact/coulomb_sweep` solves it, `ContactSet::augmented` is its shift; a row's bounds: `RowSet::project` | |
//! | `problem` | one time step in contact space; the judge of the error that "solved" promises; Farkas' proof that there is nothing to solve | |
//! | `solver` | [`Solver`]: **`method` decides what comes next**; sweeps, Newton, central path, warm start; `phases` are what a type may leave out | |
//! | `solution`, `error` | what comes out, what can be wrong | |
//! | `derivative` | how a solution moves with its data, forward and adjoint ([`guide::derivatives`]) | |
//! | `kernel` | scene, factor and solver in one value; limits that stay out until they are reached | |
//! | `linalg` | small dense linear algebra | |
//! | [`time_stepping`] | free impulse, gaps, restitution, limits, motors | |
//!
//! [`guide`] explains the method, the error and the measurements.
//!
//! "The note" is Y. Kanno, *Accelerated Alternating Direction Method of Multipliers for Frictional
//! Contact*; [`guide::note`] says how to cite it and which misprints are corrected here.
//!
//! # Features
//!
//! All are off by default, and none needs `std`.
//!
//! | feature | what it adds |
//! |---|---|
//! | `defmt` | `defmt::Format` for settings, solutions, statuses and errors, contacts and joint rows |
//! | `serde` | `Serialize` and `Deserialize` for settings, solutions, statuses and errors, and for contacts and joint rows, which a scene checks as they come in; scenes and factors are not read |
//!
//! # Panics
//!
//! None. Data is checked where it enters and refused with an [`Error`] that names the culprit. The
//! code has no indexing but by constants that the compiler checks, no `unwrap` and no integer division that could fail. `examples/panic_free`
//! proves it by linking, see "On a microcontroller" in [`guide::numbers`].
#![no_std]
#![cfg_attr(stiction_core_sqrt, feature(core_float_math))]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![deny(
    clippy::indexing_slicing,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::integer_division
)]

#[cfg(stiction_tuning)]
extern crate std;

mod admm;
mod cone;
#[cfg(feature = "defmt")]
mod defmt_format;
mod derivative;
mod error;
mod factor;
pub mod guide;
mod kernel;
mod linalg;
mod parameter;
mod problem;
mod real;
mod scene;
mod sets;
mod solution;
mod solver;
pub mod time_stepping;

pub use admm::{Acceleration, AdmmSolver, SlipUpdate};
pub use cone::FrictionCone;
pub use derivative::{Derivative, Inputs, Outputs};
pub use error::{Error, Input, List, Part};
pub use factor::{AdmmFactor, Factor};
pub use kernel::Kernel;
pub use real::Real;
pub use scene::{Contact, JointRow, RowLaw, Scene, Surface, contact_frame};
pub use solution::{
    ContactMode, ContactSolution, Model, RowMode, RowSolution, Settings, Solution, Status,
    Violation, Work,
};
pub use solver::{AllPhases, Phases, Solver, SweepsAndNewton, SweepsOnly};

pub use heapless;
pub use nalgebra;

/// The README's code compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
