//! The position pass: what overlaps, or is open, is taken back by a motion that is not kept as a velocity.
//!
//! The same kernel solves `M' z = Hᵀ r'` with friction and a little compliance, from nothing; positions then move by `h (v + z)`.

use super::engines::{Engines, Pass};
use super::islands::Island;
use super::pack::Pack;
use super::rows::Kind;
use super::touch::dot;
use super::velocity::{Motion, Scene};
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
/// Errors in lengths that are left as they are, over the model's own length.
const LEFT: f64 = 1e-9;
/// A correction is solved to this error, for this much work, and used up to that one.
const TOLERANCE: f64 = 1e-4;
const BUDGET: usize = 1_000;
const USABLE: f64 = 1e-2;

#[derive(Default)]
pub(super) struct PositionPass {
    pack: Pack,
    answer: Answer<f64>,
    scratch: Vec<f64>,
}

/// The model's own length (m) and speed (m/s).
#[derive(Clone, Copy)]
pub(super) struct Scale {
    pub(super) length: f64,
    pub(super) speed: f64,
}

impl PositionPass {
    /// Adds an island's correction to `correction`; in the first round of a step from nothing.
    pub(super) fn solve(
        &mut self,
        scene: &Scene<'_>,
        island: &Island,
        engines: &mut Engines,
        (motion, scale): (&Motion, Scale),
        is_first: bool,
        correction: &mut [f64],
    ) {
        if !is_needed(scene, island, motion, LEFT * scale.length) {
            return;
        }
        let h = scene.h;
        self.pack.begin(scene.inertia, &island.dofs, 3, None);
        let mut compliance = (Vec::new(), Vec::new());
        let soft =
            |factor: f64, response: f64, mobility: f64| factor * response.max(LEAST * mobility);
        let lever = |response: f64, mobility: f64| {
            if mobility > 0.0 {
                (response / mobility).min(1.0)
            } else {
                1.0
            }
        };
        for touch in island.touches.iter().map(|&place| &scene.touches[place]) {
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
            compliance
                .0
                .push([soft(CONTACT, touch.response, touch.mobility); 2]);
            self.pack
                .contact(touch, [open / h, 0.0, 0.0, 0.0, 0.0, 0.0]);
        }
        for row in island.rows.iter().map(|&place| &scene.rows[place]) {
            let response = scene.inertia.response(&row.jacobian, &mut self.scratch);
            if row.kind == Kind::Friction || response < NO_LEVER * row.mobility {
                continue;
            }
            let mut open = row.gap + h * dot(&row.jacobian, &motion.velocity);
            let lever = lever(response, row.mobility);
            if row.kind == Kind::Equality {
                let most = h * scale.speed * lever.sqrt();
                open = open.clamp(-most, most);
            } else if open < 0.0 {
                open = (SHARE * open).max(-h * RECOVERY * scale.speed * lever);
            }
            compliance.1.push(soft(ROW, response, row.mobility));
            self.pack.row(row, open / h);
        }
        self.pack
            .soften(compliance.0.into_iter(), compliance.1.into_iter());
        self.pack.reduce();
        let settings = Settings {
            tolerance: TOLERANCE,
            budget: BUDGET,
            model: Law::Coulomb,
        };
        for model in [Law::Coulomb, Law::ConvexRelaxation] {
            let settings = Settings { model, ..settings };
            let name = (island.dofs[0], Pass::Position);
            let outcome = engines.solve(
                name,
                &self.pack.problem(),
                &settings,
                is_first,
                &mut self.answer,
            );
            if outcome.is_some_and(|outcome| outcome.error <= USABLE)
                && self.answer.v.iter().all(|z| z.is_finite())
            {
                self.pack.expand(&mut self.answer);
                island
                    .dofs
                    .iter()
                    .zip(&self.answer.v)
                    .for_each(|(&dof, &z)| correction[dof] = z);
                return;
            }
        }
    }
}

/// Does something overlap, or is something open, by more than what is left?
fn is_needed(scene: &Scene<'_>, island: &Island, motion: &Motion, left: f64) -> bool {
    let after = |gap: f64, row: &[f64]| gap + scene.h * dot(row, &motion.velocity);
    let mut touches = island.touches.iter().map(|&place| &scene.touches[place]);
    let mut rows = island.rows.iter().map(|&place| &scene.rows[place]);
    touches.any(|touch| after(touch.gap, touch.normal_row()) < -left)
        || rows.any(|row| match row.kind {
            Kind::Equality => after(row.gap, &row.jacobian).abs() > left,
            Kind::Limit => after(row.gap, &row.jacobian) < -left,
            Kind::Friction => false,
        })
}
