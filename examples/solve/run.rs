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
    /// h, if the file says it (s).
    pub(crate) time_step: Option<f64>,
    /// Recomputed in f64.
    pub(crate) error: f64,
    pub(crate) prepare_ns: f64,
    pub(crate) solve_ns: f64,
    pub(crate) answer: Answer,
}

/// Solves scenes one after the other, each cold or each from the one before, or says why one cannot
/// be solved.
pub(crate) fn solve(files: &[MixedFile], start: Start, options: &Options) -> Result<Vec<Run>, String> {
    if files.iter().all(MixedFile::has_contacts_alone) {
        return solve_contacts(files, start, options);
    }
    if files.len() > 1 && start == Start::Warm {
        return Err(
            "a sequence with joint rows, compliance or shapes of friction is solved with --cold".into()
        );
    }
    files.iter().map(|file| solve_mixed(file, options)).collect()
}

/// Solves a scene of contacts and joint rows from nothing.
fn solve_mixed(file: &MixedFile, options: &Options) -> Result<Run, String> {
    if options.method != Method::Default {
        return Err(format!("{} solves contacts alone", options.method.name()));
    }
    let settings = Settings { budget: options.budget, ..Settings::new(options.tolerance) };
    let (answer, times) = match options.precision {
        Precision::F64 => kernels_f64::solve_mixed(file, &settings, options.repeat)?,
        #[cfg(feature = "f32")]
        Precision::F32 => kernels_f32::solve_mixed(file, &settings, options.repeat)?,
    };
    Ok(Run {
        name: file.name.clone(),
        n_dof: file.n_dof,
        n_contacts: file.n_contacts,
        dim: file.dim,
        time_step: file.time_step,
        error: mixed_measure::error(file, &answer.v, &answer.r, &answer.lambda),
        prepare_ns: times.prepare_ns,
        solve_ns: times.solve_ns,
        answer,
    })
}

fn solve_contacts(files: &[MixedFile], start: Start, options: &Options) -> Result<Vec<Run>, String> {
    let scenes = files.iter().map(SceneFile::of_file).collect::<Result<Vec<_>, _>>()?;
    let Some(shape) = Shape::of_all(&scenes) else {
        return Ok(Vec::new());
    };
    let mut kernel = match options.precision {
        Precision::F64 => kernels_f64::kernel(shape)?,
        #[cfg(feature = "f32")]
        Precision::F32 => kernels_f32::kernel(shape)?,
    };
    let mut runs = Vec::new();
    for (scene, file) in scenes.iter().zip(files) {
        if start == Start::Cold {
            kernel.reset();
        }
        let run = solve_one(scene, file.time_step, &mut *kernel, options);
        runs.push(run.map_err(|error| format!("{}: {error}", scene.name))?);
    }
    Ok(runs)
}

fn solve_one(
    file: &SceneFile,
    time_step: Option<f64>,
    kernel: &mut dyn Kernel,
    options: &Options,
) -> Result<Run, stiction::Error> {
    kernel.load(file)?;
    let method = options.method;
    let settings = Settings { budget: options.budget, ..Settings::new(options.tolerance) };
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
        time_step,
        error: measure::error(file, &answer.v, &answer.r, Law::Coulomb),
        prepare_ns,
        solve_ns,
        answer,
    })
}
