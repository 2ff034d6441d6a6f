//! What sticks keeps its place: how far contacts that stick have moved along their tangents nevertheless, as a step goes along a straight
//! line, and as what moves from outside was foreseen by its last velocity.

use super::facts::body_of;
use super::ffi::Data;
use super::islands::Island;
use super::touch::{Around, Live, Touch, dot, largest, pose};
use super::velocity::Motion;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// `Mode::Stick`, `Mode::Slip`.
pub(super) const STICK: i8 = 1;
pub(super) const SLIP: i8 = 2;
/// What is left as it is, over the model's length; it adds up from step to step.
const LEFT: f64 = 1e-7;
/// Square of an angle (rad) up to which a path is straight.
const STRAIGHT: f64 = 1e-9;
/// What counts touched as the step began: its gap or overlap was at most this, over the model's length.
const TOUCHED: f64 = 1e-4;

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

/// How contacts have crept at the end of a step, and whether `scratch` is at the pose to which its velocity leads.
pub(super) struct Creeps {
    pub(super) of_touches: Vec<Creep>,
    pub(super) is_posed: bool,
}

/// The displacements along tangents beyond those that velocities foresee, and what is left of the steps before.
pub(super) fn list(
    around: &Around<'_>,
    (touches, live): (&[Touch], &[Live]),
    motion: &Motion,
    scratch: &mut Data,
) -> Creeps {
    let Around { model, data, facts, follower, .. } = around;
    let (h, length) = (model.step(), model.size());
    let bears = |place: usize| touches[place].mu() > 0.0 && motion.impulses[place][0] > 0.0;
    let sticks = |place: usize| bears(place) && holds(motion, place);
    let turns = motion.velocity.iter().zip(&facts.turns).filter(|&(_, &turns)| turns);
    let fastest = turns.fold(0.0_f64, |most, (v, _)| most.max(v.abs()));
    let is_straight = (h * fastest).powi(2) < STRAIGHT && !follower.moves();
    let mut creeps = vec![Creep::default(); touches.len()];
    let is_posed = !is_straight && (0..touches.len()).any(sticks);
    if is_posed {
        scratch.copy_pose(data);
        model.integrate(scratch.qpos_mut(), &motion.velocity, h);
        scratch.kinematics(model);
    }
    for (place, (creep, touch)) in creeps.iter_mut().zip(touches).enumerate() {
        if !bears(place) {
            continue;
        }
        if is_posed {
            creep.along = of_step(around, touch, motion, scratch);
        }
        let frame = data.contact(touch.index).frame();
        if let Some(live) = live.iter().find(|live| live.key == touch.key) {
            for (along, axis) in creep.along.iter_mut().zip(&frame[1..]) {
                *along += Vector3::from(*axis).dot(&live.crept);
            }
        }
        // What is soft overlaps on purpose.
        let apart = if touch.soft.is_some() { touch.gap } else { touch.gap.abs() };
        let touched = !touch.is_new && apart < TOUCHED * length;
        creep.counts = touched && sticks(place) && largest(&creep.along) > LEFT * length;
    }
    Creeps { of_touches: creeps, is_posed }
}

impl Creeps {
    /// What contacts of an island have crept has been taken back.
    pub(super) fn taken_back(&mut self, island: &Island) {
        island.touches.iter().for_each(|&place| self.of_touches[place].along = [0.0; 2]);
    }

    /// What is left of a contact's creep (m).
    pub(super) fn left(&self, data: &Data, touch: &Touch, motion: &Motion, place: usize) -> Vector3<f64> {
        if !holds(motion, place) {
            return Vector3::zeros();
        }
        let axes = data.contact(touch.index).frame();
        let along = self.of_touches[place].along.iter().zip(&axes[1..]);
        along.map(|(along, axis)| Vector3::from(*axis) * *along).sum()
    }
}

/// The displacement of a contact along its tangents in a step, beyond the one that its velocity foresees (m).
fn of_step(around: &Around<'_>, touch: &Touch, motion: &Motion, scratch: &Data) -> [f64; 2] {
    let Around { model, data, facts, follower, .. } = around;
    let (h, nv, contact) = (model.step(), model.sizes.velocities, data.contact(touch.index));
    let (geoms, frame) = (contact.geoms(), contact.frame().map(Vector3::from));
    // Where the point was before what is moved from outside has moved.
    let mut point = touch.place;
    let mut paths = geoms.map(|geom| {
        let ((from_frame, from), (to_frame, to)) = (pose(data, geom), pose(scratch, geom));
        Path { from, to, turn: to_frame * from_frame.transpose() }
    });
    let mut is_led = false;
    // What is put somewhere before the first step has not moved there.
    let is_put = follower.is_first() && !touch.is_moved();
    for (path, geom) in paths.iter_mut().zip(geoms) {
        if let Some(mocap) = facts.mocap(body_of(model, geom)).filter(|_| !is_put) {
            let ([along, turn], centre) =
                (follower.moved.mocap[mocap], Vector3::from(data.mocap_pos()[mocap]));
            let turn = Rotation3::from_scaled_axis(turn).into_inner();
            let back = |place: Vector3<f64>| centre - along + turn.transpose() * (place - centre);
            *path = Path { from: back(path.to), to: path.to, turn };
            (point, is_led) = (back(touch.place), true);
        }
    }
    let apart = if touch.is_new {
        paths[0].start(touch.place) - paths[1].start(touch.place)
    } else {
        paths[1].end(point) - paths[0].end(point)
    };
    let cornered = geoms.map(|geom| facts.has_corners(geom));
    let size = geoms.map(|geom| match model.geom_rbound()[geom] {
        0.0 => f64::INFINITY,
        radius => radius,
    });
    // Directions come along with what is flat, or larger.
    let flat = match cornered {
        [true, false] => 0,
        [false, true] => 1,
        _ => usize::from(size[1] > size[0]),
    };
    let turn = if touch.is_new || is_led { Matrix3::identity() } else { paths[flat].turn };
    // Along the face as it is then; by axes as they are now, by which a correction moves.
    let normal = turn * frame[0];
    let apart = apart - normal * normal.dot(&apart);
    let mut along = [0.0; 2];
    for (i, along) in along.iter_mut().enumerate() {
        let row = &touch.rows[(1 + i) * nv..][..nv];
        let foreseen = dot(row, &motion.velocity) + touch.outside[1 + i];
        *along = frame[1 + i].dot(&apart) + dot(row, &follower.moved.joints) - h * foreseen;
    }
    if cornered != [true; 2] {
        // What is round may roll, which is no creep: what surely is none of rolling counts.
        let relative = Rotation3::from_matrix_unchecked(paths[1].turn * paths[0].turn.transpose());
        let rolled = UnitQuaternion::from_rotation_matrix(&relative).scaled_axis();
        let tilted = rolled - normal * normal.dot(&rolled);
        let doubt = rolled.norm() * tilted.norm() * size[0].min(size[1]);
        let share = (1.0 - doubt / along[0].hypot(along[1]).max(f64::MIN_POSITIVE)).max(0.0);
        along = along.map(|along| along * share);
    }
    along
}
