//! Steps of MuJoCo's models with rigid contacts and Coulomb's law.
//!
//! The way of a step: `stepper`, which asks `outside`, MuJoCo (`ffi`), `touch` and `rows` for what there is, `islands` for what
//! belongs together, `velocity` and `position` for the two passes, and `end` for what was not foreseen.

mod asked;
mod creep;
mod crowd;
mod end;
mod engines;
mod facts;
mod ffi;
mod inertia;
mod islands;
mod locks;
mod outside;
mod pack;
mod position;
pub(crate) mod rollout;
mod rows;
mod settle;
mod softness;
mod state;
mod stepper;
mod sweeps;
mod tally;
mod touch;
mod velocity;

use ffi::{Data, Library, Model};
use pyo3::exceptions::{PyImportError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use softness::{Given, Springs};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stiction::Settings;
use tally::Tally;

/// Steps one model; Python keeps the model alive.
#[pyclass(module = "stiction._stiction")]
pub(crate) struct Stepper {
    own: stepper::Stepper,
    tally: Tally,
}

#[pymethods]
impl Stepper {
    /// Takes the path of MuJoCo's library, the address of an `mjModel` of it, and what of the model is soft.
    #[new]
    fn new(library: PathBuf, model: usize, soft: Given) -> PyResult<Self> {
        Ok(Self { own: opened(&library, model, Springs(soft))?, tally: Tally::default() })
    }

    /// Takes so many steps.
    fn step(&mut self, py: Python<'_>, data: usize, steps: usize, settings: (f64, usize)) -> PyResult<()> {
        self.run(py, data, |own, tally, data| {
            for _ in 0..steps {
                own.step1(data);
                tally.add(&own.step2(data, &settings_of(settings))?);
            }
            Ok(())
        })
    }

    /// How all steps have ended.
    #[getter]
    fn tally(&self) -> Tally {
        self.tally
    }

    #[setter]
    fn set_tally(&mut self, tally: Tally) {
        self.tally = tally;
    }

    /// From now on impulses are those at which solves end: the motion is differentiated with these.
    fn keep_impulses(&mut self) {
        self.own.keep_impulses();
    }

    fn step1(&mut self, py: Python<'_>, data: usize) -> PyResult<()> {
        self.run(py, data, |own, _, data| {
            own.step1(data);
            Ok(())
        })
    }

    fn step2(&mut self, py: Python<'_>, data: usize, settings: (f64, usize)) -> PyResult<()> {
        self.run(py, data, |own, tally, data| {
            tally.add(&own.step2(data, &settings_of(settings))?);
            Ok(())
        })
    }

    fn reset(&mut self) {
        self.own.reset();
    }

    /// What the next step takes from those before it; from here on this goes on as one that takes it over.
    fn state(&mut self) -> Vec<u64> {
        state::write(&mut self.own)
    }

    /// Goes on with the data of this address, or with any that is where it ended.
    fn set_state(&mut self, data: Option<usize>, state: Vec<u64>) -> PyResult<()> {
        let taken = state::read(&mut self.own, data.unwrap_or(0), &state);
        taken.ok_or_else(|| PyValueError::new_err("state: none of a stepper of this model"))
    }

    /// Was something soft in the last step?
    #[getter]
    fn is_soft(&self) -> bool {
        self.own.is_soft
    }

    /// What each contact of MuJoCo's list does; -1 of one that took no part.
    #[getter]
    fn modes(&self) -> Vec<i8> {
        self.own.modes.clone()
    }
}

impl Stepper {
    /// Runs without the interpreter's lock.
    fn run<R: Send>(
        &mut self,
        py: Python<'_>,
        address: usize,
        call: impl FnOnce(&mut stepper::Stepper, &mut Tally, &mut Data) -> Result<R, &'static str> + Send,
    ) -> PyResult<R> {
        // SAFETY: Python says so, and holds the data during the call.
        #[allow(unsafe_code)]
        let data = unsafe { Data::new(&self.own.model, address) };
        let (mut data, library) = (data.map_err(PyValueError::new_err)?, self.own.model.library());
        let (own, tally) = (&mut self.own, &mut self.tally);
        let done = py.detach(|| library.watched(|| call(own, tally, &mut data)));
        heard(done)
    }
}

/// What a call has brought: MuJoCo may have given up, and the Stepper may have refused.
fn heard<R>(done: Result<Result<R, &'static str>, String>) -> PyResult<R> {
    done.map_err(|said| PyRuntimeError::new_err(format!("MuJoCo: {said}")))?.map_err(PyValueError::new_err)
}

fn settings_of((tolerance, budget): (f64, usize)) -> Settings<f64> {
    Settings { budget, ..Settings::new(tolerance) }
}

/// Raises an `ImportError` if MuJoCo's library is of a version that is not known.
#[pyfunction]
pub(crate) fn check_version(library: PathBuf) -> PyResult<()> {
    open(&library).map(|_| ())
}

fn open(library: &Path) -> PyResult<Arc<Library>> {
    Library::open(library).map_err(PyImportError::new_err)
}

/// A stepper of the model of this address.
fn opened(library: &Path, model: usize, springs: Springs) -> PyResult<stepper::Stepper> {
    let library = open(library)?;
    // SAFETY: Python says so, and holds the model as long as this.
    #[allow(unsafe_code)]
    let model = unsafe { Model::new(Arc::clone(&library), model) };
    heard(library.watched(|| Ok(stepper::Stepper::new(model, springs))))
}
