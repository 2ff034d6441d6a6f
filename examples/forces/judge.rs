//! What forces are worth.

use crate::scene::{MU, WEIGHT, WEIGHTS};
use crate::{ALPHA, Forces, Grasp, Wrench, wanted};

/// What is left of a wrench, in units of the friction that there is.
pub(crate) fn missed(grasp: &Grasp, forces: &Forces, b: &Wrench) -> f64 {
    let missed = grasp * forces - b;
    missed.component_mul(&Wrench::from(WEIGHTS)).dot(&missed).sqrt() / (MU * WEIGHT)
}

/// `½ |A f - b|²_S + ½ α |f|²`
pub(crate) fn objective(grasp: &Grasp, forces: &Forces, b: &Wrench) -> f64 {
    let missed = grasp * forces - b;
    let exactness = missed.component_mul(&Wrench::from(WEIGHTS)).dot(&missed);
    0.5 * (exactness + ALPHA * forces.norm_squared())
}

/// The largest push that is shared out but for 1 %, in units of the friction that there is.
pub(crate) fn reach(grasp: &Grasp, angle: f64, mut share: impl FnMut(&Wrench) -> Forces) -> f64 {
    let (mut low, mut high) = (0.0, 2.0);
    for _ in 0..14 {
        let push = 0.5 * (low + high);
        let b = wanted(push, angle);
        let delivered = missed(grasp, &share(&b), &b) <= 1e-2;
        *(if delivered { &mut low } else { &mut high }) = push;
    }
    low
}

/// The largest tangential force of a foot, in units of the friction that it has.
pub(crate) fn worst_foot(forces: &Forces) -> f64 {
    let feet = forces.as_slice().chunks_exact(3);
    let used = feet.map(|f| f[1].hypot(f[2]) / (MU * f[0]).max(1e-9));
    used.fold(0.0, f64::max)
}

/// What a floor makes of them: a foot that asks for more friction than it has slips.
pub(crate) fn on_floor(forces: &Forces) -> Forces {
    let mut forces = *forces;
    for f in forces.as_mut_slice().chunks_exact_mut(3) {
        let held = (MU * f[0] / f[1].hypot(f[2]).max(1e-9)).min(1.0);
        f[1] *= held;
        f[2] *= held;
    }
    forces
}
