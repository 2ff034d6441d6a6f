//! The derivative of a solution against differences of solutions, forward against backward, and chains of time steps.

mod chains;
mod direction;
mod marks;
mod single;

use direction::{Draws, What, inputs, moved};
use std::path::Path;
use stiction::{Derivative, Inputs, Kernel, Model, Outputs, Real, RowMode, Settings, Solution};
use testbed::format;
use testbed::generate::{self, Class};
use testbed::mixed::MixedFile;
use testbed::scene_file;

const SETTINGS: Settings<f64> = Settings { budget: 5_000, ..Settings::new(1e-14) };

/// How far a scene moves to find its direction: bounds stay in order.
const END: f64 = 1.0 / 1024.0;

/// What came of a comparison with differences.
#[derive(Debug, Default)]
struct Tally {
    compared: usize,
    near_a_change: usize,
    hyperstatic: usize,
    not_unique: usize,
    worst: f64,
    failures: Vec<String>,
}

/// A file of contacts and joint rows from any scene file.
fn file(text: &str) -> MixedFile {
    format::read_text(text, "file").expect("a scene file").remove(0)
}

fn read(path: &Path) -> MixedFile {
    file(&std::fs::read_to_string(path).expect("it can be read"))
}

type Sized<const N: usize, const D: usize, const C: usize, const R: usize> = Kernel<f64, N, D, C, R, C>;

/// The kernel with this file, limits among its rows.
fn filled<const N: usize, const D: usize, const C: usize, const R: usize>(
    file: &MixedFile,
) -> Box<Sized<N, D, C, R>> {
    let mut kernel = Box::new(Sized::new());
    for limit in file.fill(kernel.scene_mut()).expect("a valid scene") {
        kernel.scene_mut().push_row(&limit).expect("there is room");
    }
    kernel
}

fn modes<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    solution: &Solution<T, N, D, C, R>,
) -> (Vec<stiction::ContactMode>, Vec<RowMode>) {
    (
        solution.contacts.iter().map(|contact| contact.mode).collect(),
        solution.rows.iter().map(|row| row.mode).collect(),
    )
}

/// The scalar product of weights with a change of a solution.
fn value<const N: usize, const D: usize, const C: usize, const R: usize>(
    weights: &Outputs<f64, N, D, C, R>,
    change: &Outputs<f64, N, D, C, R>,
) -> [f64; 2] {
    let pairs = || {
        let contacts = weights.impulses.iter().flatten();
        let others = change.impulses.iter().flatten();
        let velocities = weights.velocity.iter().zip(&change.velocity);
        let rows = weights.row_impulses.iter().zip(&change.row_impulses);
        velocities.chain(contacts.zip(others)).chain(rows)
    };
    [pairs().map(|(a, b)| a * b).sum(), pairs().map(|(a, b)| (a * b).abs()).sum()]
}

fn gradient_value<const N: usize, const D: usize, const C: usize, const R: usize>(
    gradient: &Inputs<f64, N, D, C, R>,
    change: &Inputs<f64, N, D, C, R>,
) -> [f64; 2] {
    let pairs = || {
        let impulse = gradient.free_impulse.iter().zip(&change.free_impulse);
        let others = change.offsets.iter().flatten();
        let offsets = gradient.offsets.iter().flatten().zip(others);
        let friction = gradient.friction.iter().zip(&change.friction);
        let rows = gradient.row_offsets.iter().zip(&change.row_offsets);
        let bounds = gradient.bounds.iter().flatten();
        let bounds = bounds.zip(change.bounds.iter().flatten());
        impulse.chain(offsets).chain(friction).chain(rows).chain(bounds)
    };
    [pairs().map(|(a, b)| a * b).sum(), pairs().map(|(a, b)| (a * b).abs()).sum()]
}

/// Compares forward with adjoint, with weights that are drawn.
fn check_adjoint<const N: usize, const D: usize, const C: usize, const R: usize>(
    name: &str,
    derivative: &Derivative<'_, f64, N, D, C, R, C>,
    change: &Inputs<f64, N, D, C, R>,
    tally: &mut Tally,
) {
    let mut draws = Draws::new(5);
    let mut weights = Outputs::<f64, N, D, C, R>::zero();
    weights.velocity.iter_mut().for_each(|x| *x = draws.next());
    weights.impulses.iter_mut().flatten().for_each(|x| *x = draws.next());
    weights.row_impulses.iter_mut().for_each(|x| *x = draws.next());
    let response = derivative.forward(change);
    let gradient = derivative.adjoint(&weights);
    let ([one, size], [other, other_size]) = (value(&weights, &response), gradient_value(&gradient, change));
    if (one - other).abs() > 1e-9 * (size + other_size) {
        tally.failures.push(format!("{name}: forward {one:e}, adjoint {other:e}"));
    }
}

/// Compares with central differences, extrapolated; of scenes away from a change of mode.
fn compare<const N: usize, const D: usize, const C: usize, const R: usize>(
    file: &MixedFile,
    model: Model,
    tally: &mut Tally,
) {
    let settings = Settings { model, ..SETTINGS };
    let mut kernel = filled::<N, D, C, R>(file);
    let push = file.free_impulse();
    let solved = kernel.solve(&push, &settings);
    let usable = Settings { tolerance: 1e-11, ..settings };
    if !solved.is_ok_and(|solution| solution.is_usable(usable.tolerance)) {
        return;
    }
    let solution = kernel.solution().clone();
    let derivative = kernel.derivative(&usable).expect("it is solved");
    if derivative.margin() < 1e-4 {
        tally.near_a_change += 1;
        return;
    }
    let what = if derivative.has_unique_impulses() {
        What::All
    } else {
        tally.hyperstatic += 1;
        match model {
            Model::Coulomb => What::Momentum,
            Model::ConvexRelaxation => What::Impulse,
        }
    };
    if !derivative.has_unique_velocity() {
        tally.not_unique += 1;
        return;
    }
    for seed in 0..2 {
        let end = moved(file, seed, what, END);
        let end_kernel = filled::<N, D, C, R>(&end);
        let scenes = (kernel.scene(), end_kernel.scene());
        let change = inputs((file, scenes.0), (&end, scenes.1), &solution);
        let response = derivative.forward(&change).velocity / END;
        check_adjoint(&file.name, &derivative, &change, tally);
        let misfit = derivative.misfit(&change);
        let at = |h: f64| {
            let file = moved(file, seed, what, h);
            let mut kernel = filled::<N, D, C, R>(&file);
            let start = solution.contacts.iter().map(|found| (found.key, found.impulse));
            let rows = solution.rows.iter().map(|found| (found.key, found.impulse));
            let (start, rows): (Vec<_>, Vec<_>) = (start.collect(), rows.collect());
            let warm = kernel.solver_mut().set_impulses(&start, &rows);
            warm.expect("there is room");
            let found = kernel.solve(&file.free_impulse(), &settings);
            let found = found.expect("a valid scene");
            (modes(found) == modes(&solution)).then_some(found.velocity)
        };
        let difference = |h: f64| Some((at(h)? - at(-h)?) / (2.0 * h));
        // What holds hardly moves: then what the change does without contacts is the measure.
        let impulse = change.free_impulse.rows(0, file.n_dof);
        let free = file.mass().try_inverse().expect("a mass") * impulse / END;
        let error = |step: f64| {
            let expected = (difference(step * 0.5)? * 4.0 - difference(step)?) / 3.0;
            Some((response - expected).norm() / expected.norm().max(1e-2 * free.norm()))
        };
        // Large steps are bent, small ones rounded.
        let reach = derivative.margin().min(1.0);
        let errors = [3e-3, 1e-3, 1e-4, 1e-5, 1e-6].map(|share| error(reach * share));
        let Some(error) = errors.into_iter().flatten().reduce(f64::min) else {
            tally.near_a_change += 1;
            continue;
        };
        tally.compared += 1;
        tally.worst = tally.worst.max(error);
        if error > 1e-6 || misfit > 1e-6 {
            tally.failures.push(format!(
                "{} {model:?} {what:?}: {error:.1e}, misfit {misfit:.1e}, margin {:.1e} {:?}",
                file.name,
                derivative.margin(),
                modes(&solution)
            ));
        }
    }
}

/// In a size that holds it, if one is compiled.
fn compare_any(file: &MixedFile, model: Model, tally: &mut Tally) {
    match (file.dim, file.n_dof, file.n_contacts, file.joints.len()) {
        (2, ..=30, ..=12, ..=36) => compare::<30, 2, 12, 36>(file, model, tally),
        (3, ..=30, ..=12, ..=36) => compare::<30, 3, 12, 36>(file, model, tally),
        (4, ..=30, ..=12, ..=36) => compare::<30, 4, 12, 36>(file, model, tally),
        (6, ..=30, ..=12, ..=36) => compare::<30, 6, 12, 36>(file, model, tally),
        _ => {}
    }
}

#[test]
fn bundled_scenes_move_as_differences_say() {
    let mut tally = Tally::default();
    let mixed = scene_file::json_files(&scene_file::repository().join("tests/mixed"));
    for path in scene_file::bundled().iter().chain(&mixed) {
        let file = read(path);
        for model in [Model::Coulomb, Model::ConvexRelaxation] {
            compare_any(&file, model, &mut tally);
        }
    }
    assert!(tally.failures.is_empty(), "{tally:#?}");
    assert!(tally.compared >= 150, "{tally:#?}");
}

#[test]
fn drawn_scenes_move_as_differences_say() {
    let mut tally = Tally::default();
    for &class in Class::DRAWN {
        for scene in generate::solvable(class, 30) {
            if scene.n_dof <= 30 && scene.n_contacts <= 12 && scene.dim == 3 {
                let mut file = file(&scene.json());
                file.name = scene.name.clone();
                compare_any(&file, Model::Coulomb, &mut tally);
            }
        }
    }
    assert!(tally.failures.is_empty(), "{tally:#?}");
    assert!(tally.compared >= 200, "{tally:#?}");
}

#[test]
fn drawn_scenes_with_joint_rows_move_as_differences_say() {
    let mut tally = Tally::default();
    for index in 0..150 {
        let mut file = generate::mixed(1, index, true);
        file.name = format!("mixed {index}");
        compare_any(&file, Model::Coulomb, &mut tally);
    }
    assert!(tally.failures.is_empty(), "{tally:#?}");
    assert!(tally.compared >= 200, "{tally:#?}");
}
