//! What came of a solve, and the summary of many.

/// One scene solved by one variant.
pub(crate) struct Outcome {
    /// Is the measured error at most the tolerance?
    pub(crate) solved: bool,
    pub(crate) iterations: usize,
    /// Measured error in Coulomb's law, whatever was solved.
    pub(crate) coulomb_error: f64,
    /// `r`, row by row.
    pub(crate) impulse: Vec<f64>,
}

/// Nearest-rank quantile of numbers in ascending order.
pub(crate) fn quantile<T: Copy>(sorted: &[T], percent: usize) -> T {
    sorted[((sorted.len() - 1) * percent + 50) / 100]
}

/// `solved | median | 90 %`; an unsolved scene counts as more iterations than any.
pub(crate) fn summary(outcomes: &[Outcome]) -> String {
    let solved = solved(outcomes);
    let counts = outcomes.iter();
    let mut counts: Vec<usize> = counts.map(|o| if o.solved { o.iterations } else { usize::MAX }).collect();
    counts.sort_unstable();
    let [median, most] = [50, 90].map(|percent| match quantile(&counts, percent) {
        usize::MAX => String::from("-"),
        count => count.to_string(),
    });
    format!("{solved:>3} | {median:>4} | {most:>4}")
}

/// Number of scenes solved.
pub(crate) fn solved(outcomes: &[Outcome]) -> usize {
    outcomes.iter().filter(|outcome| outcome.solved).count()
}
