//! Which contacts of MuJoCo's list are in the scene, if there is no room for all: those that are reached.

use super::look_ahead::LookAhead;
use super::scene::Step;
use numpy::ndarray::{ArrayView1, ArrayView2};

/// How often others are tried before the rest is given up.
const ROUNDS: usize = 8;
/// A contact that is left out is not reached if it sinks in by no more than this in a step (m).
const SINKS: f64 = 1e-9;

/// A contact that takes part.
#[derive(Clone, Copy)]
pub(super) struct Listed {
    /// Its place in MuJoCo's list.
    pub(super) index: usize,
    /// Its first row among the constraints, and how many it has.
    pub(super) address: usize,
    pub(super) dim: usize,
    /// Gap (m) behind MuJoCo's own margin.
    pub(super) distance: f64,
}

/// The contacts that are in the scene, and all that may be.
#[derive(Default)]
pub(super) struct Choice {
    listed: Vec<Listed>,
    chosen: Vec<Listed>,
    /// Room for contacts, and how often the scene of this step was solved.
    most: usize,
    rounds: usize,
}

impl Choice {
    pub(super) fn listed(&self) -> &[Listed] {
        &self.listed
    }

    pub(super) fn chosen(&self) -> &[Listed] {
        &self.chosen
    }

    /// Is there a contact that spins or rolls?
    pub(super) fn needs_shapes(&self) -> bool {
        self.listed.iter().any(|contact| contact.dim > 3)
    }

    /// Lists the contacts that have rows.
    pub(super) fn list(
        &mut self,
        distances: ArrayView1<'_, f64>,
        margins: ArrayView1<'_, f64>,
        dims: ArrayView1<'_, i32>,
        addresses: ArrayView1<'_, i32>,
        geoms: ArrayView2<'_, i32>,
        look_ahead: &LookAhead,
    ) {
        self.listed.clear();
        for (index, (&dim, &address)) in dims.iter().zip(addresses).enumerate() {
            if let (Ok(address), Ok(dim)) = (usize::try_from(address), usize::try_from(dim)) {
                // No flexes, so both are geoms.
                let pair = [0, 1].map(|side| usize::try_from(geoms[[index, side]]).unwrap_or(0));
                let own = margins[index] - look_ahead.growth_of(pair);
                let distance = distances[index] - own;
                self.listed.push(Listed {
                    index,
                    address,
                    dim,
                    distance,
                });
            }
        }
    }

    /// Chooses those that the motion before the step reaches first.
    pub(super) fn first(&mut self, data: &Step<'_>, most: usize) {
        (self.most, self.rounds) = (most, 0);
        self.chosen.clone_from(&self.listed);
        if self.chosen.len() > most {
            let speed = |contact: &Listed| data.gap_speed(contact, data.velocity);
            self.chosen.sort_by(|a, b| speed(a).total_cmp(&speed(b)));
            self.chosen.truncate(most);
            self.sort();
        }
    }

    /// Takes in those that a solution reaches, in place of some that do not push. `None` if there are new ones, or else how many
    /// are reached for which there is no room.
    pub(super) fn next(
        &mut self,
        data: &Step<'_>,
        velocity: &[f64],
        pushes: impl Iterator<Item = bool>,
    ) -> Option<usize> {
        if self.chosen.len() == self.listed.len() {
            return Some(0);
        }
        let is_chosen = |contact: &Listed| {
            let place = self
                .chosen
                .binary_search_by_key(&contact.index, |own| own.index);
            place.is_ok()
        };
        let mut reached: Vec<(f64, Listed)> = Vec::new();
        for contact in self.listed.iter().filter(|contact| !is_chosen(contact)) {
            let speed = data.gap_speed(contact, velocity);
            if speed * data.h < -SINKS {
                reached.push((speed, *contact));
            }
        }
        if reached.is_empty() {
            return Some(0);
        }
        let count = self.chosen.len();
        let (kept, open): (Vec<_>, Vec<_>) = self
            .chosen
            .iter()
            .zip(pushes)
            .partition(|&(_, pushes)| pushes);
        self.rounds += 1;
        if kept.len() == count || self.rounds == ROUNDS {
            return Some(reached.len());
        }
        reached.sort_by(|a, b| a.0.total_cmp(&b.0));
        let new = reached.into_iter().map(|(_, contact)| contact);
        let [kept, open] = [kept, open].map(|list| list.into_iter().map(|(&contact, _)| contact));
        let chosen: Vec<_> = kept.chain(new).chain(open).take(self.most).collect();
        self.chosen = chosen;
        self.sort();
        None
    }

    /// In MuJoCo's order, which warm starts rely on.
    fn sort(&mut self) {
        self.chosen.sort_by_key(|contact| contact.index);
    }
}
