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

impl<const N: usize, const C: usize, const R: usize> World<N, C, R> {
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
        let mut joints =
            self.trees.iter().flat_map(|tree| tree.joints.iter().map(move |joint| (tree, joint)));
        let (joint, kind) = (key as usize / 3, key as usize % 3);
        let Some((tree, joint)) = joints.nth(joint) else { return format!("row {key}") };
        match joint.mimic {
            Some(mimic) if kind == 0 => format!("{} mimics {}", joint.name, tree.joints[mimic.leader].name),
            _ => format!("{} of {}", ["motor", "lower stop", "upper stop"][kind], joint.name),
        }
    }

    /// The motors, and joints that mimic others. Returns the stops, which the solve takes in as they are reached.
    pub(crate) fn push_rows(&mut self) -> Result<Vec<JointRow<f64, N>>, Failure> {
        let (mut stops, mut key, mut first) = (Vec::new(), 0, 0);
        let (scene, [stiffness, damping]) = (self.kernel.scene_mut(), self.gains);
        for tree in &self.trees {
            first += tree.size() - tree.joints.len();
            for (dof, joint) in tree.joints.iter().enumerate() {
                let mut row = SVector::<f64, N>::zeros();
                row[first + dof] = 1.0;
                if let Some(mimic) = joint.mimic {
                    let mut gear = row;
                    gear[first + mimic.leader] -= mimic.ratio;
                    let drift = joint.angle - mimic.ratio * tree.joints[mimic.leader].angle - mimic.offset;
                    let gear = ClosedLoop { drift, recovery: RECOVERY }.row(gear, STEP, key)?;
                    scene.push_row(&gear)?;
                } else if joint.effort != 0.0 {
                    let [aim, target] = joint.target;
                    let (limit, ahead) = (joint.effort, joint.angle - aim);
                    let motor = Motor { stiffness, damping, limit, ahead, target, ..Motor::default() };
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
                key += 1;
            }
            first += tree.joints.len();
        }
        Ok(stops)
    }
}
