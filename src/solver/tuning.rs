//! The constants of the method that could be others; `guide/reports/tuning.md` has what half, twice and none of each does.
//!
//! With `--cfg stiction_tuning` a variable of the environment replaces a constant: `examples/tuning` measures so.

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

/// Numbers, rounded to the type that the kernel computes with.
macro_rules! numbers {
    ($($(#[$doc:meta])* $name:ident: $value:literal;)*) => {
        $($(#[$doc])*
        #[inline]
        pub(super) fn $name<T: Real>() -> T {
            T::literal(value(stringify!($name), $value))
        })*
    };
}

/// Counts.
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
    /// Cold start: `alpha_i q_N` over the size of the impulses to expect above which a contact clearly separates.
    open_threshold: 0.03;
    /// Cold start: share of the tangential velocity below which an approach does not tell how hard a contact will be
    /// pressed, and is left out of account.
    grazing: 1e-4;
    /// Cold start: all contacts are taken to stick if that needs no more than this share of their friction.
    sticking: 1.0;

    /// Sweeps are fast if one leaves at most this share of the natural map.
    sweep_rate: 0.5;

    /// Newton: the step from the guess that all contacts stick may raise the merit so many times.
    merit_growth: 1e5;
    /// Newton: a Jacobian is used again as long as each of its steps leaves at most this share of the merit.
    chord_fall: 0.1;

    /// Damping: `λ` over the natural map.
    damping: 1e-6;
    /// Damping: that of a hyperstatic scene.
    hyperstatic_damping: 1e-3;
    /// Damping: that of steps that finish what the interior point began.
    finish_damping: 0.1;

    /// Interior point: the first `tau` over the mean of `alpha |q|²`.
    first_tau: 10.0;
    /// Interior point: gain, the scale of velocities relative to impulses when the first path is entered.
    first_gain: 10.0;
    /// Interior point: share of the way to the boundary of the cones that a step leaves.
    margin: 0.02;
    /// Interior point: a step that reaches less far than this is corrected once more.
    correct_again: 0.95;
    /// Interior point: natural map below which Newton's method is to finish.
    near: 1e-3;
    /// Interior point: it has jammed if a step goes less far than this.
    jammed: 0.1;
    /// Interior point: out of a jam `tau` is raised so many times, in the next round of [`WEIGHTS`] twice as high, and so on.
    tau_raise: 9.0;
}

counts! {
    /// Sweeps that are made as long as they are fast. (Further ones are made if five more reach the tolerance.)
    fast_sweeps: 3;

    /// Sweeps before the central path: as long as so many in all reach the tolerance at their present rate.
    sweeps_before_path: 40;

    /// Newton: steps of one phase.
    newton_steps: 30;
    /// Newton: steps with one Jacobian, which cost somewhat less than a new one.
    chord_steps: 4;

    /// Interior point: it has jammed, too, after so many steps on one path.
    longest_path: 30;
    /// Interior point: sweeps that lead out of a jam.
    sweeps_at_jam: 5;
    /// Interior point: one jam in so many is left from the best impulses so far, but not the first.
    jams_to_best: 3;
    /// Interior point: jams after which one in four is left from impulses drawn at random.
    jams_to_anywhere: 12;

    /// Work without a halved error after which rounding is to blame, if the error is below `1024 eps`.
    patience: 1000;
}

/// Lengths of a Newton step.
pub(super) const LENGTHS: [f64; 2] = [1.0, 0.5];

/// Weights of friction on the central path, one jam after the other.
pub(super) const WEIGHTS: [f64; 8] = [3.0, 1.0, 10.0, 0.3, 30.0, 0.1, 100.0, 0.03];

/// Gains with which the central path is entered again, see [`first_gain`], one jam after the other.
pub(super) const GAINS: [f64; 2] = [1.0, 10.0];
