//! Projected Gauss-Seidel, the solver a firmware engineer writes first: contact by contact, the
//! normal impulse to zero normal velocity, the tangential one to zero slip, clamped to the cone.

use nalgebra::{SMatrix, SVector};
use stiction::{Contact, FrictionCone, Real, Scene};

pub(crate) struct GaussSeidel<T, const N: usize, const D: usize, const C: usize> {
    /// `M⁻¹ H_iᵀ`
    response: [SMatrix<T, N, D>; C],
    /// Diagonal of `W`, inverted; the tangents share the larger entry.
    normal: [T; C],
    tangent: [T; C],
    /// `alpha_i`
    step: [T; C],
    pub(crate) impulse: [SVector<T, D>; C],
}

impl<T: Real, const N: usize, const D: usize, const C: usize> GaussSeidel<T, N, D, C> {
    /// Needs the inverse of the mass matrix.
    pub(crate) fn prepare(&mut self, scene: &Scene<T, N, D, C>) -> Option<()> {
        let cholesky = scene.mass().cholesky()?;
        for (i, contact) in scene.contacts().iter().enumerate() {
            let response = cholesky.solve(&contact.jacobian.transpose());
            let delassus = contact.jacobian * response;
            let diagonal = delassus.diagonal();
            let largest = diagonal.iter().skip(1).fold(T::ZERO, |a, &b| a.max(b));
            *self.normal.get_mut(i)? = T::ONE / diagonal[0];
            *self.tangent.get_mut(i)? = T::ONE / largest;
            *self.step.get_mut(i)? = T::literal(D as f64) / diagonal.sum();
            *self.response.get_mut(i)? = response;
        }
        Some(())
    }

    /// From zero impulses; `v` starts as `v_free` and ends as the velocity.
    pub(crate) fn solve(
        &mut self,
        scene: &Scene<T, N, D, C>,
        v: &mut SVector<T, N>,
        sweeps: usize,
    ) {
        self.impulse = [SVector::zeros(); C];
        for _ in 0..sweeps {
            self.sweep(scene, v);
        }
    }

    /// The same until a test after each sweep says that the error is small enough.
    pub(crate) fn solve_until(
        &mut self,
        scene: &Scene<T, N, D, C>,
        v: &mut SVector<T, N>,
        tolerance: T,
    ) {
        self.impulse = [SVector::zeros(); C];
        let reference = self.reference(scene, v);
        for _ in 0..400 {
            self.sweep(scene, v);
            if self.error(scene, v, reference) <= tolerance {
                return;
            }
        }
    }

    /// One sweep.
    fn sweep(&mut self, scene: &Scene<T, N, D, C>, v: &mut SVector<T, N>) {
        let state = self.impulse.iter_mut().zip(&self.response);
        let steps = self.normal.iter().zip(&self.tangent);
        for ((contact, (r, response)), (&normal, &tangent)) in
            scene.contacts().iter().zip(state).zip(steps)
        {
            let u = contact.jacobian * *v + contact.offset;
            let mut next = *r;
            next[0] = (r[0] - u[0] * normal).max(T::ZERO);
            let mut square = T::ZERO;
            for k in 1..D {
                next[k] = r[k] - u[k] * tangent;
                square += next[k] * next[k];
            }
            let limit = contact.mu * next[0];
            if square > limit * limit {
                let shrink = limit / square.square_root();
                for k in 1..D {
                    next[k] *= shrink;
                }
            }
            *v += response * (next - *r);
            *r = next;
        }
    }

    /// Natural-map error of the impulses, as the kernel defines its own.
    pub(crate) fn error(
        &self,
        scene: &Scene<T, N, D, C>,
        v: &SVector<T, N>,
        reference: Reference<T>,
    ) -> T {
        let [mut residual, mut size] = [T::ZERO; 2];
        let pairs = self.impulse.iter().zip(&self.step);
        for (contact, (r, &step)) in scene.contacts().iter().zip(pairs) {
            let (cone, push) = pushed(contact, step, v);
            residual += (r - cone.project(&(r - push))).norm_squared();
            size += r.norm_squared();
        }
        (residual / size.max(reference.square)).square_root()
    }

    /// What the error is relative to at least, from the free velocity.
    pub(crate) fn reference(
        &self,
        scene: &Scene<T, N, D, C>,
        free: &SVector<T, N>,
    ) -> Reference<T> {
        let [mut alone, mut stopping] = [T::ZERO; 2];
        let speed = free.abs();
        for (contact, &step) in scene.contacts().iter().zip(&self.step) {
            let (cone, push) = pushed(contact, step, free);
            alone += cone.project(&-push).norm_squared();
            let mut offset = contact.offset.abs();
            if contact.offset[0] > T::ZERO {
                offset[0] = T::ZERO; // a gap
            }
            let stop = contact.jacobian.abs() * speed + offset;
            stopping += (stop * (step * T::literal(0.01))).norm_squared();
        }
        Reference {
            square: alone.max(stopping),
        }
    }
}

/// What an error is relative to at least, (N·s)².
#[derive(Clone, Copy)]
pub(crate) struct Reference<T> {
    square: T,
}

/// The cone of a contact, and `alpha_i` times its augmented velocity.
fn pushed<T: Real, const N: usize, const D: usize>(
    contact: &Contact<T, N, D>,
    step: T,
    v: &SVector<T, N>,
) -> (FrictionCone<T>, SVector<T, D>) {
    let cone = FrictionCone::new(contact.mu).unwrap_or(FrictionCone::frictionless());
    let mut u = contact.jacobian * v + contact.offset;
    let slip = u.rows_range(1..).norm_squared().square_root();
    u[0] += contact.mu * slip;
    (cone, u * step)
}

impl<T: Real, const N: usize, const D: usize, const C: usize> GaussSeidel<T, N, D, C> {
    pub(crate) const fn new() -> Self {
        let zeros = nalgebra::ArrayStorage([[T::ZERO; N]; D]);
        let impulse = nalgebra::ArrayStorage([[T::ZERO; D]; 1]);
        Self {
            response: [SMatrix::from_array_storage(zeros); C],
            normal: [T::ZERO; C],
            tangent: [T::ZERO; C],
            step: [T::ZERO; C],
            impulse: [SVector::from_array_storage(impulse); C],
        }
    }
}
