//! What is moved from outside: bodies of motion capture, and positions that are written between steps.
//!
//! A pose has no velocity. What has moved in the last two steps has that of the shorter one; what has moved in one alone is a jump, and
//! has none, unless what touches it goes along.

use super::ffi::{Data, Model};
use super::state::{Reader, Writer};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Velocities from outside.
#[derive(Clone, Default)]
pub(super) struct Outside {
    /// Of bodies of motion capture: along (m/s), about (rad/s).
    pub(super) mocap: Vec<[Vector3<f64>; 2]>,
    /// Of what is written to `qpos`.
    pub(super) joints: Vec<f64>,
}

/// Tells velocities by the poses that are written. What is moved in one step alone is a jump and has none: the position pass then
/// brings along what it meets.
#[derive(Default)]
pub(super) struct Follower {
    end: Option<End>,
    /// What moved between the last steps, and since then.
    last: Option<Outside>,
    pub(super) moved: Outside,
    pub(super) now: Outside,
    /// Where bodies of motion capture are before anybody has moved them.
    initial: Vec<Pose>,
    /// Which velocities were written to.
    pub(super) is_written: Vec<bool>,
}

type Pose = ([f64; 3], [f64; 4]);

/// The end of a step: whose and when, positions, velocities, poses of motion capture.
#[derive(Default)]
struct End {
    place: usize,
    time: f64,
    positions: Vec<f64>,
    velocities: Vec<f64>,
    poses: Vec<Pose>,
}

impl Follower {
    /// Of a model, with data that nobody has written to.
    pub(super) fn new(data: &Data) -> Self {
        Self { initial: poses(data).collect(), ..Self::default() }
    }

    /// Forgets what was.
    pub(super) fn reset(&mut self) {
        (self.end, self.last) = (None, None);
    }

    /// Was the last step one of this data, which has not been reset since, or of one that it is a copy of?
    pub(super) fn follows(&self, data: &Data) -> bool {
        self.end.as_ref().is_some_and(|end| {
            let is_copy = || data.qpos() == end.positions && data.qvel() == end.velocities;
            end.time.to_bits() == data.time().to_bits() && (end.place == data.place() || is_copy())
        })
    }

    /// Looks at the poses before a step.
    pub(super) fn look(&mut self, model: &Model, data: &Data, smallest: f64) {
        let (nv, h) = (model.sizes.velocities, model.step());
        let still = || Outside { mocap: vec![Default::default(); model.sizes.mocaps], joints: vec![0.0; nv] };
        let mut moved = still();
        let poses = match &self.end {
            Some(end) => &end.poses,
            None => &self.initial,
        };
        if self.end.is_some() || data.time() == 0.0 {
            for ((moved, &before), now) in moved.mocap.iter_mut().zip(poses).zip(self::poses(data)) {
                *moved = difference(before, now);
            }
        }
        if let Some(End { positions, .. }) = &self.end
            && data.qpos() != positions
        {
            model.difference(positions, data.qpos(), &mut moved.joints);
        }
        self.is_written.clear();
        self.is_written.extend(moved.joints.iter().map(|moved| moved.abs() > smallest));
        let last = self.last.take().unwrap_or_else(still);
        let pairs = moved.mocap.iter().zip(&last.mocap);
        self.now.mocap = pairs.map(|(a, b)| [0, 1].map(|i| shorter(a[i], b[i]) / h)).collect();
        let pairs = moved.joints.iter().zip(&last.joints);
        self.now.joints = pairs
            .map(|(&a, &b)| if a * b > 0.0 { a.signum() * a.abs().min(b.abs()) / h } else { 0.0 })
            .collect();
        // Where things are put before the first step says nothing of the second.
        self.last = Some(if self.end.is_some() { moved.clone() } else { still() });
        self.moved = moved;
    }

    /// Has something been moved since the end of the last step?
    pub(super) fn moves(&self) -> bool {
        self.moved.moves_mocap() || self.moved.joints.iter().any(|&moved| moved != 0.0)
    }

    /// Is this the first step? What is moved before it is put there, unless what it touches goes along.
    pub(super) fn is_first(&self) -> bool {
        self.end.is_none()
    }

    /// Writes what is known of the last steps.
    pub(super) fn write(&self, out: &mut Writer) {
        out.word(self.end.is_some().into());
        if let Some(End { time, positions, velocities, poses, .. }) = &self.end {
            out.numbers([time].into_iter().chain(positions).chain(velocities));
            out.numbers(poses.iter().flat_map(|(place, turned)| place.iter().chain(turned)));
        }
        out.word(self.last.is_some().into());
        if let Some(Outside { mocap, joints }) = &self.last {
            out.numbers(mocap.iter().flatten().flatten().chain(joints));
        }
    }

    /// What is known of the last steps, of the data of this address.
    pub(super) fn read(&self, model: &Model, place: usize, words: &mut Reader<'_>) -> Option<Self> {
        let (nv, mocaps, initial) = (model.sizes.velocities, model.sizes.mocaps, self.initial.clone());
        let mut own = Self { initial, ..Self::default() };
        if words.word()? != 0 {
            let time = words.number()?;
            let mut all = |count| (0..count).map(|_| words.number()).collect::<Option<Vec<_>>>();
            let (positions, velocities) = (all(model.sizes.positions)?, all(nv)?);
            let poses = (0..mocaps).map(|_| Some((words.numbers()?, words.numbers()?)));
            let poses = poses.collect::<Option<_>>()?;
            own.end = Some(End { place, time, positions, velocities, poses });
        }
        if words.word()? != 0 {
            let mocap = (0..mocaps).map(|_| Some([words.vector()?, words.vector()?]));
            let mocap = mocap.collect::<Option<_>>()?;
            let joints = (0..nv).map(|_| words.number()).collect::<Option<_>>()?;
            own.last = Some(Outside { mocap, joints });
        }
        Some(own)
    }

    /// Remembers the end of a step.
    pub(super) fn keep(&mut self, data: &Data) {
        let end = self.end.get_or_insert_default();
        (end.place, end.time) = (data.place(), data.time());
        for (kept, now) in [(&mut end.positions, data.qpos()), (&mut end.velocities, data.qvel())] {
            kept.clear();
            kept.extend_from_slice(now);
        }
        end.poses.clear();
        end.poses.extend(poses(data));
    }
}

impl Outside {
    /// Does a body of motion capture move?
    pub(super) fn moves_mocap(&self) -> bool {
        self.mocap.iter().flatten().any(|velocity| *velocity != Vector3::zeros())
    }

    /// Velocity of a point that is fixed to a body of motion capture, and how fast that turns.
    pub(super) fn velocity(&self, mocap: Option<usize>, data: &Data, place: [f64; 3]) -> [Vector3<f64>; 2] {
        mocap.map_or_else(Default::default, |mocap| {
            let [along, about] = self.mocap[mocap];
            let arm = Vector3::from(place) - Vector3::from(data.mocap_pos()[mocap]);
            [along + about.cross(&arm), about]
        })
    }

    /// Puts the bodies of motion capture where they were a time `h` ago.
    pub(super) fn step_back(&self, data: &mut Data, h: f64) {
        for (place, [along, _]) in data.mocap_pos_mut().iter_mut().zip(&self.mocap) {
            *place = (Vector3::from(*place) - along * h).into();
        }
        for (turned, [_, about]) in data.mocap_quat_mut().iter_mut().zip(&self.mocap) {
            let back = UnitQuaternion::from_scaled_axis(-about * h) * quaternion(*turned);
            *turned = [back.w, back.i, back.j, back.k];
        }
    }
}

fn poses(data: &Data) -> impl Iterator<Item = Pose> {
    data.mocap_pos().iter().copied().zip(data.mocap_quat().iter().copied())
}

fn quaternion([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

/// What leads from a pose to another: along, about.
fn difference(before: Pose, now: Pose) -> [Vector3<f64>; 2] {
    let turn = quaternion(now.1) * quaternion(before.1).inverse();
    let along = Vector3::from(now.0) - Vector3::from(before.0);
    [
        along,
        if before.1.map(f64::to_bits) == now.1.map(f64::to_bits) {
            Vector3::zeros()
        } else {
            turn.scaled_axis()
        },
    ]
}

/// The first, no longer than the second; 0 if they do not go the same way.
fn shorter(a: Vector3<f64>, b: Vector3<f64>) -> Vector3<f64> {
    let (along, [one, other]) = (a.dot(&b), [a.norm(), b.norm()]);
    if along > 0.5 * one * other { a * (other / one).min(1.0) } else { Vector3::zeros() }
}
