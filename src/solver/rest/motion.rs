//! What moves, and what may stay: the geometry behind [the rest question](super).

use crate::cone::split;
use crate::linalg::stacked::Stacked;
use crate::linalg::vector::{norm, square};
use crate::linalg::zip::zip3;
use crate::problem::Problem;
use crate::real::Real;
use crate::sets::point::NewtonPoint;
use crate::solver::check::DOUBTFUL_IMPULSE_RATIO;
use nalgebra::SVector;

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Problem<'_, T, N, D, C, R, S>
{
    /// Do loaded contacts move by more than a share of the impulses? (Impulses count as doubtful at most: beside larger ones any motion is
    /// small.)
    pub(in crate::solver) fn loaded_contacts_move(
        &self,
        r: &Stacked<T, D, C, R>,
        u: &Stacked<T, D, C, R>,
        share: T,
    ) -> bool {
        let motion = self.motion(r, u, true);
        let doubtful = T::literal(DOUBTFUL_IMPULSE_RATIO * DOUBTFUL_IMPULSE_RATIO);
        motion.moved > share * share * motion.size.min(motion.expected * doubtful)
    }

    /// The motion of all contacts, or only of the loaded ones.
    #[cfg_attr(target_os = "none", inline(never))]
    fn motion(&self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>, only_loaded: bool) -> Motion<T> {
        let mut moved = T::ZERO;
        for (set, r, u) in zip3(self.sets.contacts(), &r.contacts, &u.contacts) {
            if !only_loaded || *r != [T::ZERO; D] {
                moved += set.alpha * set.alpha * square(u);
            }
        }
        let expected = self.expected_size * self.expected_size;
        Motion { moved, expected, size: self.sets.contact_square(r).max(expected) }
    }

    /// Does so little move that the estimate by the relaxation is surely below `limit`? (If `r` lies in its cone, its natural map is no
    /// longer than `alpha u`.)
    pub(super) fn hardly_moves(&self, point: &NewtonPoint<T, D, C, R>, limit: T) -> bool {
        let motion = self.motion(&point.r, &point.u, false);
        let four = T::literal(4.0);
        let bound = motion.expected.min(limit * limit * motion.size);
        !self.scene.is_mixed() && four * motion.moved < bound
    }

    /// The least distance `mu r_N - |r_T|` (N·s) of impulses to the boundaries of their cones.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn cone_margin(&self, r: &Stacked<T, D, C, R>) -> T {
        let mut least = T::INFINITY;
        for (set, r) in self.sets.contacts().iter().zip(&r.contacts) {
            let r = SVector::from(*r);
            let (normal, tangent) = split(&r);
            least = least.min(set.cone.friction() * normal - norm(tangent));
        }
        least
    }

    /// Does standing still obey all laws? Then all contacts that touch may stick.
    pub(super) fn can_stand_still(&self) -> bool {
        let mut contacts = zip3(0..C, self.sets.contacts(), self.scene.contacts());
        !self.scene.is_conceivably_infeasible()
            && contacts
                .all(|(i, set, contact)| set.cone.dual().has(&self.scene.scaled_velocity(i, contact.offset)))
    }

    /// Does the duality gap prove that a contact moves in the solution of the relaxation, without a proof that it separates?
    #[inline(never)]
    pub(super) fn must_slide(&self, r: &Stacked<T, D, C, R>, u: &Stacked<T, D, C, R>) -> bool {
        let mut gap = T::ZERO;
        // How far `u` is inside the dual cone.
        let dual_margin = |mu: T, u: &[T; D]| {
            let u = SVector::from(*u);
            let (normal, tangent) = split(&u);
            normal - mu * norm(tangent)
        };
        for (set, r, u) in zip3(self.sets.contacts(), &r.contacts, &u.contacts) {
            if dual_margin(set.cone.friction(), u) < T::ZERO {
                return false;
            }
            for (&r, &u) in r.iter().zip(u) {
                gap += r * u;
            }
        }
        for (set, &r, &u) in zip3(self.sets.rows(), &r.rows, &u.rows) {
            gap += set.duality_gap(r, u);
        }
        let bound = gap * T::count(2 * D);
        self.sets.contacts().iter().zip(&u.contacts).any(|(set, u)| {
            let margin = dual_margin(set.cone.friction(), u);
            // The contact surely moves, and `u*` may lie on the boundary of the dual cone: it need not separate.
            set.alpha * square(u) > T::literal(16.0) * bound && set.alpha * margin * margin < bound
        })
    }
}

/// The motion of contacts, to be compared with impulses. All are squares (N²·s²).
struct Motion<T> {
    /// `Σ |alpha_i u_i|²`
    moved: T,
    /// The expected size of the impulses.
    expected: T,
    /// The size of the impulses, at least the expected one.
    size: T,
}
