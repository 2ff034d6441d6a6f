//! Steps of MuJoCo's models with rigid contacts and Coulomb's law.
//!
//! The way of a step: `stepper`, which asks `outside`, MuJoCo (`ffi`), `touch` and `rows` for what there is, `islands` for what
//! belongs together, `velocity` and `position` for the two passes, and `end` for what was not foreseen.

mod crowd;
mod end;
mod engines;
mod facts;
mod ffi;
mod inertia;
mod islands;
mod outside;
mod pack;
mod position;
mod rows;
mod stepper;
mod sweeps;
mod touch;
mod velocity;

use ffi::{Data, Library, Model};
use pyo3::exceptions::{PyImportError, PyValueError};
use pyo3::prelude::*;
use std::path::PathBuf;
use stiction::Settings;

/// Steps one model; Python keeps the model alive.
#[pyclass(module = "stiction._stiction")]
pub(crate) struct Stepper {
    own: stepper::Stepper,
}

/// Status, error, work; contradicts, gave way; contacts left out.
type Report = (i64, f64, usize, bool, bool, usize);

#[pymethods]
impl Stepper {
    /// Takes the path of MuJoCo's library and the address of an `mjModel` of it.
    #[new]
    fn new(library: PathBuf, model: usize) -> PyResult<Self> {
        let library = Library::open(&library).map_err(PyImportError::new_err)?;
        // SAFETY: Python says so, and holds the model as long as this.
        #[allow(unsafe_code)]
        let model = unsafe { Model::new(library, model) };
        Ok(Self { own: stepper::Stepper::new(model) })
    }

    fn step1(&mut self, py: Python<'_>, data: usize) -> PyResult<()> {
        let mut data = self.data(data)?;
        py.detach(|| self.own.step1(&mut data));
        Ok(())
    }

    fn step2(&mut self, py: Python<'_>, data: usize, tolerance: f64, budget: usize) -> PyResult<Report> {
        let mut data = self.data(data)?;
        let settings = Settings { budget, ..Settings::new(tolerance) };
        let report = py.detach(|| self.own.step2(&mut data, &settings)).map_err(PyValueError::new_err)?;
        let ends = report.ends;
        Ok((ends.status as i64, ends.error, ends.work, ends.contradicts, ends.gave_way, report.left_out))
    }

    fn reset(&mut self) {
        self.own.reset();
    }

    /// What each contact of MuJoCo's list does; -1 of one that took no part.
    #[getter]
    fn modes(&self) -> Vec<i8> {
        self.own.modes.clone()
    }
}

impl Stepper {
    fn data(&self, address: usize) -> PyResult<Data> {
        // SAFETY: Python says so, and holds the data during the call.
        #[allow(unsafe_code)]
        let data = unsafe { Data::new(&self.own.model, address) };
        data.map_err(PyValueError::new_err)
    }
}
