//! Scenes of which `W` and `q` are known instead of `M` and `H`: a root of `W` does the same.

use crate::support::random::{draws, numbers};
use crate::support::sizes::{block_rows, bodies};
use nalgebra::{DMatrix, SMatrix, SVector};
use stiction::{
    Contact, Error, Factor, JointRow, RowLaw, RowMode, RowSolution, Scene, Settings, Solver, Surface,
};
use testbed::delassus::root;
use testbed::scene_file::{SceneFile, bundled_scenes};

const N: usize = 18;
const C: usize = 12;

/// The scene by a root of `W` and by `q`.
fn given(file: &SceneFile) -> Result<Scene<f64, N, 3, C>, Error> {
    let cholesky = file.mass.clone().cholesky().expect("it has a mass");
    let w = &file.h * cholesky.solve(&file.h.transpose());
    let q = &file.w - &file.h * cholesky.solve(&file.f);
    let jacobians = root(&w, N);
    let mut scene = Scene::new();
    scene.set_mass(&SMatrix::identity())?;
    for i in 0..file.n_contacts {
        scene.push(&Contact {
            jacobian: jacobians.fixed_view::<3, N>(3 * i, 0).into_owned(),
            offset: SVector::from_fn(|k, _| q[3 * i + k]),
            mu: file.mu[i],
            key: 0,
        })?;
    }
    Ok(scene)
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
        let scene = given(&file)?;
        let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
        let found = solver.solve(&scene, &factor, &SVector::zeros(), &settings)?;
        assert!(found.is_solved(), "{}: {}", file.name, found.status);
        // Where there is one solution, it is the same one; modes differ where a contact is just about to slip.
        let pairs = wanted.contacts.iter().zip(&found.contacts);
        let off = pairs.map(|(a, b)| (a.velocity - b.velocity).norm()).fold(0.0, f64::max);
        count += usize::from(off < 1e-6);
    }
    assert!(count >= 20, "{count}");
    Ok(())
}

/// A point mass on a floor, whose slide has a stop: `W` over the contact and the stop.
#[test]
fn joint_rows_may_be_given_as_w_too() -> Result<(), Error> {
    let masses = SVector::from([2.0, 0.5]);
    let jacobian = SMatrix::<f64, 2, 2>::new(0.0, 1.0, 1.0, 0.0);
    let free = SVector::from([-0.3, -0.02]);
    // `W` of normal and tangent of the contact, and of the stop.
    let [x, y] = masses.map(|mass| 1.0 / mass).into();
    let w = DMatrix::from_row_slice(3, 3, &[y, 0.0, 0.0, 0.0, x, x, 0.0, x, x]);
    let solve = |given: bool| -> Result<(SVector<f64, 2>, RowSolution<f64>), Error> {
        let rows =
            if given { root(&w, 2) } else { DMatrix::from_row_slice(3, 2, &[0.0, 1.0, 1.0, 0.0, 1.0, 0.0]) };
        let [mass, free_velocity] =
            if given { [SVector::repeat(1.0), SVector::zeros()] } else { [masses, free] };
        let q = if given { jacobian * free } else { SVector::zeros() };
        let mut scene = block_rows::Scene::<f64>::new();
        scene.set_mass(&SMatrix::from_diagonal(&mass))?;
        scene.push(&Contact {
            jacobian: rows.fixed_view::<2, 2>(0, 0).into_owned(),
            offset: q,
            mu: 0.5,
            key: 0,
        })?;
        let stop = scene.push_row(&JointRow {
            row: rows.fixed_view::<1, 2>(2, 0).transpose(),
            offset: if given { free[0] + 0.1 } else { 0.1 },
            law: RowLaw::Limit,
            compliance: 0.0,
            key: 0,
        })?;
        let push = free_velocity.component_mul(&mass);
        let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
        let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-10))?;
        assert!(solution.is_solved(), "{}", solution.status);
        let row = solution.rows[stop];
        Ok((solution.contacts[0].impulse, row))
    };
    let ((r, row), (other, same)) = (solve(false)?, solve(true)?);
    assert!((r - other).norm() < 1e-9 && (row.impulse - same.impulse).abs() < 1e-9);
    assert_eq!((row.mode, same.mode), (RowMode::AtLimit, RowMode::AtLimit));
    Ok(())
}

/// Contacts on surfaces, compliance, and joint rows of each law, all in one `W` of full rank: then impulses are unique, too.
#[test]
fn contacts_and_joint_rows_do_the_same_whether_m_and_h_or_w_and_q_are_given() -> Result<(), Error> {
    const N: usize = 10;
    type Mixed = bodies::Scene<f64>;
    let surface = Surface { friction: [0.7, 0.3], compliance: [0.05, 0.02], ..Surface::isotropic(0.0) };
    let (lower, upper) = (-0.1, 0.2);
    let laws = [RowLaw::Limit, RowLaw::Equality, RowLaw::Box { lower, upper }];
    let mut busy = [0; 2];
    for x in draws(numbers(220), 100) {
        let mut x = x.iter().copied();
        let mut next = || x.next().expect("enough numbers");
        let square = SMatrix::<f64, N, N>::from_fn(|_, _| next());
        let mass = square * square.transpose() + SMatrix::identity();
        let j = SMatrix::<f64, 9, N>::from_fn(|_, _| next());
        let w = SVector::<f64, 9>::from_fn(|_, _| 0.2 * next());
        let push = SVector::<f64, N>::from_fn(|_, _| next());
        let fill = |mass: &SMatrix<f64, N, N>,
                    j: &SMatrix<f64, 9, N>,
                    w: &SVector<f64, 9>|
         -> Result<Mixed, Error> {
            let mut scene = Mixed::new();
            scene.set_mass(mass)?;
            for i in 0..2 {
                let contact = Contact {
                    jacobian: j.fixed_rows::<3>(3 * i).into_owned(),
                    offset: w.fixed_rows::<3>(3 * i).into_owned(),
                    mu: 0.5,
                    key: 0,
                };
                if i == 0 {
                    scene.push_on(&contact, &surface)?;
                } else {
                    scene.push(&contact)?;
                }
            }
            for (k, law) in laws.into_iter().enumerate() {
                scene.push_row(&JointRow {
                    row: j.row(6 + k).transpose(),
                    offset: w[6 + k],
                    law,
                    compliance: [0.0, 0.1, 0.0][k],
                    key: 0,
                })?;
            }
            Ok(scene)
        };
        let settings = Settings::new(1e-11);
        let scene = fill(&mass.symmetric_part(), &j, &w)?;
        let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
        let wanted = solver.solve(&scene, &factor, &push, &settings)?;

        let cholesky = mass.cholesky().expect("it has a mass");
        let delassus = (j * cholesky.solve(&j.transpose())).symmetric_part();
        let delassus = DMatrix::from_column_slice(9, 9, delassus.as_slice());
        let rows = root(&delassus, N).fixed_view::<9, N>(0, 0).into_owned();
        let q = w + j * cholesky.solve(&push);
        let scene = fill(&SMatrix::identity(), &rows, &q)?;
        let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
        let found = solver.solve(&scene, &factor, &SVector::zeros(), &settings)?;
        assert!(wanted.is_solved() && found.is_solved());
        for (a, b) in wanted.contacts.iter().zip(&found.contacts) {
            assert!((a.impulse - b.impulse).norm() < 1e-8, "{a:?} {b:?}");
            assert!((a.velocity - b.velocity).norm() < 1e-8, "{a:?} {b:?}");
            assert_eq!(a.mode, b.mode);
            busy[0] += usize::from(a.impulse.norm() > 0.0);
        }
        for (a, b) in wanted.rows.iter().zip(&found.rows) {
            assert!((a.impulse - b.impulse).abs() < 1e-8, "{a:?} {b:?}");
            assert!((a.velocity - b.velocity).abs() < 1e-8, "{a:?} {b:?}");
            assert_eq!(a.mode, b.mode);
            busy[1] += usize::from(a.impulse.abs() > 0.0);
        }
    }
    assert!(busy[0] > 80 && busy[1] > 200, "{busy:?}");
    Ok(())
}
