//! The constants of the method, all of them.

/// Gauss-Seidel: a sweep is fast if it leaves at most this share of the natural map.
pub(crate) const SWEEP_RATE: f64 = 0.5;
/// Gauss-Seidel: sweeps that are made because they are fast.
pub(crate) const FAST_SWEEPS: usize = 3;
/// Gauss-Seidel: sweeps that are made because five more reach the tolerance.
pub(crate) const SWEEPS: usize = 20;
/// Gauss-Seidel: a natural map from which sweeps that are not fast lead nowhere, even if impulses are unique.
pub(crate) const FAR: f64 = 0.1;

/// ADMM: iterations of a cold start, one Newton step's worth with the resolvent.
pub(crate) const FIRST_ITERATIONS: usize = 5;
/// ADMM: iterations between rejected Newton steps.
pub(crate) const ITERATIONS: usize = 8;
/// ADMM: iterations with a penalty of another size.
pub(crate) const ITERATIONS_AFTER_RESTART: usize = 20;

/// Newton: steps of one phase.
pub(crate) const NEWTON_STEPS: u8 = 30;
/// Newton: lengths of a step that are tried. A step that is tried in vain costs as much as ten iterations, so that
/// at first there are [`LENGTHS_AT_FIRST`].
pub(crate) const LENGTHS: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.02];
/// Newton: lengths that are tried until a penalty of another size is.
pub(crate) const LENGTHS_AT_FIRST: usize = 2;
/// Newton: share of the merit that a step of full length has to take off (Armijo).
pub(crate) const ARMIJO: f64 = 2e-4;
/// Newton: how many times the merit may be after a nonmonotone step.
pub(crate) const RISE: f64 = 1e2;
/// Newton: the same where the step begins at a guess.
pub(crate) const RISE_OF_A_GUESS: f64 = 1e5;

/// Jacobian: it is used again if its own step left at most this share of the merit.
pub(crate) const REUSE_FALL: f64 = 0.01;
/// Jacobian: steps with one that was kept, as many as cost what a new one costs.
pub(crate) const CHORD_STEPS: usize = 4;
/// Jacobian: share of the merit that each of them may leave.
pub(crate) const CHORD_FALL: f64 = 0.1;
/// Jacobian: share of the merit that all of them together may leave, if they are not to be taken back.
pub(crate) const CHORDS_FALL: f64 = 0.04;

/// Damping: `λ` at level 1 and a natural map of 1.
pub(crate) const DAMPING: f64 = 1e-3;
/// Damping: the largest `λ`.
pub(crate) const LARGEST_DAMPING: f64 = 0.3;
/// Damping: the level falls tenfold with each full step down to this, and rises tenfold with each rejection.
pub(crate) const LEAST_LEVEL: f64 = 1e-3;
/// Damping: the highest level.
pub(crate) const LARGEST_LEVEL: f64 = 1e6;
/// Damping: share of its merit at which a rejected step is tried again.
pub(crate) const FALL_AFTER_REJECTION: f64 = 0.09;
/// Damping: ADMM phases after which it is tried in any case.
pub(crate) const PATIENCE: u8 = 2;

/// Fallback: work after which the penalties get another size, one Newton step counted as ten iterations.
pub(crate) const FIRST_RESTART: usize = 300;
/// Fallback: work between two such sizes.
pub(crate) const NEXT_RESTART: usize = 1000;
/// Fallback: the sizes, in units of the effective masses.
pub(crate) const SCALES: [f64; 8] = [10.0, 0.1, 100.0, 0.01, 3.0, 0.3, 1000.0, 1e-3];
/// Fallback: share of the natural map that sweeps without impulses have to reach.
pub(crate) const SIDE_BRANCH: f64 = 0.1;
/// Fallback: sweeps of every fourth restart.
pub(crate) const SWEEPS_ASIDE: usize = 20;

/// Start: `alpha_i q_N` over `|alpha q|` above which a contact clearly parts.
pub(crate) const PARTING: f64 = 0.03;
/// Start: a normal velocity that is less than this share of the tangential one does not tell how hard a contact is pressed.
pub(crate) const GRAZING: f64 = 1e-4;
/// Start: a contact goes on sliding if it slides so many times as fast as friction could stop it.
pub(crate) const SLIDING: f64 = 4.0;
/// Start: contacts stick if friction is needed up to this share.
pub(crate) const STICKING: f64 = 0.75;
