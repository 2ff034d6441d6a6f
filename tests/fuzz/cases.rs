//! How many cases, and of which a stranger can tell the error. (`examples/c_firmware/fuzz` has this file, too.)

use proptest::prelude::ProptestConfig;
use proptest::test_runner::RngSeed;
use stiction::Real;

/// The same cases each time, or as many others as `PROPTEST_CASES` says. Found things are kept as plain tests.
pub(super) fn cases() -> ProptestConfig {
    let random = ProptestConfig::default();
    ProptestConfig {
        failure_persistence: None,
        max_shrink_iters: 20_000,
        rng_seed: match std::env::var_os("PROPTEST_CASES") {
            None => RngSeed::Fixed(1),
            Some(_) => random.rng_seed,
        },
        ..random
    }
}

/// Numbers whose squares of squares neither overflow nor vanish in the number type of a scene, nor in f64.
pub(super) fn is_tame<'a, T: Real>(numbers: impl IntoIterator<Item = &'a f64>) -> bool {
    let largest = if T::EPSILON < T::literal(1e-10) { 1e12 } else { 1e8 };
    let mut numbers = numbers.into_iter();
    numbers.all(|x| *x == 0.0 || (1.0 / largest..largest).contains(&x.abs()))
}
