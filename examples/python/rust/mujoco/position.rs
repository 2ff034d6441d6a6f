//! The position pass: what overlaps, or is open, is taken back by a motion that is not kept as a velocity.
//!
//! `M' z = Hᵀ r'` is solved with friction and a little compliance: at once where nothing slips or opens, of many contacts by sweeps if these
//! converge, else by the same kernel.
//! Where a contact sticks, normal impulses are changes of those that press, so that what is held stays held: of the friction that they allow the
//! pass has all, and what slips has none. Else it begins from nothing. Positions then move by `h (v + z)`.

use super::asked::{Asked, Moving, is_needed};
use super::engines::{Ask, Engines, Pass};
use super::facts::has_lever;
use super::islands::Island;
use super::locks::{Locks, Name};
use super::pack::Pack;
use super::settle::Settler;
use super::touch::Touch;
use super::velocity::Scene;
use stiction::{Model as Law, Settings};
use stiction_kernels::problem::Answer;

/// A correction is solved to this error, or to that one if it is a small change of what presses; for this much work; and used up to so
/// many times its error.
const TOLERANCE: f64 = 1e-4;
const PRESSED: f64 = 1e-8;
const BUDGET: usize = 1_000;
const USABLE: f64 = 100.0;
/// Overlaps by more than this share of the model's length may be jams.
const DEEP: f64 = 1e-3;
/// How often what does not give way is left out.
const ATTEMPTS: usize = 3;
/// More contacts and rows than so many are swept first.
const FEW: usize = 8;

#[derive(Default)]
pub(super) struct PositionPass {
    pack: Pack,
    answer: Answer<f64>,
    settler: Settler,
    asked: Asked,
    pub(super) locks: Locks,
}

impl PositionPass {
    pub(super) fn reset(&mut self) {
        self.locks.0.clear();
    }

    /// Adds an island's correction to `correction`; in the first round of a step from nothing. What does not give way is left as it is, and
    /// pushes nothing. `true` if contacts that stick are back where they were.
    pub(super) fn solve(
        &mut self,
        scene: &Scene<'_>,
        island: &Island,
        engines: &mut Engines,
        moving: &Moving<'_>,
        is_first: bool,
        correction: &mut [f64],
    ) -> bool {
        let is_driven = scene.touches(island).any(|touch| touch.is_driven) || scene.is_moved(island);
        for _ in 0..ATTEMPTS {
            if !is_needed(scene, island, moving, &self.locks) {
                return false;
            }
            // What presses in a jam is no measure of friction.
            let is_deep = |touch: &Touch| {
                touch.soft.is_none()
                    && touch.gap < -DEEP * moving.scale.length
                    && has_lever(touch.response, touch.mobility)
                    && !self.locks.hold(Name::Touch(touch.key))
            };
            let may_press = moving.holds_in(island) && !scene.touches(island).any(is_deep);
            let mut find = |is_pressed: bool| {
                self.asked.list(scene, island, moving, &self.locks, is_pressed);
                self.settle(scene, island, correction)
                    || self.solve_exactly(scene, island, engines, is_first, correction)
            };
            let is_pressed = may_press && find(true);
            let is_found = is_pressed || find(false);
            let locks = &mut self.locks;
            let is_refused = !is_driven && self.asked.lock(scene, moving, correction, locks);
            if is_found && !is_refused {
                return is_pressed;
            }
            island.dofs.iter().for_each(|&dof| correction[dof] = 0.0);
            if !is_found {
                break;
            }
        }
        false
    }

    /// Holds what is asked, or sweeps over it if it is much; `false` if that finds nothing.
    fn settle(&mut self, scene: &Scene<'_>, island: &Island, correction: &mut [f64]) -> bool {
        let Asked { touches, rows, is_pressed, .. } = &self.asked;
        let (settler, coordinates) = (&mut self.settler, (scene.inertia, &island.dofs[..]));
        settler.begin(island.dofs.len());
        for (demand, grip) in touches {
            settler.contact(coordinates, &scene.touches[demand.place], demand, grip);
        }
        for demand in rows {
            settler.row(coordinates, &scene.rows[demand.place], demand);
        }
        let is_much = touches.len() + rows.len() > FEW || *is_pressed;
        let is_found = settler.hold() || is_much && settler.sweep(tolerance(*is_pressed));
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
        let Asked { touches, rows, is_pressed, .. } = &self.asked;
        let start = is_pressed.then(|| {
            let mut start = vec![0.0; correction.len()];
            for (demand, grip) in touches.iter().filter(|(_, grip)| grip.start != 0.0) {
                let row = scene.touches[demand.place].normal_row();
                start.iter_mut().zip(row).for_each(|(sum, entry)| *sum -= grip.start * entry);
            }
            start
        });
        self.pack.begin(scene.inertia, &island.dofs, 3, start.as_deref());
        for (demand, grip) in touches {
            let [one, other] = grip.slip;
            let normal = demand.offset - demand.compliance * grip.start;
            let offset = [normal, one, other, 0.0, 0.0, 0.0];
            self.pack.contact(&scene.touches[demand.place], offset, grip.rubs);
        }
        for demand in rows {
            self.pack.row(&scene.rows[demand.place]);
        }
        self.pack.ask(
            touches.iter().map(|(demand, grip)| [demand.compliance, grip.compliance]),
            rows.iter().map(|demand| [demand.offset, demand.compliance]),
        );
        self.pack.reduce(scene.inertia);
        for model in [Law::Coulomb, Law::ConvexRelaxation] {
            let settings = Settings { budget: BUDGET, model, ..Settings::new(tolerance(*is_pressed)) };
            let name = (island.dofs[0], Pass::Position);
            let problem = self.pack.problem();
            let ask = Ask { cold: is_first && !is_pressed, still: f64::INFINITY, least: None };
            let outcome = engines.solve(name, &problem, &settings, ask, &mut self.answer);
            if outcome.is_some_and(|outcome| outcome.error <= USABLE * tolerance(*is_pressed))
                && self.answer.v.iter().all(|z| z.is_finite())
            {
                self.pack.expand(scene.inertia, &mut self.answer);
                island.dofs.iter().zip(&self.answer.v).for_each(|(&dof, &z)| correction[dof] = z);
                return true;
            }
        }
        false
    }
}

fn tolerance(is_pressed: bool) -> f64 {
    if is_pressed { PRESSED } else { TOLERANCE }
}
