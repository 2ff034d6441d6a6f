//! Scenes of which `W` and `q` are given instead of `M` and `H`.

use nalgebra::{SMatrix, SVector};
use stiction::{
    Contact, Error, Factor, JointRow, RowLaw, RowMode, RowSolution, Scene, Settings, Solver,
};
use testbed::scene_file::{SceneFile, bundled_scenes};

const N: usize = 18;
const C: usize = 4;

type Blocks = [[[[f64; 3]; C]; 3]; C];

/// `W` in blocks, and the scene with `q` as offsets and without Jacobians.
fn given(file: &SceneFile) -> Result<(Scene<f64, N, 3, C>, Blocks), Error> {
    let cholesky = file.mass.clone().cholesky().expect("it has a mass");
    let w = &file.h * cholesky.solve(&file.h.transpose());
    let q = &file.w - &file.h * cholesky.solve(&file.f);
    let entry = |i: usize, j: usize| w.get((i, j)).copied().unwrap_or(0.0);
    let blocks = std::array::from_fn(|i| {
        std::array::from_fn(|k| {
            std::array::from_fn(|j| std::array::from_fn(|l| entry(3 * i + k, 3 * j + l)))
        })
    });
    let mut scene = Scene::new();
    for i in 0..file.n_contacts {
        scene.push(&Contact {
            jacobian: SMatrix::zeros(),
            offset: SVector::from_fn(|k, _| q[3 * i + k]),
            mu: file.mu[i],
            key: 0,
        })?;
    }
    Ok((scene, blocks))
}

#[test]
fn contacts_do_the_same_whether_m_and_h_or_w_and_q_are_given() -> Result<(), Error> {
    let settings = Settings::new(1e-9);
    let mut count = 0;
    for file in bundled_scenes() {
        let fits = file.dim == 3 && file.n_dof <= N && file.n_contacts <= C;
        if !fits || file.name.starts_with("infeasible") {
            continue;
        }
        let plain = file.scene::<f64, N, 3, C>()?;
        let (factor, mut solver) = (Factor::new(&plain)?, Solver::new());
        let wanted = solver.solve(&plain, &factor, &file.free_impulse(), &settings)?;
        let (mut scene, blocks) = given(&file)?;
        scene.set_delassus(&blocks)?;
        let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
        let found = solver.solve(&scene, &factor, &SVector::zeros(), &settings)?;
        assert!(found.is_solved(), "{}: {}", file.name, found.status);
        // Where there is one solution, it is the same one; modes differ where a contact is just about to slip.
        let pairs = wanted.contacts.iter().zip(&found.contacts);
        let off = pairs
            .map(|(a, b)| (a.velocity - b.velocity).norm())
            .fold(0.0, f64::max);
        count += usize::from(off < 1e-6);
    }
    assert!(count >= 20, "{count}");
    Ok(())
}

#[test]
fn what_is_no_delassus_operator_is_refused() -> Result<(), Error> {
    let files = bundled_scenes();
    let file = files.iter().find(|file| file.name == "go2_stand");
    let (mut scene, blocks) = given(file.expect("it is bundled"))?;
    let mut asymmetric = blocks;
    asymmetric[1][0][2][1] += 0.1;
    let mut indefinite = blocks;
    indefinite[2][1][2][1] = -1.0;
    for wrong in [asymmetric, indefinite] {
        let refused = scene.set_delassus(&wrong);
        assert!(
            matches!(refused, Err(Error::DelassusNotGram { .. })),
            "{refused:?}"
        );
    }
    let mut infinite = blocks;
    infinite[0][0][0][0] = f64::INFINITY;
    assert!(matches!(
        scene.set_delassus(&infinite),
        Err(Error::NotFinite { .. })
    ));
    // Of rank 12, it needs twelve velocities.
    let mut small = Scene::<f64, 3, 3, C>::new();
    for contact in scene.contacts() {
        small.push(&Contact {
            jacobian: SMatrix::zeros(),
            offset: contact.offset,
            mu: contact.mu,
            key: 0,
        })?;
    }
    let refused = small.set_delassus(&blocks);
    assert!(matches!(refused, Err(Error::DelassusNotGram { .. })));
    scene.set_delassus(&blocks)
}

/// A point mass on a floor, whose slide has a stop: `W` over the contact and the slot of the stop.
#[test]
fn joint_rows_may_be_given_as_w_too() -> Result<(), Error> {
    let masses = SVector::from([2.0, 0.5]);
    let jacobian = SMatrix::<f64, 2, 2>::new(0.0, 1.0, 1.0, 0.0);
    let free = SVector::from([-0.3, -0.02]);
    let solve = |given: bool| -> Result<(SVector<f64, 2>, RowSolution<f64>), Error> {
        let mut scene = Scene::<f64, 2, 2, 2, _>::mixed();
        scene.set_mass(&SMatrix::from_diagonal(&masses))?;
        let q = jacobian * free;
        let rows = if given { SMatrix::zeros() } else { jacobian };
        scene.push(&Contact {
            jacobian: rows,
            offset: if given { q } else { SVector::zeros() },
            mu: 0.5,
            key: 0,
        })?;
        let unit = if given { 0.0 } else { 1.0 };
        let stop = scene.push_row(&JointRow {
            row: SVector::from([unit, 0.0]),
            offset: if given { free[0] + 0.1 } else { 0.1 },
            law: RowLaw::Limit,
            compliance: 0.0,
            key: 0,
        })?;
        let mut push = free.component_mul(&masses);
        if given {
            let [x, y] = masses.map(|mass| 1.0 / mass).into();
            // Contact: normal and tangent; slot of the stop: its row, and one that is not used.
            scene.set_delassus(&[
                [[[y, 0.0], [0.0, 0.0]], [[0.0, x], [x, 0.0]]],
                [[[0.0, x], [x, 0.0]], [[0.0, 0.0], [0.0, 0.0]]],
            ])?;
            push = SVector::zeros();
        }
        let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
        let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-10))?;
        assert!(solution.is_solved(), "{}", solution.status);
        let row = solution.row(stop).expect("it is there");
        Ok((solution.contacts[0].impulse, row))
    };
    let ((r, row), (other, same)) = (solve(false)?, solve(true)?);
    assert!((r - other).norm() < 1e-9 && (row.impulse - same.impulse).abs() < 1e-9);
    assert_eq!((row.mode, same.mode), (RowMode::AtLimit, RowMode::AtLimit));
    Ok(())
}
