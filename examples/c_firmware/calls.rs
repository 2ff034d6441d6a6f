//! The calls of `stiction.h`.
//!
//! The one place where pointers come in: each function turns them into references, or says that one is null, and goes on
//! without `unsafe`.
//!
//! # Safety
//! Of all functions: a pointer is null, or points to what the header declares, which nothing else uses meanwhile.
#![allow(clippy::missing_safety_doc)] // it is above

use super::given::{ContactImpulse, JointRow, LawNumber, ModelNumber, RowImpulse, Surface};
use super::header::{C, D, K, L, N, R, Real};
use super::outcome::{ContactOutcome, RowOutcome, Solution, Violation};
use super::solver::{FloatKernel, Kernel, Refusal, Solver, advance, advance_with_limits};
use super::status::{Culprit, Status, turned};
use core::ffi::{CStr, c_char};
use stiction::nalgebra::{SMatrix, SVector};
use stiction::time_stepping::Gap;
use stiction::{Contact, contact_frame};

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

/// The limits behind a pointer.
macro_rules! limits {
    ($pointer:expr, $count:expr) => {
        // SAFETY: the caller's promise. One more than fits is as many as are looked at.
        match unsafe { some($pointer, $count.min(L as u32 + 1)) } {
            Some(limits) => limits,
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

/// `stiction_init_sized`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_init_sized(
    memory: *mut Solver,
    bytes: usize,
    solution_bytes: usize,
) -> Status {
    if memory.is_null() {
        return Status::Null;
    }
    if (bytes, solution_bytes) != (Solver::ROOM, size_of::<Solution>()) {
        return Status::WrongSizes;
    }
    // SAFETY: the memory is the caller's, large enough and aligned.
    unsafe { Solver::init(memory) };
    Status::Ok
}

/// `stiction_reset`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_reset(memory: *mut Solver) -> Status {
    solver!(memory).kernel.solver_mut().reset();
    Status::Ok
}

/// `stiction_set_model`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_model(memory: *mut Solver, model: ModelNumber) -> Status {
    solver!(memory).set_model(model)
}

/// `stiction_set_still`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_still(memory: *mut Solver, speed: Real) -> Status {
    solver!(memory).set_still(speed);
    Status::Ok
}

/// `stiction_set_velocities`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_velocities(memory: *mut Solver, velocities: u32) -> Status {
    solver!(memory).change(|scene| scene.set_velocities(index(velocities)))
}

/// `stiction_set_mass`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_mass(memory: *mut Solver, mass: *const [Real; N]) -> Status {
    let (solver, mass) = (solver!(memory), given!(mass, SMatrix<Real, N, N>));
    // Its rows for its columns: it is symmetric, and so nothing of this size is copied over the stack.
    solver.change(|scene| scene.set_mass(mass).map_err(turned))
}

/// `stiction_clear`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_clear(memory: *mut Solver) -> Status {
    solver!(memory).kernel.scene_mut().clear();
    Status::Ok
}

/// `stiction_clear_contacts`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_clear_contacts(memory: *mut Solver) -> Status {
    solver!(memory).kernel.scene_mut().clear_contacts();
    Status::Ok
}

/// `stiction_clear_rows`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_clear_rows(memory: *mut Solver) -> Status {
    solver!(memory).kernel.scene_mut().clear_rows();
    Status::Ok
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
    let (solver, jacobian, offset) =
        (solver!(memory), given!(jacobian, [[Real; N]; D]), given!(offset, [Real; D]));
    solver.push(&contact(jacobian, offset, mu, key))
}

/// `stiction_add_contact_on`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_add_contact_on(
    memory: *mut Solver,
    jacobian: *const [Real; N],
    offset: *const Real,
    surface: *const Surface,
    key: u32,
) -> Status {
    let (solver, jacobian, offset, surface) = (
        solver!(memory),
        given!(jacobian, [[Real; N]; D]),
        given!(offset, [Real; D]),
        given!(surface, Surface),
    );
    let contact = contact(jacobian, offset, 0.0, key);
    solver.change(|scene| scene.push_on(&contact, &surface.into()).map(|_| ()))
}

/// `stiction_remove_contact`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_remove_contact(memory: *mut Solver, contact: u32) -> Status {
    solver!(memory).change(|scene| scene.remove_contact(index(contact)))
}

/// `stiction_contact_index`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_contact_index(memory: *const Solver, key: u32) -> i32 {
    // SAFETY: the caller's promise.
    unsafe { find(memory, |kernel| kernel.scene().contact_index(key)) }
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
pub unsafe extern "C" fn stiction_set_friction(memory: *mut Solver, contact: u32, mu: Real) -> Status {
    solver!(memory).change(|scene| scene.set_friction(index(contact), mu))
}

/// `stiction_add_row`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_add_row(memory: *mut Solver, row: *const JointRow) -> Status {
    let (solver, row) = (solver!(memory), given!(row, JointRow));
    match row.read() {
        Ok(row) => solver.change(|scene| scene.push_row(&row).map(|_| ())),
        Err(refusal) => solver.refuse(refusal),
    }
}

/// `stiction_remove_row`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_remove_row(memory: *mut Solver, row: u32) -> Status {
    solver!(memory).change(|scene| scene.remove_row(index(row)))
}

/// `stiction_row_index`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_row_index(memory: *const Solver, key: u32) -> i32 {
    // SAFETY: the caller's promise.
    unsafe { find(memory, |kernel| kernel.scene().row_index(key)) }
}

/// `stiction_set_row_jacobian`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_row_jacobian(
    memory: *mut Solver,
    row: u32,
    jacobian: *const Real,
) -> Status {
    let (solver, jacobian) = (solver!(memory), given!(jacobian, SVector<Real, N>));
    solver.change(|scene| scene.set_row_jacobian(index(row), jacobian))
}

/// `stiction_set_row_offset`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_row_offset(memory: *mut Solver, row: u32, offset: Real) -> Status {
    solver!(memory).change(|scene| scene.set_row_offset(index(row), offset))
}

/// `stiction_set_row_law`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_row_law(
    memory: *mut Solver,
    row: u32,
    law: LawNumber,
    lower: Real,
    upper: Real,
) -> Status {
    let solver = solver!(memory);
    match JointRow::law(law, lower, upper) {
        Ok(law) => solver.change(|scene| scene.set_row_law(index(row), law)),
        Err(refusal) => solver.refuse(refusal),
    }
}

/// `stiction_set_row_compliance`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_row_compliance(
    memory: *mut Solver,
    row: u32,
    compliance: Real,
) -> Status {
    solver!(memory).change(|scene| scene.set_row_compliance(index(row), compliance))
}

/// `stiction_set_impulses`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_set_impulses(
    memory: *mut Solver,
    contacts: *const ContactImpulse,
    contact_count: u32,
    rows: *const RowImpulse,
    row_count: u32,
) -> Status {
    let solver = solver!(memory);
    // One more than fits is as many as are looked at.
    let (contact_count, row_count) = (contact_count.min(C as u32 + 1), row_count.min(R as u32 + 1));
    // SAFETY: the caller's promise.
    match unsafe { (some(contacts, contact_count), some(rows, row_count)) } {
        (Some(contacts), Some(rows)) => solver.set_impulses(contacts, rows),
        _ => Status::Null,
    }
}

/// `stiction_budget_within`.
#[unsafe(no_mangle)]
pub extern "C" fn stiction_budget_within(microseconds: u32, megahertz: u32, wait_percent: u32) -> u32 {
    // The sizes and phases of this kernel, whose number type the bound does not know.
    const IS_BOUNDED: bool = size_of::<Real>() == size_of::<f32>();
    let [microseconds, megahertz, wait_percent] = [microseconds, megahertz, wait_percent].map(index);
    let budget = FloatKernel::budget_within(microseconds, megahertz, wait_percent);
    if IS_BOUNDED { u32::try_from(budget).unwrap_or(u32::MAX) } else { 0 }
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

/// `stiction_advance`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_advance(
    memory: *mut Solver,
    free_impulse: *const Real,
    tolerance: Real,
    budget: u32,
) -> Status {
    let (solver, free_impulse) = (solver!(memory), given!(free_impulse, [Real; N]));
    solver.solve(advance, free_impulse, tolerance, index(budget))
}

/// `stiction_solve_with_limits`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_solve_with_limits(
    memory: *mut Solver,
    limits: *const JointRow,
    limit_count: u32,
    free_impulse: *const Real,
    tolerance: Real,
    budget: u32,
) -> Status {
    let (solver, free_impulse) = (solver!(memory), given!(free_impulse, [Real; N]));
    let limits = limits!(limits, limit_count);
    solver.solve_with_limits(Kernel::solve_with_limits, limits, free_impulse, (tolerance, index(budget)))
}

/// `stiction_resume_with_limits`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_resume_with_limits(
    memory: *mut Solver,
    limits: *const JointRow,
    limit_count: u32,
    free_impulse: *const Real,
    tolerance: Real,
    budget: u32,
) -> Status {
    let (solver, free_impulse) = (solver!(memory), given!(free_impulse, [Real; N]));
    let limits = limits!(limits, limit_count);
    solver.solve_with_limits(Kernel::resume_with_limits, limits, free_impulse, (tolerance, index(budget)))
}

/// `stiction_advance_with_limits`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_advance_with_limits(
    memory: *mut Solver,
    limits: *const JointRow,
    limit_count: u32,
    free_impulse: *const Real,
    tolerance: Real,
    budget: u32,
) -> Status {
    let (solver, free_impulse) = (solver!(memory), given!(free_impulse, [Real; N]));
    let limits = limits!(limits, limit_count);
    solver.solve_with_limits(advance_with_limits, limits, free_impulse, (tolerance, index(budget)))
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
    let kernel = &shared!(memory).kernel;
    // SAFETY: the caller's promise.
    unsafe { tell(solution, || Ok(Solution::of(kernel.solution()))) }
}

/// `stiction_contact_at`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_contact_at(
    memory: *const Solver,
    contact: u32,
    found: *mut ContactOutcome,
) -> Status {
    let solution = shared!(memory).kernel.solution();
    let read = || ContactOutcome::at(solution, index(contact)).ok_or(Status::NoSuchContact);
    // SAFETY: the caller's promise.
    unsafe { tell(found, read) }
}

/// `stiction_contact_by_key`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_contact_by_key(
    memory: *const Solver,
    key: u32,
    found: *mut ContactOutcome,
) -> Status {
    let solution = shared!(memory).kernel.solution();
    let place = || solution.contacts.iter().position(|c| c.key == key);
    let read = || ContactOutcome::at(solution, place()?);
    // SAFETY: the caller's promise.
    unsafe { tell(found, || read().ok_or(Status::NoSuchKey)) }
}

/// `stiction_row_at`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_row_at(memory: *const Solver, row: u32, found: *mut RowOutcome) -> Status {
    let solution = shared!(memory).kernel.solution();
    let read = || RowOutcome::at(solution, index(row)).ok_or(Status::NoSuchRow);
    // SAFETY: the caller's promise.
    unsafe { tell(found, read) }
}

/// `stiction_row_by_key`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_row_by_key(
    memory: *const Solver,
    key: u32,
    found: *mut RowOutcome,
) -> Status {
    let solution = shared!(memory).kernel.solution();
    let place = || solution.rows.iter().position(|row| row.key == key);
    let read = || RowOutcome::at(solution, place()?);
    // SAFETY: the caller's promise.
    unsafe { tell(found, || read().ok_or(Status::NoSuchKey)) }
}

/// `stiction_worst_violation`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_worst_violation(
    memory: *const Solver,
    violation: *mut Violation,
) -> Status {
    let kernel = &shared!(memory).kernel;
    // SAFETY: the caller's promise.
    unsafe { tell(violation, || Ok(kernel.violation().into())) }
}

/// `stiction_read_least`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_read_least(
    memory: *const Solver,
    tolerance: Real,
    solution: *mut Solution,
) -> Status {
    let solver = shared!(memory);
    let settings = solver.settings(tolerance, 0);
    let read = || {
        let least = solver.kernel.least_impulses(&settings)?;
        Ok(Solution::of(solver.kernel.solution()).with(&least))
    };
    // SAFETY: the caller's promise.
    unsafe { tell(solution, read) }
}

/// `stiction_slip_reserve`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_slip_reserve(
    memory: *const Solver,
    accuracy: Real,
    share: *mut Real,
) -> Status {
    let solver = shared!(memory);
    let settings = solver.settings(accuracy, 0);
    // SAFETY: the caller's promise.
    unsafe { tell(share, || Ok(solver.kernel.slip_reserve(&settings)?)) }
}

/// `stiction_load_reserve`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_load_reserve(
    memory: *const Solver,
    load: *const Real,
    accuracy: Real,
    factor: *mut Real,
) -> Status {
    let (solver, load) = (shared!(memory), given!(load, [Real; N]));
    let settings = solver.settings(accuracy, 0);
    // SAFETY: the caller's promise.
    unsafe { tell(factor, || Ok(solver.kernel.load_reserve(&SVector::from(*load), &settings)?)) }
}

/// `stiction_rest_reserve`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_rest_reserve(
    memory: *mut Solver,
    free_impulse: *const Real,
    accuracy: Real,
    share: *mut Real,
) -> Status {
    let (solver, free_impulse) = (solver!(memory), given!(free_impulse, [Real; N]));
    let settings = solver.settings(accuracy, 0);
    let free_impulse = SVector::from(*free_impulse);
    // SAFETY: the caller's promise.
    unsafe { tell(share, || Ok(solver.kernel.rest_reserve(&free_impulse, &settings)?)) }
}

/// `stiction_last_culprit`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_last_culprit(memory: *const Solver, culprit: *mut Culprit) -> Status {
    let error = shared!(memory).error;
    // SAFETY: the caller's promise.
    unsafe { tell(culprit, || Ok(error.map_or(Culprit::NONE, Refusal::culprit))) }
}

/// `stiction_describe`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_describe(memory: *const Solver, text: *mut c_char, bytes: usize) -> Status {
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
    Status::Ok
}

/// `stiction_gap_offset`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_gap_offset(
    distance: Real,
    recovery: Real,
    reach: Real,
    step: Real,
    offset: *mut Real,
) -> Status {
    let gap = Gap { distance, recovery, reach };
    // SAFETY: the caller's promise.
    unsafe { tell(offset, || Ok(gap.offset(step)?)) }
}

/// `stiction_contact_frame`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_contact_frame(normal: *const Real, frame: *mut [Real; K]) -> Status {
    let normal = given!(normal, [Real; K]);
    // Its columns are rows in C.
    let axes = || Ok(contact_frame(&SVector::from(*normal))?.into());
    // SAFETY: the caller's promise.
    unsafe { tell(frame.cast::<[[Real; K]; K]>(), axes) }
}

/// `stiction_contact_rows`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_contact_rows(
    normal: *const Real,
    velocity: *const [Real; N],
    turning: *const [Real; N],
    jacobian: *mut [Real; N],
) -> Status {
    let (normal, velocity) = (given!(normal, [Real; K]), given!(velocity, [[Real; N]; K]));
    let turning = if D > K { given!(turning, [[Real; N]; K]) } else { velocity };
    // SAFETY: the caller's promise.
    unsafe { tell(jacobian.cast::<[[Real; N]; D]>(), || rows_at(normal, velocity, turning)) }
}

/// `stiction_name`.
#[unsafe(no_mangle)]
pub extern "C" fn stiction_name(status: i32) -> *const c_char {
    let named = Status::NAMES.iter().find(|(known, _)| *known as i32 == status);
    let name: &CStr = named.map_or(c"?", |(_, name)| name);
    name.as_ptr()
}

/// Writes a value to where a pointer points, unless that is null or there is none.
///
/// # Safety
/// The pointer is null or good.
unsafe fn tell<T>(place: *mut T, value: impl FnOnce() -> Result<T, Status>) -> Status {
    if place.is_null() {
        return Status::Null;
    }
    match value() {
        Ok(value) => {
            // SAFETY: the caller's promise.
            unsafe { place.write(value) };
            Status::Ok
        }
        Err(status) => status,
    }
}

/// So many values behind a pointer, which may be null if they are none.
///
/// # Safety
/// The pointer is null or good.
unsafe fn some<'a, T>(first: *const T, count: u32) -> Option<&'a [T]> {
    match (count, first.is_null()) {
        (0, _) => Some(&[]),
        (_, true) => None,
        // SAFETY: the caller's promise.
        _ => Some(unsafe { core::slice::from_raw_parts(first, index(count)) }),
    }
}

/// The rows of a contact at a point: those of its velocity along the axes of its frame, then those that turn about them.
fn rows_at(
    normal: &[Real; K],
    velocity: &[[Real; N]; K],
    turning: &[[Real; N]; K],
) -> Result<[[Real; N]; D], Status> {
    let axes = contact_frame(&SVector::from(*normal))?.data.0;
    let along = axes.iter().map(|axis| (axis, velocity));
    let about = axes.iter().map(|axis| (axis, turning));
    let mut rows = [[0.0; N]; D];
    for (row, (axis, velocity)) in rows.iter_mut().zip(along.chain(about)) {
        for (&share, velocity) in axis.iter().zip(velocity) {
            for (entry, &v) in row.iter_mut().zip(velocity) {
                *entry += share * v;
            }
        }
    }
    Ok(rows)
}

/// A contact from the rows of its Jacobian.
fn contact(jacobian: &[[Real; N]; D], offset: &[Real; D], mu: Real, key: u32) -> Contact<Real, N, D> {
    Contact { jacobian: matrix(jacobian), offset: SVector::from(*offset), mu, key }
}

/// A matrix from its rows; `from` takes columns.
fn matrix(rows: &[[Real; N]; D]) -> SMatrix<Real, D, N> {
    SMatrix::<Real, N, D>::from(*rows).transpose()
}

/// An index in the scene of a solver, or the status that says why there is none.
unsafe fn find(memory: *const Solver, index: impl FnOnce(&Kernel) -> Option<usize>) -> i32 {
    // SAFETY: the caller's promise, and `stiction_init` was called.
    let kernel = match unsafe { Solver::check(memory) } {
        Ok(()) => unsafe { &(*memory).kernel },
        Err(status) => return status as i32,
    };
    index(kernel).map_or(Status::NoSuchKey as i32, |index| i32::try_from(index).unwrap_or(i32::MAX))
}

/// An index, a count or a budget of C.
fn index(number: u32) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}
