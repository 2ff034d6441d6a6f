//! Derivatives in single precision beside those in double.

use super::direction::Draws;
use super::{modes, read};
use stiction::{Factor, Inputs, JointRow, Real, Scene, Settings, Solution, Solver};
use testbed::mixed::MixedFile;
use testbed::scene_file;

const N: usize = 30;
const D: usize = 3;
const C: usize = 12;
const R: usize = 36;

/// How the velocity moves with a change of the free impulse, in this number type; and what kind of solution it is.
struct Answer {
    modes: (Vec<stiction::ContactMode>, Vec<stiction::RowMode>),
    unique: bool,
    margin: f64,
    velocity: Vec<f64>,
}

fn double<T: Real>(x: &T) -> f64 {
    x.to_subset().unwrap_or(f64::NAN)
}

fn answer<T: Real>(file: &MixedFile, tolerance: f64) -> Option<Answer> {
    let mut scene = Scene::<T, N, D, C, R, C>::new();
    let limits: Vec<JointRow<T, N>> = file.fill(&mut scene).ok()?;
    for limit in limits {
        scene.push_row(&limit).ok()?;
    }
    let factor = Factor::new(&scene).ok()?;
    let (settings, mut solver) = (Settings::new(T::literal(tolerance)), Solver::new());
    let push = file.free_impulse();
    let solved = solver.solve(&scene, &factor, &push, &settings);
    let solution: Solution<T, N, D, C, R> = solved.ok().filter(|found| found.is_solved())?.clone();
    let derivative = stiction::Derivative::new(&scene, &factor, &solution, &settings).ok()?;
    let (mut change, mut draws) = (Inputs::<T, N, D, C, R>::zero(), Draws::new(3));
    for (i, entry) in change.free_impulse.iter_mut().enumerate().take(file.n_dof) {
        *entry = T::literal(draws.next() * file.mass[i][i].sqrt());
    }
    let velocity = derivative.forward(&change).velocity;
    Some(Answer {
        modes: modes(&solution),
        unique: derivative.has_unique_impulses(),
        margin: double(&derivative.margin()),
        velocity: velocity.iter().map(double).collect(),
    })
}

fn compare(file: &MixedFile, compared: &mut usize, failures: &mut Vec<String>) {
    let (double, single) = (answer::<f64>(file, 1e-11), answer::<f32>(file, 1e-5));
    let (Some(double), Some(single)) = (double, single) else {
        return;
    };
    if double.modes != single.modes || double.margin < 1e-3 {
        return;
    }
    let energy = |v: &[f64]| {
        let own = v.iter().zip(&file.mass).enumerate();
        own.map(|(i, (v, row))| v * v * row[i]).sum::<f64>()
    };
    let pairs = double.velocity.iter().zip(&single.velocity);
    let difference: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
    // Of a change that would have an energy of about one for each velocity without contacts.
    let error = energy(&difference).sqrt();
    *compared += 1;
    if error > 1e-3 || double.unique != single.unique {
        failures.push(format!("{}: {error:.1e}, unique {} {}", file.name, double.unique, single.unique));
    }
}

#[test]
fn bundled_scenes_move_in_single_precision_as_in_double() {
    let (mut compared, mut failures) = (0, Vec::new());
    let mixed = scene_file::json_files(&scene_file::repository().join("tests/mixed"));
    for path in scene_file::bundled().iter().chain(&mixed) {
        let file = read(path);
        if file.dim == D {
            compare(&file, &mut compared, &mut failures);
        }
    }
    assert!(failures.is_empty(), "{compared}: {failures:#?}");
    assert!(compared >= 30, "{compared}");
}
