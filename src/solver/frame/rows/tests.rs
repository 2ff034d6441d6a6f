//! The Jacobian of slots of joint rows, beside contacts that give way and have an elliptic cone, against finite differences of
//! `E(z)`.
#![allow(clippy::indexing_slicing)]

extern crate std;

use crate::laws::Mixed;
use crate::problem::Problem;
use crate::solver::jacobian::Jacobian;
use crate::solver::point::Point;
use crate::{Contact, Error, Factor, JointRow, Model, RowLaw, RowMode, Scene, Surface};
use nalgebra::{SMatrix, SVector};
use std::vec::Vec;

const N: usize = 16;
const D: usize = 4;
const C: usize = 3;

/// Numbers between -1 and 1, the same each time.
fn numbers() -> impl Iterator<Item = f64> {
    let mut state = 7_u32;
    core::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / f64::from(1_u32 << 31) - 1.0
    })
}

/// A contact on an elliptic cone, and two slots of rows of all laws, some of which give way.
fn scene(random: &mut impl Iterator<Item = f64>) -> Result<Scene<f64, N, D, C, Mixed>, Error> {
    let mut next = || random.next().unwrap_or(0.0);
    let root = SMatrix::<f64, N, N>::from_fn(|_, _| next());
    let mut scene = Scene::mixed();
    scene.set_mass(&(root * root.transpose() + SMatrix::identity()))?;
    let contact = Contact {
        jacobian: SMatrix::from_fn(|_, _| next()),
        offset: SVector::zeros(),
        mu: 0.0,
        key: 0,
    };
    let surface = Surface {
        friction: [0.4 + 0.3 * next(), 0.7],
        spin: 0.2,
        compliance: [0.1, 0.05],
        ..Surface::isotropic(0.0)
    };
    scene.push_on(&contact, &surface)?;
    for key in 0..7 {
        let bound = 0.5 + 0.4 * next();
        scene.push_row(&JointRow {
            row: SVector::from_fn(|_, _| next()),
            offset: next(),
            law: match key % 3 {
                0 => RowLaw::Limit,
                1 => RowLaw::Equality,
                _ => RowLaw::Box {
                    lower: -bound,
                    upper: bound,
                },
            },
            compliance: if key > 3 { 0.2 } else { 0.0 },
            key,
        })?;
    }
    Ok(scene)
}

#[test]
fn the_jacobian_is_the_derivative_of_the_residual() -> Result<(), Error> {
    let mut random = numbers();
    let mut met = Vec::new();
    let mut compared = 0;
    for _ in 0..200 {
        let scene = scene(&mut random)?;
        let factor = Factor::new(&scene)?;
        let mut next = || random.next().unwrap_or(0.0);
        let push = SVector::from_fn(|_, _| next());
        let mut problem = Problem::new(&scene, &factor, &push, Model::Coulomb);
        problem.fill(true);
        let z: [SVector<f64, D>; C] = core::array::from_fn(|_| SVector::from_fn(|_, _| next()));
        let b: [[f64; D]; C] = core::array::from_fn(|_| core::array::from_fn(|_| next()));
        let at = |z: [SVector<f64, D>; C]| {
            let mut point = Point::none();
            point.z = z;
            point.update(&problem);
            point
        };
        let point = at(z);
        let (mut jacobian, mut matrix) = (Jacobian::none(), [[[[0.0; D]; C]; D]; C]);
        let step = jacobian.compute(&problem, &point, 0.0, &mut matrix);
        let step = step.and_then(|()| jacobian.step(&problem, &b, &matrix));
        let Some(d) = step else { continue };
        let size = d.iter().fold(0.0_f64, |size, d| size.max(d.amax()));
        let h = 1e-6 / size;
        let [ahead, behind] = [h, -h].map(|h| at(core::array::from_fn(|i| z[i] + d[i] * h)));
        // At a kink there is no derivative.
        let same = |point| jacobian.has_same_active_set(&problem, point);
        if !(same(&ahead) && same(&behind)) {
            continue;
        }
        compared += 1;
        for (i, law) in problem.laws().iter().enumerate() {
            let slopes = ahead.residual[i].iter().zip(&behind.residual[i]);
            for (k, ((ahead, behind), b)) in slopes.zip(&b[i]).enumerate() {
                let slope = (ahead - behind) / (2.0 * h);
                assert!((slope + b).abs() < 1e-6, "slot {i}, row {k}: {slope}");
            }
            for (r, [lower, upper]) in point.r[i]
                .iter()
                .zip(law.rows.iter().flat_map(|rows| rows.bounds))
            {
                met.push(RowMode::of(*r, *r, [lower, upper]));
            }
        }
    }
    assert!(compared > 100);
    for mode in [
        RowMode::Open,
        RowMode::AtLimit,
        RowMode::AtLower,
        RowMode::AtUpper,
        RowMode::Holding,
    ] {
        let times = met.iter().filter(|&&found| found == mode).count();
        assert!(times > 20, "{mode:?}: {times}");
    }
    Ok(())
}
