//! The variants that the library has.

use crate::outcome::Outcome;
use stiction::{Error, Settings, SlipUpdate, Status};
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
fn prepared(file: &SceneFile) -> Result<Box<dyn Kernel>, Error> {
    kernel::prepared(kernels_f64::kernel, file, true)
}

/// Solves a scene cold, with the default penalty; a Newton step counts as ten iterations.
pub(crate) fn solve(file: &SceneFile, method: Method, settings: &Settings<f64>) -> Outcome {
    try_solve(file, method, settings).expect("bundled scenes are valid")
}

/// The default penalty `rho` of a scene.
pub(crate) fn penalty(file: &SceneFile) -> f64 {
    let kernel = prepared(file).expect("bundled scenes are valid");
    kernel.penalty()
}

fn try_solve(file: &SceneFile, method: Method, settings: &Settings<f64>) -> Result<Outcome, Error> {
    let mut kernel = prepared(file)?;
    kernel.solve(method, settings)?;
    let answer = kernel.answer();
    let error = |law| measure::error(file, &answer.v, &answer.r, law);
    let law = match settings.slip {
        SlipUpdate::Never => Law::Relaxed,
        _ => Law::Coulomb,
    };
    let claimed = answer.status == Status::Solved;
    Ok(Outcome {
        solved: claimed && error(law) <= settings.tolerance,
        iterations: answer.work.total(),
        coulomb_error: error(Law::Coulomb),
        impulse: answer.r,
    })
}
