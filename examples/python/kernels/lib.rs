//! Kernels of a table of sizes behind one interface: filled from slices and read into slices.

pub mod derivative;
pub mod engine;
pub mod loads;
pub mod problem;
pub mod room;
pub mod sizes;
