//! Warm starts of joint rows: each follows its key, in whatever slot it stands.

use crate::laws::{Laws, Room};
use crate::scene::slot::{Slot, SlotRows};
use crate::solution::zeros;
use crate::solver::warm_start::{ContactState, WarmStart};
use crate::{Real, Scene};
use core::mem;

/// The keys of the joint rows of a slot, those of the last solve that nobody has taken yet.
pub(super) type RowKeys<const D: usize> = [Option<u32>; D];

/// The keys of the rows of a slot; `None` of one that holds a contact.
fn keys<T: Real, const D: usize>(slot: Option<&Slot<T, D>>) -> Option<RowKeys<D>> {
    let SlotRows { count, keys, .. } = slot?.rows?;
    let mut places = [None; D];
    for (place, key) in places.iter_mut().zip(keys).take(count) {
        *place = Some(key);
    }
    Some(places)
}

impl<T: Real, const D: usize, const C: usize, L: Laws> WarmStart<T, D, C, L> {
    /// Are the joint rows of the last solve where those of a scene are?
    pub(super) fn has_rows_of<const N: usize>(&self, scene: &Scene<T, N, D, C, L>) -> bool {
        let slots = self.rows.iter().enumerate().take(scene.contacts().len());
        let mut slots = slots.map(|(i, rows)| (rows.get().copied().flatten(), scene.slot(i)));
        slots.all(|(rows, slot)| rows == keys(slot))
    }

    /// Did a joint row with this key push in the last solve?
    pub(super) fn has_pushed(&self, key: u32) -> bool {
        let mut slots = self.contacts.iter().zip(&self.rows);
        slots.any(|(state, rows)| {
            let (Some(state), Some(Some(keys))) = (state, rows.get()) else {
                return false;
            };
            let mut rows = keys.iter().zip(state.r.iter());
            rows.any(|(&row, &r)| row == Some(key) && r != T::ZERO)
        })
    }

    /// Remembers which joint rows stand in which slots.
    pub(super) fn keep_keys<const N: usize>(&mut self, scene: &Scene<T, N, D, C, L>) {
        self.rows = [const { L::Room::EMPTY }; C];
        let places = self.rows.iter_mut().enumerate();
        for (i, rows) in places.take(scene.contacts().len()) {
            *rows = L::Room::with(keys(scene.slot(i)));
        }
    }

    /// Goes over to the slots of the next solve, contacts as a whole and joint rows one by one. Tells where each slot was, and
    /// `C` for one that is new or holds other rows.
    pub(super) fn reorder_slots<const N: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, L>,
    ) -> [usize; C] {
        let mut last = mem::replace(&mut self.contacts, [None; C]);
        let mut left = self.rows.map(|rows| rows.get().copied().flatten());
        let mut places = [C; C];
        let slots = self.contacts.iter_mut().zip(&mut places).enumerate();
        for (i, (state, place)) in slots.take(scene.contacts().len()) {
            let Some(wanted) = keys(scene.slot(i)) else {
                let key = scene.contacts().get(i).map(|contact| contact.key);
                let mut states = last.iter().zip(&left);
                let same = |(state, rows): (&Option<ContactState<T, D>>, &Option<_>)| {
                    rows.is_none() && state.as_ref().map(|state| state.key) == key
                };
                if let Some(found) = states.position(same) {
                    *place = found;
                    *state = last.get_mut(found).and_then(Option::take);
                }
                continue;
            };
            if let Some(found) = left.iter().position(|rows| *rows == Some(wanted)) {
                *place = found;
            }
            *state = gather(&wanted, &last, &mut left);
        }
        self.keep_keys(scene);
        places
    }
}

/// What is known of the joint rows of a slot; `None` if it is nothing.
fn gather<T: Real, const D: usize, const C: usize>(
    wanted: &RowKeys<D>,
    last: &[Option<ContactState<T, D>>; C],
    left: &mut [Option<RowKeys<D>>; C],
) -> Option<ContactState<T, D>> {
    let mut gathered: Option<ContactState<T, D>> = None;
    for (k, key) in wanted.iter().enumerate().filter(|(_, key)| key.is_some()) {
        for (state, rows) in last.iter().zip(left.iter_mut()) {
            let (Some(state), Some(rows)) = (state, rows) else {
                continue;
            };
            let Some(found) = rows.iter().position(|row| row == key) else {
                continue;
            };
            if let Some(row) = rows.get_mut(found) {
                *row = None;
            }
            let target = gathered.get_or_insert(ContactState {
                key: state.key,
                u: zeros(),
                r: zeros(),
                before: zeros(),
                solves: state.solves,
            });
            target.solves = target.solves.min(state.solves);
            let pairs = [
                (&mut target.u, &state.u),
                (&mut target.r, &state.r),
                (&mut target.before, &state.before),
            ];
            for (target, source) in pairs {
                if let (Some(target), Some(&source)) = (
                    target.as_mut_slice().get_mut(k),
                    source.as_slice().get(found),
                ) {
                    *target = source;
                }
            }
            break;
        }
    }
    gathered
}
