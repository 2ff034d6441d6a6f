//! The recipe of the guide on random grasps, beside the recipe that the guide once had: how often a tick is solved, and how far its forces
//! are from the least ones.

use crate::programme::least;
use crate::recipe::{Hand, MU, RECIPE, Recipe, WEIGHTS};
use nalgebra::{SVector, Vector3, vector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::error::Error;
use std::time::Instant;

/// Velocities: of the thing, and of two joints of each of three fingers.
const N: usize = 12;
const GRASPS: u32 = 24;
/// Ticks with a load, which then grows by 30 % and falls to 70 %.
const TICKS: u32 = 100;
const LOADS: [f64; 3] = [1.0, 1.3, 0.7];

/// Numbers of which quantiles are asked for.
#[derive(Default)]
struct Numbers(Vec<f64>);

impl Numbers {
    /// Median, 95 % and largest.
    fn quantiles(&mut self) -> [f64; 3] {
        self.0.sort_by(f64::total_cmp);
        [50, 95, 100].map(|percent| self.0[(self.0.len() - 1) * percent / 100])
    }
}

#[derive(Default)]
struct Outcome {
    ticks: usize,
    unsolved: usize,
    works: Numbers,
    /// µs of a tick, filling included.
    times: Numbers,
    /// Of the second half of the ticks of each wrench: size of the forces over that of the least ones, and what the wrench is missed by,
    /// over its size.
    sizes: Numbers,
    missed: Numbers,
    /// For each load, the tick whose forces are within 5 % of the least ones.
    settled: [Numbers; 3],
    /// What the least forces miss it by.
    missed_by_least: Numbers,
    /// Largest share of its friction that a contact takes, and largest torque (N·m).
    friction: f64,
    torque: f64,
}

/// Size of a wrench, weighted.
fn size(wrench: &SVector<f64, 6>) -> f64 {
    wrench.component_mul(&SVector::from(WEIGHTS)).dot(wrench).sqrt()
}

/// Grasps of so many contacts, with a noise of 0.5 % on the wrench. Cold ticks have the last forces, but not the last solve.
fn run(contacts: u32, recipe: &Recipe, is_cold: bool) -> Result<Outcome, Box<dyn Error>> {
    let mut outcome = Outcome::default();
    for grasp in 0..GRASPS {
        let mut random = Pcg64Mcg::seed_from_u64(u64::from(1_000 * contacts + grasp));
        let mut uniform = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let mut hand = Hand::<f32, N>::random(contacts, &mut uniform)?;
        let [x, y, roll, pitch] = [0.3, 0.3, 5e-3, 5e-3].map(|size| uniform(-size, size));
        let first = vector![x, y, uniform(2.0, 6.0), roll, pitch, uniform(-0.01, 0.01)];
        for (change, load) in LOADS.map(|share| first * share).into_iter().enumerate() {
            // Forces that are drawn to a share of themselves come to rest at the least ones at the price of what is left.
            let price = recipe.alpha * (1.0 - recipe.drawn);
            let best =
                least(&hand.jacobians().collect::<Vec<_>>(), &load, MU / recipe.reserve, price, recipe.limit);
            let forces = best.as_slice().chunks_exact(3).map(Vector3::from_column_slice);
            let effect = hand.effect(forces);
            outcome.missed_by_least.0.push(size(&(effect.fixed_rows::<6>(0) - load)) / size(&load));
            let mut settled = TICKS;
            for tick in 0..TICKS {
                let wrench = load.map(|entry| entry * (1.0 + uniform(-5e-3, 5e-3)));
                if is_cold {
                    hand.reset();
                }
                let start = Instant::now();
                let solution = hand.share(&wrench, recipe)?;
                outcome.times.0.push(start.elapsed().as_secs_f64() * 1e6);
                outcome.ticks += 1;
                outcome.unsolved += usize::from(!solution.is_solved());
                outcome.works.0.push(f64::from(u32::try_from(solution.work.total())?));
                let forces: Vec<Vector3<f64>> = hand.forces.iter().map(|force| force.cast()).collect();
                let effect = hand.effect(forces.iter().copied());
                outcome.torque =
                    effect.iter().skip(6).fold(outcome.torque, |most, torque| most.max(torque.abs()));
                for force in &forces {
                    outcome.friction =
                        outcome.friction.max(force[1].hypot(force[2]) / (MU * force[0]).max(1e-9));
                }
                let best_forces = best.as_slice().chunks_exact(3).map(Vector3::from_column_slice);
                let off: f64 =
                    forces.iter().zip(best_forces).map(|(force, best)| (force - best).norm_squared()).sum();
                if off.sqrt() < 0.05 * best.norm() {
                    settled = settled.min(tick + 1);
                }
                if tick >= TICKS / 2 {
                    let square: f64 = forces.iter().map(Vector3::norm_squared).sum();
                    outcome.sizes.0.push(square.sqrt() / best.norm());
                    outcome.missed.0.push(size(&(effect.fixed_rows::<6>(0) - wrench)) / size(&wrench));
                }
            }
            outcome.settled[change].0.push(f64::from(settled));
        }
    }
    Ok(outcome)
}

/// Prints a line for each recipe and number of contacts.
pub(crate) fn compare() -> Result<(), Box<dyn Error>> {
    let former = Recipe { alpha: 1e-3, drawn: 0.0, reserve: 1.0, enough: 1e-2, ..RECIPE };
    let eager = Recipe { budget: 200, ..RECIPE };
    let limited = |limit| Recipe { limit: Some(limit), drawn: 0.9, ..eager };
    println!(
        "contacts, recipe: unsolved; size: 50, 95, 100 %; ticks to settle: at first, risen, fallen (95 %); work: 50, 95, 100 %;"
    );
    println!(
        "    wrench missed: 50, 95, 100 %, by the least forces; use of friction; torque in N·m; µs: 50, 95 %"
    );
    for (name, recipe, is_cold) in [
        ("α 0.001, if usable", former, false),
        ("α 0.1", Recipe { drawn: 0.0, reserve: 1.0, ..RECIPE }, false),
        ("drawn to 0.99", Recipe { reserve: 1.0, ..RECIPE }, false),
        ("drawn to 0.99, mu / 1.5", RECIPE, false),
        ("the same, cold", RECIPE, true),
        ("cold, budget 200", eager, true),
        ("drawn to 0.9", Recipe { drawn: 0.9, ..RECIPE }, false),
        ("1 N·m", limited(1.0), false),
        ("0.3 N·m", limited(0.3), false),
        ("0.15 N·m", limited(0.15), false),
        ("0.3 N·m, budget 100", Recipe { budget: 100, ..limited(0.3) }, false),
        ("0.3 N·m, joints of 1e-3", Recipe { joint: 1e-3, ..limited(0.3) }, false),
        ("1 N·m, drawn to 0.99", Recipe { drawn: 0.99, ..limited(1.0) }, false),
    ] {
        for contacts in [4, 6, 8] {
            let mut outcome = run(contacts, &recipe, is_cold)?;
            let Outcome { ticks, unsolved, friction, torque, .. } = outcome;
            let [sizes, works] = [&mut outcome.sizes, &mut outcome.works].map(Numbers::quantiles);
            let missed = [&mut outcome.missed, &mut outcome.missed_by_least].map(Numbers::quantiles);
            let settled = outcome.settled.each_mut().map(|settled| settled.quantiles()[1]);
            let [median, most, _] = outcome.times.quantiles();
            println!(
                "{contacts} {name:24} {unsolved:4} of {ticks}; {sizes:5.2?}; {settled:3.0?}; {works:3.0?}; {missed:.4?}; {friction:.2}; {torque:.4}; {median:.1}, {most:.1}"
            );
        }
    }
    println!();
    Ok(())
}
