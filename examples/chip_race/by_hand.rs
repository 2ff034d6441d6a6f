//! The loop by hand (`examples/embedded/gauss_seidel.rs`), with a fixed number of sweeps or with a test after every second.

use crate::gauss_seidel::GaussSeidel;
use crate::race::{C, Course, N, SHARING, run};
use crate::stack::stack_bytes;
use cortex_m_semihosting::hprintln;

/// `None` if something does not succeed.
#[inline(never)]
pub(crate) fn race(Course { step, push, before, counter }: Course<'_>) -> Option<()> {
    static mut SOLVER: GaussSeidel<f32, N, 3, C> = GaussSeidel::new(SHARING);
    #[allow(unsafe_code)]
    // SAFETY: called once, and no interrupt is enabled.
    let solver = unsafe { &mut *&raw mut SOLVER };
    let scene = &step.scene;
    let mut ok = true;
    run(counter, "prepare", 0, |_| ok &= solver.prepare(scene, push).is_some())?;
    for sweeps in (1..=40).chain([60, 100, 200, 400, 1000]) {
        for (label, warm) in [("cold", false), ("warm", true)] {
            if warm {
                // Impulses of the tick before, by as many sweeps.
                ok &= solver.prepare(scene, before).is_some();
                solver.reset();
                (0..2 * sweeps).for_each(|_| ok &= solver.sweep(scene).is_some());
                ok &= solver.prepare(scene, push).is_some();
            }
            run(counter, label, sweeps, |impulses| {
                if !warm {
                    solver.reset();
                }
                (0..sweeps).for_each(|_| ok &= solver.sweep(scene).is_some());
                *impulses = solver.impulse;
            })?;
        }
    }
    for (setting, tolerance) in [("1e-3", 1e-3_f32), ("1e-4", 1e-4), ("1e-5", 1e-5)] {
        run(counter, "tested_cold", setting, |impulses| {
            solver.reset();
            solver.solve(scene, tolerance, 1000);
            *impulses = solver.impulse;
        })?;
    }
    let stack = stack_bytes(|| {
        ok &= solver.prepare(scene, push).is_some();
        solver.reset();
        ok &= solver.sweep(scene).is_some();
    });
    hprintln!("bytes ram {}", size_of_val(scene) + size_of_val(solver));
    hprintln!("bytes stack {}", stack);
    ok.then_some(())
}
