//! This crate: factor, and solves to three tolerances, cold and warm, of Coulomb's law and of its convex relaxation. Its solver, or its
//! [`stiction::AdmmSolver`].

use crate::race::{C, Course, N, SHARING, run};
use crate::stack::stack_bytes;
use cortex_m_semihosting::hprintln;
#[cfg(contestant = "admm")]
use stiction::{AdmmFactor as Factor, AdmmSolver as Solver};
#[cfg(not(contestant = "admm"))]
use stiction::{Factor, Solver};
use stiction::{Model, Scene, Settings, Surface};

/// Room for surfaces: compliance is one.
const S: usize = if SHARING.is_some() { C } else { 0 };

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
    scene.set_mass(step.scene.mass()).ok()?;
    for contact in step.scene.contacts() {
        if let Some(alpha) = SHARING {
            let surface = Surface { compliance: [alpha; 2], ..Surface::isotropic(contact.mu) };
            scene.push_on(contact, &surface).ok()?;
        } else {
            scene.push(contact).ok()?;
        }
    }
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
                        for (impulse, contact) in impulses.iter_mut().zip(&solution.contacts) {
                            *impulse = contact.impulse;
                        }
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
