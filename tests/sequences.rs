//! The bundled sequences: consecutive time steps of one simulation, each solved from the one before.

use crate::support::boxes::BRICK;
use crate::support::check;
use nalgebra::{DMatrix, vector};
use stiction::{Error, Factor, Scene, Settings, Solver, Status};
use testbed::ContactKeys;
use testbed::kernel::{Constructor, Shape, smallest};
use testbed::measure::{self, Law};
use testbed::method::Method;
use testbed::scene_file::{self, SceneFile, repository};

/// Solves the steps of a sequence, warm or each cold; the work of each.
fn replay(kernel: Constructor, steps: &[SceneFile], warm: bool, tolerance: f64) -> Result<Vec<usize>, Error> {
    let shape = Shape::of_all(steps).expect("a step");
    let mut kernel = kernel(shape).expect("a size is compiled");
    let mut work = Vec::new();
    for step in steps {
        if !warm {
            kernel.reset();
        }
        kernel.load(step)?;
        kernel.prepare(Method::Default)?;
        kernel.solve(Method::Default, &Settings::new(tolerance))?;
        let answer = kernel.answer();
        assert_eq!(answer.status, Status::Solved, "{}", step.name);
        let error = measure::error(step, &answer.v, &answer.r, Law::Coulomb);
        assert!(error <= tolerance, "{}: {error:e}", step.name);
        work.push(answer.work.total());
    }
    Ok(work)
}

/// Work of all steps of the bundled sequences, warm and each cold, in f64 to 1e-6 and in f32 to 1e-4, as measured. One in twenty more
/// fails.
const WORK: [(&str, [usize; 2], [usize; 2]); 6] = [
    ("box_slide", [390, 1012], [172, 766]),
    ("go2_push_ice", [242, 390], [128, 288]),
    ("go2_trot", [252, 324], [164, 250]),
    ("hopper_planar", [282, 1690], [158, 1106]),
    ("stack2_1000", [618, 486], [484, 456]),
    ("stack2_1000_stick", [382, 600], [296, 600]),
];

#[test]
fn every_step_of_every_sequence_is_solved_and_a_warm_start_costs_less() -> Result<(), Error> {
    let mut changed = Vec::new();
    for (name, double, single) in WORK {
        let file = repository().join(format!("tests/sequences/{name}.json"));
        let steps = scene_file::read(&file).expect("a sequence file");
        let kernels: [(Constructor, f64, [usize; 2]); 2] =
            [(smallest::<f64>, 1e-6, double), (smallest::<f32>, 1e-4, single)];
        for (kernel, tolerance, before) in kernels {
            let work = [true, false].map(|warm| replay(kernel, &steps, warm, tolerance));
            let [warm, cold] = work;
            let (mut warm, mut cold) = (warm?, cold?);
            let now = [warm.iter().sum(), cold.iter().sum()];
            if !now.into_iter().zip(before).all(check::is_no_more) {
                changed.push(format!("{name} to {tolerance:e}: {now:?}, not {before:?}"));
            }
            warm.sort_unstable();
            cold.sort_unstable();
            let (half, most) = (warm.len() / 2, warm.len() * 95 / 100);
            // A stack that begins to slide is asked once whether it can stay. From rest it is swept: two sweeps less than a warm start takes.
            let (question, sweeps) = if name == "stack2_1000" { (100, 4) } else { (0, 0) };
            assert!(
                now[0] < now[1] + question + 16 * sweeps && warm[half] <= cold[half] + sweeps,
                "{name} to {tolerance:e}: warm {warm:?}, cold {cold:?}"
            );
            // The choice of a start that misleads comes on top of a cold solve.
            let dearest = 9 * (cold[most] + question);
            assert!(8 * warm[most] <= dearest, "{name} to {tolerance:e}: warm {warm:?}, cold {cold:?}");
        }
    }
    assert!(changed.is_empty(), "{}", changed.join("\n"));
    Ok(())
}

#[test]
fn contacts_are_recognised_by_name_and_by_where_they_are() {
    let mut keys = ContactKeys::default();
    let mut step = |contacts: &[(&str, f64)]| {
        let names: Vec<_> = contacts.iter().map(|(name, _)| (*name).into()).collect();
        let places = contacts.iter().map(|&(_, x)| x);
        let h = DMatrix::from_iterator(contacts.len(), 1, places);
        keys.of_step(&names, &h, contacts.len())
    };
    let first = step(&[("a", 0.1), ("b", 0.2), ("a", 0.9), ("c", 0.5)]);
    assert_eq!(first, [0, 1, 2, 3]);
    let second = step(&[("c", 0.5), ("a", 0.8), ("a", 0.25), ("a", 0.05), ("d", 0.1)]);
    assert_eq!(second, [3, 2, 4, 0, 5]);
    assert_eq!(step(&[("a", 0.2)]), [4]);
    assert_eq!(step(&[("b", 0.7), ("a", 0.8), ("a", 0.9)]), [1, 4, 2]); // back again
    let (unnamed, two) = (&[], DMatrix::zeros(2, 1));
    assert_eq!(keys.of_step(unnamed, &two, 2), [0, 1]);
}

/// Whatever was replaced: the scene, its factor in place, and the solution are those of a scene that
/// was built so, bit for bit.
#[test]
fn a_scene_changed_in_place_is_as_one_built_anew() -> Result<(), Error> {
    let push = BRICK.free_impulse::<f64>(0.5, 0.01);
    let mut scene = BRICK.on_plane::<f64>(0.3)?;
    let mut factor = Factor::new(&scene)?;
    let mass = scene.mass() * 1.7;
    let mut anew = Scene::<f64, 6, 3, 4>::new();
    scene.set_mass(&mass)?;
    anew.set_mass(&mass)?;
    for (i, mut contact) in scene.contacts().to_vec().into_iter().enumerate() {
        contact.jacobian[(0, 3)] += 0.1;
        contact.offset = vector![0.01, -0.02, 0.0];
        contact.mu = 0.7;
        scene.set_jacobian(i, &contact.jacobian)?;
        scene.set_offset(i, &contact.offset)?;
        scene.set_friction(i, contact.mu)?;
        anew.push(&contact)?;
    }
    factor.prepare(&scene)?;
    let settings = Settings::new(1e-9);
    let [mut changed, mut built] = [Solver::new(), Solver::new()];
    let changed = changed.solve(&scene, &factor, &push, &settings)?;
    let built = built.solve(&anew, &Factor::new(&anew)?, &push, &settings)?;
    assert_eq!(changed.velocity, built.velocity);
    assert_eq!(changed.contacts, built.contacts);
    Ok(())
}
