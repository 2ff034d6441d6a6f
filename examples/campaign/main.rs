//! Solves random scenes and counts what was solved, what was not, what was claimed falsely, and what work it
//! took. A panic of the kernel ends the campaign.
//!
//! The scenes are of the classes of `testbed::generate`, one after the other: those made to break a solver, and those of
//! what is met. Odd seeds are for looking, which constants are tuned on; even ones are for deciding.
//!
//! `cargo run --release -p campaign -- --count 100000 --seed 1`; a scene of the list at
//! the end is solved again, alone, with `--only INDEX` and the same seed.
//!
//! Scenes are drawn and solved on all cores. A scene depends on the seed and its index alone, and they are counted in the
//! order of their indices: the output is the same on any number of threads (`RAYON_NUM_THREADS`).

mod kinds;
mod tally;

use clap::{Parser, ValueEnum};
use indicatif::ParallelProgressIterator;
use kinds::Kind;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::process::ExitCode;
use tally::{Tally, Verdict};
use testbed::generate::{self, Class};
use testbed::kernel::Constructor;
use testbed::solve;

/// Solve random scenes; exit with 1 if the kernel claimed anything false.
#[derive(Parser)]
struct Options {
    /// Scenes to draw, one class after the other
    #[arg(long, default_value_t = 100_000)]
    count: u64,
    /// Seed of the campaign: an odd one to look at scenes, an even one to decide
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// What is drawn
    #[arg(long, value_enum, default_value_t = Kind::Contacts)]
    kind: Kind,
    /// Draw the scene of this index only
    #[arg(long, value_name = "INDEX")]
    only: Option<u64>,
    /// Number type of the kernel
    #[arg(long, value_enum, default_value_t = Precision::F64)]
    precision: Precision,
    /// Error below which a scene counts as solved
    #[arg(long, default_value_t = 1e-6)]
    tolerance: f64,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Precision {
    F64,
    F32,
}

/// What became of one scene.
struct Finding {
    /// Which of the classes it is of.
    turn: usize,
    verdict: Verdict,
    work: usize,
    /// A line for somebody who should look at it.
    note: Option<String>,
}

impl Finding {
    fn new(kernel: Constructor, options: &Options, index: u64) -> Self {
        let turn = usize::try_from(index).unwrap_or(0) % Class::ALL.len();
        let (scene, existence) = generate::draw(Class::ALL[turn], options.seed, index);
        let outcome = solve::solve(kernel, &scene, options.tolerance);
        let verdict = Verdict::new(&outcome, existence, options.tolerance);
        let note = format!(
            "{} of seed {}: {} dofs, {} x {} rows, {verdict:?}, error {:.2e}, work {}",
            scene.name, options.seed, scene.n_dof, scene.n_contacts, scene.dim, outcome.error, outcome.work
        );
        let is_noted = verdict.is_noted() || options.only.is_some();
        Self { turn, verdict, work: outcome.work, note: is_noted.then_some(note) }
    }
}

fn main() -> ExitCode {
    let options = Options::parse();
    let indices = match options.only {
        Some(index) => index..index + 1,
        None => 0..options.count,
    };
    if options.kind != Kind::Contacts {
        return try_out(&options, indices);
    }
    let kernel: Constructor = match options.precision {
        Precision::F64 => kernels_f64::kernel,
        Precision::F32 => kernels_f32::kernel,
    };
    let count = indices.end - indices.start;
    let findings: Vec<Finding> = indices
        .into_par_iter()
        .progress_count(count)
        .map(|index| Finding::new(kernel, &options, index))
        .collect();
    let mut tallies = Class::ALL.map(|class| Tally::new(format!("{class:?}")));
    for finding in &findings {
        tallies[finding.turn].add(finding.verdict, finding.work);
    }
    println!("{}", Tally::header());
    for tally in &tallies {
        println!("{tally}");
    }
    let (hard, drawn) = tallies.split_at(Class::HARD.len());
    for (name, part) in [("all hard", hard), ("all drawn", drawn), ("all", &tallies)] {
        println!("{}", Tally::sum(name, part));
    }
    println!();
    for note in findings.iter().filter_map(|finding| finding.note.as_ref()) {
        println!("{note}");
    }
    let count = |wanted: fn(Verdict) -> bool| tallies.iter().map(|tally| tally.count(wanted)).sum();
    let (noted, falsehoods): (usize, usize) = (count(Verdict::is_noted), count(Verdict::is_false));
    println!("{noted} unsolved or false, {falsehoods} false");
    ExitCode::from(u8::from(falsehoods > 0))
}

/// Draws scenes of one kind; exits with 1 if the kernel claimed anything false.
fn try_out(options: &Options, indices: std::ops::Range<u64>) -> ExitCode {
    let (kind, count) = (options.kind, indices.end - indices.start);
    let found: Vec<_> = indices
        .into_par_iter()
        .progress_count(count)
        .map(|index| {
            let place = (options.seed, index);
            (index, kind.try_out(options.precision, place, options.tolerance))
        })
        .collect();
    let mut tally = Tally::new(format!("{kind:?}"));
    println!("{}", Tally::header());
    for (verdict, _, work) in found.iter().flat_map(|(_, solves)| solves) {
        tally.add(*verdict, *work);
    }
    println!("{tally}\n");
    for (index, solves) in &found {
        for (solve, (verdict, error, work)) in solves.iter().enumerate() {
            if verdict.is_false() || options.only.is_some() {
                println!("{index}, solve {solve}: {verdict:?}, error {error:.3e}, work {work}");
            }
        }
    }
    let falsehoods = tally.count(Verdict::is_false);
    println!("{falsehoods} false");
    ExitCode::from(u8::from(falsehoods > 0))
}
