//! Changes of units.

use super::random::Random;
use crate::scene_file::SceneFile;

const SMALLEST: f64 = 1e-12;
const LARGEST: f64 = 1e12;

/// Whether all masses, and the size of all other data, lie between 1e-12 and 1e12.
fn in_range(scene: &SceneFile) -> bool {
    let masses = scene.mass.diagonal();
    let others = [scene.h.amax(), scene.f.amax(), scene.w.amax()];
    let mut sizes = masses.iter().chain(&others).filter(|&&size| size > 0.0);
    sizes.all(|size| (SMALLEST..=LARGEST).contains(size))
}

/// Other units of mass and velocity, and of length for some dofs, by powers of two: nothing is
/// rounded, so what was true of the scene stays true.
pub(super) fn change(random: &mut Random, scene: &SceneFile) -> SceneFile {
    let mut draw = |limit: i32| random.exponent(-limit, limit);
    let (mut mass, mut velocity, mut length) = (draw(40), draw(40), draw(12));
    let angular: Vec<bool> = (0..scene.n_dof).map(|_| random.one_in(2)).collect();
    loop {
        let mut changed = scene.clone();
        let scale = |exponent| libm::scalbn(1.0, exponent);
        changed.mass *= scale(mass);
        changed.f *= scale(mass + velocity);
        changed.w *= scale(velocity);
        for (dof, _) in angular.iter().enumerate().filter(|(_, angular)| **angular) {
            let unit = scale(length);
            changed.mass.row_mut(dof).scale_mut(unit);
            changed.mass.column_mut(dof).scale_mut(unit);
            changed.h.column_mut(dof).scale_mut(unit);
            changed.f[dof] *= unit;
        }
        if in_range(&changed) || (mass, velocity, length) == (0, 0, 0) {
            return changed;
        }
        (mass, velocity, length) = (mass / 2, velocity / 2, length / 2);
    }
}
