//! Coulomb friction with unilateral contact, for control loops on microcontrollers.
//!
//! In each tick you give a mass matrix `M`, a free impulse `M v_free` (momentum without contacts), and for each contact a Jacobian `H_i`,
//! an offset `w_i` and a friction coefficient `mu_i`. A [`Kernel`] finds the velocity `v` at the end of the tick and the contact
//! impulses `r_i` with
//!
//! `M v = M v_free + Hᵀ r`, `u_i = H_i v + w_i`, `K*_mu ∋ u_i + mu_i |u_Ti| e_N ⟂ r_i ∈ K_mu`
//!
//! and says which contacts stick, which slip and which let go. The last formula is Coulomb's law: `K_mu` is the friction cone,
//! `K*_mu` its dual, `u_T` the tangential part of `u`, `e_N` the unit normal. Joint limits, dry friction, motors, loops and compliance are
//! solved together with the contacts ([`guide::rows`]). Nothing allocates and nothing panics.
//!
//! All sizes are known at compile time: `N` velocities, up to `C` contacts of `D` rows each (1 frictionless, 2 planar, 3 spatial, 4 with
//! spin, 6 with rolling) and up to `R` joint rows (0 by default).
//!
//! ```
//! use nalgebra::{Matrix3, matrix, vector};
//! use stiction::{Contact, ContactMode, Kernel, Settings, Status};
//!
//! // A 2 kg point mass on the floor, pushed sideways for 1 ms with 30 N: more than mu m g holds.
//! let mut kernel = Kernel::<f32, 3, 3, 1>::new(); // `const`, for a `static`
//! let scene = kernel.scene_mut();
//! scene.set_mass(&(Matrix3::identity() * 2.0))?;
//! scene.push(&Contact {
//!     jacobian: matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0], // normal row first
//!     offset: vector![0.0, 0.0, 0.0],
//!     mu: 0.8,
//!     key: 0, // which contact it is, for a warm start
//! })?;
//!
//! let push = vector![30.0e-3, 0.0, -2.0 * 9.81e-3]; // the free impulse, N·s
//! let solution = kernel.solve(&push, &Settings::new(1e-5))?;
//!
//! assert_eq!(solution.status, Status::Solved);
//! assert_eq!(solution.contacts[0].mode, ContactMode::Slip);
//! # Ok::<(), stiction::Error>(())
//! ```
//!
//! # Where to go
//!
//! [`guide`] is the manual: [a first robot](guide::first_robot), [contacts and rows](guide::rows), [a tick that fits](guide::tick),
//! [the method](guide::method), [the error](guide::error), [all reports](guide::reports).
//!
//! A [`Kernel`] is all that a control loop needs. In it, data flows from a [`Scene`] (checked as it is filled) to a [`Factor`] (everything that
//! depends on `M` and `H` alone) to a [`Solver`] (what a warm start needs) to a [`Solution`] with a [`Status`] and an error. Take the parts by
//! themselves where one factor serves several solvers.
//!
//! | folder or file | content | in the note |
//! |---|---|---|
//! | `cone` | `K`, `K*`, projections | Eqs. (1), (2), (6), (8)-(10) |
//! | `admm` | one iteration: plain, Algorithm 1, Algorithm 2; a solver of its own | steps 2-15 |
//! | `scene` | contacts, joint rows and surfaces | |
//! | `factor` | Cholesky factor of `M`, Delassus operator `W = H M⁻¹ Hᵀ` (contact impulses to contact velocities), for ADMM the resolvent `(I + rho W)⁻¹` | step 2 |
//! | `sets` | cones of contacts and intervals of joint rows. **Coulomb's law**: `contact/natural_map` checks it, `contact/coulomb_sweep` solves it, `ContactSet::augmented` adds the De Saxcé shift. **A row's bounds**: `RowLaw::bounds`, `RowSet::project`. **A third kind of set**: the table in `sets/mod.rs` | |
//! | `problem` | one time step in contact space. `judge`: the error and its bound on rounding. `infeasibility`: proofs that there is no solution | |
//! | `solver` | [`Solver`]: **`method` decides what comes next**, also after a rejected step; sweeps, Newton, central path, warm start; `phases` can be left out | |
//! | `solution`, `error` | solution, status, settings and budget; errors | |
//! | `derivative` | derivatives of a solution, forward and adjoint ([`guide::derivatives`]) | |
//! | `loads` | least impulses, and how near to slipping a solution is ([`guide::loads`]) | |
//! | `kernel` | scene, factor and solver in one value; joint limits by demand; the time of a call | |
//! | `linalg` | small dense linear algebra | |
//! | [`time_stepping`] | free impulse, gaps, restitution, joint limits, motors | |
//!
//! "The note" is Y. Kanno, *Accelerated Alternating Direction Method of Multipliers for Frictional Contact*; [`guide::note`] says how to
//! cite it and which misprints are corrected here.
//!
//! # Features
//!
//! All are off by default, and none needs `std`.
//!
//! | feature | what it adds |
//! |---|---|
//! | `defmt` | `defmt::Format` for settings, solutions, statuses and errors, contacts and joint rows |
//! | `hardware-sqrt` | square roots of `f32` by the instruction of a core that has one, by the target: Arm with `eabihf` (Cortex-M4F, M7, M33), RISC-V with `f`, `d` or `g` in its name (`riscv32imafc`); elsewhere `libm` stays. 7 to 10 % fewer instructions of a solve, the same bits. The instruction is in a crate of its own, `stiction-sqrt`, for this one forbids `unsafe` |
//! | `serde` | `Serialize` and `Deserialize` for settings, solutions, statuses and errors, and for contacts and joint rows, which a scene checks as they come in; scenes and factors are not read |
//!
//! # Panics
//!
//! None. A scene checks its data and refuses it with an [`Error`] that names the culprit. The code indexes by constants alone, which the
//! compiler checks, and has no `unwrap` and no integer division that could fail. `examples/panic_free` calls all public functions that
//! compute, and links only if none of them reaches a panic.
#![no_std]
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
mod loads;
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
pub use kernel::{ContactOf, FreeImpulseOf, JointRowOf, Kernel, Parts, SceneOf, SolutionOf};
pub use loads::LeastImpulses;
pub use real::Real;
pub use scene::{Contact, JointRow, RowLaw, Scene, Surface, contact_frame};
pub use solution::{
    ContactMode, ContactSolution, Model, RowMode, RowSolution, Settings, Solution, Status, Violation, Work,
};
pub use solver::warm_start::WarmStart;
pub use solver::{AllPhases, Phases, Solver, SweepsAndNewton, SweepsOnly};

pub use heapless;
pub use nalgebra;

/// The README's code compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
