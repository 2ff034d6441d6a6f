//! What the tests of hard scenes ask of the kernel, and scenes made by hand.

use nalgebra::{DMatrix, DVector, SVector};
use stiction::{AdmmFactor, AdmmSolver, Error, Real, Scene, Settings, Solution, Status};
use testbed::kernel::Constructor;
use testbed::scene_file::SceneFile;
use testbed::solve::{self, Answer, Outcome};

/// Error to be reached in f64.
pub(crate) const F64: f64 = 1e-9;
/// Error to be reached in f64 by each of the scenes drawn at random from the hardest classes, of
/// which a few in a hundred end above [`F64`].
pub(crate) const DRAWN_F64: f64 = 1e-6;
/// Error to be reached in f32.
pub(crate) const F32: f64 = 1e-4;

/// The error up to which a robot uses a solution that is not solved.
pub(crate) const USABLE: f64 = 1e-2;

/// How many solves ended solved, and how many with nothing to use; the others have an error between, or a proof.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) solved: usize,
    pub(crate) unusable: usize,
}

/// Does it say that there is no solution?
pub(crate) fn is_proof(status: Status) -> bool {
    matches!(status, Status::Infeasible | Status::Jammed)
}

impl Tally {
    /// Counts a solution: can it be used?
    pub(crate) fn add<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
        &mut self,
        solution: &Solution<T, N, D, C, R>,
    ) -> bool {
        let is_usable = solution.is_usable(T::literal(USABLE));
        self.solved += usize::from(solution.is_solved());
        self.unusable += usize::from(!is_usable && !is_proof(solution.status));
        is_usable
    }
}

/// Is a count at most one in twenty above what it was? Any gain passes.
pub(crate) fn is_no_more((now, before): (usize, usize)) -> bool {
    20 * now <= 21 * before
}

/// Fails with the list of the scenes whose outcome is not as wanted.
pub(crate) fn all(
    kernel: Constructor,
    scenes: impl IntoIterator<Item = SceneFile>,
    tolerance: f64,
    mut wanted: impl FnMut(&Outcome) -> bool,
) {
    let (mut count, mut failures) = (0, Vec::new());
    for scene in scenes {
        let outcome = solve::solve(kernel, &scene, tolerance);
        count += 1;
        if !wanted(&outcome) {
            failures.push(format!("{}: {outcome:?}", scene.name));
        }
    }
    assert!(count > 0, "no scene");
    assert!(
        failures.is_empty(),
        "{} of {count} scenes to {tolerance:e}:\n{}",
        failures.len(),
        failures.join("\n")
    );
}

/// Two factors are as good as the same: Algorithm 2 solves the scene with either alike. How that ends.
pub(crate) fn same_by_admm<const N: usize, const D: usize, const C: usize>(
    scene: &Scene<f64, N, D, C>,
    factors: [&AdmmFactor<f64, N, D, C>; 2],
    push: &SVector<f64, N>,
    settings: &Settings<f64>,
) -> Result<Status, Error> {
    let (mut one, mut other) = (AdmmSolver::new(), AdmmSolver::new());
    let one = one.solve(scene, factors[0], push, settings)?;
    let other = other.solve(scene, factors[1], push, settings)?;
    assert_eq!((one.velocity, one.work), (other.velocity, other.work));
    Ok(one.status)
}

/// The kernel says that it solved each scene, and a stranger measures that it did.
pub(crate) fn solved(kernel: Constructor, scenes: impl IntoIterator<Item = SceneFile>, tolerance: f64) {
    all(kernel, scenes, tolerance, |outcome| outcome.answer == Answer::Solved && outcome.error <= tolerance);
}

/// The kernel says nothing of scenes that have a solution but what is true, and solves so many of them.
pub(crate) fn honest(
    kernel: Constructor,
    scenes: impl IntoIterator<Item = SceneFile>,
    tolerance: f64,
    floor: usize,
) {
    let mut solved = 0;
    all(kernel, scenes, tolerance, |outcome| match outcome.answer {
        Answer::Solved => {
            solved += 1;
            outcome.error <= tolerance
        }
        Answer::Infeasible { .. } => false,
        Answer::Unsolved | Answer::Refused(_) => true,
    });
    assert!(solved >= floor, "{solved} solved");
}

/// A contact of a scene made by hand: rows `H_i`, offset `w_i`, `mu_i`.
pub(crate) type Rows<'a, const D: usize> = ([&'a [f64]; D], [f64; D], f64);

/// A scene with a diagonal mass matrix.
pub(crate) fn scene<const D: usize>(
    name: &str,
    mass: &[f64],
    f: &[f64],
    contacts: &[Rows<'_, D>],
) -> SceneFile {
    let rows = contacts.iter().flat_map(|(rows, _, _)| rows.concat());
    let offsets = contacts.iter().flat_map(|&(_, w, _)| w);
    SceneFile {
        name: name.to_owned(),
        n_dof: mass.len(),
        n_contacts: contacts.len(),
        dim: D,
        mass: DMatrix::from_diagonal(&DVector::from_row_slice(mass)),
        h: DMatrix::from_row_iterator(D * contacts.len(), mass.len(), rows),
        f: DVector::from_row_slice(f),
        w: DVector::from_iterator(D * contacts.len(), offsets),
        mu: contacts.iter().map(|&(_, _, mu)| mu).collect(),
        keys: vec![0; contacts.len()],
    }
}
