//! From an impulse to a solution in a scene of contacts and joint rows: what [`super::evaluation`] needs beside.

use crate::laws::{Laws, Room};
use crate::linalg::hints::rolled;
use crate::problem::dynamics::Dynamics;
use crate::problem::energies::Given;
use crate::problem::{ContactLaw, Problem};
use crate::scene::slot::Slot;
use crate::solution::SlotSolution;
use crate::{Real, RowMode};
use nalgebra::SVector;

impl<T: Real, const N: usize, const D: usize, const C: usize, L: Laws> Problem<'_, T, N, D, C, L> {
    /// Impulses as they are written, in rows that are not scaled, those of joint rows within their bounds; and what of them is
    /// judged: contacts in scaled rows again, joint rows as they stand.
    #[inline]
    pub(super) fn written(&self, r: &[[T; D]]) -> L::Room<[[[T; D]; C]; 2]> {
        if self.energies.get().is_none() {
            return L::Room::EMPTY;
        }
        let [mut written, mut judged] = [[[T::ZERO; D]; C]; 2];
        let places = written.iter_mut().zip(&mut judged);
        for (i, ((written, judged), (&r, law))) in places.zip(r.iter().zip(self.laws())).enumerate()
        {
            rolled();
            if let (Some(law), Some((given, scales))) = (law.rows.get(), self.given(i)) {
                *written = law.unscaled(&r, &given.bounds, scales);
                *judged = *written;
            } else {
                *written = self.factor.scaled(i, r.into()).into();
                *judged = self.factor.unscaled(i, SVector::from(*written)).into();
            }
        }
        L::Room::with([written, judged])
    }

    /// The laws and scales of joint rows.
    #[inline]
    pub(super) fn given(&self, slot: usize) -> Option<Given<'_, T, D>> {
        let rows = self.scene.slot(slot)?.rows.as_ref()?;
        Some((rows, self.factor.scales(slot)?))
    }

    /// Adds to `u = H v + w` by how much the slots give way, and to the dynamics what momenta are compared with at least.
    /// Returns what of `u` is judged, as [`Self::written`].
    #[inline]
    pub(super) fn give_way(
        &self,
        impulses: &[[T; D]],
        u: &mut [[T; D]; C],
        momentum: &mut Dynamics<T, L>,
    ) -> L::Room<[[T; D]; C]> {
        if self.energies.get().is_none() {
            return L::Room::EMPTY;
        }
        let mut scaled = *u;
        for (i, ((scaled, u), r)) in scaled.iter_mut().zip(u).zip(impulses).enumerate() {
            rolled();
            if let Some(slot) = self.scene.slot(i) {
                for (u, given) in u.iter_mut().zip(slot.given_way(r)) {
                    *u += given;
                }
                *scaled = *u;
                if slot.rows.is_none() {
                    *scaled = self.factor.scaled(i, (*u).into()).into();
                }
            }
        }
        if let (Some(energies), Some(weighted)) = (self.energies.get(), momentum.weighted.get_mut())
        {
            let diagonal = self.scene.mass().data.0.iter().enumerate();
            let heaviest = diagonal.fold(T::ZERO, |largest, (k, column)| {
                column.get(k).map_or(largest, |&mass| largest.max(mass))
            });
            weighted.compare_with(energies.momentum(self.scene.reference_mass()));
            momentum.plain.compare_with(energies.momentum(heaviest));
        }
        L::Room::with(scaled)
    }
}

/// What the joint rows of a slot do, read off the argument of the natural map as for contacts.
pub(super) fn rows_of<T: Real, const D: usize, L: Laws>(
    (law, slot): (&ContactLaw<T, D, L>, Option<&Slot<T, D>>),
    (u, r): &(SVector<T, D>, SVector<T, D>),
    before: Option<&SlotSolution<T, D>>,
) -> L::Room<SlotSolution<T, D>> {
    let Some(rows) = law.rows.get() else {
        return L::Room::EMPTY;
    };
    let mut modes = [RowMode::Open; D];
    let pushes = (r - u * law.alpha).data.0;
    let pushes = pushes.as_flattened().iter().zip(r.iter());
    for (k, (mode, ((&push, &r), bounds))) in
        modes.iter_mut().zip(pushes.zip(&rows.bounds)).enumerate()
    {
        let given = slot.and_then(|slot| slot.rows?.bounds.get(k).copied());
        let is_fixed = |&[lower, upper]: &[T; 2]| lower == upper;
        // Nothing moves a row that is fixed but not given so.
        *mode = match given.filter(|given| is_fixed(bounds) && !is_fixed(given)) {
            Some(given) => RowMode::of(r, r, given),
            None => RowMode::of(r, push, *bounds),
        };
    }
    L::Room::with(SlotSolution {
        count: rows.count(),
        keys: slot
            .and_then(|slot| slot.rows)
            .map_or([0; D], |rows| rows.keys),
        modes,
        // A proof that was found on the way.
        certificate: before.map_or([T::ZERO; D], |before| before.certificate),
    })
}
