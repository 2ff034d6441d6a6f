//! Frames of slots of joint rows, each of which holds or does not.

use super::{Frame, Kind};
use crate::Real;
use crate::laws::{Laws, Room};
use crate::problem::ContactLaw;
use nalgebra::SVector;

impl<T: Real, const D: usize, L: Laws> Frame<T, D, L> {
    /// Unknowns and equations are the joint rows that hold.
    pub(super) fn set_rows(&mut self, holding: [bool; D], compliance: T, regularisation: T) {
        self.rows = L::Room::with(holding);
        self.kind = if holding.contains(&true) {
            Kind::Stick
        } else {
            Kind::Open
        };
        (self.compliance, self.hold) = (compliance, regularisation);
        self.direction = [T::ZERO; D];
        let units = self.pushes.iter_mut().zip(&mut self.tests);
        let places = holding.iter().enumerate().filter(|&(_, &holds)| holds);
        for ((push, test), (place, _)) in units.zip(places) {
            *push = [T::ZERO; D];
            if let Some(entry) = push.get_mut(place) {
                *entry = T::ONE;
            }
            *test = *push;
        }
    }

    /// Are unknowns and equations combinations of rows?
    #[inline]
    pub(super) fn is_combined(&self) -> bool {
        self.kind == Kind::Slip || self.rows.get().is_some()
    }

    /// Is it a contact that sticks?
    #[inline]
    pub(crate) fn sticks(&self) -> bool {
        self.kind == Kind::Stick && self.rows.get().is_none()
    }

    /// Does its slot do what it did where this was set?
    #[inline]
    pub(crate) fn is_of(
        &self,
        law: &ContactLaw<T, D, L>,
        velocity: &SVector<T, D>,
        r: &[T; D],
    ) -> bool {
        match (self.rows.get(), law.rows.get()) {
            (Some(holding), Some(rows)) => *holding == rows.holding(r),
            (None, None) => self.kind == Kind::of(law, velocity, r),
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests;
