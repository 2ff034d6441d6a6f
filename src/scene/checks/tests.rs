//! Fingerprints of different numbers differ.
#![allow(clippy::integer_division)]

extern crate std;

use super::fingerprint;
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
