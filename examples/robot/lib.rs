//! Robots from URDF files among contacts: what all programs of this folder share.
//!
//! | file | what it does | with |
//! |---|---|---|
//! | `world` | **[`World::step`]: one time step**, and [`World::run`] for many | stiction |
//! | `rows` | contacts, motors, stops, joints that mimic each other | stiction |
//! | `urdf`, `tree`, `shapes` | links, joints, shapes and meshes of a file | `urdf-rs`, `mesh-loader`, `parry3d` |
//! | `dynamics` | `M`, bias forces, Jacobians | `dynibo` |
//! | `collide` | points at which bodies are near each other | `parry3d` |
//! | `draw`, `report` | filmstrip, plots, costs | `plotters` |
#![allow(clippy::missing_errors_doc)] // all say what went wrong

mod collide;
mod draw;
mod dynamics;
#[cfg(test)]
mod firmware_tests;
mod report;
mod rows;
mod shapes;
#[cfg(test)]
mod tests;
mod tree;
mod urdf;
#[cfg(test)]
mod urdf_tests;
mod world;

pub use collide::Body;
pub use draw::{Curve, Film};
pub use report::report;
pub use tree::{Base, GRAVITY, Joint, Tree};
pub use world::{STEP, Tick, Touch, World};

/// What went wrong, in words.
pub type Failure = Box<dyn std::error::Error>;

/// The README's code compiles.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
