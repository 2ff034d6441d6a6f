//! The kernel behind a C interface; `stiction.h` beside this file is its header.
//!
//! The one place where pointers come in: each function turns them into references, or says that
//! one is null, and goes on without `unsafe`.
#![cfg_attr(target_os = "none", no_std)]
#![allow(unsafe_code)]

use core::mem::{align_of, size_of};
use nalgebra::{SMatrix, SVector};
use stiction::{Contact, Error, Settings, Solution, Status};

const N: usize = 18;
const D: usize = 3;
const C: usize = 5;
/// As many as in `stiction.h`.
const BYTES: usize = 10240;

const NULL: i32 = -1;
const MEMORY: i32 = -2;

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        safe fn abort() -> !;
    }
    abort()
}

/// What lives in the caller's memory.
type Kernel = stiction::Kernel<f32, N, D, C>;

fn code(error: Error) -> i32 {
    match error {
        Error::NotFinite { .. } => -3,
        Error::MassNotSymmetric { .. } | Error::MassNotPositiveDefinite { .. } => -4,
        Error::InvalidFriction { .. } => -5,
        Error::ContactListFull { .. } => -6,
        Error::InvalidTolerance => -7,
        _ => -8,
    }
}

fn check(result: Result<(), Error>) -> i32 {
    result.map_or_else(code, |()| 0)
}

/// # Safety
/// `kernel` is null or points to a `stiction` that nothing else uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_init(kernel: *mut Kernel) -> i32 {
    if kernel.is_null() {
        return NULL;
    }
    if size_of::<Kernel>() > BYTES || align_of::<Kernel>() > 8 {
        return MEMORY;
    }
    // SAFETY: the memory is the caller's, large enough and aligned.
    unsafe {
        kernel.write(Kernel::new());
    }
    0
}

/// # Safety
/// Pointers are null or as `stiction.h` declares them; `stiction_init` has been called.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_mass(kernel: *mut Kernel, mass: *const [[f32; N]; N]) -> i32 {
    // SAFETY: the caller's promise.
    let (Some(kernel), Some(mass)) = (unsafe { kernel.as_mut() }, unsafe { mass.as_ref() }) else {
        return NULL;
    };
    let mass = SMatrix::<f32, N, N>::from(*mass).transpose(); // `from` takes columns
    check(kernel.scene_mut().set_mass(&mass))
}

/// # Safety
/// As for [`stiction_set_mass`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_clear_contacts(kernel: *mut Kernel) -> i32 {
    // SAFETY: the caller's promise.
    let Some(kernel) = (unsafe { kernel.as_mut() }) else {
        return NULL;
    };
    kernel.scene_mut().clear_contacts();
    0
}

/// # Safety
/// As for [`stiction_set_mass`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_add_contact(
    kernel: *mut Kernel,
    jacobian: *const [[f32; N]; D],
    offset: *const [f32; D],
    mu: f32,
    key: u32,
) -> i32 {
    // SAFETY: the caller's promise.
    let (kernel, jacobian, offset) =
        unsafe { (kernel.as_mut(), jacobian.as_ref(), offset.as_ref()) };
    let (Some(kernel), Some(jacobian), Some(offset)) = (kernel, jacobian, offset) else {
        return NULL;
    };
    let contact = Contact {
        jacobian: SMatrix::<f32, N, D>::from(*jacobian).transpose(),
        offset: SVector::from(*offset),
        mu,
        key,
    };
    check(kernel.scene_mut().push(&contact).map(|_| ()))
}

/// # Safety
/// As for [`stiction_set_mass`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_solve(
    kernel: *mut Kernel,
    free_impulse: *const [f32; N],
    tolerance: f32,
    budget: u32,
) -> i32 {
    // SAFETY: the caller's promise.
    unsafe { run(Kernel::solve, kernel, free_impulse, tolerance, budget) }
}

/// # Safety
/// As for [`stiction_set_mass`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_resume(
    kernel: *mut Kernel,
    free_impulse: *const [f32; N],
    tolerance: f32,
    budget: u32,
) -> i32 {
    // SAFETY: the caller's promise.
    unsafe { run(Kernel::resume, kernel, free_impulse, tolerance, budget) }
}

type Solve = for<'a> fn(
    &'a mut Kernel,
    &SVector<f32, N>,
    &Settings<f32>,
) -> Result<&'a Solution<f32, N, D, C>, Error>;

/// # Safety
/// As for [`stiction_set_mass`].
unsafe fn run(
    solve: Solve,
    kernel: *mut Kernel,
    free_impulse: *const [f32; N],
    tolerance: f32,
    budget: u32,
) -> i32 {
    // SAFETY: the caller's promise.
    let (kernel, free_impulse) = unsafe { (kernel.as_mut(), free_impulse.as_ref()) };
    let (Some(kernel), Some(free_impulse)) = (kernel, free_impulse) else {
        return NULL;
    };
    let settings = Settings {
        budget: usize::try_from(budget).unwrap_or(usize::MAX),
        ..Settings::new(tolerance)
    };
    match solve(kernel, &SVector::from(*free_impulse), &settings) {
        Ok(solution) => match solution.status {
            Status::Solved => 0,
            Status::OutOfBudget => 1,
            Status::PrecisionLimit => 2,
            Status::Infeasible => 3,
            _ => 4,
        },
        Err(error) => code(error),
    }
}

/// # Safety
/// As for [`stiction_set_mass`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_is_usable(kernel: *const Kernel, error: f32) -> i32 {
    // SAFETY: the caller's promise.
    let kernel = unsafe { kernel.as_ref() };
    kernel.map_or(NULL, |kernel| kernel.solution().is_usable(error).into())
}

/// # Safety
/// As for [`stiction_set_mass`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_read(
    kernel: *const Kernel,
    velocity: *mut [f32; N],
    keys: *mut [u32; C],
    impulses: *mut [[f32; D]; C],
    error: *mut f32,
) -> i32 {
    // SAFETY: the caller's promise.
    let Some(kernel) = (unsafe { kernel.as_ref() }) else {
        return NULL;
    };
    let solution = kernel.solution();
    // SAFETY: the caller's promise.
    let (velocity, keys) = unsafe { (velocity.as_mut(), keys.as_mut()) };
    // SAFETY: the caller's promise.
    let (impulses, error) = unsafe { (impulses.as_mut(), error.as_mut()) };
    if let Some(velocity) = velocity {
        *velocity = solution.velocity.into();
    }
    if let Some(keys) = keys {
        for (key, contact) in keys.iter_mut().zip(&solution.contacts) {
            *key = contact.key;
        }
    }
    if let Some(impulses) = impulses {
        for (impulse, contact) in impulses.iter_mut().zip(&solution.contacts) {
            *impulse = contact.impulse.into();
        }
    }
    if let Some(error) = error {
        *error = solution.error;
    }
    i32::try_from(solution.contacts.len()).unwrap_or(i32::MAX)
}
