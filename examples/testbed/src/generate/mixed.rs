//! Scenes of contacts and joint rows, their time steps, and scenes of which `W` is given.

use super::random::{Random, real};
use crate::mixed::{Friction, Joint, MixedFile};
use crate::scene_file::SceneFile;
use nalgebra::{DMatrix, DVector};

/// A scene of contacts and joint rows, of which nobody knows whether it has a solution; its limits inside, or given to the solve.
#[must_use]
pub fn mixed(seed: u64, index: u64, limits_inside: bool) -> MixedFile {
    draw(&mut Random::new(seed, index), limits_inside)
}

/// Time steps of such a scene: contacts and joint rows come, go and change places, and all numbers change a little.
#[must_use]
pub fn time_steps(seed: u64, index: u64) -> Vec<MixedFile> {
    let mut random = Random::new(seed, index);
    let inside = random.one_in(2);
    let mut file = draw(&mut random, inside);
    let mut steps = Vec::new();
    for _ in 0..5 {
        let mut step = file.clone();
        reorder(&mut random, &mut step);
        steps.push(step);
        let share = if random.one_in(3) { 0.3 } else { 0.02 };
        let mut shake = |x: &mut f64| *x += share * x.abs() * random.normal();
        file.f.iter_mut().chain(&mut file.w).for_each(&mut shake);
        file.h.iter_mut().flatten().for_each(&mut shake);
        file.joints.iter_mut().for_each(|joint| shake(&mut joint.offset));
    }
    steps
}

/// Time steps of a scene of contacts alone, likewise.
pub(super) fn steps_of(seed: u64, index: u64, scene: &SceneFile) -> Vec<SceneFile> {
    let mut random = Random::new(!seed, index);
    let (d, mut next, mut steps) = (scene.dim, scene.clone(), Vec::new());
    for _ in 0..5 {
        let (kept, names) = shuffled(&mut random, next.n_contacts);
        let mut step = next.clone();
        step.n_contacts = kept.len();
        step.mu = kept.iter().map(|&i| next.mu[i]).collect();
        step.keys = names;
        let row = |k: usize| d * kept[k / d] + k % d;
        step.h = DMatrix::from_fn(d * kept.len(), next.n_dof, |k, j| next.h[(row(k), j)]);
        step.w = DVector::from_fn(d * kept.len(), |k, _| next.w[row(k)]);
        steps.push(step);
        let share = if random.one_in(3) { 0.3 } else { 0.02 };
        let mut shake = |x: &mut f64| *x += share * x.abs() * random.normal();
        next.f.iter_mut().chain(&mut next.h).for_each(&mut shake);
    }
    steps
}

/// Some of so many things, in another order, and their names.
fn shuffled(random: &mut Random, total: usize) -> (Vec<usize>, Vec<u32>) {
    let (from, reversed) = (random.count(0, total), random.one_in(2));
    let mut kept: Vec<usize> = (0..total).filter(|_| !random.one_in(4)).collect();
    let from = from % kept.len().max(1);
    kept.rotate_left(from);
    if reversed {
        kept.reverse();
    }
    let names = kept.iter().map(|&i| u32::try_from(i).unwrap_or(0)).collect();
    (kept, names)
}

/// Leaves out some contacts and rows, and turns the others round.
fn reorder(random: &mut Random, file: &mut MixedFile) {
    let (d, total) = (file.dim, file.n_contacts + file.joints.len());
    let (kept, _) = shuffled(random, total);
    let old = file.clone();
    let contacts: Vec<usize> = kept.iter().copied().filter(|&i| i < old.n_contacts).collect();
    let joints: Vec<usize> = kept.into_iter().filter(|&i| i >= old.n_contacts).collect();
    file.n_contacts = contacts.len();
    file.keys = contacts.iter().chain(&joints).map(|&i| old.keys[i]).collect();
    let rows = contacts.iter().flat_map(|&i| i * d..(i + 1) * d);
    file.h = rows.clone().map(|k| old.h[k].clone()).collect();
    file.w = rows.map(|k| old.w[k]).collect();
    file.mu = contacts.iter().map(|&i| old.mu[i].clone()).collect();
    file.compliance = contacts.iter().map(|&i| old.compliance[i]).collect();
    let joint = |&i: &usize| old.joints[i - old.n_contacts].clone();
    file.joints = joints.iter().map(joint).collect();
}

fn draw(random: &mut Random, limits_inside: bool) -> MixedFile {
    let n = random.pick(&[1, 2, 3, 4, 6, 6, 7, 9, 12, 18, 24]);
    let dim = random.pick(&[2, 3, 3, 3, 4, 6]);
    let n_contacts = random.count(0, 4);
    let count = random.count(1, 6);
    let spread = if random.one_in(4) { 3.0 } else { 0.3 };
    let units: Vec<f64> = (0..n).map(|_| random.power_of_ten(-spread, spread)).collect();
    let root: Vec<_> = (0..n).map(|_| random.normals(n)).collect();
    let entry = |i: usize, j: usize| {
        let (i, j) = (i.min(j), i.max(j));
        let own = if i == j { 0.1 * real(n) } else { 0.0 };
        (root[i].dot(&root[j]) + own) * units[i] * units[j]
    };
    let mass = (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect();
    let mut vector = |scale: f64| -> Vec<f64> {
        let sparse = random.one_in(2);
        let numbers =
            (0..n).map(|j| if sparse && random.one_in(2) { 0.0 } else { scale * random.normal() * units[j] });
        numbers.collect()
    };
    let h = (0..dim * n_contacts).map(|_| vector(1.0)).collect();
    let rows: Vec<_> = (0..count).map(|_| vector(1.0)).collect();
    let f = vector(1.0);
    let w = (0..dim * n_contacts).map(|_| match random.count(0, 2) {
        0 => 0.0,
        _ => 0.3 * random.normal(),
    });
    let w = w.collect();
    let mut coefficient = || match random.count(0, 7) {
        0 => 0.0,
        1 => 10.0,
        _ => random.uniform(0.05, 1.5),
    };
    let mu = (0..n_contacts).map(|i| match i % 2 {
        0 => Friction::Isotropic(coefficient()),
        _ => Friction::Rows((1..dim).map(|_| coefficient()).collect()),
    });
    let mu = mu.collect();
    let mut soft = || {
        if random.one_in(4) { random.uniform(0.0, 1.0) } else { 0.0 }
    };
    let compliance = (0..n_contacts).map(|_| [soft(), soft()]).collect();
    let joints = rows.into_iter().map(|row| joint(random, row)).collect();
    MixedFile {
        name: String::new(),
        n_dof: n,
        n_contacts,
        dim,
        mass,
        h,
        f,
        w,
        mu,
        joints,
        compliance,
        keys: (0..100).collect(),
        time_step: None,
        limits_inside,
    }
}

fn joint(random: &mut Random, mut row: Vec<f64>) -> Joint {
    let scale = if random.one_in(4) { random.power_of_ten(-3.0, 3.0) } else { 1.0 };
    for entry in &mut row {
        *entry *= scale;
    }
    let kind = random.pick(&["limit", "equality", "box", "box"]);
    // Narrow ones, which are reached, and some that are fixed, or hold against equalities by far.
    let size = random.power_of_ten(-2.0, 2.5) / scale;
    let (lower, upper) = match random.count(0, 5) {
        0 => (size, size),
        1 => (0.3 * size, size),
        _ => (-size, size * random.uniform(0.1, 1.0)),
    };
    Joint {
        kind: kind.to_owned(),
        row,
        offset: if random.one_in(3) { 0.0 } else { 0.5 * scale * random.normal() },
        lower: Some(lower),
        upper: Some(upper),
        compliance: if random.one_in(4) { scale * scale * random.uniform(0.0, 1.0) } else { 0.0 },
    }
}
