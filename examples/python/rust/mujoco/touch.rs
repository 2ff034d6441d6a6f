//! Contacts of a step, as the laws need them.

use super::facts::{Facts, body_of, mobility};
use super::ffi::{ContactRef, Data, Model};
use super::inertia::Inertia;
use super::outside::{Follower, Outside};
use super::softness::{Spring, Springs};
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeMap;

/// What contacts and rows are made from.
pub(super) struct Around<'a> {
    pub(super) model: &'a Model,
    pub(super) data: &'a Data,
    pub(super) springs: &'a Springs,
    pub(super) facts: &'a Facts,
    pub(super) follower: &'a Follower,
    pub(super) inertia: &'a Inertia,
}

/// A contact that takes part.
#[derive(Clone)]
pub(super) struct Touch {
    /// Its place in MuJoCo's list, and its first constraint.
    pub(super) index: usize,
    pub(super) address: usize,
    /// The same in every step in which it is at its place on its geoms.
    pub(super) key: u32,
    pub(super) dim: usize,
    pub(super) face: Face,
    pub(super) place: Vector3<f64>,
    /// Its Jacobian, row by row.
    pub(super) rows: Vec<f64>,
    /// Gap at the start of the step (m).
    pub(super) gap: f64,
    /// Velocities along its rows: of its surfaces, and from outside.
    pub(super) surface: [f64; 3],
    pub(super) outside: [f64; 6],
    pub(super) friction: [f64; 5],
    /// How much an impulse along the normal moves a free point of its bodies (1/kg), and how much it moves these.
    pub(super) mobility: f64,
    pub(super) response: f64,
    /// How its normal gives way, if the user has asked for that.
    pub(super) soft: Option<Spring>,
    /// Is one of its bodies moved from outside?
    pub(super) is_driven: bool,
    /// Was it found at the end of the step?
    pub(super) is_new: bool,
    /// How much of its depth is not from the start of the step, but what its path has of a curve (m).
    pub(super) curve: f64,
}

/// Which geoms touch, the smaller first, and along which normal.
#[derive(Clone, Copy)]
pub(super) struct Face {
    pub(super) geoms: [usize; 2],
    pub(super) normal: Vector3<f64>,
}

impl Face {
    pub(super) fn of(contact: ContactRef<'_>) -> Self {
        let mut geoms = contact.geoms();
        geoms.sort_unstable();
        Self { geoms, normal: contact.frame()[0].into() }
    }

    /// Is it a face of the same geoms, that looks the same way?
    pub(super) fn is(&self, other: &Self) -> bool {
        self.geoms == other.geoms && self.looks_as(other)
    }

    pub(super) fn looks_as(&self, other: &Self) -> bool {
        self.normal.dot(&other.normal) > SAME_NORMAL
    }
}

/// Contacts of a face as near as this are one, over the model's length.
pub(super) const NEAR: f64 = 1e-2;

/// A contact that takes part: its key, and whether it has borne in the last step.
#[derive(Clone, Copy)]
pub(super) struct Taken {
    pub(super) key: u32,
    pub(super) bore: bool,
}

/// A contact of the last step: its key, its face, where it is on its geoms, how far it has crept along it (m), and whether it bears.
pub(super) struct Live {
    pub(super) key: u32,
    pub(super) face: Face,
    pub(super) places: [Vector3<f64>; 2],
    pub(super) crept: Vector3<f64>,
    pub(super) bears: bool,
}

impl Live {
    pub(super) fn of(touch: &Touch, data: &Data, crept: Vector3<f64>, bears: bool) -> Self {
        let on = |geom: usize| {
            let (frame, centre) = pose(data, geom);
            frame.transpose() * (touch.place - centre)
        };
        Self { key: touch.key, face: touch.face, places: touch.face.geoms.map(on), crept, bears }
    }

    /// Where it is now if it has come along with its one geom, or with the other.
    pub(super) fn places_now(&self, data: &Data) -> [Vector3<f64>; 2] {
        std::array::from_fn(|i| {
            let (frame, centre) = pose(data, self.face.geoms[i]);
            centre + frame * self.places[i]
        })
    }
}

/// Contacts of the last step, and how far those that are listed now are from them.
pub(super) struct Known<'a> {
    live: &'a [Live],
    /// Where they are now.
    places: Vec<[Vector3<f64>; 2]>,
    near: f64,
    /// Distances (m), places in MuJoCo's list, and numbers of contacts of the last step.
    pairs: Vec<(f64, usize, usize)>,
}

impl<'a> Known<'a> {
    /// What is as `near` as this (m) may be the same.
    pub(super) fn new(live: &'a [Live], data: &Data, near: f64) -> Self {
        let places = live.iter().map(|live| live.places_now(data)).collect();
        Self { live, places, near, pairs: Vec::new() }
    }

    /// Is a face one of the last step?
    pub(super) fn has(&self, face: &Face) -> bool {
        self.live.iter().any(|live| live.face.is(face))
    }

    /// Looks at a contact of MuJoCo's list, and says whether its face is one of the last step.
    pub(super) fn look(&mut self, index: usize, contact: ContactRef<'_>) -> bool {
        let (face, place, mut has) = (Face::of(contact), Vector3::from(contact.place()), false);
        for (number, (_, places)) in
            self.live.iter().zip(&self.places).enumerate().filter(|(_, (live, _))| live.face.is(&face))
        {
            has = true;
            let distance = places.iter().map(|own| (own - place).norm()).fold(f64::INFINITY, f64::min);
            if distance < self.near {
                self.pairs.push((distance, index, number));
            }
        }
        has
    }

    /// Is there one with nothing near it?
    pub(super) fn lacks_any(&self) -> bool {
        (0..self.live.len()).any(|number| self.pairs.iter().all(|pair| pair.2 != number))
    }

    /// Contacts that are those of the last step, by their places in MuJoCo's list.
    pub(super) fn pairs(self) -> BTreeMap<usize, &'a Live> {
        let pairs = nearest_first(self.pairs).into_iter();
        pairs.map(|(index, number)| (index, &self.live[number])).collect()
    }
}

/// Pairs what is nearest to each other first, each only once; of distances and what they are between.
pub(super) fn nearest_first(mut pairs: Vec<(f64, usize, usize)>) -> Vec<(usize, usize)> {
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut taken: Vec<(usize, usize)> = Vec::new();
    for (_, one, other) in pairs {
        if taken.iter().all(|pair| pair.0 != one && pair.1 != other) {
            taken.push((one, other));
        }
    }
    taken
}

/// The rotation of a geom, and its centre.
pub(super) fn pose(data: &Data, geom: usize) -> (Matrix3<f64>, Vector3<f64>) {
    (Matrix3::from_row_slice(&data.geom_xmat()[geom]), data.geom_xpos()[geom].into())
}

impl Touch {
    /// Takes a contact of MuJoCo's list; `rows` in place of those at the start of the step.
    pub(super) fn new(
        around: &Around<'_>,
        index: usize,
        (key, gap): (u32, f64),
        rows: Option<&[f64]>,
        scratch: &mut Vec<f64>,
    ) -> Option<Self> {
        let Around { model, data, springs, facts, follower, inertia } = around;
        let contact = data.contact(index);
        let (address, dim, nv) = (contact.address()?, contact.dim(), model.sizes.velocities);
        let rows = rows.unwrap_or_else(|| &data.efc_j()[address * nv..][..dim * nv]).to_vec();
        let (frame, place) = (contact.frame(), contact.place());
        let bodies = contact.geoms().map(|geom| body_of(model, geom));
        let mocaps = bodies.map(|body| facts.mocap(body));
        let along = |outside: &Outside, time: f64| {
            let [first, second] = mocaps.map(|mocap| outside.velocity(mocap, data, place));
            let velocity = [second[0] - first[0], second[1] - first[1]];
            let mut along = [0.0; 6];
            for (i, (along, row)) in along.iter_mut().zip(rows.chunks_exact(nv)).enumerate() {
                let of_bodies = Vector3::from(frame[i % 3]).dot(&velocity[i / 3]);
                *along = (of_bodies + dot(row, &outside.joints)) / time;
            }
            along
        };
        // What has just begun to move has its velocity if what it touches has it, too.
        let speed = |outside: &[f64; 6]| {
            let of_row = |(row, outside): (&[f64], &f64)| (dot(row, data.qvel()) + outside).powi(2);
            rows.chunks_exact(nv).zip(outside).take(3).map(of_row).sum::<f64>()
        };
        let mut outside = along(&follower.now, 1.0);
        if follower.moves() {
            let begun = along(&follower.moved, model.step());
            if speed(&begun) < speed(&outside) {
                outside = begun;
            }
        }
        let writes = |row: &[f64]| {
            row.iter().zip(&follower.is_written).any(|(&entry, &written)| written && entry != 0.0)
        };
        Some(Self {
            index,
            address,
            key,
            dim,
            place: place.into(),
            face: Face::of(contact),
            gap,
            surface: contact.surface_velocity(),
            outside,
            friction: contact.friction(),
            mobility: bodies.map(|body| mobility(model, body)).iter().sum(),
            response: inertia.response(&rows[..nv], scratch),
            soft: springs.of_contact(contact),
            is_driven: mocaps.iter().any(Option::is_some) || rows.chunks_exact(nv).any(writes),
            is_new: false,
            curve: 0.0,
            rows,
        })
    }

    pub(super) fn normal_row(&self) -> &[f64] {
        &self.rows[..self.rows.len() / self.dim]
    }

    /// How deep it overlaps when its bodies have moved at a velocity for a time, by its row (m).
    pub(super) fn depth_after(&self, velocity: &[f64], time: f64) -> f64 {
        (-self.gap - time * dot(self.normal_row(), velocity)).max(0.0)
    }

    /// Does something move it from outside?
    pub(super) fn is_moved(&self) -> bool {
        self.outside.iter().any(|&speed| speed != 0.0)
    }

    /// The velocities along its tangents (m/s).
    pub(super) fn slip(&self, velocity: &[f64]) -> [f64; 2] {
        let mut slip = [0.0; 2];
        let tangents = self.rows.chunks_exact(velocity.len()).skip(1);
        for (i, (slip, row)) in slip.iter_mut().zip(tangents).enumerate() {
            *slip = dot(row, velocity) + self.outside[1 + i] + self.surface[i];
        }
        slip
    }

    /// Friction coefficient, 0 without tangents.
    pub(super) fn mu(&self) -> f64 {
        if self.dim > 1 { self.friction[0] } else { 0.0 }
    }
}

/// Cosine of the angle (25°) up to which normals of a pair of geoms are the same contact's.
const SAME_NORMAL: f64 = 0.9;

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (fours, others) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest = fours.remainder().iter().zip(others.remainder());
    let rest: f64 = rest.map(|(a, b)| a * b).sum();
    let mut sums = [0.0; 4];
    for (a, b) in fours.zip(others) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + rest
}

pub(super) fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most, x| most.max(x.abs()))
}
