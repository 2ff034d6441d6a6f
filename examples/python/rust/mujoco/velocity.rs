//! The velocity pass: the exact law without recovery, and what gives way where it has no answer.
//!
//! Overlaps ask for no speed here, so without motion from outside standing still is allowed: nothing contradicts, and no overlap
//! becomes momentum.

use super::creep::{SLIP, STICK};
use super::engines::{Ask, Engines, Pass};
use super::inertia::Inertia;
use super::islands::Island;
use super::pack::Pack;
use super::rows::{Kind, Row};
use super::softness::Spring;
use super::sweeps;
use super::touch::{Touch, largest};
use std::collections::{HashMap, HashSet};
use stiction::{Model as Law, Settings, Status, Work};
use stiction_kernels::problem::{Answer, Needs, Outcome};
use stiction_kernels::sizes;

/// A normal row without lever is held as if its bodies were free, by this share of what would move them.
const LEVER: f64 = 1e-5;
/// Compliance over mobility: of what is moved from outside and blocked (its impulse is at most `m v`), and of all, as little as is solved.
const BLOCKED: f64 = 1.0;
const SOFT: [f64; 4] = [1e-2, 1e-4, 1e-6, 1e-8];
/// An answer that is not solved is used up to this error, and up to impulses that change velocities of free bodies by so many times
/// those there are.
const LARGEST_ERROR: f64 = 1e-3;
const LARGEST_CHANGE: f64 = 1e4;
/// What is moved from outside gives way where things would be this many times as fast as it.
const LARGEST_SPEED: f64 = 4.0;
/// In so many steps it is asked once whether what was blocked, or locked, still is.
pub(super) const ASK_AGAIN: u32 = 8;

/// What gives way.
#[derive(Clone, Copy, PartialEq)]
enum Softness {
    Rigid,
    /// What was blocked comes after what leads it.
    Following,
    /// The convex relaxation, whose answer is only where another starts: where all can stay it is that of the law.
    Relaxed,
    Driven,
    All(f64),
}

/// Velocities and impulses of a step.
#[derive(Default)]
pub(super) struct Motion {
    pub(super) velocity: Vec<f64>,
    pub(super) impulses: Vec<[f64; 6]>,
    pub(super) modes: Vec<i8>,
    pub(super) rows: Vec<f64>,
}

/// How the islands of a step ended, at worst.
pub(super) struct Ends {
    pub(super) status: Status,
    pub(super) error: f64,
    pub(super) work: usize,
    pub(super) contradicts: bool,
    pub(super) gave_way: bool,
    /// Is there an island that no compiled size holds?
    pub(super) is_crowded: bool,
}

impl Ends {
    pub(super) const NONE: Self = Self {
        status: Status::Solved,
        error: 0.0,
        work: 0,
        contradicts: false,
        gave_way: false,
        is_crowded: false,
    };

    fn add(&mut self, outcome: &Outcome) {
        self.work += outcome.work.total();
        let error = if outcome.error.is_nan() { f64::INFINITY } else { outcome.error };
        self.error = self.error.max(error);
        if self.status == Status::Solved {
            self.status = outcome.status;
        }
    }
}

/// Solves islands.
#[derive(Default)]
pub(super) struct VelocityPass {
    pack: Pack,
    spare: Answer<f64>,
    /// Islands in which something that is moved from outside is blocked, and for how many steps.
    pub(super) blocked: HashMap<usize, u32>,
    /// Are impulses those at which solves end, and not the least ones?
    pub(super) keeps_impulses: bool,
}

/// What is solved.
pub(super) struct Scene<'a> {
    pub(super) inertia: &'a Inertia,
    pub(super) touches: &'a [Touch],
    pub(super) rows: &'a [Row],
    pub(super) h: f64,
    /// What is open by more than this is not closed in a step (m, rad).
    pub(super) reach: f64,
    /// What is open by no more is closed (m).
    pub(super) closed: f64,
    /// A contact that opens or slips no faster bears as one that sticks (m/s): positions are rounded.
    pub(super) still: f64,
}

impl<'a> Scene<'a> {
    /// The contacts of an island.
    pub(super) fn touches(&self, island: &Island) -> impl Iterator<Item = &'a Touch> {
        island.touches.iter().map(|&place| &self.touches[place])
    }

    /// Its rows.
    pub(super) fn rows(&self, island: &Island) -> impl Iterator<Item = &'a Row> {
        island.rows.iter().map(|&place| &self.rows[place])
    }

    /// Is something open that a body of motion capture leads?
    pub(super) fn is_open(&self, island: &Island) -> bool {
        self.rows(island).any(|row| self.open(row).is_some())
    }

    fn open(&self, row: &Row) -> Option<f64> {
        row.spring.filter(|_| row.gap.abs() > self.reach)
    }

    /// How fast a row is led from outside.
    fn lead(&self, row: &Row) -> f64 {
        let pulled = self.open(row).or(row.soft.map(|_| row_offset(row, self.h)));
        row.outside.abs().max(pulled.map_or(0.0, f64::abs))
    }

    /// Does something move it from outside?
    pub(super) fn is_moved(&self, island: &Island) -> bool {
        self.touches(island).any(Touch::is_moved) || self.rows(island).any(|row| row.outside != 0.0)
    }
}

impl VelocityPass {
    pub(super) fn reset(&mut self) {
        self.blocked.clear();
    }

    /// Is something blocked in an island that a body of motion capture leads?
    pub(super) fn is_blocked(&self, island: &Island) -> bool {
        self.blocked.contains_key(&island.dofs[0])
    }

    /// Solves an island, writes its motion, and says how that ended.
    pub(super) fn solve(
        &mut self,
        scene: &Scene<'_>,
        island: &Island,
        engines: &mut Engines,
        settings: &Settings<f64>,
        motion: &mut Motion,
        ends: &mut Ends,
    ) {
        let name = island.dofs[0];
        let is_moved = scene.is_moved(island);
        self.fill(scene, island);
        self.pack.reduce(scene.inertia);
        let mut found = None;
        let blocked_for =
            self.blocked.remove(&name).filter(|_| is_moved || scene.is_open(island)).map(|steps| steps + 1);
        if blocked_for.is_some_and(|steps| steps % ASK_AGAIN != 0) {
            found = self.attempt(scene, island, engines, settings, Softness::Driven);
            self.blocked.extend(blocked_for.map(|steps| (name, steps)));
        }
        let rigid = if blocked_for.is_some() { Softness::Following } else { Softness::Rigid };
        if found.is_none() {
            found = self.attempt(scene, island, engines, settings, rigid);
            if blocked_for.is_some() && scene.is_open(island) {
                self.blocked.insert(name, ASK_AGAIN - 1);
            }
        }
        ends.is_crowded |= found.is_none() && sizes::index::<f64>(&self.pack.problem().needs()).is_err();
        let is_solved = |(outcome, _): &(Outcome, _)| outcome.status == Status::Solved;
        // From nothing, as the last step may lead astray; then from where the relaxation leads.
        for hint in [None, Some(Softness::Relaxed)] {
            if blocked_for.is_some() || found.as_ref().is_some_and(is_solved) {
                break;
            }
            engines.forget(name);
            if let Some(hint) = hint {
                self.attempt(scene, island, engines, settings, hint);
            }
            let other = self.attempt(scene, island, engines, settings, Softness::Rigid);
            if other.as_ref().is_some_and(is_solved) {
                found = other;
            }
        }
        let is_driven = is_moved || blocked_for.is_some();
        let is_thrown = |found: &(Outcome, Answer<f64>)| is_driven && is_thrown(scene, island, found);
        if !self.is_usable(scene, island, settings, found.as_ref()) || found.as_ref().is_some_and(is_thrown) {
            let contradicts = found.as_ref().is_some_and(|(outcome, _)| has_no_answer(outcome));
            ends.contradicts |= contradicts && blocked_for.is_none();
            engines.forget(name);
            found = None;
            if is_driven {
                found = self.attempt(scene, island, engines, settings, Softness::Driven);
                self.blocked.insert(name, blocked_for.unwrap_or(0));
            }
            if !self.is_usable(scene, island, settings, found.as_ref()) {
                ends.gave_way = true;
                engines.forget(name);
                found = self.give_way(scene, island, engines, settings, contradicts);
                if found.is_none() {
                    engines.forget(name);
                    found = Some(self.sweep(scene, island));
                }
            }
        }
        if let Some((outcome, answer)) = found {
            ends.add(&outcome);
            write(scene, island, &answer, self.pack.dim, motion);
            self.spare = answer;
        }
    }

    /// All gives way: by less each time, from where more has led, as long as that has a usable answer with impulses that may be. What
    /// contradicts itself gives way at any softness.
    fn give_way(
        &mut self,
        scene: &Scene<'_>,
        island: &Island,
        engines: &mut Engines,
        settings: &Settings<f64>,
        contradicts: bool,
    ) -> Option<(Outcome, Answer<f64>)> {
        let mut found: Option<(Outcome, Answer<f64>)> = None;
        let times = if contradicts { 1 } else { SOFT.len() };
        for &soft in SOFT.iter().take(times) {
            let next = self.attempt(scene, island, engines, settings, Softness::All(soft)).filter(|next| {
                let may_be = found.is_none() || self.is_plausible(scene, island, &next.1);
                may_be && self.is_usable(scene, island, settings, Some(next))
            });
            if next.is_none() {
                break;
            }
            found = next;
        }
        found
    }

    fn fill(&mut self, scene: &Scene<'_>, island: &Island) {
        let most = scene.touches(island).map(|touch| touch.dim).max();
        let (n, contacts, rows) = (island.dofs.len(), island.touches.len(), island.rows.len());
        let in_four = Needs { n, dim: 4, contacts, rows, surfaces: true };
        let dim = match most.unwrap_or(0) {
            ..=3 => 3,
            4 if sizes::index::<f64>(&in_four).is_ok() => 4,
            _ => 6,
        };
        self.pack.begin(scene.inertia, &island.dofs, dim, Some(&scene.inertia.impulse));
        for touch in scene.touches(island) {
            self.pack.contact(touch, offset(touch, scene.h), true);
        }
        for row in scene.rows(island) {
            self.pack.row(row);
        }
    }

    /// Says how much gives way, and what is asked of rows.
    fn ask(&mut self, scene: &Scene<'_>, island: &Island, softness: Softness) {
        let touches = scene.touches(island).map(|touch| {
            let soft = softness_of(softness, touch.mobility, touch.is_moved());
            let lever = (LEVER * touch.mobility - touch.response).max(0.0);
            [soft.max(lever) + compliance_of(touch.soft, scene.h), soft]
        });
        let rows = scene.rows(island).map(|row| {
            let offset = match row.spring {
                Some(spring) if pulls(softness) => spring,
                _ => row_offset(row, scene.h),
            };
            let is_led = row.spring.is_some() || row.outside != 0.0;
            let compliance = match row.kind {
                Kind::Friction => 0.0,
                _ => softness_of(softness, row.mobility, is_led) + compliance_of(row.soft, scene.h),
            };
            [offset, compliance]
        });
        self.pack.ask(touches, rows);
    }

    fn attempt(
        &mut self,
        scene: &Scene<'_>,
        island: &Island,
        engines: &mut Engines,
        settings: &Settings<f64>,
        softness: Softness,
    ) -> Option<(Outcome, Answer<f64>)> {
        self.ask(scene, island, softness);
        let name = (island.dofs[0], Pass::Velocity);
        let mut answer = std::mem::take(&mut self.spare);
        let shares = softness == Softness::Rigid && !self.keeps_impulses;
        let least = shares.then(|| sharing_dofs(scene, island));
        let ask = Ask { cold: false, still: scene.still, least };
        let model = if softness == Softness::Relaxed { Law::ConvexRelaxation } else { Law::Coulomb };
        let settings = Settings { model, ..*settings };
        let outcome = engines.solve(name, &self.pack.problem(), &settings, ask, &mut answer)?;
        self.pack.expand(scene.inertia, &mut answer);
        Some((outcome, answer))
    }

    /// All rows soft, by sweeps that always end.
    fn sweep(&mut self, scene: &Scene<'_>, island: &Island) -> (Outcome, Answer<f64>) {
        self.ask(scene, island, Softness::All(SOFT[0]));
        let mut answer = sweeps::sweep(&self.pack.problem());
        self.pack.expand(scene.inertia, &mut answer);
        let work = Work { sweeps: sweeps::SWEEPS, ..Work::default() };
        (Outcome { status: Status::OutOfBudget, error: f64::INFINITY, work }, answer)
    }

    /// May this be applied?
    fn is_usable(
        &self,
        scene: &Scene<'_>,
        island: &Island,
        settings: &Settings<f64>,
        found: Option<&(Outcome, Answer<f64>)>,
    ) -> bool {
        let Some((outcome, answer)) = found else {
            return false;
        };
        let is_finite = answer.v.iter().chain(&answer.r).chain(&answer.rows[0]).all(|x| x.is_finite());
        if is_finite && outcome.status == Status::Solved {
            return true;
        }
        let is_near = outcome.error <= LARGEST_ERROR.max(settings.tolerance); // not a number is not
        if !is_finite || has_no_answer(outcome) || !is_near {
            return false;
        }
        self.is_plausible(scene, island, answer)
    }

    /// Are impulses not far above what there is to stop?
    fn is_plausible(&self, scene: &Scene<'_>, island: &Island, answer: &Answer<f64>) -> bool {
        let speed = speed(scene, island, |row| row.outside.abs());
        let impulses = scene.touches(island).zip(answer.r.chunks_exact(self.pack.dim));
        let change = impulses.map(|(touch, r)| largest(r) * touch.mobility.sqrt()).fold(0.0, f64::max);
        change <= LARGEST_CHANGE * speed || change == 0.0
    }
}

/// The number of velocities between which impulses of an island are shared: 0 if two geoms touch in several places.
fn sharing_dofs(scene: &Scene<'_>, island: &Island) -> usize {
    let mut pairs = HashSet::new();
    let repeats = scene.touches(island).any(|touch| !pairs.insert(touch.face.geoms));
    if repeats { 0 } else { island.dofs.len() }
}

/// Is it proved that the question has no answer?
fn has_no_answer(outcome: &Outcome) -> bool {
    matches!(outcome.status, Status::Infeasible | Status::Jammed)
}

/// Speed in the metric, `√(vᵀ M v)`: what there is without contacts and rows, and that of what moves them from outside.
fn speed(scene: &Scene<'_>, island: &Island, lead: impl Fn(&Row) -> f64) -> f64 {
    let inertia = scene.inertia;
    let energy: f64 = island.dofs.iter().map(|&dof| inertia.impulse[dof] * inertia.velocity[dof]).sum();
    let touches = scene.touches(island).map(|touch| {
        let drive = if touch.soft.is_some() { offset(touch, scene.h) } else { touch.outside };
        (largest(&drive), touch.mobility)
    });
    let rows = scene.rows(island).map(|row| (lead(row), row.mobility));
    let drive = touches.chain(rows).filter(|&(_, mobility)| mobility > 0.0);
    energy.max(0.0).sqrt() + drive.map(|(speed, mobility)| speed / mobility.sqrt()).fold(0.0, f64::max)
}

/// Is an answer much faster than what moves it from outside, as where an arm cannot follow?
fn is_thrown(scene: &Scene<'_>, island: &Island, (_, answer): &(Outcome, Answer<f64>)) -> bool {
    let moved = |(&i, v): (&usize, &f64)| {
        let row = island.dofs.iter().zip(&answer.v).map(|(&j, w)| scene.inertia.entry(i, j) * w);
        v * row.sum::<f64>()
    };
    let energy: f64 = island.dofs.iter().zip(&answer.v).map(moved).sum();
    energy.sqrt() > LARGEST_SPEED * speed(scene, island, |row| scene.lead(row))
}

/// Does what is blocked pull by its own law?
fn pulls(softness: Softness) -> bool {
    matches!(softness, Softness::Following | Softness::Driven | Softness::All(_))
}

fn softness_of(softness: Softness, mobility: f64, is_moved: bool) -> f64 {
    match softness {
        Softness::Driven if is_moved => BLOCKED * mobility,
        Softness::All(soft) => soft * mobility,
        Softness::Rigid | Softness::Relaxed | Softness::Following | Softness::Driven => 0.0,
    }
}

/// What the user has asked for (1/kg).
fn compliance_of(soft: Option<Spring>, h: f64) -> f64 {
    soft.map_or(0.0, |spring| spring.compliance(h))
}

/// Velocities that close a gap in the step, and those of surfaces; an overlap asks for what comes from outside alone,
/// or for what its spring does.
fn offset(touch: &Touch, h: f64) -> [f64; 6] {
    let mut offset = touch.outside;
    for (offset, speed) in offset[1..].iter_mut().zip(touch.surface) {
        *offset += speed;
    }
    offset[0] = match touch.soft {
        Some(spring) if touch.gap < 0.0 => spring.offset(touch.gap, touch.outside[0], h),
        _ => closing(touch.gap, touch.outside[0], h),
    };
    offset
}

fn closing(gap: f64, outside: f64, h: f64) -> f64 {
    if gap >= 0.0 { gap / h } else { (gap / h).max(outside.min(0.0)) }
}

fn row_offset(row: &Row, h: f64) -> f64 {
    match row.kind {
        Kind::Equality => row.soft.map_or(row.outside, |spring| spring.offset(row.gap, row.outside, h)),
        Kind::Friction => 0.0,
        Kind::Limit => closing(row.gap, row.outside, h),
    }
}

fn write(scene: &Scene<'_>, island: &Island, answer: &Answer<f64>, dim: usize, motion: &mut Motion) {
    for (&dof, &v) in island.dofs.iter().zip(&answer.v) {
        motion.velocity[dof] = v;
    }
    for (i, (&place, r)) in island.touches.iter().zip(answer.r.chunks_exact(dim)).enumerate() {
        motion.impulses[place][..dim].copy_from_slice(r);
        motion.modes[place] = answer.modes[i];
        // Corners that have sagged by different lengths slip a little as what stands on them tilts.
        let touch = &scene.touches[place];
        if answer.modes[i] == SLIP
            && touch.soft.is_some()
            && largest(&touch.slip(&motion.velocity)) < scene.closed / scene.h
        {
            motion.modes[place] = STICK;
        }
    }
    for (&place, &impulse) in island.rows.iter().zip(&answer.rows[0]) {
        motion.rows[place] = impulse;
    }
}
