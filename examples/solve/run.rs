//! Solves a scene, or the time steps of a sequence, with the smallest compiled size that holds it.

use crate::options::{Options, Precision, Start};
use std::time::Instant;
use stiction::Settings;
use testbed::kernel::{Answer, Kernel, Shape};
use testbed::measure::{self, Law};
use testbed::method::Method;
use testbed::mixed::MixedFile;
use testbed::mixed_measure;
use testbed::scene_file::SceneFile;

/// One solved scene.
pub(crate) struct Run {
    pub(crate) name: String,
    pub(crate) n_dof: usize,
    pub(crate) n_contacts: usize,
    pub(crate) dim: usize,
    /// Recomputed in f64.
    pub(crate) error: f64,
    pub(crate) prepare_ns: f64,
    pub(crate) solve_ns: f64,
    pub(crate) answer: Answer,
}

/// Solves a scene of contacts and joint rows from nothing.
pub(crate) fn solve_mixed(file: &MixedFile, options: &Options) -> Result<Vec<Run>, String> {
    if options.method != Method::Default {
        return Err(format!("{} solves contacts alone", options.method.name()));
    }
    let settings = Settings { budget: options.max_iterations, ..Settings::new(options.tolerance) };
    let (answer, times) = match options.precision {
        Precision::F64 => kernels_f64::solve_mixed(file, &settings, options.repeat)?,
        Precision::F32 => kernels_f32::solve_mixed(file, &settings, options.repeat)?,
    };
    Ok(vec![Run {
        name: file.name.clone(),
        n_dof: file.n_dof,
        n_contacts: file.n_contacts,
        dim: file.dim,
        error: mixed_measure::error(file, &answer.v, &answer.r, &answer.lambda),
        prepare_ns: times.prepare_ns,
        solve_ns: times.solve_ns,
        answer,
    }])
}

/// Solves scenes one after the other, each cold or each from the one before, or says why one cannot
/// be solved.
pub(crate) fn solve(scenes: &[SceneFile], start: Start, options: &Options) -> Result<Vec<Run>, String> {
    let Some(shape) = Shape::of_all(scenes) else {
        return Ok(Vec::new());
    };
    let mut kernel = match options.precision {
        Precision::F64 => kernels_f64::kernel(shape)?,
        Precision::F32 => kernels_f32::kernel(shape)?,
    };
    let mut runs = Vec::new();
    for scene in scenes {
        if start == Start::Cold {
            kernel.reset();
        }
        let run = solve_one(scene, &mut *kernel, options);
        runs.push(run.map_err(|error| format!("{}: {error}", scene.name))?);
    }
    Ok(runs)
}

fn solve_one(file: &SceneFile, kernel: &mut dyn Kernel, options: &Options) -> Result<Run, stiction::Error> {
    kernel.load(file)?;
    let method = options.method;
    let settings = Settings { budget: options.max_iterations, ..Settings::new(options.tolerance) };
    let (mut prepare_ns, mut solve_ns) = (f64::INFINITY, f64::INFINITY);
    kernel.keep(method);
    for _ in 0..options.repeat {
        let start = Instant::now();
        kernel.prepare(method)?;
        prepare_ns = prepare_ns.min(start.elapsed().as_secs_f64() * 1e9);

        kernel.rewind();
        let start = Instant::now();
        kernel.solve(method, &settings)?;
        solve_ns = solve_ns.min(start.elapsed().as_secs_f64() * 1e9);
    }
    let answer = kernel.answer();
    Ok(Run {
        name: file.name.clone(),
        n_dof: file.n_dof,
        n_contacts: file.n_contacts,
        dim: file.dim,
        error: measure::error(file, &answer.v, &answer.r, Law::Coulomb),
        prepare_ns,
        solve_ns,
        answer,
    })
}
