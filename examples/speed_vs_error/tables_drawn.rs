//! The tables of the drawn scenes: how work and time are distributed.

use crate::contestant::{Id, Kind};
use crate::drawn::Drawn;
use crate::race::Race;
use crate::tables::{DOUBLE, micro, table};
use crate::verdict;
use testbed::generate::Class;

/// Shares of the scenes, in %: the last is the worst scene.
const SHARES: [usize; 4] = [50, 90, 99, 100];

/// What a share of the scenes takes at most, infinite for those unsolved.
fn distribution(mut values: Vec<f64>) -> [f64; SHARES.len()] {
    values.sort_unstable_by(f64::total_cmp);
    SHARES.map(|share| {
        let rank = (values.len() * share).div_ceil(100).max(1);
        values.get(rank - 1).copied().unwrap_or(f64::INFINITY)
    })
}

/// Time (ns) and work of the fastest solves to an error, of each scene; infinite for those unsolved.
fn costs(races: &[&Race], id: Id, level: f64) -> [Vec<f64>; 2] {
    let rungs = races.iter().map(|race| race.run(id).and_then(|run| run.fastest(level)));
    let of = rungs.map(|rung| {
        rung.map_or((f64::INFINITY, f64::INFINITY), |rung| (rung.time.least, rung.effort.work() as f64))
    });
    let (times, work) = of.unzip();
    [times, work]
}

/// How many scenes are solved, and the cells of their time and work.
fn cells(races: &[&Race], id: Id, level: f64) -> Vec<String> {
    let [times, work] = costs(races, id, level);
    let solved = times.iter().filter(|time| time.is_finite()).count();
    let or_none = |value: f64, text: fn(f64) -> String| {
        if value.is_finite() { text(value) } else { "-".to_owned() }
    };
    let mut cells = vec![solved.to_string()];
    cells.extend(distribution(times).map(|time| or_none(time, micro)));
    cells.extend(distribution(work).map(|work| or_none(work, |work| format!("{work}"))));
    cells
}

fn columns(first: &[&str]) -> Vec<String> {
    let mut columns: Vec<String> = first.iter().map(|&column| column.to_owned()).collect();
    for what in ["µs", "work"] {
        columns.extend(SHARES.map(|share| match share {
            50 => format!("{what}, median"),
            100 => format!("{what}, worst"),
            share => format!("{what}, {share} %"),
        }));
    }
    columns
}

/// Every contestant over all drawn scenes, to one error.
pub(crate) fn solvers(drawn: &Drawn, level: f64) -> String {
    let races: Vec<&Race> = drawn.races.iter().collect();
    let rows = Id::ALL.into_iter().map(|id| {
        let mut row = vec![id.name()];
        row.extend(cells(&races, id, level));
        row
    });
    table(&columns(&["solver", "solved"]), rows)
}

/// The default method on each class, on scenes of one contact and on those where nothing touches, and how many times
/// faster than its rivals it is there.
pub(crate) fn parts(drawn: &Drawn, level: f64) -> String {
    let rivals = [Kind::GaussSeidel, Kind::AlartCurnier].map(Kind::double);
    let mut columns = columns(&["scenes", "number", "solved"]);
    columns.extend(rivals.map(|id| format!("{}: time, slower on", id.name())));
    let classes = Class::DRAWN.iter();
    let mut parts: Vec<(String, Vec<&Race>)> =
        classes.map(|&class| (format!("`{class:?}`"), drawn.of(class))).collect();
    parts.push(("one contact".to_owned(), drawn.of_one_contact()));
    parts.push(("nothing touches".to_owned(), drawn.of_no_touch()));
    parts.push(("all".to_owned(), drawn.races.iter().collect()));
    let rows = parts.into_iter().map(|(name, races)| {
        let mut row = vec![name, races.len().to_string()];
        row.extend(cells(&races, DOUBLE, level));
        row.extend(rivals.map(|rival| {
            let found = verdict::compare(races.iter().copied(), (DOUBLE, rival), level, false);
            let slower = found.ratios.iter().filter(|ratio| ratio.1 < 1.0).count();
            match found.ratios.len() {
                0 => "-".to_owned(),
                count => format!("{:.2}, {slower} of {count}", found.mean()),
            }
        }));
        row
    });
    table(&columns, rows)
}
