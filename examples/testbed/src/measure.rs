//! The error of a solution as somebody else would measure it: in f64, from the scene as given.

use crate::scene_file::SceneFile;
use nalgebra::{DMatrix, DVector, SVector};
use stiction::{Real, Scene, Solution};

/// Coulomb's law, or its convex relaxation (no `mu |u_T|` in the normal velocity).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    Coulomb,
    Relaxed,
}

/// Projection onto `K_mu`, Eq. (1), as plainly as it can be written.
pub fn project(x: &[f64], mu: f64) -> Vec<f64> {
    let length = norm(x[1..].iter());
    if x[0] >= 0.0 && length <= mu * x[0] {
        return x.to_vec();
    }
    if mu * length <= -x[0] {
        return vec![0.0; x.len()];
    }
    let along = (x[0] + mu * length) / (1.0 + mu * mu);
    let mut projection = vec![along];
    projection.extend(x[1..].iter().map(|x| along * mu * x / length));
    projection
}

fn ratio(numerator: f64, denominator: f64) -> f64 {
    if numerator == 0.0 {
        0.0
    } else {
        numerator / denominator
    }
}

/// The Euclidean norm, also where squares overflow or underflow.
fn norm<'a>(x: impl Iterator<Item = &'a f64> + Clone) -> f64 {
    let largest = x.clone().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let squares = x.map(|x| (x / largest).powi(2));
    if largest > 0.0 {
        largest * squares.sum::<f64>().sqrt()
    } else {
        0.0
    }
}

/// `max(|r - Π_K(r - alpha û)| / max(|r|, |r0|, |stop|), |M v + f - Hᵀ r| / max(|f|, |M v|, |Hᵀ r|))`; infinite where f64
/// cannot tell.
pub fn error(scene: &SceneFile, v: &[f64], r: &[f64], law: Law) -> f64 {
    let (v, r) = (DVector::from_row_slice(v), DVector::from_row_slice(r));
    let (residual, size) = contacts(scene, &v, &r, law);
    let natural_map = ratio(norm(residual.iter()), size.max(norm(r.iter())));
    let (inertia, contact) = (&scene.mass * &v, scene.h.transpose() * &r);
    let size = norm(scene.f.iter()).max(norm(inertia.iter()));
    let size = size.max(norm(contact.iter()));
    let balance = inertia + &scene.f - contact;
    let dynamics = ratio(norm(balance.iter()), size);
    let finite = residual.iter().chain(&balance).all(|x| x.is_finite());
    if finite && natural_map.is_finite() && dynamics.is_finite() {
        natural_map.max(dynamics)
    } else {
        f64::INFINITY
    }
}

/// The size of the impulses to expect, `max(|r0|, |speed|)`.
pub fn size(scene: &SceneFile, law: Law) -> f64 {
    let [v, r] = [scene.n_dof, scene.w.len()].map(DVector::zeros);
    contacts(scene, &v, &r, law).1
}

/// The natural map `r - Π_K(r - alpha û)`, and the larger of `|r0|` and `|speed|`: `r0_i = Π_K(-alpha_i q̂_i)` is what contact
/// `i` would take if it were alone, `speed_i = alpha_i (|H_i| |v_free| + |w_i|) / 100` (without gaps `w_Ni > 0`) a hundredth
/// of what would stop its motion.
fn contacts(scene: &SceneFile, v: &DVector<f64>, r: &DVector<f64>, law: Law) -> (Vec<f64>, f64) {
    let cholesky = scene
        .mass
        .clone()
        .cholesky()
        .expect("M is positive definite");
    let delassus: DMatrix<f64> = &scene.h * cholesky.solve(&scene.h.transpose());
    let free = -cholesky.solve(&scene.f);
    let (q, u) = (&scene.w + &scene.h * &free, &scene.w + &scene.h * v);
    let motion = scene.h.abs() * free.abs();
    let d = scene.dim;
    let (mut residual, mut alone, mut speed) = (Vec::new(), Vec::new(), Vec::new());
    for (i, &mu) in scene.mu.iter().enumerate() {
        let rows = i * d..(i + 1) * d;
        let mean = delassus.view((i * d, i * d), (d, d)).diagonal().mean();
        let alpha = if mean > 0.0 { 1.0 / mean } else { 0.0 };
        // Π_K(r - alpha û)
        let projected = |r: &[f64], u: &DVector<f64>| {
            let u = u.rows(i * d, d);
            let slip = norm(u.rows(1, d - 1).iter());
            let mut x: Vec<f64> = (0..d).map(|k| r[k] - alpha * u[k]).collect();
            if law == Law::Coulomb {
                x[0] -= alpha * mu * slip;
            }
            project(&x, mu)
        };
        let r = &r.as_slice()[rows.clone()];
        let projection = projected(r, &u);
        residual.extend(r.iter().zip(projection).map(|(r, p)| r - p));
        // Nothing moves it: no impulse changes what it misses.
        let shift = if law == Law::Coulomb { 0.0 } else { mu };
        if alpha == 0.0 && u[i * d] < shift * norm(u.rows(i * d + 1, d - 1).iter()) {
            residual[i * d] = f64::INFINITY;
        }
        alone.extend(projected(&vec![0.0; d], &q));
        speed.extend(rows.map(|row| {
            let gap = row == i * d && scene.w[row] > 0.0;
            let offset = if gap { 0.0 } else { scene.w[row].abs() };
            1e-2 * alpha * (motion[row] + offset)
        }));
    }
    (residual, norm(alone.iter()).max(norm(speed.iter())))
}

/// What a certificate of infeasibility `d` (one number a contact) proves: any velocity with
/// `H_N v + w_N >= 0` has so many times the kinetic energy, in its square root, that the fastest
/// offset asks for alone. Infinite if `H_Nᵀ d = 0` exactly, 0 if `d` proves nothing.
pub fn proof(scene: &SceneFile, d: &[f64]) -> f64 {
    let normal = |i: usize| scene.h.row(i * scene.dim);
    let cholesky = scene
        .mass
        .clone()
        .cholesky()
        .expect("M is positive definite");
    let energy = |x: &DVector<f64>| x.dot(&cholesky.solve(x)).sqrt();
    let mut leak = DVector::zeros(scene.n_dof);
    let (mut approach, mut fastest) = (0.0, 0.0_f64);
    for (i, &d) in d.iter().enumerate() {
        let (row, w) = (normal(i).transpose(), scene.w[i * scene.dim]);
        approach -= d * w;
        if energy(&row) > 0.0 {
            fastest = fastest.max(w.abs() / energy(&row));
        }
        leak += row * d;
    }
    if d.len() != scene.n_contacts || d.iter().any(|&d| d < 0.0) || approach <= 0.0 {
        return 0.0;
    }
    let leak = energy(&leak) * fastest;
    if leak > 0.0 {
        approach / leak
    } else {
        f64::INFINITY
    }
}

/// [`error`] of a solution of the kernel.
pub fn error_of<T: Real, const N: usize, const D: usize, const C: usize>(
    scene: &Scene<T, N, D, C>,
    free_impulse: &SVector<T, N>,
    solution: &Solution<T, N, D, C>,
    law: Law,
) -> f64 {
    let scene = SceneFile::of(scene, free_impulse);
    error(&scene, &velocity(solution), &impulses(solution), law)
}

/// The velocity `v` of a solution, in f64.
pub fn velocity<T: Real, const N: usize, const D: usize, const C: usize>(
    solution: &Solution<T, N, D, C>,
) -> Vec<f64> {
    solution.velocity.iter().map(double).collect()
}

/// The impulses `r` of a solution, contact by contact, in f64.
pub fn impulses<T: Real, const N: usize, const D: usize, const C: usize>(
    solution: &Solution<T, N, D, C>,
) -> Vec<f64> {
    let contacts = solution.contacts.iter();
    contacts
        .flat_map(|contact| contact.impulse.iter().map(double))
        .collect()
}

pub(crate) fn double<T: Real>(x: &T) -> f64 {
    x.to_subset().unwrap_or(f64::NAN)
}
