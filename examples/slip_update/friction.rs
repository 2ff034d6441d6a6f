//! Higher friction, where the update at every iteration ceases to converge.

use crate::library::{self, Method, Update};
use crate::note::{Acceleration, Note, Printed, Slip, Variant};
use crate::outcome::{Outcome, solved};
use crate::{CAP, by_library, by_note, heading};
use testbed::scene_file::SceneFile;

const FACTORS: [f64; 4] = [1.0, 2.0, 5.0, 10.0];
const TOLERANCE: f64 = 1e-6;
const LONG: usize = 100 * CAP;
const EVERY: Update = Update::EveryIteration;
const OUTER: Update = Update::OuterLoop;

pub(crate) fn tables(scenes: &[SceneFile]) {
    let rougher = FACTORS.map(|factor| {
        let mut scenes = scenes.to_vec();
        for mu in scenes.iter_mut().flat_map(|scene| &mut scene.mu) {
            *mu *= factor;
        }
        scenes
    });
    shares(&rougher);
    unsolved(&rougher);
    stability(&rougher);
}

/// Scenes solved under growing friction.
fn shares(rougher: &[Vec<SceneFile>; 4]) {
    heading(
        "Higher friction: scenes solved to 1e-6 with all `mu` multiplied",
        "| method | `s` | iterations | x 1 | x 2 | x 5 | x 10 |",
    );
    let print = |method: Method, slip: &str, cap, run: &dyn Fn(&[SceneFile]) -> Vec<Outcome>| {
        let [one, two, five, ten] = rougher.each_ref().map(|scenes| solved(&run(scenes)));
        let method = library::name(method);
        println!("| {method:<11} | {slip:<23} | {cap:>6} | {one} | {two} | {five} | {ten} |");
    };
    for (method, name, slip, cap) in [
        (Method::Plain, "every iteration", EVERY, CAP),
        (Method::Plain, "every iteration", EVERY, LONG),
        (Method::Restart, "every iteration", EVERY, CAP),
        (Method::Restart, "every iteration", EVERY, LONG),
        (Method::Restart, "outer loop", OUTER, CAP),
        (Method::Restart, "outer loop", OUTER, LONG),
        (Method::Default, "every iteration", EVERY, CAP),
        (Method::Default, "outer loop", OUTER, CAP),
    ] {
        print(method, name, cap, &|scenes| by_library(scenes, method, slip, TOLERANCE, cap));
    }
    for cap in [CAP, LONG] {
        let tighter = Variant {
            acceleration: Acceleration::Restart,
            slip: Slip::OuterLoop(0.1),
            printed: Printed::default(),
        };
        let run = |scenes: &[SceneFile]| by_note(scenes, tighter, TOLERANCE, cap);
        print(Method::Restart, "outer loop, inner 1e-7", cap, &run);
    }
}

/// What is left where the update at every iteration fails: is it slow, or does it go nowhere?
fn unsolved(rougher: &[Vec<SceneFile>; 4]) {
    heading(
        "Scenes that Algorithm 2 with `s` at every iteration leaves above 1e-6: least error",
        "| scene | `mu` | 1,000 iterations | 100,000 | outer loop, 100,000 | default, 1,000 |",
    );
    for (factor, scenes) in FACTORS.iter().zip(rougher) {
        let error = |scene, method, slip, budget| {
            library::solve(scene, method, slip, TOLERANCE, budget).coulomb_error
        };
        for scene in scenes {
            let late = error(scene, Method::Restart, EVERY, LONG);
            if late > TOLERANCE {
                println!(
                    "| {:<24} | x {factor:<2} | {:.1e} | {late:.1e} | {:.1e} | {:.1e} |",
                    scene.name,
                    error(scene, Method::Restart, EVERY, CAP),
                    error(scene, Method::Restart, OUTER, LONG),
                    error(scene, Method::Default, EVERY, CAP),
                );
            }
        }
    }
}

/// Whether the update at every iteration stays at a solution that it is given, or lets rounding
/// grow.
fn stability(rougher: &[Vec<SceneFile>; 4]) {
    heading(
        "Plain ADMM, `s` at every iteration, started from a solution (error below 1e-9)",
        "| `mu` | solutions | error above 1e-6 after 10,000 iterations | where |",
    );
    for (factor, scenes) in FACTORS.iter().zip(rougher) {
        let (mut solutions, mut left) = (0, Vec::new());
        for scene in scenes {
            let solution = library::solve(scene, Method::Default, EVERY, 1e-12, LONG);
            if solution.coulomb_error > 1e-9 {
                continue;
            }
            solutions += 1;
            let note = Note::new(scene, library::penalty(scene));
            if note.drift(&solution.impulse, 10 * CAP) > TOLERANCE {
                left.push(scene.name.as_str());
            }
        }
        let (count, names) = (left.len(), left.join(", "));
        println!("| x {factor:<2} | {solutions} | {count} | {names} |");
    }
}
