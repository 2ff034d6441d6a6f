//! A paused solve goes on with its own data, and with no other.

use crate::support::boxes::{BRICK, point_jacobian};
use crate::support::random::{draws, numbers};
use crate::support::sizes::{block_rows, body_rows};
use nalgebra::{Matrix2, SVector, matrix, vector};
use stiction::{
    AdmmFactor, AdmmSolver, Contact, Error, Factor, JointRow, Model, RowLaw, Scene, Settings, Solution,
    Status, Work,
};

/// A standing body of two contacts, and joints of three laws.
type Small = body_rows::Solver<f64>;

fn small_scene() -> Result<body_rows::Scene<f64>, Error> {
    let mut scene = Scene::new();
    scene.set_mass(&BRICK.mass_matrix())?;
    for (key, corner) in (0..).zip(BRICK.corners().into_iter().take(2)) {
        scene.push(&Contact {
            jacobian: point_jacobian(&corner),
            offset: vector![0.01, 0.02, -0.01],
            mu: 0.4,
            key,
        })?;
    }
    let (lower, upper) = (-0.02, 0.03);
    for (key, law) in (0..).zip([RowLaw::Limit, RowLaw::Equality, RowLaw::Box { lower, upper }]) {
        let entry = |k: usize| 0.3 * f64::from(u8::try_from(7 * k % 5).unwrap_or(0)) - 0.4;
        scene.push_row(&JointRow {
            row: SVector::from_fn(|k, _| entry(k + usize::try_from(key).unwrap_or(0))),
            offset: -0.05,
            law,
            compliance: 0.0,
            key,
        })?;
    }
    Ok(scene)
}

const PUSH: [f64; 6] = [0.3, -0.1, -0.6, 0.01, -0.02, 0.005];

/// A change of what a solve depends on.
type Change = fn(&mut body_rows::Scene<f64>, &mut SVector<f64, 6>, &mut Settings<f64>) -> Result<(), Error>;

const CHANGES: [(&str, Change); 16] = [
    ("keys of contacts", |scene, _, _| {
        let contacts = scene.contacts().to_vec();
        scene.clear_contacts();
        for mut contact in contacts {
            contact.key = 1 - contact.key;
            scene.push(&contact)?;
        }
        Ok(())
    }),
    ("key of a row", |scene, _, _| {
        let rows = scene.rows().to_vec();
        scene.clear_rows();
        for mut row in rows {
            row.key += 4 * (row.key / 2);
            scene.push_row(&row)?;
        }
        Ok(())
    }),
    ("offset", |scene, _, _| scene.set_offset(1, &vector![0.01, 0.02, -0.02])),
    ("sign of an offset", |scene, _, _| scene.set_offset(1, &vector![0.01, 0.02, 0.01])),
    ("offsets of two contacts, in the same way", |scene, _, _| {
        scene.set_offset(0, &vector![0.01, 0.02, 0.01])?;
        scene.set_offset(1, &vector![0.01, 0.02, 0.01])
    }),
    ("friction", |scene, _, _| scene.set_friction(0, 0.3)),
    ("row offset", |scene, _, _| scene.set_row_offset(2, -0.04)),
    ("signs of row offsets", |scene, _, _| {
        scene.set_row_offset(0, 0.05)?;
        scene.set_row_offset(1, 0.05)
    }),
    ("row law", |scene, _, _| scene.set_row_law(0, RowLaw::Equality)),
    ("bound", |scene, _, _| {
        let (lower, upper) = (-0.02, 0.04);
        scene.set_row_law(2, RowLaw::Box { lower, upper })
    }),
    ("row", |scene, _, _| scene.set_row_jacobian(1, &SVector::repeat(0.2))),
    ("compliance", |scene, _, _| scene.set_row_compliance(1, 0.1)),
    ("mass", |scene, _, _| scene.set_mass(&(BRICK.mass_matrix() * 1.25))),
    ("free impulse", |_, push, _| {
        push[5] = -push[5];
        Ok(())
    }),
    ("tolerance", |_, _, settings| {
        settings.tolerance = 1e-8;
        Ok(())
    }),
    ("model", |_, _, settings| {
        settings.model = Model::ConvexRelaxation;
        Ok(())
    }),
];

fn all_of<const N: usize, const D: usize, const C: usize, const R: usize>(
    solution: &Solution<f64, N, D, C, R>,
) -> String {
    // Each number to the last bit. The end of a call is a time to look for a proof.
    let work = Work { proof_searches: 0, ..solution.work };
    let mut solution = solution.clone();
    solution.work = work;
    format!("{solution:?}")
}

/// What a solve was paused with must not answer for other data: it is begun anew, with a warm start as always.
#[test]
fn a_paused_solve_of_other_data_is_begun_anew() -> Result<(), Error> {
    let settings = Settings { budget: 10_000, ..Settings::new(1e-10) };
    for budget in [5, 20, 30] {
        let pause = Settings { budget, ..settings };
        let (scene, push) = (small_scene()?, SVector::from(PUSH));
        let (factor, mut paused) = (Factor::new(&scene)?, Small::new());
        paused.solve(&scene, &factor, &push, &pause)?;
        assert_eq!(paused.solution().status, Status::OutOfBudget);
        // With the same data it goes on, and counts the work of both.
        let (mut same, mut whole) = (paused.clone(), Small::new());
        let same = same.resume(&scene, &factor, &push, &settings)?;
        let whole = whole.solve(&scene, &factor, &push, &settings)?;
        assert_eq!(all_of(same), all_of(whole));
        let mut anew = paused.clone();
        let anew = anew.solve(&scene, &factor, &push, &settings)?;
        // ... which is not what it does when it begins.
        assert_ne!(all_of(same), all_of(anew));

        for (name, change) in CHANGES {
            let (mut scene, mut push, mut settings) = (scene.clone(), push, settings);
            change(&mut scene, &mut push, &mut settings)?;
            let factor = Factor::new(&scene)?;
            let (mut resumed, mut begun) = (paused.clone(), paused.clone());
            let resumed = resumed.resume(&scene, &factor, &push, &settings)?;
            let begun = begun.solve(&scene, &factor, &push, &settings)?;
            assert_eq!(all_of(resumed), all_of(begun), "{name}, after {budget}");
            assert!(resumed.is_solved(), "{name}: {}", resumed.status);
        }
    }
    Ok(())
}

/// The budget is no part of the data, and neither is what is changed and changed back.
#[test]
fn a_paused_solve_goes_on_with_data_that_is_the_same_again() -> Result<(), Error> {
    let settings = Settings { budget: 10_000, ..Settings::new(1e-10) };
    let pause = Settings { budget: 30, ..settings };
    let mut kernel = body_rows::Kernel::<f64>::new();
    *kernel.scene_mut() = small_scene()?;
    let push = SVector::from(PUSH);
    let whole = all_of(kernel.clone().solve(&push, &settings)?);
    kernel.solve(&push, &pause)?;
    let scene = kernel.scene_mut();
    scene.set_friction(1, 0.1)?;
    scene.set_row_offset(0, 0.5)?;
    scene.set_friction(1, 0.4)?;
    scene.set_row_offset(0, -0.05)?;
    scene.remove_row(2)?;
    *scene = small_scene()?;
    assert_eq!(all_of(kernel.resume(&push, &settings)?), whole);
    Ok(())
}

/// [`Kernel::advance`] claims nothing before the end, changes no bit, and a call without a budget shows what there is.
#[test]
fn a_solve_in_pieces_is_the_whole_solve() -> Result<(), Error> {
    let settings = Settings { budget: 10_000, ..Settings::new(1e-10) };
    let [piece, none] = [1, 0].map(|budget| Settings { budget, ..settings });
    let push = SVector::from(PUSH);
    let mut kernel = body_rows::Kernel::<f64>::new();
    *kernel.scene_mut() = small_scene()?;
    let mut whole = kernel.clone();
    let whole = whole.solve(&push, &settings)?;
    let mut pieces = 1;
    let mut before = kernel.clone(); // shows what there is after each piece
    while !kernel.advance(&push, &piece)? {
        let paused = kernel.solution();
        assert_eq!(paused.status, Status::Unsolved);
        assert!(!paused.is_usable(f64::MAX));
        before.resume(&push, &piece)?;
        let mut shown = kernel.clone();
        let shown = shown.resume(&push, &none)?;
        // The last piece may have led to a solution, of which nobody has asked the error yet.
        let is_last = shown.status == Status::Solved;
        assert!(is_last || shown.status == Status::OutOfBudget);
        assert!(shown.error >= before.solution().error); // that has seen all the points between
        pieces += 1;
    }
    assert!(pieces > 3, "{pieces} pieces");
    assert_eq!(all_of(kernel.solution()), all_of(whole));
    // With other data it begins anew.
    kernel.advance(&push, &piece)?;
    kernel.scene_mut().set_friction(0, 0.2)?;
    let work = kernel.resume(&push, &none)?.work;
    assert_eq!(work.sweeps + work.newton_steps + work.chord_steps, 0);
    Ok(())
}

/// It would be solved through a joint stop.
#[test]
fn a_solve_with_limits_is_not_gone_on_with_without_them() -> Result<(), Error> {
    let settings = Settings::new(1e-10);
    let pause = Settings { budget: 1, ..settings };
    let mut kernel = body_rows::Kernel::<f64>::new();
    let source = small_scene()?;
    let scene = kernel.scene_mut();
    scene.set_mass(source.mass())?;
    for contact in source.contacts() {
        scene.push(contact)?;
    }
    let (limit, own) = source.rows().split_first().expect("three rows");
    for row in own {
        scene.push_row(row)?;
    }
    let push = SVector::from(PUSH);
    let paused = kernel.solve_with_limits(std::slice::from_ref(limit), &push, &pause)?;
    assert_eq!(paused.status, Status::OutOfBudget);
    let before = all_of(paused);
    assert_eq!(kernel.resume(&push, &settings).err(), Some(Error::LimitsLeftOut));
    assert_eq!(kernel.advance(&push, &settings).err(), Some(Error::LimitsLeftOut));
    assert_eq!(all_of(kernel.solution()), before);
    // What begins anew, or has ended, is no solve with limits.
    for begin in 0..4 {
        let mut kernel = kernel.clone();
        match begin {
            3 => {
                let limits = std::slice::from_ref(limit);
                assert!(kernel.resume_with_limits(limits, &push, &settings)?.is_solved());
            }
            0 => kernel.solver_mut().reset(),
            1 => assert!(!kernel.solve(&push, &pause)?.is_solved()),
            _ => {
                assert!(kernel.solve_with_limits(std::slice::from_ref(limit), &push, &settings)?.is_solved());
            }
        }
        assert!(kernel.resume(&push, &settings)?.is_solved());
    }
    Ok(())
}

/// Pieces change no bit of a solve with limits, also where a pass appends limits that the last pass violates.
#[test]
fn a_solve_with_limits_in_pieces_is_the_same() -> Result<(), Error> {
    let settings = Settings::new(1e-10);
    let source = small_scene()?;
    let mut kernel = body_rows::Kernel::<f64>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(source.mass())?;
    for contact in source.contacts() {
        scene.push(contact)?;
    }
    let push = SVector::from(PUSH);
    let free = source.mass().try_inverse().expect("it is a mass matrix") * push;
    let (mut pauses, mut appended) = (0, 0);
    for x in draws(numbers(24), 40) {
        // The free motion reaches one in two or three.
        let limits = [0, 1, 2, 3].map(|key: u8| {
            let row = SVector::<_, 6>::from_column_slice(&x[6 * usize::from(key)..][..6]);
            let offset = 0.1 * row[0] + 0.05 - row.dot(&free);
            JointRow { row, offset, law: RowLaw::Limit, compliance: 1e-3, key: key.into() }
        });
        let mut whole = kernel.clone();
        let once = whole.solve_with_limits(&limits, &push, &settings)?;
        let violated = limits.iter().filter(|limit| limit.row.dot(&free) + limit.offset < 0.0);
        appended += usize::from(once.rows.len() > violated.count());
        for budget in [1, 2, 3] {
            let piece = Settings { budget, ..settings };
            let (mut in_pieces, mut resumed) = (kernel.clone(), kernel.clone());
            while !in_pieces.advance_with_limits(&limits, &push, &piece)? {
                assert_eq!(in_pieces.solution().status, Status::Unsolved);
                assert!(in_pieces.scene().rows().is_empty());
                pauses += 1;
            }
            while resumed.resume_with_limits(&limits, &push, &piece)?.status == Status::OutOfBudget {
                assert_eq!(resumed.resume(&push, &piece).err(), Some(Error::LimitsLeftOut));
                pauses += 1;
            }
            assert_eq!(all_of(in_pieces.solution()), all_of(once));
            // A solution at a pause obeys all limits, so it may take in one before the end of a pass.
            assert!(resumed.solution().is_solved());
            assert!((resumed.solution().velocity - once.velocity).norm() < 1e-8);
        }
    }
    assert!(pauses > 400 && appended > 10, "{pauses}, {appended}");
    Ok(())
}

/// A loop that has spent its time, and goes on with pieces of nothing: they do some work.
#[test]
fn pieces_without_a_budget_end_a_solve() -> Result<(), Error> {
    let settings = Settings::new(1e-9);
    let piece = Settings { budget: 0, ..settings };
    let (scene, push) = (small_scene()?, SVector::from(PUSH));
    let factor = Factor::new(&scene)?;
    let mut ends = 0;
    for presumes_rest in [false, true] {
        let (mut once, mut in_pieces) = (Small::new(), Small::new());
        if presumes_rest {
            once.presume_rest();
            in_pieces.presume_rest();
        }
        once.solve(&scene, &factor, &push, &settings)?;
        for _ in 0..1_000 {
            if in_pieces.advance(&scene, &factor, &push, &piece)? {
                ends += 1;
                break;
            }
        }
        assert_eq!(all_of(in_pieces.solution()), all_of(once.solution()));
    }
    let mut kernel = block_rows::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&Matrix2::identity())?;
    let (row, law) = (vector![1.0, 0.0], RowLaw::Limit);
    let limits = [JointRow { row, offset: 0.25, law, compliance: 0.0, key: 3 }];
    for _ in 0..1_000 {
        if kernel.advance_with_limits(&limits, &vector![-1.0, 0.0], &piece)? {
            ends += 1;
            break;
        }
    }
    assert_eq!(ends, 3);
    Ok(())
}

/// Another offset of a limit that was reached: the paused solve would answer for the old one.
#[test]
fn a_solve_with_other_limits_begins_anew() -> Result<(), Error> {
    let settings = Settings::new(1e-10);
    let piece = Settings { budget: 1, ..settings };
    let limit = |factor, offset| {
        let row = vector![factor, 0.0];
        [JointRow { row, offset, law: RowLaw::Limit, compliance: 0.0, key: 3 }]
    };
    let push = vector![-1.0, 0.0];
    let mut kernel = block_rows::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&Matrix2::identity())?;
    let floor = matrix![0.0, 1.0; 1.0, 0.0];
    kernel.scene_mut().push(&Contact { jacobian: floor, offset: vector![0.0, 0.0], mu: 0.5, key: 0 })?;
    let none = Settings { budget: 0, ..settings };
    // The same; another offset, another row, and none.
    for (limits, velocity, goes_on) in [
        (&limit(1.0, 0.25)[..], -0.25, true),
        (&limit(1.0, 0.5), -0.5, false),
        (&limit(2.0, 0.25), -0.125, false),
        (&[], -1.0, false),
    ] {
        kernel.solver_mut().reset();
        assert!(!kernel.advance_with_limits(&limit(1.0, 0.25), &push, &piece)?);
        let work = kernel.solution().work;
        assert!(work.total() > 0);
        let resumed = kernel.resume_with_limits(limits, &push, &none)?.work;
        assert_eq!(resumed == work, goes_on, "{resumed:?}");
        while !kernel.advance_with_limits(limits, &push, &piece)? {}
        assert!((kernel.solution().velocity.x - velocity).abs() < 1e-9);
    }
    Ok(())
}

#[test]
fn admm_begins_anew_with_other_data_too() -> Result<(), Error> {
    let scene = BRICK.on_plane::<f64>(0.3)?;
    let (factor, push) = (AdmmFactor::new(&scene)?, BRICK.free_impulse(0.5, 0.01));
    let settings = Settings::new(1e-8);
    let few = Settings { budget: 7, ..settings };
    let mut paused = AdmmSolver::new();
    paused.solve(&scene, &factor, &push, &few)?;
    let mut other = scene.clone();
    other.set_friction(2, 0.2)?;
    let looser = Settings::new(1e-7);
    for (scene, push, settings) in
        [(&other, push, settings), (&scene, push * 1.001, settings), (&scene, push, looser)]
    {
        let [mut resumed, mut begun] = [paused.clone(), paused.clone()];
        let resumed = resumed.resume(scene, &factor, &push, &settings)?;
        assert_eq!(all_of(resumed), all_of(begun.solve(scene, &factor, &push, &settings)?));
    }
    Ok(())
}

/// Its iterates are impulses over the penalty.
#[test]
fn admm_begins_anew_with_another_penalty() -> Result<(), Error> {
    let mut scene = Scene::<f64, 1, 1, 1>::new();
    scene.set_mass(&matrix![2.0])?;
    scene.push(&Contact { jacobian: matrix![1.0], offset: vector![0.0], mu: 0.0, key: 0 })?;
    let (mut factor, mut solver) = (AdmmFactor::new(&scene)?, AdmmSolver::new());
    let (push, settings) = (vector![-0.2], Settings::new(1e-9));
    let few = Settings { budget: 1, ..settings };
    let paused = solver.solve(&scene, &factor, &push, &few)?;
    assert_eq!(paused.status, Status::OutOfBudget);
    factor.set_penalty(10.0 * factor.penalty())?;
    let solution = solver.resume(&scene, &factor, &push, &settings)?;
    assert!(solution.is_solved(), "{solution:?}");
    assert!((solution.contacts[0].impulse[0] - 0.2).abs() < 1e-9);
    Ok(())
}
