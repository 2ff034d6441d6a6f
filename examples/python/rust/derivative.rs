//! Derivatives of one solution or of those of a batch.

use crate::arrays::Arrays;
use crate::batch::pool;
use crate::solve::{SettingsArguments, settings};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rayon::prelude::*;
use stiction_kernels::derivative::{Lengths, Way, differentiate};

/// The numbers that come out, and margin, whether impulses and velocity are unique, and the error of each scene.
type Answer<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// The fingerprint of a scene or of a batch, in single precision if it was solved in that.
#[pyfunction]
pub(crate) fn fingerprint(scenes: &Bound<'_, PyTuple>, is_batch: bool, single: bool) -> PyResult<u64> {
    Ok(Arrays::<f64>::new(scenes, is_batch)?.fingerprint(single))
}

/// Goes forward from changes of the data, or backward from weights of the solution, a line of numbers for each scene. Impulses are
/// those of the solutions, of contacts and of joint rows. `asked` are the numbers, and whether the way is backward.
#[pyfunction]
pub(crate) fn derivative<'py>(
    py: Python<'py>,
    scenes: &Bound<'py, PyTuple>,
    given: SettingsArguments<'py>,
    is_batch: bool,
    impulses: (PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>),
    asked: (PyReadonlyArray2<'py, f64>, bool),
    threads: usize,
) -> PyResult<Answer<'py>> {
    let (numbers, backward) = asked;
    let arrays = Arrays::<f64>::new(scenes, is_batch)?;
    let settings = settings::<f64>(&given)?;
    let lengths = Lengths { n: arrays.n, contacts: arrays.contacts, dim: arrays.dim, rows: arrays.rows };
    let (way, width, wide) = if backward {
        (Way::Adjoint, lengths.outputs(), lengths.inputs())
    } else {
        (Way::Forward, lengths.inputs(), lengths.outputs())
    };
    let own = lengths.contacts * lengths.dim;
    let (count, (contacts, rows)) = (numbers.shape()[0], &impulses);
    let fits = numbers.shape() == [count, width]
        && contacts.shape() == [count, own]
        && rows.shape() == [count, lengths.rows]
        && (arrays.lead == count || arrays.lead == 1);
    if !fits {
        return Err(PyValueError::new_err("solution: its arrays are no longer those that were solved"));
    }
    let (from, contacts, rows) = (numbers.as_slice()?, contacts.as_slice()?, rows.as_slice()?);
    let (mut to, mut facts) = (vec![0.0; count * wide], vec![0.0; count * 4]);
    let problems: Vec<_> = (0..count).map(|scene| arrays.problem(scene)).collect();
    let one = |scene: usize, to: &mut [f64], facts: &mut [f64]| {
        let found = differentiate(
            &problems[scene],
            &settings,
            [line(contacts, own, scene), line(rows, lengths.rows, scene)],
            (way, line(from, width, scene), to),
        )?;
        let flag = |is: bool| f64::from(u8::from(is));
        let (impulses, velocity) = (flag(found.unique_impulses), flag(found.unique_velocity));
        facts.copy_from_slice(&[found.margin, impulses, velocity, found.error]);
        Ok(())
    };
    let done: PyResult<Result<(), String>> = py.detach(|| {
        let (places, of_each) = (to.chunks_exact_mut(wide.max(1)), facts.chunks_exact_mut(4));
        let mut tasks: Vec<_> = places.zip(of_each).enumerate().collect();
        if threads == 1 {
            return Ok(tasks.iter_mut().try_for_each(|(scene, (to, facts))| one(*scene, to, facts)));
        }
        let pool = pool(threads)?;
        Ok(pool.install(|| tasks.par_iter_mut().try_for_each(|(scene, (to, facts))| one(*scene, to, facts))))
    });
    done?.map_err(PyValueError::new_err)?;
    let table =
        |numbers: &[f64], width: usize| numpy::PyArray1::from_slice(py, numbers).reshape([count, width]);
    Ok((table(&to, wide)?, table(&facts, 4)?))
}

/// The numbers of a scene among those of all.
fn line(all: &[f64], length: usize, scene: usize) -> &[f64] {
    &all[scene * length..][..length]
}
