//! A scene of the race as this crate takes it, and the impulses of its solution.

use crate::race::{C, Impulses, N, SHARING};
use crate::records::Step;
use stiction::{Scene, Solution, Surface};

/// Room for surfaces: compliance is one.
pub(crate) const S: usize = if SHARING.is_some() { C } else { 0 };

/// Fills a scene with the mass and the contacts of a step, and with compliance where forces are shared out.
pub(crate) fn fill(scene: &mut Scene<f32, N, 3, C, 0, S>, step: &Step<f32, N, 3, C>) -> Option<()> {
    scene.set_mass(step.scene.mass()).ok()?;
    for contact in step.scene.contacts() {
        if let Some(alpha) = SHARING {
            let surface = Surface { compliance: [alpha; 2], ..Surface::isotropic(contact.mu) };
            scene.push_on(contact, &surface).ok()?;
        } else {
            scene.push(contact).ok()?;
        }
    }
    Some(())
}

pub(crate) fn copy(solution: &Solution<f32, N, 3, C>, impulses: &mut Impulses) {
    for (impulse, contact) in impulses.iter_mut().zip(&solution.contacts) {
        *impulse = contact.impulse;
    }
}
