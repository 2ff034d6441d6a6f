//! The variants that the library has.

use crate::outcome::Outcome;
use stiction::{Error, Model, Settings, SlipUpdate, Status};
use testbed::kernel::{self, Kernel};
use testbed::measure::{self, Law};
pub(crate) use testbed::method::Method;
use testbed::scene_file::SceneFile;

/// What the tables call a method.
pub(crate) fn name(method: Method) -> &'static str {
    match method {
        Method::Plain => "plain ADMM",
        Method::Fast => "Algorithm 1",
        Method::Restart => "Algorithm 2",
        Method::Default => "default",
    }
}

/// The kernel with a scene and its factor.
fn prepared(file: &SceneFile, method: Method) -> Result<Box<dyn Kernel>, Error> {
    kernel::prepared(kernels_f64::kernel, file, method)
}

/// When `s` is updated.
#[derive(Clone, Copy)]
pub(crate) enum Update {
    EveryIteration,
    OuterLoop,
    /// `s = 0`, the convex relaxation.
    Never,
}

/// Solves a scene cold, with the default penalty; a Newton step counts as ten iterations.
pub(crate) fn solve(
    file: &SceneFile,
    method: Method,
    update: Update,
    tolerance: f64,
    budget: usize,
) -> Outcome {
    let (model, slip_update) = match update {
        Update::EveryIteration => (Model::Coulomb, SlipUpdate::EveryIteration),
        Update::OuterLoop => (Model::Coulomb, SlipUpdate::OuterLoop),
        Update::Never => (Model::ConvexRelaxation, SlipUpdate::EveryIteration),
    };
    let settings = Settings { budget, model, ..Settings::new(tolerance) };
    try_solve(file, method, slip_update, &settings).expect("bundled scenes are valid")
}

/// The default penalty `rho` of a scene.
pub(crate) fn penalty(file: &SceneFile) -> f64 {
    let kernel = prepared(file, Method::Restart).expect("bundled scenes are valid");
    kernel.penalty()
}

fn try_solve(
    file: &SceneFile,
    method: Method,
    slip_update: SlipUpdate,
    settings: &Settings<f64>,
) -> Result<Outcome, Error> {
    let mut kernel = prepared(file, method)?;
    kernel.set_slip_update(slip_update);
    kernel.solve(method, settings)?;
    let answer = kernel.answer();
    let error = |law| measure::error(file, &answer.v, &answer.r, law);
    let law = match settings.model {
        Model::ConvexRelaxation => Law::Relaxed,
        Model::Coulomb => Law::Coulomb,
    };
    let claimed = answer.status == Status::Solved;
    Ok(Outcome {
        solved: claimed && error(law) <= settings.tolerance,
        iterations: answer.work.total(),
        coulomb_error: error(Law::Coulomb),
        impulse: answer.r,
    })
}
