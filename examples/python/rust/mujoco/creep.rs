//! What sticks keeps its place: how far contacts that stuck have moved along their tangents nevertheless, as a step goes along a
//! straight line, and as what moves from outside was foreseen by its last velocity.

use super::ffi::Data;
use super::touch::{Around, Touch, dot, largest};
use super::velocity::Motion;
use nalgebra::{Matrix3, Vector3};

/// `Mode::Stick`.
const STICK: i8 = 1;
/// What is left as it is, over the model's length.
pub(super) const LEFT: f64 = 1e-9;

/// What counts was closed as the step began, up to this gap over the model's length.
const CLOSED: f64 = 1e-4;

/// A motion from one pose of a geom to another.
struct Path {
    from: Vector3<f64>,
    to: Vector3<f64>,
    turn: Matrix3<f64>,
}

impl Path {
    fn end(&self, place: Vector3<f64>) -> Vector3<f64> {
        self.to + self.turn * (place - self.from)
    }

    fn start(&self, place: Vector3<f64>) -> Vector3<f64> {
        self.from + self.turn.transpose() * (place - self.to)
    }
}

/// How a contact that is pressed has moved along its tangents beyond its velocity (m).
#[derive(Clone, Copy, Default)]
pub(super) struct Creep {
    pub(super) along: [f64; 2],
    /// Is it to be taken back?
    pub(super) counts: bool,
}

/// Does a contact stick, and bear something?
pub(super) fn holds(motion: &Motion, place: usize) -> bool {
    motion.modes[place] == STICK && motion.impulses[place][0] > 0.0
}

/// The displacements along tangents beyond those that velocities foresee.
pub(super) fn list(around: &Around<'_>, touches: &[Touch], motion: &Motion, scratch: &mut Data) -> Vec<Creep> {
    let Around { model, data, facts, follower, .. } = around;
    let (h, length) = (model.step(), model.size());
    let mut creeps = vec![Creep::default(); touches.len()];
    let is_one = |place: usize| touches[place].mu() > 0.0 && motion.impulses[place][0] > 0.0;
    let sticks = |place: usize| touches[place].mu() > 0.0 && holds(motion, place);
    let turns = motion.velocity.iter().zip(&facts.turns).filter(|&(_, &turns)| turns);
    let fastest = turns.fold(0.0_f64, |most, (v, _)| most.max(v.abs()));
    let is_straight = (h * fastest).powi(2) < LEFT;
    if !(0..touches.len()).any(sticks) || is_straight && !follower.moves() {
        return creeps;
    }
    scratch.copy_pose(data);
    model.integrate(scratch.qpos_mut(), &motion.velocity, h);
    scratch.kinematics(model);
    let nv = model.sizes.velocities;
    for place in (0..touches.len()).filter(|&place| is_one(place)) {
        let touch = &touches[place];
        let contact = data.contact(touch.index);
        let (geoms, frame) = (contact.geoms(), contact.frame().map(Vector3::from));
        // Where the point was before what is moved from outside has moved.
        let mut point = touch.place;
        let mut paths = geoms.map(|geom| {
            let matrix = |data: &Data| Matrix3::from_row_slice(&data.geom_xmat()[geom]);
            Path {
                from: data.geom_xpos()[geom].into(),
                to: scratch.geom_xpos()[geom].into(),
                turn: matrix(scratch) * matrix(data).transpose(),
            }
        });
        let mut is_led = false;
        let is_put = follower.is_first() && !touch.is_moved();
        let mocap = |body: usize| {
            let mocap = facts.mocap(body).filter(|_| !is_put)?;
            let [along, turn] = follower.moved.mocap[mocap];
            Some([along, turn, data.mocap_pos()[mocap].into()])
        };
        for (path, geom) in paths.iter_mut().zip(geoms) {
            let body = model.geom_bodyid()[geom].unsigned_abs() as usize;
            if let Some([along, turn, centre]) = mocap(body) {
                let turn = nalgebra::Rotation3::from_scaled_axis(turn).into_inner();
                let back = |place: Vector3<f64>| centre - along + turn.transpose() * (place - centre);
                *path = Path { from: back(path.to), to: path.to, turn };
                (point, is_led) = (back(touch.place), true);
            }
        }
        let relative = paths[1].turn * paths[0].turn.transpose();
        let rolled = turned(&relative);
        let apart = |point: Vector3<f64>| {
            if touch.is_new {
                paths[0].start(point) - paths[1].start(point)
            } else {
                paths[1].end(point) - paths[0].end(point)
            }
        };
        if touch.is_new {
            point = touch.place;
        }
        let cornered = geoms.map(|geom| facts.has_corners(geom));
        let size = |i: usize| match model.geom_rbound()[geoms[i]] {
            0.0 => f64::INFINITY,
            radius => radius,
        };
        // Directions come along with what is flat, or larger.
        let flat = match cornered {
            [true, false] => 0,
            [false, true] => 1,
            _ => usize::from(size(1) > size(0)),
        };
        let turn = if touch.is_new || is_led { Matrix3::identity() } else { paths[flat].turn };
        let normal = turn * frame[0];
        // What is round may roll, which is no creep: what surely is none of rolling counts.
        let doubt = if cornered == [true; 2] {
            0.0
        } else {
            let tilted = rolled - normal * normal.dot(&rolled);
            rolled.norm() * tilted.norm() * size(0).min(size(1))
        };
        let crept = apart(point);
        let written = &follower.moved.joints;
        for i in 0..2 {
            let axis = turn * frame[1 + i];
            let row = &touch.rows[(1 + i) * nv..][..nv];
            let foreseen = dot(row, &motion.velocity) + touch.outside[1 + i];
            creeps[place].along[i] = axis.dot(&crept) + dot(row, written) - h * foreseen;
        }
        let own = &mut creeps[place].along;
        let share = (1.0 - doubt / own[0].hypot(own[1]).max(f64::MIN_POSITIVE)).max(0.0);
        own.iter_mut().for_each(|own| *own *= share);
        let is_closed = !touch.is_new && touch.gap.abs() < CLOSED * length;
        creeps[place].counts = is_closed && sticks(place) && largest(&creeps[place].along) > LEFT * length;
    }
    creeps
}

/// About what, and how far, a rotation turns (rad).
fn turned(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let double = Vector3::new(
        rotation[(2, 1)] - rotation[(1, 2)],
        rotation[(0, 2)] - rotation[(2, 0)],
        rotation[(1, 0)] - rotation[(0, 1)],
    );
    let (sine, cosine) = (0.5 * double.norm(), 0.5 * (rotation.trace() - 1.0));
    if sine > 0.0 { double * (0.5 * sine.atan2(cosine) / sine) } else { Vector3::zeros() }
}
