//! Fewer contacts, where a pair of faces has more than hold it, or a scene more than there is room for.

use super::touch::{Touch, dot};
use crate::sizes;
use nalgebra::Vector3;

/// Up to so many contacts nothing is left out, nor of a pair of faces.
const FEW: usize = 8;
const FEW_OF_PAIR: usize = 4;
/// Directions along a face in which its outermost contact stays.
const DIRECTIONS: u32 = 8;

/// Leaves out contacts inside of a face; then those that are reached last, down to what is compiled. Returns how many of these.
pub(super) fn thin(touches: &mut Vec<Touch>, velocity: &[f64], h: f64) -> usize {
    if touches.len() > FEW {
        thin_faces(touches);
    }
    let dim = if touches.iter().all(|touch| touch.dim <= 3) { 3 } else { 6 };
    let most = sizes::most_contacts(dim);
    let left_out = touches.len().saturating_sub(most);
    if left_out > 0 {
        let gap = |touch: &Touch| touch.gap / h + dot(touch.normal_row(), velocity).min(0.0);
        touches.sort_by(|a, b| gap(a).total_cmp(&gap(b)));
        touches.truncate(most);
        touches.sort_by_key(|touch| touch.index);
    }
    left_out
}

fn thin_faces(touches: &mut Vec<Touch>) {
    let mut stays = vec![true; touches.len()];
    let mut is_done = vec![false; touches.len()];
    for first in 0..touches.len() {
        if is_done[first] {
            continue;
        }
        let normal = touches[first].normal;
        let same = |touch: &Touch| touch.geoms == touches[first].geoms && (touch.normal - normal).norm() < 1e-4;
        let face: Vec<_> = (first..touches.len()).filter(|&i| !is_done[i] && same(&touches[i])).collect();
        face.iter().for_each(|&i| is_done[i] = true);
        if face.len() <= FEW_OF_PAIR {
            continue;
        }
        face.iter().for_each(|&i| stays[i] = false);
        let by = |f: &dyn Fn(usize) -> f64| face.iter().copied().max_by(|&a, &b| f(a).total_cmp(&f(b)));
        let across = if normal.x.abs() < 0.8 { Vector3::x() } else { Vector3::y() };
        let one = normal.cross(&across).normalize();
        let other = normal.cross(&one);
        let outermost = (0..DIRECTIONS).filter_map(|i| {
            let angle = 0.1 + f64::from(i) * std::f64::consts::TAU / f64::from(DIRECTIONS);
            let direction = one * angle.cos() + other * angle.sin();
            by(&|i| touches[i].place.dot(&direction))
        });
        let deepest = by(&|i| -touches[i].gap);
        outermost.chain(deepest).for_each(|i| stays[i] = true);
    }
    let mut stays = stays.into_iter();
    touches.retain(|_| stays.next().unwrap_or(true));
}
