//! Coulomb friction for microcontrollers.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod admm;
mod admm_solver;
mod cholesky;
mod cone;
mod contact_space;
mod error;
mod factor;
mod infeasibility;
mod newton;
mod problem;
mod real;
mod residual;
mod resolvent;
mod scene;
mod search;
mod solution;
mod solver;
mod state;

pub use admm_solver::AdmmSolver;
pub use cone::{FrictionCone, Spectral};
pub use error::{Error, Input};
pub use factor::Factor;
pub use real::Real;
pub use scene::{Contact, Scene};
pub use solution::{ContactMode, ContactSolution, Settings, SlipUpdate, Solution, Status};
pub use solver::Solver;
