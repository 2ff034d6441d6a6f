//! What was once called solved, or Open, and was not: found by reasoning where fuzzing had not been.
#![allow(clippy::float_cmp)] // to the last bit

use crate::support::sizes::{joint, joints};
use nalgebra::{Matrix1, Matrix2, Matrix3, SMatrix, SVector, matrix, vector};
use stiction::{Contact, Error, Factor, JointRow, Kernel, RowLaw, RowMode, Scene, Settings, Status, Surface};
use testbed::measure::{Law, error_of};

fn row<T: stiction::Real, const N: usize>(
    row: SVector<T, N>,
    offset: T,
    law: RowLaw<T>,
    key: u32,
) -> JointRow<T, N> {
    JointRow { row, offset, law, compliance: T::ZERO, key }
}

fn normal<T: stiction::Real, const N: usize>(jacobian: SVector<T, N>, offset: T) -> Contact<T, N, 1> {
    Contact { jacobian: jacobian.transpose(), offset: vector![offset], mu: T::ZERO, key: 0 }
}

/// The impulse of a motor that moves nothing is no size to compare others with.
#[test]
fn a_row_that_nothing_moves_loosens_nothing() -> Result<(), Error> {
    let mut kernel = joint::Kernel::<f64>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix1::new(1.0))?;
    scene.push_row(&row(vector![1.0], 0.0, RowLaw::Limit, 0))?;
    let motor = RowLaw::Box { lower: 1e5, upper: 1e5 };
    scene.push_row(&row(vector![0.0], 0.0, motor, 1))?;
    for (push, velocity) in [(1.0, 1.0), (-1.0, 0.0)] {
        let solution = kernel.solve(&vector![push], &Settings::new(1e-4))?;
        assert!(solution.is_solved());
        assert!((solution.velocity[0] - velocity).abs() < 1e-3);
    }
    Ok(())
}

/// `q` is 0 by cancellation, and `W r + q` and `H v + w` are, too: what rounding hides is still there.
#[test]
fn rounding_counts_where_everything_cancels() -> Result<(), Error> {
    let mut kernel = joints::Kernel::<f32>::new();
    kernel.scene_mut().set_mass(&Matrix2::identity())?;
    let contact = normal(vector![0.909_239_4, 1.013_443_8], 0.0);
    kernel.scene_mut().push(&contact)?;
    let push = vector![0.560_922_6, -0.503_247_44];
    for tolerance in [1e-6_f32, 1e-4] {
        let solution = kernel.solve(&push, &Settings::new(tolerance))?.clone();
        let error = error_of(kernel.scene(), &push, &solution, Law::Coulomb);
        assert!(!solution.is_solved() || error <= f64::from(tolerance));
        assert!(tolerance < 1e-5 || solution.is_solved());
    }
    Ok(())
}

#[test]
fn a_limit_within_rounding_is_not_left_out() -> Result<(), Error> {
    let mut kernel = joints::Kernel::<f32>::new();
    kernel.scene_mut().set_mass(&Matrix2::identity())?;
    let limits = [row(vector![0.885_352, 0.955_784_8], 0.0, RowLaw::Limit, 0)];
    let push = vector![1.185_029_3, -1.097_703_3];
    let solution = kernel.solve_with_limits(&limits, &push, &Settings::new(1e-6))?;
    assert!(solution.row_by_key(0).is_some());
    Ok(())
}

/// An open limit is checked as well.
#[test]
fn a_limit_that_is_left_out_has_sound_numbers() -> Result<(), Error> {
    let mut kernel = joint::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&Matrix1::new(1.0))?;
    for compliance in [-1.0, f64::NAN] {
        let limits = [JointRow { compliance, ..row(vector![1.0], 5.0, RowLaw::Limit, 0) }];
        let refused = kernel.solve_with_limits(&limits, &vector![0.0], &Settings::new(1e-9));
        assert_eq!(refused.err(), Some(Error::InvalidLimit { limit: 0 }));
    }
    Ok(())
}

#[test]
fn a_solve_that_leaves_limits_out_is_not_resumed_without_them() -> Result<(), Error> {
    let mut kernel = joints::Kernel::<f64>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix2::identity())?;
    scene.push(&normal(vector![1.0, 0.3], 0.0))?;
    scene.push(&normal(vector![0.9, -0.4], 0.0))?;
    let limits = [0, 1, 2, 3, 4].map(|key| row(vector![-1.0, 0.0], 0.05, RowLaw::Limit, key));
    let hurried = Settings { budget: 1, ..Settings::new(1e-9) };
    let full = kernel.solve_with_limits(&limits, &vector![-1.0, 1.9], &hurried)?;
    assert_eq!(full.status, Status::OutOfBudget);
    let none = Settings { budget: 0, ..hurried };
    assert_eq!(kernel.resume(&vector![-5.0, 0.0], &none).err(), Some(Error::LimitsLeftOut));
    Ok(())
}

#[test]
fn a_limit_is_open_if_it_does_not_push() -> Result<(), Error> {
    let mut kernel = joints::Kernel::<f64>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix2::identity())?;
    for (key, (x, y, offset)) in
        [(-0.9, 0.9, -0.4), (0.3, -0.4, -0.3), (0.7, -0.9, -0.9)].into_iter().enumerate()
    {
        let key = u32::try_from(key).unwrap_or(0);
        scene.push_row(&row(vector![x, y], offset, RowLaw::Limit, key))?;
    }
    for tolerance in [1e-2, 1e-4, 1e-9] {
        let solution = kernel.solve(&vector![0.0, 0.0], &Settings::new(tolerance))?;
        assert_eq!(solution.rows.len(), 3);
        for found in &solution.rows {
            assert_eq!(found.mode == RowMode::Open, found.impulse == 0.0);
            assert!(found.mode == RowMode::Open || found.mode == RowMode::AtLimit);
        }
    }
    Ok(())
}

/// Two walls that nothing can move apart, beside a body that could be solved alone.
#[test]
fn what_cannot_be_met_is_not_solved() -> Result<(), Error> {
    let mut kernel = Kernel::<f32, 3, 3, 3>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix3::identity())?;
    for (scale, offset) in [(1.0, 0.0), (0.0, -1.0)] {
        scene.push(&Contact {
            jacobian: matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0] * scale,
            offset: vector![offset, 0.0, 0.0],
            mu: 0.5,
            key: 0,
        })?;
    }
    let solution = kernel.solve(&vector![0.1, 0.0, -1.0], &Settings::new(1e-4))?;
    assert_eq!(solution.status, Status::Infeasible);
    Ok(())
}

/// Rows that nothing moves, and rows whose `W_jj` only seems to vanish or has no number.
#[test]
fn a_row_out_of_range_is_refused_with_its_key() -> Result<(), Error> {
    let refused = Err(Error::RowOutOfRange { key: 9 });
    for (mass, entry) in [(1.0, 2e19), (1e12, 1e-17), (1.0, 1e-23), (1e30, 1e-5)] {
        let mut kernel = joint::Kernel::<f32>::new();
        kernel.scene_mut().set_mass(&Matrix1::new(mass))?;
        let limit = row(vector![entry], -1e-3, RowLaw::Limit, 9);
        let outside =
            kernel.solve_with_limits(std::slice::from_ref(&limit), &vector![-1.0], &Settings::new(1e-4));
        assert_eq!(outside.map(|_| ()), refused);
        kernel.scene_mut().push_row(&limit)?;
        let inside = kernel.solve(&vector![-1.0], &Settings::new(1e-4));
        assert_eq!(inside.map(|_| ()), refused);
    }
    Ok(())
}

#[test]
fn a_contact_whose_normal_only_seems_to_move_nothing_is_refused() -> Result<(), Error> {
    for (mass, entry) in [(1e12, 1e-17), (1.0, 1e-23), (1.0, 2e19)] {
        let mut scene = Scene::<f32, 1, 1, 1>::new();
        scene.set_mass(&Matrix1::new(mass))?;
        scene.push(&normal(vector![entry], -1e-3))?;
        let refused = Err(Error::DelassusOutOfRange { contact: 0 });
        assert_eq!(Factor::new(&scene).map(|_| ()), refused);
    }
    Ok(())
}

/// Beside a motion that is large enough to make its impulse small.
#[test]
fn a_row_that_nothing_moves_stays_within_its_bounds() -> Result<(), Error> {
    for offset in [0.158, 0.0, -0.158] {
        let mut kernel = joint::Kernel::<f64>::new();
        let scene = kernel.scene_mut();
        scene.set_mass(&Matrix1::new(1.0))?;
        let (lower, upper) = (0.0828, 0.0828);
        let fixed = scene.push_row(&row(vector![0.0], offset, RowLaw::Box { lower, upper }, 0))?;
        scene.push_row(&row(vector![1.0], 0.0, RowLaw::Limit, 1))?;
        for push in [0.3, 1e6] {
            for budget in [0, 1_000] {
                let settings = Settings { budget, ..Settings::new(1e-4) };
                let solution = kernel.solve(&vector![push], &settings)?;
                assert_eq!(solution.rows[fixed].impulse, lower);
            }
        }
    }
    Ok(())
}

/// A sum of thirty terms loses more than each of them: what it may lose is counted.
#[test]
fn a_long_sum_is_not_trusted_too_far() -> Result<(), Error> {
    let (small, last) = (2.45e-4_f32, 1.0_f32);
    let mut jacobian = SVector::<f32, 30>::repeat(small);
    jacobian[29] = last;
    let mut kernel = Kernel::<f32, 30, 1, 1, 1>::new();
    kernel.scene_mut().set_mass(&SMatrix::identity())?;
    kernel.scene_mut().push(&normal(jacobian, 1.0))?;
    let mut limited = Kernel::<f32, 30, 1, 1, 1>::new();
    limited.scene_mut().set_mass(&SMatrix::identity())?;
    let limits = [row(jacobian, 1.0, RowLaw::Limit, 0)];
    let mut solved = 0;
    for k in 0..40_u8 {
        let mut push = jacobian;
        push[29] = -(1.0 + 29.0 * 6.0025e-8) - f32::from(k) * 5.96e-8;
        for tolerance in [1e-4_f32, 1e-6] {
            let settings = Settings::new(tolerance);
            let solution = kernel.solve(&push, &settings)?.clone();
            let error = error_of(kernel.scene(), &push, &solution, Law::Coulomb);
            assert!(!solution.is_solved() || error <= f64::from(tolerance), "{k}: {error:e}");
            solved += usize::from(solution.is_solved());
            let solution = limited.solve_with_limits(&limits, &push, &settings)?;
            let wide = |x: &SVector<f32, 30>| x.map(f64::from);
            let speed = wide(&jacobian).dot(&wide(&solution.velocity)) + 1.0;
            assert!(solution.row_by_key(0).is_some() || speed >= 0.0, "{k}: {speed:e}");
        }
    }
    assert!(solved >= 40, "{solved} of 80");
    Ok(())
}

/// A factor is that of its scene alone, also where the same numbers stand elsewhere in another one.
#[test]
fn a_factor_tells_a_jacobian_from_a_compliance() -> Result<(), Error> {
    let scene = |[entry, compliance]: [f64; 2]| -> Result<_, Error> {
        let mut scene = Scene::<f64, 5, 1, 1, 0, 1>::new();
        scene.set_mass(&SMatrix::identity())?;
        let surface = Surface { compliance: [compliance, 0.0], ..Surface::isotropic(0.0) };
        let contact = normal(vector![0.0, 0.0, 0.0, 0.0, entry], 0.0);
        scene.push_on(&contact, &surface)?;
        Ok(scene)
    };
    let factor = Factor::new(&scene([1.0, 0.5])?)?;
    assert!(factor.is_current(&scene([1.0, 0.5])?));
    assert!(!factor.is_current(&scene([0.5, 1.0])?));

    // A mass and a row of the same numbers.
    let scene = |[mass, entry]: [f64; 2]| -> Result<_, Error> {
        let mut scene = joint::Scene::<f64>::new();
        scene.set_mass(&Matrix1::new(mass))?;
        scene.push_row(&row(vector![entry], 0.0, RowLaw::Equality, 0))?;
        Ok(scene)
    };
    let factor = Factor::new(&scene([2.0, 3.0])?)?;
    assert!(!factor.is_current(&scene([3.0, 2.0])?));
    Ok(())
}

/// A factor tells scenes apart, also once something in them is replaced, and a kernel notices another scene in the place of its own.
#[test]
fn a_factor_tells_scenes_apart() -> Result<(), Error> {
    let scene = |mass: f64, entry: f64| -> Result<_, Error> {
        let mut scene = Scene::<f64, 1, 1, 1>::new();
        scene.set_mass(&Matrix1::new(mass))?;
        scene.push(&normal(vector![entry], -1.0))?;
        Ok(scene)
    };
    let factor = Factor::new(&scene(1.0, 1.0)?)?;
    assert!(factor.is_current(&scene(1.0, 1.0)?));
    assert!(!factor.is_current(&scene(2.0, 1.0)?) && !factor.is_current(&scene(1.0, 2.0)?));
    let mut other = scene(3.0, 2.0)?;
    other.set_mass(&Matrix1::new(1.0))?;
    assert!(!factor.is_current(&other));
    other.set_jacobian(0, &Matrix1::new(1.0))?;
    assert!(factor.is_current(&other));

    let mut kernel = Kernel::<f64, 1, 1, 1>::new();
    for mass in [1.0, 4.0] {
        *kernel.scene_mut() = scene(mass, 1.0)?;
        let impulse = kernel.solve(&vector![0.0], &Settings::new(1e-9))?.contacts[0].impulse;
        assert_eq!(impulse, vector![mass]);
    }
    Ok(())
}

/// What gives way is added to a velocity once, also where numbers are too large to be computed with twice the digits.
#[test]
fn compliance_is_added_once() -> Result<(), Error> {
    let (entry, compliance) = (1e35_f32, 1e34_f32);
    let mut kernel = joint::Kernel::<f32>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix1::new(entry))?;
    let surface = Surface { compliance: [compliance, 0.0], ..Surface::isotropic(0.0) };
    scene.push_on(&normal(vector![entry], 0.0), &surface)?;
    let solution = kernel.solve(&vector![-0.5 * entry], &Settings::new(1e-12))?;
    let (v, contact) = (solution.velocity[0], &solution.contacts[0]);
    let expected = f64::from(entry) * f64::from(v) + f64::from(compliance * contact.impulse[0]);
    let terms = f64::from(compliance * contact.impulse[0]);
    assert!(terms > 0.0);
    assert!((f64::from(contact.velocity[0]) - expected).abs() < 1e-5 * terms);
    Ok(())
}

/// A tangent along which hardly any friction acts is no reason for a rigid surface to end without numbers.
#[test]
fn a_scale_whose_square_vanishes_is_one() -> Result<(), Error> {
    let mut kernel = Kernel::<f32, 3, 3, 3, 0, 1>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix3::identity())?;
    let contact = Contact { jacobian: Matrix3::identity(), offset: vector![0.0, 0.0, 0.0], mu: 0.0, key: 0 };
    let surface = Surface { friction: [1.0, 1e-23], ..Surface::isotropic(0.0) };
    scene.push_on(&contact, &surface)?;
    let solution = kernel.solve(&vector![-1.0, 0.2, 0.1], &Settings::default())?;
    assert!(solution.is_solved(), "{:?}", solution.status);
    assert!((solution.velocity - vector![0.0, 0.0, 0.1]).norm() < 1e-3);
    Ok(())
}

/// The worst contact does not depend on the unit of mass.
#[test]
fn the_worst_contact_is_the_same_in_other_units() -> Result<(), Error> {
    let mut found = Vec::new();
    for unit in [1.0, 2.0_f32.powi(-80)] {
        let mut kernel = Kernel::<f32, 6, 3, 4>::new();
        let scene = kernel.scene_mut();
        scene.set_mass(&(SMatrix::identity() * unit))?;
        for body in 0..2 {
            let jacobian = SMatrix::from_fn(|k, j| if j == 3 * body + k { 1.0 } else { 0.0 });
            let (offset, key) = (SVector::zeros(), u32::try_from(body).unwrap_or(0));
            scene.push(&Contact { jacobian, offset, mu: 0.5, key })?;
        }
        let settings = Settings { budget: 0, ..Settings::new(1e-5) };
        // The first is pressed a little, the second slides fast and is pressed less.
        let push = vector![-1.0, 0.0, 0.0, -0.9, 3.0, 4.0] * unit;
        kernel.solve(&push, &settings)?;
        let violation = kernel.violation().outside_cone / unit;
        found.push((kernel.worst_contact(), violation));
    }
    assert_eq!(found[0], found[1]);
    assert_eq!(found[0].0, Some(0));
    Ok(())
}

/// Two walls with a gap at one of them, and impulses of an earlier tick that press against both: no contact asks for an impulse, so that these
/// would be compared with nothing but themselves.
#[test]
fn impulses_that_nothing_asks_for_are_no_solution() -> Result<(), Error> {
    let mut kernel = joints::Kernel::<f64>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix2::identity())?;
    scene.push(&normal(vector![1.0, 0.0], 0.0))?;
    let other = normal(vector![-1.0, 0.0], 0.5);
    scene.push(&Contact { key: 1, ..other })?;
    // What moves by itself, so that no impulse at all does not solve the scene.
    scene.push_row(&row(vector![0.0, 1.0], 0.0, RowLaw::Limit, 0))?;
    let pressed = [(0, vector![5.0]), (1, vector![4.95])];
    kernel.solver_mut().set_impulses(&pressed, &[])?;
    let solution = kernel.solve(&vector![0.1, -1e-3], &Settings::new(0.1))?;
    assert!(solution.is_solved());
    for contact in &solution.contacts {
        assert_eq!(contact.impulse[0], 0.0);
    }
    Ok(())
}

/// The same beside a fast belt along a row without friction: nothing can push along it, so that it lets expect no impulse.
#[test]
fn a_belt_without_friction_loosens_nothing() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 2, 3, 2, 0, 2>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix2::identity())?;
    let across = Surface { friction: [0.0, 1.0], spin: 0.0, roll: [0.0; 2], compliance: [0.0; 2] };
    for (key, side, offset) in [(0, 1.0, -0.01), (1, -1.0, 0.5)] {
        let contact = Contact {
            jacobian: matrix![side, 0.0; 0.0, 0.0; 0.0, 1.0],
            offset: vector![offset, 100.0, 0.0],
            mu: 0.0,
            key,
        };
        scene.push_on(&contact, &across)?;
    }
    let pressed = [(0, vector![5.0, 0.0, 0.0]), (1, vector![4.95, 0.0, 0.0])];
    kernel.solver_mut().set_impulses(&pressed, &[])?;
    let solution = kernel.solve(&vector![0.0, 0.0], &Settings::new(0.2))?;
    assert!(solution.is_solved());
    for contact in &solution.contacts {
        assert!(contact.impulse[0] < 0.1, "{}", contact.impulse[0]);
    }
    Ok(())
}
