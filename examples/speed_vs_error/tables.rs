//! The tables of the report, in Markdown.

use crate::contestant::{Effort, Id, Kind, Precision};
use crate::pictures_sizes::points;
use crate::race::{LEVELS, Race, geometric_mean};
use crate::scaling::{self, Scaling, Size};
use crate::verdict;
use std::fmt::Write;

pub(crate) const DOUBLE: Id = Kind::Default.double();
/// Contestants of the tables that go scene by scene.
const COLUMNS: [Id; 7] = [
    DOUBLE,
    Kind::Default.single(),
    Kind::Restart.double(),
    Kind::GaussSeidel.double(),
    Kind::AlartCurnier.double(),
    Kind::Relaxation.double(),
    Kind::OuterLoop.double(),
];

pub(crate) fn table(columns: &[String], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut text = format!("| {} |\n|---|", columns.join(" | "));
    text += &"---:|".repeat(columns.len() - 1);
    text.push('\n');
    for row in rows {
        _ = writeln!(text, "| {} |", row.join(" | "));
    }
    text
}

/// ns as µs with three digits.
pub(crate) fn micro(time: f64) -> String {
    let time = time / 1e3;
    match time {
        ..10.0 => format!("{time:.2}"),
        ..100.0 => format!("{time:.1}"),
        _ => format!("{time:.0}"),
    }
}

/// Every contestant over all scenes.
pub(crate) fn summary(races: &[Race]) -> String {
    let mut columns = vec!["solver".to_owned()];
    columns.extend(LEVELS.map(|level| format!("solved to {level:e}")));
    columns.extend(LEVELS.map(|level| format!("time to {level:e}")));
    columns.extend(["prepare, µs", "median / least time"].map(str::to_owned));
    let rows = Id::ALL.into_iter().map(|id| {
        let mut row = vec![id.name()];
        row.extend(LEVELS.map(|level| {
            let solved = races.iter().filter(|race| race.time(id, level, false).is_some());
            solved.count().to_string()
        }));
        row.extend(LEVELS.map(|level| {
            let found = verdict::compare(races.iter(), (DOUBLE, id), level, false);
            match found.ratios.len() {
                0 => "-".to_owned(),
                count => format!("{:.2} ({count})", found.mean()),
            }
        }));
        let prepare: Vec<f64> = races.iter().filter_map(|race| Some(race.run(id)?.prepare.least)).collect();
        row.push(geometric_mean(&prepare).map_or("-".to_owned(), micro));
        let runs = races.iter().filter_map(|race| race.run(id));
        let rungs = runs.flat_map(|run| &run.rungs);
        let spread: Vec<f64> = rungs.map(|rung| rung.time.median / rung.time.least).collect();
        row.push(geometric_mean(&spread).map_or("-".to_owned(), |spread| format!("{spread:.2}")));
        row
    });
    table(&columns, rows)
}

/// Least and median time of each scene to one error.
pub(crate) fn scenes(races: &[Race], level: f64) -> String {
    let mut columns = vec!["scene".to_owned()];
    columns.extend(COLUMNS.map(Id::name));
    let rows = races.iter().map(|race| {
        let mut row = vec![race.scene.name.clone()];
        row.extend(COLUMNS.map(|id| {
            let cell = |time: crate::measure::Time| format!("{} ({})", micro(time.least), micro(time.median));
            let fastest = race.run(id).and_then(|run| run.fastest(level));
            fastest.map_or("-".to_owned(), |rung| cell(rung.time))
        }));
        row
    });
    table(&columns, rows)
}

/// Size of each scene, and what preparing it takes.
pub(crate) fn preparation(races: &[Race]) -> String {
    let mut columns = ["scene", "dofs", "contacts x rows"].map(str::to_owned).to_vec();
    columns.extend(COLUMNS.map(Id::name));
    let rows = races.iter().map(|race| {
        let scene = &race.scene;
        let mut row = vec![
            scene.name.clone(),
            scene.n_dof.to_string(),
            format!("{} x {}", scene.n_contacts, scene.dim),
        ];
        row.extend(COLUMNS.map(|id| {
            race.run(id).map_or("-".to_owned(), |run| {
                format!("{} ({})", micro(run.prepare.least), micro(run.prepare.median))
            })
        }));
        row
    });
    table(&columns, rows)
}

/// Multiply-adds that the default method's steps need, against the time that they take and the
/// instructions that were counted, if they were (`profile.py`; a line has a scene, iterations, Newton steps and
/// instructions) and if the same was done.
pub(crate) fn operations(races: &[Race], level: f64, counted: &str) -> String {
    let instructions = |scene: &str, effort: Effort| -> Option<f64> {
        let done = format!("{scene} {} {} ", effort.iterations, effort.newton_steps);
        let count = counted.lines().find_map(|line| line.strip_prefix(&done));
        count?.parse().ok()
    };
    let columns = [
        "scene",
        "dofs",
        "rows",
        "of closed contacts",
        "iterations",
        "Newton steps",
        "multiply-adds",
        "around them",
        "µs",
        "multiply-adds a ns",
        "instructions",
        "a multiply-add",
    ];
    let (mut shares, mut ratios) = (Vec::new(), Vec::new());
    let rows = races.iter().filter_map(|race| {
        let scene = &race.scene;
        let rung = race.run(DOUBLE)?.fastest(level)?;
        let (n, m) = (scene.n_dof as f64, (scene.dim * scene.n_contacts) as f64);
        let effort = rung.effort;
        let [iterations, steps] = [effort.iterations, effort.newton_steps].map(|count| count as f64);
        let k = (scene.dim * rung.closed) as f64;
        let needed = iterations * m * m + steps * (k * k * k / 3.0 + 2.0 * k * k);
        let around = 2.0 * n * n + 4.0 * n * m;
        shares.push(100.0 * around / (needed + around));
        let executed = instructions(&scene.name, effort);
        let ratio = executed.map(|executed| executed / (needed + around));
        ratios.extend(ratio);
        let or_none = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        Some(vec![
            scene.name.clone(),
            scene.n_dof.to_string(),
            format!("{m}"),
            format!("{k}"),
            effort.iterations.to_string(),
            effort.newton_steps.to_string(),
            format!("{needed:.0}"),
            format!("{around:.0}"),
            micro(rung.time.least),
            format!("{:.2}", (needed + around) / rung.time.least),
            or_none(executed.map(|executed| format!("{executed:.0}"))),
            or_none(ratio.map(|ratio| format!("{ratio:.1}"))),
        ])
    });
    let table = table(&columns.map(str::to_owned), rows);
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    format!(
        "{table}\nIn the median {:.0} % of the multiply-adds are around the method, and {:.1} instructions are executed for each of all.\n",
        median(shares),
        median(ratios),
    )
}

/// Times over sizes, and the fitted exponents in the last row.
pub(crate) fn sizes(scalings: &[Scaling], what: &str, of: fn(&Scaling) -> &Vec<Size>) -> String {
    let mut columns = vec![what.to_owned()];
    for scaling in scalings {
        let precision = match scaling.id.precision {
            Precision::F64 => "f64",
            Precision::F32 => "f32",
        };
        columns.push(format!("prepare {precision}, µs"));
        columns.push(format!("solve {precision}, µs"));
    }
    let count = scalings.first().map_or(0, |scaling| of(scaling).len());
    let mut rows: Vec<Vec<String>> = (0..count)
        .map(|k| {
            let mut row = vec![of(&scalings[0])[k].count.to_string()];
            for size in scalings.iter().map(|scaling| &of(scaling)[k]) {
                row.extend([micro(size.prepare), micro(size.solve)]);
            }
            row
        })
        .collect();
    let mut fitted = vec!["exponent".to_owned()];
    for sizes in scalings.iter().map(of) {
        for time in [|size: &Size| size.prepare, |size: &Size| size.solve] {
            fitted.push(format!("{:.2}", scaling::exponent(&points(sizes, time))));
        }
    }
    rows.push(fitted);
    table(&columns, rows.into_iter())
}

/// The scenes that cost the default method most, and by whom it is beaten there.
pub(crate) fn costliest(races: &[Race], level: f64) -> String {
    let mut order: Vec<(&Race, f64)> =
        races.iter().map(|race| (race, race.time(DOUBLE, level, false).unwrap_or(f64::INFINITY))).collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let columns = ["scene", "default method, f64, µs", "fastest other solver", "its time, µs"];
    let rows = order.into_iter().take(6).map(|(race, time)| {
        let others = Id::ALL.iter().filter(|id| !Kind::LIBRARY.contains(&id.kind));
        let times = others.filter_map(|&id| Some((id, race.time(id, level, false)?)));
        let best = times.min_by(|a, b| a.1.total_cmp(&b.1));
        let (name, other) =
            best.map_or(("-".to_owned(), "-".to_owned()), |(id, time)| (id.name(), micro(time)));
        let time = if time.is_finite() { micro(time) } else { "unsolved".to_owned() };
        vec![race.scene.name.clone(), time, name, other]
    });
    table(&columns.map(str::to_owned), rows)
}
