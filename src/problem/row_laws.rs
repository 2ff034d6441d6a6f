//! What a solve needs to know of a slot of joint rows.

use crate::Real;
use crate::laws::{Laws, Room};
use crate::problem::ContactLaw;
use crate::scene::slot::{Slot, SlotRows};
use nalgebra::SVector;

/// The bounds of the impulses of joint rows, which are scaled to `W_jj = 1 / alpha`.
///
/// A row is a limit with the bounds `0` and infinity, an equality without bounds. One that nothing moves keeps the impulse
/// nearest to 0, as if both bounds were there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowLaws<T, const D: usize> {
    pub(crate) bounds: [[T; 2]; D],
    count: usize,
    /// Does something move a row?
    moves: [bool; D],
    /// Does a row that nothing moves ask for another velocity than it has?
    pub(crate) is_hopeless: bool,
}

impl<T: Real, const D: usize> RowLaws<T, D> {
    /// Those of rows with these scales, velocities without impulse, and own rows of `W`.
    fn new(rows: &SlotRows<T, D>, scales: &[T; D], q: &SVector<T, D>, moves: &[bool; D]) -> Self {
        let mut laws = Self {
            bounds: rows.bounds,
            count: rows.count,
            moves: *moves,
            is_hopeless: false,
        };
        let sources = scales.iter().zip(q.iter()).zip(moves);
        for (bounds, ((&scale, &q), &moves)) in laws.bounds.iter_mut().zip(sources).take(rows.count)
        {
            let [lower, upper] = *bounds;
            if moves {
                *bounds = bounds.map(|bound| bound / scale);
            } else {
                *bounds = [clamped(T::ZERO, &[lower, upper]); 2];
                laws.is_hopeless |=
                    q > T::ZERO && !lower.is_finite() || q < T::ZERO && !upper.is_finite();
            }
        }
        laws
    }

    /// Rows with these bounds, all of which something moves.
    #[cfg(test)]
    pub(crate) const fn of(bounds: [[T; 2]; D]) -> Self {
        Self {
            bounds,
            count: D,
            moves: [true; D],
            is_hopeless: false,
        }
    }

    /// How many there are.
    pub(crate) const fn count(&self) -> usize {
        self.count
    }

    /// The nearest impulse within the bounds.
    pub(crate) fn project(&self, r: &SVector<T, D>) -> SVector<T, D> {
        let mut projection = *r;
        for (r, bounds) in projection.iter_mut().zip(&self.bounds) {
            *r = clamped(*r, bounds);
        }
        projection
    }

    /// The impulses of rows that something moves; zero of the others, which do no work.
    pub(crate) fn working(&self, mut r: [T; D]) -> [T; D] {
        for (r, &moves) in r.iter_mut().zip(&self.moves) {
            if !moves {
                *r = T::ZERO;
            }
        }
        r
    }

    /// The bounds of rows that something moves as they were given; of the others those that they have.
    pub(crate) fn of_moving(&self, given: &[[T; 2]; D]) -> [[T; 2]; D] {
        let mut bounds = self.bounds;
        for (bounds, (given, &moves)) in bounds.iter_mut().zip(given.iter().zip(&self.moves)) {
            if moves {
                *bounds = *given;
            }
        }
        bounds
    }

    /// Impulses in rows that are not scaled, within the bounds that were given: at them to the last bit if they are at the
    /// scaled ones.
    pub(crate) fn unscaled(&self, r: &[T; D], given: &[[T; 2]; D], scales: &[T; D]) -> [T; D] {
        let (mut impulses, given) = (*r, self.of_moving(given));
        let bounds = self.bounds.iter().zip(&given).zip(scales);
        for (r, ((&[lower, upper], given), &scale)) in impulses.iter_mut().zip(bounds) {
            let &[first, last] = given;
            *r = if *r <= lower {
                first
            } else if *r >= upper {
                last
            } else {
                clamped(*r * scale, given)
            };
        }
        impulses
    }

    /// Which rows hold, with an impulse between their bounds.
    pub(crate) fn holding(&self, r: &[T; D]) -> [bool; D] {
        let mut holding = [false; D];
        for (holding, (&r, &[lower, upper])) in holding.iter_mut().zip(r.iter().zip(&self.bounds)) {
            *holding = lower < r && r < upper;
        }
        holding
    }
}

/// The nearest number between bounds; what is no number stays so.
pub(crate) fn clamped<T: Real>(r: T, &[lower, upper]: &[T; 2]) -> T {
    if r < lower {
        lower
    } else if r > upper {
        upper
    } else {
        r
    }
}

impl<T: Real, const D: usize, L: Laws> ContactLaw<T, D, L> {
    /// Takes what its slot has, whose rows are scaled, joint rows with a step of the reference mass.
    pub(super) fn take(
        &mut self,
        slot: &Slot<T, D>,
        (scales, reference_mass): (&[T; D], T),
        own: &[[T; D]; D],
        offset: SVector<T, D>,
        moved: SVector<T, D>,
    ) {
        self.q = offset.component_mul(&SVector::from(*scales)) + moved;
        self.base = self.q;
        if let Some(rows) = &slot.rows {
            let mut moves = [false; D];
            for ((moves, row), k) in moves.iter_mut().zip(own).zip(0..) {
                *moves = row.get(k).is_some_and(|&inertia| inertia > T::ZERO);
            }
            self.alpha = reference_mass;
            self.rows = L::Room::with(RowLaws::new(rows, scales, &self.q, &moves));
        }
    }
}
