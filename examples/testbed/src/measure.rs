//! The error of a solution as somebody else would measure it, from the scene as given.

use crate::judge::{self, Wide};
use crate::scene_file::SceneFile;
use nalgebra::{DVector, SVector};
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

/// The Euclidean norm, also where squares overflow or underflow.
fn norm<'a>(x: impl Iterator<Item = &'a f64> + Clone) -> f64 {
    let largest = x.clone().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let squares = x.map(|x| (x / largest).powi(2));
    if largest > 0.0 { largest * squares.sum::<f64>().sqrt() } else { 0.0 }
}

/// A scene of contacts alone, to be judged.
fn judged(scene: &SceneFile, law: Law) -> judge::Scene {
    let (d, n) = (scene.dim, scene.n_dof);
    let row = |matrix: &nalgebra::DMatrix<f64>, i: usize| -> judge::Vector {
        (0..n).map(|j| Wide::from(matrix[(i, j)])).collect()
    };
    let contact = |(i, &mu): (usize, &f64)| judge::Contact {
        rows: (i * d..(i + 1) * d).map(|k| row(&scene.h, k)).collect(),
        scales: vec![Wide::from(1.0); d],
        offset: judge::wide(&scene.w.as_slice()[i * d..(i + 1) * d]),
        compliance: vec![judge::zero(); d],
        mu: Wide::from(mu),
        shift: Wide::from(if law == Law::Coulomb { mu } else { 0.0 }),
    };
    judge::Scene {
        mass: (0..n).map(|i| row(&scene.mass, i)).collect(),
        push: scene.f.iter().map(|&f| Wide::from(-f)).collect(),
        contacts: scene.mu.iter().enumerate().map(contact).collect(),
        rows: Vec::new(),
        is_mixed: false,
    }
}

/// `max(|r - Π_K(r - alpha û)| / max(|r|, |r0|, |stop|), |M v + f - Hᵀ r| / max(|f|, |M v|, |Hᵀ r|))`, computed with twice the
/// digits of f64; infinite where that cannot tell.
pub fn error(scene: &SceneFile, v: &[f64], r: &[f64], law: Law) -> f64 {
    let r: Vec<_> = r.chunks(scene.dim).map(<[f64]>::to_vec).collect();
    judged(scene, law).error(v, &r, &[])
}

/// The size of the impulses to expect, `max(|r0|, |stop|)`.
pub fn size(scene: &SceneFile, law: Law) -> f64 {
    let scene = judged(scene, law);
    let rest =
        vec![vec![judge::zero(); scene.contacts.first().map_or(1, |c| c.scales.len())]; scene.contacts.len()];
    let still = vec![judge::zero(); scene.push.len()];
    scene.contacts(&still, &rest).map_or(0.0, |(map, ..)| judge::narrow(map.size()))
}

/// What a certificate of infeasibility `d` (one number a contact) proves: any velocity with
/// `H_N v + w_N >= 0` has so many times the kinetic energy, in its square root, that the fastest
/// offset asks for alone. Infinite if `H_Nᵀ d = 0` exactly, 0 if `d` proves nothing.
pub fn proof(scene: &SceneFile, d: &[f64]) -> f64 {
    let normal = |i: usize| scene.h.row(i * scene.dim);
    let cholesky = scene.mass.clone().cholesky().expect("M is positive definite");
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
    if leak > 0.0 { approach / leak } else { f64::INFINITY }
}

/// [`error`] of a solution of the kernel, of a scene of contacts alone.
pub fn error_of<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
    scene: &Scene<T, N, D, C, R, S>,
    free_impulse: &SVector<T, N>,
    solution: &Solution<T, N, D, C, R>,
    law: Law,
) -> f64 {
    let scene = SceneFile::of(scene, free_impulse);
    error(&scene, &velocity(solution), &impulses(solution), law)
}

/// The velocity `v` of a solution, in f64.
pub fn velocity<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    solution: &Solution<T, N, D, C, R>,
) -> Vec<f64> {
    solution.velocity.iter().map(double).collect()
}

/// The impulses `r` of a solution, contact by contact, in f64.
pub fn impulses<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    solution: &Solution<T, N, D, C, R>,
) -> Vec<f64> {
    let contacts = solution.contacts.iter();
    contacts.flat_map(|contact| contact.impulse.iter().map(double)).collect()
}

pub(crate) fn double<T: Real>(x: &T) -> f64 {
    x.to_subset().unwrap_or(f64::NAN)
}
