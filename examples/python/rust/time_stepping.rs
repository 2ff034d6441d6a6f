//! The helpers of a time step: their fields read from Python's dataclasses of the same names, their numbers computed by the library.

use nalgebra::SVector;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use stiction::time_stepping::{ClosedLoop, DryFriction, Gap, Motor, Parameter, Restitution, Spring, Suction};
use stiction::{Error, JointRow, RowLaw};

/// Offset, least and largest impulse, and compliance of a joint row.
type Row = (f64, f64, f64, f64);

/// The number of an argument, or of a field.
fn number(name: &str, given: &Bound<'_, PyAny>) -> PyResult<f64> {
    given.extract().map_err(|error| PyValueError::new_err(format!("{name}: {error}")))
}

fn field(of: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    number(name, &of.getattr(name)?)
}

/// The number, or an error that begins with the field or argument that it speaks of.
fn found<T>(found: Result<T, Error>) -> PyResult<T> {
    found.map_err(|error| {
        let name = match error {
            Error::InvalidParameter { parameter } => match parameter {
                Parameter::Gap | Parameter::Distance => "distance",
                Parameter::Drift => "drift",
                Parameter::Recovery => "recovery",
                Parameter::Reach => "reach",
                Parameter::Restitution => "coefficient",
                Parameter::Approach => "approach",
                Parameter::Threshold => "threshold",
                Parameter::GapOffset => "gap_offset",
                Parameter::Torque => "torque",
                Parameter::MotorStiffness | Parameter::MotorGains | Parameter::Stiffness => "stiffness",
                Parameter::MotorDamping => "damping",
                Parameter::Feedforward => "feedforward",
                Parameter::TorqueLimit => "limit",
                Parameter::Ahead => "ahead",
                Parameter::Target => "target",
                Parameter::Relaxation => "relaxation",
                Parameter::Suction => "force",
                _ => "step",
            },
            _ => "row",
        };
        PyValueError::new_err(format!("{name}: {error}"))
    })
}

fn gap(of: &Bound<'_, PyAny>) -> PyResult<Gap<f64>> {
    Ok(Gap { distance: field(of, "distance")?, recovery: field(of, "recovery")?, reach: field(of, "reach")? })
}

fn spring(of: &Bound<'_, PyAny>) -> PyResult<Spring<f64>> {
    Ok(Spring { stiffness: field(of, "stiffness")?, relaxation: field(of, "relaxation")? })
}

fn suction(of: &Bound<'_, PyAny>) -> PyResult<Suction<f64>> {
    Ok(Suction { force: field(of, "force")?, touches: of.getattr("touches")?.is_truthy()? })
}

/// What Python keeps of a row beside its vector, which has no entries here.
fn row(made: Result<JointRow<f64, 0>, Error>) -> PyResult<Row> {
    let made = found(made)?;
    let (lower, upper) = match made.law {
        RowLaw::Limit => (0.0, f64::INFINITY),
        RowLaw::Equality => (-f64::INFINITY, f64::INFINITY),
        RowLaw::Box { lower, upper } => (lower, upper),
    };
    Ok((made.offset, lower, upper, made.compliance))
}

#[pyfunction]
fn gap_offset(of: &Bound<'_, PyAny>, step: &Bound<'_, PyAny>) -> PyResult<f64> {
    found(gap(of)?.offset(number("step", step)?))
}

#[pyfunction]
fn gap_row(of: &Bound<'_, PyAny>, step: &Bound<'_, PyAny>) -> PyResult<Row> {
    row(gap(of)?.row(SVector::zeros(), number("step", step)?, 0))
}

#[pyfunction]
fn dry_friction_row(of: &Bound<'_, PyAny>, step: &Bound<'_, PyAny>) -> PyResult<Row> {
    let friction = DryFriction { torque: field(of, "torque")? };
    row(friction.row(SVector::zeros(), number("step", step)?, 0))
}

#[pyfunction]
fn motor_row(of: &Bound<'_, PyAny>, step: &Bound<'_, PyAny>) -> PyResult<Row> {
    let motor = Motor {
        stiffness: field(of, "stiffness")?,
        damping: field(of, "damping")?,
        feedforward: field(of, "feedforward")?,
        limit: field(of, "limit")?,
        ahead: field(of, "ahead")?,
        target: field(of, "target")?,
    };
    row(motor.row(SVector::zeros(), number("step", step)?, 0))
}

#[pyfunction]
fn closed_loop_row(of: &Bound<'_, PyAny>, step: &Bound<'_, PyAny>) -> PyResult<Row> {
    let closed = ClosedLoop { drift: field(of, "drift")?, recovery: field(of, "recovery")? };
    row(closed.row(SVector::zeros(), number("step", step)?, 0))
}

#[pyfunction]
fn restitution_offset(
    of: &Bound<'_, PyAny>,
    approach: &Bound<'_, PyAny>,
    gap_offset: &Bound<'_, PyAny>,
) -> PyResult<f64> {
    let bounce = Restitution { coefficient: field(of, "coefficient")?, threshold: field(of, "threshold")? };
    found(bounce.offset(number("approach", approach)?, number("gap_offset", gap_offset)?))
}

#[pyfunction]
fn spring_compliance(of: &Bound<'_, PyAny>, step: &Bound<'_, PyAny>) -> PyResult<f64> {
    found(spring(of)?.compliance(number("step", step)?))
}

#[pyfunction]
fn spring_offset(of: &Bound<'_, PyAny>, near: &Bound<'_, PyAny>, step: &Bound<'_, PyAny>) -> PyResult<f64> {
    found(spring(of)?.offset(&gap(near)?, number("step", step)?))
}

/// The free impulse without the pull, of which the normal row of the contact tells the direction. Both have a length.
#[pyfunction]
fn suction_push_back<'py>(
    of: &Bound<'py, PyAny>,
    normal: PyReadonlyArray1<'py, f64>,
    step: &Bound<'py, PyAny>,
    free_impulse: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (cup, step) = (suction(of)?, number("step", step)?);
    let mut pushed = free_impulse.as_slice()?.to_vec();
    for (impulse, &entry) in pushed.iter_mut().zip(normal.as_slice()?) {
        let mut one = SVector::from([*impulse]); // a velocity of the contact
        found(cup.push_back(&SVector::from([entry]), step, &mut one))?;
        *impulse = one.x;
    }
    Ok(PyArray1::from_vec(of.py(), pushed))
}

/// The normal impulse of a contact that pulls.
#[pyfunction]
fn suction_impulse(of: &Bound<'_, PyAny>, solved: f64, step: &Bound<'_, PyAny>) -> PyResult<f64> {
    let impulse = suction(of)?.impulse(&SVector::from([solved]), number("step", step)?);
    Ok(found(impulse)?.x)
}

/// Columns of the frame of a contact with a normal of two or three coordinates, one after the other.
#[pyfunction]
fn contact_frame<'py>(
    python: Python<'py>,
    normal: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let frame = match *normal.as_slice()? {
        [x, y] => stiction::contact_frame(&SVector::from([x, y])).map(|frame| frame.as_slice().to_vec()),
        [x, y, z] => {
            stiction::contact_frame(&SVector::from([x, y, z])).map(|frame| frame.as_slice().to_vec())
        }
        _ => return Err(PyValueError::new_err("normal: it has not two or three coordinates")),
    };
    let frame = frame.map_err(|error| PyValueError::new_err(format!("normal: {error}")))?;
    Ok(PyArray1::from_vec(python, frame))
}

pub(crate) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(gap_offset, module)?)?;
    module.add_function(wrap_pyfunction!(gap_row, module)?)?;
    module.add_function(wrap_pyfunction!(dry_friction_row, module)?)?;
    module.add_function(wrap_pyfunction!(motor_row, module)?)?;
    module.add_function(wrap_pyfunction!(closed_loop_row, module)?)?;
    module.add_function(wrap_pyfunction!(restitution_offset, module)?)?;
    module.add_function(wrap_pyfunction!(spring_compliance, module)?)?;
    module.add_function(wrap_pyfunction!(spring_offset, module)?)?;
    module.add_function(wrap_pyfunction!(suction_push_back, module)?)?;
    module.add_function(wrap_pyfunction!(suction_impulse, module)?)?;
    module.add_function(wrap_pyfunction!(contact_frame, module)?)
}
