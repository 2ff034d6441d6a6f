//! How far things may move in a step, and margins that MuJoCo lists contacts and limits by.

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1};
use pyo3::prelude::*;

/// `(cvel, subtree_com, geom_xpos, qvel, ten_velocity)` of MuJoCo's data.
type Motion<'py> = (
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
);
/// Margins of geoms, bodies, pairs, joints and tendons.
type Margins<'py> = [PyReadwriteArray1<'py, f64>; 5];

/// The margins of a model as they were, and its geoms.
#[pyclass(module = "stiction._stiction")]
pub(crate) struct LookAhead {
    margins: [Vec<f64>; 5],
    /// Body, root of its tree and radius (m) of each geom.
    geoms: Vec<(usize, usize, f64)>,
    /// The two geoms of each pair.
    pairs: Vec<[usize; 2]>,
    /// What the margin of each geom grows by at least (m): a contact at rest is listed, whatever pushes it next.
    least: f64,
    /// What it has grown by (m), and the point velocities that this comes from (m/s).
    growth: Vec<f64>,
    speeds: Vec<([f64; 3], f64)>,
    /// Velocities at the end of the last step.
    velocity: Vec<f64>,
}

#[pymethods]
impl LookAhead {
    #[new]
    fn new(
        margins: [Vec<f64>; 5],
        geoms: Vec<(usize, usize, f64)>,
        pairs: Vec<[usize; 2]>,
        least: f64,
    ) -> Self {
        Self {
            margins,
            geoms,
            pairs,
            least,
            growth: Vec::new(),
            speeds: Vec::new(),
            velocity: Vec::new(),
        }
    }

    /// Remembers the velocities at the end of a step.
    fn keep(&mut self, velocity: PyReadonlyArray1<'_, f64>) -> PyResult<()> {
        self.velocity.clear();
        self.velocity.extend_from_slice(velocity.as_slice()?);
        Ok(())
    }

    /// Are these others than at the end of the last step?
    fn is_pushed(&self, velocity: PyReadonlyArray1<'_, f64>) -> PyResult<bool> {
        Ok(velocity.as_slice()? != self.velocity)
    }

    /// Sets the margins: of a geom, twice what it moves in a `step` (s) under `gravity` (m/s²), or half of `fixed` (m).
    fn set(
        &mut self,
        motion: Motion<'_>,
        margins: Margins<'_>,
        step: f64,
        gravity: PyReadonlyArray1<'_, f64>,
        fixed: Option<f64>,
    ) -> PyResult<()> {
        self.growth.clear();
        if let Some(fixed) = fixed {
            self.growth.resize(self.geoms.len(), 0.5 * fixed);
        } else {
            let fall = step * step * norm(gravity.as_slice()?) + self.least;
            self.grow(
                motion.0.as_slice()?,
                motion.1.as_slice()?,
                motion.2.as_slice()?,
                2.0 * step,
                fall,
            );
        }
        let largest = |speeds: &[f64]| {
            speeds
                .iter()
                .fold(0.0_f64, |most, speed| most.max(speed.abs()))
        };
        let (turn, pull) = (largest(motion.3.as_slice()?), largest(motion.4.as_slice()?));
        // What stands still may start to move: 1 rad/s, 1 m/s.
        let growths = [2.0 * step * (1.0 + turn), 2.0 * step * (1.0 + pull)];
        let [mut geoms, mut bodies, mut pairs, joints, tendons] = margins;
        let (geoms, bodies, pairs) = (
            geoms.as_slice_mut()?,
            bodies.as_slice_mut()?,
            pairs.as_slice_mut()?,
        );
        bodies.copy_from_slice(&self.margins[1]);
        for (geom, &growth) in self.growth.iter().enumerate() {
            geoms[geom] = self.margins[0][geom] + growth;
            let body = self.geoms[geom].0;
            bodies[body] = bodies[body].max(self.margins[1][body] + growth);
        }
        for ((target, own), &pair) in pairs.iter_mut().zip(&self.margins[2]).zip(&self.pairs) {
            *target = own + self.growth_of(pair);
        }
        for ((mut target, own), growth) in [joints, tendons]
            .into_iter()
            .zip(&self.margins[3..])
            .zip(growths)
        {
            for (target, own) in target.as_slice_mut()?.iter_mut().zip(own) {
                *target = own + growth;
            }
        }
        Ok(())
    }
}

impl LookAhead {
    /// How much the margin of a contact of two geoms has grown (m): MuJoCo adds those of both.
    pub(super) fn growth_of(&self, pair: [usize; 2]) -> f64 {
        pair.map(|geom| self.growth[geom]).into_iter().sum()
    }

    /// Grows each geom's margin by `time` (s) times its speed, and by `least` (m). Speeds are relative to the mean of what moves, which
    /// what stands still is then charged with: the sum over two geoms is no less than their speed to each other, and a robot
    /// that falls does not list its own limbs.
    fn grow(&mut self, motion: &[f64], com: &[f64], positions: &[f64], time: f64, least: f64) {
        self.speeds.clear();
        let (mut mean, mut count) = ([0.0; 3], 0.0);
        for (&(body, root, radius), position) in self.geoms.iter().zip(positions.as_chunks::<3>().0)
        {
            let [a, b, c, x, y, z] = motion.as_chunks::<6>().0[body];
            let com = com.as_chunks::<3>().0[root];
            let [p, q, r] = [
                position[0] - com[0],
                position[1] - com[1],
                position[2] - com[2],
            ];
            let speed = [x + b * r - c * q, y + c * p - a * r, z + a * q - b * p];
            let turn = norm(&[a, b, c]) * radius;
            if norm(&speed) + turn > 0.0 {
                count += 1.0;
                mean = std::array::from_fn(|i| mean[i] + (speed[i] - mean[i]) / count);
            }
            self.speeds.push((speed, turn));
        }
        let growths = self.speeds.iter().map(|(speed, turn)| {
            let [x, y, z] = std::array::from_fn(|i| speed[i] - mean[i]);
            time * (norm(&[x, y, z]) + turn) + least
        });
        self.growth.extend(growths);
    }
}

fn norm(vector: &[f64]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}
