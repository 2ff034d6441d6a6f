//! Helpers beside the solver, each with numbers to be checked by hand: frames of contacts, suction, static friction, what a mechanic
//! measures, the budget of a tick, and scenes of joint rows alone.
#![allow(clippy::float_cmp)] // to the last bit

use crate::support::boxes::planar_floor;
use crate::support::pad;
use crate::support::random::{draws, numbers};
use crate::support::sizes::{block, cart, joint, joints, linkage, point, roomy_linkage};
use nalgebra::{Matrix1, Matrix2, Matrix3, Matrix4, SMatrix, SVector, Vector3, matrix, vector};
use stiction::time_stepping::{Parameter, StaticFriction, Suction, free_impulse, moving_surface};
use stiction::{
    AllPhases, Contact, ContactMode, Error, JointRow, Kernel, List, Model, Phases, RowLaw, RowMode, Scene,
    Settings, Status, Surface, SweepsAndNewton, SweepsOnly, contact_frame,
};

/// Normals along all axes, either way, next to them, and anywhere.
fn normals() -> Vec<Vector3<f64>> {
    let axes = (0..3).flat_map(|k| [1.0, -1.0].map(|sign| Vector3::ith(k, sign)));
    let near = vector![-1.0, 1e-9, -1e-12].normalize();
    let any = draws(numbers(3), 200).map(|x| Vector3::from_column_slice(&x));
    let any = any.filter(|x| x.norm() > 1e-3).map(|x| x.normalize());
    axes.chain([near, -near]).chain(any).collect()
}

#[test]
fn a_frame_is_orthonormal_and_begins_with_its_normal() -> Result<(), Error> {
    for normal in normals() {
        let frame = contact_frame(&normal)?;
        assert!((frame.column(0) - normal).amax() <= 1e-15);
        let off = frame.transpose() * frame - Matrix3::identity();
        assert!(off.amax() <= 1e-15, "{normal:?}: {:e}", off.amax());
        // In the plane, too.
        let flat = vector![normal.x, normal.y];
        if flat.norm() > 1e-3 {
            let frame = contact_frame(&flat.normalize())?;
            assert!((frame.column(0) - flat.normalize()).amax() <= 1e-15);
            assert!((frame.transpose() * frame - Matrix2::identity()).amax() <= 1e-15);
        }
    }
    // By hand: on the ground and at a ceiling, in space and in the plane.
    let ground = contact_frame(&vector![0.0, 0.0, 1.0])?;
    assert_eq!(ground, matrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; 1.0, 0.0, 0.0]);
    let ceiling = contact_frame(&vector![0.0, 0.0, -1.0])?;
    assert_eq!(ceiling, matrix![0.0, -1.0, 0.0; 0.0, 0.0, 1.0; -1.0, 0.0, 0.0]);
    assert_eq!(contact_frame(&vector![0.0, 1.0])?, matrix![0.0, 1.0; 1.0, 0.0]);
    assert_eq!(contact_frame(&vector![1.0])?, Matrix1::new(1.0));
    Ok(())
}

/// Between normals that are near each other, no entry of the frame moves farther than three times as far, but for normals that point down.
#[test]
fn a_frame_turns_with_its_normal_without_a_jump() -> Result<(), Error> {
    for (normal, x) in normals().iter().zip(draws(numbers(3), 1_000)) {
        let near = (normal + Vector3::from_column_slice(&x[..3]) * 1e-4).normalize();
        let (turn, height) = ((near - normal).amax(), 1.0 + normal.z.min(near.z));
        let moved = (contact_frame(&near)? - contact_frame(normal)?).amax();
        assert!(moved <= 4.0 * turn / height + 1e-15, "{normal:?}, {near:?}: {moved:e}");
    }
    Ok(())
}

/// What an impulse does to the body it does at the point as well: `Hᵀ r = Jᵀ (frame r)`.
#[test]
fn the_impulse_of_a_contact_at_a_point_is_a_vector_there() -> Result<(), Error> {
    for (normal, x) in normals().iter().zip(draws(numbers(24), 1_000)) {
        let point = SMatrix::<f64, 3, 6>::from_column_slice(&x[..18]);
        let contact = Contact::<f64, 6, 3>::at_point(normal, &point, 0.7, 9)?;
        assert_eq!((contact.mu, contact.key), (0.7, 9));
        assert_eq!(contact.offset, Vector3::zeros());
        let r = Vector3::from_column_slice(&x[18..21]);
        let there = contact_frame(normal)? * r;
        let off = contact.jacobian.transpose() * r - point.transpose() * there;
        assert!(off.amax() <= 1e-14, "{off:?}");
        assert!((contact.jacobian.row(0) - normal.transpose() * point).amax() <= 1e-15);
        // A contact without tangents has the normal row.
        let smooth = Contact::<f64, 6, 1>::at_point(normal, &point, 0.0, 9)?;
        assert_eq!(smooth.jacobian.row(0), contact.jacobian.row(0));
    }
    Ok(())
}

/// 3 kg on a slope of 0.3 rad, whose friction holds 0.25 rad: it slides down by `h g (sin - mu cos)`, along the slope.
#[test]
fn a_contact_at_a_point_slides_down_its_slope() -> Result<(), Error> {
    let (mass, slope, step, gravity) = (3.0, 0.3_f64, 0.01, 9.81);
    let mu = f64::tan(0.25);
    let normal = vector![slope.sin(), 0.0, slope.cos()];
    let mut kernel = Kernel::<f64, 3, 3, 3>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&(Matrix3::identity() * mass))?;
    scene.push(&Contact::at_point(&normal, &Matrix3::identity(), mu, 0)?)?;
    let push = vector![0.0, 0.0, -mass * gravity * step];
    let solution = kernel.solve(&push, &Settings::new(1e-12))?;
    let speed = step * gravity * (slope.sin() - mu * slope.cos());
    let wanted = vector![slope.cos(), 0.0, -slope.sin()] * speed;
    assert!((solution.velocity - wanted).norm() < 1e-12);
    assert_eq!(solution.contacts[0].mode, ContactMode::Slip);
    Ok(())
}

#[test]
fn a_normal_is_as_long_as_one() -> Result<(), Error> {
    let refused = Err(Error::InvalidParameter { parameter: Parameter::Normal });
    let point = Matrix3::identity();
    for wrong in [
        vector![0.0, 0.0, 0.0],
        vector![0.0, 0.0, 1.01],
        vector![0.6, 0.0, 0.79],
        vector![f64::NAN, 0.0, 1.0],
        vector![f64::INFINITY, 0.0, 0.0],
        vector![1e200, 0.0, 0.0],
    ] {
        assert_eq!(contact_frame(&wrong), refused);
        let contact = Contact::<f64, 3, 3>::at_point(&wrong, &point, 0.5, 0);
        assert_eq!(contact.map(|_| point), refused);
    }
    // Rounded numbers are made one, and no more is.
    let frame = contact_frame(&vector![0.0, 0.6004, 0.8])?;
    assert!((frame.transpose() * frame - point).amax() <= 1e-15);
    Ok(())
}

/// 2 kg at a ceiling (x, height), held by a cup of 16 N for half a second, on rubber of coefficient 0.5.
fn hang(weight: f64, sideways: f64) -> Result<(SVector<f64, 2>, SVector<f64, 2>), Error> {
    hang_at(0.0, weight, sideways)
}

/// The same from so far below the ceiling.
fn hang_at(gap: f64, weight: f64, sideways: f64) -> Result<(SVector<f64, 2>, SVector<f64, 2>), Error> {
    let (step, touches) = (0.5, gap <= 0.0);
    let cup = Suction { force: 16.0, touches };
    let jacobian = matrix![0.0, -1.0; 1.0, 0.0]; // out of the ceiling is down
    let mut kernel = Kernel::<f64, 2, 2, 2>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&(Matrix2::identity() * 2.0))?;
    scene.push(&Contact { jacobian, offset: vector![gap / step, 0.0], mu: 0.5, key: 0 })?;
    let mut push = vector![sideways, -weight] * step;
    cup.push_back(&jacobian, step, &mut push)?;
    let solution = kernel.solve(&push, &Settings::new(1e-12))?;
    assert!(solution.is_solved());
    let impulse = cup.impulse(&solution.contacts[0].impulse, step)?;
    Ok((solution.velocity, impulse))
}

#[test]
fn a_suction_cup_holds_up_to_its_force_and_lets_go_above() -> Result<(), Error> {
    let near = |x: SVector<f64, 2>, y: [f64; 2]| (x - SVector::from(y)).norm() < 1e-10;
    // Below its force it pulls as much as hangs there, 7.95 N·s of 8.
    let (velocity, impulse) = hang(15.9, 0.0)?;
    assert!(near(velocity, [0.0, 0.0]) && near(impulse, [-7.95, 0.0]));
    // Above it pulls as much as it can, and what is left falls: (17 - 16) 0.5 / 2 kg.
    let (velocity, impulse) = hang(17.0, 0.0)?;
    assert!(near(velocity, [0.0, -0.25]) && near(impulse, [-8.0, 0.0]));
    // Pressed onto the ceiling it is a contact like any other.
    let (velocity, impulse) = hang(-4.0, 0.0)?;
    assert!(near(velocity, [0.0, 0.0]) && near(impulse, [2.0, 0.0]));
    Ok(())
}

#[test]
fn a_suction_cup_pulls_nothing_across_a_gap() -> Result<(), Error> {
    let (velocity, impulse) = hang_at(1.0, 10.0, 0.0)?;
    assert_eq!(velocity, vector![0.0, -2.5]);
    assert_eq!(impulse, vector![0.0, 0.0]);
    Ok(())
}

/// With 10 N hanging there 6 of the cup's 16 N press it on, and 3 N of them hold sideways: `mu (r_N + a)`.
#[test]
fn a_suction_cup_holds_sideways_what_its_pull_presses() -> Result<(), Error> {
    let near = |x: SVector<f64, 2>, y: [f64; 2]| (x - SVector::from(y)).norm() < 1e-10;
    let (velocity, impulse) = hang(10.0, 2.9)?;
    assert!(near(velocity, [0.0, 0.0]) && near(impulse, [-5.0, -1.45]));
    let (velocity, impulse) = hang(10.0, 5.0)?;
    assert!(near(velocity, [0.5, 0.0]) && near(impulse, [-5.0, -1.5])); // (5 - 3) 0.5 / 2 kg
    let (velocity, impulse) = hang(-4.0, 11.0)?;
    assert!(near(velocity, [0.25, 0.0]) && near(impulse, [2.0, -5.0])); // 0.5 (4 + 16) N of 11
    Ok(())
}

/// 1 kg that weighs 10 N: 5 N hold it while it stands, 3 N brake it while it slides. Steps of 0.1 s, pushed by what is given.
#[test]
fn what_slides_is_braked_by_less_than_what_stands() -> Result<(), Error> {
    let (friction, step) = (StaticFriction { at_rest: 0.5, sliding: 0.3 }, 0.1);
    let mut kernel = Kernel::<f64, 2, 2, 2>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&Matrix2::identity())?;
    scene.push(&planar_floor(friction.at_rest, 7))?;
    let mut velocity = vector![0.0, 0.0];
    for (tick, (force, wanted)) in [
        (4.0, 0.0),
        (6.0, 0.1), // it stood until now: 5 N are overcome
        (6.0, 0.4), // and now 3 N
        (4.0, 0.5), // which would not have moved it
        (1.0, 0.3),
        (1.0, 0.1),
        (1.0, 0.0), // it stops
        (4.0, 0.0), // and stands
    ]
    .into_iter()
    .enumerate()
    {
        let mode = kernel.solution().contact_by_key(7).map(|found| found.mode);
        assert_eq!(mode.is_none(), tick == 0);
        kernel.scene_mut().set_friction(0, friction.mu(mode))?;
        let push = velocity + vector![force, -10.0] * step;
        velocity = kernel.solve(&push, &Settings::new(1e-12))?.velocity;
        assert!((velocity.x - wanted).abs() < 1e-10, "{tick}: {velocity:?}");
    }
    for mode in [ContactMode::Open, ContactMode::Stick] {
        assert_eq!(friction.mu(Some(mode)), 0.5);
    }
    Ok(())
}

fn close(x: f64, y: f64) -> bool {
    (x - y).abs() < 1e-10
}

/// In m/s and N·s: what falls through a floor, and what friction holds that it cannot.
#[test]
fn a_violation_is_the_worst_of_all_contacts_in_the_units_of_the_scene() -> Result<(), Error> {
    // Two bodies of 2 kg (x, height each) on one floor.
    let mut kernel = cart::Kernel::<f64>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&(SMatrix::identity() * 2.0))?;
    for (key, body) in [(0, 0), (1, 2)] {
        let mut jacobian = SMatrix::zeros();
        (jacobian[(0, body + 1)], jacobian[(1, body)]) = (1.0, 1.0);
        scene.push(&Contact { jacobian, offset: vector![0.0, 0.0], mu: 0.5, key })?;
    }
    let push = pad::vector(vector![4.0, -2.0, 9.0, -6.0]);
    let none = Settings { budget: 0, ..Settings::new(1e-12) };
    // Nothing pushes yet: they fall at 1 m/s and at 3.
    kernel.solve(&push, &none)?;
    let violation = kernel.violation();
    assert_eq!((violation.closing_speed, violation.outside_cone), (3.0, 0.0));
    // Solved, with friction of 1 N·s and 3.
    kernel.solve(&push, &Settings::new(1e-12))?;
    let violation = kernel.violation();
    assert!(violation.closing_speed < 1e-11 && violation.outside_cone < 1e-11);
    // On a floor that holds 0.2 of 2 N·s and of 6 they would be too much by 0.6 and 1.8; on the first alone by 0.6.
    kernel.scene_mut().set_friction(0, 0.2)?;
    assert!(close(kernel.violation().outside_cone, 0.6));
    kernel.scene_mut().set_friction(1, 0.2)?;
    assert!(close(kernel.violation().outside_cone, 1.8));
    Ok(())
}

/// A joint row of one velocity.
fn row_of(law: RowLaw<f64>) -> JointRow<f64, 1> {
    JointRow { row: vector![1.0], offset: 0.0, law, compliance: 0.0, key: 0 }
}

/// A stop that a joint runs through, a loop that opens and a motor that is pushed back are violations, too.
#[test]
fn a_violation_is_that_of_joint_rows_as_well() -> Result<(), Error> {
    let (lower, upper) = (-1.0, 1.0);
    let none = Settings { budget: 0, ..Settings::new(1e-12) };
    for (law, push, speed) in [
        (RowLaw::Limit, -3.0, 3.0),
        (RowLaw::Limit, 3.0, 0.0),
        (RowLaw::Equality, -3.0, 3.0),
        (RowLaw::Equality, 3.0, 3.0),
        (RowLaw::Box { lower, upper }, 0.5, 0.5),
        (RowLaw::Box { lower, upper }, -0.5, 0.5),
    ] {
        let mut kernel = joint::Kernel::<f64>::new();
        kernel.scene_mut().set_mass(&Matrix1::new(1.0))?;
        kernel.scene_mut().push_row(&row_of(law))?;
        kernel.solve(&vector![push], &none)?;
        assert_eq!(kernel.violation().row_speed, speed, "{law:?}");
        kernel.solve(&vector![push], &Settings::new(1e-12))?;
        assert!(close(kernel.violation().row_speed, 0.0));
    }
    Ok(())
}

/// Impulses within their cones and bounds, and no wall that is passed: and yet not Coulomb's law.
#[test]
fn a_violation_is_also_friction_that_does_not_act_and_an_impulse_at_a_distance() -> Result<(), Error> {
    // 2 kg pressed onto a floor by 1 N·s. It slides without friction, and then the floor gets some.
    let settings = Settings::new(1e-12);
    let mut kernel = block::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&(Matrix2::identity() * 2.0))?;
    kernel.scene_mut().push(&planar_floor(0.0, 0))?;
    let mut slide = |momentum: f64, mu: f64, model: Model| -> Result<_, Error> {
        kernel.scene_mut().set_friction(0, if model == Model::Coulomb { 0.0 } else { mu })?;
        kernel.solve(&vector![momentum, -1.0], &Settings { model, ..settings })?;
        assert!(kernel.solution().is_solved());
        kernel.scene_mut().set_friction(0, mu)?;
        let violation = kernel.violation();
        assert_eq!((violation.outside_cone, violation.row_speed, violation.row_impulse), (0.0, 0.0, 0.0));
        assert!(violation.closing_speed < 1e-12);
        Ok([violation.creep, violation.missing_friction, violation.opening_impulse])
    };
    let is = |found: [f64; 3], wanted: [f64; 3]| {
        assert!(found.iter().zip(wanted).all(|(x, y)| close(*x, y)), "{found:?} {wanted:?}");
    };
    // Friction of up to 0.5 N·s could stop 0.2 N·s, and of 3 N·s takes 0.5.
    is(slide(0.2, 0.5, Model::Coulomb)?, [0.1, 0.0, 0.0]);
    is(slide(3.0, 0.5, Model::Coulomb)?, [0.0, 0.5, 0.0]);
    // The relaxation has it, and opens at 0.5 of the speed. The load then is 1 N·s and what lifts 2 kg so fast.
    let [creep, missing, opening] = slide(3.0, 0.5, Model::ConvexRelaxation)?;
    is([creep, missing, opening], [0.0, 0.0, 1.0]);

    // Dry friction of 1 N·m·s that does not act at 3 rad/s, and a stop that pushes what leaves it.
    let mut kernel = joint::Kernel::<f64>::new();
    kernel.scene_mut().set_mass(&Matrix1::new(1.0))?;
    let index = kernel.scene_mut().push_row(&row_of(RowLaw::Box { lower: -1.0, upper: 1.0 }))?;
    for (speed, wanted) in [(3.0, 1.0), (-3.0, 1.0), (0.5, 0.0)] {
        kernel.solve(&vector![speed], &Settings { budget: 0, ..settings })?;
        assert_eq!(kernel.violation().row_impulse, wanted, "{speed}");
        kernel.solve(&vector![speed], &settings)?;
        assert!(close(kernel.violation().row_impulse, 0.0));
    }
    kernel.scene_mut().set_row_law(index, RowLaw::Limit)?;
    kernel.solver_mut().set_impulses(&[], &[(0, 4.0)])?;
    kernel.solve(&vector![-3.0], &Settings { budget: 0, ..settings })?;
    assert!(close(kernel.violation().row_impulse, 1.0), "{:?} {:?}", kernel.violation(), kernel.solution());
    Ok(())
}

/// A solution beside a scene of others: what only the scene knows of a contact is not taken from another one.
#[test]
fn a_contact_of_another_key_is_not_measured_by_what_stands_in_its_place() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 2, 2, 2>::new();
    kernel.scene_mut().set_mass(&Matrix2::identity())?;
    kernel.scene_mut().push(&planar_floor(0.5, 7))?;
    let settings = Settings::new(1e-12);
    kernel.solve(&vector![0.4, -1.0], &settings)?;
    kernel.scene_mut().clear();
    kernel.scene_mut().push(&planar_floor(0.0, 8))?;
    assert_eq!(kernel.violation().outside_cone, 0.0);
    assert_eq!(kernel.worst_contact(), None);
    kernel.scene_mut().clear();
    kernel.scene_mut().push(&planar_floor(0.0, 7))?;
    assert!(close(kernel.violation().outside_cone, 0.4));
    assert_eq!(kernel.worst_contact(), Some(0));
    Ok(())
}

#[test]
fn what_pushes_without_friction_slips_where_it_has_tangents_and_moves() -> Result<(), Error> {
    fn mode<const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
        mut kernel: Kernel<f64, N, D, C, R, S>,
        slide: f64,
    ) -> Result<ContactMode, Error> {
        kernel.scene_mut().set_mass(&SMatrix::identity())?;
        let jacobian = SMatrix::identity();
        kernel.scene_mut().push(&Contact { jacobian, offset: SVector::zeros(), mu: 0.0, key: 0 })?;
        let push = SVector::from_fn(|k, _| if k == 0 { -1.0 } else { slide });
        let settings = Settings { still: 1e-3, ..Settings::new(1e-12) };
        Ok(kernel.solve(&push, &settings)?.contacts[0].mode)
    }
    for (slide, moves) in [(0.0, ContactMode::Stick), (1e-4, ContactMode::Stick), (1e-2, ContactMode::Slip)] {
        assert_eq!(mode(point::Kernel::new(), slide)?, moves);
        assert_eq!(mode(joints::Kernel::new(), slide)?, ContactMode::Stick);
    }
    Ok(())
}

#[test]
fn helpers_of_no_dimension_do_not_panic() {
    let (none, step) = (SVector::<f64, 0>::zeros(), 0.1);
    assert_eq!(free_impulse(&SMatrix::zeros(), &none, &none, step), none);
    let frame = SMatrix::<f64, 0, 2>::zeros();
    assert_eq!(moving_surface(&frame, &vector![1.0, 2.0]), none);
    let frame = SMatrix::<f64, 2, 0>::zeros();
    assert_eq!(moving_surface(&frame, &none), vector![0.0, 0.0]);
}

/// On a surface in the rows in which its cone is round: of 0.8 along and 0.4 across 10 N·s hold 8 along, and 4 across.
#[test]
fn a_violation_on_a_surface_is_measured_where_its_cone_is_round() -> Result<(), Error> {
    let jacobian = matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0];
    for push in [vector![20.0, 0.0, -10.0], vector![0.0, 20.0, -10.0]] {
        let mut kernel = Kernel::<f64, 3, 3, 3, 0, 1>::new();
        let scene = kernel.scene_mut();
        scene.set_mass(&Matrix3::identity())?;
        let contact = Contact { jacobian, offset: SVector::zeros(), mu: 0.0, key: 0 };
        let surface = Surface { friction: [0.8, 0.4], ..Surface::isotropic(0.0) };
        scene.push_on(&contact, &surface)?;
        kernel.solve(&push, &Settings::new(1e-12))?;
        assert!(kernel.violation().outside_cone < 1e-10);
        kernel.scene_mut().set_friction(0, 0.6)?; // and 0.3
        assert!(close(kernel.violation().outside_cone, 2.0));
    }
    Ok(())
}

fn is_the_largest_that_fits<const N: usize, const D: usize, const C: usize, const R: usize, P: Phases>() {
    let budget = Kernel::<f32, N, D, C, R, 0, P>::budget_within;
    let cycles = Kernel::<f32, N, D, C, R, 0, P>::worst_cycles;
    let slice = Kernel::<f32, N, D, C, R, 0, P>::worst_slice_cycles;
    let mut most = 0;
    for megahertz in [1, 16, 64, 168, 480] {
        let mut last = 0;
        for microseconds in (0..200).map(|k| k * k) {
            let found = budget(microseconds, megahertz, 0);
            assert!(found >= last, "more time, and less budget");
            assert!(found <= budget(microseconds, megahertz + 1, 0));
            last = found;
            let left = microseconds * megahertz;
            assert_eq!(budget(microseconds * 155, megahertz, 55), budget(microseconds * 100, megahertz, 0));
            assert!(found == 0 || cycles(found) <= left, "{found} takes longer");
            assert!(cycles(found + 1) > left, "more than {found} fits");
            assert!(slice(found) < cycles(found.max(1)));
        }
        most = most.max(last);
    }
    assert!(most > 100, "{most}");
    assert_eq!(budget(0, 168, 0), 0);
    assert!(budget(usize::MAX, usize::MAX, 0) > budget(1_000_000, 168, 0));
    assert_eq!(budget(1_000_000, 168, usize::MAX), 0);
    assert_eq!(budget(usize::MAX / 2, 1, usize::MAX), 0);
}

/// The quadruped of the guide.
const QUADRUPED: usize = Kernel::<f32, 18, 3, 4>::budget_within(2_000, 168, 0);

#[test]
fn a_budget_within_a_time_is_the_largest_whose_worst_case_fits() {
    is_the_largest_that_fits::<18, 3, 4, 0, AllPhases>();
    is_the_largest_that_fits::<18, 3, 4, 0, SweepsAndNewton>();
    is_the_largest_that_fits::<6, 3, 4, 2, SweepsOnly>();
    is_the_largest_that_fits::<2, 1, 1, 0, AllPhases>();
    is_the_largest_that_fits::<7, 3, 0, 14, AllPhases>();
    assert_eq!(QUADRUPED, 4);
}

fn fill<const C: usize, const R: usize, const S: usize>(
    scene: &mut Scene<f64, 4, 3, C, R, S>,
    mass: &Matrix4<f64>,
    rows: [&JointRow<f64, 4>; 2],
) -> Result<(), Error> {
    scene.set_mass(mass)?;
    for row in rows {
        scene.push_row(row)?;
    }
    Ok(())
}

/// A finger of two joints between a stop and a motor: with room for contacts or without, to the last bit.
#[test]
fn a_scene_without_room_for_contacts_solves_its_joint_rows() -> Result<(), Error> {
    let mut alone = linkage::Kernel::<f64>::new();
    let mut roomy = roomy_linkage::Kernel::<f64>::new();
    let mass = pad::mass(&matrix![0.4, 0.1; 0.1, 0.2]);
    let stop =
        JointRow { row: SVector::ith(0, 1.0), offset: 0.25, law: RowLaw::Limit, compliance: 0.0, key: 3 };
    let (lower, upper) = (-0.05, 0.05);
    let motor = JointRow {
        row: SVector::ith(1, 1.0),
        offset: -0.5,
        law: RowLaw::Box { lower, upper },
        key: 4,
        ..stop
    };
    fill(alone.scene_mut(), &mass, [&stop, &motor])?;
    fill(roomy.scene_mut(), &mass, [&stop, &motor])?;
    let contact = Contact { jacobian: SMatrix::zeros(), offset: SVector::zeros(), mu: 0.0, key: 0 };
    let (list, capacity) = (List::Contacts, 0);
    let full = Err(Error::ListFull { list, capacity });
    assert_eq!(alone.scene_mut().push(&contact), full);
    alone.scene_mut().clear_contacts(); // it is not to be missing
    for push in [vector![-0.3, 0.02], vector![-0.2, 0.01], vector![0.3, 0.3]].map(pad::vector) {
        let settings = Settings::new(1e-12);
        let one = alone.solve(&push, &settings)?;
        let other = roomy.solve(&push, &settings)?;
        assert_eq!((one.status, one.work), (Status::Solved, other.work));
        assert_eq!((one.velocity, one.error), (other.velocity, other.error));
        assert_eq!(one.rows[..], other.rows[..]);
        assert!(one.contacts.is_empty() && other.contacts.is_empty());
    }
    // By hand: the motor gives all it has, and the stop lets the first joint close at 0.25 rad/s:
    // M v = (-0.3 + λ, 0.02 + 0.05) with v_1 = -0.25.
    let solution = alone.solve(&pad::vector(vector![-0.3, 0.02]), &Settings::new(1e-12))?;
    let second = (0.07 + 0.1 * 0.25) / 0.2;
    assert!((solution.velocity - pad::vector(vector![-0.25, second])).norm() < 1e-12);
    let limit = 0.3 - 0.4 * 0.25 + 0.1 * second;
    assert!((solution.rows[0].impulse - limit).abs() < 1e-12);
    let modes = [RowMode::AtLimit, RowMode::AtUpper];
    assert_eq!([solution.rows[0].mode, solution.rows[1].mode], modes);
    assert_eq!(solution.rows[1].impulse, upper);
    Ok(())
}
