//! The constants of the method. `guide/reports/tuning.md` lists the effect of halving, doubling and removing each of them.
//!
//! With `--cfg stiction_tuning` an environment variable with the name of a constant replaces it, for `examples/tuning`.

use crate::real::Real;

/// The value of a constant.
#[cfg(not(stiction_tuning))]
#[inline]
const fn value(_: &str, constant: f64) -> f64 {
    constant
}

#[cfg(stiction_tuning)]
fn value(name: &str, constant: f64) -> f64 {
    let text = std::env::var(name).ok();
    text.and_then(|text| text.parse().ok()).unwrap_or(constant)
}

/// Constants that are real numbers, rounded to the number type of the solver.
macro_rules! numbers {
    ($($(#[$doc:meta])* $name:ident: $value:literal;)*) => {
        $($(#[$doc])*
        #[inline]
        pub(super) fn $name<T: Real>() -> T {
            T::literal(value(stringify!($name), $value))
        })*
    };
}

/// Constants that are counts.
macro_rules! counts {
    ($($(#[$doc:meta])* $name:ident: $value:literal;)*) => {
        $($(#[$doc])*
        #[inline]
        #[cfg(not(stiction_tuning))]
        pub(super) const fn $name() -> usize {
            $value
        }

        $(#[$doc])*
        #[cfg(stiction_tuning)]
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        pub(super) fn $name() -> usize {
            value(stringify!($name), f64::from($value)) as usize
        })*
    };
}

numbers! {
    /// Cold start: a contact clearly separates if `alpha_i q_N` is above this share of the expected size of the impulses.
    open_threshold: 0.03;
    /// Cold start: an approach slower than this share of the tangential velocity does not tell the load of a contact, and does not count.
    grazing: 1e-4;
    /// Cold start: the guess is that all contacts stick if that needs no more than this share of their friction.
    sticking: 1.0;

    /// Newton: the step from the guess that all contacts stick may raise the merit by this factor.
    merit_growth: 1e5;
    /// Newton: chord steps follow as long as the merit falls to at most this share in each step.
    chord_fall: 0.1;

    /// Damping: `δ` over the estimate of the error.
    damping: 1e-6;
    /// Damping: `δ` over the estimate in steps that finish the central path.
    finish_damping: 0.1;

    /// Central path: the first `tau` over the mean of `alpha |q|²`.
    first_tau: 10.0;
    /// Central path: the first `tau` is smaller if the estimate of the error times this is below 1.
    tau_share: 2.0;
    /// Central path: gain (weight of velocities against impulses) at the start of the first path.
    first_gain: 10.0;
    /// Central path: a step ends before this last share of the way to the boundary of the cones.
    margin: 0.02;
    /// Central path: a step shorter than this is corrected once more.
    correct_again: 0.95;
    /// Central path: Newton's method finishes if the estimate of the error is below this.
    near: 1e-3;
    /// Central path: a step shorter than this is a jam.
    jammed: 0.02;
    /// Central path: a jam raises `tau` by this factor, in the second round of [`WEIGHTS`] by twice as much, and so on.
    tau_raise: 9.0;
}

counts! {
    /// Sweeps: least number of a phase. They continue as long as this many more reach the tolerance at the present rate: a Newton step with
    /// its solves takes as long.
    sweeps: 8;

    /// Newton: largest number of steps in a row.
    newton_steps: 30;
    /// Newton: largest number of chord steps in a row; together they cost somewhat less than a new Jacobian.
    chord_steps: 4;

    /// Central path: a path of this many steps has jammed.
    longest_path: 30;
    /// Central path: number of sweeps after a jam.
    sweeps_at_jam: 5;
    /// Central path: the path after this many jams and one more begins with the `tau` of a path that begins far away, over the root of `eps`.
    jams_to_farthest: 2;

    /// Work without a halved error after which rounding is to blame, if the error is below `1024 eps`.
    patience: 1000;
}

/// Lengths of a Newton step that are tried, in this order.
pub(super) const LENGTHS: [f64; 2] = [1.0, 0.5];

/// Weights `beta` of friction on the central path, one after each jam.
pub(super) const WEIGHTS: [f64; 8] = [10.0, 3.0, 1.0, 0.3, 30.0, 0.1, 100.0, 0.03];

/// Gains at the start of another path (see [`first_gain`]), one after each jam.
pub(super) const GAINS: [f64; 2] = [1.0, 10.0];
