//! Joint rows beside contacts that give way and have an elliptic cone. A row that holds is one unknown; one at its bound is none.
#![allow(clippy::indexing_slicing)]

extern crate std;

use super::{C, N, R, differences, point_at};
use crate::linalg::stacked::{Stacked, StackedMatrix};
use crate::problem::{Age, Problem};
use crate::sets::jacobian::{EarlierIndices, Jacobian};
use crate::{Contact, Error, Factor, JointRow, Model, RowLaw, RowMode, Scene, Settings, Surface};
use nalgebra::{SMatrix, SVector};
use std::vec::Vec;

/// Numbers between -1 and 1, the same each time.
fn numbers() -> impl Iterator<Item = f64> {
    let mut state = 7_u32;
    core::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / f64::from(1_u32 << 31) - 1.0
    })
}

/// So many contacts on elliptic cones, the second one without friction, and seven rows of all laws, some of which give way.
fn scene_with_rows<const D: usize>(
    contacts: u32,
    random: &mut impl Iterator<Item = f64>,
) -> Result<Scene<f64, N, D, C, R, C>, Error> {
    let mut next = || random.next().unwrap_or(0.0);
    let root = SMatrix::<f64, N, N>::from_fn(|_, _| next());
    let mut scene = Scene::new();
    scene.set_mass(&(root * root.transpose() + SMatrix::identity()))?;
    for key in 0..contacts {
        let contact =
            Contact { jacobian: SMatrix::from_fn(|_, _| next()), offset: SVector::zeros(), mu: 0.0, key };
        let friction = [0.4 + 0.3 * next(), 0.7];
        let surface = Surface {
            friction: if key == 1 { [0.0; 2] } else { friction },
            spin: if key == 1 { 0.0 } else { 0.2 },
            compliance: [0.1, 0.05],
            ..Surface::isotropic(0.0)
        };
        scene.push_on(&contact, &surface)?;
    }
    for key in 0..7 {
        let bound = 0.5 + 0.4 * next();
        scene.push_row(&JointRow {
            row: SVector::from_fn(|_, _| next()),
            offset: next(),
            law: match key % 3 {
                0 => RowLaw::Limit,
                1 => RowLaw::Equality,
                _ => RowLaw::Box { lower: -bound, upper: bound },
            },
            compliance: if key > 3 { 0.2 } else { 0.0 },
            key,
        })?;
    }
    Ok(scene)
}

/// Draws scenes and points of contacts of `D` rows and joint rows; how often each of stick, slip, open and frictionless was met.
fn check_rows<const D: usize>(contacts: u32, model: Model) -> Result<[usize; 4], Error> {
    let mut random = numbers();
    let mut modes = Vec::new();
    let (mut compared, mut met) = (0, [0; 4]);
    for _ in 0..200 {
        let scene = scene_with_rows::<D>(contacts, &mut random)?;
        let factor = Factor::new(&scene)?;
        let mut next = || random.next().unwrap_or(0.0);
        let push = SVector::from_fn(|_, _| next());
        let mut problem =
            Problem::new(&scene, &factor, &push, &Settings { model, ..Settings::default() }, Age::New);
        problem.fill(true);
        let [z, b] = [(); 2].map(|()| {
            let mut drawn = Stacked::zero();
            for entry in drawn.in_use_mut(scene.counts()) {
                *entry = next();
            }
            drawn
        });
        let point = point_at(&problem, &z);
        let Some((differences, jacobian)) = differences(&problem, &point, &b) else {
            continue;
        };
        compared += 1;
        for (index, difference) in differences.in_use(scene.counts()).enumerate() {
            assert!(*difference < 1e-6, "{D} rows a contact, index {index}: {difference:e}");
        }
        for frame in jacobian.frames.iter().take(scene.contacts().len()) {
            met[frame.kind as usize] += 1;
        }
        for (j, (set, &r)) in problem.sets.rows().iter().zip(&point.r.rows).enumerate() {
            let mode = RowMode::of(r, r, set.bounds);
            // A stop that pushes is free to push more or less.
            let holds = matches!(mode, RowMode::Holding | RowMode::AtLimit);
            assert_eq!(jacobian.holds[j], holds, "{mode:?}");
            modes.push(mode);
        }
    }
    assert!(compared > 100, "{compared}");
    for mode in [RowMode::Open, RowMode::AtLimit, RowMode::AtLower, RowMode::AtUpper, RowMode::Holding] {
        let times = modes.iter().filter(|&&found| found == mode).count();
        assert!(times > 20, "{mode:?}: {times}");
    }
    Ok(met)
}

/// With and without contacts, and where all of them stick, so that the system is symmetric.
#[test]
fn the_jacobian_of_joint_rows_is_the_derivative_of_the_residual() -> Result<(), Error> {
    for model in [Model::Coulomb, Model::ConvexRelaxation] {
        check_rows::<4>(1, model)?;
        check_rows::<3>(0, model)?;
        check_rows::<1>(2, model)?;
        let met = [check_rows::<2>(3, model)?, check_rows::<3>(3, model)?];
        assert!(met.iter().flatten().all(|&count| count > 20), "{met:?}");
    }
    Ok(())
}

/// `order[i]` says which contact, and which joint row, of a scene is the `i`-th of the new one.
fn reordered(
    scene: &Scene<f64, N, 3, 3, R, 3>,
    order: &EarlierIndices<3, 7>,
) -> Result<Scene<f64, N, 3, 3, R, 3>, Error> {
    let mut other = Scene::new();
    other.set_mass(scene.mass())?;
    for &i in &order.contacts {
        other.push(&Contact { mu: 0.4, ..scene.contacts()[i].clone() })?;
    }
    for &j in &order.rows {
        other.push_row(&scene.rows()[j])?;
    }
    Ok(other)
}

/// What stands elsewhere in the list of a scene takes the same step with the Jacobian that was kept.
#[test]
fn a_jacobian_follows_to_other_places() -> Result<(), Error> {
    let mut random = numbers();
    let orders = [
        EarlierIndices { contacts: [0, 1, 2], rows: [0, 1, 2, 3, 4, 5, 6] },
        EarlierIndices { contacts: [2, 0, 1], rows: [3, 1, 6, 0, 5, 4, 2] },
    ];
    let mut compared = 0;
    for _ in 0..50 {
        let scene = scene_with_rows::<3>(3, &mut random)?;
        let scenes = [reordered(&scene, &orders[0])?, reordered(&scene, &orders[1])?];
        let mut next = || random.next().unwrap_or(0.0);
        let push = SVector::from_fn(|_, _| next());
        let drawn = [(); 2].map(|()| {
            let mut drawn = Stacked::<f64, 3, 3, R>::zero();
            drawn.iter_mut().for_each(|entry| *entry = next());
            drawn
        });
        let (mut jacobian, mut matrix) = (Jacobian::none(), StackedMatrix::zero());
        let mut steps = Vec::new();
        for (scene, order) in scenes.iter().zip(&orders) {
            let factor = Factor::new(scene)?;
            let mut problem = Problem::new(scene, &factor, &push, &Settings::default(), Age::New);
            problem.fill(true);
            let [z, b] = drawn.map(|drawn| {
                let mut moved = drawn;
                for (moved, &i) in moved.contacts.iter_mut().zip(&order.contacts) {
                    *moved = drawn.contacts[i];
                }
                for (moved, &j) in moved.rows.iter_mut().zip(&order.rows) {
                    *moved = drawn.rows[j];
                }
                moved
            });
            let point = point_at(&problem, &z);
            if steps.is_empty() {
                let computed =
                    jacobian.compute(&problem.sets, problem.factor.delassus(), &point, 1e-3, &mut matrix);
                assert_eq!(computed, Some(()));
            } else {
                // Indices of unused rows do not count.
                let mut indices = EarlierIndices { contacts: order.contacts, rows: [R; R] };
                indices.rows[..7].copy_from_slice(&order.rows);
                jacobian.follow(&indices);
            }
            assert!(jacobian.has_same_active_set(&problem.sets, &point));
            steps.extend(jacobian.step(&problem.sets, problem.factor.delassus(), &b, &matrix));
        }
        let [there, here] = steps.as_slice() else { unreachable!("steps are finite") };
        let size = there.iter().fold(0.0_f64, |size, d| size.max(d.abs()));
        let mut wanted = *there;
        for (wanted, &i) in wanted.contacts.iter_mut().zip(&orders[1].contacts) {
            *wanted = there.contacts[i];
        }
        for (wanted, &j) in wanted.rows.iter_mut().zip(&orders[1].rows) {
            *wanted = there.rows[j];
        }
        for (here, wanted) in here.iter().zip(wanted.iter()) {
            assert!((here - wanted).abs() <= 1e-12 * size, "{here} {wanted}");
            compared += usize::from(*here != 0.0);
        }
        // A new joint row has no mode in the Jacobian.
        let mut indices = EarlierIndices { contacts: [0, 1, 2], rows: [0, 1, 2, 3, 4, 5, R, R] };
        jacobian.follow(&indices);
        let factor = Factor::new(&scenes[1])?;
        let mut problem = Problem::new(&scenes[1], &factor, &push, &Settings::default(), Age::New);
        problem.fill(true);
        let point = point_at(&problem, &drawn[0]);
        assert!(!jacobian.has_same_active_set(&problem.sets, &point));
        indices.rows[6] = 6;
        jacobian.follow(&indices);
        assert!(!jacobian.has_same_active_set(&problem.sets, &point));
    }
    assert!(compared > 500, "{compared}");
    Ok(())
}
