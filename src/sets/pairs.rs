//! Impulses and velocities of contacts and joint rows on the central path ([`crate::guide::method`]).

use crate::linalg::stacked::Stacked;
use crate::linalg::zip::{zip3, zip4};
use crate::real::Real;
use crate::sets::Sets;
use crate::sets::contact::pair::{Pair, Part, widen};
use crate::sets::row::pair::RowPair;

/// Pairs of an impulse and a velocity on the central path, or a step of such pairs.
#[derive(Clone, Debug)]
pub(crate) struct Pairs<T: Real, const D: usize, const C: usize, const R: usize> {
    pub(super) contacts: [Pair<T, D>; C],
    pub(super) rows: [RowPair<T>; R],
}

impl<T: Real, const D: usize, const C: usize, const R: usize> Pairs<T, D, C, R> {
    /// No pairs.
    pub(crate) const fn none() -> Self {
        Self { contacts: [Pair::none(); C], rows: [RowPair::none(); R] }
    }

    /// Fills in pairs with the parameter `tau`, near the impulses `r` and the velocities `u`. `gain` is the weight of velocities
    /// against impulses, `beta` the weight of friction.
    pub(crate) fn enter(
        &mut self,
        sets: &Sets<T, D, C, R>,
        (r, u): (&Stacked<T, D, C, R>, &Stacked<T, D, C, R>),
        tau: T,
        gain: T,
        beta: T,
    ) {
        *self = Self::none();
        for (pair, set, &r, &u) in zip4(&mut self.contacts, sets.contacts(), &r.contacts, &u.contacts) {
            let velocity = set.augmented(&u.into());
            *pair = Pair::centred(set, &r.into(), &velocity, tau, gain, beta);
        }
        for (pair, set, &r, &u) in zip4(&mut self.rows, sets.rows(), &r.rows, &u.rows) {
            *pair = RowPair::centred(set, r, u, tau, gain);
        }
    }

    /// Fills `r` with the impulses of the pairs.
    pub(crate) fn impulses(&self, sets: &Sets<T, D, C, R>, r: &mut Stacked<T, D, C, R>) {
        for (r, pair, set) in zip3(&mut r.contacts, &self.contacts, sets.contacts()) {
            *r = widen(set, &pair.x).into();
        }
        for (r, pair, set) in zip3(&mut r.rows, &self.rows, sets.rows()) {
            *r = set.project(pair.impulse);
        }
    }

    /// Mean of the products `y_N x_N`, `x · (s, y_T) / beta` and of joint rows. All are `tau` on the central path.
    pub(crate) fn tau(&self, beta: T) -> T {
        let contacts = self.contacts.iter().map(|pair| pair.products(beta));
        let rows = self.rows.iter().map(RowPair::products);
        let (mut sum, mut count) = (T::ZERO, T::ZERO);
        for product in contacts.chain(rows).flatten().flatten() {
            sum += product;
            count += T::ONE;
        }
        sum / count.max(T::ONE)
    }

    /// The greatest length, up to `limit`, of a step that stays inside all cones and bounds.
    pub(crate) fn max_step(&self, step: &Self, limit: T) -> T {
        let contacts = self.contacts.iter().zip(&step.contacts);
        let limit = contacts.fold(limit, |limit, (pair, step)| pair.max_step(step, limit));
        let rows = self.rows.iter().zip(&step.rows);
        rows.fold(limit, |limit, (pair, step)| pair.max_step(step, limit))
    }

    /// Moves the pairs by `step length`.
    pub(crate) fn advance(&mut self, step: &Self, length: T) {
        for (pair, step) in self.contacts.iter_mut().zip(&step.contacts) {
            pair.advance(step, length);
        }
        for (pair, step) in self.rows.iter_mut().zip(&step.rows) {
            pair.advance(step, length);
        }
    }
}

/// Mean over all sets of an energy: `alpha |q|²` of a contact, `λ0² / alpha` of a joint row. It is the scale of the first `tau`.
pub(crate) fn mean_energy<T: Real, const D: usize, const C: usize, const R: usize>(
    sets: &Sets<T, D, C, R>,
) -> T {
    let contacts = sets.contacts().iter();
    let contacts = contacts.map(|set| set.energy(Part::of(set).count::<D>()));
    let rows = sets.rows().iter().map(|set| set.alone_energy(T::ONE));
    let (mut energy, mut count) = (T::ZERO, T::ZERO);
    for energy_of_set in contacts.chain(rows) {
        energy += energy_of_set;
        count += T::ONE;
    }
    energy / count
}
