//! The position pass: what overlaps, or is open, is taken back by a motion that is not kept as a velocity.
//!
//! `M' z = Hᵀ r'` is solved with friction and a little compliance, from nothing: of many contacts by sweeps if these converge, else by
//! the same kernel. Positions then move by `h (v + z)`.

use super::engines::{Engines, Pass};
use super::islands::Island;
use super::pack::Pack;
use super::rows::{Kind, Row};
use super::settle::Settler;
use super::touch::dot;
use super::velocity::{ASK_AGAIN, Motion, Scene};
use nalgebra::{DMatrix, DVector};
use std::collections::HashMap;
use stiction::{Model as Law, Settings};
use stiction_kernels::problem::Answer;

/// The share of an overlap that is taken back in a step; of an equality, and of what this step found, all.
const SHARE: f64 = 0.8;
/// Compliance of contacts and of other rows, over what moves them.
const CONTACT: f64 = 1e-4;
const ROW: f64 = 0.02;
/// A row is moved as little as if it were at least this share of a free point.
const LEAST: f64 = 1e-2;
/// Rows that move less than this share of a free point have no lever: they are left as they are.
const NO_LEVER: f64 = 1e-6;
/// The fastest recovery of an overlap, over the model's own speed.
const RECOVERY: f64 = 0.2;
/// How fast joints turn to close what is far open, over the model's speed over its length.
const TURN: f64 = 4.0;
/// Errors in lengths that are left as they are, over the model's own length.
const LEFT: f64 = 1e-9;
/// A correction is solved to this error, for this much work, and used up to that one.
const TOLERANCE: f64 = 1e-4;
const BUDGET: usize = 1_000;
const USABLE: f64 = 1e-2;
/// More contacts and rows than so many are swept first.
const FEW: usize = 8;
/// An island that does less than this share of what is asked is locked: it is asked again after [`ASK_AGAIN`] steps.
const LITTLE: f64 = 0.1;

#[derive(Default)]
pub(super) struct PositionPass {
    pack: Pack,
    answer: Answer<f64>,
    settler: Settler,
    asked: Asked,
    /// Islands that hardly gave way, by their first velocities, and for how many steps they are left as they are.
    locked: HashMap<usize, u32>,
}

/// What is asked of an island.
#[derive(Default)]
struct Asked {
    touches: Vec<Demand>,
    rows: Vec<Demand>,
    scratch: Vec<f64>,
}

/// What is asked of a contact or a row.
struct Demand {
    /// Its place among those of the scene.
    place: usize,
    /// The velocity that is left to it.
    offset: f64,
    compliance: f64,
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
    pub(super) scale: Scale,
    /// Is a velocity one of turning?
    pub(super) turns: &'a [bool],
    /// Is something blocked that a body of motion capture leads? Then its spring pulls, and nothing else.
    pub(super) is_blocked: bool,
}

impl Moving<'_> {
    /// Is a row asked to close?
    fn asks(&self, row: &Row) -> bool {
        row.kind != Kind::Friction && !(self.is_blocked && row.spring.is_some())
    }
}

impl PositionPass {
    pub(super) fn reset(&mut self) {
        self.locked.clear();
    }

    /// Adds an island's correction to `correction`; in the first round of a step from nothing.
    pub(super) fn solve(
        &mut self,
        scene: &Scene<'_>,
        island: &Island,
        engines: &mut Engines,
        moving: &Moving<'_>,
        is_first: bool,
        correction: &mut [f64],
    ) {
        if !is_needed(scene, island, moving) || is_first && self.is_locked(scene, island) {
            return;
        }
        self.asked.list(scene, island, moving);
        let is_found = self.sweep(scene, island, correction)
            || self.solve_exactly(scene, island, engines, is_first, correction);
        if is_found && self.asked.gives_way(scene, correction) {
            self.locked.remove(&island.dofs[0]);
        } else {
            self.locked.insert(island.dofs[0], ASK_AGAIN - 1);
        }
    }

    /// Is an island locked, and left as it is in this step? Not if something moves it from outside.
    fn is_locked(&mut self, scene: &Scene<'_>, island: &Island) -> bool {
        let Some(steps) = self.locked.remove(&island.dofs[0]) else {
            return false;
        };
        let is_driven = scene.touches(island).any(|touch| touch.is_driven);
        if steps == 0 || is_driven || scene.is_moved(island) {
            return false;
        }
        self.locked.insert(island.dofs[0], steps - 1);
        true
    }

    /// Sweeps over what is asked, if it is much; `false` if that finds nothing.
    fn sweep(&mut self, scene: &Scene<'_>, island: &Island, correction: &mut [f64]) -> bool {
        let Asked { touches, rows, .. } = &self.asked;
        if touches.len() + rows.len() <= FEW {
            return false;
        }
        let (settler, coordinates) = (&mut self.settler, (scene.inertia, &island.dofs[..]));
        settler.begin(island.dofs.len());
        for demand in touches {
            let touch = &scene.touches[demand.place];
            settler.contact(coordinates, touch, (demand.offset, demand.compliance));
        }
        for demand in rows {
            let row = &scene.rows[demand.place];
            settler.row(coordinates, row, (demand.offset, demand.compliance));
        }
        let is_found = settler.sweep(TOLERANCE);
        if is_found {
            settler.write(coordinates, correction);
        }
        is_found
    }

    /// Solves what is asked by a kernel; `false` if that finds nothing.
    fn solve_exactly(
        &mut self,
        scene: &Scene<'_>,
        island: &Island,
        engines: &mut Engines,
        is_first: bool,
        correction: &mut [f64],
    ) -> bool {
        let Asked { touches, rows, .. } = &self.asked;
        self.pack.begin(scene.inertia, &island.dofs, 3, None);
        for demand in touches {
            let offset = [demand.offset, 0.0, 0.0, 0.0, 0.0, 0.0];
            self.pack.contact(&scene.touches[demand.place], offset);
        }
        for demand in rows {
            self.pack.row(&scene.rows[demand.place], demand.offset);
        }
        self.pack.soften(
            touches.iter().map(|demand| [demand.compliance; 2]),
            rows.iter().map(|demand| demand.compliance),
        );
        self.pack.reduce(scene.inertia);
        for model in [Law::Coulomb, Law::ConvexRelaxation] {
            let settings = Settings {
                tolerance: TOLERANCE,
                budget: BUDGET,
                model,
            };
            let name = (island.dofs[0], Pass::Position);
            let problem = self.pack.problem();
            let outcome = engines.solve(name, &problem, &settings, is_first, &mut self.answer);
            if outcome.is_some_and(|outcome| outcome.error <= USABLE)
                && self.answer.v.iter().all(|z| z.is_finite())
            {
                self.pack.expand(scene.inertia, &mut self.answer);
                island
                    .dofs
                    .iter()
                    .zip(&self.answer.v)
                    .for_each(|(&dof, &z)| correction[dof] = z);
                return true;
            }
        }
        false
    }
}

impl Asked {
    /// Does a correction do more than a little of it?
    fn gives_way(&self, scene: &Scene<'_>, correction: &[f64]) -> bool {
        let (mut asked, mut done) = (0.0, 0.0);
        let mut add = |row: &[f64], offset: f64, is_equality: bool| {
            let wrong = |speed: f64| {
                if is_equality {
                    speed.abs()
                } else {
                    (-speed).max(0.0)
                }
            };
            asked += wrong(offset);
            done += wrong(offset) - wrong(offset + dot(row, correction));
        };
        for demand in &self.touches {
            let row = scene.touches[demand.place].normal_row();
            add(row, demand.offset, false);
        }
        for demand in &self.rows {
            let row = &scene.rows[demand.place];
            add(&row.jacobian, demand.offset, row.kind == Kind::Equality);
        }
        done > LITTLE * asked
    }

    /// Lists what is asked at the end of a motion.
    fn list(&mut self, scene: &Scene<'_>, island: &Island, moving: &Moving<'_>) {
        let (h, Moving { motion, scale, .. }) = (scene.h, moving);
        self.touches.clear();
        self.rows.clear();
        let soft =
            |factor: f64, response: f64, mobility: f64| factor * response.max(LEAST * mobility);
        let lever = |response: f64, mobility: f64| {
            if mobility > 0.0 {
                (response / mobility).min(1.0)
            } else {
                1.0
            }
        };
        for (&place, touch) in island.touches.iter().zip(scene.touches(island)) {
            if touch.response < NO_LEVER * touch.mobility {
                continue;
            }
            let mut open = touch.gap + h * dot(touch.normal_row(), &motion.velocity);
            if open < 0.0 {
                let fastest = if touch.is_driven {
                    scale.speed
                } else {
                    RECOVERY * scale.speed
                };
                // What is from the step itself is taken back in it.
                let old = (-open - touch.curve).max(0.0);
                let most = h * fastest * lever(touch.response, touch.mobility);
                open = (open + old) - (SHARE * old).min(most);
            }
            self.touches.push(Demand {
                place,
                offset: open / h,
                compliance: soft(CONTACT, touch.response, touch.mobility),
            });
        }
        for (&place, row) in island.rows.iter().zip(scene.rows(island)) {
            let response = scene.inertia.response(&row.jacobian, &mut self.scratch);
            if !moving.asks(row) || response < NO_LEVER * row.mobility {
                continue;
            }
            let mut open = row.gap + h * dot(&row.jacobian, &motion.velocity);
            if row.kind == Kind::Equality {
                let most = h * scale.speed;
                if open.abs() <= most {
                    let most = most * lever(response, row.mobility).sqrt();
                    open = open.clamp(-most, most);
                }
            } else if open < 0.0 {
                open =
                    (SHARE * open).max(-h * RECOVERY * scale.speed * lever(response, row.mobility));
            }
            self.rows.push(Demand {
                place,
                offset: open / h,
                compliance: soft(ROW, response, row.mobility),
            });
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
        let rows: Vec<_> = self
            .rows
            .iter()
            .filter(|&demand| is_equality(demand))
            .collect();
        let jacobian = |demand: &Demand| &scene.rows[demand.place].jacobian;
        let motions: Vec<_> = rows
            .iter()
            .map(|demand| scene.inertia.solve(jacobian(demand)))
            .collect();
        let mut system = DMatrix::from_fn(rows.len(), rows.len(), |i, j| {
            dot(jacobian(rows[i]), &motions[j])
        });
        rows.iter()
            .enumerate()
            .for_each(|(i, demand)| system[(i, i)] += demand.compliance);
        let asked = DVector::from_iterator(rows.len(), rows.iter().map(|demand| demand.offset));
        let Some(factor) = system.cholesky() else {
            return;
        };
        let impulses = factor.solve(&asked);
        let fastest = moving.turns.iter().enumerate().map(|(dof, &turns)| {
            let z: f64 = motions
                .iter()
                .zip(&impulses)
                .map(|(motion, impulse)| motion[dof] * impulse)
                .sum();
            z.abs() * if turns { length / TURN } else { 1.0 }
        });
        // Less where joints hardly move it, as of an arm that is stretched.
        let all: f64 = rows
            .iter()
            .map(|demand| demand.offset.powi(2) / demand.compliance)
            .sum();
        let gain = 1.0 - impulses.dot(&asked) / all;
        let share = (speed / fastest.fold(0.0, f64::max)).min(1.0) * gain;
        let equality = |demand: &Demand| scene.rows[demand.place].equality();
        let far: Vec<_> = self
            .rows
            .iter()
            .filter(|demand| is_far(demand))
            .map(equality)
            .collect();
        let rows = self
            .rows
            .iter_mut()
            .filter(|demand| far.contains(&equality(demand)));
        rows.for_each(|demand| demand.offset *= share);
    }
}

/// Does something overlap, or is something open, by more than what is left?
fn is_needed(scene: &Scene<'_>, island: &Island, moving: &Moving<'_>) -> bool {
    let left = LEFT * moving.scale.length;
    let after = |gap: f64, row: &[f64]| gap + scene.h * dot(row, &moving.motion.velocity);
    let (mut touches, rows) = (scene.touches(island), scene.rows(island));
    touches.any(|touch| after(touch.gap, touch.normal_row()) < -left)
        || rows.filter(|row| moving.asks(row)).any(|row| {
            let after = after(row.gap, &row.jacobian);
            after < -left || row.kind == Kind::Equality && after > left
        })
}
