//! Coulomb friction for microcontrollers.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod admm;
mod cholesky;
mod cone;
mod error;
mod factor;
mod problem;
mod real;
mod residual;
mod scene;
mod solver;

pub use cone::{FrictionCone, Spectral};
pub use error::{Error, Input};
pub use factor::Factor;
pub use real::Real;
pub use scene::{Contact, Scene};
pub use solver::{ContactMode, ContactSolution, Settings, SlipUpdate, Solution, Solver, Status};
