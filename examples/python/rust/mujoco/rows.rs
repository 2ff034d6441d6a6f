//! Joint rows of a step: equalities, dry friction, limits.

use super::facts::{has_lever, mobility};
use super::ffi::{CONNECT, Data, Model, SITE, WELD};
use super::outside::Outside;
use super::softness::Spring;
use super::touch::{Around, dot};
use std::collections::HashSet;

/// `mjtConstraint`: what stands before the contacts. (Contacts are found by their own list.)
const EQUALITY: i32 = 0;
const LIMIT_JOINT: i32 = 3;
const LIMIT_TENDON: i32 = 4;

/// Of a key, what names the equality, joint or tendon.
const ID: u32 = 0xff_ffff;

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
    pub(super) jacobian: Vec<f64>,
    /// What is open of an equality, what is left up to a limit (m, rad).
    pub(super) gap: f64,
    /// How fast it opens from outside.
    pub(super) outside: f64,
    /// The most impulse of dry friction.
    pub(super) most: f64,
    /// How much an impulse moves what the row is about if nothing else holds it, and how much it moves the row.
    pub(super) mobility: f64,
    pub(super) response: f64,
    /// Of an equality with a body of motion capture: how fast it opens or closes where that is blocked, by MuJoCo's own law of
    /// it (`solref`, `solimp`).
    pub(super) spring: Option<f64>,
    /// How it gives way, if the user has asked for that.
    pub(super) soft: Option<Spring>,
}

impl Row {
    /// The equality that it is a row of.
    pub(super) fn equality(&self) -> Option<u32> {
        (self.kind == Kind::Equality).then_some(self.key & ID)
    }
}

/// A limit among MuJoCo's constraints: its key, and what is left up to it (m, rad).
fn limit(model: &Model, data: &Data, constraint: usize, row: &[f64]) -> (u32, f64) {
    let (kind, id) = (data.efc_type()[constraint], data.efc_id()[constraint].unsigned_abs());
    let margin = if kind == LIMIT_JOINT {
        model.jnt_margin()[id as usize]
    } else {
        model.tendon_margin()[id as usize]
    };
    // The two limits of a joint have rows of different signs.
    let is_upper = row.iter().sum::<f64>() > 0.0;
    (key(kind, usize::from(is_upper), id), data.efc_pos()[constraint] - margin)
}

fn key(kind: i32, number: usize, id: u32) -> u32 {
    kind.unsigned_abs() << 28 | u32::try_from(number).unwrap_or(0) << 24 | id & ID
}

/// The constraints before contacts, and their rows.
fn constraints<'a>(model: &Model, data: &'a Data) -> impl Iterator<Item = (usize, i32, &'a [f64])> {
    let rows = data.efc_j().chunks_exact(model.sizes.velocities);
    let all = data.efc_type().iter().zip(rows).enumerate();
    all.take_while(|&(_, (&kind, _))| kind <= LIMIT_TENDON)
        .map(|(constraint, (&kind, row))| (constraint, kind, row))
}

/// Lists the rows that have a lever; of limits those that are `reached`, or may be with one of these velocities.
pub(super) fn list(
    around: &Around<'_>,
    rates: &[f64],
    velocities: [&[f64]; 2],
    reached: &mut HashSet<u32>,
) -> Vec<Row> {
    let Around { model, data, springs, follower, inertia, .. } = around;
    let h = model.step();
    let (mut rows, mut scratch) = (Vec::new(), Vec::new());
    let mut first = (u32::MAX, 0);
    for (constraint, sort, row) in constraints(model, data) {
        let id = data.efc_id()[constraint].unsigned_abs();
        let moved = || dot(row, &follower.now.joints);
        let (key, kind, gap, outside, mobility) = match sort {
            EQUALITY => {
                if first.0 != id {
                    first = (id, constraint);
                }
                let (number, rate) = (constraint - first.1, rates.get(constraint).copied().unwrap_or(0.0));
                let mobility = equality_mobility(model, id as usize, number, row);
                (key(sort, number, id), Kind::Equality, data.efc_pos()[constraint], rate, mobility)
            }
            LIMIT_JOINT | LIMIT_TENDON => {
                let (key, gap) = limit(model, data, constraint, row);
                let may_reach = |velocity: &&[f64]| gap + h * dot(row, velocity) < 0.0;
                if !(gap <= 0.0 || reached.contains(&key) || velocities.iter().any(may_reach)) {
                    continue;
                }
                reached.insert(key);
                let mobility = if sort == LIMIT_JOINT {
                    model.dof_invweight0()[model.jnt_dofadr()[id as usize].unsigned_abs() as usize]
                } else {
                    model.tendon_invweight0()[id as usize]
                };
                (key, Kind::Limit, gap, moved(), mobility)
            }
            _ => (key(sort, 0, id), Kind::Friction, 0.0, 0.0, 1.0),
        };
        let response = match kind {
            Kind::Friction => mobility,
            Kind::Equality | Kind::Limit => inertia.response(row, &mut scratch),
        };
        if !has_lever(response, mobility) {
            continue;
        }
        let most = h * data.efc_frictionloss()[constraint];
        let soft = (sort == EQUALITY).then(|| springs.of_equality(model, id as usize)).flatten();
        let spring = (sort == EQUALITY && soft.is_none() && is_led(around, id as usize)).then(|| {
            let [stiffness, damping, impedance, _] = data.efc_kbip()[constraint];
            let rate = dot(row, data.qvel()) + outside;
            outside - rate * (1.0 - h * damping) + h * stiffness * impedance * gap
        });
        rows.push(Row {
            constraint,
            key,
            kind,
            jacobian: row.to_vec(),
            gap,
            outside,
            most,
            mobility,
            response,
            spring,
            soft,
        });
    }
    rows
}

/// Adds the limits that a velocity passes by more than `least` (m, rad); `true` if there are any.
pub(super) fn passed(
    model: &Model,
    data: &Data,
    velocity: &[f64],
    least: f64,
    reached: &mut HashSet<u32>,
) -> bool {
    let mut any = false;
    for (constraint, _, row) in
        constraints(model, data).filter(|&(_, kind, _)| kind == LIMIT_JOINT || kind == LIMIT_TENDON)
    {
        let (key, gap) = limit(model, data, constraint, row);
        if gap + model.step() * dot(row, velocity) < -least {
            any |= reached.insert(key);
        }
    }
    any
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

/// Is an equality with a body of motion capture?
fn is_led(Around { model, facts, .. }: &Around<'_>, equality: usize) -> bool {
    matches!(model.eq_type()[equality], CONNECT | WELD)
        && bodies(model, equality).any(|body| facts.mocap(body).is_some())
}

/// What an equality is between.
fn objects(model: &Model, equality: usize) -> impl Iterator<Item = usize> {
    let objects = [model.eq_obj1id()[equality], model.eq_obj2id()[equality]];
    objects.into_iter().filter_map(|id| usize::try_from(id).ok())
}

/// Bodies of an equality that has them.
fn bodies(model: &Model, equality: usize) -> impl Iterator<Item = usize> {
    let is_site = model.eq_objtype()[equality] == SITE;
    objects(model, equality).map(move |id| if is_site { model.site_body(id) } else { id })
}

/// Of a row of an equality, as MuJoCo has it of its bodies, joints and tendons.
fn equality_mobility(model: &Model, equality: usize, number: usize, row: &[f64]) -> f64 {
    let sum_of_bodies = |of: &dyn Fn(usize) -> f64| bodies(model, equality).map(of).sum::<f64>();
    match model.eq_type()[equality] {
        kind @ (CONNECT | WELD) => {
            if kind == CONNECT || number < 3 {
                sum_of_bodies(&|body| mobility(model, body))
            } else {
                let scale = model.weld_scale(equality);
                sum_of_bodies(&|body| model.body_invweight0()[2 * body + 1]) * scale * scale
            }
        }
        // With the ratio of a gear, which may be of other units.
        _ => row.iter().zip(model.dof_invweight0()).map(|(entry, own)| entry * entry * own).sum(),
    }
}
