//! One scene, solved by a kernel of this thread.

use crate::arrays::Arrays;
use crate::arrays::Number;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use stiction::{Error, Model, Settings};
use stiction_kernels::engine::Engine;
use stiction_kernels::problem::{Answer, Out, Outcome, Problem, refusal};
use stiction_kernels::sizes;

/// Tolerance, budget, and whether the relaxed law is solved, as they come from Python.
pub(crate) type SettingsArguments<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, bool);

pub(crate) fn settings<T: Number>(given: &SettingsArguments<'_>) -> PyResult<Settings<T>> {
    let (tolerance, budget, relaxed) = given;
    let wrong = |name: &str, error: PyErr| PyValueError::new_err(format!("{name}: {error}"));
    let tolerance: f64 = tolerance.extract().map_err(|error| wrong("tol", error))?;
    Ok(Settings {
        budget: budget.extract().map_err(|error| wrong("budget", error))?,
        model: if *relaxed { Model::ConvexRelaxation } else { Model::Coulomb },
        ..Settings::new(T::literal(tolerance))
    })
}

pub(crate) fn value_error(error: &Error) -> PyErr {
    PyValueError::new_err(refusal(error))
}

/// Runs a solve without the interpreter's lock, and makes a tuple of its solution and its fingerprint; the solve tells sizes and fingerprint. The solution is
/// `(v, r, u, modes, certificate, status, error, work, row impulses, row velocities, row modes, row certificate)`.
pub(crate) fn solved<T: Number>(
    py: Python<'_>,
    solve: impl FnOnce(&mut Answer<T>) -> PyResult<(Loaded, Outcome)> + Send,
) -> PyResult<Bound<'_, PyTuple>> {
    let mut answer = Answer::default();
    let (Loaded { sizes: [_, contacts, dim, _], fingerprint }, outcome) = py.detach(|| solve(&mut answer))?;
    let vector = |numbers: &[T]| PyArray1::from_slice(py, numbers);
    let modes = |modes: &[i8]| PyArray1::from_slice(py, modes);
    let [impulses, velocities, row_certificate] = &answer.rows;
    let parts = (
        vector(&answer.v),
        vector(&answer.r).reshape([contacts, dim])?,
        vector(&answer.u).reshape([contacts, dim])?,
        modes(&answer.modes),
        vector(&answer.certificate).reshape([contacts, dim])?,
        outcome.status as i64,
        outcome.error,
        outcome.work(),
        vector(impulses),
        vector(velocities),
        modes(&answer.row_modes),
        vector(row_certificate),
    );
    (parts, fingerprint).into_pyobject(py)
}

/// The scene in a kernel.
#[derive(Clone, Copy)]
pub(crate) struct Loaded {
    /// Velocities, contacts, rows of a contact and joint rows.
    pub(crate) sizes: [usize; 4],
    pub(crate) fingerprint: u64,
}

/// Loads, solves and reads.
pub(crate) fn run<T: Number>(
    engine: &mut dyn Engine<T>,
    problem: &Problem<'_, T>,
    settings: &Settings<T>,
    out: &mut Out<'_, T>,
) -> Result<Outcome, Error> {
    engine.load(problem)?;
    let outcome = engine.solve(settings, false)?;
    engine.read(out);
    Ok(outcome)
}

/// Lets a function use this thread's kernel of a size, cold.
pub(crate) fn with_engine<T: Number, V>(index: usize, call: impl FnOnce(&mut dyn Engine<T>) -> V) -> V {
    T::engines().with_borrow_mut(|engines| {
        if engines.len() <= index {
            engines.resize_with(T::sizes().len(), || None);
        }
        let engine = engines[index].get_or_insert_with(|| sizes::engine(index));
        engine.reset();
        call(engine.as_mut())
    })
}

/// Solves one scene from nothing.
#[pyfunction]
pub(crate) fn solve<'py>(
    py: Python<'py>,
    scene: &Bound<'py, PyTuple>,
    settings: SettingsArguments<'py>,
    single: bool,
) -> PyResult<Bound<'py, PyTuple>> {
    fn cold<'py, T: Number>(
        py: Python<'py>,
        scene: &Bound<'py, PyTuple>,
        given: &SettingsArguments<'py>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let arrays = Arrays::<T>::new(scene, false)?;
        let problem = arrays.problem(0);
        let settings = self::settings(given)?;
        let index = sizes::index::<T>(&problem.needs()).map_err(PyValueError::new_err)?;
        let loaded = arrays.loaded();
        solved(py, |answer| {
            let mut out = answer.out(loaded.sizes);
            let outcome = with_engine(index, |engine| run(engine, &problem, &settings, &mut out));
            Ok((loaded, outcome.map_err(|error| value_error(&error))?))
        })
    }
    if single { cold::<f32>(py, scene, &settings) } else { cold::<f64>(py, scene, &settings) }
}
