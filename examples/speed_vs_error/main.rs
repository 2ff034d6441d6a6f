//! Speed against error: this crate, what a user would write instead, and a conic solver, in one run, on the bundled scenes
//! and on drawn ones.
//!
//! `cargo run --release -p speed_vs_error` measures and writes the report with its pictures to
//! `examples/speed_vs_error/report`; `-- --quick` takes less than a minute and writes to
//! `target/speed_vs_error`. Drawn scenes are of an even seed, which are for deciding: `testbed::generate`.
//!
//! | files | idea |
//! |---|---|
//! | `contestant`, `library`, `sizes` | what a solver is here; ours; the compiled sizes |
//! | `contact_space`, `block`, `gauss_seidel` | projected Gauss-Seidel with exact block steps |
//! | `alart_curnier`, `elimination` | nonsmooth Newton |
//! | `clarabel` | the convex relaxation, and the outer loop on `s` |
//! | `measure`, `race`, `drawn`, `scaling`, `instructions` | the numbers |
//! | `axis`, `chart`, `pictures`, `pictures_sizes` | what is drawn |
//! | `verdict`, `tables`, `tables_drawn`, `report` | what is written |
//! | `single`, `profile.py` | instructions by function, counted by callgrind |

#![allow(clippy::cast_precision_loss)] // counts and sizes are small
#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // pixels, decades and visits

mod alart_curnier;
mod axis;
mod block;
mod chart;
mod clarabel;
mod contact_space;
mod contestant;
mod drawn;
mod elimination;
mod gauss_seidel;
mod instructions;
mod library;
mod machine;
mod measure;
mod pictures;
mod pictures_sizes;
mod progress;
mod race;
mod report;
mod scaling;
mod single;
mod sizes;
mod tables;
mod tables_drawn;
mod verdict;

use clap::Parser;
use drawn::Drawn;
use measure::Patience;
use progress::Progress;
use race::Race;
use std::path::PathBuf;
use testbed::scene_file::{bundled_scenes, repository};

/// Measure error against time and write the report.
#[derive(Parser)]
struct Options {
    /// Few repeats: less than a minute, and rougher numbers
    #[arg(long)]
    quick: bool,
    /// Only solve, SCENE:SOLVER:TOLERANCE:CALLS, for a profiler
    #[arg(long)]
    profile: Option<String>,
    /// How many scenes to draw
    #[arg(long, value_name = "COUNT")]
    drawn: Option<usize>,
    /// Seed of the drawn scenes; odd ones are for looking only
    #[arg(long, default_value_t = 2)]
    seed: u64,
    /// Only write the drawn scenes to this folder, as scene files
    #[arg(long, value_name = "FOLDER")]
    scenes: Option<PathBuf>,
    /// Folder to write to
    #[arg(long)]
    output: Option<PathBuf>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let options = Options::parse();
    let (patience, brief, drawn, samples, folder) = if options.quick {
        (QUICK, QUICK, 36, 3, "target/speed_vs_error")
    } else {
        (FULL, BRIEF, 300, 20, "examples/speed_vs_error/report")
    };
    let repository = repository();
    let folder = options.output.unwrap_or_else(|| repository.join(folder));
    let count = options.drawn.unwrap_or(drawn);
    if let Some(folder) = options.scenes {
        return Ok(drawn::write(&folder, options.seed, count)?);
    }

    let mut scenes = bundled_scenes();
    scenes.retain(|scene| !scene.name.starts_with("infeasible"));
    if let Some(what) = options.profile {
        return Ok(single::run(&scenes, &what)?);
    }
    let mut progress = Progress::new("scene", scenes.len());
    let mut races = Vec::new();
    for scene in scenes {
        progress.step(&scene.name);
        races.push(Race::new(scene, &patience));
    }
    let drawn = Drawn::new(options.seed, count, &brief);
    let scalings = scaling::run(samples, &patience);
    report::write(&folder, &races, &drawn, &scalings)?;
    eprintln!("written: {}", folder.join("REPORT.md").display());
    Ok(())
}

const QUICK: Patience = Patience { visits: 7, budget: 0.3e6 };
const FULL: Patience = Patience { visits: 100, budget: 12e6 };
/// For drawn scenes, which are many.
const BRIEF: Patience = Patience { visits: 10, budget: 1e6 };
