//! A Markdown table of what became of bodies.

use crate::body::{Body, Kind};
use crate::run::{Outcome, Plan, Setting};

pub(crate) fn head() {
    println!(
        "| load | setting | slid | by kind | in tick 0 | when the load came | later | moved and stopped | unsolved ticks | work per tick |"
    );
    println!("|---|---|--:|---|--:|--:|--:|--:|--:|--:|");
}

pub(crate) fn print(load: &str, (setting, plan): (Setting, Plan), bodies: &[Body], outcomes: &[Outcome]) {
    let slid = |kind: Option<Kind>, first: usize, end: usize| {
        let pairs = bodies.iter().zip(outcomes);
        let of_kind = pairs.filter(|(body, _)| kind.is_none_or(|kind| body.kind == kind));
        let left = of_kind.filter_map(|(_, outcome)| outcome.left);
        left.filter(|tick| (first..end).contains(tick)).count()
    };
    let all = |kind| slid(kind, 0, usize::MAX);
    let kinds = Kind::ALL.map(|kind| all(Some(kind)).to_string());
    let sum = |of: fn(&Outcome) -> usize| outcomes.iter().map(of).sum::<usize>();
    let alone = plan.alone.max(1);
    let at_load = if plan.alone == 0 { 0 } else { slid(None, alone, alone + 1) };
    println!(
        "| {load} | {} | {} of {} | {} | {} | {} | {} | {} | {} | {:.2} |",
        setting.name,
        all(None),
        bodies.len(),
        kinds.join(" "),
        slid(None, 0, 1),
        at_load,
        all(None) - slid(None, 0, 1) - at_load,
        sum(|outcome| usize::from(outcome.has_moved)),
        sum(|outcome| outcome.unsolved),
        sum(|outcome| outcome.work) as f64 / sum(|outcome| outcome.ticks) as f64,
    );
}

/// The bodies that slid, with the ticks in which they left.
pub(crate) fn list(bodies: &[Body], outcomes: &[Outcome]) {
    for (index, (body, outcome)) in bodies.iter().zip(outcomes).enumerate() {
        if let Some(tick) = outcome.left {
            println!("{index}: {}, tick {tick}", body.kind.name());
        }
    }
}
