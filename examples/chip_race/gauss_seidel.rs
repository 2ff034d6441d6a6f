//! Projected Gauss-Seidel, what a firmware engineer writes first, with a fixed number of sweeps or with a test after each.

use crate::counter::Counter;
use crate::race::{C, Impulses, N, Push, SHARING, run};
use crate::records::Step;
use crate::stack::stack_bytes;
use cortex_m_semihosting::hprintln;
use nalgebra::{SMatrix, SVector};
use stiction::{FrictionCone, Real, Scene};

struct GaussSeidel {
    /// `M⁻¹ H_iᵀ`
    response: [SMatrix<f32, N, 3>; C],
    /// Diagonal of `W`, inverted; the tangents share the larger entry.
    normal: [f32; C],
    tangent: [f32; C],
    /// `1 / trace(W_ii)`
    step: [f32; C],
    impulse: Impulses,
    /// Velocities without impulses, and with them.
    free: Push,
    velocity: Push,
}

/// Compliance, 0 where there is none.
const ALPHA: f32 = match SHARING {
    Some(alpha) => alpha,
    None => 0.0,
};

impl GaussSeidel {
    const fn new() -> Self {
        let zeros = nalgebra::ArrayStorage([[0.0; N]; 3]);
        let impulse = nalgebra::ArrayStorage([[0.0; 3]; 1]);
        let velocity = SVector::from_array_storage(nalgebra::ArrayStorage([[0.0; N]; 1]));
        Self {
            response: [SMatrix::from_array_storage(zeros); C],
            normal: [0.0; C],
            tangent: [0.0; C],
            step: [0.0; C],
            impulse: [SVector::from_array_storage(impulse); C],
            free: velocity,
            velocity,
        }
    }

    /// `M⁻¹ Hᵀ`, its diagonals, and the velocity without impulses.
    fn prepare(&mut self, scene: &Scene<f32, N, 3, C>, push: &Push) -> Option<()> {
        let cholesky = scene.mass().cholesky()?;
        self.free = cholesky.solve(push);
        for (i, contact) in scene.contacts().iter().enumerate() {
            let response = cholesky.solve(&contact.jacobian.transpose());
            let diagonal = (contact.jacobian * response).diagonal().add_scalar(ALPHA);
            *self.normal.get_mut(i)? = 1.0 / diagonal[0];
            *self.tangent.get_mut(i)? = 1.0 / diagonal[1].max(diagonal[2]);
            *self.step.get_mut(i)? = 1.0 / diagonal.sum();
            *self.response.get_mut(i)? = response;
        }
        Some(())
    }

    /// Of the impulses at hand, or of none.
    fn start(&mut self, warm: bool) {
        self.velocity = self.free;
        for (impulse, response) in self.impulse.iter_mut().zip(&self.response) {
            if warm {
                self.velocity += response * *impulse;
            } else {
                *impulse = SVector::zeros();
            }
        }
    }

    /// Normal impulse to zero normal velocity, tangential one to zero slip, clamped to the cone. With compliance a projected
    /// step, for the convex model.
    fn sweep(&mut self, scene: &Scene<f32, N, 3, C>) {
        let state = self.impulse.iter_mut().zip(&self.response);
        let steps = self.normal.iter().zip(&self.tangent).zip(&self.step);
        for ((contact, (r, response)), ((&normal, &tangent), &step)) in
            scene.contacts().iter().zip(state).zip(steps)
        {
            let u = contact.jacobian * self.velocity + contact.offset + *r * ALPHA;
            let next = if SHARING.is_some() {
                let cone = FrictionCone::new(contact.mu).unwrap_or(FrictionCone::frictionless());
                cone.project(&(*r - u * step))
            } else {
                let mut next = SVector::from([
                    (r[0] - u[0] * normal).max(0.0),
                    r[1] - u[1] * tangent,
                    r[2] - u[2] * tangent,
                ]);
                let limit = contact.mu * next[0];
                let square = next[1] * next[1] + next[2] * next[2];
                if square > limit * limit {
                    let shrink = limit / square.square_root();
                    next[1] *= shrink;
                    next[2] *= shrink;
                }
                next
            };
            self.velocity += response * (next - *r);
            *r = next;
        }
    }

    /// Natural map of the guide over `max(|r|, |r0|)`, squared; `r0` comes once from [`Self::alone`].
    fn error(&self, scene: &Scene<f32, N, 3, C>, alone: f32) -> f32 {
        let (mut residual, mut size) = (0.0, 0.0);
        for ((contact, r), &step) in scene.contacts().iter().zip(&self.impulse).zip(&self.step) {
            let cone = FrictionCone::new(contact.mu).unwrap_or(FrictionCone::frictionless());
            let u = contact.jacobian * self.velocity + contact.offset + *r * ALPHA;
            residual +=
                (*r - cone.project(&(*r - shifted(contact.mu, u) * (3.0 * step)))).norm_squared();
            size += r.norm_squared();
        }
        residual / size.max(alone)
    }

    fn alone(&self, scene: &Scene<f32, N, 3, C>) -> f32 {
        let contacts = scene.contacts().iter().zip(&self.step);
        let squares = contacts.map(|(contact, &step)| {
            let cone = FrictionCone::new(contact.mu).unwrap_or(FrictionCone::frictionless());
            let q = contact.jacobian * self.free + contact.offset;
            cone.project(&(shifted(contact.mu, q) * (-3.0 * step)))
                .norm_squared()
        });
        squares.sum()
    }
}

/// The augmented velocity of the law, or the velocity itself of its relaxation.
fn shifted(mu: f32, mut u: SVector<f32, 3>) -> SVector<f32, 3> {
    if SHARING.is_none() {
        u[0] += mu * (u[1] * u[1] + u[2] * u[2]).square_root();
    }
    u
}

/// `None` if something does not succeed.
#[inline(never)]
pub(crate) fn race(
    step: &mut Step<f32, N, 3, C>,
    push: &Push,
    before: &Push,
    counter: &mut Counter,
) -> Option<()> {
    static mut SOLVER: GaussSeidel = GaussSeidel::new();
    #[allow(unsafe_code)]
    // SAFETY: called once, and no interrupt is enabled.
    let solver = unsafe { &mut *&raw mut SOLVER };
    let scene = &step.scene;
    let mut ok = true;
    run(counter, "prepare", 0, |_| {
        ok &= solver.prepare(scene, push).is_some()
    })?;
    for sweeps in (1..=40).chain([60, 100, 200, 400, 1000]) {
        for (label, warm) in [("cold", false), ("warm", true)] {
            if warm {
                // Impulses of the tick before, by as many sweeps.
                ok &= solver.prepare(scene, before).is_some();
                solver.start(false);
                (0..2 * sweeps).for_each(|_| solver.sweep(scene));
                ok &= solver.prepare(scene, push).is_some();
            }
            run(counter, label, sweeps, |impulses| {
                solver.start(warm);
                (0..sweeps).for_each(|_| solver.sweep(scene));
                *impulses = solver.impulse;
            })?;
        }
    }
    for (setting, tolerance) in [("1e-3", 1e-3_f32), ("1e-4", 1e-4), ("1e-5", 1e-5)] {
        run(counter, "tested_cold", setting, |impulses| {
            let alone = solver.alone(scene);
            solver.start(false);
            for _ in 0..1000 {
                solver.sweep(scene);
                if solver.error(scene, alone) <= tolerance * tolerance {
                    break;
                }
            }
            *impulses = solver.impulse;
        })?;
    }
    let stack = stack_bytes(|| {
        ok &= solver.prepare(scene, push).is_some();
        solver.start(false);
        solver.sweep(scene);
    });
    hprintln!("bytes ram {}", size_of_val(scene) + size_of_val(solver));
    hprintln!("bytes stack {}", stack);
    ok.then_some(())
}
