//! What is read of a URDF file: links without mass, meshes, joints that mimic others; and what is refused.

use crate::collide::{collide, pose};
use crate::{Base, Body, Failure, Tree, World};
use dynibo::{BaseState, FloatingRobot, Frame, Twist};
use nalgebra::{UnitQuaternion, Vector3};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::shape::SharedShape;
use std::path::Path;
use tempfile::TempDir;

/// Inertia of a box of 2 kg, 0.25 m wide and deep and 0.5 m high.
const INERTIAL: &str = r#"<inertial><mass value="2"/>
    <inertia ixx="0.052" iyy="0.052" izz="0.021" ixy="0" ixz="0" iyz="0"/></inertial>"#;
const BOX: &str = r#"<box size="0.25 0.25 0.5"/>"#;

/// A folder with a robot of these elements in `robots/robot.urdf`.
fn folder(elements: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("robots")).unwrap();
    let text = format!("<robot name=\"robot\">{elements}</robot>");
    std::fs::write(folder.path().join("robots/robot.urdf"), text).unwrap();
    folder
}

/// The world of the robot of a folder, above a floor.
fn world<const N: usize>(folder: &Path, base: Base, height: f64) -> Result<World<N>, Failure> {
    let mut world = World::new(0.8, [1e3, 30.0]);
    world.ground("floor", [-4.0, -4.0, -1.0], [4.0, 4.0, 0.0]);
    world.load(&folder.join("robots/robot.urdf"), base, [0.0, 0.0, height])?;
    Ok(world)
}

/// Why the robot of these elements, of at most `N` velocities, is not loaded or stepped.
fn refused<const N: usize>(elements: &str, base: Base) -> String {
    let stepped = world::<N>(folder(elements).path(), base, 1.0).and_then(|mut world| world.step());
    stepped.err().unwrap().to_string()
}

/// A box that is fixed, beside it and turned, to a root without mass.
fn beside(geometry: &str) -> String {
    format!(
        r#"<link name="root"/><link name="box">{INERTIAL}<collision><geometry>{geometry}</geometry></collision></link>
        <joint name="glue" type="fixed"><parent link="root"/><child link="box"/><origin xyz="1 0 0" rpy="0 0 0.5"/></joint>"#
    )
}

/// An STL file of a block between two corners, as text.
fn block(from: [f32; 3], to: [f32; 3]) -> Vec<[[f32; 3]; 3]> {
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { from[axis] } else { to[axis] });
    let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let halves = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    halves.map(|triangle| triangle.map(corner)).collect()
}

/// A binary STL file of triangles, whose header begins as that of a text does.
fn binary(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut file = format!("{:80}", "solid block\n").into_bytes();
    file.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
    for triangle in triangles {
        file.extend([0; 12]); // the normal, which nobody reads
        file.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
        file.extend([0; 2]);
    }
    file
}

/// The same as text.
fn text(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let vertex = |[x, y, z]: &[f32; 3]| format!("vertex {x} {y} {z}\n");
    let facet = |triangle: &[[f32; 3]; 3]| {
        let vertices: String = triangle.iter().map(vertex).collect();
        format!("facet normal 0 0 1\nouter loop\n{vertices}endloop\nendfacet\n")
    };
    let facets: String = triangles.iter().map(facet).collect();
    format!("solid block\n{facets}endsolid block\n").into_bytes()
}

#[test]
fn a_mesh_of_a_box_stands_as_the_box_does() {
    let stand = |geometry: &str, mesh: &[u8]| {
        let folder = folder(&beside(geometry));
        std::fs::create_dir_all(folder.path().join("things/meshes")).unwrap();
        std::fs::write(folder.path().join("things/meshes/block.stl"), mesh).unwrap();
        let mut world = world::<6>(folder.path(), Base::Free, 0.0).unwrap();
        world.trees[0].place.z = 1e-3 - world.lowest().unwrap();
        let ticks = world.run(0.2, |_, _| Ok(())).unwrap();
        assert!(ticks.iter().all(|tick| tick.error <= 1e-8));
        let touches = &ticks[ticks.len() - 1].touches;
        let force: f64 = touches.iter().map(|touch| touch.force.z).sum();
        assert!((force - 2.0 * crate::GRAVITY).abs() < 1e-6, "{force} N");
        (touches.len(), world.trees[0].place, world.trees[0].turn)
    };
    let (count, place, turn) = stand(BOX, b"");
    assert_eq!(count, 4);
    assert!((place.z - 0.25).abs() < 1e-9 && turn.angle() < 1e-9, "{place} {turn}");
    let triangles = block([-1.0, -1.0, -2.0], [1.0, 1.0, 2.0]); // in eighths of a metre
    for file in [text(&triangles), binary(&triangles)] {
        for name in ["package://things/meshes/block.stl", "../things/meshes/block.stl"] {
            let mesh = format!(r#"<mesh filename="{name}" scale="0.125 0.125 0.125"/>"#);
            let (same, there, turned) = stand(&mesh, &file);
            assert_eq!(same, count);
            assert!((there - place).norm() < 1e-9 && turned.angle_to(&turn) < 1e-9, "{there} {turned}");
        }
    }
}

#[test]
fn what_is_fixed_to_each_other_moves_as_dynibo_has_it() {
    let more = format!(
        r#"<link name="top">{INERTIAL}</link><link name="arm">{INERTIAL}</link>
        <joint name="on" type="fixed"><parent link="box"/><child link="top"/><origin xyz="0 0.1 0.5" rpy="1 0.2 0.5"/></joint>
        <joint name="hinge" type="continuous"><parent link="top"/><child link="arm"/><origin xyz="0.3 0 0"/></joint>"#
    );
    let elements =
        beside(BOX).replace(r#"<link name="root"/>"#, &format!(r#"<link name="root">{INERTIAL}</link>"#));
    let folder = folder(&(elements + &more));
    let mut world = world::<7>(folder.path(), Base::Free, 0.0).unwrap();
    let mut model = FloatingRobot::from_urdf(folder.path().join("robots/robot.urdf")).unwrap();
    let base = BaseState::new(Frame::identity(), Twist::zeros(), Twist::zeros()).unwrap();
    let mut mass = [0.0; 49];
    model.mass_matrix(&base, &[0.0], &mut mass).unwrap();
    let ours = world.dynamics().unwrap().mass;
    let apart = ours.iter().zip(mass).map(|(ours, theirs)| (ours - theirs).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-13, "{ours}");
}

#[test]
fn a_root_without_mass_is_carried_by_what_is_fixed_to_it_or_bolted_down() {
    let hinge = beside(BOX).replace("fixed", "continuous");
    let refused = refused::<7>(&hinge, Base::Free);
    assert!(refused.contains("moves no inertia"), "{refused}");
    world::<1>(folder(&hinge).path(), Base::Bolted, 1.0).unwrap().step().unwrap();
    // In ROS a link of this name is the world.
    world::<1>(folder(&hinge.replace("root", "world")).path(), Base::Free, 1.0).unwrap().step().unwrap();
}

/// A slide, and another one that mimics a joint.
fn slides(mimic: &str) -> String {
    let slide = |name: &str, more: &str| {
        format!(
            r#"<link name="{name}">{INERTIAL}</link><joint name="to_{name}" type="prismatic"><parent link="root"/>
            <child link="{name}"/><limit lower="0" upper="0.2" effort="1000" velocity="1"/>{more}</joint>"#
        )
    };
    [r#"<link name="root"/>"#, &slide("one", ""), &slide("other", mimic)].concat()
}

#[test]
fn a_joint_mimics_another_with_a_ratio_and_an_offset_beyond_its_own_stops() {
    let folder = folder(&slides(r#"<mimic joint="to_one" multiplier="-2" offset="0.05"/>"#));
    let mut world = world::<2>(folder.path(), Base::Bolted, 1.0).unwrap();
    assert!((world.joint("to_other").unwrap().angle - 0.05).abs() < 1e-15);
    world.run(1.0, |world, time| world.aim("to_one", 0.1 * time)).unwrap();
    let [one, other] = ["to_one", "to_other"].map(|name| world.joint(name).unwrap().angle);
    assert!((one - 0.1).abs() < 1e-3, "{one}");
    assert!((other - (0.05 - 2.0 * one)).abs() < 1e-12, "{other}");
    let refused = world.aim("to_other", 0.1).unwrap_err().to_string();
    assert!(refused.contains("joint to_other has no motor: it mimics another joint"), "{refused}");
}

#[test]
fn what_cannot_be_loaded_is_named() {
    let thing = |geometry: &str| refused::<6>(&beside(geometry), Base::Free);
    let lost = thing(r#"<mesh filename="package://things/block.stl"/>"#);
    assert!(
        lost.ends_with("link box: mesh package://things/block.stl: no folder around the file holds it"),
        "{lost}"
    );
    let folder = folder(&beside(r#"<mesh filename="point.stl"/>"#));
    std::fs::write(folder.path().join("robots/point.stl"), binary(&block([1.0; 3], [1.0; 3]))).unwrap();
    let point = Tree::load(&folder.path().join("robots/robot.urdf"), Base::Free).unwrap_err().to_string();
    assert!(point.ends_with("link box: mesh point.stl: its points have no convex hull"), "{point}");

    for (of, mimic) in [("nobody", "nobody"), ("itself", "to_other")] {
        let alone = refused::<6>(&slides(&format!(r#"<mimic joint="{mimic}"/>"#)), Base::Bolted);
        assert!(
            alone.contains(&format!("joint to_other mimics {mimic}, which is no other")),
            "{of}: {alone}"
        );
    }
    let light = refused::<6>(&beside(BOX).replace(r#"value="2""#, r#"value="-2""#), Base::Free);
    assert!(light.contains("link box has a mass of -2"), "{light}");
    let bent = refused::<6>(&beside(BOX).replace(r#"ixx="0.052""#, r#"ixx="-0.052""#), Base::Free);
    assert!(bent.contains("link root inertia must be positive"), "{bent}");
    let empty = refused::<6>("", Base::Free);
    assert!(empty.ends_with("robot.urdf: it has no links"), "{empty}");
    // What is only to be seen is not read.
    let seen = beside(BOX).replace("<collision>", "<visual><nonsense/></visual><collision>");
    world::<6>(self::folder(&seen).path(), Base::Free, 1.0).unwrap().step().unwrap();
}

#[test]
fn a_hull_that_just_touches_a_block_is_pushed_out_of_it() {
    let corners: Vec<_> = block([-0.5; 3], [0.5; 3]).into_iter().flatten().collect();
    let corners: Vec<_> = corners.iter().map(|corner| Vector::from(corner.map(f64::from))).collect();
    let ground = Body::ground("floor", [-100.0, -100.0, -1.0].into(), [100.0, 100.0, 0.0].into());
    let (shape, local) = (SharedShape::convex_hull(&corners).unwrap(), Pose::identity());
    let bodies = [ground.clone(), Body { name: "hull".into(), tree: 0, link: 0, local, shape }];
    for step in 0..500 {
        let (turn, depth) = (0.01 * f64::from(step), 1e-16 * f64::from(step % 21 - 10)); // of rounding
        let turn = UnitQuaternion::from_euler_angles(depth, -depth, turn);
        let poses = [ground.local, pose(Vector3::z() * (0.5 + depth), &turn)];
        let points = collide(&bodies, &poses, |_| true).unwrap();
        assert_eq!(points.len(), 4);
        assert!(points.iter().all(|point| point.normal.z > 0.999 && point.gap.abs() < 1e-12), "{step}");
    }
}
