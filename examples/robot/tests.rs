//! What a world does and refuses, of files of this folder and of such with a fault.

use crate::{Base, Failure, STEP, Touch, World};
use nalgebra::Vector3;
use std::path::Path;

/// A world of a file of this folder, with changes to its text.
fn changed<const N: usize>(
    file: &str,
    base: Base,
    height: f64,
    changes: &[[&str; 2]],
) -> Result<World<N>, Failure> {
    let mut text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap();
    for [from, to] in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let path = tempfile::NamedTempFile::new()?.into_temp_path();
    std::fs::write(&path, text)?;
    let mut world = World::new(0.8, [60.0, 1.0]);
    world.load(&path, base, [0.0, 0.0, height])?;
    Ok(world)
}

#[test]
fn a_world_of_another_size_is_refused_with_the_right_one() {
    let mut world = World::<3>::new(0.8, [60.0, 1.0]);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("leg.urdf");
    world.load(&file, Base::Bolted, [0.0; 3]).unwrap();
    let refused = world.step().err().unwrap().to_string();
    assert!(refused.contains("World::<4>"), "{refused}");
}

#[test]
fn a_bottle_falls_and_spins_as_on_paper() {
    let mut world = World::<6>::new(0.8, [0.0, 0.0]);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("bottle.urdf");
    world.load(&file, Base::Free, [0.0, 0.0, 1.0]).unwrap();
    world.velocity[2] = 3.0; // about the vertical (rad/s)
    let ticks = world.run(0.1, |_, _| Ok(())).unwrap();
    let (steps, bottle) = (f64::from(u32::try_from(ticks.len()).unwrap()), &world.trees[0]);
    let fallen = crate::GRAVITY * STEP * STEP * steps * (steps + 1.0) / 2.0;
    assert!((bottle.place - Vector3::z() * (1.0 - fallen)).norm() < 1e-12);
    assert!((bottle.turn.scaled_axis() - Vector3::z() * 0.3).norm() < 1e-12);
}

#[test]
fn a_bolted_base_may_stand_on_the_ground() {
    let shape = r#"<collision><origin xyz="-0.3 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision><inertial>"#;
    let stand = r#"<link name="stand"><inertial>"#;
    let with_shape = format!(r#"<link name="stand">{shape}"#);
    let base = [stand, &*with_shape];
    let mut world = changed::<4>("leg.urdf", Base::Bolted, 0.36, &[base]).unwrap();
    // Its top and the floor, as near as rounding has them: 0.31 m is not 0.36 - 0.05.
    world.ground("column", [-0.35, -0.05, 0.0], [-0.25, 0.05, 0.36 - 0.05]);
    world.ground("floor", [-1.0, -1.0, -0.5], [1.0, 1.0, 0.0]);
    let ticks = world.run(0.5, |_, _| Ok(())).unwrap();
    assert!(ticks.iter().all(|tick| tick.error <= 1e-8));
    let names = |touch: &Touch| touch.pair.map(|body| world.bodies[body].name.clone());
    let mut touches = ticks.iter().flat_map(|tick| &tick.touches).map(names);
    assert!(touches.all(|pair| pair.contains(&"foot".into()) && pair.contains(&"floor".into())));
    assert!(!ticks[ticks.len() - 1].touches.is_empty());
}

#[test]
fn what_excludes_each_other_is_named() {
    let mut world = changed::<6>("bottle.urdf", Base::Free, 0.08, &[]).unwrap();
    world.ground("floor", [-1.0, -1.0, -0.5], [1.0, 1.0, 1e-3]);
    world.ground("ceiling", [-1.0, -1.0, 0.199], [1.0, 1.0, 0.5]);
    world.ground("wall", [0.03, -1.0, 1e-3], [0.5, 1.0, 0.199]);
    let refused = world.run(0.1, |_, _| Ok(())).err().unwrap().to_string();
    assert!(refused.contains("at 0.000 s: infeasible"), "{refused}");
    let named = "these exclude each other: bottle and floor, bottle and ceiling";
    assert!(refused.ends_with(named), "{refused}");
}

#[test]
fn a_stop_that_excludes_a_contact_is_named() {
    // The leg, its joints locked, is 0.1 m below the rail's lower stop and a millimetre deep in what is above its foot.
    let rail = [r#"lower="-0.3""#, r#"lower="0""#];
    let mut world = changed::<4>("leg.urdf", Base::Bolted, 0.36, &[rail]).unwrap();
    world.ground("ceiling", [-1.0, -1.0, -0.061], [1.0, 1.0, 0.5]);
    world.joint("rail").unwrap().angle = -0.1;
    for name in ["hip", "knee", "ankle"] {
        world.joint(name).unwrap().range = [0.0, 0.0];
    }
    let refused = world.run(0.1, |_, _| Ok(())).err().unwrap().to_string();
    assert!(refused.contains("foot and ceiling"), "{refused}");
    assert!(refused.contains("lower stop of rail"), "{refused}");
}

#[test]
fn a_joint_without_limits_or_motor_is_no_silent_one() {
    let load = |change| changed::<4>("leg.urdf", Base::Bolted, 0.36, &[change]);
    let limit = r#"<limit lower="0" upper="2.4" effort="10" velocity="25"/>"#;
    let refused = load([limit, ""]).err().unwrap().to_string();
    assert!(refused.contains("joint knee cannot move: its <limit> is missing"), "{refused}");
    let negative = limit.replace("10", "-10");
    let refused = load([limit, &negative]).err().unwrap().to_string();
    assert!(refused.contains("joint knee has an effort of -10"), "{refused}");

    let without_effort = limit.replace(r#"effort="10""#, "");
    let mut world = load([limit, &without_effort]).unwrap();
    assert_eq!(world.trees[0].passive(), ["rail", "knee"]);
    let refused = world.aim("knee", 1.0).unwrap_err().to_string();
    assert!(refused.contains("joint knee has no motor"), "{refused}");
    world.aim("hip", 1.0).unwrap();

    // A wheel has no limits and needs none.
    let wheel = [r#"<joint name="knee" type="revolute">"#, r#"<joint name="knee" type="continuous">"#];
    load(wheel).unwrap().run(0.01, |_, _| Ok(())).unwrap();
}

#[test]
fn gains_of_zero_are_refused_by_the_name_of_the_joint() {
    let mut world = changed::<4>("leg.urdf", Base::Bolted, 0.36, &[]).unwrap();
    world.gains = [0.0, 0.0];
    let refused = world.step().err().unwrap().to_string();
    assert!(refused.contains("joint hip: gains of a motor are both 0"), "{refused}");
}
