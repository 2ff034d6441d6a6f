//! Which contact takes what from which, against the sentence of [`crate::Contact::key`].
#![allow(clippy::float_cmp, clippy::indexing_slicing)]

extern crate std;

use super::WarmStart;
use crate::problem::Problem;
use crate::solver::point::Point;
use crate::{Contact, Error, Factor, Model, Scene};
use nalgebra::{Matrix1, Vector1};
use proptest::collection::vec;
use proptest::prelude::*;
use std::string::ToString;
use std::vec::Vec;

const C: usize = 5;

fn scene(keys: &[u32]) -> Result<Scene<f64, 1, 1, C>, Error> {
    let mut scene = Scene::new();
    scene.set_mass(&Matrix1::new(1.0))?;
    let contact = |&key| Contact {
        jacobian: Matrix1::new(1.0),
        offset: Vector1::zeros(),
        mu: 0.0,
        key,
    };
    for contact in keys.iter().map(contact) {
        scene.push(&contact)?;
    }
    Ok(scene)
}

/// Of place `i` among `keys`: its key, and how many of that key stand before it.
fn name(keys: &[u32], i: usize) -> (u32, usize) {
    let before = keys[..i].iter().filter(|&&key| key == keys[i]);
    (keys[i], before.count())
}

proptest! {
    #[test]
    fn the_kth_of_a_key_takes_what_the_kth_left(
        lists in vec(vec(0_u32..4, 0..=C), 2..6),
    ) {
        let mut state = WarmStart::<f64, 1, C>::cold();
        let mut last: Vec<((u32, usize), f64)> = Vec::new();
        for (step, keys) in lists.iter().enumerate() {
            let scene = scene(keys).map_err(|error| TestCaseError::fail(error.to_string()))?;
            let factor = Factor::new(&scene);
            let factor = factor.map_err(|error| TestCaseError::fail(error.to_string()))?;
            state.follow(&scene);
            let names: Vec<_> = (0..keys.len()).map(|i| name(keys, i)).collect();
            for (i, contact) in state.contacts.iter().enumerate() {
                let left = last.iter().find(|(name, _)| names.get(i) == Some(name));
                prop_assert_eq!(contact.map(|c| c.r.x), left.map(|&(_, r)| r));
            }
            // Each contact of each step leaves something of its own.
            let values = (0_u32..).zip(&names).map(|(i, &name)| {
                let number = f64::from(i) + 10.0 * f64::from(u32::try_from(step).unwrap_or(0));
                (name, number)
            });
            last = values.collect();
            let left = last.iter().map(|&(_, r)| (Vector1::new(-r), Vector1::new(r)));
            state.keep((&scene, &factor), left, false);
        }
    }
}

/// Impulses go on from tick to tick; a second pass of the same tick begins where the first has ended.
#[test]
fn impulses_are_extrapolated_once_a_tick() -> Result<(), Error> {
    let scene = scene(&[0])?;
    let (factor, push) = (Factor::new(&scene)?, Vector1::new(-4.0));
    let mut problem = Problem::new(&scene, &factor, &push, Model::Coulomb);
    problem.fill(true);
    let mut state = WarmStart::<f64, 1, C>::cold();
    for r in [1.0, 2.0] {
        let left = [(Vector1::new(0.0), Vector1::new(r))].into_iter();
        state.keep((&scene, &factor), left, false);
    }
    for (onwards, r) in [(true, 3.0), (false, 2.0)] {
        let mut point = Point::none();
        state.start(&problem, (1e-9, onwards), &mut point);
        assert_eq!(point.r[0], [r]);
    }
    Ok(())
}
