//! The entries that contacts and joint rows of a scene take over from the last one, as [`crate::Contact::key`] says.
#![allow(clippy::float_cmp, clippy::indexing_slicing)]

extern crate std;

use super::WarmStart;
use crate::linalg::stacked::Stacked;
use crate::solver::fixtures::with_solve_from;
use crate::solver::record::Call;
use crate::solver::state::State;
use crate::{Contact, Error, JointRow, RowLaw, Scene};
use nalgebra::{Matrix1, Vector1};
use proptest::collection::vec;
use proptest::prelude::*;
use std::string::ToString;
use std::vec::Vec;

const C: usize = 5;
const R: usize = 3;

/// A mass with contacts and joint rows of these keys.
fn scene<const R: usize>(keys: &[u32], rows: &[u32]) -> Result<Scene<f64, 1, 1, C, R>, Error> {
    let mut scene = Scene::new();
    scene.set_mass(&Matrix1::new(1.0))?;
    let contact = |&key| Contact { jacobian: Matrix1::new(1.0), offset: Vector1::zeros(), mu: 0.0, key };
    for contact in keys.iter().map(contact) {
        scene.push(&contact)?;
    }
    for &key in rows {
        scene.push_row(&JointRow {
            row: Vector1::new(1.0),
            offset: 0.0,
            law: RowLaw::Limit,
            compliance: 0.0,
            key,
        })?;
    }
    Ok(scene)
}

/// The key at index `i`, and the number of equal keys before it.
fn name(keys: &[u32], i: usize) -> (u32, usize) {
    let before = keys[..i].iter().filter(|&&key| key == keys[i]);
    (keys[i], before.count())
}

/// The name and the impulse of each contact (or joint row) of a list.
type Impulses = Vec<((u32, usize), f64)>;

/// Different impulses for all of a list, in all steps.
fn impulses(keys: &[u32], step: u32, first: f64) -> Impulses {
    let names = (0..keys.len()).map(|i| name(keys, i));
    let numbered = (0_u32..).zip(names);
    numbered.map(|(i, name)| (name, first + f64::from(i) + 10.0 * f64::from(step))).collect()
}

/// The old index and the impulse that index `i` of a list takes over.
fn taken(keys: &[u32], i: usize, last: &Impulses) -> Option<(usize, f64)> {
    let name = (i < keys.len()).then(|| name(keys, i))?;
    let index = last.iter().position(|&(other, _)| other == name)?;
    Some((index, last[index].1))
}

/// Follows contacts and joint rows through several scenes.
fn check<const R: usize>(lists: &[(Vec<u32>, Vec<u32>)]) -> Result<(), TestCaseError> {
    let mut state = WarmStart::<f64, 1, C, R>::cold();
    let [mut last, mut last_rows] = [Impulses::new(), Impulses::new()];
    for (step, (keys, rows)) in (0..).zip(lists) {
        let rows = &rows[..rows.len().min(R)];
        let scene = scene::<R>(keys, rows);
        let scene = scene.map_err(|error| TestCaseError::fail(error.to_string()))?;
        let earlier_indices = state.follow(&scene);
        let contacts: Vec<_> = (0..C).map(|i| taken(keys, i, &last)).collect();
        let joints: Vec<_> = (0..R).map(|j| taken(rows, j, &last_rows)).collect();
        for (entry, taken) in state.contacts.entries.iter().zip(&contacts) {
            prop_assert_eq!(entry.map(|c| c.r[0]), taken.map(|(_, r)| r));
        }
        for (entry, taken) in state.rows.entries.iter().zip(&joints) {
            prop_assert_eq!(entry.map(|c| c.r[0]), taken.map(|(_, r)| r));
        }
        if let Some(old) = earlier_indices {
            for (i, &index) in old.contacts.iter().enumerate().take(keys.len()) {
                prop_assert_eq!(index, contacts[i].map_or(C, |(index, _)| index));
            }
            for (j, &index) in old.rows.iter().enumerate().take(rows.len()) {
                prop_assert_eq!(index, joints[j].map_or(R, |(index, _)| index));
            }
        } else {
            // There is no last solve, or no index has changed.
            let stays = |keys: &[u32], last: &Impulses| {
                last.iter().map(|&(name, _)| name).eq((0..keys.len()).map(|i| name(keys, i)))
            };
            let known = last.len() + last_rows.len() > 0;
            prop_assert!(!known || stays(keys, &last) && stays(rows, &last_rows));
        }
        (last, last_rows) = (impulses(keys, step, 0.0), impulses(rows, step, 0.5));
        let mut r = Stacked::zero();
        for (r, &(_, impulse)) in r.contacts.iter_mut().zip(&last) {
            *r = [impulse];
        }
        for (r, &(_, impulse)) in r.rows.iter_mut().zip(&last_rows) {
            *r = impulse;
        }
        let mut u = r;
        u.iter_mut().for_each(|u| *u = -*u);
        state.keep(&scene, &u, &r, false);
    }
    Ok(())
}

proptest! {
    #[test]
    fn the_kth_with_a_key_takes_over_the_kth_entry(
        lists in vec((vec(0_u32..4, 0..=C), vec(0_u32..3, 0..=R)), 2..6),
    ) {
        check::<0>(&lists)?;
        check::<R>(&lists)?;
    }
}

/// Where the first call of a tick and a second one start after two solves with these impulses.
fn starts<const R: usize>(
    (keys, rows): (&[u32], &[u32]),
    solves: [Stacked<f64, 1, C, R>; 2],
) -> Result<[Stacked<f64, 1, C, R>; 2], Error> {
    let scene = scene::<R>(keys, rows)?;
    let mut state = WarmStart::cold();
    for r in &solves {
        state.keep(&scene, &Stacked::zero(), r, false);
    }
    let mut start = |call| {
        let last = (&mut State::none(), &mut state);
        with_solve_from(last, call, (&scene, &Vector1::new(-4.0)), |solve| {
            solve.go_to_start();
            solve.state.point.r
        })
    };
    Ok([start(Call::Begin)?, start(Call::Append(0))?])
}

/// A new tick extrapolates impulses. A second pass of the same tick does not.
#[test]
fn impulses_are_extrapolated_once_a_tick() -> Result<(), Error> {
    let solves = [1.0, 2.0].map(|r| {
        let mut solve = Stacked::<f64, 1, C, 0>::zero();
        solve.contacts[0] = [r];
        solve
    });
    let starts = starts((&[0], &[]), solves)?;
    assert_eq!(starts.map(|r| r.contacts[0]), [[3.0], [2.0]]);
    Ok(())
}

/// The same of a joint row alone.
#[test]
fn impulses_of_joint_rows_are_extrapolated_once_a_tick() -> Result<(), Error> {
    let solves = [1.0, 2.0].map(|r| {
        let mut solve = Stacked::<f64, 1, C, R>::zero();
        solve.rows[0] = r;
        solve
    });
    let starts = starts((&[], &[0]), solves)?;
    assert_eq!(starts.map(|r| r.rows[0]), [3.0, 2.0]);
    Ok(())
}
