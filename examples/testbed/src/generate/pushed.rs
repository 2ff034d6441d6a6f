//! Real scenes, pushed at random: where a control loop will be the tick after next.

use super::Candidate;
use super::random::Random;
use crate::scene_file::{self, SceneFile};
use nalgebra::DVector;
use std::sync::LazyLock;

/// The bundled scenes whose surfaces do not approach, so that few become infeasible.
static REAL: LazyLock<Vec<SceneFile>> = LazyLock::new(|| {
    let mut scenes = scene_file::bundled_scenes();
    scenes.retain(|scene| {
        let mut offsets = scene.w.iter().step_by(scene.dim);
        !scene.name.starts_with("infeasible") && offsets.all(|w| *w >= 0.0)
    });
    scenes
});

/// The scene with these contacts only.
fn only(scene: &SceneFile, kept: &[usize]) -> SceneFile {
    let rows: Vec<usize> = kept.iter().flat_map(|i| i * scene.dim..(i + 1) * scene.dim).collect();
    SceneFile {
        n_contacts: kept.len(),
        h: scene.h.select_rows(&rows),
        w: scene.w.select_rows(&rows),
        mu: kept.iter().map(|&i| scene.mu[i]).collect(),
        keys: kept.iter().map(|&i| scene.keys[i]).collect(),
        ..scene.clone()
    }
}

/// `wanted` of `0..count`, in order, each choice as likely as any other.
fn sample(random: &mut Random, count: usize, mut wanted: usize) -> Vec<usize> {
    let mut kept = Vec::new();
    for i in 0..count {
        if random.count(1, count - i) <= wanted {
            kept.push(i);
            wanted -= 1;
        }
    }
    kept
}

/// A bundled scene with a free velocity off by 0, 10 or 50 % of its energy norm, other friction, and fewer contacts once
/// in three times.
pub(super) fn pushed(random: &mut Random) -> Candidate {
    let mut scene = REAL[random.count(0, REAL.len() - 1)].clone();
    let factor = scene.mass.clone().cholesky();
    let factor = factor.expect("M of a bundled scene is positive definite");
    // With M = L Lᵀ the free velocity's energy norm is |L⁻¹ f|, and noise x of that norm adds -L x to f.
    let free = factor.l_dirty().solve_lower_triangular(&scene.f);
    let size = free.map_or(0.0, |free| free.norm());
    let noise = random.normals(scene.n_dof).normalize();
    scene.f -= factor.l() * noise * (random.pick(&[0.0, 0.1, 0.5]) * size);
    for mu in &mut scene.mu {
        *mu *= libm::exp(0.5 * random.normal());
    }
    if scene.n_contacts > 1 && random.one_in(3) {
        let wanted = random.count(1, scene.n_contacts - 1);
        let kept = sample(random, scene.n_contacts, wanted);
        scene = only(&scene, &kept);
    }
    let witness = DVector::zeros(scene.n_dof);
    Candidate { scene, witness }
}
