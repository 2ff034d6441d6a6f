//! What each constant of the method is worth: half of it, twice of it, and a value that switches off what it belongs to.
//!
//! `RUSTFLAGS="--cfg stiction_tuning" cargo run --release -p tuning --target-dir target/tuning > src/guide/reports/tuning.md`
//!
//! The measure is work, which is the same on every machine: of random scenes that surely have a solution (the classes of
//! the campaign, drawn with a seed of their own), of the bundled scenes, and of the bundled sequences with warm starts.

#![allow(clippy::cast_precision_loss)] // sums of work

use clap::Parser;
use std::process::{Command, ExitCode};
use stiction::{Settings, Status};
use testbed::generate::{self, Class, Existence};
use testbed::kernel::{Constructor, Shape};
use testbed::method::Method;
use testbed::scene_file::{self, SceneFile};

/// A constant, its value, and one without what it belongs to.
const CONSTANTS: [(&str, f64, f64); 22] = [
    ("open_threshold", 0.03, 1e30),
    ("grazing", 1e-4, 0.0),
    ("sticking", 1.0, -1.0),
    ("sweeps", 8.0, 0.0),
    ("newton_steps", 30.0, 255.0),
    ("merit_growth", 1e5, 1.0),
    ("chord_fall", 0.1, 0.0),
    ("chord_steps", 4.0, 0.0),
    ("damping", 1e-6, 0.0),
    ("finish_damping", 0.1, 0.0),
    ("first_tau", 10.0, 1.0),
    ("tau_share", 2.0, 1e30),
    ("first_gain", 10.0, 1.0),
    ("margin", 0.02, 0.5),
    ("correct_again", 0.95, 0.0),
    ("near", 1e-3, 0.0),
    ("jammed", 0.02, 0.0),
    ("longest_path", 30.0, 1e9),
    ("tau_raise", 9.0, 1.0),
    ("sweeps_at_jam", 5.0, 0.0),
    ("jams_to_farthest", 2.0, 1e9),
    ("patience", 1000.0, 1e9),
];

/// What a solve may cost.
const BUDGET: usize = 10_000;

/// Measure what the constants of the method are worth.
#[derive(Parser)]
struct Options {
    /// Random scenes
    #[arg(long, default_value_t = 6_000)]
    count: u64,
    /// Their seed
    #[arg(long, default_value_t = 77)]
    seed: u64,
    /// Measure with the constants as they are, and print sums only
    #[arg(long)]
    sums: bool,
}

/// Work of drawn scenes, bundled ones and sequences, and how many of all were not solved.
type Sums = [usize; 4];

fn solve(kernel: Constructor, steps: &[SceneFile], tolerance: f64, sums: &mut Sums, place: usize) {
    let shape = Shape::of_all(steps).expect("a step");
    let mut kernel = kernel(shape).expect("a size is compiled");
    let settings = Settings { budget: BUDGET, ..Settings::new(tolerance) };
    for step in steps {
        let prepared = kernel.load(step).and_then(|()| kernel.prepare(Method::Default));
        // A mass matrix of condition 1e10 need not be one in f32.
        if prepared.is_err() || kernel.solve(Method::Default, &settings).is_err() {
            continue;
        }
        let (status, work) = kernel.outcome();
        sums[place] += work.total().min(BUDGET);
        sums[3] += usize::from(!matches!(status, Status::Solved | Status::Infeasible | Status::Jammed));
    }
}

fn measure(options: &Options) -> Sums {
    let mut sums = [0; 4];
    let kernels: [(Constructor, f64); 2] = [(kernels_f64::kernel, 1e-6), (kernels_f32::kernel, 1e-4)];
    for (kernel, tolerance) in kernels {
        for index in 0..options.count {
            let class = usize::try_from(index).unwrap_or(0) % Class::ALL.len();
            let (scene, existence) = generate::draw(Class::ALL[class], options.seed, index);
            if existence == Existence::Guaranteed {
                solve(kernel, &[scene], tolerance, &mut sums, 0);
            }
        }
        let files = [scene_file::bundled(), scene_file::bundled_sequences()];
        for (place, files) in (1..).zip(files) {
            for file in files {
                let steps = scene_file::read(&file).expect("a bundled file");
                solve(kernel, &steps, tolerance, &mut sums, place);
            }
        }
    }
    sums
}

/// [`measure`] in a process of its own, with another value of a constant.
fn measure_with(options: &Options, constant: &str, value: f64) -> Result<Sums, String> {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let (count, seed) = (options.count.to_string(), options.seed.to_string());
    let output = Command::new(program)
        .args(["--sums", "--count", &count, "--seed", &seed])
        .env(constant, value.to_string())
        .output()
        .map_err(|error| error.to_string())?;
    let text = String::from_utf8_lossy(&output.stdout);
    let sums: Vec<usize> = text.split_whitespace().flat_map(str::parse).collect();
    sums.try_into().map_err(|_| format!("{constant} = {value}: {output:?}"))
}

/// A number as a reader would write it.
fn plain(x: f64) -> String {
    if x == 0.0 || (1e-4..1e4).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

/// "+1.2 / 0.0 / -0.3", and how many solves more end unsolved.
fn cell(sums: &Sums, base: &Sums) -> String {
    let percent = |i: usize| {
        let [new, old] = [sums[i], base[i]].map(|sum| sum as f64);
        format!("{:+.1}", 100.0 * (new / old - 1.0))
    };
    let [now, before] = [sums[3], base[3]].map(|count| i64::try_from(count).unwrap_or(i64::MAX));
    let lost = match now - before {
        0 => String::new(),
        change => format!(", {change:+} unsolved"),
    };
    format!("{} / {} / {}{lost}", percent(0), percent(1), percent(2))
}

fn table(options: &Options) -> Result<(), String> {
    if !cfg!(stiction_tuning) {
        return Err("without `--cfg stiction_tuning` the constants do not listen".into());
    }
    let base = measure_with(options, "nothing", 0.0)?;
    let [drawn, bundled, sequences, unsolved] = base;
    println!(
        "# What the constants are worth\n\n\
         Printed by `RUSTFLAGS=\"--cfg stiction_tuning\" cargo run --release -p tuning --target-dir target/tuning`, which \
         measures {} random scenes of seed {}, the bundled ones and the bundled sequences with warm starts, each in f64 to \
         1e-6 and in f32 to 1e-4, with a budget of {BUDGET}. Work of all: {drawn}, {bundled} and {sequences}, {unsolved} \
         unsolved.\n\n\
         A cell has the change of these three sums in percent (random / bundled / sequences), and how many solves more or \
         less end unsolved. Half of a count is rounded up. \"Without\" is the value in brackets, which switches off what the \
         constant belongs to.\n\n\
         | constant | value | half: work in % | twice: work in % | without: work in % |\n|---|---:|---|---|---|",
        options.count, options.seed
    );
    for (name, value, off) in CONSTANTS {
        if measure_with(options, name, value)? != base {
            return Err(format!("{name} is not {value} in src/solver/tuning.rs"));
        }
        // Half of a count is rounded up.
        let half = if value >= 2.0 { (value * 0.5).ceil() } else { value * 0.5 };
        let values = [half, value * 2.0, off];
        let mut cells = Vec::new();
        for value in values {
            cells.push(cell(&measure_with(options, name, value)?, &base));
        }
        let [half, twice, without] = &cells[..] else { unreachable!("three values") };
        let (value, off) = (plain(value), plain(off));
        println!("| `{name}` | {value} | {half} | {twice} | {without} ({off}) |");
    }
    Ok(())
}

fn main() -> ExitCode {
    let options = Options::parse();
    if options.sums {
        let [drawn, bundled, sequences, unsolved] = measure(&options);
        println!("{drawn} {bundled} {sequences} {unsolved}");
        return ExitCode::SUCCESS;
    }
    match table(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
