//! Solves a scene by default settings, and has a stranger judge the answer.

use crate::kernel::{Constructor, Kernel, Shape};
use crate::measure::{self, Law};
use crate::method::Method;
use crate::scene_file::SceneFile;
use stiction::{Error, Settings, Status};

/// What the kernel said of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// "The error is below the tolerance."
    Solved,
    /// "It is not."
    Unsolved,
    /// "There is no solution", and how strong the proof is by [`measure::proof`].
    Infeasible { proof: f64 },
    /// "This scene cannot be computed with."
    Refused(Error),
}

/// The answer, and what it is worth.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    pub answer: Answer,
    /// Of the returned velocity and impulses, recomputed from the scene as the kernel has it.
    pub error: f64,
    /// Iterations, and ten for each Newton step.
    pub work: usize,
}

/// Settings with a budget that hardly any scene uses up, for those who want to know whether it can be solved at all.
#[must_use]
pub const fn patient(tolerance: f64) -> Settings<f64> {
    let mut settings = Settings::new(tolerance);
    settings.budget = 100_000;
    settings
}

/// Solves with [`patient`] settings; the smallest compiled size has to hold the scene.
pub fn solve(kernel: Constructor, file: &SceneFile, tolerance: f64) -> Outcome {
    let mut kernel = kernel(Shape::of(file)).expect("a size is compiled");
    judged(kernel.as_mut(), file, Method::Default, &patient(tolerance))
}

/// Solves with whatever the kernel keeps of its last solve.
pub fn judged(
    kernel: &mut dyn Kernel,
    file: &SceneFile,
    method: Method,
    settings: &Settings<f64>,
) -> Outcome {
    try_solve(kernel, file, method, settings).unwrap_or_else(|error| Outcome {
        answer: Answer::Refused(error),
        error: f64::INFINITY,
        work: 0,
    })
}

fn try_solve(
    kernel: &mut dyn Kernel,
    file: &SceneFile,
    method: Method,
    settings: &Settings<f64>,
) -> Result<Outcome, Error> {
    kernel.load(file)?;
    kernel.prepare(method)?;
    kernel.solve(method, settings)?;
    let answer = kernel.answer();
    Ok(Outcome {
        answer: match answer.status {
            Status::Solved => Answer::Solved,
            Status::Infeasible => Answer::Infeasible { proof: measure::proof(file, &answer.certificate) },
            _ => Answer::Unsolved,
        },
        error: measure::error(&kernel.rounded(file), &answer.v, &answer.r, Law::Coulomb),
        work: answer.work.total(),
    })
}
