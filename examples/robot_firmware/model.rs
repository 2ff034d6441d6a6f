//! The robot: masses, lengths and inertias of `examples/robot/quadruped.urdf`, as constants.

/// Standard gravity (m/s²).
pub(crate) const GRAVITY: f32 = 9.80665;
/// Radius of a foot (m).
pub(crate) const RADIUS: f32 = 0.018;

/// Rigid body of a link.
pub(crate) struct Body {
    /// Mass (kg).
    pub(crate) mass: f32,
    /// Centre of mass (m), in the link.
    pub(crate) centre: [f32; 3],
    /// Moments of inertia (kg m²) about axes through the centre of mass, which are parallel to those of the link. Products are zero.
    pub(crate) inertia: [f32; 3],
}

/// Body of the torso.
pub(crate) const TORSO: Body = Body { mass: 3.6, centre: [0.0; 3], inertia: [0.0107, 0.0419, 0.0466] };

/// Axis of a hinge: x points ahead, y to the left.
pub(crate) enum Axis {
    X,
    Y,
}

/// Link of the front left leg.
pub(crate) struct Link {
    /// Place of its hinge (m), in the link before it.
    pub(crate) hinge: [f32; 3],
    /// Axis about which it turns.
    pub(crate) axis: Axis,
    pub(crate) body: Body,
}

/// Moment of inertia (kg m²) of shank and foot about x and y: 0.12 kg are 16 mm above their centre of mass, 0.03 kg 64 mm below.
const ACROSS: f32 = 2.59e-4 + 3.89e-6 + 0.12 * 0.016 * 0.016 + 0.03 * 0.064 * 0.064;
/// Body of a calf: shank and foot turn as one.
const CALF: Body =
    Body { mass: 0.12 + 0.03, centre: [0.0, 0.0, -0.096], inertia: [ACROSS, ACROSS, 6e-6 + 3.89e-6] };

/// Links of the front left leg: hip, thigh and calf.
pub(crate) const LINKS: [Link; 3] = [
    Link {
        hinge: [0.17, 0.07, 0.0],
        axis: Axis::X,
        body: Body { mass: 0.25, centre: [0.0, 0.03, 0.0], inertia: [1.31e-4, 1.31e-4, 1.12e-4] },
    },
    Link {
        hinge: [0.0, 0.05, 0.0],
        axis: Axis::Y,
        body: Body { mass: 0.3, centre: [0.0, 0.0, -0.06], inertia: [6.7e-4, 6.7e-4, 6e-5] },
    },
    Link { hinge: [0.0, 0.0, -0.16], axis: Axis::Y, body: CALF },
];
/// Place of the foot (m), in the calf.
pub(crate) const FOOT: [f32; 3] = [0.0, 0.0, -0.16];

/// Legs by the signs of their x and y: front left, front right, rear left, rear right.
pub(crate) const LEGS: [[f32; 2]; 4] = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
