//! Fingerprints of different numbers differ.
#![allow(clippy::integer_division)]

extern crate std;

use super::fingerprint;
use crate::real::Real;
use std::collections::HashSet;
use std::vec::Vec;

/// Of 300,000 hashes of 32 bits ten would be those of others, as good as for certain.
#[test]
fn no_two_of_many_scenes_have_the_same_fingerprint() {
    let numbers = |k: u32| -> Vec<f32> {
        let [x, y] = [k % 997, k / 997].map(|part| f32::from_bits(0x3f80_0000 + part));
        // Every fourth number alone changes.
        (0..36)
            .map(|i| match i % 8 {
                0 => x,
                4 => y,
                _ => 0.5,
            })
            .collect()
    };
    let prints: HashSet<u64> = (0..300_000).map(|k| fingerprint(&numbers(k), 1)).collect();
    assert_eq!(prints.len(), 300_000);
    let halves: HashSet<u64> = prints.iter().map(|print| print >> 16 << 16).collect();
    assert_eq!(halves.len(), 300_000);
}

/// What changes places or signs is told apart, which a sum would not do.
fn are_told_apart<T: Real>() {
    let numbers: Vec<T> = (0..54).map(T::count).collect();
    let mut prints = HashSet::from([fingerprint(&numbers, 1)]);
    let mut count = 1;
    for i in 1..54 {
        for j in 1..i {
            let mut swapped = numbers.clone();
            swapped.swap(i, j);
            let mut mirrored = numbers.clone();
            for (k, number) in mirrored.iter_mut().enumerate() {
                if k == i || k == j {
                    *number = -*number;
                }
            }
            prints.extend([&swapped, &mirrored].map(|numbers| fingerprint(numbers, 1)));
            count += 2;
        }
    }
    // Two tangents that change places.
    let rows = |a: T, b: T| [a, b, b, a];
    let rows = [rows(T::ONE, T::ZERO), rows(T::ZERO, T::ONE)];
    prints.extend(rows.map(|numbers| fingerprint(&numbers, 1)));
    assert_eq!(prints.len(), count + 2);
}

#[test]
fn numbers_that_change_places_or_signs_have_another_fingerprint() {
    are_told_apart::<f32>();
    are_told_apart::<f64>();
}
