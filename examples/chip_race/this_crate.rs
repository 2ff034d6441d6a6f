//! This crate: factor, and solves to three tolerances, cold and warm, of Coulomb's law and of its convex relaxation.

use crate::race::{C, Course, N, SHARING, run};
use crate::scene::{S, copy, fill};
use crate::stack::stack_bytes;
use cortex_m_semihosting::hprintln;
use stiction::{Factor, Model, Scene, Settings, Solver};

/// `None` if something does not succeed.
#[inline(never)]
pub(crate) fn race(Course { step, push, before, counter }: Course<'_>) -> Option<()> {
    static mut SCENE: Scene<f32, N, 3, C, 0, S> = Scene::new();
    static mut FACTOR: Factor<f32, N, 3, C> = Factor::empty();
    static mut SOLVER: Solver<f32, N, 3, C> = Solver::new();
    #[allow(unsafe_code)]
    // SAFETY: called once, and no interrupt is enabled.
    let (scene, factor, solver) =
        unsafe { (&mut *&raw mut SCENE, &mut *&raw mut FACTOR, &mut *&raw mut SOLVER) };
    fill(scene, step)?;
    let mut ok = true;
    run(counter, "prepare", 0, |_| ok &= factor.prepare(scene).is_ok())?;
    let models =
        [(["cold", "warm"], Model::Coulomb), (["convex_cold", "convex_warm"], Model::ConvexRelaxation)];
    let models = models.iter().skip(usize::from(SHARING.is_some()));
    for &(labels, model) in models {
        for (setting, tolerance) in [("1e-3", 1e-3), ("1e-4", 1e-4), ("1e-5", 1e-5)] {
            let settings = Settings { model, ..Settings::new(tolerance) };
            for (label, warm) in labels.into_iter().zip([false, true]) {
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
    }
    let settings = Settings::new(1e-5);
    solver.reset();
    let stack = stack_bytes(|| {
        ok &= factor.prepare(scene).is_ok() && solver.solve(scene, factor, push, &settings).is_ok()
    });
    hprintln!("bytes ram {}", size_of_val(scene) + size_of_val(factor) + size_of_val(solver));
    hprintln!("bytes stack {}", stack);
    ok.then_some(())
}
