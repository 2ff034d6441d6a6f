//! The options of the command line.

use lexopt::{Arg, Parser, ValueExt};
use std::num::NonZeroU32;
use std::path::PathBuf;
use testbed::method::Method;
use testbed::scene_file;

const HELP: &str = "\
Solve frictional contact scenes and measure error, iterations and time

Usage: solve [OPTIONS] [FILE]...

Arguments:
  [FILE]...  Scene files, each scene solved from nothing [default: the bundled scenes]

Options:
      --json                   One JSON object a scene and line instead of the table
                               (impulses r in N s; forces r / h in N, if the file has h)
      --precision <PRECISION>  Number type of the kernel [default: f64] [possible values: f64; f32 if built with --features f32]
      --method <METHOD>        Algorithm [default: default] [possible values: plain, fast, restart, default]
      --tolerance <TOLERANCE>  Error below which a scene counts as solved [default: 1e-9 for f64, 1e-4 for f32]
      --budget <N>             Work that a solve may take, as Settings::budget [default: 1000]
      --repeat <N>             Solve each scene N times and give the best time [default: 20; with --json 1]
      --sequence <FILE>        Solve the time steps of a sequence, one after the other
      --warm                   Start each step of a sequence from the step before [default]
      --cold                   Start each step of a sequence from nothing
  -h, --help                   Print help";

/// What a solve starts from.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Start {
    Cold,
    Warm,
}

#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Precision {
    F64,
    #[cfg(feature = "f32")]
    F32,
}

impl Precision {
    const ALL: &[Self] = &[
        Self::F64,
        #[cfg(feature = "f32")]
        Self::F32,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::F64 => "f64",
            #[cfg(feature = "f32")]
            Self::F32 => "f32",
        }
    }
}

pub(crate) struct Options {
    pub(crate) json: bool,
    pub(crate) precision: Precision,
    pub(crate) method: Method,
    /// Error below which a scene counts as solved.
    pub(crate) tolerance: f64,
    /// Of a solve.
    pub(crate) budget: usize,
    pub(crate) repeat: u32,
    pub(crate) sequences: Vec<PathBuf>,
    /// What each step of a sequence starts from.
    pub(crate) start: Start,
    /// Scene files; the bundled scenes if there is neither file nor sequence.
    pub(crate) files: Vec<PathBuf>,
}

impl Options {
    /// Reads the command line.
    pub(crate) fn read() -> Result<Self, lexopt::Error> {
        let mut options = Self {
            json: false,
            precision: Precision::F64,
            method: Method::Default,
            tolerance: 0.0,
            budget: 1000,
            repeat: 0,
            sequences: Vec::new(),
            start: Start::Warm,
            files: Vec::new(),
        };
        let (mut tolerance, mut repeat, mut starts) = (None, None, Vec::new());
        let mut parser = Parser::from_env();
        while let Some(arg) = parser.next()? {
            match arg {
                Arg::Long("json") => options.json = true,
                Arg::Long("precision") => {
                    options.precision =
                        parser.value()?.parse_with(|name| named(Precision::ALL, Precision::name, name))?;
                }
                Arg::Long("method") => {
                    options.method =
                        parser.value()?.parse_with(|name| named(&Method::ALL, Method::name, name))?;
                }
                Arg::Long("tolerance") => tolerance = Some(parser.value()?.parse_with(positive)?),
                Arg::Long("budget") => options.budget = parser.value()?.parse()?,
                Arg::Long("repeat") => repeat = Some(parser.value()?.parse::<NonZeroU32>()?.get()),
                Arg::Long("sequence") => options.sequences.push(parser.value()?.into()),
                Arg::Long("warm") => starts.push(Start::Warm),
                Arg::Long("cold") => starts.push(Start::Cold),
                Arg::Value(path) => options.files.push(path.into()),
                Arg::Short('h') | Arg::Long("help") => {
                    println!("{HELP}");
                    std::process::exit(0);
                }
                _ => return Err(arg.unexpected()),
            }
        }
        options.repeat = repeat.unwrap_or(if options.json { 1 } else { 20 });
        options.tolerance = tolerance.unwrap_or(match options.precision {
            Precision::F64 => 1e-9,
            #[cfg(feature = "f32")]
            Precision::F32 => 1e-4,
        });
        match starts[..] {
            [] => {}
            [start] if !options.sequences.is_empty() => options.start = start,
            _ => return Err("--warm or --cold goes with --sequence".into()),
        }
        if options.files.is_empty() && options.sequences.is_empty() {
            options.files = scene_file::bundled();
        }
        Ok(options)
    }
}

/// Returns the value that has this name.
fn named<T: Copy>(all: &[T], name_of: fn(T) -> &'static str, name: &str) -> Result<T, String> {
    let names = || all.iter().map(|&value| name_of(value)).collect::<Vec<_>>().join(", ");
    all.iter()
        .copied()
        .find(|&value| name_of(value) == name)
        .ok_or_else(|| format!("possible values: {}", names()))
}

fn positive(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|error| format!("{error}"))?;
    if number > 0.0 && number.is_finite() { Ok(number) } else { Err("not a positive number".into()) }
}
