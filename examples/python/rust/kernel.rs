//! A kernel that keeps what a warm start needs.

use crate::arrays::Arrays;
use crate::arrays::Number;
use crate::solve::{Loaded, SettingsArguments, run, settings, solved, value_error};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::{Mutex, PoisonError};
use stiction_kernels::engine::Engine;
use stiction_kernels::problem::Needs;
use stiction_kernels::sizes::{self, Size};

/// A kernel of one number type.
struct Kept<T> {
    engine: Box<dyn Engine<T>>,
    /// The scene in it, if there is one.
    loaded: Option<Loaded>,
}

enum Either {
    Single(Mutex<Kept<f32>>),
    Double(Mutex<Kept<f64>>),
}

/// A kernel that keeps its last solve.
#[pyclass(frozen, module = "stiction._stiction")]
pub(crate) struct Kernel {
    size: Size,
    kept: Either,
}

#[pymethods]
impl Kernel {
    #[new]
    fn new(counts: [usize; 4], surfaces: bool, single: bool) -> PyResult<Self> {
        let [n, contacts, dim, rows] = counts;
        let surfaces = surfaces || dim > 3;
        let needs = Needs { n, dim, contacts, rows, surfaces };
        let (size, kept) = if single {
            let (size, kept) = kept(&needs)?;
            (size, Either::Single(kept))
        } else {
            let (size, kept) = kept(&needs)?;
            (size, Either::Double(kept))
        };
        Ok(Self { size, kept })
    }

    /// Its compiled size.
    #[getter]
    fn size(&self) -> (usize, usize, usize, usize, usize) {
        self.size.tuple()
    }

    fn solve<'py>(
        &self,
        py: Python<'py>,
        scene: &Bound<'py, PyTuple>,
        settings: SettingsArguments<'py>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        match &self.kept {
            Either::Single(kept) => self.warm(py, kept, scene, &settings),
            Either::Double(kept) => self.warm(py, kept, scene, &settings),
        }
    }

    fn resume<'py>(
        &self,
        py: Python<'py>,
        settings: SettingsArguments<'py>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        match &self.kept {
            Either::Single(kept) => resumed(py, kept, &settings),
            Either::Double(kept) => resumed(py, kept, &settings),
        }
    }

    fn reset(&self, py: Python<'_>) {
        match &self.kept {
            Either::Single(kept) => py.detach(|| lock(kept).engine.reset()),
            Either::Double(kept) => py.detach(|| lock(kept).engine.reset()),
        }
    }

    fn presume_rest(&self, py: Python<'_>) {
        match &self.kept {
            Either::Single(kept) => py.detach(|| lock(kept).engine.presume_rest()),
            Either::Double(kept) => py.detach(|| lock(kept).engine.presume_rest()),
        }
    }

    fn start(
        &self,
        py: Python<'_>,
        keys: PyReadonlyArray1<'_, u32>,
        impulses: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
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
        given: &SettingsArguments<'py>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let arrays = Arrays::<T>::new(scene, false)?;
        let (problem, size) = (arrays.problem(0), &self.size);
        if !size.holds(&problem.needs()) {
            let (n, dim, contacts, rows, surfaces) = size.tuple();
            return Err(PyValueError::new_err(format!(
                "scene: this kernel has room for {n} velocities, {contacts} contacts of {dim} rows, {rows} joint rows \
                 and {surfaces} contacts with coefficients by row or compliance; the scene has {} velocities, {} contacts of {} rows \
                 and {} joint rows",
                arrays.n, arrays.contacts, arrays.dim, arrays.rows
            )));
        }
        let loaded = arrays.loaded();
        let settings = settings(given)?;
        solved(py, |answer| {
            let mut kept = lock(kept);
            kept.loaded = None; // half a scene, if it is refused
            let mut out = answer.out(loaded.sizes);
            let outcome = run(kept.engine.as_mut(), &problem, &settings, &mut out)
                .map_err(|error| value_error(&error))?;
            kept.loaded = Some(loaded);
            Ok((loaded, outcome))
        })
    }
}

/// A kernel of the smallest compiled size that holds a scene.
fn kept<T: Number>(needs: &Needs) -> PyResult<(Size, Mutex<Kept<T>>)> {
    let index = sizes::index::<T>(needs).map_err(PyValueError::new_err)?;
    let (size, make) = T::sizes()[index];
    Ok((size, Mutex::new(Kept { engine: make(), loaded: None })))
}

fn resumed<'py, T: Number>(
    py: Python<'py>,
    kept: &Mutex<Kept<T>>,
    given: &SettingsArguments<'py>,
) -> PyResult<Bound<'py, PyTuple>> {
    let settings = settings(given)?;
    solved(py, |answer| {
        let mut kept = lock(kept); // once: another thread may load another scene
        let loaded = kept.loaded.ok_or_else(|| {
            PyValueError::new_err(
                "there is no scene to go on with: the last one was refused, or there was none",
            )
        })?;
        let outcome = kept.engine.solve(&settings, true);
        let outcome = outcome.map_err(|error| value_error(&error))?;
        kept.engine.read(&mut answer.out(loaded.sizes));
        Ok((loaded, outcome))
    })
}

fn start<T: Number>(
    py: Python<'_>,
    kept: &Mutex<Kept<T>>,
    keys: &PyReadonlyArray1<'_, u32>,
    impulses: &PyReadonlyArray2<'_, T>,
) -> PyResult<()> {
    if impulses.shape()[0] != keys.len() {
        return Err(PyValueError::new_err(format!(
            "impulses: {} beside {} keys",
            impulses.shape()[0],
            keys.len()
        )));
    }
    let (keys, impulses) = (keys.as_slice()?, impulses.as_slice()?);
    py.detach(|| lock(kept).engine.start(keys, impulses)).map_err(|error| value_error(&error))
}

/// A kernel is whole after a panic: the next scene is filled in anew.
fn lock<T>(kept: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    kept.lock().unwrap_or_else(PoisonError::into_inner)
}
