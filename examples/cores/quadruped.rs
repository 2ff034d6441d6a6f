//! The scene of `examples/flash`: a quadruped on four feet.

use core::hint::black_box;
use nalgebra::SVector;
#[cfg(whole)]
use stiction::AllPhases as Chosen;
#[cfg(sweeps)]
use stiction::SweepsOnly as Chosen;
use stiction::{Factor, Scene, Settings, Solver};

static mut SCENE: Scene<f32, 18, 3, 4> = Scene::new();
static mut FACTOR: Factor<f32, 18, 3, 4> = Factor::empty();
static mut SOLVER: Solver<f32, 18, 3, 4, 0, Chosen> = Solver::with_phases(Chosen);

#[allow(unsafe_code)]
pub(crate) fn solve() -> bool {
    // SAFETY: it is called once.
    let (scene, factor, solver) =
        unsafe { (&mut *&raw mut SCENE, &mut *&raw mut FACTOR, &mut *&raw mut SOLVER) };
    let (scene, solver) = (black_box(scene), black_box(solver));
    let mut ok = factor.prepare(scene).is_ok();
    if ok {
        let (push, settings) = black_box((SVector::zeros(), Settings::default()));
        ok = black_box(solver.solve(scene, factor, &push, &settings)).is_ok();
    }
    ok
}
