//! What became of the scenes of a class, and what work they took.

use std::fmt;
use testbed::generate::Existence;
use testbed::solve::{Answer, Outcome};

/// A proof of infeasibility must ask for velocities this many times those of the offsets.
const STRONG_PROOF: f64 = 1e3;
/// Work that a control loop would not wait for.
const MUCH_WORK: usize = 1000;

/// What an answer is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Solved,
    /// Proved to have no solution.
    Infeasible,
    /// Not solved, though a solution exists or a proof that there is none.
    Unsolved,
    /// Not solved, and nobody knows whether there is a solution.
    Unknown,
    /// The number type cannot hold the scene.
    Refused,
    /// Said to be solved, but the error is larger than the tolerance.
    FalselySolved,
    /// Said to have no solution, but there is one, or the certificate proves nothing.
    FalselyInfeasible,
}

impl Verdict {
    const ALL: [Self; 7] = [
        Self::Solved,
        Self::Infeasible,
        Self::Unsolved,
        Self::Unknown,
        Self::Refused,
        Self::FalselySolved,
        Self::FalselyInfeasible,
    ];

    pub(crate) fn new(outcome: &Outcome, existence: Existence, tolerance: f64) -> Self {
        match outcome.answer {
            Answer::Solved if outcome.error <= tolerance => Self::Solved,
            Answer::Solved => Self::FalselySolved,
            Answer::Infeasible { proof } if existence != Existence::Guaranteed && proof >= STRONG_PROOF => {
                Self::Infeasible
            }
            Answer::Infeasible { .. } => Self::FalselyInfeasible,
            Answer::Unsolved if existence == Existence::Unknown => Self::Unknown,
            Answer::Unsolved => Self::Unsolved,
            Answer::Refused(_) => Self::Refused,
        }
    }

    pub(crate) fn is_false(self) -> bool {
        matches!(self, Self::FalselySolved | Self::FalselyInfeasible)
    }

    /// Whether somebody should look at the scene.
    pub(crate) fn is_noted(self) -> bool {
        self.is_false() || self == Self::Unsolved
    }
}

/// Verdicts and work of a class, or of all.
#[derive(Clone)]
pub(crate) struct Tally {
    name: String,
    counts: [usize; Verdict::ALL.len()],
    /// Of each scene that was not refused.
    work: Vec<usize>,
}

impl Tally {
    pub(crate) fn new(name: String) -> Self {
        Self { name, counts: [0; Verdict::ALL.len()], work: Vec::new() }
    }

    /// All scenes of these tallies.
    pub(crate) fn sum(name: &str, tallies: &[Self]) -> Self {
        let mut sum = Self::new(name.to_owned());
        for tally in tallies {
            for (count, more) in sum.counts.iter_mut().zip(tally.counts) {
                *count += more;
            }
            sum.work.extend(&tally.work);
        }
        sum
    }

    pub(crate) fn add(&mut self, verdict: Verdict, work: usize) {
        for (count, of) in self.counts.iter_mut().zip(Verdict::ALL) {
            *count += usize::from(of == verdict);
        }
        if verdict != Verdict::Refused {
            self.work.push(work);
        }
    }

    pub(crate) fn count(&self, wanted: impl Fn(Verdict) -> bool) -> usize {
        let counts = self.counts.iter().zip(Verdict::ALL);
        counts.filter(|&(_, of)| wanted(of)).map(|(n, _)| n).sum()
    }

    /// The head of the table; work is that in the median, at 90 and 99 %, and at most.
    pub(crate) fn header() -> String {
        format!(
            "{:<14} {:>7} {:>7} {:>10} {:>8} {:>7} {:>7} {:>12} {:>16} {:>30} {:>6}",
            "class",
            "scenes",
            "solved",
            "infeasible",
            "unsolved",
            "unknown",
            "refused",
            "false solved",
            "false infeasible",
            "work 50 %   90 %   99 %    max",
            "> 1000"
        )
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<14} {:>7}", self.name, self.count(|_| true))?;
        for (count, width) in self.counts.iter().zip([7, 10, 8, 7, 7, 12, 16]) {
            write!(f, " {count:>width$}")?;
        }
        let mut work = self.work.clone();
        work.sort_unstable();
        let percentile = |p: usize| work.get(work.len() * p / 100).or(work.last()).unwrap_or(&0);
        let [median, ninety, ninety_nine, worst] = [50, 90, 99, 100].map(percentile);
        let much = work.iter().filter(|&&work| work > MUCH_WORK).count();
        write!(f, " {median:>9} {ninety:>6} {ninety_nine:>6} {worst:>6} {much:>6}")
    }
}
