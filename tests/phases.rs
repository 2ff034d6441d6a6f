//! Solvers that leave phases out: they promise the same, and do what they have.

use stiction::{
    AllPhases, Error, Factor, Kernel, Model, Phases, Scene, Settings, Solution, Solver, Status,
    SweepsAndNewton, SweepsOnly,
};
use testbed::generate::{self, Class, Existence};
use testbed::measure::{self, Law};
use testbed::scene_file::{SceneFile, bundled_sequences, read};

const N: usize = 18;
const C: usize = 12;

type Spatial<P> = Solver<f64, N, 3, C, 0, P>;

/// It stands in a `static`.
static SWEEPS: Kernel<f32, 6, 3, 4, 2, 4, SweepsOnly> = Kernel::with_phases(SweepsOnly);

fn fits(file: &SceneFile) -> bool {
    file.dim == 3 && file.n_dof <= N && file.n_contacts <= 6
}

/// The error that a stranger finds.
fn error(file: &SceneFile, solution: &Solution<f64, N, 3, C>, law: Law) -> f64 {
    let v = &solution.velocity.as_slice()[..file.n_dof];
    let impulses = solution.contacts.iter().flat_map(|contact| contact.impulse.iter());
    let r: Vec<f64> = impulses.copied().collect();
    measure::error(file, v, &r, law)
}

/// Solves of scenes of all classes, and how many of them were solved.
fn share<P: Phases>(phases: P, settings: &Settings<f64>) -> Result<[usize; 2], Error> {
    let law = match settings.model {
        Model::Coulomb => Law::Coulomb,
        Model::ConvexRelaxation => Law::Relaxed,
    };
    let [mut scenes, mut solved] = [0; 2];
    for index in 0..40 {
        for class in Class::ALL {
            let (file, existence) = generate::draw(class, 4, index);
            if !fits(&file) || existence == Existence::Infeasible {
                continue;
            }
            let scene = file.scene::<f64, N, 3, C>()?;
            let Ok(factor) = Factor::new(&scene) else {
                continue; // a mass matrix that is not positive definite, once rounded
            };
            let mut solver = Spatial::with_phases(phases);
            let push = file.free_impulse();
            let solution = solver.solve(&scene, &factor, &push, settings)?;
            let work = solution.work;
            assert!(P::NEWTON || work.total() == 2 * work.sweeps);
            assert!(P::CENTRAL_PATH || work.proof_searches == 0);
            assert!(work.total() <= settings.budget + 27);
            scenes += 1;
            if solution.is_solved() {
                solved += 1;
                let found = error(&file, solution, law);
                assert!(found <= settings.tolerance, "{}: {found}", file.name);
            }
        }
    }
    Ok([scenes, solved])
}

/// Two percent of slack both ways: a gain is written down as a loss is.
fn is_about(count: usize, of: usize, percent: usize) -> bool {
    (100 * count).abs_diff(percent * of) <= 2 * of
}

#[test]
fn what_is_called_solved_is() -> Result<(), Error> {
    let settings = Settings::new(1e-6);
    let [scenes, all] = share(AllPhases, &settings)?;
    let [_, newton] = share(SweepsAndNewton, &settings)?;
    let [_, sweeps] = share(SweepsOnly, &settings)?;
    assert!(is_about(all, scenes, 100), "{all} of {scenes}");
    assert!(is_about(newton, scenes, 94), "{newton} of {scenes}");
    assert!(is_about(sweeps, scenes, 88), "{sweeps} of {scenes}");
    Ok(())
}

#[test]
fn the_relaxation_is_swept_too() -> Result<(), Error> {
    let settings = Settings { model: Model::ConvexRelaxation, ..Settings::new(1e-4) };
    let [scenes, sweeps] = share(SweepsOnly, &settings)?;
    assert!(is_about(sweeps, scenes, 88), "{sweeps} of {scenes}");
    Ok(())
}

/// A sequence tick by tick, all at once and in the smallest pieces.
fn trot<P: Phases>(phases: P, steps: &[SceneFile]) -> Result<usize, Error> {
    let whole = Settings::new(1e-6);
    let piece = Settings { budget: 1, ..whole };
    let (mut solver, mut in_pieces) = (Spatial::with_phases(phases), Spatial::with_phases(phases));
    let mut work = 0;
    for file in steps {
        let (scene, push) = (file.scene()?, file.free_impulse());
        let factor = Factor::new(&scene)?;
        while !in_pieces.advance(&scene, &factor, &push, &piece)? {}
        let solution = solver.solve(&scene, &factor, &push, &whole)?;
        assert!(solution.is_solved(), "{}: {:?}", file.name, solution.status);
        assert_eq!(solution.velocity, in_pieces.solution().velocity);
        assert!(error(file, solution, Law::Coulomb) <= 1e-6);
        work += solution.work.total();
    }
    Ok(work)
}

#[test]
fn each_walks_with_warm_starts() -> Result<(), Error> {
    let path = bundled_sequences().into_iter().find(|path| path.ends_with("go2_trot.json"));
    let steps = read(&path.expect("it is bundled")).expect("a sequence");
    let all = trot(AllPhases, &steps)?;
    let newton = trot(SweepsAndNewton, &steps)?;
    let sweeps = trot(SweepsOnly, &steps)?;
    assert_eq!(all, newton);
    assert!(sweeps < 2 * all, "{sweeps} for {all}");
    Ok(())
}

#[test]
fn walls_that_close_end_the_budget_of_sweeps() -> Result<(), Error> {
    let mut kernel = SWEEPS.clone();
    let scene: &mut Scene<f32, 6, 3, 4, 2, 4> = kernel.scene_mut();
    scene.set_mass(&nalgebra::Matrix6::identity())?;
    for (key, normal) in [(0, 1.0), (1, -1.0)] {
        let mut jacobian = nalgebra::SMatrix::<f32, 3, 6>::identity();
        jacobian[(0, 0)] = normal;
        scene.push(&stiction::Contact {
            jacobian,
            offset: nalgebra::vector![-0.1, 0.0, 0.0],
            mu: 0.5,
            key,
        })?;
    }
    let solution = kernel.solve(&nalgebra::SVector::zeros(), &Settings::default())?;
    assert_eq!(solution.status, Status::OutOfBudget);
    assert!(solution.error > 1e-4);
    Ok(())
}

/// A body that falls upon a contact without friction, of any number of rows.
fn falls_without_friction<P: Phases, const D: usize>(phases: P) -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 6, D, 4, 6, 4, P>::with_phases(phases);
    kernel.scene_mut().set_mass(&nalgebra::Matrix6::identity())?;
    let contact = stiction::Contact {
        jacobian: nalgebra::SMatrix::identity(),
        offset: nalgebra::SVector::zeros(),
        mu: 0.0,
        key: 0,
    };
    let ice = stiction::Surface { friction: [0.0; 2], spin: 0.0, roll: [0.0; 2], compliance: [0.0; 2] };
    kernel.scene_mut().push_on(&contact, &ice)?;
    let push = nalgebra::vector![-1.0, 0.1, 0.2, 0.3, 0.4, 0.5];
    let solution = kernel.solve(&push, &Settings::new(1e-6))?;
    assert!(solution.is_solved(), "{D} rows: {:?}", solution.status);
    assert_eq!(solution.work.total(), 2, "{D} rows: one sweep");
    Ok(())
}

#[test]
fn one_sweep_solves_a_contact_without_friction() -> Result<(), Error> {
    falls_without_friction::<_, 1>(SweepsOnly)?;
    falls_without_friction::<_, 3>(SweepsOnly)?;
    falls_without_friction::<_, 4>(SweepsOnly)?;
    falls_without_friction::<_, 6>(SweepsOnly)?;
    falls_without_friction::<_, 6>(AllPhases)
}
