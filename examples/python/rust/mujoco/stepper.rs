//! A step: motion from outside, MuJoCo's first half, the two passes, a look at the end, MuJoCo's second half.

use super::asked::{Moving, Scale};
use super::creep::{self, Creeps};
use super::crowd::{corners, thin};
use super::end::{self, Lookout, Seen, There};
use super::engines::Engines;
use super::facts::{CLOSED, Facts, speed_scale};
use super::ffi::{Data, HFIELD, Model, OwnedContact};
use super::inertia::Inertia;
use super::islands::islands;
use super::outside::Follower;
use super::position::PositionPass;
use super::rows::{self, Row};
use super::softness::Springs;
use super::touch::{Around, Face, Known, Live, NEAR, Taken, Touch, largest};
use super::velocity::{Ends, Motion, Scene, VelocityPass};
use nalgebra::Vector3;
use std::collections::{BTreeMap, HashSet};
use stiction::Settings;

/// Lengths over the model's own: contacts are listed up to this gap; contacts of the last step are listed up to this gap; a position
/// that is written moves something from here on.
const BAND: f64 = 1e-6;
const KEPT: f64 = 1e-3;
const WRITTEN: f64 = 1e-6;
/// What is slower bears as if it stood, over the speed of a fall by the model's length.
const STILL: f64 = 1e-9;
/// A limit is passed from here on (m or rad; over the model's length if that is more than 1 m).
const PASSED: f64 = 1e-12;
/// What rests does so at this depth, over the model's length, so that MuJoCo sees the contact as well (`mj_forward`).
const DEPTH: f64 = 3e-9;
/// What has not borne yet is closed up to this gap, over the model's length: it comes to rest where MuJoCo sees it.
const REACHED: f64 = 1e-9;
/// How often a step is solved again with what was found at its end, and how often contacts found are then taken anew.
const ROUNDS: usize = 12;
const ANEW: usize = 4;
/// Velocities that differ by less than this share of the largest lead to the same place.
const SAME: f64 = 1e-9;

/// How a step ended.
pub(super) struct Report {
    pub(super) ends: Ends,
    /// Did something move farther than contacts are looked for?
    pub(super) is_blind: bool,
}

/// What a step has found that was not there as it began.
#[derive(Default)]
struct Found {
    /// Contacts, by their places in MuJoCo's list.
    contacts: BTreeMap<usize, There>,
    /// By how much contacts are deeper at the end than their rows foresaw (m).
    curves: BTreeMap<usize, f64>,
    /// Limits that may be reached, by their keys.
    limits: HashSet<u32>,
    /// Where the last trial led.
    last: Vec<f64>,
    /// Did something move farther than contacts are looked for?
    is_blind: bool,
}

/// A step as it would be.
struct Trial {
    touches: Vec<Touch>,
    rows: Vec<Row>,
    motion: Motion,
    creeps: Creeps,
    correction: Vec<f64>,
    ends: Ends,
}

pub(super) struct Stepper {
    pub(super) model: Model,
    springs: Springs,
    facts: Facts,
    scratch: Data,
    pub(super) follower: Follower,
    inertia: Inertia,
    pub(super) engines: Engines,
    pub(super) velocity_pass: VelocityPass,
    pub(super) position_pass: PositionPass,
    /// Contacts that take part, by their places in MuJoCo's list.
    taken: BTreeMap<usize, Taken>,
    /// The contacts of the last step.
    pub(super) live: Vec<Live>,
    /// The key of the next contact that is new.
    pub(super) next_key: u32,
    /// What each contact of MuJoCo's list does; -1 of one that took no part.
    pub(super) modes: Vec<i8>,
    /// Was something soft in the last step?
    pub(super) is_soft: bool,
}

impl Stepper {
    pub(super) fn new(model: Model, springs: Springs) -> Self {
        let scratch = Data::scratch(&model);
        Self {
            facts: Facts::new(&model),
            follower: Follower::new(&scratch),
            scratch,
            inertia: Inertia::default(),
            engines: Engines::default(),
            velocity_pass: VelocityPass::default(),
            position_pass: PositionPass::default(),
            taken: BTreeMap::new(),
            live: Vec::new(),
            next_key: 0,
            modes: Vec::new(),
            is_soft: false,
            springs,
            model,
        }
    }

    /// Forgets the last step.
    pub(super) fn reset(&mut self) {
        self.engines.reset();
        self.velocity_pass.reset();
        self.position_pass.reset();
        self.follower.reset();
        self.live.clear();
        self.next_key = 0;
    }

    fn scale(&self) -> Scale {
        Scale { length: self.model.size(), speed: speed_scale(&self.model) }
    }

    /// What comes before controls are set.
    pub(super) fn step1(&mut self, data: &mut Data) {
        self.model.refresh();
        if !self.follower.follows(data) {
            self.reset();
        }
        let length = self.model.size();
        self.follower.look(&self.model, data, WRITTEN * length);
        self.grow_margins(data, BAND * length);
        data.step1(&self.model);
        self.take(data);
    }

    /// Contacts are listed as they touch, limits as far as they may be reached.
    fn grow_margins(&mut self, data: &Data, contacts: f64) {
        let Scale { length, speed } = self.scale();
        let (joint, tendon) = (largest(data.qvel()), largest(data.ten_velocity()));
        // What stands still may start to move.
        let (turn, h) = (joint + (speed / length).max(speed), self.model.step());
        self.model.grow_margins(contacts, [2.0 * h * turn, 2.0 * h * (tendon + speed)]);
    }

    /// Takes what overlaps, and contacts of the last step, also those that have opened a little since; these keep their keys.
    fn take(&mut self, data: &mut Data) {
        let live = std::mem::take(&mut self.live);
        let lookout = lookout(&self.model, &self.facts);
        let mut known = Known::new(&live, data, NEAR * lookout.length);
        let mut taken = Vec::new();
        for (index, contact) in data.contacts().enumerate() {
            if contact.is_excluded() || lookout.is_ghost(data, contact) {
                continue;
            }
            // Suction holds what touches without a load.
            let most = if self.facts.has_suction { lookout.slop } else { -lookout.slop };
            if known.look(index, contact) || contact.gap(lookout.grown) < most {
                taken.push(index);
            }
        }
        if known.lacks_any() {
            self.keep(data, &mut known, &mut taken);
        }
        let pairs = known.pairs();
        self.taken.clear();
        for index in taken {
            match pairs.get(&index) {
                Some(&&Live { key, bears: bore, .. }) => {
                    self.taken.insert(index, Taken { key, bore });
                }
                None => self.take_new(index),
            }
        }
        self.live = live;
    }

    fn take_new(&mut self, index: usize) {
        self.taken.insert(index, Taken { key: self.next_key, bore: false });
        self.next_key = self.next_key.wrapping_add(1);
    }

    /// Lists contacts of the last step that have opened by less than a thousandth of the model's length.
    fn keep(&mut self, data: &mut Data, known: &mut Known<'_>, taken: &mut Vec<usize>) {
        let length = self.model.size();
        let (band, kept) = (BAND * length, KEPT * length);
        self.grow_margins(data, band + kept);
        let scratch = &mut self.scratch;
        scratch.copy_pose(data);
        scratch.kinematics(&self.model);
        scratch.collision(&self.model);
        self.grow_margins(data, band);
        let (model, listed) = (&self.model, taken.len());
        for contact in self.scratch.contacts() {
            let face = Face::of(contact);
            let is_field = |&geom: &usize| model.geom_type()[geom] == HFIELD;
            if contact.is_excluded() || face.geoms.iter().any(is_field) || !known.has(&face) {
                continue;
            }
            let place = Vector3::from(contact.place());
            let is_there = taken.iter().any(|&index| {
                let other = data.contact(index);
                let distance = (Vector3::from(other.place()) - place).norm();
                Face::of(other).is(&face) && distance < NEAR * length
            });
            if is_there {
                continue;
            }
            let own = OwnedContact::new(contact, f64::INFINITY, kept);
            let Some(index) = data.add_contact(model, &own) else {
                break;
            };
            known.look(index, data.contact(index));
            taken.push(index);
        }
        if taken.len() > listed {
            data.make_constraint(&self.model);
        }
    }

    /// From now on impulses are those at which solves end.
    pub(super) fn keep_impulses(&mut self) {
        self.velocity_pass.keeps_impulses = true;
    }

    /// What comes after controls are set.
    ///
    /// # Errors
    /// The mass matrix is not positive definite.
    pub(super) fn step2(
        &mut self,
        data: &mut Data,
        settings: &Settings<f64>,
    ) -> Result<Report, &'static str> {
        let h = self.model.step();
        let (mut found, mut round) = (Found::default(), 0);
        self.push(data, &found)?;
        let rates = rows::equality_rates(&self.model, data, &mut self.scratch, &self.follower.now);
        let trial = loop {
            let trial = self.attempt(data, &rates, &mut found, settings, round == 0);
            round += 1;
            if round > ROUNDS || !self.finds_more(data, &trial, &mut found, round <= ANEW) {
                break trial;
            }
            if self.facts.has_suction {
                self.push(data, &found)?;
            }
        };
        let Trial { touches, rows, motion, creeps, correction, ends } = trial;
        self.write(data, &touches, &rows, &motion);
        self.is_soft =
            touches.iter().any(|touch| touch.soft.is_some()) || rows.iter().any(|row| row.soft.is_some());
        let left = |(place, touch): (usize, &Touch)| {
            let bears = motion.impulses[place][0] > 0.0;
            Live::of(touch, data, creeps.left(data, touch, &motion, place), bears)
        };
        self.live.clear();
        self.live.extend(touches.iter().enumerate().map(left));
        data.sensor_acc(&self.model);
        data.check_acceleration(&self.model);
        data.euler(&self.model);
        if correction.iter().any(|&z| z != 0.0) {
            self.model.integrate(data.qpos_mut(), &correction, h);
        }
        self.follower.keep(data);
        Ok(Report { ends, is_blind: found.is_blind })
    }

    /// Computes all forces but those of constraints. Suction is spread over the corners of what is closed.
    fn push(&mut self, data: &mut Data, found: &Found) -> Result<(), &'static str> {
        if self.facts.has_suction {
            let length = self.model.size();
            let is_closed = |&index: &usize| {
                let has_rows = self.taken.contains_key(&index) && data.contact(index).address().is_some();
                has_rows && gap(&self.model, data, found, index) < CLOSED * length
            };
            let closed = (0..data.contacts().len()).filter(is_closed).collect();
            let corners = corners(data, closed, BAND * length);
            data.transmission(&self.model, |index| corners.contains(&index));
        }
        data.actuation(&self.model);
        data.acceleration(&self.model);
        self.inertia.update(&self.model, data)
    }

    /// Solves the step with what has been found.
    fn attempt(
        &mut self,
        data: &Data,
        rates: &[f64],
        found: &mut Found,
        settings: &Settings<f64>,
        is_first: bool,
    ) -> Trial {
        let around = Around {
            model: &self.model,
            data,
            springs: &self.springs,
            facts: &self.facts,
            follower: &self.follower,
            inertia: &self.inertia,
        };
        let touches = listed(&around, &self.taken, found);
        let rows = rows::list(&around, rates, [data.qvel(), &self.inertia.velocity], &mut found.limits);
        let (h, nv, scale) = (self.model.step(), self.model.sizes.velocities, self.scale());
        let scene = Scene {
            inertia: &self.inertia,
            touches: &touches,
            rows: &rows,
            h,
            reach: h * scale.speed,
            closed: CLOSED * scale.length,
            still: STILL * scale.speed,
        };
        let mut motion = Motion {
            velocity: self.inertia.velocity.clone(),
            impulses: vec![[0.0; 6]; touches.len()],
            modes: vec![-1; touches.len()],
            rows: vec![0.0; rows.len()],
        };
        if is_first {
            self.position_pass.locks.count_down();
        }
        let (mut ends, mut correction) = (Ends::NONE, vec![0.0; nv]);
        let mut islands = islands(&self.inertia, &touches, &rows, nv);
        for island in &mut islands {
            thin(&mut island.touches, &touches, scale.length);
            let engines = &mut self.engines;
            self.velocity_pass.solve(&scene, island, engines, settings, &mut motion, &mut ends);
        }
        let mut creeps = creep::list(&around, (&touches, &self.live), &motion, &mut self.scratch);
        for island in &islands {
            let motion = Moving {
                motion: &motion,
                creeps: &creeps.of_touches,
                scale,
                turns: &self.facts.turns,
                is_blocked: self.velocity_pass.is_blocked(island),
            };
            let correct = &mut correction;
            if self.position_pass.solve(&scene, island, &mut self.engines, &motion, is_first, correct) {
                creeps.taken_back(island);
            }
        }
        Trial { touches, rows, motion, creeps, correction, ends }
    }

    /// Looks at where a trial leads, and adds what it has not seen; `false` if there is nothing.
    fn finds_more(&mut self, data: &mut Data, trial: &Trial, found: &mut Found, takes_anew: bool) -> bool {
        let Trial { motion, correction, touches, creeps, .. } = trial;
        let least = PASSED * self.model.size().max(1.0);
        let limits = &mut found.limits;
        if rows::passed(&self.model, data, &motion.velocity, least, limits) {
            return true;
        }
        let total: Vec<_> = motion.velocity.iter().zip(correction).map(|(v, z)| v + z).collect();
        if is_same(&total, &found.last) {
            return false;
        }
        let lookout = lookout(&self.model, &self.facts);
        let step = end::Step { data, velocity: &total, touches, taken: &self.taken, takes_anew };
        let is_posed = creeps.is_posed && correction.iter().all(|&z| z == 0.0);
        let (seen, is_blind) = lookout.look(&step, &mut self.scratch, is_posed);
        found.is_blind |= is_blind;
        let finds_more = !seen.is_empty();
        found.last = total;
        let mut has_more = false;
        for seen in seen {
            match seen {
                Seen::Listed(index) => self.take_new(index),
                Seen::Deeper(index, by) => *found.curves.entry(index).or_insert(0.0) += by,
                Seen::Again(index, contact, there) => {
                    data.replace_contact(index, &contact);
                    found.contacts.insert(index, there);
                }
                Seen::New(contact, there) => {
                    let Some(index) = data.add_contact(&self.model, &contact) else {
                        break;
                    };
                    self.take_new(index);
                    found.contacts.insert(index, there);
                    has_more = true;
                }
            }
        }
        if has_more {
            data.make_constraint(&self.model);
        }
        finds_more
    }

    /// Writes acceleration and forces.
    fn write(&mut self, data: &mut Data, touches: &[Touch], rows: &[Row], motion: &Motion) {
        let (h, nv) = (self.model.step(), self.model.sizes.velocities);
        let acceleration: Vec<_> =
            motion.velocity.iter().zip(data.qvel()).map(|(after, before)| (after - before) / h).collect();
        data.qacc_mut().copy_from_slice(&acceleration);
        let mut constraint = vec![0.0; nv];
        let mut add = |row: &[f64], force: f64| {
            if force != 0.0 {
                constraint.iter_mut().zip(row).for_each(|(sum, entry)| *sum += force * entry);
            }
        };
        data.efc_force_mut().fill(0.0);
        self.modes.clear();
        self.modes.resize(data.contacts().len(), -1);
        for ((touch, impulse), &mode) in touches.iter().zip(&motion.impulses).zip(&motion.modes) {
            for (i, row) in touch.rows.chunks_exact(nv).enumerate() {
                add(row, impulse[i] / h);
                data.efc_force_mut()[touch.address + i] = impulse[i] / h;
            }
            self.modes[touch.index] = mode;
            data.set_distance(touch.index, touch.gap);
            if touch.is_new {
                let first = touch.address * nv;
                data.efc_j_mut()[first..first + touch.rows.len()].copy_from_slice(&touch.rows);
            }
        }
        for (row, impulse) in rows.iter().zip(&motion.rows) {
            add(&row.jacobian, impulse / h);
            data.efc_force_mut()[row.constraint] = impulse / h;
        }
        data.qfrc_constraint_mut().copy_from_slice(&constraint);
    }
}

fn lookout<'a>(model: &'a Model, facts: &'a Facts) -> Lookout<'a> {
    let length = model.size();
    Lookout { model, facts, grown: BAND * length, slop: CLOSED * length, length }
}

/// Are these velocities those of the round before? Then nothing else will be seen.
fn is_same(now: &[f64], before: &[f64]) -> bool {
    let most = SAME * largest(now);
    !before.is_empty() && now.iter().zip(before).all(|(now, before)| (now - before).abs() <= most)
}

/// The gap of a contact as the step begins (m).
fn gap(model: &Model, data: &Data, found: &Found, index: usize) -> f64 {
    let length = model.size();
    let measured = match found.contacts.get(&index) {
        Some(there) => there.gap_before(model.step()),
        None => data.contact(index).gap(BAND * length) - found.curves.get(&index).copied().unwrap_or(0.0),
    };
    measured + DEPTH * length
}

/// Contacts that take part, as they are now.
fn listed(around: &Around<'_>, taken: &BTreeMap<usize, Taken>, found: &Found) -> Vec<Touch> {
    let mut scratch = Vec::new();
    let touch = |index: usize| {
        let (Taken { key, bore }, there) = (*taken.get(&index)?, found.contacts.get(&index));
        let gap = gap(around.model, around.data, found, index);
        // What is closed has no gap, or its corners would be open by residuals of solves, or by rounding.
        let closed = if bore { CLOSED } else { REACHED };
        let gap = if gap < closed * around.model.size() { gap.min(0.0) } else { gap };
        let rows = there.map(|there| &there.rows[..]);
        let mut touch = Touch::new(around, index, (key, gap), rows, &mut scratch)?;
        touch.is_new = there.is_some();
        touch.curve =
            if touch.is_new { (-gap).max(0.0) } else { found.curves.get(&index).copied().unwrap_or(0.0) };
        Some(touch)
    };
    (0..around.data.contacts().len()).filter_map(touch).collect()
}
