//! A Markdown table of what became of bodies.

use crate::body::{Body, Kind};
use crate::run::{Outcome, Setting, WEIGHT_ALONE};

pub(crate) fn head() {
    println!(
        "| load | setting | slid | by kind | in tick 0 | when the load came | later | unsolved ticks | work per tick | fastest that stayed |"
    );
    println!("|---|---|--:|---|--:|--:|--:|--:|--:|--:|");
}

pub(crate) fn print(load: &str, setting: Setting, bodies: &[Body], outcomes: &[Outcome]) {
    let slid = |kind: Option<Kind>, first: usize, end: usize| {
        let pairs = bodies.iter().zip(outcomes);
        let of_kind = pairs.filter(|(body, _)| kind.is_none_or(|kind| body.kind == kind));
        let left = of_kind.filter_map(|(_, outcome)| outcome.left);
        left.filter(|tick| (first..end).contains(tick)).count()
    };
    let all = |kind| slid(kind, 0, usize::MAX);
    let kinds = Kind::ALL.map(|kind| all(Some(kind)).to_string());
    let sum = |of: fn(&Outcome) -> usize| outcomes.iter().map(of).sum::<usize>();
    let stayed = outcomes.iter().filter(|outcome| outcome.left.is_none());
    println!(
        "| {load} | {} | {} of {} | {} | {} | {} | {} | {} | {:.2} | {:.1e} m/s |",
        setting.name,
        all(None),
        bodies.len(),
        kinds.join(" "),
        slid(None, 0, 1),
        slid(None, WEIGHT_ALONE, WEIGHT_ALONE + 1),
        slid(None, 1, WEIGHT_ALONE) + slid(None, WEIGHT_ALONE + 1, usize::MAX),
        sum(|outcome| outcome.unsolved),
        sum(|outcome| outcome.work) as f64 / sum(|outcome| outcome.ticks) as f64,
        stayed.map(|outcome| outcome.fastest).fold(0.0, f64::max),
    );
}

/// The bodies that slid, with the ticks in which they left.
pub(crate) fn list(bodies: &[Body], outcomes: &[Outcome]) {
    for (index, (body, outcome)) in bodies.iter().zip(outcomes).enumerate() {
        if let Some(tick) = outcome.left {
            let turn = Kind::ALL.iter().position(|&kind| kind == body.kind);
            let name = turn.map_or("", |turn| Kind::NAMES[turn]);
            println!("{index}: {name}, tick {tick}");
        }
    }
}
