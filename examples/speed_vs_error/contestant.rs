//! What every solver of the comparison does, and what it is called.

/// One solver on one scene.
pub(crate) trait Contestant {
    /// Computes what depends on `M` and `H` alone.
    fn prepare(&mut self);

    /// Solves from a cold start, from `f` to `v` and `r`.
    fn solve(&mut self, tolerance: f64) -> Effort;

    /// `v` and `r` of the last solve, without padding.
    fn answer(&self) -> (Vec<f64>, Vec<f64>);
}

/// What a solve took.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Iterations or sweeps.
    pub(crate) iterations: usize,
    /// Newton or interior-point steps, each with a linear system of its own.
    pub(crate) newton_steps: usize,
    /// The solver's own stopping test was met.
    pub(crate) finished: bool,
}

impl Effort {
    /// Iterations, a Newton or interior-point step counted as ten.
    pub(crate) fn work(self) -> usize {
        self.iterations + 10 * self.newton_steps
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Plain,
    Fast,
    Restart,
    Default,
    GaussSeidel,
    AlartCurnier,
    Relaxation,
    OuterLoop,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Precision {
    F64,
    F32,
}

/// A solver and its number type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Id {
    pub(crate) kind: Kind,
    pub(crate) precision: Precision,
}

impl Kind {
    /// The methods of this crate.
    pub(crate) const LIBRARY: [Self; 4] = [Self::Plain, Self::Fast, Self::Restart, Self::Default];

    /// The name alone.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain ADMM",
            Self::Fast => "Algorithm 1",
            Self::Restart => "Algorithm 2",
            Self::Default => "default method",
            Self::GaussSeidel => "Gauss-Seidel",
            Self::AlartCurnier => "Alart-Curnier Newton",
            Self::Relaxation => "Clarabel, relaxation",
            Self::OuterLoop => "Clarabel, outer loop on s",
        }
    }

    pub(crate) const fn double(self) -> Id {
        Id { kind: self, precision: Precision::F64 }
    }

    pub(crate) const fn single(self) -> Id {
        Id { kind: self, precision: Precision::F32 }
    }
}

impl Id {
    /// All contestants, in the order of the tables.
    pub(crate) const ALL: [Self; 14] = [
        Kind::Plain.double(),
        Kind::Plain.single(),
        Kind::Fast.double(),
        Kind::Fast.single(),
        Kind::Restart.double(),
        Kind::Restart.single(),
        Kind::Default.double(),
        Kind::Default.single(),
        Kind::GaussSeidel.double(),
        Kind::GaussSeidel.single(),
        Kind::AlartCurnier.double(),
        Kind::AlartCurnier.single(),
        Kind::Relaxation.double(),
        Kind::OuterLoop.double(),
    ];

    pub(crate) fn name(self) -> String {
        match (self.kind, self.precision) {
            (Kind::Relaxation | Kind::OuterLoop, _) => self.kind.name().to_owned(),
            (_, Precision::F64) => format!("{}, f64", self.kind.name()),
            (_, Precision::F32) => format!("{}, f32", self.kind.name()),
        }
    }
}
