//! Which phases a solver has: a choice by type, so that what a program leaves out is not linked.

use core::fmt::Debug;

/// The phases that a [`crate::Solver`] may go through.
///
/// [`AllPhases`] by default. The others are for programs that count bytes of flash: what they leave out is not linked, and what they solve
/// is solved to the same promise. [`crate::guide::reports::firmware`] says what each of them takes, and which share of scenes it solves.
///
/// ```
/// use nalgebra::{Matrix2, matrix, vector};
/// use stiction::{Contact, Kernel, Settings, SweepsOnly};
///
/// let mut kernel = Kernel::<f32, 2, 2, 1, 0, 0, SweepsOnly>::with_phases(SweepsOnly); // `const`
/// kernel.scene_mut().set_mass(&(Matrix2::identity() * 2.0))?;
/// kernel.scene_mut().push(&Contact { jacobian: matrix![0.0, 1.0; 1.0, 0.0], offset: vector![0.0, 0.0], mu: 0.5, key: 0 })?;
/// let solution = kernel.solve(&vector![0.3, -0.2], &Settings::default())?;
/// assert!(solution.is_solved() && solution.work.sweeps * 2 == solution.work.total());
/// # Ok::<(), stiction::Error>(())
/// ```
pub trait Phases: Copy + Debug + sealed::Sealed {
    /// Is there Newton's method?
    #[doc(hidden)]
    const NEWTON: bool;
    /// Is there the central path, and the search for a proof that a scene is infeasible?
    #[doc(hidden)]
    const CENTRAL_PATH: bool;
}

/// Sweeps, Newton's method, and where that fails the central path and a proof that a scene is infeasible.
#[derive(Clone, Copy, Debug)]
pub struct AllPhases;

/// Sweeps and Newton's method. Where a Newton step fails, sweeps go on; of an infeasible scene the budget ends.
#[derive(Clone, Copy, Debug)]
pub struct SweepsAndNewton;

/// Sweeps alone, for few contacts with unique impulses and coarse tolerances: they converge linearly at best. An infeasible scene ends
/// its budget. It takes as much RAM as all phases.
#[derive(Clone, Copy, Debug)]
pub struct SweepsOnly;

impl Phases for AllPhases {
    const NEWTON: bool = true;
    const CENTRAL_PATH: bool = true;
}

impl Phases for SweepsAndNewton {
    const NEWTON: bool = true;
    const CENTRAL_PATH: bool = false;
}

impl Phases for SweepsOnly {
    const NEWTON: bool = false;
    const CENTRAL_PATH: bool = false;
}

mod sealed {
    /// There are three choices.
    pub trait Sealed {}
    impl Sealed for super::AllPhases {}
    impl Sealed for super::SweepsAndNewton {}
    impl Sealed for super::SweepsOnly {}
}
