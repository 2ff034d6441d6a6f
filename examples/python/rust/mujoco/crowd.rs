//! Fewer contacts, where a pair of faces has more than hold it.

use super::ffi::Data;
use super::touch::{Face, Touch};
use nalgebra::Vector3;
use stiction_kernels::sizes;

/// Up to so many contacts nothing is left out, nor of a pair of faces.
const FEW: usize = 8;
const FEW_OF_PAIR: usize = 4;
/// From here on a step takes long.
const MANY: usize = 24;
/// Directions along a face in which its outermost contact stays.
const DIRECTIONS: u32 = 8;

/// How far apart normals of one face may be: of a flat one, and, where there is no room for all, of a round one.
pub(super) const FLAT: f64 = 1e-4;
const ROUND: f64 = 0.5;
/// What overlaps by more than this share of the model's length does so for good.
const DEEP: f64 = 1e-3;

/// Leaves out contacts of an island: those inside of a face, of a round one only where there are many. What is soft bears at each of its
/// points, as far as there is room.
pub(super) fn thin(island: &mut Vec<usize>, touches: &[Touch], length: f64) {
    let is_soft = island.iter().any(|&place| touches[place].soft.is_some());
    let dim = if island.iter().all(|&place| touches[place].dim <= 3) { 3 } else { 6 };
    let [few, many] = if is_soft { [sizes::most_contacts(dim); 2] } else { [FEW, MANY] };
    if island.len() > few {
        thin_faces(island, touches, (FLAT, f64::INFINITY), DIRECTIONS);
    }
    for (directions, enough, highest) in [
        (DIRECTIONS, many, f64::INFINITY),
        (DIRECTIONS / 2, many, f64::INFINITY),
        // Of what overlaps few or one, as it has no exact answer anyway.
        (DIRECTIONS / 4, many, -DEEP * length),
        (0, many, -DEEP * length),
    ] {
        if island.len() > enough {
            thin_faces(island, touches, (ROUND, highest), directions);
        }
    }
}

/// Leaves out what is inside of faces whose contacts all have at most a gap.
fn thin_faces(island: &mut Vec<usize>, all: &[Touch], (apart, highest): (f64, f64), directions: u32) {
    let touches: Vec<&Touch> = island.iter().map(|&place| &all[place]).collect();
    let mut stays = vec![true; touches.len()];
    let mut is_done = vec![false; touches.len()];
    for first in 0..touches.len() {
        if is_done[first] {
            continue;
        }
        let normal = touches[first].face.normal;
        let same = |touch: &&Touch| {
            touch.face.geoms == touches[first].face.geoms && (touch.face.normal - normal).norm() < apart
        };
        let face: Vec<_> = (first..touches.len()).filter(|&i| !is_done[i] && same(&touches[i])).collect();
        for &i in &face {
            is_done[i] = true;
        }
        let is_higher = face.iter().any(|&i| touches[i].gap > highest);
        if is_higher || face.len() <= FEW_OF_PAIR.min(directions as usize) {
            continue;
        }
        for &i in &face {
            stays[i] = false;
        }
        let deepest = face.iter().copied().max_by(|&a, &b| touches[b].gap.total_cmp(&touches[a].gap));
        let outermost = outermost(normal, &face, |i| touches[i].place, directions);
        outermost.chain(deepest).for_each(|i| stays[i] = true);
    }
    let mut stays = stays.into_iter();
    island.retain(|_| stays.next().unwrap_or(true));
}

/// The contacts of a face that are farthest in so many directions.
fn outermost(
    normal: Vector3<f64>,
    face: &[usize],
    place: impl Fn(usize) -> Vector3<f64>,
    directions: u32,
) -> impl Iterator<Item = usize> {
    let across = if normal.x.abs() < 0.8 { Vector3::x() } else { Vector3::y() };
    let one = normal.cross(&across).normalize();
    let other = normal.cross(&one);
    (0..directions).filter_map(move |i| {
        let angle = 0.1 + f64::from(i) * std::f64::consts::TAU / f64::from(directions);
        let direction = one * angle.cos() + other * angle.sin();
        let along = |i: usize| place(i).dot(&direction);
        face.iter().copied().max_by(|&a, &b| along(a).total_cmp(&along(b)))
    })
}

/// Of contacts of MuJoCo's list the corners of their faces, each once: what else is listed of a face changes from step to step.
pub(super) fn corners(data: &Data, mut contacts: Vec<usize>, near: f64) -> Vec<usize> {
    let place = |i: usize| Vector3::from(data.contact(i).place());
    let mut corners: Vec<usize> = Vec::new();
    while let Some(&first) = contacts.first() {
        let own = Face::of(data.contact(first));
        let is_other = |i: &usize| !Face::of(data.contact(*i)).is(&own);
        let (others, face) = contacts.into_iter().partition(is_other);
        let face: Vec<_> = face;
        for corner in outermost(own.normal, &face, place, DIRECTIONS) {
            let is_there = |&other: &usize| (place(other) - place(corner)).norm() < near;
            if !corners.iter().any(|other| face.contains(other) && is_there(other)) {
                corners.push(corner);
            }
        }
        contacts = others;
    }
    corners
}
