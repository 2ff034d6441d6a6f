//! The scene of a step, from MuJoCo's arrays.

use super::choice::Listed;
use super::redundant::reconcile;
use crate::problem::{Dynamics, Friction, Problem, Rows};
use numpy::ndarray::ArrayView2;

/// `mjtConstraint`: what stands before the contacts. (Contacts are found by their own list.)
const EQUALITY: i32 = 0;
const LIMIT_JOINT: i32 = 3;
const LIMIT_TENDON: i32 = 4;

/// What a step reads.
pub(super) struct Step<'a> {
    pub(super) nv: usize,
    /// Time step (s).
    pub(super) h: f64,
    /// The fastest at which a penetration is pushed out, and an equality closed (m/s, rad/s).
    pub(super) recovery: f64,
    pub(super) closing: f64,
    pub(super) velocity: &'a [f64],
    pub(super) smooth: &'a [f64],
    pub(super) damping: &'a [f64],
    pub(super) jacobian: &'a [f64],
    pub(super) kinds: &'a [i32],
    pub(super) ids: &'a [i32],
    pub(super) positions: &'a [f64],
    pub(super) losses: &'a [f64],
    pub(super) geoms: ArrayView2<'a, i32>,
    pub(super) friction: ArrayView2<'a, f64>,
    pub(super) surface: ArrayView2<'a, f64>,
}

impl<'a> Step<'a> {
    /// Rows of the constraints' Jacobian.
    pub(super) fn rows(&self, first: usize, count: usize) -> &'a [f64] {
        &self.jacobian[first * self.nv..(first + count) * self.nv]
    }

    /// The speed that closes a distance in the step; a penetration is pushed out no faster than `recovery`.
    fn offset(&self, distance: f64) -> f64 {
        (distance / self.h).max(-self.recovery)
    }

    /// Normal velocity of a contact above that which closes it in the step.
    pub(super) fn gap_speed(&self, contact: &Listed, velocity: &[f64]) -> f64 {
        let products = self.rows(contact.address, 1).iter().zip(velocity);
        products.map(|(entry, v)| entry * v).sum::<f64>() + self.offset(contact.distance)
    }
}

/// The arrays of a scene.
#[derive(Default)]
pub(super) struct Scene {
    /// Margins of joint and tendon limits as the model had them.
    margins: [Vec<f64>; 2],
    /// Which constraints are joint rows.
    pub(super) constraints: Vec<usize>,
    mass: Vec<f64>,
    free_impulse: Vec<f64>,
    jacobian: Vec<f64>,
    offsets: Vec<f64>,
    round: Vec<f64>,
    shaped: Vec<f64>,
    keys: Vec<u32>,
    row_jacobian: Vec<f64>,
    row_offset: Vec<f64>,
    row_lower: Vec<f64>,
    row_upper: Vec<f64>,
    row_keys: Vec<u32>,
}

impl Scene {
    pub(super) fn new(margins: [Vec<f64>; 2]) -> Self {
        Self {
            margins,
            ..Self::default()
        }
    }

    /// How many joint rows it has.
    pub(super) fn rows(&self) -> usize {
        self.constraints.len()
    }

    /// `M` with damping, and the free impulse `M v + h F`.
    pub(super) fn dynamics(&mut self, data: &Step<'_>, metric: &[f64]) {
        let nv = data.nv;
        self.mass.clear();
        self.mass.extend_from_slice(metric);
        self.free_impulse.clear();
        for i in 0..nv {
            self.mass[i * nv + i] += data.h * data.damping[i];
            let row = self.mass[i * nv..][..nv].iter();
            let momentum: f64 = row.zip(data.velocity).map(|(m, v)| m * v).sum();
            self.free_impulse.push(momentum + data.h * data.smooth[i]);
        }
    }

    pub(super) fn fill_rows(&mut self, data: &Step<'_>) {
        self.constraints.clear();
        for list in [
            &mut self.row_jacobian,
            &mut self.row_offset,
            &mut self.row_lower,
            &mut self.row_upper,
        ] {
            list.clear();
        }
        self.row_keys.clear();
        for (row, &kind) in data.kinds.iter().enumerate() {
            if kind > LIMIT_TENDON {
                continue;
            }
            let (id, position) = (
                u32::try_from(data.ids[row]).unwrap_or(0),
                data.positions[row],
            );
            let [joints, tendons] = &self.margins;
            let (infinity, loss) = (f64::INFINITY, data.h * data.losses[row]);
            let (offset, lower, upper) = match kind {
                EQUALITY => {
                    let speed = (position / data.h).clamp(-data.closing, data.closing);
                    (speed, -infinity, infinity)
                }
                LIMIT_JOINT => (data.offset(position - joints[id as usize]), 0.0, infinity),
                LIMIT_TENDON => (data.offset(position - tendons[id as usize]), 0.0, infinity),
                _ => (0.0, -loss, loss),
            };
            self.constraints.push(row);
            self.row_jacobian.extend_from_slice(data.rows(row, 1));
            self.row_offset.push(offset);
            self.row_lower.push(lower);
            self.row_upper.push(upper);
            self.row_keys
                .push(u32::try_from(kind).unwrap_or(0) << 28 | id);
        }
        // MuJoCo lists equalities first.
        let count = data.kinds.iter().take_while(|&&kind| kind == EQUALITY);
        let count = count.count();
        let equalities = &self.row_jacobian[..count * data.nv];
        reconcile(equalities, data.nv, &mut self.row_offset[..count]);
    }

    /// Fills in contacts; does a cone need more than one coefficient?
    pub(super) fn fill_contacts(
        &mut self,
        data: &Step<'_>,
        contacts: &[Listed],
        dim: usize,
    ) -> bool {
        for list in [
            &mut self.jacobian,
            &mut self.offsets,
            &mut self.round,
            &mut self.shaped,
        ] {
            list.clear();
        }
        self.keys.clear();
        let mut is_shaped = dim > 3;
        for (i, contact) in contacts.iter().enumerate() {
            let rows = data.rows(contact.address, contact.dim);
            self.jacobian.extend_from_slice(rows);
            self.jacobian.resize((i + 1) * dim * data.nv, 0.0);
            self.offsets.push(data.offset(contact.distance));
            // MuJoCo gives the speeds of surfaces along the tangents and about the normal.
            let surface = data.surface.row(contact.index);
            self.offsets.extend(surface.iter().take(contact.dim - 1));
            self.offsets.resize((i + 1) * dim, 0.0);
            let friction = data.friction.row(contact.index);
            self.shaped.extend(friction.iter().take(contact.dim - 1));
            self.shaped.resize((i + 1) * (dim - 1), 0.0);
            let rubs = contact.dim > 1;
            self.round.push(if rubs { friction[0] } else { 0.0 });
            is_shaped |= rubs && friction[0].to_bits() != friction[1].to_bits();
            let geom =
                |side: usize| u32::try_from(data.geoms[[contact.index, side]]).unwrap_or(u32::MAX);
            self.keys.push(geom(0) << 16 ^ geom(1));
        }
        is_shaped
    }

    /// Takes back what pushes penetrations out and closes equalities: then standing still is a solution.
    pub(super) fn leave_penetrations(&mut self, dim: usize) {
        for offset in self.offsets.iter_mut().step_by(dim) {
            *offset = offset.max(0.0);
        }
        for (offset, &lower) in self.row_offset.iter_mut().zip(&self.row_lower) {
            *offset = if lower < 0.0 { 0.0 } else { offset.max(0.0) };
        }
    }

    pub(super) fn problem(&self, n: usize, dim: usize, is_shaped: bool) -> Problem<'_, f64> {
        Problem {
            n,
            dim,
            dynamics: Dynamics::Mass(&self.mass, &self.jacobian, &self.free_impulse),
            offsets: &self.offsets,
            friction: if is_shaped {
                Friction::Shaped(&self.shaped)
            } else {
                Friction::Round(&self.round)
            },
            compliance: &[],
            keys: &self.keys,
            rows: Rows {
                jacobian: &self.row_jacobian,
                offset: &self.row_offset,
                lower: &self.row_lower,
                upper: &self.row_upper,
                compliance: &[],
                keys: &self.row_keys,
            },
        }
    }
}
