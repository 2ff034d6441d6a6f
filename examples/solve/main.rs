//! Solves scene files and prints how exactly and how fast.
//!
//! `cargo run --release -p solve` solves the bundled scenes and prints a table; with files
//! and options it is a measuring instrument; `--sequence FILE --warm|--cold` solves the time steps of
//! a simulation. Errors are recomputed in f64 from the file's data,
//! not taken from the kernel.

#![allow(clippy::cast_precision_loss)] // counts are small

mod options;
mod report;
mod run;

use options::{Options, Start};
use std::process::ExitCode;
use testbed::format;

fn main() -> ExitCode {
    let options = match Options::read() {
        Ok(options) => options,
        Err(error) => {
            eprintln!("error: {error}\n\nFor more information, try '--help'.");
            return ExitCode::from(2);
        }
    };
    let mut failed = false;
    let mut runs = Vec::new();
    if !options.json {
        report::header(&options);
    }
    let scenes = options.files.iter().map(|path| (path, None));
    let sequences = options.sequences.iter().map(|path| (path, Some(options.start)));
    for (path, sequence) in scenes.chain(sequences) {
        let results = format::read(path)
            .and_then(|scenes| run::solve(&scenes, sequence.unwrap_or(Start::Cold), &options));
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
