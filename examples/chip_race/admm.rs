//! This crate's [`AdmmSolver`] on scenes that share out forces.

use crate::race::{C, Course, N, run};
use crate::scene::{S, copy, fill};
use crate::stack::stack_bytes;
use cortex_m_semihosting::hprintln;
use stiction::{AdmmFactor, AdmmSolver, Model, Scene, Settings};

/// `None` if something does not succeed.
#[inline(never)]
pub(crate) fn race(Course { step, push, before, counter }: Course<'_>) -> Option<()> {
    static mut SCENE: Scene<f32, N, 3, C, 0, S> = Scene::new();
    static mut FACTOR: AdmmFactor<f32, N, 3, C> = AdmmFactor::empty();
    static mut SOLVER: AdmmSolver<f32, N, 3, C> = AdmmSolver::new();
    #[allow(unsafe_code)]
    // SAFETY: called once, and no interrupt is enabled.
    let (scene, factor, solver) =
        unsafe { (&mut *&raw mut SCENE, &mut *&raw mut FACTOR, &mut *&raw mut SOLVER) };
    fill(scene, step)?;
    let mut ok = true;
    run(counter, "prepare", 0, |_| ok &= factor.prepare(scene).is_ok())?;
    for (setting, tolerance) in [("1e-3", 1e-3), ("1e-4", 1e-4), ("1e-5", 1e-5)] {
        let settings = Settings { model: Model::ConvexRelaxation, ..Settings::new(tolerance) };
        for (label, warm) in [("cold", false), ("warm", true)] {
            solver.reset();
            if warm {
                ok &= solver.solve(scene, factor, before, &settings).is_ok();
            }
            run(counter, label, setting, |impulses| {
                if let Ok(solution) = solver.solve(scene, factor, push, &settings) {
                    copy(solution, impulses);
                }
            })?;
        }
    }
    let settings = Settings { model: Model::ConvexRelaxation, ..Settings::new(1e-5) };
    solver.reset();
    let stack = stack_bytes(|| {
        ok &= factor.prepare(scene).is_ok() && solver.solve(scene, factor, push, &settings).is_ok()
    });
    hprintln!("bytes ram {}", size_of_val(scene) + size_of_val(factor) + size_of_val(solver));
    hprintln!("bytes stack {}", stack);
    ok.then_some(())
}
