//! How many times as fast one contestant is as another.

use crate::contestant::{Id, Kind, Precision};
use crate::race::{LEVELS, Race, geometric_mean};
use std::cmp::Reverse;

/// Times of one contestant over those of another, scene by scene.
pub(crate) struct Comparison {
    /// Scene, and how many times faster the second is.
    pub(crate) ratios: Vec<(String, f64)>,
    /// Scenes that the first solves and the second does not.
    pub(crate) lost: Vec<String>,
}

/// How many times faster `ours` is than `theirs` to this error, on the scenes that `theirs` solves.
pub(crate) fn compare<'a>(
    races: impl Iterator<Item = &'a Race>,
    (ours, theirs): (Id, Id),
    error: f64,
    prepared: bool,
) -> Comparison {
    let mut comparison = Comparison { ratios: Vec::new(), lost: Vec::new() };
    for race in races {
        let name = race.scene.name.clone();
        let Some(slow) = race.time(theirs, error, prepared) else {
            continue;
        };
        match race.time(ours, error, prepared) {
            Some(fast) => comparison.ratios.push((name, slow / fast)),
            None => comparison.lost.push(name),
        }
    }
    comparison.ratios.sort_by(|a, b| a.1.total_cmp(&b.1));
    comparison
}

impl Comparison {
    pub(crate) fn mean(&self) -> f64 {
        let ratios: Vec<f64> = self.ratios.iter().map(|ratio| ratio.1).collect();
        geometric_mean(&ratios).unwrap_or(f64::NAN)
    }

    /// "1.20 times as fast as ... (slower on 3 of 37 scenes)"
    fn text(&self, whom: &str) -> String {
        let slower = self.ratios.iter().filter(|ratio| ratio.1 < 1.0).count();
        let unsolved = match self.lost.len() {
            0 => String::new(),
            lost => format!(", unsolved {lost}"),
        };
        let scenes = self.ratios.len() + self.lost.len();
        format!(
            "{:.2} times as fast as {whom} (slower on {slower}{unsolved} of {scenes} scenes)",
            self.mean()
        )
    }
}

/// Scenes with two tangents.
pub(crate) fn spatial(races: &[Race]) -> impl Iterator<Item = &Race> {
    races.iter().filter(|race| race.scene.dim == 3)
}

/// Who is fastest to each error with its factor given, of all in `f64`, by the number of scenes: a bullet an error.
pub(crate) fn winners(races: &[&Race]) -> String {
    let lines = LEVELS.map(|error| {
        let mut wins: Vec<(usize, &str)> = Vec::new();
        for race in races {
            let times = Id::ALL.into_iter().filter(|id| id.precision == Precision::F64);
            let times = times.filter_map(|id| Some((race.time(id, error, false)?, id.kind.name())));
            let Some((_, name)) = times.min_by(|a, b| a.0.total_cmp(&b.0)) else {
                continue;
            };
            match wins.iter_mut().find(|win| win.1 == name) {
                Some(win) => win.0 += 1,
                None => wins.push((1, name)),
            }
        }
        wins.sort_by_key(|win| Reverse(win.0));
        let wins: Vec<String> = wins.iter().map(|(count, name)| format!("{name} on {count}")).collect();
        format!("- {error:e}: {}", wins.join(", "))
    });
    lines.join("\n")
}

/// The next paragraph: the default method beside Gauss-Seidel, itself in `f32`, and `peers`, the result of the run against the external
/// solvers.
pub(crate) fn paragraph(races: &[Race], peers: &str) -> String {
    let (double, single) = (Kind::Default.double(), Kind::Default.single());
    let rival = Kind::GaussSeidel.double();
    let mut found = Vec::new();
    for error in [LEVELS[0], LEVELS[1]] {
        for prepared in [false, true] {
            let what = if prepared { " with prepare" } else { "" };
            let beside = compare(spatial(races), (double, rival), error, prepared);
            found.push(beside.text(&format!("Gauss-Seidel{what} to {error:e}")));
        }
    }
    let beside = compare(spatial(races), (single, double), LEVELS[0], false);
    found.push(beside.text(&format!("itself in f64, in f32 to {:e}", LEVELS[0])));
    format!(
        "The default method, in geometric means over the feasible spatial scenes, is\n\n- {}.\n\nAgainst the fastest external solver, \
         chosen per scene in hindsight, it is {peers}",
        found.join(";\n- ")
    )
}
