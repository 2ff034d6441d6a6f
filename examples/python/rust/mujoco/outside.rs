//! What is moved from outside: bodies of motion capture, and positions that are written between steps.

use super::ffi::{Data, Model};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Velocities from outside.
#[derive(Clone, Default)]
pub(super) struct Outside {
    /// Of bodies of motion capture: along (m/s), about (rad/s).
    mocap: Vec<[Vector3<f64>; 2]>,
    /// Of what is written to `qpos`.
    pub(super) joints: Vec<f64>,
}

/// Tells velocities by the poses that are written. What is moved in one step alone is a jump and has none: the position pass then
/// brings along what it meets.
#[derive(Default)]
pub(super) struct Follower {
    /// The end of the last step: whose and when, positions, poses of motion capture.
    end: Option<End>,
    /// What moved between the last steps.
    last: Option<Outside>,
    pub(super) now: Outside,
    /// Which velocities were written to.
    pub(super) is_written: Vec<bool>,
}

type Pose = ([f64; 3], [f64; 4]);
type End = ((usize, f64), Vec<f64>, Vec<Pose>);

impl Follower {
    /// Forgets what was.
    pub(super) fn reset(&mut self) {
        (self.end, self.last) = (None, None);
    }

    /// Was the last step one of this data, which has not been reset since?
    pub(super) fn follows(&self, data: &Data) -> bool {
        self.end.as_ref().is_some_and(|(end, ..)| *end == (data.place(), data.time()))
    }

    /// Looks at the poses before a step.
    pub(super) fn look(&mut self, model: &Model, data: &Data, smallest: f64) {
        let (nv, mocaps, h) = (model.sizes.velocities, model.sizes.mocaps, model.step());
        let mut moved = Outside { mocap: vec![[Vector3::zeros(); 2]; mocaps], joints: vec![0.0; nv] };
        if let Some((_, positions, poses)) = &self.end {
            for ((moved, &before), now) in moved.mocap.iter_mut().zip(poses).zip(self::poses(data)) {
                *moved = difference(before, now);
            }
            if data.qpos() != positions {
                model.difference(positions, data.qpos(), &mut moved.joints);
            }
        }
        self.is_written.clear();
        self.is_written.extend(moved.joints.iter().map(|moved| moved.abs() > smallest));
        let still = || Outside { mocap: vec![[Vector3::zeros(); 2]; mocaps], joints: vec![0.0; nv] };
        let last = self.last.get_or_insert_with(still);
        let pairs = moved.mocap.iter().zip(&last.mocap);
        self.now.mocap = pairs.map(|(a, b)| [0, 1].map(|i| shorter(a[i], b[i]) / h)).collect();
        let pairs = moved.joints.iter().zip(&last.joints);
        self.now.joints = pairs
            .map(|(&a, &b)| if a * b > 0.0 { a.signum() * a.abs().min(b.abs()) / h } else { 0.0 })
            .collect();
        *last = moved;
    }

    /// Has something been moved since the end of the last step?
    pub(super) fn moves(&self) -> bool {
        let moves = |last: &Outside| last.moves_mocap() || last.joints.iter().any(|&moved| moved != 0.0);
        self.last.as_ref().is_some_and(moves)
    }

    /// How a body of motion capture has moved since the end of the last step: along, about, and where it is.
    pub(super) fn moved(&self, mocap: usize, data: &Data) -> [Vector3<f64>; 3] {
        let [along, about] = self.last.as_ref().map_or_else(Default::default, |last| last.mocap[mocap]);
        [along, about, data.mocap_pos()[mocap].into()]
    }

    /// How far positions were written to since then.
    pub(super) fn written(&self) -> &[f64] {
        self.last.as_ref().map_or(&[], |last| &last.joints)
    }

    /// Writes what is known of the last steps.
    pub(super) fn write(&self, out: &mut Vec<f64>) {
        out.push(f64::from(u8::from(self.end.is_some())));
        if let Some(((_, time), positions, poses)) = &self.end {
            out.push(*time);
            out.extend(positions);
            poses.iter().for_each(|(place, turned)| out.extend(place.iter().chain(turned)));
        }
        out.push(f64::from(u8::from(self.last.is_some())));
        if let Some(last) = &self.last {
            last.mocap.iter().flatten().for_each(|moved| out.extend(moved.iter()));
            out.extend(&last.joints);
        }
    }

    /// Takes over what was written, as of this data.
    pub(super) fn read(&mut self, model: &Model, data: &Data, own: &mut impl Iterator<Item = f64>) -> Option<()> {
        let (nq, nv, mocaps) = (data.qpos().len(), model.sizes.velocities, model.sizes.mocaps);
        self.reset();
        if own.next()? > 0.0 {
            let time = own.next()?;
            let positions: Vec<f64> = own.by_ref().take(nq).collect();
            let mut poses = Vec::new();
            for _ in 0..mocaps {
                let mut next = || own.next();
                poses.push(([next()?, next()?, next()?], [next()?, next()?, next()?, next()?]));
            }
            self.end = Some(((data.place(), time), positions, poses));
        }
        if own.next()? > 0.0 {
            let mut mocap = Vec::new();
            for _ in 0..mocaps {
                let mut next = || own.next();
                mocap.push([
                    Vector3::new(next()?, next()?, next()?),
                    Vector3::new(next()?, next()?, next()?),
                ]);
            }
            self.last = Some(Outside { mocap, joints: own.by_ref().take(nv).collect() });
        }
        Some(())
    }

    /// Remembers the end of a step.
    pub(super) fn keep(&mut self, data: &Data) {
        let (end, positions, poses) = self.end.get_or_insert_default();
        *end = (data.place(), data.time());
        positions.clear();
        positions.extend_from_slice(data.qpos());
        poses.clear();
        poses.extend(self::poses(data));
    }
}

impl Outside {
    /// Does a body of motion capture move?
    pub(super) fn moves_mocap(&self) -> bool {
        self.mocap.iter().flatten().any(|velocity| *velocity != Vector3::zeros())
    }

    /// Velocity of a point that is fixed to a body of motion capture.
    pub(super) fn velocity(&self, mocap: Option<usize>, data: &Data, place: [f64; 3]) -> Vector3<f64> {
        mocap.map_or_else(Vector3::zeros, |mocap| {
            let [along, about] = self.mocap[mocap];
            along + about.cross(&(Vector3::from(place) - Vector3::from(data.mocap_pos()[mocap])))
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
