//! One scene: solved by a kernel of this thread, or by one that keeps what a warm start needs.

use crate::arrays::Arrays;
use crate::engine::{Engine, Number};
use crate::problem::{Needs, Out, Outcome, refusal};
use crate::sizes;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::{Mutex, PoisonError};
use stiction::{Error, Model, Settings};

/// Tolerance, budget, and whether the relaxed law is solved.
pub(crate) type SettingsArguments = (f64, usize, bool);

pub(crate) fn settings<T: Number>((tolerance, budget, relaxed): SettingsArguments) -> Settings<T> {
    Settings {
        tolerance: T::literal(tolerance),
        budget,
        model: if relaxed { Model::ConvexRelaxation } else { Model::Coulomb },
    }
}

pub(crate) fn value_error(error: &Error) -> PyErr {
    PyValueError::new_err(refusal(error))
}

/// Runs a solve without the interpreter's lock, and makes a tuple of its solution:
/// `(v, r, u, modes, certificate, status, error, work, row impulses, row velocities, row modes, row certificate)`.
fn solved<'py, T: Number>(
    py: Python<'py>,
    [n, contacts, dim, rows]: [usize; 4],
    solve: impl FnOnce(&mut Out<'_, T>) -> Result<Outcome, Error> + Send,
) -> PyResult<Bound<'py, PyTuple>> {
    let v = PyArray1::<T>::zeros(py, n, false);
    let [r, u] = [(); 2].map(|()| PyArray2::<T>::zeros(py, [contacts, dim], false));
    let modes = PyArray1::<i8>::zeros(py, contacts, false);
    let certificate = PyArray1::<T>::zeros(py, contacts, false);
    let [impulses, velocities, row_certificate] = [(); 3].map(|()| PyArray1::<T>::zeros(py, rows, false));
    let row_modes = PyArray1::<i8>::zeros(py, rows, false);
    let outcome = {
        let (mut v_, mut r_, mut u_) = (v.readwrite(), r.readwrite(), u.readwrite());
        let (mut modes_, mut certificate_) = (modes.readwrite(), certificate.readwrite());
        let (mut impulses_, mut velocities_) = (impulses.readwrite(), velocities.readwrite());
        let (mut row_modes_, mut row_certificate_) = (row_modes.readwrite(), row_certificate.readwrite());
        let mut out = Out {
            v: v_.as_slice_mut()?,
            r: r_.as_slice_mut()?,
            u: u_.as_slice_mut()?,
            modes: modes_.as_slice_mut()?,
            certificate: certificate_.as_slice_mut()?,
            row_impulses: impulses_.as_slice_mut()?,
            row_velocities: velocities_.as_slice_mut()?,
            row_modes: row_modes_.as_slice_mut()?,
            row_certificate: row_certificate_.as_slice_mut()?,
        };
        py.detach(|| solve(&mut out)).map_err(|error| value_error(&error))?
    };
    (
        v,
        r,
        u,
        modes,
        certificate,
        outcome.status as i64,
        outcome.error,
        outcome.work(),
        impulses,
        velocities,
        row_modes,
        row_certificate,
    )
        .into_pyobject(py)
}

/// Loads, solves and reads.
pub(crate) fn run<T: Number>(
    engine: &mut dyn Engine<T>,
    problem: &crate::problem::Problem<'_, T>,
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
            engines.resize_with(sizes::SIZES.len(), || None);
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
    settings: SettingsArguments,
    single: bool,
) -> PyResult<Bound<'py, PyTuple>> {
    fn cold<'py, T: Number>(py: Python<'py>, scene: &Bound<'py, PyTuple>, given: SettingsArguments) -> PyResult<Bound<'py, PyTuple>> {
        let arrays = Arrays::<T>::new(scene, false)?;
        let problem = arrays.problem(0);
        let index = sizes::index(&problem.needs()).map_err(PyValueError::new_err)?;
        let sizes = [arrays.velocities(), arrays.contacts, arrays.dim, arrays.rows];
        solved(py, sizes, |out| with_engine(index, |engine| run(engine, &problem, &self::settings(given), out)))
    }
    if single { cold::<f32>(py, scene, settings) } else { cold::<f64>(py, scene, settings) }
}

/// A kernel of one number type.
struct Kept<T> {
    engine: Box<dyn Engine<T>>,
    /// Velocities, contacts, rows of a contact and joint rows of the scene in it, if there is one.
    loaded: Option<[usize; 4]>,
}

enum Either {
    Single(Mutex<Kept<f32>>),
    Double(Mutex<Kept<f64>>),
}

/// A kernel that keeps its last solve.
#[pyclass(frozen, module = "stiction._stiction")]
pub(crate) struct Kernel {
    index: usize,
    kept: Either,
}

#[pymethods]
impl Kernel {
    #[new]
    fn new(n: usize, contacts: usize, dim: usize, rows: usize, surfaces: bool, single: bool) -> PyResult<Self> {
        let surfaces = surfaces || dim > 3;
        let needs = Needs { n, dim, contacts, rows, surfaces };
        let index = sizes::index(&needs).map_err(PyValueError::new_err)?;
        let kept = if single {
            Either::Single(Mutex::new(Kept { engine: sizes::engine(index), loaded: None }))
        } else {
            Either::Double(Mutex::new(Kept { engine: sizes::engine(index), loaded: None }))
        };
        Ok(Self { index, kept })
    }

    /// Its compiled size.
    #[getter]
    fn size(&self) -> (usize, usize, usize, usize, usize) {
        sizes::SIZES[self.index].tuple()
    }

    fn solve<'py>(&self, py: Python<'py>, scene: &Bound<'py, PyTuple>, settings: SettingsArguments) -> PyResult<Bound<'py, PyTuple>> {
        match &self.kept {
            Either::Single(kept) => self.warm(py, kept, scene, settings),
            Either::Double(kept) => self.warm(py, kept, scene, settings),
        }
    }

    fn resume<'py>(&self, py: Python<'py>, settings: SettingsArguments) -> PyResult<Bound<'py, PyTuple>> {
        match &self.kept {
            Either::Single(kept) => resumed(py, kept, settings),
            Either::Double(kept) => resumed(py, kept, settings),
        }
    }

    fn reset(&self, py: Python<'_>) {
        match &self.kept {
            Either::Single(kept) => py.detach(|| lock(kept).engine.reset()),
            Either::Double(kept) => py.detach(|| lock(kept).engine.reset()),
        }
    }

    fn start(&self, py: Python<'_>, keys: PyReadonlyArray1<'_, u32>, impulses: &Bound<'_, PyAny>) -> PyResult<()> {
        match &self.kept {
            Either::Single(kept) => start(py, kept, &keys, &impulses.extract()?),
            Either::Double(kept) => start(py, kept, &keys, &impulses.extract()?),
        }
    }
}

impl Kernel {
    fn warm<'py, T: Number>(
        &self,
        py: Python<'py>,
        kept: &Mutex<Kept<T>>,
        scene: &Bound<'py, PyTuple>,
        given: SettingsArguments,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let arrays = Arrays::<T>::new(scene, false)?;
        let (problem, size) = (arrays.problem(0), &sizes::SIZES[self.index]);
        if !size.holds(&problem.needs()) {
            return Err(PyValueError::new_err(format!(
                "scene: {:?} do not fit in a kernel made for {size:?}",
                problem.needs()
            )));
        }
        let sizes = [arrays.velocities(), arrays.contacts, arrays.dim, arrays.rows];
        solved(py, sizes, |out| {
            let mut kept = lock(kept);
            kept.loaded = None; // half a scene, if it is refused
            let outcome = run(kept.engine.as_mut(), &problem, &settings(given), out)?;
            kept.loaded = Some(sizes);
            Ok(outcome)
        })
    }
}

fn resumed<'py, T: Number>(py: Python<'py>, kept: &Mutex<Kept<T>>, given: SettingsArguments) -> PyResult<Bound<'py, PyTuple>> {
    let loaded = py.detach(|| lock(kept).loaded);
    let sizes = loaded.ok_or_else(|| PyValueError::new_err("there is no scene to go on with: the last one was refused, or there was none"))?;
    solved(py, sizes, |out| {
        let mut kept = lock(kept);
        let outcome = kept.engine.solve(&settings(given), true)?;
        kept.engine.read(out);
        Ok(outcome)
    })
}

fn start<T: Number>(py: Python<'_>, kept: &Mutex<Kept<T>>, keys: &PyReadonlyArray1<'_, u32>, impulses: &PyReadonlyArray2<'_, T>) -> PyResult<()> {
    if impulses.shape()[0] != keys.len() {
        return Err(PyValueError::new_err(format!("impulses: {} beside {} keys", impulses.shape()[0], keys.len())));
    }
    let (keys, impulses) = (keys.as_slice()?, impulses.as_slice()?);
    py.detach(|| lock(kept).engine.start(keys, impulses)).map_err(|error| value_error(&error))
}

/// A kernel is whole after a panic: the next scene is filled in anew.
fn lock<T>(kept: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    kept.lock().unwrap_or_else(PoisonError::into_inner)
}
