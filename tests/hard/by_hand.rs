//! Small scenes whose data can be read: each at the edge of something.

use crate::support::check::scene;
use testbed::scene_file::SceneFile;

const MIXED: [f64; 4] = [0.0, 1e-6, 5.0, 10.0];

/// A point on a slope with `tan = mu (1 + off)`, dofs along and across the slope.
pub(super) fn point_on_a_slope() -> impl Iterator<Item = SceneFile> {
    [0.0, 1e-6, -1e-6, 1e-3, -1e-3].into_iter().flat_map(|off| {
        [1e-3, 0.5, 5.0].map(|mu| {
            let floor: [&[f64]; 2] = [&[0.0, 1.0], &[1.0, 0.0]];
            let load = [-0.1 * mu * (1.0 + off), 0.1];
            let name = format!("mu {mu}, off by {off:e}");
            scene(&name, &[2.0; 2], &load, &[(floor, [0.0; 2], mu)])
        })
    })
}

/// A point in a corner, pressed against the wall and the floor: dofs y, x, z.
pub(super) fn point_in_a_corner() -> impl Iterator<Item = SceneFile> {
    MIXED.into_iter().flat_map(|floor_mu| {
        MIXED.map(|wall_mu| {
            let (y, x, z): (&[f64], &[f64], &[f64]) = (&[1.0, 0.0, 0.0], &[0.0, 1.0, 0.0], &[0.0, 0.0, 1.0]);
            let contacts = [([z, x, y], [0.0; 3], floor_mu), ([x, y, z], [0.0; 3], wall_mu)];
            let name = format!("floor {floor_mu}, wall {wall_mu}");
            scene(&name, &[1.0; 3], &[-0.3, 0.2, 0.1], &contacts)
        })
    })
}

/// A point on a floor that is there three times, turned by an angle each time.
pub(super) fn same_floor_three_times() -> impl Iterator<Item = SceneFile> {
    [0.0, 1e-12, 1e-9, 1e-6, 1e-3].into_iter().map(|angle| {
        let floor = [-1.0, 0.0, 1.0].map(|side| {
            let (sin, cos) = libm::sincos(side * angle);
            ([-sin, cos], [cos, sin])
        });
        let contacts = floor.each_ref().map(|(normal, tangent)| ([&normal[..], &tangent[..]], [0.0; 2], 0.5));
        scene(&format!("{angle:e}"), &[2.0, 2.0], &[-0.05, 0.2], &contacts)
    })
}

/// Dofs x, z below, x, z above: a light point on the floor, a heavy one on it, pushed sideways.
pub(super) fn heavy_on_light() -> impl Iterator<Item = SceneFile> {
    [1.0, 1e2, 1e4, 1e6].into_iter().flat_map(|ratio| {
        [0.0, 0.03, 0.06].map(|push| {
            let weight = 0.0981;
            scene(
                &format!("1:{ratio:e}, push {push}"),
                &[1.0, 1.0, ratio, ratio],
                &[0.0, weight, -push * ratio, weight * ratio],
                &[
                    ([&[0.0, 1.0, 0.0, 0.0], &[1.0, 0.0, 0.0, 0.0]], [0.0; 2], 0.5),
                    ([&[0.0, -1.0, 0.0, 1.0], &[-1.0, 0.0, 1.0, 0.0]], [0.0; 2], 0.5),
                ],
            )
        })
    })
}

/// A rod of 1 kg and 2 m on one end, dofs x, z and angle; the end slides forward.
pub(super) fn sliding_rod() -> impl Iterator<Item = SceneFile> {
    [0.5, 4.0 / 3.0, 2.0, 6.0].into_iter().flat_map(|mu| {
        [0.3, 0.8, 1.1, 1.4].map(|angle| {
            let (rise, run) = libm::sincos(angle);
            let end: [&[f64]; 2] = [&[0.0, 1.0, -run], &[1.0, 0.0, -rise]];
            let name = format!("mu {mu}, angle {angle}");
            let inertia = 1.0 / 3.0;
            scene(&name, &[1.0, 1.0, inertia], &[1.0, 0.0981, 0.0], &[(end, [0.0; 2], mu)])
        })
    })
}

/// A point in a groove, dofs x and z; the walls rise by an angle from the vertical.
pub(super) fn point_in_a_groove() -> impl Iterator<Item = SceneFile> {
    [1e-3, 0.1, 0.5, 1.2].into_iter().flat_map(|angle| {
        [0.0, 0.1, 1.0, 10.0].map(|mu| {
            let (sin, cos) = libm::sincos(angle);
            let left: [&[f64]; 2] = [&[cos, sin], &[-sin, cos]];
            let right: [&[f64]; 2] = [&[-cos, sin], &[sin, cos]];
            let contacts = [(left, [0.0; 2], mu), (right, [0.0; 2], mu)];
            let name = format!("angle {angle}, mu {mu}");
            scene(&name, &[2.0; 2], &[0.03, 0.2], &contacts)
        })
    })
}

/// A point over a floor, dofs x and z: `f`, then `w`.
pub(super) fn point_over_a_floor() -> impl Iterator<Item = SceneFile> {
    let floor: [&[f64]; 2] = [&[0.0, 1.0], &[1.0, 0.0]];
    [
        ("nothing", [0.0, 0.0], [0.0, 0.0]),
        ("belt", [0.0, 0.2], [0.0, 1.0]),
        ("fast belt", [0.0, 0.2], [0.0, 1e6]),
        ("belt, no load", [0.0, 0.0], [0.0, 1.0]),
        ("impact", [-1.0, 4.0], [-1.5, 0.0]),
        ("gap", [0.1, 0.2], [3.0, 0.0]),
        ("touching at the end", [0.0, 0.25], [0.125, 0.0]),
        ("rising floor, no load", [0.0, 0.0], [-1.0, 0.5]),
    ]
    .into_iter()
    .map(move |(name, f, w)| scene(name, &[2.0; 2], &f, &[(floor, w, 0.5)]))
}

/// A point that falls on a slippery slope, in units of mass and velocity far apart.
pub(super) fn point_in_other_units() -> impl Iterator<Item = SceneFile> {
    let floor: [&[f64]; 2] = [&[0.0, 1.0], &[1.0, 0.0]];
    [(1e-12, 1.0), (1e12, 1.0), (1.0, 1e-12), (1.0, 1e12), (1e12, 1e-12), (1e-12, 1e12)].into_iter().map(
        move |(mass, velocity)| {
            let (load, w) = (mass * velocity, [0.1 * velocity, 0.2 * velocity]);
            let name = format!("mass {mass:e}, velocity {velocity:e}");
            scene(&name, &[mass; 2], &[-load, load], &[(floor, w, 0.5)])
        },
    )
}

/// A point between two walls, the right one moving left: dofs x and z, `room` between the speeds.
fn between_walls(room: f64) -> SceneFile {
    let left: [&[f64]; 2] = [&[1.0, 0.0], &[0.0, 1.0]];
    let right: [&[f64]; 2] = [&[-1.0, 0.0], &[0.0, 1.0]];
    let contacts = [(left, [1.0 + room, 0.0], 0.5), (right, [-1.0, 0.0], 0.5)];
    scene(&format!("room {room:e}"), &[2.0; 2], &[0.1, 0.2], &contacts)
}

/// Walls that leave no room.
pub(super) fn closing_walls() -> impl Iterator<Item = SceneFile> {
    [-1.0, -1e-1, -1e-3].map(between_walls).into_iter()
}

/// Walls that leave a little.
pub(super) fn narrow_walls() -> impl Iterator<Item = SceneFile> {
    [0.0, 1e-6, 1e-3].map(between_walls).into_iter()
}
