//! Which contact takes what from which, against the sentence of [`crate::Contact::key`].
#![allow(clippy::indexing_slicing)]

extern crate std;

use super::WarmStart;
use crate::Contact;
use nalgebra::{Matrix1, Vector1};
use proptest::collection::vec;
use proptest::prelude::*;
use std::vec::Vec;

const C: usize = 5;

fn contacts(keys: &[u32]) -> Vec<Contact<f64, 1, 1>> {
    let contact = |&key| Contact {
        jacobian: Matrix1::new(1.0),
        offset: Vector1::zeros(),
        mu: 0.0,
        key,
    };
    keys.iter().map(contact).collect()
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
            let contacts = contacts(keys);
            state.follow(&contacts);
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
            state.keep(&contacts, left, false);
        }
    }
}
