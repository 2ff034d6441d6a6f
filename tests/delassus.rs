//! Scenes of which `W` and `q` are given instead of `M` and `H`.

use crate::support::random::{draws, numbers};
use nalgebra::{SMatrix, SVector};
use stiction::{
    Contact, Error, Factor, Input, JointRow, RowLaw, RowMode, RowSolution, Scene, Settings, Solver,
    Surface,
};
use testbed::scene_file::{SceneFile, bundled_scenes};

const N: usize = 18;
const C: usize = 4;

/// `W` row by row, and the scene with `q` as offsets and without Jacobians.
fn given(file: &SceneFile) -> Result<(Scene<f64, N, 3, C>, Vec<f64>), Error> {
    let cholesky = file.mass.clone().cholesky().expect("it has a mass");
    let w = &file.h * cholesky.solve(&file.h.transpose());
    let q = &file.w - &file.h * cholesky.solve(&file.f);
    let delassus = w.transpose().as_slice().to_vec();
    let mut scene = Scene::new();
    for i in 0..file.n_contacts {
        scene.push(&Contact {
            jacobian: SMatrix::zeros(),
            offset: SVector::from_fn(|k, _| q[3 * i + k]),
            mu: file.mu[i],
            key: 0,
        })?;
    }
    Ok((scene, delassus))
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
        let (mut scene, delassus) = given(&file)?;
        scene.set_delassus(&delassus)?;
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
    let (mut scene, delassus) = given(file.expect("it is bundled"))?;
    let size = 3 * C;
    assert_eq!(delassus.len(), size * size);
    let mut asymmetric = delassus.clone();
    asymmetric[3 * size + 7] += 0.1;
    let mut indefinite = delassus.clone();
    indefinite[7 * size + 7] = -1.0;
    for wrong in [asymmetric, indefinite] {
        let refused = scene.set_delassus(&wrong);
        assert!(
            matches!(refused, Err(Error::DelassusNotGram { .. })),
            "{refused:?}"
        );
    }
    let mut infinite = delassus.clone();
    infinite[2 * size + 5] = f64::INFINITY;
    let (input, row, column) = (Input::Delassus, 2, 5);
    let refused = scene.set_delassus(&infinite);
    assert_eq!(refused, Err(Error::NotFinite { input, row, column }));
    let wanted = size * size;
    for wrong in [&delassus[1..], &[], &[0.5; 145]] {
        let refused = scene.set_delassus(wrong);
        assert_eq!(refused, Err(Error::DelassusSize { wanted }));
    }
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
    let refused = small.set_delassus(&delassus);
    assert!(matches!(refused, Err(Error::DelassusNotGram { .. })));
    scene.set_delassus(&delassus)
}

/// A point mass on a floor, whose slide has a stop: `W` over the contact and the stop.
#[test]
fn joint_rows_may_be_given_as_w_too() -> Result<(), Error> {
    let masses = SVector::from([2.0, 0.5]);
    let jacobian = SMatrix::<f64, 2, 2>::new(0.0, 1.0, 1.0, 0.0);
    let free = SVector::from([-0.3, -0.02]);
    let solve = |given: bool| -> Result<(SVector<f64, 2>, RowSolution<f64>), Error> {
        let mut scene = Scene::<f64, 2, 2, 1, 1>::new();
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
            // Normal and tangent of the contact, and the stop.
            scene.set_delassus(&[y, 0.0, 0.0, 0.0, x, x, 0.0, x, x])?;
            push = SVector::zeros();
        }
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
    type Mixed = Scene<f64, N, 3, 2, 3, 1>;
    let surface = Surface {
        friction: [0.7, 0.3],
        compliance: [0.05, 0.02],
        ..Surface::isotropic(0.0)
    };
    let (lower, upper) = (-0.1, 0.2);
    let laws = [
        RowLaw::Limit,
        RowLaw::Equality,
        RowLaw::Box { lower, upper },
    ];
    let mut busy = [0; 2];
    for x in draws(numbers(220), 100) {
        let mut x = x.iter().copied();
        let mut next = || x.next().expect("enough numbers");
        let root = SMatrix::<f64, N, N>::from_fn(|_, _| next());
        let mass = root * root.transpose() + SMatrix::identity();
        let j = SMatrix::<f64, 9, N>::from_fn(|_, _| next());
        let w = SVector::<f64, 9>::from_fn(|_, _| 0.2 * next());
        let push = SVector::<f64, N>::from_fn(|_, _| next());
        let fill = |j: &SMatrix<f64, 9, N>, w: &SVector<f64, 9>| -> Result<Mixed, Error> {
            let mut scene = Mixed::new();
            scene.set_mass(&mass.symmetric_part())?;
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
        let scene = fill(&j, &w)?;
        let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
        let wanted = solver.solve(&scene, &factor, &push, &settings)?;

        let cholesky = mass.cholesky().expect("it has a mass");
        let delassus = (j * cholesky.solve(&j.transpose())).symmetric_part();
        let q = w + j * cholesky.solve(&push);
        let mut scene = fill(&SMatrix::zeros(), &q)?;
        scene.set_delassus(delassus.as_slice())?;
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

/// A `W` of contacts alone is that of other scenes too: what comes or goes afterwards is in it no longer.
#[test]
fn a_row_more_or_less_is_another_size() -> Result<(), Error> {
    let mut scene = Scene::<f64, 2, 1, 1, 1>::new();
    scene.push(&Contact {
        jacobian: SMatrix::zeros(),
        offset: SVector::from([-1.0]),
        mu: 0.0,
        key: 0,
    })?;
    let size = |wanted| Err(Error::DelassusSize { wanted });
    assert_eq!(scene.set_delassus(&[1.0, 0.0, 0.0, 1.0]), size(1));
    scene.push_row(&JointRow {
        row: SVector::zeros(),
        offset: -0.5,
        law: RowLaw::Limit,
        compliance: 0.0,
        key: 0,
    })?;
    assert_eq!(scene.set_delassus(&[1.0]), size(4));
    scene.set_delassus(&[1.0, 0.5, 0.5, 1.0])?;
    let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
    let solution = solver.solve(&scene, &factor, &SVector::zeros(), &Settings::new(1e-12))?;
    // By hand: the contact alone pushes 1, and takes the row along at 0.5.
    let (r, row) = (solution.contacts[0].impulse[0], solution.rows[0]);
    assert!((r - 1.0).abs() < 1e-12 && row.impulse.abs() < 1e-12 && row.velocity.abs() < 1e-12);
    Ok(())
}

/// With `W` goes the mass that was there before: Jacobians that come afterwards find none.
#[test]
fn a_scene_that_had_a_w_is_not_solved_without_a_mass() -> Result<(), Error> {
    type One = Scene<f64, 1, 1, 2, 1>;
    type Change = fn(&mut One, &Contact<f64, 1, 1>, &JointRow<f64, 1>) -> Result<(), Error>;
    let contact = Contact {
        jacobian: SMatrix::from([[1.0]]),
        offset: SVector::zeros(),
        mu: 0.0,
        key: 0,
    };
    let row = JointRow {
        row: SVector::from([1.0]),
        offset: 0.0,
        law: RowLaw::Limit,
        compliance: 0.0,
        key: 0,
    };
    let changes: [Change; 5] = [
        |scene, contact, _| scene.push(contact).map(|_| ()),
        |scene, _, row| scene.push_row(row).map(|_| ()),
        |scene, contact, _| scene.set_jacobian(0, &contact.jacobian),
        |scene, contact, _| {
            scene.clear();
            scene.push(contact).map(|_| ())
        },
        |scene, contact, _| {
            scene.clear_contacts();
            scene.push(contact).map(|_| ())
        },
    ];
    for change in changes {
        let mut scene = One::new();
        scene.set_mass(&SMatrix::from([[2.0]]))?;
        scene.push(&contact)?;
        scene.set_delassus(&[0.5])?;
        assert!(Factor::new(&scene).is_ok());
        change(&mut scene, &contact, &row)?;
        let refused = Factor::new(&scene).err();
        assert_eq!(refused, Some(Error::MassNotPositiveDefinite { dof: 0 }));
        // With a mass it is a scene like any other.
        scene.clear();
        scene.set_mass(&SMatrix::from([[2.0]]))?;
        scene.push(&contact)?;
        let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
        let push = SVector::from([-1.0]);
        let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-12))?;
        assert!((solution.contacts[0].impulse[0] - 1.0).abs() < 1e-12);
    }
    Ok(())
}
