//! What stands in the scene of a step: contacts, motors, stops, joints that mimic each other.

use crate::collide::Point;
use crate::dynamics::Dynamics;
use crate::{Failure, STEP, World};
use nalgebra::{SVector, vector};
use stiction::time_stepping::{ClosedLoop, Gap, JointLimit, Motor, Spring};
use stiction::{Contact, Error, JointRow, Surface};

/// Speed (m/s, rad/s) at which nothing here closes.
const REACH: f64 = 20.0;
/// Penetration, and what has drifted apart, is undone at this speed (m/s, rad/s) at most; a joint beyond its stop faster.
const RECOVERY: f64 = 0.1;
const STOP_RECOVERY: f64 = 1.0;
/// Relaxation time of rubber (s).
const RELAXATION: f64 = 5e-3;

impl<const N: usize> World<N> {
    /// The contacts at these points.
    pub(crate) fn push_contacts(&mut self, points: &[Point], dynamics: &Dynamics<N>) -> Result<(), Error> {
        let rubber = Spring { stiffness: self.stiffness, relaxation: RELAXATION };
        let compliance = rubber.compliance(STEP)?; // 0 is rigid
        let surface = Surface { compliance: [compliance, 0.0], ..Surface::isotropic(self.mu) };
        for point in points {
            let [a, b] = point.pair.map(|body| dynamics.jacobian(body, &point.place));
            let gap = Gap { distance: point.gap, recovery: RECOVERY, reach: REACH };
            let gap = if compliance > 0.0 { rubber.offset(&gap, STEP)? } else { gap.offset(STEP)? };
            let contact = Contact {
                offset: vector![gap, 0.0, 0.0],
                ..Contact::at_point(&point.normal, &(b - a), self.mu, point.key)?
            };
            self.kernel.scene_mut().push_on(&contact, &surface)?;
        }
        Ok(())
    }

    /// What the row of a key of [`Self::push_rows`] is, in words.
    pub(crate) fn row_name(&self, key: u32) -> String {
        let joints = self.trees.iter().flat_map(|tree| &tree.joints);
        let names: Vec<_> = joints.map(|joint| &joint.name).collect();
        let (joint, kind) = (key as usize / 3, key as usize % 3);
        match names.get(joint) {
            Some(name) => format!("{} of {name}", ["motor", "lower stop", "upper stop"][kind]),
            None => match self.mimics.get(key as usize - 3 * names.len()) {
                Some([one, other]) => format!("{one} mimics {other}"),
                None => format!("row {key}"),
            },
        }
    }

    /// The motors, and joints that mimic each other. Returns the stops, which the solve takes in as they are reached.
    pub(crate) fn push_rows(&mut self) -> Result<Vec<JointRow<f64, N>>, Failure> {
        let (mut stops, mut key, mut dof) = (Vec::new(), 0, 0);
        let (scene, [stiffness, damping]) = (self.kernel.scene_mut(), self.gains);
        let mut joints = Vec::new();
        for tree in &self.trees {
            dof += tree.size() - tree.joints.len();
            for joint in &tree.joints {
                let mut row = SVector::<f64, N>::zeros();
                row[dof] = 1.0;
                joints.push((&*joint.name, row, joint.angle));
                let [aim, target] = joint.target;
                let motor = Motor {
                    stiffness,
                    damping,
                    limit: joint.effort,
                    ahead: joint.angle - aim,
                    target,
                    ..Motor::default()
                };
                if joint.effort != 0.0 {
                    let row = motor.row(row, STEP, key);
                    let row = row.map_err(|error| format!("joint {}: {error}", joint.name))?;
                    scene.push_row(&row)?;
                }
                let [lower, upper] = joint.range;
                for (row, distance) in [(row, joint.angle - lower), (-row, upper - joint.angle)] {
                    key += 1;
                    let stop = JointLimit { distance, recovery: STOP_RECOVERY, reach: REACH };
                    stops.push(stop.row(row, STEP, key)?);
                }
                (key, dof) = (key + 1, dof + 1);
            }
        }
        for names in &self.mimics {
            let find = |name| joints.iter().find(|(joint, ..)| *joint == name);
            let [Some((_, one, at)), Some((_, other, there))] = names.map(find) else {
                return Err(format!("there are no joints {names:?}").into());
            };
            let gear = ClosedLoop { drift: at - there, recovery: RECOVERY };
            scene.push_row(&gear.row(one - other, STEP, key)?)?;
            key += 1;
        }
        Ok(stops)
    }
}
