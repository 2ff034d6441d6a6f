//! The constants of the method that could be others; `guide/tuning.md` has what half, twice and none of each does.
//!
//! With `--cfg stiction_tuning` a variable of the environment replaces a constant: `examples/tuning` measures so.

use crate::Real;

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
    /// Cold start: `alpha_i q_N` over `|alpha q|` above which a contact clearly parts.
    parting: 0.03;
    /// Cold start: share of the tangential velocity below which the normal one does not tell how hard a contact is
    /// pressed.
    grazing: 1e-4;
    /// Cold start: a contact goes on sliding if it slides so many times as fast as friction could stop.
    sliding: 4.0;
    /// Cold start: all contacts are taken to stick if that needs no more than this share of their friction.
    sticking: 0.75;

    /// Sweeps are fast if one leaves at most this share of the natural map.
    sweep_rate: 0.5;

    /// Newton: the step from the guess that all contacts stick may raise the merit so many times.
    rise: 1e5;
    /// Newton: a Jacobian is used again as long as each of its steps leaves at most this share of the merit.
    chord_fall: 0.1;
    /// Newton: steps with one Jacobian are taken back if together they leave more than this share.
    chords_fall: 0.04;

    /// Damping: `λ` over the natural map, at level 1.
    damping: 1e-3;
    /// Damping: the largest `λ`. Without it, 10 more of 300,000 scenes of the campaign stay unsolved.
    largest_damping: 0.3;
    /// Damping: each full step lowers the level tenfold down to this, each rejected one raises it to 1 or tenfold.
    least_level: 1e-3;
    /// Damping: the highest level.
    largest_level: 1e6;
    /// Damping: share of the merit of a rejected step at which another is tried.
    fall_after_rejection: 0.09;

    first_energy: 1.0;
    first_gain: 10.0;
    near: 1e-4;
    stalled: 0.7;
    jam: 0.1;
    beta: 3.0;
    lift: 9.0;
    boundary: 0.99;
    correct_again: 0.95;

    /// Fallback: share of the natural map that sweeps without impulses have to reach to be followed.
    side_branch: 0.1;
}

counts! {
    /// Sweeps that are made as long as they are fast. (Further ones are made if five more reach the tolerance.)
    fast_sweeps: 3;

    /// ADMM: iterations of a cold start.
    first_iterations: 5;
    /// ADMM: iterations between rejected Newton steps.
    iterations: 8;
    /// ADMM: iterations with a penalty of another size, and sweeps of every fourth such attempt.
    after_restart: 20;

    from_w: 1;
    interior_start: 3;
    jam_sweeps: 10;
    finish_steps: 6;
    /// Newton: steps of one phase.
    newton_steps: 30;
    /// Newton: lengths of a step that are tried, of [`LENGTHS`], until a penalty of another size is.
    lengths_at_first: 2;
    /// Newton: steps with one Jacobian, which cost somewhat less than a new one.
    chord_steps: 4;

    /// Damping: ADMM phases after which a step is tried in any case.
    patience: 2;

    /// Fallback: work after which the penalties get another size.
    first_restart: 300;
    /// Fallback: work between two such sizes.
    next_restart: 1000;
}

/// Lengths of a Newton step.
pub(super) const LENGTHS: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.02];

/// Sizes of the penalties, in effective masses, one after the other.
pub(super) const SCALES: [f64; 8] = [10.0, 0.1, 100.0, 0.01, 3.0, 0.3, 1000.0, 1e-3];
