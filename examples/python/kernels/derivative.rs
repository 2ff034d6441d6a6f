//! Derivatives of solutions, in double precision, by kernels of a few sizes.

use crate::engine::{Compiled, Engine, with_room};
use crate::loads::{self, Asked};
use crate::problem::{Needs, Problem};
use std::cell::RefCell;
use stiction::nalgebra::SVector;
use stiction::{Error, Inputs, Outputs, Settings};

/// What is asked of a derivative.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From a change of the data to that of the solution.
    Forward,
    /// From weights of the solution to the gradient of the data.
    Adjoint,
}

/// What a solution and its derivative are like.
#[derive(Clone, Copy, Debug)]
pub struct Facts {
    /// The error with which the solution was found again.
    pub error: f64,
    pub margin: f64,
    pub unique_impulses: bool,
    pub unique_velocity: bool,
}

/// The lengths of the parts of data and solutions: velocities, contacts, rows of a contact, joint rows.
#[derive(Clone, Copy, Debug)]
pub struct Lengths {
    pub n: usize,
    pub contacts: usize,
    pub dim: usize,
    pub rows: usize,
}

impl Lengths {
    /// Numbers in a change of the data: free impulse, offsets, friction, and of joint rows offsets, lower and upper bounds.
    pub fn inputs(&self) -> usize {
        self.n + self.contacts * (self.dim + 1) + 3 * self.rows
    }

    /// Numbers in a change of a solution: velocity, impulses, those of joint rows.
    pub fn outputs(&self) -> usize {
        self.n + self.contacts * self.dim + self.rows
    }
}

/// Impulses that are found again are off by no more than this share of the largest: those of `f32` are rounded.
const SAME: f64 = 1e-5;

/// What is found again has an error of up to twice the tolerance and this: its impulses were rounded, and its scene may be a reduced one.
const ROUNDED: f64 = 1e-6;

/// A kernel that finds a solution again and differentiates it.
trait Differentiable {
    /// Finds the solution again from its impulses, and tells what it bears; `None` if it is not found.
    fn bear(
        &mut self,
        problem: &Problem<'_, f64>,
        settings: &Settings<f64>,
        impulses: [&[f64]; 2],
        asked: &Asked<'_>,
    ) -> Result<Option<Vec<f64>>, Error>;

    /// Finds the solution again from its impulses; goes the way from the numbers of `from` to those of `to`.
    fn differentiate(
        &mut self,
        problem: &Problem<'_, f64>,
        settings: &Settings<f64>,
        impulses: [&[f64]; 2],
        way: Way,
        from: &[f64],
        to: &mut [f64],
    ) -> Result<Facts, Error>;
}

/// Copies the next numbers of a list to a part.
fn take(numbers: &mut impl Iterator<Item = f64>, part: &mut [f64]) {
    for (place, number) in part.iter_mut().zip(numbers) {
        *place = number;
    }
}

/// Copies a part to the next places of a list.
fn put<'a>(places: &mut impl Iterator<Item = &'a mut f64>, part: &[f64]) {
    for (&number, place) in part.iter().zip(places) {
        *place = number;
    }
}

impl<const N: usize, const D: usize, const C: usize, const R: usize, const S: usize> Differentiable
    for Compiled<f64, N, D, C, R, S>
{
    fn bear(
        &mut self,
        problem: &Problem<'_, f64>,
        settings: &Settings<f64>,
        impulses: [&[f64]; 2],
        asked: &Asked<'_>,
    ) -> Result<Option<Vec<f64>>, Error> {
        with_room::<Self, _>(|| loads::bear(self, problem, settings, impulses, asked))
    }

    fn differentiate(
        &mut self,
        problem: &Problem<'_, f64>,
        settings: &Settings<f64>,
        impulses: [&[f64]; 2],
        way: Way,
        from: &[f64],
        to: &mut [f64],
    ) -> Result<Facts, Error> {
        // Its matrix takes about as much room as the kernel.
        with_room::<Self, _>(|| differentiate_by(self, problem, settings, impulses, (way, from, to)))
    }
}

/// As [`Differentiable::differentiate`], where there is room.
fn differentiate_by<const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
    kept: &mut Compiled<f64, N, D, C, R, S>,
    problem: &Problem<'_, f64>,
    settings: &Settings<f64>,
    [impulses, row_impulses]: [&[f64]; 2],
    (way, from, to): (Way, &[f64], &mut [f64]),
) -> Result<Facts, Error> {
    let (mut from, mut to) = (from.iter().copied(), to.iter_mut());
    let (n, contacts, rows) = (problem.n, problem.contacts(), problem.rows.lower.len());
    let Some((error, settings)) = find_again(kept, problem, settings, [impulses, row_impulses])? else {
        let error = f64::INFINITY;
        return Ok(Facts { error, margin: 0.0, unique_impulses: false, unique_velocity: false });
    };
    let kernel = kept.kernel_mut();
    let derivative = kernel.derivative(&settings)?;
    match way {
        Way::Forward => {
            let mut change = Inputs::<f64, N, D, C, R>::zero();
            take(&mut from, &mut change.free_impulse.as_mut_slice()[..n]);
            for offset in &mut change.offsets[..contacts] {
                take(&mut from, offset.as_mut_slice());
            }
            take(&mut from, &mut change.friction[..contacts]);
            take(&mut from, &mut change.row_offsets[..rows]);
            for side in 0..2 {
                for bounds in &mut change.bounds[..rows] {
                    take(&mut from, &mut bounds[side..=side]);
                }
            }
            let response = derivative.forward(&change);
            put(&mut to, &response.velocity.as_slice()[..n]);
            for impulse in &response.impulses[..contacts] {
                put(&mut to, impulse.as_slice());
            }
            put(&mut to, &response.row_impulses[..rows]);
        }
        Way::Adjoint => {
            let mut weights = Outputs::<f64, N, D, C, R>::zero();
            take(&mut from, &mut weights.velocity.as_mut_slice()[..n]);
            for impulse in &mut weights.impulses[..contacts] {
                take(&mut from, impulse.as_mut_slice());
            }
            take(&mut from, &mut weights.row_impulses[..rows]);
            let gradient = derivative.adjoint(&weights);
            put(&mut to, &gradient.free_impulse.as_slice()[..n]);
            for offset in &gradient.offsets[..contacts] {
                put(&mut to, offset.as_slice());
            }
            put(&mut to, &gradient.friction[..contacts]);
            put(&mut to, &gradient.row_offsets[..rows]);
            for side in 0..2 {
                for bounds in &gradient.bounds[..rows] {
                    put(&mut to, &bounds[side..=side]);
                }
            }
        }
    }
    Ok(Facts {
        error,
        margin: derivative.margin(),
        unique_impulses: derivative.has_unique_impulses(),
        unique_velocity: derivative.has_unique_velocity(),
    })
}

/// Finds a solution again from its impulses. Returns its error, and settings under which it is usable; `None` if the impulses are of another scene, or of
/// no solution.
pub(crate) fn find_again<const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
    kept: &mut Compiled<f64, N, D, C, R, S>,
    problem: &Problem<'_, f64>,
    settings: &Settings<f64>,
    [impulses, row_impulses]: [&[f64]; 2],
) -> Result<Option<(f64, Settings<f64>)>, Error> {
    kept.reset();
    kept.load(problem)?;
    let key = |keys: &[u32], i: usize| keys.get(i).copied().unwrap_or(0);
    let contact = |(i, r)| (key(problem.keys, i), SVector::from_column_slice(r));
    let known: Vec<_> = impulses.chunks_exact(D).enumerate().map(contact).collect();
    let row = |(j, &r)| (key(problem.rows.keys, j), r);
    let known_rows: Vec<_> = row_impulses.iter().enumerate().map(row).collect();
    kept.kernel_mut().solver_mut().set_impulses(&known, &known_rows)?;
    let mut settings = Settings { budget: 1, ..*settings }; // to judge them
    let error = kept.solve(&settings, false)?.error;
    settings.tolerance = ROUNDED + 2.0 * settings.tolerance;
    let found = kept.kernel_mut().solution();
    let is_usable = found.is_usable(settings.tolerance);
    let found = (found.contacts.iter().flat_map(|contact| contact.impulse.as_slice()))
        .chain(found.rows.iter().map(|row| &row.impulse));
    let (mut off, mut largest) = (0.0_f64, 0.0_f64);
    for (found, given) in found.zip(impulses.iter().chain(row_impulses)) {
        (off, largest) = (off.max((found - given).abs()), largest.max(given.abs()));
    }
    Ok((off <= SAME * largest && is_usable).then_some((error, settings)))
}

/// Sizes and their constructors; all of them are sizes of the table.
macro_rules! sizes {
    ($(($n:literal, $d:literal, $c:literal, $r:literal, $s:literal): $push:expr;)*) => {
        const SIZES: &[(Needs, fn() -> Box<dyn Differentiable>)] = &[$((
            Needs { n: $n, dim: $d, contacts: $c, rows: $r, surfaces: $s > 0 },
            || Compiled::<f64, $n, $d, $c, $r, $s>::boxed($push),
        ),)*];
    };
}

sizes! {
    (18, 3, 16, 30, 16): stiction::Scene::push;
    (36, 3, 24, 48, 24): stiction::Scene::push;
    (60, 3, 64, 96, 64): stiction::Scene::push;
    (36, 2, 16, 48, 16): stiction::Scene::push;
    (36, 1, 16, 48, 16): stiction::Scene::push;
    (36, 4, 16, 48, 16): crate::sizes::push_on_surface;
    (36, 6, 24, 48, 24): crate::sizes::push_on_surface;
}

thread_local! {
    /// A kernel for each size, as far as this thread has needed them.
    static KERNELS: RefCell<Vec<Option<Box<dyn Differentiable>>>> = const { RefCell::new(Vec::new()) };
}

/// Differentiates a solution of a scene at its impulses, by a kernel of this thread.
///
/// # Errors
/// What is refused, with the name of its argument first.
pub fn differentiate(
    problem: &Problem<'_, f64>,
    settings: &Settings<f64>,
    impulses: [&[f64]; 2],
    (way, from, to): (Way, &[f64], &mut [f64]),
) -> Result<Facts, String> {
    with_kernel(problem, |kernel| kernel.differentiate(problem, settings, impulses, way, from, to))
}

/// Tells what a solution of a scene bears at its impulses, by a kernel of this thread; `None` if they are of another scene, or of no solution.
///
/// # Errors
/// What is refused, with the name of its argument first.
pub fn bear(
    problem: &Problem<'_, f64>,
    settings: &Settings<f64>,
    impulses: [&[f64]; 2],
    asked: &Asked<'_>,
) -> Result<Option<Vec<f64>>, String> {
    with_kernel(problem, |kernel| kernel.bear(problem, settings, impulses, asked))
}

/// Lets a function use this thread's kernel for a scene.
fn with_kernel<V>(
    problem: &Problem<'_, f64>,
    call: impl FnOnce(&mut dyn Differentiable) -> Result<V, Error>,
) -> Result<V, String> {
    let needs = problem.needs();
    let holds = |size: &Needs| {
        needs.n <= size.n
            && needs.dim == size.dim
            && needs.contacts <= size.contacts
            && needs.rows <= size.rows
    };
    let place = SIZES.iter().position(|(size, _)| holds(size)).ok_or_else(|| {
        format!(
            "solution: no kernel looks into {} velocities, {} contacts of {} rows and {} joint rows; add a line to kernels/derivative.rs",
            needs.n, needs.contacts, needs.dim, needs.rows
        )
    })?;
    KERNELS.with_borrow_mut(|kernels| {
        kernels.resize_with(SIZES.len(), || None);
        let kernel = kernels[place].get_or_insert_with(SIZES[place].1);
        call(kernel.as_mut()).map_err(|error| crate::problem::refusal(&error))
    })
}
