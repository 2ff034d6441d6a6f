//! All contestants on one scene, and what the pictures and tables ask of them.

use crate::contestant::Id;
use crate::measure::{self, Patience, Run};
use crate::sizes;
use testbed::scene_file::SceneFile;

/// Errors at which times are compared.
pub(crate) const LEVELS: [f64; 3] = [1e-3, 1e-6, 1e-9];

pub(crate) struct Race {
    pub(crate) scene: SceneFile,
    pub(crate) runs: Vec<Run>,
}

/// Tolerances asked for, two a decade from 1e-1 to 1e-12.
fn ladder() -> Vec<f64> {
    let exponents = (2..=24).map(|half_decades| -0.5 * f64::from(half_decades));
    exponents.map(|exponent| 10_f64.powf(exponent)).collect()
}

impl Race {
    pub(crate) fn new(scene: SceneFile, patience: &Patience) -> Self {
        let entry = |id| Some((id, sizes::contestant(&scene, id)?));
        let entries = Id::ALL.into_iter().filter_map(entry).collect();
        Self { runs: measure::race(&scene, entries, &ladder(), patience), scene }
    }

    /// `None` where the contestant's number type cannot hold the scene.
    pub(crate) fn run(&self, id: Id) -> Option<&Run> {
        self.runs.iter().find(|run| run.id == id)
    }

    /// Least time (ns) to an error of at most this, the preparation added if asked for.
    pub(crate) fn time(&self, id: Id, error: f64, prepared: bool) -> Option<f64> {
        let run = self.run(id)?;
        let prepare = if prepared { run.prepare.least } else { 0.0 };
        Some(run.fastest(error)?.time.least + prepare)
    }
}

/// Geometric mean; `None` of nothing.
pub(crate) fn geometric_mean(values: &[f64]) -> Option<f64> {
    let sum: f64 = values.iter().map(|value| value.ln()).sum();
    (!values.is_empty()).then(|| (sum / values.len() as f64).exp())
}
