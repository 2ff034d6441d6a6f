//! What overlaps at the end of the step and is not in the scene.

use super::crowd::FLAT;
use super::facts::{Facts, MOST_POSES, TURN, body_of, is_side_of_prism};
use super::ffi::{ContactRef, Data, Model, OwnedContact};
use super::touch::{Face, Taken, Touch, dot, nearest_first, pose};
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeMap;

/// A contact where it was found.
pub(super) struct There {
    gap: f64,
    pub(super) rows: Vec<f64>,
    velocity: Vec<f64>,
}

impl There {
    /// The gap at the start of the step, as its row sees it.
    pub(super) fn gap_before(&self, h: f64) -> f64 {
        self.gap - h * dot(&self.rows[..self.velocity.len()], &self.velocity)
    }

    /// The share of the way to its pose after which it touches: 0 if it has done so all along.
    fn touches_after(&self, h: f64) -> f64 {
        let before = self.gap_before(h).max(0.0);
        before / (before - self.gap)
    }
}

/// What is told of a contact at the end.
pub(super) enum Seen {
    /// It is listed, but did not take part: its place in MuJoCo's list.
    Listed(usize),
    /// It takes part, and is deeper than its row foresaw, by so much (m): its path has a curve.
    Deeper(usize, f64),
    /// It was found before, and is elsewhere now.
    Again(usize, OwnedContact, There),
    New(OwnedContact, There),
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

/// What is looked at.
pub(super) struct Step<'a> {
    pub(super) data: &'a Data,
    pub(super) velocity: &'a [f64],
    /// Contacts that take part, and their places in MuJoCo's list.
    pub(super) touches: &'a [Touch],
    pub(super) taken: &'a BTreeMap<usize, Taken>,
    /// May rows of contacts that were found before be taken anew?
    pub(super) takes_anew: bool,
}

/// Contacts that are added at once.
const MOST_NEW: usize = 64;
/// Contacts of a pair as near as this are one: over the model's length, those of the scene and those found.
const NEAR_KNOWN: f64 = 0.05;
const NEAR_FOUND: f64 = 1e-3;
/// Touches as near as this in time are one, over the way to their pose.
const AT_ONCE: f64 = 1e-6;

/// An overlap at a pose.
struct Overlap {
    index: usize,
    depth: f64,
    /// How deep is only what its path has of a curve (m).
    deepest: f64,
    face: Face,
    /// Is something round that turns?
    rolls: bool,
    place: Vector3<f64>,
    known: Option<usize>,
}

/// A contact that is told of for the first time.
struct Met {
    /// Its place among what is seen.
    seen: usize,
    face: Face,
    place: Vector3<f64>,
    /// The share of the way to its pose after which it touches.
    after: f64,
}

impl Lookout<'_> {
    /// Is a contact none of the surfaces, but of what a height field is made of?
    pub(super) fn is_ghost(&self, data: &Data, contact: ContactRef<'_>) -> bool {
        if !self.facts.height_fields {
            return false;
        }
        let [normal, ..] = contact.frame();
        let sides = contact.geoms().into_iter().zip([1.0, -1.0]);
        sides.into_iter().any(|(geom, sign)| {
            let (position, rotation) = (data.geom_xpos()[geom], data.geom_xmat()[geom]);
            is_side_of_prism(
                self.model,
                geom,
                [position, contact.place()],
                rotation,
                sign * Vector3::from(normal),
            )
        })
    }

    /// Looks for what overlaps after the step; where things move far, for what overlaps first on the way.
    /// Says as well whether something moves too far for that. `is_posed` says that `scratch` is at the pose after the step.
    pub(super) fn look(&self, step: &Step<'_>, scratch: &mut Data, is_posed: bool) -> (Vec<Seen>, bool) {
        let h = self.model.step();
        if !is_posed {
            self.pose(step, scratch, h);
        }
        let moved = moved(self.model, step.data, scratch);
        let (mut poses, is_blind) = self.facts.poses(&moved);
        loop {
            let mut is_doubtful = false;
            for pose in 1..=poses {
                let share = f64::from(pose) / f64::from(poses);
                if poses > 1 {
                    self.pose(step, scratch, share * h);
                }
                scratch.collision(self.model);
                let mut overlaps = self.overlaps(scratch);
                if overlaps.is_empty() {
                    continue;
                }
                self.recognise(&mut overlaps, step, (scratch, share), &moved);
                scratch.com_pos(self.model);
                let (mut seen, mut found) = (Vec::new(), Vec::new());
                for overlap in overlaps {
                    is_doubtful |= !self.tell(step, scratch, overlap, share, &mut seen, &mut found);
                }
                if step.takes_anew {
                    for late in found.iter().filter(|met| self.is_late(met, &found)).rev() {
                        seen.remove(late.seen);
                    }
                }
                // Where it goes from there is not known yet.
                if !seen.is_empty() {
                    return (seen, is_blind);
                }
            }
            if !is_doubtful || poses >= MOST_POSES {
                return (Vec::new(), is_blind);
            }
            // Entered so deep that its side is not known: looked at on the way.
            poses = (4 * poses).min(MOST_POSES);
        }
    }

    fn pose(&self, step: &Step<'_>, scratch: &mut Data, time: f64) {
        scratch.copy_pose(step.data);
        self.model.integrate(scratch.qpos_mut(), step.velocity, time);
        scratch.kinematics(self.model);
    }

    fn overlaps(&self, scratch: &Data) -> Vec<Overlap> {
        let overlap = |(index, contact): (usize, ContactRef<'_>)| {
            let depth = -contact.gap(self.grown);
            (depth > self.slop && !contact.is_excluded() && !self.is_ghost(scratch, contact)).then(|| {
                Overlap {
                    index,
                    depth,
                    deepest: 0.0,
                    rolls: false,
                    face: Face::of(contact),
                    place: contact.place().into(),
                    known: None,
                }
            })
        };
        scratch.contacts().enumerate().filter_map(overlap).collect()
    }

    /// Tells which contacts of the scene they are, each of one overlap: those that are nearest to each other first.
    fn recognise(
        &self,
        overlaps: &mut [Overlap],
        step: &Step<'_>,
        (scratch, share): (&Data, f64),
        moved: &[Moved],
    ) {
        let (touches, time) = (step.touches, share * self.model.step());
        let mut pairs = Vec::new();
        for (i, overlap) in overlaps.iter_mut().enumerate() {
            let [one, other] = overlap.face.geoms.map(|geom| &moved[geom]);
            let around = overlap.face.geoms.map(|geom| moved[geom].turned * self.model.geom_rbound()[geom]);
            // Corners and edges come along with their bodies, contacts of what is round do not.
            let has_corners = overlap.face.geoms.iter().all(|&geom| self.facts.has_corners(geom));
            let turned = one.curve + other.curve;
            let far = if has_corners { around[0] + around[1] } else { 2.0 * (one.most + other.most) };
            let reach = NEAR_KNOWN * self.length + far;
            overlap.rolls = !has_corners && one.turned.max(other.turned) > TURN;
            overlap.deepest = NEAR_FOUND * self.length + turned;
            for (j, touch) in touches.iter().enumerate().filter(|(_, touch)| touch.face.is(&overlap.face)) {
                let distance = came_along(touch, step.data, scratch)
                    .map(|place| (place - overlap.place).norm())
                    .fold(f64::INFINITY, f64::min);
                let depth = touch.depth_after(step.velocity, time).max(-touch.gap);
                if distance < reach && overlap.depth < depth + overlap.deepest {
                    pairs.push((distance, i, j));
                }
            }
        }
        for (i, j) in nearest_first(pairs) {
            overlaps[i].known = Some(j);
        }
    }

    /// Is a geom met by another face before? Then it may be met here only because that does not bear yet: what slides from tile to tile
    /// sinks below their faces in free fall, and meets the side of the next.
    fn is_late(&self, met: &Met, found: &[Met]) -> bool {
        found.iter().any(|other| {
            other.after + AT_ONCE < met.after
                && (other.face.normal - met.face.normal).norm() > FLAT
                && self.share(&other.face, &met.face)
        })
    }

    /// Have faces a geom in common that may move?
    fn share(&self, one: &Face, other: &Face) -> bool {
        one.geoms.iter().any(|&geom| other.geoms.contains(&geom) && self.facts.moves(geom))
    }

    /// Tells of an overlap; `false` if it is not known which side was entered.
    fn tell(
        &self,
        step: &Step<'_>,
        scratch: &Data,
        overlap: Overlap,
        share: f64,
        seen: &mut Vec<Seen>,
        found: &mut Vec<Met>,
    ) -> bool {
        let known = overlap.known.map(|known| &step.touches[known]);
        if let Some(known) = known {
            let more = overlap.depth - known.depth_after(step.velocity, self.model.step());
            if !step.takes_anew
                || share < 1.0
                || (!known.is_new && (more <= self.slop || known.soft.is_some()))
            {
                return true;
            }
            if !known.is_new {
                seen.push(Seen::Deeper(known.index, more));
                return true;
            }
        }
        let near = |place: Vector3<f64>| (place - overlap.place).norm() < NEAR_FOUND * self.length;
        if known.is_none() {
            if seen.len() == MOST_NEW
                || found.iter().any(|met| met.face.geoms == overlap.face.geoms && near(met.place))
            {
                return true;
            }
            // What touched this side of a geom as the step began bears together, or the geom would tip.
            let is_it = |&(index, contact): &(usize, ContactRef<'_>)| {
                let face = Face::of(contact);
                let mut sides = contact.geoms().into_iter().zip(scratch.contact(overlap.index).geoms());
                let mut shares = || sides.any(|(one, other)| one == other && self.facts.moves(one));
                !step.taken.contains_key(&index)
                    && !contact.is_excluded()
                    && !self.is_ghost(step.data, contact)
                    && face.looks_as(&overlap.face)
                    && (face.geoms == overlap.face.geoms || shares())
            };
            let mut is_listed = false;
            for (listed, contact) in step.data.contacts().enumerate().filter(is_it) {
                let face = Face::of(contact);
                is_listed |= face.geoms == overlap.face.geoms;
                if !seen.iter().any(|seen| matches!(seen, Seen::Listed(other) if *other == listed)) {
                    found.push(Met { seen: seen.len(), face, place: contact.place().into(), after: 0.0 });
                    seen.push(Seen::Listed(listed));
                }
            }
            if is_listed {
                return true;
            }
        }
        let contact = scratch.contact(overlap.index);
        let velocity = step.velocity.iter().map(|v| v * share).collect();
        let gap = contact.gap(self.grown);
        // It rolls about its own surface, and not about the middle of an overlap.
        let apart = if overlap.rolls { gap } else { 0.0 };
        let there = There { gap, rows: jacobian(self.model, scratch, contact, apart), velocity };
        // What would have overlapped all along is the wrong side of what was entered.
        if there.gap_before(self.model.step()) < -overlap.deepest {
            return false;
        }
        if known.is_none() {
            let after = there.touches_after(self.model.step());
            found.push(Met { seen: seen.len(), face: overlap.face, place: overlap.place, after });
        }
        // With a distance that MuJoCo takes for a contact.
        let copy = OwnedContact::new(contact, -self.slop, 0.0);
        seen.push(match known {
            Some(known) => Seen::Again(known.index, copy, there),
            None => Seen::New(copy, there),
        });
        true
    }
}

/// Where a contact is that has stayed in place, or has come along with one of its geoms.
fn came_along<'a>(
    touch: &'a Touch,
    before: &'a Data,
    after: &'a Data,
) -> impl Iterator<Item = Vector3<f64>> + 'a {
    let geoms = if touch.is_new { &[][..] } else { &touch.face.geoms[..] };
    let along = |&geom: &usize| {
        let ((frame, from), (turned, to)) = (pose(before, geom), pose(after, geom));
        to + turned * frame.transpose() * (touch.place - from)
    };
    std::iter::once(touch.place).chain(geoms.iter().map(along))
}

/// How far a geom moves in a step, at most (m), and how far from a line.
pub(super) struct Moved {
    pub(super) most: f64,
    pub(super) turned: f64,
    curve: f64,
}

fn moved(model: &Model, before: &Data, after: &Data) -> Vec<Moved> {
    let places = before.geom_xpos().iter().zip(after.geom_xpos());
    let frames = before.geom_xmat().iter().zip(after.geom_xmat());
    let both = places.zip(frames).zip(model.geom_rbound());
    both.map(|(((p, q), (a, b)), radius)| {
        let along = (Vector3::from(*q) - Vector3::from(*p)).norm();
        let turned = (Matrix3::from_row_slice(b) - Matrix3::from_row_slice(a)).norm();
        let most = along + turned * radius;
        Moved { most, turned, curve: turned * most }
    })
    .collect()
}

/// The Jacobian of a contact where the data is, of surfaces so far apart (m).
fn jacobian(model: &Model, data: &Data, contact: ContactRef<'_>, apart: f64) -> Vec<f64> {
    let nv = model.sizes.velocities;
    let half = Vector3::from(contact.frame()[0]) * (apart / 2.0);
    let of = |geom: usize, surface: Vector3<f64>| data.jacobian(model, surface.into(), body_of(model, geom));
    let (place, [one, other]) = (Vector3::from(contact.place()), contact.geoms());
    let [first, second] = [of(one, place - half), of(other, place + half)];
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
