//! What the position pass asks of an island: how far each contact and each row is to come back in the step.

use super::creep::{Creep, holds};
use super::facts::{CLOSED, has_lever};
use super::islands::Island;
use super::locks::{Locks, Name};
use super::rows::{Kind, Row};
use super::touch::dot;
use super::velocity::{Motion, Scene};
use nalgebra::{DMatrix, DVector};

/// The share of an overlap that is taken back in a step; of an equality, and of what this step found, all.
const SHARE: f64 = 0.8;
/// Compliance of contacts and of other rows, over what moves them.
const CONTACT: f64 = 1e-4;
const ROW: f64 = 0.02;
/// Compliance of contacts that keep the impulses of the velocity pass.
const PRESSED: f64 = 1e-5;
/// Compliance of contacts that are springs: these are held as they are, and give way to all others.
const SPRING: f64 = 1e-2;
/// A row is moved as little as if it were at least this share of a free point.
const LEAST: f64 = 1e-2;
/// The fastest recovery of an overlap, over the model's own speed.
const RECOVERY: f64 = 0.2;
/// How fast joints turn to close what is far open, over the model's speed over its length.
const TURN: f64 = 4.0;
/// What is open of rows up to this is left as it is, over the model's own length.
const LEFT: f64 = 1e-9;
/// What does less than this share of what is asked of it does not give way.
const LITTLE: f64 = 0.1;

/// What is asked of an island.
#[derive(Default)]
pub(super) struct Asked {
    pub(super) touches: Vec<(Demand, Grip)>,
    pub(super) rows: Vec<Demand>,
    /// Do contacts keep the impulses of the velocity pass, and change these?
    pub(super) is_pressed: bool,
}

/// What is asked of a contact or a row.
pub(super) struct Demand {
    /// Its place among those of the scene.
    pub(super) place: usize,
    /// The velocity that is left to it; of a contact along its normal.
    pub(super) offset: f64,
    pub(super) compliance: f64,
}

/// What else is asked of a contact.
#[derive(Clone, Copy)]
pub(super) struct Grip {
    /// The velocities along its tangents.
    pub(super) slip: [f64; 2],
    /// Has it friction in this pass?
    pub(super) rubs: bool,
    /// The normal impulse that it starts from.
    pub(super) start: f64,
    /// Compliance along its tangents.
    pub(super) compliance: f64,
}

/// The model's own length (m) and speed (m/s).
#[derive(Clone, Copy)]
pub(super) struct Scale {
    pub(super) length: f64,
    pub(super) speed: f64,
}

/// How an island moves.
pub(super) struct Moving<'a> {
    pub(super) motion: &'a Motion,
    /// How far contacts that stick have crept (m).
    pub(super) creeps: &'a [Creep],
    pub(super) scale: Scale,
    /// Is a velocity one of turning?
    pub(super) turns: &'a [bool],
    /// Is something blocked that a body of motion capture leads? Then its spring pulls, and nothing else.
    pub(super) is_blocked: bool,
}

impl Moving<'_> {
    /// Is there a contact of an island that sticks and bears?
    pub(super) fn holds_in(&self, island: &Island) -> bool {
        island.touches.iter().any(|&place| holds(self.motion, place))
    }

    /// Does a contact of an island creep?
    fn creeps_in(&self, island: &Island) -> bool {
        island.touches.iter().any(|&place| self.creeps[place].counts)
    }

    /// Is a row asked to close?
    fn asks(&self, row: &Row) -> bool {
        row.kind != Kind::Friction && row.soft.is_none() && !(self.is_blocked && row.spring.is_some())
    }
}

impl Asked {
    /// Locks what a correction does not do more than a little of; `true` if there is something.
    pub(super) fn lock(
        &self,
        scene: &Scene<'_>,
        moving: &Moving<'_>,
        correction: &[f64],
        locks: &mut Locks,
    ) -> bool {
        let (left, before) = (LEFT * moving.scale.length / scene.h, locks.0.len());
        // How much is asked, and done.
        let of = |offset: f64, row: &[f64], is_equality: bool| {
            let wrong = |speed: f64| if is_equality { speed.abs() } else { (-speed).max(0.0) };
            [wrong(offset), wrong(offset) - wrong(offset + dot(row, correction))]
        };
        let of_touch = |demand: &Demand| of(demand.offset, scene.touches[demand.place].normal_row(), false);
        let of_row = |demand: &Demand| {
            let row = &scene.rows[demand.place];
            of(demand.offset, &row.jacobian, row.kind == Kind::Equality)
        };
        let of_touches = self.touches.iter().map(|(demand, _)| of_touch(demand));
        let all = of_touches.chain(self.rows.iter().map(of_row));
        // What is asked little beside others may have to wait for these.
        let least = left.max(LITTLE * all.fold(0.0, |most, [asked, _]| f64::max(most, asked)));
        let refuses = |[asked, done]: [f64; 2]| asked > least && done < LITTLE * asked;
        for (demand, _) in self.touches.iter().filter(|(demand, _)| refuses(of_touch(demand))) {
            locks.add(Name::Touch(scene.touches[demand.place].key));
        }
        let equality = |demand: &Demand| scene.rows[demand.place].equality();
        for rows in
            self.rows.chunk_by(|one, other| equality(one).is_some() && equality(one) == equality(other))
        {
            let sum = rows.iter().map(of_row).fold([0.0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]]);
            if refuses(sum) {
                for demand in rows {
                    locks.add(Name::Row(scene.rows[demand.place].key));
                }
            }
        }
        locks.0.len() > before
    }

    /// Lists what is asked at the end of a motion.
    pub(super) fn list(
        &mut self,
        scene: &Scene<'_>,
        island: &Island,
        moving: &Moving<'_>,
        locks: &Locks,
        is_pressed: bool,
    ) {
        let (h, Moving { motion, scale, .. }) = (scene.h, moving);
        self.touches.clear();
        self.rows.clear();
        self.is_pressed = is_pressed;
        let soft = |factor: f64, response: f64, mobility: f64| factor * response.max(LEAST * mobility);
        let lever = |response: f64, mobility: f64| {
            if mobility > 0.0 { (response / mobility).min(1.0) } else { 1.0 }
        };
        for (&place, touch) in island.touches.iter().zip(scene.touches(island)) {
            if !has_lever(touch.response, touch.mobility) {
                continue;
            }
            let mut open = touch.gap + h * dot(touch.normal_row(), &motion.velocity);
            if touch.soft.is_some() {
                open = open.max(0.0);
            }
            if open < 0.0 {
                let fastest = if touch.is_driven { scale.speed } else { RECOVERY * scale.speed };
                // What is from the step itself is taken back in it.
                let old = (-open - touch.curve).max(0.0);
                let most = h * fastest * lever(touch.response, touch.mobility);
                let back = if old > CLOSED * scale.length { (SHARE * old).min(most) } else { 0.0 };
                open = (open + old) - back;
                if locks.hold(Name::Touch(touch.key)) {
                    open = 0.0;
                }
            }
            let factor = if is_pressed { PRESSED } else { CONTACT };
            let compliance = soft(factor, touch.response, touch.mobility);
            let mut grip = Grip { slip: [0.0; 2], rubs: true, start: 0.0, compliance };
            if is_pressed {
                grip.slip = touch.slip(&motion.velocity);
                for (slip, along) in grip.slip.iter_mut().zip(moving.creeps[place].along) {
                    *slip += along / h;
                }
                (grip.rubs, grip.start) = (holds(motion, place), motion.impulses[place][0]);
            }
            let compliance =
                if touch.soft.is_some() { soft(SPRING, touch.response, touch.mobility) } else { compliance };
            self.touches.push((Demand { place, offset: open / h, compliance }, grip));
        }
        for (&place, row) in island.rows.iter().zip(scene.rows(island)) {
            if !moving.asks(row) {
                continue;
            }
            let mut open = row.gap + h * dot(&row.jacobian, &motion.velocity);
            if row.kind == Kind::Equality {
                let most = h * scale.speed;
                if open.abs() <= most {
                    let most = most * lever(row.response, row.mobility).sqrt();
                    open = open.clamp(-most, most);
                }
            } else if open < 0.0 {
                open = (SHARE * open).max(-h * RECOVERY * scale.speed * lever(row.response, row.mobility));
            }
            if locks.hold(Name::Row(row.key)) && (row.kind == Kind::Equality || open < 0.0) {
                open = 0.0;
            }
            let compliance = soft(ROW, row.response, row.mobility);
            self.rows.push(Demand { place, offset: open / h, compliance });
        }
        self.slow_down(scene, moving);
    }

    /// Takes what is far open a share of its way, as much as joints may move in the step: that of damped least squares.
    fn slow_down(&mut self, scene: &Scene<'_>, moving: &Moving<'_>) {
        let Scale { length, speed } = moving.scale;
        let is_equality = |demand: &Demand| scene.rows[demand.place].kind == Kind::Equality;
        let is_far = |demand: &Demand| is_equality(demand) && demand.offset.abs() > speed;
        if !self.rows.iter().any(is_far) {
            return;
        }
        let rows: Vec<_> = self.rows.iter().filter(|&demand| is_equality(demand)).collect();
        let jacobian = |demand: &Demand| &scene.rows[demand.place].jacobian;
        let motions: Vec<_> = rows.iter().map(|demand| scene.inertia.solve(jacobian(demand))).collect();
        let mut system = DMatrix::from_fn(rows.len(), rows.len(), |i, j| dot(jacobian(rows[i]), &motions[j]));
        rows.iter().enumerate().for_each(|(i, demand)| system[(i, i)] += demand.compliance);
        let asked = DVector::from_iterator(rows.len(), rows.iter().map(|demand| demand.offset));
        let Some(factor) = system.cholesky() else {
            return;
        };
        let impulses = factor.solve(&asked);
        let fastest = moving.turns.iter().enumerate().map(|(dof, &turns)| {
            let z: f64 = motions.iter().zip(&impulses).map(|(motion, impulse)| motion[dof] * impulse).sum();
            z.abs() * if turns { length / TURN } else { 1.0 }
        });
        // Less where joints hardly move it, as of an arm that is stretched.
        let all: f64 = rows.iter().map(|demand| demand.offset.powi(2) / demand.compliance).sum();
        let gain = 1.0 - impulses.dot(&asked) / all;
        let share = (speed / fastest.fold(0.0, f64::max)).min(1.0) * gain;
        let equality = |demand: &Demand| scene.rows[demand.place].equality();
        let far: Vec<_> = self.rows.iter().filter(|demand| is_far(demand)).map(equality).collect();
        let rows = self.rows.iter_mut().filter(|demand| far.contains(&equality(demand)));
        rows.for_each(|demand| demand.offset *= share);
    }
}

/// Does something overlap, or is something open, by more than what is left, and is not locked?
pub(super) fn is_needed(scene: &Scene<'_>, island: &Island, moving: &Moving<'_>, locks: &Locks) -> bool {
    let [left, slop] = [LEFT, CLOSED].map(|share| share * moving.scale.length);
    let after = |gap: f64, row: &[f64]| gap + scene.h * dot(row, &moving.motion.velocity);
    let (mut touches, rows) = (scene.touches(island), scene.rows(island));
    moving.creeps_in(island)
        || touches.any(|touch| {
            touch.soft.is_none()
                && after(touch.gap, touch.normal_row()) < -slop
                && !locks.hold(Name::Touch(touch.key))
        })
        || rows.filter(|row| moving.asks(row)).any(|row| {
            let after = after(row.gap, &row.jacobian);
            (after < -left || row.kind == Kind::Equality && after > left) && !locks.hold(Name::Row(row.key))
        })
}
