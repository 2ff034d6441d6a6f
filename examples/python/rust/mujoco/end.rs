//! What overlaps at the end of the step and is not in the scene.

use super::facts::{Facts, body_of, is_side_of_prism};
use super::ffi::{ContactRef, Data, Model, OwnedContact};
use super::touch::{Touch, pair_of};
use nalgebra::{Matrix3, Vector3};

/// A contact that was found at the end of the step, or on the way.
pub(super) struct Found {
    pub(super) contact: OwnedContact,
    /// Its gap and its Jacobian there, and the velocities that led there.
    pub(super) there: There,
    geoms: [usize; 2],
    place: Vector3<f64>,
}

/// A contact where it was found.
pub(super) struct There {
    gap: f64,
    pub(super) rows: Vec<f64>,
    velocity: Vec<f64>,
}

impl There {
    /// The gap at the start of the step, as its row sees it.
    pub(super) fn gap_before(&self, h: f64) -> f64 {
        let row = &self.rows[..self.velocity.len()];
        self.gap - h * super::touch::dot(row, &self.velocity)
    }
}

/// Looks at poses of the step.
pub(super) struct Lookout<'a> {
    pub(super) model: &'a Model,
    pub(super) facts: &'a Facts,
    /// By how much margins have grown (m).
    pub(super) grown: f64,
    /// Overlaps up to this count as none (m), and the model's length.
    pub(super) slop: f64,
    pub(super) length: f64,
}

/// What was seen.
#[derive(Default)]
pub(super) struct Seen {
    pub(super) new: Vec<Found>,
    /// Contacts found before, by their places in MuJoCo's list, where they are now.
    pub(super) again: Vec<(usize, There)>,
}

/// Contacts that are added at once.
const MOST_NEW: usize = 24;
/// Contacts of a pair as near as this are one: over the model's length, those of the scene and those found.
const NEAR_KNOWN: f64 = 0.05;
const NEAR_FOUND: f64 = 1e-3;

impl Lookout<'_> {
    /// Is a contact none of the surfaces, but of what a height field is made of?
    pub(super) fn is_ghost(&self, data: &Data, contact: ContactRef<'_>) -> bool {
        if !self.facts.height_fields {
            return false;
        }
        let [normal, ..] = contact.frame();
        let sides = contact.geoms().into_iter().zip([1.0, -1.0]);
        sides.into_iter().any(|(geom, sign)| {
            let [position, rotation] = [geom, geom];
            let (position, rotation) = (data.geom_xpos()[position], data.geom_xmat()[rotation]);
            is_side_of_prism(self.model, geom, [position, contact.place()], rotation, sign * Vector3::from(normal))
        })
    }

    /// Looks for what overlaps after the step at these velocities. `moves_again` tells of contacts of the scene that were found
    /// before, and whose row may be taken anew.
    pub(super) fn look(
        &self,
        data: &Data,
        scratch: &mut Data,
        velocity: &[f64],
        touches: &[Touch],
        takes_anew: bool,
    ) -> Seen {
        let h = self.model.step();
        self.pose(data, scratch, velocity, h);
        let moved = moved(self.model, data, scratch);
        let poses = self.facts.poses(&moved);
        let mut seen = Seen::default();
        for pose in 1..=poses {
            let share = f64::from(pose) / f64::from(poses);
            if poses > 1 {
                self.pose(data, scratch, velocity, share * h);
            }
            scratch.collision(self.model);
            let is_end = pose == poses;
            self.list(scratch, share, velocity, touches, &moved, takes_anew && is_end, &mut seen);
        }
        seen.new.truncate(MOST_NEW);
        seen
    }

    fn pose(&self, data: &Data, scratch: &mut Data, velocity: &[f64], time: f64) {
        scratch.qpos_mut().copy_from_slice(data.qpos());
        scratch.mocap_pos_mut().copy_from_slice(data.mocap_pos());
        scratch.mocap_quat_mut().copy_from_slice(data.mocap_quat());
        self.model.integrate(scratch.qpos_mut(), velocity, time);
        scratch.kinematics(self.model);
    }

    #[allow(clippy::too_many_arguments)] // a pose has that much around it
    fn list(
        &self,
        scratch: &mut Data,
        share: f64,
        velocity: &[f64],
        touches: &[Touch],
        moved: &[f64],
        takes_anew: bool,
        seen: &mut Seen,
    ) {
        let mut has_com = false;
        let count = scratch.contacts().len();
        for index in 0..count {
            let contact = scratch.contact(index);
            let gap = contact.gap(self.grown);
            if gap >= -self.slop || contact.is_excluded() || self.is_ghost(scratch, contact) {
                continue;
            }
            let geoms = pair_of(contact);
            let (place, normal) = (Vector3::from(contact.place()), Vector3::from(contact.frame()[0]));
            let reach = NEAR_KNOWN * self.length + 2.0 * (moved[geoms[0]] + moved[geoms[1]]);
            let distance = |touch: &Touch| (touch.place - place).norm();
            let known = touches.iter().filter(|touch| touch.faces(geoms, normal) && distance(touch) < reach);
            let known = known.min_by(|a, b| distance(a).total_cmp(&distance(b)));
            if known.is_some_and(|known| !(known.is_new && takes_anew)) {
                continue;
            }
            let is_near = |other: &Found| other.geoms == geoms && (other.place - place).norm() < NEAR_FOUND * self.length;
            if known.is_none() && seen.new.iter().any(is_near) {
                continue;
            }
            let known = known.map(|known| known.index);
            if !has_com {
                scratch.com_pos(self.model);
                has_com = true;
            }
            let contact = scratch.contact(index);
            let rows = jacobian(self.model, scratch, contact);
            let there = There { gap, rows, velocity: velocity.iter().map(|v| v * share).collect() };
            if let Some(known) = known {
                seen.again.push((known, there));
            } else {
                // With a distance that MuJoCo takes for a contact.
                let contact = OwnedContact::new(contact, gap.min(-self.slop), 0.0);
                seen.new.push(Found { contact, there, geoms, place });
            }
        }
    }
}

/// How far each geom moves from data to others, at most (m).
fn moved(model: &Model, before: &Data, after: &Data) -> Vec<f64> {
    let places = before.geom_xpos().iter().zip(after.geom_xpos());
    let frames = before.geom_xmat().iter().zip(after.geom_xmat());
    let both = places.zip(frames).zip(model.geom_rbound());
    both.map(|(((p, q), (a, b)), radius)| {
        let along = (Vector3::from(*q) - Vector3::from(*p)).norm();
        let turned = (Matrix3::from_row_slice(b) - Matrix3::from_row_slice(a)).norm();
        along + turned * radius
    })
    .collect()
}

/// The Jacobian of a contact where the data is.
fn jacobian(model: &Model, data: &Data, contact: ContactRef<'_>) -> Vec<f64> {
    let nv = model.sizes.velocities;
    let [first, second] = contact.geoms().map(|geom| data.jacobian(model, contact.place(), body_of(model, geom)));
    let mut rows = Vec::with_capacity(contact.dim() * nv);
    for i in 0..contact.dim() {
        let (axis, kind) = (contact.frame()[i % 3], i / 3);
        rows.extend((0..nv).map(|dof| {
            let entry = |k: usize| second[kind][k * nv + dof] - first[kind][k * nv + dof];
            (0..3).map(|k| axis[k] * entry(k)).sum::<f64>()
        }));
    }
    rows
}
