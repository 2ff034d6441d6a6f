//! The table and the JSON lines.

use crate::options::Options;
use crate::run::Run;
use serde_json::json;
use std::io::Write;
use stiction::{ContactMode, Status};

/// Prints a line; whoever reads may stop listening.
fn print(line: &str) {
    if writeln!(std::io::stdout(), "{line}").is_err() {
        std::process::exit(0);
    }
}

pub(crate) fn header(options: &Options) {
    print(&format!(
        "method {}, {}; error recomputed in f64; contacts: = stick, ~ slip, o open\n",
        options.method.name(),
        options.precision.name()
    ));
    print(&format!(
        "{:<28} {:>4} {:>8} {:<15} {:>5} {:>6} {:>8} {:>10} {:>9} {:>8}  contacts",
        "scene", "dofs", "contacts", "status", "iter", "newton", "error", "prepare/µs", "solve/µs", "ns/iter"
    ));
}

pub(crate) fn row(run: &Run) {
    let per_iteration = if run.answer.work.newton_steps == 0 {
        format!("{:.0}", run.solve_ns / first_order(run).max(1) as f64)
    } else {
        "-".into() // most of it is Newton's
    };
    let modes: String = run.answer.modes.iter().map(|&mode| symbol(mode)).collect();
    print(&format!(
        "{:<28} {:>4} {:>8} {:<15} {:>5} {:>6} {:>8.1e} {:>10.2} {:>9.2} {:>8}  {}",
        run.name,
        run.n_dof,
        format!("{}x{}", run.n_contacts, run.dim),
        format!("{:?}", run.answer.status),
        first_order(run),
        run.answer.work.newton_steps,
        run.error,
        run.prepare_ns / 1e3,
        run.solve_ns / 1e3,
        per_iteration,
        modes,
    ));
}

/// One line; `step` is the place in a sequence.
pub(crate) fn json(run: &Run, step: Option<usize>, options: &Options) {
    let mut line = json!({
        "name": run.name,
        "n_dof": run.n_dof,
        "n_contacts": run.n_contacts,
        "dim": run.dim,
        "precision": options.precision.name(),
        "method": options.method.name(),
        "status": format!("{:?}", run.answer.status),
        "iterations": first_order(run),
        "newton_steps": run.answer.work.newton_steps,
        "factorizations": 0,
        "error": run.error,
        "prepare_ns": run.prepare_ns,
        "solve_ns": run.solve_ns,
        "v": run.answer.v,
        "modes": run.answer.modes.iter().map(|mode| format!("{mode:?}")).collect::<Vec<_>>(),
        "r": run.answer.r,
        "forces": run.time_step.map(|h| run.answer.r.iter().map(|r| r / h).collect::<Vec<_>>()),
        "lambda": run.answer.lambda,
        "certificate": certificate(run),
        "certificate_lambda": run.answer.certificate_lambda,
    });
    if let Some(step) = step {
        line["step"] = step.into();
    }
    print(&line.to_string());
}

/// Work but for Newton steps: what the column and the field `iterations` have always been.
fn first_order(run: &Run) -> usize {
    run.answer.work.total() - 10 * run.answer.work.newton_steps
}

/// `d`, row by row with zero tangential parts, if the scene is infeasible.
fn certificate(run: &Run) -> Option<Vec<f64>> {
    let normals = run.answer.certificate.iter();
    let rows = normals.flat_map(|&d| (0..run.dim).map(move |row| if row == 0 { d } else { 0.0 }));
    (run.answer.status == Status::Infeasible).then(|| rows.collect())
}

/// How many scenes reached which error, and how long it took.
pub(crate) fn summary(runs: &[Run], options: &Options) {
    if runs.is_empty() {
        return;
    }
    let mut work: Vec<usize> = runs.iter().map(|run| run.answer.work.total()).collect();
    work.sort_unstable();
    let quantile = |percent: usize| work[(work.len() - 1) * percent / 100];
    let reaches = |run: &Run, error| {
        !matches!(run.answer.status, Status::Infeasible | Status::Jammed) && run.error <= error
    };
    let count = |wanted: &dyn Fn(&Run) -> bool| runs.iter().filter(|run| wanted(run)).count();
    print(&format!(
        "\n{} scenes: {} infeasible, {} solved; error <= 1e-3: {}, 1e-6: {}, 1e-9: {}; \
         work (iterations + 10 newton) median {}, 90 % {}, max {}",
        runs.len(),
        count(&|run| run.answer.status == Status::Infeasible),
        count(&|run| run.answer.status == Status::Solved),
        count(&|run| reaches(run, 1e-3)),
        count(&|run| reaches(run, 1e-6)),
        count(&|run| reaches(run, 1e-9)),
        quantile(50),
        quantile(90),
        quantile(100),
    ));
    let false_claims =
        runs.iter().filter(|run| run.answer.status == Status::Solved && run.error > options.tolerance);
    for run in false_claims {
        print(&format!("{}: solved, but the error is {:.3e}", run.name, run.error));
    }
}

fn symbol(mode: ContactMode) -> char {
    match mode {
        ContactMode::Open => 'o',
        ContactMode::Stick => '=',
        ContactMode::Slip => '~',
    }
}
