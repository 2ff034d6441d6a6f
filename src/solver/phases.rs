//! The phases of a solver, chosen by type: a phase that is left out is not linked.

use core::fmt::Debug;

/// The phases that a [`crate::Solver`] may go through.
///
/// The default is [`AllPhases`]. The other two save flash: a phase that is left out is not linked. A solution that they call solved keeps
/// the same promise. [`crate::guide::reports::firmware`] lists the flash of each choice and the share of scenes that it solves.
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
    /// Is an error that exceeds the tolerance computed again with twice the digits?
    #[doc(hidden)]
    const EXACT_ERRORS: bool;
}

/// All phases: sweeps, Newton's method, the central path where Newton's method fails, and proofs that a scene is infeasible.
#[derive(Clone, Copy, Debug)]
pub struct AllPhases;

/// Sweeps and Newton's method. If a Newton step is rejected, sweeps follow. An infeasible scene uses up its budget.
#[derive(Clone, Copy, Debug)]
pub struct SweepsAndNewton;

/// Sweeps alone, for few contacts with unique impulses, coarse tolerances and short deadlines: they converge linearly at best. An infeasible
/// scene uses up its budget. No error is computed with twice the digits, so in `f32` a tolerance below 1e-5 is out of reach. The solver takes
/// as much RAM as one of all phases.
#[derive(Clone, Copy, Debug)]
pub struct SweepsOnly;

impl Phases for AllPhases {
    const NEWTON: bool = true;
    const CENTRAL_PATH: bool = true;
    const EXACT_ERRORS: bool = true;
}

impl Phases for SweepsAndNewton {
    const NEWTON: bool = true;
    const CENTRAL_PATH: bool = false;
    const EXACT_ERRORS: bool = true;
}

impl Phases for SweepsOnly {
    const NEWTON: bool = false;
    const CENTRAL_PATH: bool = false;
    const EXACT_ERRORS: bool = false;
}

mod sealed {
    /// No other crate can add a choice of phases.
    pub trait Sealed {}
    impl Sealed for super::AllPhases {}
    impl Sealed for super::SweepsAndNewton {}
    impl Sealed for super::SweepsOnly {}
}
