//! Joint rows of a step: equalities, dry friction, limits.

use super::ffi::{CONNECT, Data, JOINT, Model, SITE, WELD};
use super::outside::Outside;
use super::touch::{Around, dot};
use super::facts::mobility;

/// `mjtConstraint`: what stands before the contacts. (Contacts are found by their own list.)
const EQUALITY: i32 = 0;
const LIMIT_JOINT: i32 = 3;
const LIMIT_TENDON: i32 = 4;

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Equality,
    Friction,
    Limit,
}

/// A row that takes part.
#[derive(Clone)]
pub(super) struct Row {
    /// Its place among MuJoCo's constraints.
    pub(super) constraint: usize,
    /// The same in every step.
    pub(super) key: u32,
    pub(super) kind: Kind,
    pub(super) row: Vec<f64>,
    /// What is open of an equality, what is left up to a limit (m, rad).
    pub(super) gap: f64,
    /// How fast it opens from outside.
    pub(super) outside: f64,
    /// The most impulse of dry friction.
    pub(super) most: f64,
    /// How much an impulse moves what the row is about if nothing else holds it, and how much it does.
    pub(super) mobility: f64,
    pub(super) response: f64,
}

/// Lists the rows; of limits those that `is_reached`, by row and gap.
pub(super) fn list(around: &Around<'_>, rates: &[f64], is_reached: impl Fn(u32, &[f64], f64) -> bool) -> Vec<Row> {
    let Around { model, data, follower, inertia, .. } = around;
    let (nv, h) = (model.sizes.velocities, model.step());
    let mut rows = Vec::new();
    let mut first = (usize::MAX, 0);
    for (constraint, (&kind, &id)) in data.efc_type().iter().zip(data.efc_id()).enumerate() {
        if kind > LIMIT_TENDON {
            break;
        }
        let id = id.unsigned_abs() as usize;
        let row = &data.efc_j()[constraint * nv..][..nv];
        let position = data.efc_pos()[constraint];
        if first.0 != id || kind != EQUALITY {
            first = (id, constraint);
        }
        let joint = |id: usize| model.dof_invweight0()[model.jnt_dofadr()[id].unsigned_abs() as usize];
        let (sort, gap, outside, mobility) = match kind {
            EQUALITY => {
                let rate = rates.get(constraint).copied().unwrap_or(0.0);
                (Kind::Equality, position, rate, equality_mobility(model, id, constraint - first.1))
            }
            LIMIT_JOINT => (Kind::Limit, position - model.jnt_margin()[id], dot(row, &follower.now.joints), joint(id)),
            LIMIT_TENDON => {
                let gap = position - model.tendon_margin()[id];
                (Kind::Limit, gap, dot(row, &follower.now.joints), model.tendon_invweight0()[id])
            }
            _ => (Kind::Friction, 0.0, 0.0, 1.0),
        };
        // The two limits of a joint have rows of different signs.
        let is_upper = row.iter().sum::<f64>() > 0.0;
        let number = if sort == Kind::Equality { constraint - first.1 } else { usize::from(is_upper) };
        let key = u32::try_from(kind).unwrap_or(0) << 28 | u32::try_from(number).unwrap_or(0) << 24 | u32::try_from(id).unwrap_or(0);
        if sort == Kind::Limit && !is_reached(key, row, gap) {
            continue;
        }
        rows.push(Row {
            constraint,
            key,
            kind: sort,
            row: row.to_vec(),
            gap,
            outside,
            most: h * data.efc_frictionloss()[constraint],
            mobility,
            response: inertia.response(row),
        });
    }
    rows
}

/// How fast the bodies of motion capture open the equalities.
pub(super) fn equality_rates(model: &Model, data: &Data, scratch: &mut Data, outside: &Outside) -> Vec<f64> {
    let h = model.step();
    if model.sizes.equalities == 0 || !outside.moves_mocap() {
        return Vec::new();
    }
    scratch.copy_from(model, data);
    outside.step_back(scratch, h);
    scratch.kinematics(model);
    scratch.com_pos(model);
    scratch.make_constraint(model);
    let is_equality = |kind: &&i32| **kind == EQUALITY;
    let count = data.efc_type().iter().take_while(is_equality).count();
    if scratch.efc_type().iter().take_while(is_equality).count() != count {
        return Vec::new();
    }
    let pairs = data.efc_pos().iter().zip(scratch.efc_pos()).take(count);
    pairs.map(|(now, before)| (now - before) / h).collect()
}

/// Of a row of an equality, as MuJoCo has it of its bodies, joints and tendons.
fn equality_mobility(model: &Model, equality: usize, row: usize) -> f64 {
    let objects = [model.eq_obj1id()[equality], model.eq_obj2id()[equality]].map(|id| usize::try_from(id).ok());
    let sum = |of: &dyn Fn(usize) -> f64| objects.iter().flatten().map(|&id| of(id)).sum::<f64>();
    match model.eq_type()[equality] {
        kind @ (CONNECT | WELD) => {
            let is_site = model.eq_objtype()[equality] == SITE;
            let body = |id: usize| if is_site { model.site_body(id) } else { id };
            if kind == CONNECT || row < 3 {
                sum(&|id| mobility(model, body(id)))
            } else {
                let scale = model.weld_scale(equality);
                sum(&|id| model.body_invweight0()[2 * body(id) + 1]) * scale * scale
            }
        }
        JOINT => sum(&|id| model.dof_invweight0()[model.jnt_dofadr()[id].unsigned_abs() as usize]),
        _ => sum(&|id| model.tendon_invweight0()[id]),
    }
}
