//! Whether bodies at rest stay there under a constant load that friction can hold, and leave under one that it cannot.
//!
//! Coulomb's law often has several solutions: one at rest, one that slides. This program draws bodies of seven kinds, each with
//! a constant load inside of its friction cones, steps them for four seconds with a warm start, and counts how many slide off
//! and when. Clarabel says how much friction can hold.
//!
//! `cargo run --release -p rest`; `--critical` loads each body near the largest load that friction holds; `--nudge` prints the
//! forces of a box on a slope before and after a nudge; `--write FILE` writes the bodies that `tests/rest_kept.rs` reads.

#![allow(clippy::cast_precision_loss)] // counts are small

mod body;
mod draw;
mod file;
mod limit;
mod nudge;
mod run;
mod table;

use body::{Body, Kind};
use clap::Parser;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};
use run::{Outcome, Plan, SETTINGS};
use std::path::PathBuf;

/// Step bodies at rest under constant loads and count those that slide off.
#[derive(Parser)]
#[allow(clippy::struct_excessive_bools)] // switches
struct Options {
    /// Bodies to draw, one kind after the other
    #[arg(long, default_value_t = 500)]
    bodies: u64,
    /// Ticks of 2 ms under the load (default 2000, with --critical 1000)
    #[arg(long)]
    ticks: Option<usize>,
    /// Ticks under the weight alone before that; with 0 the first solve, which is cold, has the load
    #[arg(long, default_value_t = 5)]
    alone: usize,
    /// Seed of the draws
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads
    #[arg(long, default_value_t = 2)]
    threads: usize,
    /// Load each body with 0.99 to 1.5 times what full friction can hold
    #[arg(long)]
    critical: bool,
    /// Forget the last solution in each tick
    #[arg(long)]
    cold: bool,
    /// List the bodies that slid
    #[arg(long)]
    list: bool,
    /// Print the forces of a box on a slope before and after a nudge
    #[arg(long)]
    nudge: bool,
    /// Write bodies with their largest loads
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
}

/// Shares of the largest load.
const CRITICAL: [f64; 5] = [0.99, 0.999, 1.001, 1.01, 1.5];

impl Options {
    /// The bodies, whose loads are `share` times what full friction holds, or inside of 0.6 to 0.95 of friction without one.
    fn draw(&self, is_critical: bool) -> Vec<Body> {
        let bodies = (0..self.bodies).into_par_iter();
        bodies.map(|index| draw::body(self.seed, index, is_critical)).collect()
    }

    fn plan(&self) -> Plan {
        let ticks = if self.critical { 1_000 } else { 2_000 };
        Plan { alone: self.alone, loaded: self.ticks.unwrap_or(ticks), is_cold: self.cold }
    }

    fn run(&self, bodies: &[Body], title: &str) {
        let plan = self.plan();
        for setting in SETTINGS {
            let outcomes: Vec<Outcome> =
                bodies.par_iter().map(|body| run::run(body, setting, plan)).collect();
            table::print(title, (setting, plan), bodies, &outcomes);
            if self.list {
                table::list(bodies, &outcomes);
            }
        }
    }
}

fn main() {
    let options = Options::parse();
    rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build_global()
        .expect("no pool was built before");
    if options.nudge {
        nudge::print();
        return;
    }
    if let Some(path) = &options.write {
        let text = file::text(&options.draw(true));
        std::fs::write(path, text).expect("the file can be written");
        return;
    }
    let plan = options.plan();
    let bodies = options.draw(options.critical);
    println!(
        "{} bodies of seed {}, {} ticks under the load after {} under the weight alone{}\n",
        bodies.len(),
        options.seed,
        plan.loaded,
        plan.alone,
        if plan.is_cold { ", each solved cold" } else { "" },
    );
    table::head();
    if options.critical {
        for share in CRITICAL {
            let bodies: Vec<Body> = bodies.iter().map(|body| body.loaded(share)).collect();
            options.run(&bodies, &format!("{share}"));
        }
    } else {
        options.run(&bodies, "0.6 to 0.95");
    }
    println!("\nKinds: {}.", Kind::NAMES.join(", "));
}
