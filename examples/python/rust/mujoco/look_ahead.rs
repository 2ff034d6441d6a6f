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
    /// Velocities at the end of the last step.
    velocity: Vec<f64>,
}

#[pymethods]
impl LookAhead {
    #[new]
    fn new(margins: [Vec<f64>; 5], geoms: Vec<(usize, usize, f64)>) -> Self {
        Self {
            margins,
            geoms,
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

    /// Sets the margins: twice what the fastest geom moves in a `step` (s) under `gravity` (m/s²), or `fixed` (m) for contacts.
    /// Returns how much those of contacts have grown (m).
    fn set(
        &self,
        motion: Motion<'_>,
        margins: Margins<'_>,
        step: f64,
        gravity: PyReadonlyArray1<'_, f64>,
        fixed: Option<f64>,
    ) -> PyResult<f64> {
        let reach = match fixed {
            Some(fixed) => fixed,
            None => {
                2.0 * step
                    * (self.fastest(
                        motion.0.as_slice()?,
                        motion.1.as_slice()?,
                        motion.2.as_slice()?,
                    ) + step * norm(gravity.as_slice()?))
            }
        };
        let largest = |speeds: &[f64]| {
            speeds
                .iter()
                .fold(0.0_f64, |most, speed| most.max(speed.abs()))
        };
        let (turn, pull) = (largest(motion.3.as_slice()?), largest(motion.4.as_slice()?));
        // A contact's margin is the sum of those of its geoms. What stands still may start to move: 1 rad/s, 1 m/s.
        let growths = [
            0.5 * reach,
            0.5 * reach,
            reach,
            2.0 * step * (1.0 + turn),
            2.0 * step * (1.0 + pull),
        ];
        for ((mut target, own), growth) in margins.into_iter().zip(&self.margins).zip(growths) {
            for (target, own) in target.as_slice_mut()?.iter_mut().zip(own) {
                *target = own + growth;
            }
        }
        Ok(reach)
    }
}

impl LookAhead {
    /// A bound on the speed of any point of a geom (m/s).
    fn fastest(&self, motion: &[f64], com: &[f64], positions: &[f64]) -> f64 {
        let mut fastest = 0.0_f64;
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
            fastest = fastest.max(norm(&speed) + norm(&[a, b, c]) * radius);
        }
        fastest
    }
}

fn norm(vector: &[f64]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}
