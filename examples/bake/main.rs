//! Scene files for firmware, written on the host.
//!
//! `cargo run -p bake -- records FILE > scene.bin` writes a scene, or some steps of a
//! sequence, as the bytes `examples/embedded/records.rs` reads; `by-size FILES` all scenes of some files as a macro call of
//! `examples/worst_case`.

mod by_size;
mod records;

use clap::{Args, Parser};
use std::io::{Write, stdout};
use std::path::PathBuf;
use std::process::ExitCode;
use testbed::scene_file;

/// Write scenes for firmware to the standard output.
#[derive(Parser)]
enum Command {
    /// Little-endian f32 records
    Records(Selection),
    /// Scenes with or without joint rows, by size
    BySize {
        /// Scene or sequence files
        files: Vec<PathBuf>,
        /// Time steps to take of a sequence
        #[arg(long, default_value_t = 2)]
        steps: usize,
    },
}

/// What to take of a file.
#[derive(Args)]
struct Selection {
    /// Scene or sequence file
    file: PathBuf,
    /// First time step of a sequence
    #[arg(long, default_value_t = 0)]
    from: usize,
    /// Number of time steps
    #[arg(long, default_value_t = 1)]
    steps: usize,
    /// Generalised velocities to keep, the others are locked [default: all]
    #[arg(long, value_delimiter = ',')]
    dofs: Vec<usize>,
    /// Contacts to keep [default: all]
    #[arg(long, value_delimiter = ',')]
    contacts: Vec<usize>,
    /// Rows of each contact to keep, 0 is the normal [default: all]
    #[arg(long, value_delimiter = ',')]
    rows: Vec<usize>,
}

fn run(command: &Command) -> Result<(), String> {
    let selection = match command {
        Command::Records(selection) => selection,
        Command::BySize { files, steps } => {
            let source = by_size::write(files, *steps)?;
            return stdout().write_all(source.as_bytes()).map_err(|error| error.to_string());
        }
    };
    let scenes = scene_file::read(&selection.file)?;
    let steps = scenes.iter().skip(selection.from);
    let mut bytes = Vec::new();
    for scene in steps.take(selection.steps) {
        records::write(&selection.reduce(scene), &mut bytes);
    }
    stdout().write_all(&bytes).map_err(|error| error.to_string())
}

fn main() -> ExitCode {
    match run(&Command::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
