//! Solves scene files and prints how exactly and how fast.
//!
//! `cargo run --release --example solve` solves the bundled scenes and prints a table; with files
//! and options it is a measuring instrument; `--sequence FILE --warm|--cold` solves the time steps of
//! a simulation. Errors are recomputed in f64 from the file's data,
//! not taken from the kernel.

#![allow(clippy::cast_precision_loss)] // counts are small

mod report;
mod run;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Parser, ValueEnum, value_parser};
use std::path::PathBuf;
use std::process::ExitCode;
use testbed::method::Method;
use testbed::{mixed, scene_file};

/// Solve frictional contact scenes and measure error, iterations and time.
#[derive(Parser)]
struct Options {
    /// One JSON object a scene and line instead of the table
    #[arg(long)]
    json: bool,
    /// Number type of the kernel
    #[arg(long, value_enum, default_value_t = Precision::F64)]
    precision: Precision,
    /// Algorithm
    #[arg(long, default_value = "default", value_parser = methods())]
    method: Method,
    /// Error below which a scene counts as solved [default: 1e-9 for f64, 1e-4 for f32]
    #[arg(long, value_parser = positive)]
    tolerance: Option<f64>,
    /// Largest number of iterations
    #[arg(long, default_value_t = 1000)]
    max_iterations: usize,
    /// Solve each scene N times and give the best time
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = value_parser!(u32).range(1..))]
    repeat: u32,
    /// Solve the time steps of a sequence, one after the other
    #[arg(long, value_name = "FILE")]
    sequence: Vec<PathBuf>,
    /// Start each step of a sequence from the step before [default]
    #[arg(long, requires = "sequence", conflicts_with = "cold")]
    warm: bool,
    /// Start each step of a sequence from nothing
    #[arg(long, requires = "sequence")]
    cold: bool,
    /// Scene files, each scene solved from nothing [default: the bundled scenes]
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
}

impl Options {
    fn tolerance(&self) -> f64 {
        self.tolerance.unwrap_or(match self.precision {
            Precision::F64 => 1e-9,
            Precision::F32 => 1e-4,
        })
    }
}

/// The methods by their names.
fn methods() -> impl TypedValueParser<Value = Method> {
    let named = |name: String| Method::ALL.into_iter().find(|method| method.name() == name);
    PossibleValuesParser::new(Method::ALL.map(Method::name))
        .try_map(move |name| named(name).ok_or("no such method"))
}

fn positive(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|error| format!("{error}"))?;
    if number > 0.0 && number.is_finite() { Ok(number) } else { Err("not a positive number".into()) }
}

/// What a solve starts from.
#[derive(Clone, Copy, PartialEq)]
enum Start {
    Cold,
    Warm,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Precision {
    F64,
    F32,
}

impl Precision {
    fn name(self) -> &'static str {
        match self {
            Self::F64 => "f64",
            Self::F32 => "f32",
        }
    }
}

fn main() -> ExitCode {
    let mut options = Options::parse();
    if options.files.is_empty() && options.sequence.is_empty() {
        options.files = scene_file::bundled();
    }
    let mut failed = false;
    let mut runs = Vec::new();
    if !options.json {
        report::header(&options);
    }
    let start = if options.cold { Start::Cold } else { Start::Warm };
    let scenes = options.files.iter().map(|path| (path, None));
    let sequences = options.sequence.iter().map(|path| (path, Some(start)));
    for (path, sequence) in scenes.chain(sequences) {
        let results = mixed::read(path).and_then(|file| match file {
            Some(file) => run::solve_mixed(&file, &options),
            None => scene_file::read(path)
                .and_then(|scenes| run::solve(&scenes, sequence.unwrap_or(Start::Cold), &options)),
        });
        match results {
            Ok(results) => {
                for (step, result) in results.into_iter().enumerate() {
                    if options.json {
                        report::json(&result, sequence.map(|_| step), &options);
                    } else {
                        report::row(&result);
                    }
                    runs.push(result);
                }
            }
            Err(error) => {
                eprintln!("{}: {error}", path.display());
                failed = true;
            }
        }
    }
    if !options.json {
        report::summary(&runs, &options);
    }
    ExitCode::from(if failed { 2 } else { 0 })
}
