//! A step of MuJoCo: its list of constraints made a scene, and the solution made forces and an acceleration.

use crate::engine::Engine;
use crate::problem::{Answer, Dynamics, Friction, Needs, Outcome, Problem, Rows};
use crate::sizes;
use crate::solve::value_error;
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use stiction::{Error, Settings, Status};

/// `mjtConstraint`: what stands before the contacts. (Contacts are found by their own list.)
const EQUALITY: i32 = 0;
const LIMIT_JOINT: i32 = 3;
const LIMIT_TENDON: i32 = 4;

/// What stays the same as long as model and data do: `(qvel, qfrc_smooth, damping)`, views of length `nv`.
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

/// A contact that takes part.
#[derive(Clone, Copy)]
struct Listed {
    /// Its place in MuJoCo's list.
    index: usize,
    /// Its first row among the constraints, and how many it has.
    address: usize,
    dim: usize,
    /// Gap (m) behind MuJoCo's own margin.
    distance: f64,
}

/// The scene of a step, and the kernel for it, which grows if it has to.
#[pyclass(module = "stiction._stiction")]
pub(crate) struct Gather {
    nv: usize,
    /// Margins of joint and tendon limits as the model had them.
    margins: [Vec<f64>; 2],
    engine: Option<(usize, Box<dyn Engine<f64>>)>,
    needs: Needs,
    contacts: Vec<Listed>,
    /// Constraints that are joint rows.
    rows: Vec<usize>,
    scene: Scene,
    answer: Answer<f64>,
    modes: Vec<i8>,
}

/// The arrays of a scene.
#[derive(Default)]
struct Scene {
    mass: Vec<f64>,
    free_impulse: Vec<f64>,
    jacobian: Vec<f64>,
    offsets: Vec<f64>,
    round: Vec<f64>,
    shaped: Vec<f64>,
    keys: Vec<u32>,
    row_jacobian: Vec<f64>,
    row_offset: Vec<f64>,
    row_lower: Vec<f64>,
    row_upper: Vec<f64>,
    row_keys: Vec<u32>,
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
            nv,
            margins: [joint_margins, tendon_margins],
            engine: None,
            needs,
            contacts: Vec::new(),
            rows: Vec::new(),
            scene: Scene::default(),
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

    /// Solves a step and writes what MuJoCo goes on with. Returns status, error and total work, and whether penetrations
    /// contradicted each other, so that they were left as they are.
    #[allow(clippy::too_many_arguments)] // a step of MuJoCo is that
    fn step(
        &mut self,
        py: Python<'_>,
        metric: PyReadonlyArray1<'_, f64>,
        state: State<'_>,
        constraints: Constraints<'_>,
        contacts: Contacts<'_>,
        written: Written<'_>,
        numbers: (f64, f64, f64, f64),
        settings: (f64, usize),
    ) -> PyResult<(i64, f64, usize, bool)> {
        let ((step, look_ahead, recovery, closing), (tolerance, budget)) = (numbers, settings);
        let (mut qacc, mut qfrc, mut force) = written;
        let (qacc, qfrc, force) = (
            qacc.as_slice_mut()?,
            qfrc.as_slice_mut()?,
            force.as_slice_mut()?,
        );
        let velocity = state.0.as_slice()?;
        let jacobian = constraints.0.as_slice()?;
        let data = Step {
            nv: self.nv,
            h: step,
            recovery,
            closing,
            jacobian,
            kinds: constraints.1.as_slice()?,
            ids: constraints.2.as_slice()?,
            positions: constraints.3.as_slice()?,
            losses: constraints.4.as_slice()?,
            friction: contacts.5.as_array(),
            surface: contacts.6.as_array(),
            geoms: contacts.4.as_array(),
        };
        self.list(
            &data,
            contacts.0.as_array(),
            contacts.1.as_array(),
            contacts.2.as_array(),
            contacts.3.as_array(),
            look_ahead,
        )?;
        self.scene.dynamics(
            &data,
            metric.as_slice()?,
            velocity,
            state.1.as_slice()?,
            state.2.as_slice()?,
        );
        self.fill_rows(&data);
        let is_shaped = self.fill_contacts(&data);
        let settings = Settings {
            budget,
            ..Settings::new(tolerance)
        };
        self.needs.contacts = self.needs.contacts.max(self.contacts.len());
        self.needs.rows = self.needs.rows.max(self.rows.len());
        self.needs.surfaces |= is_shaped;
        let (outcome, contradicts) = py.detach(|| self.solve(is_shaped, &settings))?;
        self.write(&data, velocity, qacc, qfrc, force);
        Ok((
            outcome.status as i64,
            outcome.error,
            outcome.work.total(),
            contradicts,
        ))
    }
}

/// What a step reads.
struct Step<'a> {
    nv: usize,
    /// Time step (s).
    h: f64,
    /// The fastest at which a penetration is pushed out, and an equality closed (m/s, rad/s).
    recovery: f64,
    closing: f64,
    jacobian: &'a [f64],
    kinds: &'a [i32],
    ids: &'a [i32],
    positions: &'a [f64],
    losses: &'a [f64],
    friction: ArrayView2<'a, f64>,
    surface: ArrayView2<'a, f64>,
    geoms: ArrayView2<'a, i32>,
}

impl<'a> Step<'a> {
    /// Rows of the constraints' Jacobian.
    fn rows(&self, first: usize, count: usize) -> &'a [f64] {
        &self.jacobian[first * self.nv..(first + count) * self.nv]
    }

    /// The speed that closes a distance in the step; a penetration is pushed out no faster than `recovery`.
    fn offset(&self, distance: f64) -> f64 {
        (distance / self.h).max(-self.recovery)
    }
}

impl Scene {
    /// `M` with damping, and the free impulse `M v + h F`.
    fn dynamics(
        &mut self,
        data: &Step<'_>,
        metric: &[f64],
        velocity: &[f64],
        smooth: &[f64],
        damping: &[f64],
    ) {
        let nv = data.nv;
        self.mass.clear();
        self.mass.extend_from_slice(metric);
        self.free_impulse.clear();
        for i in 0..nv {
            self.mass[i * nv + i] += data.h * damping[i];
            let row = &self.mass[i * nv..][..nv];
            let momentum: f64 = row.iter().zip(velocity).map(|(m, v)| m * v).sum();
            self.free_impulse.push(momentum + data.h * smooth[i]);
        }
    }
}

impl Gather {
    /// Finds the contacts that take part: the nearest, if there are more than fit.
    fn list(
        &mut self,
        data: &Step<'_>,
        distances: ArrayView1<'_, f64>,
        margins: ArrayView1<'_, f64>,
        dims: ArrayView1<'_, i32>,
        addresses: ArrayView1<'_, i32>,
        look_ahead: f64,
    ) -> PyResult<()> {
        self.contacts.clear();
        self.modes.clear();
        self.modes.resize(dims.len(), -1);
        for (index, (&dim, &address)) in dims.iter().zip(addresses).enumerate() {
            if let (Ok(address), Ok(dim)) = (usize::try_from(address), usize::try_from(dim)) {
                let distance = distances[index] - (margins[index] - look_ahead);
                self.contacts.push(Listed {
                    index,
                    address,
                    dim,
                    distance,
                });
            }
        }
        self.rows.clear();
        let is_row = |kind: i32| kind <= LIMIT_TENDON;
        self.rows.extend(
            data.kinds
                .iter()
                .enumerate()
                .filter(|&(_, &kind)| is_row(kind))
                .map(|(row, _)| row),
        );
        if self.contacts.iter().any(|contact| contact.dim > 3) {
            self.needs.dim = 6;
        }
        let most = sizes::most_contacts(self.needs.dim);
        if self.contacts.len() > most {
            let touching = self
                .contacts
                .iter()
                .filter(|contact| contact.distance <= 0.0)
                .count();
            if touching > most {
                return Err(PyValueError::new_err(format!(
                    "{touching} contacts touch, at most {most} are compiled: use simpler geoms, exclude pairs, or add a line to rust/sizes.rs"
                )));
            }
            self.contacts
                .sort_by(|a, b| a.distance.total_cmp(&b.distance));
            self.contacts.truncate(most);
            self.contacts.sort_by_key(|contact| contact.index);
        }
        Ok(())
    }

    fn fill_rows(&mut self, data: &Step<'_>) {
        let scene = &mut self.scene;
        for list in [
            &mut scene.row_jacobian,
            &mut scene.row_offset,
            &mut scene.row_lower,
            &mut scene.row_upper,
        ] {
            list.clear();
        }
        scene.row_keys.clear();
        for &row in &self.rows {
            let (kind, id, position) = (data.kinds[row], data.ids[row], data.positions[row]);
            let of = |margins: &[f64]| {
                usize::try_from(id)
                    .ok()
                    .and_then(|id| margins.get(id).copied())
                    .unwrap_or(0.0)
            };
            let [joints, tendons] = &self.margins;
            let (offset, lower, upper) = match kind {
                EQUALITY => (
                    (position / data.h).clamp(-data.closing, data.closing),
                    f64::NEG_INFINITY,
                    f64::INFINITY,
                ),
                LIMIT_JOINT => (data.offset(position - of(joints)), 0.0, f64::INFINITY),
                LIMIT_TENDON => (data.offset(position - of(tendons)), 0.0, f64::INFINITY),
                _ => (0.0, -data.h * data.losses[row], data.h * data.losses[row]),
            };
            scene.row_jacobian.extend_from_slice(data.rows(row, 1));
            scene.row_offset.push(offset);
            scene.row_lower.push(lower);
            scene.row_upper.push(upper);
            scene
                .row_keys
                .push(u32::try_from(kind).unwrap_or(0) << 28 | u32::try_from(id).unwrap_or(0));
        }
    }

    /// Fills in the contacts; does a cone need more than one coefficient?
    fn fill_contacts(&mut self, data: &Step<'_>) -> bool {
        let (scene, dim, nv) = (&mut self.scene, self.needs.dim, self.nv);
        for list in [
            &mut scene.jacobian,
            &mut scene.offsets,
            &mut scene.round,
            &mut scene.shaped,
        ] {
            list.clear();
        }
        scene.keys.clear();
        let mut is_shaped = dim > 3;
        for (i, contact) in self.contacts.iter().enumerate() {
            scene
                .jacobian
                .extend_from_slice(data.rows(contact.address, contact.dim));
            scene.jacobian.resize((i + 1) * dim * nv, 0.0);
            scene.offsets.push(data.offset(contact.distance));
            // MuJoCo gives the speeds of surfaces along the tangents and about the normal.
            let surface = data.surface.row(contact.index);
            scene.offsets.extend(surface.iter().take(contact.dim - 1));
            scene.offsets.resize((i + 1) * dim, 0.0);
            let friction = data.friction.row(contact.index);
            scene.shaped.extend(friction.iter().take(contact.dim - 1));
            scene.shaped.resize((i + 1) * (dim - 1), 0.0);
            scene
                .round
                .push(if contact.dim > 1 { friction[0] } else { 0.0 });
            is_shaped |= contact.dim > 1 && friction[0].to_bits() != friction[1].to_bits();
            let geom =
                |side: usize| u32::try_from(data.geoms[[contact.index, side]]).unwrap_or(u32::MAX);
            scene.keys.push(geom(0) << 16 ^ geom(1));
        }
        is_shaped
    }

    /// Solves; if penetrations contradict each other, once more without pushing them out.
    fn solve(&mut self, is_shaped: bool, settings: &Settings<f64>) -> PyResult<(Outcome, bool)> {
        let index = sizes::index(&self.needs).map_err(PyValueError::new_err)?;
        if self.engine.as_ref().is_none_or(|&(own, _)| own != index) {
            self.engine = Some((index, sizes::engine(index)));
        }
        let Some((_, engine)) = &mut self.engine else {
            return Err(PyValueError::new_err("no kernel"));
        };
        let mut run = |scene: &Scene, answer: &mut Answer<f64>| -> Result<Outcome, Error> {
            let problem = scene.problem(self.nv, self.needs.dim, is_shaped);
            engine.load(&problem)?;
            let outcome = engine.solve(settings, false)?;
            engine.read(&mut answer.out([
                problem.n,
                problem.contacts(),
                problem.dim,
                problem.rows.lower.len(),
            ]));
            Ok(outcome)
        };
        let outcome = run(&self.scene, &mut self.answer).map_err(|error| value_error(&error))?;
        if outcome.status != Status::Infeasible {
            return Ok((outcome, false));
        }
        let scene = &mut self.scene;
        for offset in scene.offsets.iter_mut().step_by(self.needs.dim) {
            *offset = offset.max(0.0);
        }
        for (offset, lower) in scene.row_offset.iter_mut().zip(&scene.row_lower) {
            *offset = if *lower < 0.0 { 0.0 } else { offset.max(0.0) };
        }
        let outcome = run(&self.scene, &mut self.answer).map_err(|error| value_error(&error))?;
        Ok((outcome, true))
    }

    /// Writes acceleration and forces.
    fn write(
        &mut self,
        data: &Step<'_>,
        velocity: &[f64],
        qacc: &mut [f64],
        qfrc: &mut [f64],
        force: &mut [f64],
    ) {
        let (answer, dim) = (&self.answer, self.needs.dim);
        for (acceleration, (after, before)) in qacc.iter_mut().zip(answer.v.iter().zip(velocity)) {
            *acceleration = (after - before) / data.h;
        }
        force.fill(0.0);
        for (&row, impulse) in self.rows.iter().zip(&answer.rows[0]) {
            force[row] = impulse / data.h;
        }
        for (i, contact) in self.contacts.iter().enumerate() {
            for (force, impulse) in force[contact.address..][..contact.dim]
                .iter_mut()
                .zip(&answer.r[i * dim..])
            {
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

impl Scene {
    fn problem(&self, n: usize, dim: usize, is_shaped: bool) -> Problem<'_, f64> {
        Problem {
            n,
            dim,
            dynamics: Dynamics::Mass(&self.mass, &self.jacobian, &self.free_impulse),
            offsets: &self.offsets,
            friction: if is_shaped {
                Friction::Shaped(&self.shaped)
            } else {
                Friction::Round(&self.round)
            },
            compliance: &[],
            keys: &self.keys,
            rows: Rows {
                jacobian: &self.row_jacobian,
                offset: &self.row_offset,
                lower: &self.row_lower,
                upper: &self.row_upper,
                compliance: &[],
                keys: &self.row_keys,
            },
        }
    }
}
