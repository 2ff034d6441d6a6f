//! Is updating the tangential speed `s` at every iteration stable? The note leaves it open; here
//! it is measured over the bundled scenes.
//!
//! `cargo run --release -p slip_update`
//!
//! f64, the library's default penalty, cold starts, at most 1000 iterations; a scene is solved if
//! its error, measured from the file's data, is at most the tolerance. What the library does not
//! offer (`s` from the velocity, the note as printed) runs in `note`, the note's steps written
//! down once more; the first table shows that both count the same iterations.

mod friction;
mod library;
mod misprints;
mod note;
mod outcome;
use library::{Method, Update};
use note::{Acceleration, Note, Printed, Slip, Variant};
use outcome::{Outcome, quantile, solved, summary};
use testbed::scene_file::{SceneFile, bundled_scenes};

const CAP: usize = 1000;
const TOLERANCES: [f64; 2] = [1e-3, 1e-6];
const ACCELERATED: [(Method, Acceleration); 3] = [
    (Method::Plain, Acceleration::Plain),
    (Method::Fast, Acceleration::Fast),
    (Method::Restart, Acceleration::Restart),
];

fn main() {
    let scenes: Vec<SceneFile> =
        bundled_scenes().into_iter().filter(|scene| !scene.name.starts_with("infeasible")).collect();
    let feasible = scenes.len();
    println!("{feasible} feasible scenes; `-`: not solved in {CAP} iterations.");
    check(&scenes);
    updates(&scenes);
    relaxation(&scenes);
    misprints::tables(&scenes);
    failures(&scenes);
    friction::tables(&scenes);
}

/// The library's outcome on every scene.
fn by_library(
    scenes: &[SceneFile],
    method: Method,
    slip: Update,
    tolerance: f64,
    cap: usize,
) -> Vec<Outcome> {
    let solve = |scene| library::solve(scene, method, slip, tolerance, cap);
    scenes.iter().map(solve).collect()
}

/// The outcome of the note's steps on every scene.
fn by_note(scenes: &[SceneFile], variant: Variant, tolerance: f64, cap: usize) -> Vec<Outcome> {
    let solve = |scene| Note::new(scene, library::penalty(scene)).solve(variant, tolerance, cap);
    scenes.iter().map(solve).collect()
}

fn heading(title: &str, columns: &str) {
    println!("\n### {title}\n\n{columns}");
    let columns = columns.matches('|').count() - 1;
    println!("|{}", "---|".repeat(columns));
}

/// A row of numbers for both tolerances.
fn row(method: &str, what: &str, run: impl Fn(f64) -> Vec<Outcome>) {
    let [coarse, fine] = TOLERANCES.map(|tolerance| summary(&run(tolerance)));
    println!("| {method:<11} | {what:<44} | {coarse} | {fine} |");
}

fn check(scenes: &[SceneFile]) {
    heading(
        "The note's steps against the library",
        "| method | `s` | tolerance | solved by library / here | equal counts | largest difference |",
    );
    for (method, acceleration) in ACCELERATED {
        for (name, update, slip) in [
            ("every iteration", Update::EveryIteration, Slip::Projected),
            ("outer loop", Update::OuterLoop, Slip::OuterLoop(1.0)),
        ] {
            for tolerance in TOLERANCES {
                let printed = Printed::default();
                let variant = Variant { acceleration, slip, printed };
                let theirs = by_library(scenes, method, update, tolerance, CAP);
                let ours = by_note(scenes, variant, tolerance, CAP);
                let pairs = theirs.iter().zip(&ours);
                let differences = pairs.map(|(a, b)| a.iterations.abs_diff(b.iterations));
                println!(
                    "| {:<11} | {name:<15} | {tolerance:.0e} | {} / {} | {} | {} |",
                    library::name(method),
                    solved(&theirs),
                    solved(&ours),
                    differences.clone().filter(|&difference| difference == 0).count(),
                    differences.max().unwrap_or(0),
                );
            }
        }
    }
}

fn updates(scenes: &[SceneFile]) {
    heading(
        "When `s` is updated",
        "| method | `s` | solved to 1e-3 | median | 90 % | solved to 1e-6 | median | 90 % |",
    );
    for method in Method::ALL {
        let library = |what: &str, slip| {
            row(library::name(method), what, |tolerance| by_library(scenes, method, slip, tolerance, CAP));
        };
        library("every iteration, of `ũ`", Update::EveryIteration);
        let other = ACCELERATED.iter().find(|(other, _)| *other == method);
        if let Some(&(_, acceleration)) = other {
            let (slip, printed) = (Slip::OfVelocity, Printed::default());
            let variant = Variant { acceleration, slip, printed };
            let run = |tolerance| by_note(scenes, variant, tolerance, CAP);
            row(library::name(method), "every iteration, of `v`", run);
        }
        library("outer loop", Update::OuterLoop);
        library("never (the relaxation, by its own error)", Update::Never);
    }
}

fn relaxation(scenes: &[SceneFile]) {
    heading(
        "Error in Coulomb's law where `s` is never updated",
        "| method | scenes below 1e-6 | below 1e-3 | below 1e-2 | below 0.1 | median | 90 % | largest |",
    );
    for method in Method::ALL {
        let outcomes = by_library(scenes, method, Update::Never, 1e-6, CAP);
        let mut errors: Vec<f64> = outcomes.iter().map(|o| o.coulomb_error).collect();
        errors.sort_unstable_by(f64::total_cmp);
        let below = |limit: f64| errors.partition_point(|&error| error <= limit);
        println!(
            "| {:<11} | {} | {} | {} | {} | {:.1e} | {:.1e} | {:.1e} |",
            library::name(method),
            below(1e-6),
            below(1e-3),
            below(1e-2),
            below(0.1),
            quantile(&errors, 50),
            quantile(&errors, 90),
            quantile(&errors, 100),
        );
    }
}

fn failures(scenes: &[SceneFile]) {
    heading(
        "Scenes that one way solves to 1e-6 and the other does not",
        "| method | only every iteration | only the outer loop | neither |",
    );
    for method in Method::ALL {
        let run = |slip| by_library(scenes, method, slip, 1e-6, CAP);
        let every = run(Update::EveryIteration);
        let outer = run(Update::OuterLoop);
        let list = |wanted: (bool, bool)| {
            let pairs = every.iter().zip(&outer).zip(scenes);
            let named = pairs.filter(|((a, b), _)| (a.solved, b.solved) == wanted);
            let names: Vec<&str> = named.map(|(_, scene)| scene.name.as_str()).collect();
            names.join(", ")
        };
        println!(
            "| {:<11} | {} | {} | {} |",
            library::name(method),
            list((true, false)),
            list((false, true)),
            list((false, false)),
        );
    }
}
