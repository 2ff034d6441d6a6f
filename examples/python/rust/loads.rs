//! What a solution bears.

use crate::arrays::Arrays;
use crate::solve::{SettingsArguments, settings};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use stiction::Settings;
use stiction_kernels::derivative;
use stiction_kernels::loads::Asked;

/// Tells what a solution with these impulses of contacts and of joint rows bears: its least impulses (their momentum error, those of contacts, those of
/// joint rows), or one number, a reserve. `asked` has the name of the question, the speed of what is still, the accuracy, and a further load.
#[pyfunction]
pub(crate) fn bear<'py>(
    py: Python<'py>,
    scene: &Bound<'py, PyTuple>,
    given: SettingsArguments<'py>,
    impulses: (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>),
    asked: (&str, f64, f64, PyReadonlyArray1<'py, f64>),
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let arrays = Arrays::<f64>::new(scene, false)?;
    let (name, still, accuracy, load) = asked;
    let settings = Settings { still, ..settings::<f64>(&given)? };
    let load = load.as_slice()?;
    let asked = match name {
        "least" => Asked::Least,
        "slip" => Asked::SlipReserve(accuracy),
        "load" => Asked::LoadReserve(accuracy, load),
        _ => Asked::RestReserve(accuracy),
    };
    if name == "load" && load.len() != arrays.n {
        return Err(PyValueError::new_err(format!("load: shape [{}] is not [{}]", load.len(), arrays.n)));
    }
    let problem = arrays.problem(0);
    let (contacts, rows) = (impulses.0.as_slice()?, impulses.1.as_slice()?);
    let found = py.detach(|| derivative::bear(&problem, &settings, [contacts, rows], &asked));
    let found = found.map_err(PyValueError::new_err)?;
    let found = found.ok_or_else(|| PyValueError::new_err("solution: it was not solved"))?;
    Ok(PyArray1::from_vec(py, found))
}
