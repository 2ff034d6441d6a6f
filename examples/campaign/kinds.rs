//! What is drawn beside scenes of contacts alone, each solved once from nothing.

use super::Precision;
use crate::tally::Verdict;
use clap::ValueEnum;
use testbed::generate::{self, Class, Existence};
use testbed::kernel::Shape;
use testbed::method::Method;
use testbed::mixed::MixedFile;
use testbed::scene_file::SceneFile;
use testbed::solve::{Answer, Outcome, judged, patient};
use testbed::{kernel, mixed_measure};

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
    /// Scenes of contacts alone, solved from nothing, class by class
    Contacts,
    /// Contacts, compliance, shapes of friction and joint rows
    Mixed,
    /// The same with limits that are given to the solve
    Limits,
    /// Scenes of contacts alone, by `AdmmSolver`
    Admm,
    /// Contacts that come, go and change places, five solves in a row
    Warm,
    /// Contacts and joint rows that do so
    WarmMixed,
}

/// A verdict and the work of each solve.
pub(crate) type Findings = Vec<(Verdict, f64, usize)>;

impl Kind {
    /// Draws a scene, solves it, and says what the answers are worth.
    pub(crate) fn try_out(self, precision: Precision, (seed, index): (u64, u64), tolerance: f64) -> Findings {
        let class = Class::ALL[usize::try_from(index).unwrap_or(0) % Class::ALL.len()];
        match self {
            Self::Mixed | Self::Limits => {
                let file = generate::mixed(seed, index, self == Self::Mixed);
                mixed(precision, &[file], tolerance)
            }
            Self::WarmMixed => mixed(precision, &generate::time_steps(seed, index), tolerance),
            Self::Contacts | Self::Admm => {
                let (scene, existence) = generate::draw(class, seed, index);
                let method = if self == Self::Admm { Method::Restart } else { Method::Default };
                contacts(precision, method, &[scene], existence, tolerance)
            }
            Self::Warm => {
                let (steps, existence) = generate::steps(class, seed, index);
                contacts(precision, Method::Default, &steps, existence, tolerance)
            }
        }
    }
}

fn worth(outcome: &Outcome, existence: Existence, tolerance: f64) -> (Verdict, f64, usize) {
    let verdict = Verdict::new(outcome, existence, tolerance);
    (verdict, outcome.error, outcome.work)
}

fn contacts(
    precision: Precision,
    method: Method,
    steps: &[SceneFile],
    existence: Existence,
    tolerance: f64,
) -> Findings {
    let constructor: kernel::Constructor = match precision {
        Precision::F64 => kernels_f64::kernel,
        Precision::F32 => kernels_f32::kernel,
    };
    let shape = Shape::of_all(steps).expect("a step");
    let mut kernel = constructor(shape).expect("a size is compiled");
    let mut settings = patient(tolerance);
    settings.budget = 2_000;
    let solve = |step: &SceneFile| {
        let outcome = judged(kernel.as_mut(), step, method, &settings);
        worth(&outcome, existence, tolerance)
    };
    steps.iter().map(solve).collect()
}

fn mixed(precision: Precision, steps: &[MixedFile], tolerance: f64) -> Findings {
    let mut settings = patient(tolerance);
    settings.budget = 2_000;
    let (answers, held) = match precision {
        Precision::F64 => (kernels_f64::solve_all(steps, &settings), steps.to_vec()),
        Precision::F32 => {
            (kernels_f32::solve_all(steps, &settings), steps.iter().map(MixedFile::rounded::<f32>).collect())
        }
    };
    let pairs = answers.into_iter().zip(&held);
    let found = pairs.map(|(answer, file)| {
        let Ok(answer) = answer else {
            return (Verdict::Refused, f64::INFINITY, 0);
        };
        let error = mixed_measure::error(file, &answer.v, &answer.r, &answer.lambda);
        let is_proved = || {
            let (normals, joints) = (&answer.certificate, &answer.certificate_lambda);
            mixed_measure::proves(file, normals, joints)
        };
        let outcome = Outcome {
            answer: match answer.status {
                stiction::Status::Solved => Answer::Solved,
                // In single precision a proof is what rounding leaves of one.
                stiction::Status::Infeasible => Answer::Infeasible {
                    proof: if precision == Precision::F32 || is_proved() { f64::INFINITY } else { 0.0 },
                },
                _ => Answer::Unsolved,
            },
            error,
            work: answer.work.total(),
        };
        worth(&outcome, Existence::Unknown, tolerance)
    });
    found.collect()
}
