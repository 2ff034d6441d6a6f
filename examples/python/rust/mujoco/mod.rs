//! A step of MuJoCo: its list of constraints made a scene, and the solution made forces and an acceleration.

use crate::engine::Engine;
use crate::problem::{Answer, Needs, Outcome};
use crate::sizes;
use crate::solve::value_error;
use choice::Choice;
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use scene::{Scene, Step};
use stiction::{Error, Settings, Status};

mod choice;
mod look_ahead;
mod redundant;
mod scene;

pub(crate) use look_ahead::LookAhead;

/// `(qvel, qfrc_smooth, damping)`, of length `nv`.
type State<'py> = (
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
);
/// `(efc_J, efc_type, efc_id, efc_pos, efc_frictionloss)`.
type Constraints<'py> = (
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, i32>,
    PyReadonlyArray1<'py, i32>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
);
/// `(dist, includemargin, dim, efc_address, geom, friction, surfacevel)` of the contacts.
type Contacts<'py> = (
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, i32>,
    PyReadonlyArray1<'py, i32>,
    PyReadonlyArray2<'py, i32>,
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray2<'py, f64>,
);
/// `(qacc, qfrc_constraint, efc_force)`, to be written.
type Written<'py> = (
    PyReadwriteArray1<'py, f64>,
    PyReadwriteArray1<'py, f64>,
    PyReadwriteArray1<'py, f64>,
);

/// The scene of a step, and the kernel for it, which grows if it has to.
#[pyclass(module = "stiction._stiction")]
pub(crate) struct Gather {
    engine: Option<(usize, Box<dyn Engine<f64>>)>,
    needs: Needs,
    choice: Choice,
    scene: Scene,
    answer: Answer<f64>,
    modes: Vec<i8>,
}

#[pymethods]
impl Gather {
    #[new]
    fn new(nv: usize, joint_margins: Vec<f64>, tendon_margins: Vec<f64>) -> PyResult<Self> {
        let needs = Needs {
            n: nv,
            dim: 3,
            ..Needs::default()
        };
        sizes::index(&needs).map_err(PyValueError::new_err)?;
        Ok(Self {
            engine: None,
            needs,
            choice: Choice::default(),
            scene: Scene::new([joint_margins, tendon_margins]),
            answer: Answer::default(),
            modes: Vec::new(),
        })
    }

    /// Forgets the last solve.
    fn reset(&mut self) {
        if let Some((_, engine)) = &mut self.engine {
            engine.reset();
        }
    }

    /// What each contact of MuJoCo's list does; -1 of one that took no part.
    #[getter]
    fn modes(&self) -> Vec<i8> {
        self.modes.clone()
    }

    /// Solves a step and writes what MuJoCo goes on with. Returns status, error and total work; whether penetrations contradicted
    /// each other, so that they were left as they are; and how many contacts were reached for which there is no room.
    #[allow(clippy::too_many_arguments)] // a step of MuJoCo is that
    fn step(
        &mut self,
        py: Python<'_>,
        metric: PyReadonlyArray1<'_, f64>,
        state: State<'_>,
        constraints: Constraints<'_>,
        contacts: Contacts<'_>,
        written: Written<'_>,
        look_ahead: PyRef<'_, LookAhead>,
        numbers: (f64, f64, f64),
        settings: (f64, usize),
    ) -> PyResult<(i64, f64, usize, bool, usize)> {
        let ((h, recovery, closing), (tolerance, budget)) = (numbers, settings);
        let (mut qacc, mut qfrc, mut force) = written;
        let data = Step {
            nv: self.needs.n,
            h,
            recovery,
            closing,
            velocity: state.0.as_slice()?,
            smooth: state.1.as_slice()?,
            damping: state.2.as_slice()?,
            jacobian: constraints.0.as_slice()?,
            kinds: constraints.1.as_slice()?,
            ids: constraints.2.as_slice()?,
            positions: constraints.3.as_slice()?,
            losses: constraints.4.as_slice()?,
            geoms: contacts.4.as_array(),
            friction: contacts.5.as_array(),
            surface: contacts.6.as_array(),
        };
        let settings = Settings {
            budget,
            ..Settings::new(tolerance)
        };
        self.choice.list(
            contacts.0.as_array(),
            contacts.1.as_array(),
            contacts.2.as_array(),
            contacts.3.as_array(),
            data.geoms,
            &look_ahead,
        );
        if self.choice.needs_shapes() {
            self.needs.dim = 6;
        }
        self.choice
            .first(&data, sizes::most_contacts(self.needs.dim));
        self.scene.dynamics(&data, metric.as_slice()?);
        self.scene.fill_rows(&data);
        let (outcome, contradicts, left_out) =
            py.detach(|| self.solve_reached(&data, &settings))?;
        self.write(
            &data,
            qacc.as_slice_mut()?,
            qfrc.as_slice_mut()?,
            force.as_slice_mut()?,
        );
        let (status, work) = (outcome.status as i64, outcome.work.total());
        Ok((status, outcome.error, work, contradicts, left_out))
    }
}

impl Gather {
    /// Solves with the contacts that are chosen, and with others in their place as long as they are reached.
    fn solve_reached(
        &mut self,
        data: &Step<'_>,
        settings: &Settings<f64>,
    ) -> PyResult<(Outcome, bool, usize)> {
        loop {
            let is_shaped = self
                .scene
                .fill_contacts(data, self.choice.chosen(), self.needs.dim);
            self.needs.contacts = self.needs.contacts.max(self.choice.chosen().len());
            self.needs.rows = self.needs.rows.max(self.scene.rows());
            self.needs.surfaces |= is_shaped;
            let (outcome, contradicts) = self.solve(is_shaped, settings)?;
            let pushes = self
                .answer
                .r
                .iter()
                .step_by(self.needs.dim)
                .map(|&normal| normal > 0.0);
            let next = self.choice.next(data, &self.answer.v, pushes);
            if let Some(left_out) = next {
                return Ok((outcome, contradicts, left_out));
            }
        }
    }

    /// Solves; if penetrations contradict each other, once more without pushing them out.
    fn solve(&mut self, is_shaped: bool, settings: &Settings<f64>) -> PyResult<(Outcome, bool)> {
        let index = sizes::index(&self.needs).map_err(PyValueError::new_err)?;
        let engine = match &mut self.engine {
            Some((own, engine)) if *own == index => engine,
            place => &mut place.insert((index, sizes::engine(index))).1,
        };
        let Needs { n, dim, .. } = self.needs;
        let mut run = |scene: &Scene, answer: &mut Answer<f64>| -> Result<Outcome, Error> {
            let problem = scene.problem(n, dim, is_shaped);
            engine.load(&problem)?;
            let outcome = engine.solve(settings, false)?;
            engine.read(&mut answer.out([n, problem.contacts(), dim, scene.rows()]));
            Ok(outcome)
        };
        let mut outcome = run(&self.scene, &mut self.answer);
        let contradicts = matches!(
            outcome,
            Ok(Outcome {
                status: Status::Infeasible,
                ..
            })
        );
        if contradicts {
            self.scene.leave_penetrations(dim);
            outcome = run(&self.scene, &mut self.answer);
        }
        let outcome = outcome.map_err(|error| value_error(&error))?;
        Ok((outcome, contradicts))
    }

    /// Writes acceleration and forces.
    fn write(&mut self, data: &Step<'_>, qacc: &mut [f64], qfrc: &mut [f64], force: &mut [f64]) {
        let (answer, dim) = (&self.answer, self.needs.dim);
        let velocities = answer.v.iter().zip(data.velocity);
        for (acceleration, (after, before)) in qacc.iter_mut().zip(velocities) {
            *acceleration = (after - before) / data.h;
        }
        force.fill(0.0);
        for (&row, impulse) in self.scene.constraints.iter().zip(&answer.rows[0]) {
            force[row] = impulse / data.h;
        }
        self.modes.clear();
        self.modes.resize(data.geoms.nrows(), -1);
        for contact in self.choice.listed() {
            self.modes[contact.index] = 0;
        }
        for (i, contact) in self.choice.chosen().iter().enumerate() {
            let impulses = &answer.r[i * dim..][..contact.dim];
            for (force, impulse) in force[contact.address..].iter_mut().zip(impulses) {
                *force = impulse / data.h;
            }
            self.modes[contact.index] = answer.modes[i];
        }
        qfrc.fill(0.0);
        for (row, &force) in force.iter().enumerate().filter(|&(_, &force)| force != 0.0) {
            for (sum, entry) in qfrc.iter_mut().zip(data.rows(row, 1)) {
                *sum += force * entry;
            }
        }
    }
}
