//! The kernel behind a C interface; `stiction.h` beside this file is its header and says what each call does.
//!
//! The one place where pointers come in: each function turns them into references, or says that one is null, and goes on
//! without `unsafe`. Sizes are those of `stiction_sizes.h`.
//!
//! # Safety
//! Of all functions: a pointer is null, or points to what the header declares, which nothing else uses meanwhile.
#![cfg_attr(target_os = "none", no_std)]
#![allow(clippy::missing_safety_doc)] // it is above

mod header;
mod solver;
mod status;

use core::ffi::{CStr, c_char};
use header::{SIZES, is, number, size};
pub use solver::{BYTES, ContactOutcome, Kernel, Solution, Solver};
pub use status::{Culprit, Mode, Source, Status, turned};
use stiction::Contact;
use stiction::nalgebra::{SMatrix, SVector};

/// Generalised velocities.
pub const N: usize = size("STICTION_N");
/// Rows of a contact.
pub const D: usize = size("STICTION_D");
/// Most contacts.
pub const C: usize = size("STICTION_C");

/// The number type.
pub type Real = <Bits<{ is(SIZES, "STICTION_REAL", "double") }> as Number>::Type;

const _: () = assert!(
    is(SIZES, "STICTION_REAL", "double") || is(SIZES, "STICTION_REAL", "float"),
    "STICTION_REAL is float or double"
);
const _: () = assert!(number(header::CALLS, "STICTION_OK") == Status::Solved as i32);

/// The number type by name: is it `double`?
pub struct Bits<const DOUBLE: bool>;

/// What stands behind [`Bits`].
pub trait Number {
    /// The number type.
    type Type: stiction::Real;
}

impl Number for Bits<false> {
    type Type = f32;
}

impl Number for Bits<true> {
    type Type = f64;
}

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        safe fn abort() -> !;
    }
    abort() // never: stiction does not panic, but the language wants a handler
}

/// A reference to what stands behind a pointer, all its rows, or the status that says why there is none.
macro_rules! given {
    ($pointer:expr, $Type:ty) => {
        // SAFETY: the caller's promise.
        match unsafe { $pointer.cast::<$Type>().as_ref() } {
            Some(reference) => reference,
            None => return Status::Null,
        }
    };
}

/// The solver behind a pointer, or the status that says why there is none.
macro_rules! solver {
    ($pointer:expr) => {
        // SAFETY: the caller's promise, and `stiction_init` was called.
        match unsafe { Solver::check($pointer) } {
            Ok(()) => unsafe { &mut *$pointer },
            Err(status) => return status,
        }
    };
}

/// The same of a `const stiction *`.
macro_rules! shared {
    ($pointer:expr) => {
        // SAFETY: the caller's promise, and `stiction_init` was called.
        match unsafe { Solver::check($pointer) } {
            Ok(()) => unsafe { &*$pointer },
            Err(status) => return status,
        }
    };
}

/// `stiction_init`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_init(memory: *mut Solver) -> Status {
    if memory.is_null() {
        return Status::Null;
    }
    // SAFETY: the memory is the caller's, large enough and aligned.
    unsafe { Solver::init(memory) };
    Status::Solved
}

/// `stiction_reset`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_reset(memory: *mut Solver) -> Status {
    solver!(memory).kernel.solver_mut().reset();
    Status::Solved
}

/// `stiction_set_mass`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_mass(memory: *mut Solver, mass: *const [Real; N]) -> Status {
    let (solver, mass) = (solver!(memory), given!(mass, SMatrix<Real, N, N>));
    // Its rows for its columns: it is symmetric, and so nothing of this size is copied over the stack.
    solver.change(|scene| scene.set_mass(mass).map_err(turned))
}

/// `stiction_clear_contacts`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_clear_contacts(memory: *mut Solver) -> Status {
    solver!(memory).kernel.scene_mut().clear_contacts();
    Status::Solved
}

/// `stiction_add_contact`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_add_contact(
    memory: *mut Solver,
    jacobian: *const [Real; N],
    offset: *const Real,
    mu: Real,
    key: u32,
) -> Status {
    let (solver, jacobian, offset) = (
        solver!(memory),
        given!(jacobian, [[Real; N]; D]),
        given!(offset, [Real; D]),
    );
    let contact = Contact {
        jacobian: matrix(jacobian),
        offset: SVector::from(*offset),
        mu,
        key,
    };
    solver.change(|scene| scene.push(&contact).map(|_| ()))
}

/// `stiction_set_jacobian`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_jacobian(
    memory: *mut Solver,
    contact: u32,
    jacobian: *const [Real; N],
) -> Status {
    let (solver, jacobian) = (solver!(memory), given!(jacobian, [[Real; N]; D]));
    solver.change(|scene| scene.set_jacobian(index(contact), &matrix(jacobian)))
}

/// `stiction_set_offset`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_offset(
    memory: *mut Solver,
    contact: u32,
    offset: *const Real,
) -> Status {
    let (solver, offset) = (solver!(memory), given!(offset, [Real; D]));
    solver.change(|scene| scene.set_offset(index(contact), &SVector::from(*offset)))
}

/// `stiction_set_friction`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_friction(
    memory: *mut Solver,
    contact: u32,
    mu: Real,
) -> Status {
    solver!(memory).change(|scene| scene.set_friction(index(contact), mu))
}

/// `stiction_solve`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_solve(
    memory: *mut Solver,
    free_impulse: *const Real,
    tolerance: Real,
    budget: u32,
) -> Status {
    let (solver, free_impulse) = (solver!(memory), given!(free_impulse, [Real; N]));
    solver.solve(Kernel::solve, free_impulse, tolerance, index(budget))
}

/// `stiction_resume`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_resume(
    memory: *mut Solver,
    free_impulse: *const Real,
    tolerance: Real,
    budget: u32,
) -> Status {
    let (solver, free_impulse) = (solver!(memory), given!(free_impulse, [Real; N]));
    solver.solve(Kernel::resume, free_impulse, tolerance, index(budget))
}

/// `stiction_is_usable`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_is_usable(memory: *const Solver, error: Real) -> bool {
    // SAFETY: the caller's promise, and `stiction_init` was called.
    unsafe { Solver::check(memory).is_ok() && (*memory).kernel.solution().is_usable(error) }
}

/// `stiction_read`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_read(memory: *const Solver, solution: *mut Solution) -> Status {
    let solver = shared!(memory);
    if solution.is_null() {
        return Status::Null;
    }
    // SAFETY: the caller's promise.
    unsafe { solution.write(Solution::of(solver.kernel.solution())) };
    Status::Solved
}

/// `stiction_last_culprit`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_last_culprit(
    memory: *const Solver,
    culprit: *mut Culprit,
) -> Status {
    let solver = shared!(memory);
    if culprit.is_null() {
        return Status::Null;
    }
    // SAFETY: the caller's promise.
    unsafe { culprit.write(solver.error.map_or(Culprit::NONE, Culprit::from)) };
    Status::Solved
}

/// `stiction_describe`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_describe(
    memory: *const Solver,
    text: *mut c_char,
    bytes: usize,
) -> Status {
    let solver = shared!(memory);
    if text.is_null() {
        return Status::Null;
    }
    // SAFETY: the caller's promise; zeros first, so that it may hold anything.
    let text = unsafe {
        text.write_bytes(0, bytes);
        core::slice::from_raw_parts_mut(text.cast::<u8>(), bytes)
    };
    solver.describe(text);
    Status::Solved
}

/// `stiction_name`.
#[unsafe(no_mangle)]
pub extern "C" fn stiction_name(status: i32) -> *const c_char {
    let named = Status::NAMES
        .iter()
        .find(|(known, _)| *known as i32 == status);
    let name: &CStr = named.map_or(c"?", |(_, name)| name);
    name.as_ptr()
}

/// A matrix from its rows; `from` takes columns.
fn matrix<const ROWS: usize>(rows: &[[Real; N]; ROWS]) -> SMatrix<Real, ROWS, N> {
    SMatrix::<Real, N, ROWS>::from(*rows).transpose()
}

/// An index or a budget of C.
fn index(number: u32) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}
