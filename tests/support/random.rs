//! Random scenes that have a solution, as proptest strategies.

use nalgebra::{SMatrix, SVector};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use stiction::{Contact, Scene};

/// A scene of the kernel and its `f`.
pub(crate) type Case<const N: usize, const D: usize, const C: usize> = (Scene<f64, N, D, C>, SVector<f64, N>);

/// The same draws each time, for what is said of a share of them.
pub(crate) fn draws<S: Strategy>(strategy: S, count: usize) -> impl Iterator<Item = S::Value> {
    let mut runner = TestRunner::deterministic();
    (0..count).map(move |_| {
        let tree = strategy.new_tree(&mut runner);
        tree.expect("nothing is filtered").current()
    })
}

/// `count` numbers between -1 and 1.
pub(crate) fn numbers(count: usize) -> impl Strategy<Value = Vec<f64>> {
    vec(-1.0..1.0, count)
}

/// So many contacts with dense Jacobians on a dense, well-conditioned mass matrix, at rest (`w = 0`:
/// then `v = 0` is feasible and a solution exists), with friction coefficients up to `max_mu`.
pub(crate) fn scenes<const N: usize, const D: usize, const C: usize>(
    contacts: usize,
    max_mu: f64,
) -> impl Strategy<Value = Case<N, D, C>> {
    let mus = vec(0.0..=max_mu, contacts);
    (numbers(N * N), numbers(contacts * D * N), numbers(N), mus).prop_map(|(root, h, f, mu)| {
        let root = SMatrix::<f64, N, N>::from_iterator(root);
        let mut scene = Scene::new();
        let mass = root * root.transpose() + SMatrix::identity();
        scene.set_mass(&mass).expect("M is symmetric");
        for (h, mu) in h.chunks(D * N).zip(mu) {
            let contact =
                Contact { jacobian: SMatrix::from_column_slice(h), offset: SVector::zeros(), mu, key: 0 };
            scene.push(&contact).expect("the contact is valid");
        }
        (scene, SVector::from_iterator(f))
    })
}
