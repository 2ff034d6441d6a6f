//! What an engineer writes to share out forces: ADMM on the forces, with exact projections onto the cones and `(alpha + rho + Aᵀ S A)⁻¹`
//! by Woodbury's formula, for a fixed number of iterations. It knows no error, and no scene but this one.

use crate::race::{C, Course, N, Push, SHARING, run};
use crate::stack::stack_bytes;
use cortex_m_semihosting::hprintln;
use nalgebra::{ComplexField, SMatrix, SVector, Vector3};
use stiction::Scene;

/// Penalty of the augmented Lagrangian, on forces: that with the fewest iterations of 0.1, 0.3 and 1.
const RHO: f32 = 0.3;

struct Admm {
    /// `((alpha + rho) S⁻¹ + A Aᵀ)⁻¹`
    inverse: SMatrix<f32, N, N>,
    /// `Aᵀ S b - w`
    wanted: [Vector3<f32>; C],
    force: [Vector3<f32>; C],
    dual: [Vector3<f32>; C],
}

impl Admm {
    const fn new() -> Self {
        const ZERO: Vector3<f32> = Vector3::new(0.0, 0.0, 0.0);
        Self {
            inverse: SMatrix::from_array_storage(nalgebra::ArrayStorage([[0.0; N]; N])),
            wanted: [ZERO; C],
            force: [ZERO; C],
            dual: [ZERO; C],
        }
    }

    fn reset(&mut self) {
        self.force.fill(Vector3::zeros());
        self.dual.fill(Vector3::zeros());
    }

    #[inline(never)]
    fn prepare(&mut self, scene: &Scene<f32, N, 3, C>, push: &Push) -> Option<()> {
        let (inverse_weights, alpha) = (scene.mass().diagonal(), SHARING?);
        let free = push.component_div(&inverse_weights);
        let mut matrix = SMatrix::<f32, N, N>::from_diagonal(&(inverse_weights * (alpha + RHO)));
        for (wanted, contact) in self.wanted.iter_mut().zip(scene.contacts()) {
            *wanted = -(contact.jacobian * free + contact.offset);
            matrix += contact.jacobian.tr_mul(&contact.jacobian);
        }
        self.inverse = matrix.cholesky()?.inverse();
        Some(())
    }

    #[inline(never)]
    fn iterate(&mut self, scene: &Scene<f32, N, 3, C>) {
        let scale = 1.0 / (SHARING.unwrap_or(0.0) + RHO);
        let mut sums = SVector::<f32, N>::zeros();
        let mut targets = [Vector3::zeros(); C];
        for (i, contact) in scene.contacts().iter().enumerate() {
            targets[i] = self.wanted[i] + (self.force[i] - self.dual[i]) * RHO;
            sums += contact.jacobian.tr_mul(&targets[i]);
        }
        let sums = self.inverse * sums;
        for (i, contact) in scene.contacts().iter().enumerate() {
            let mu = contact.mu;
            let z = (targets[i] - contact.jacobian * sums) * scale + self.dual[i];
            let tangent = ComplexField::sqrt(z[1] * z[1] + z[2] * z[2]);
            self.force[i] = if tangent <= mu * z[0] {
                z
            } else if mu * tangent <= -z[0] {
                Vector3::zeros()
            } else {
                let normal = (z[0] + mu * tangent) / (1.0 + mu * mu);
                let shrink = mu * normal / tangent;
                Vector3::new(normal, z[1] * shrink, z[2] * shrink)
            };
            self.dual[i] = z - self.force[i];
        }
    }
}

/// `None` if something does not succeed.
#[inline(never)]
pub(crate) fn race(Course { step, push, before, counter }: Course<'_>) -> Option<()> {
    static mut ADMM: Admm = Admm::new();
    #[allow(unsafe_code)]
    // SAFETY: called once, and no interrupt is enabled.
    let admm = unsafe { &mut *&raw mut ADMM };
    let scene = &step.scene;
    let mut ok = true;
    run(counter, "prepare", 0, |_| ok &= admm.prepare(scene, push).is_some())?;
    for iterations in (1..=40).chain([50, 60, 80, 100, 140, 200, 300, 400, 600, 1000]) {
        for (label, warm) in [("cold", false), ("warm", true)] {
            if warm {
                ok &= admm.prepare(scene, before).is_some();
                admm.reset();
                // What it comes to tick by tick: as many iterations on each.
                (0..10 * iterations).for_each(|_| admm.iterate(scene));
                ok &= admm.prepare(scene, push).is_some();
            }
            run(counter, label, iterations, |impulses| {
                if !warm {
                    admm.reset();
                }
                (0..iterations).for_each(|_| admm.iterate(scene));
                *impulses = admm.force;
            })?;
        }
    }
    let stack = stack_bytes(|| {
        ok &= admm.prepare(scene, push).is_some();
        admm.iterate(scene);
    });
    hprintln!("bytes ram {}", size_of_val(scene) + size_of_val(admm));
    hprintln!("bytes stack {}", stack);
    ok.then_some(())
}
