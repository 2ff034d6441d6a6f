//! The predictor and the corrector of Mehrotra: two or three solves with one matrix.

use crate::Real;
use crate::linalg::blocks::{ContactMatrix, ContactVector};
use crate::linalg::elimination::Elimination;
use crate::linalg::hints::rolled;
use crate::problem::Problem;
use crate::solution::zeros;
use crate::solver::interior_point::lorentz::{first, joined};
use crate::solver::interior_point::pair::{Pair, Part, Scaling, widen};
use core::array::from_fn;
use nalgebra::SVector;

/// The linearised equations of a point, factorised.
pub(super) struct System<'a, T, const D: usize, const C: usize> {
    scalings: [Scaling<T, D>; C],
    pairs: &'a [Pair<T, D>; C],
    /// `y = Λ u`
    velocities: [SVector<T, D>; C],
    matrix: &'a ContactMatrix<T, D, C>,
    elimination: &'a Elimination<T, D, C>,
}

impl<'a, T: Real, const D: usize, const C: usize> System<'a, T, D, C> {
    /// Linearises at pairs with `u = W r + q`, and factorises `Λ W Λ + V⁻²`; the normal row of Coulomb's law has `y_N / x_N`
    /// in place of `V⁻²`. `None` if that is singular.
    #[inline(never)]
    pub(super) fn new<const N: usize>(
        problem: &Problem<'_, T, N, D, C>,
        pairs: &'a [Pair<T, D>; C],
        u: &ContactVector<T, D, C>,
        matrix: &'a mut ContactMatrix<T, D, C>,
        elimination: &'a mut Elimination<T, D, C>,
    ) -> Option<Self> {
        let laws = problem.laws();
        let mut scalings = [Scaling::none(); C];
        let mut velocities = [zeros(); C];
        let contacts = laws.iter().zip(pairs.iter().zip(u));
        for ((scaling, velocity), (law, (pair, u))) in
            scalings.iter_mut().zip(&mut velocities).zip(contacts)
        {
            rolled();
            if pair.part.is_cone::<D>() {
                *scaling = Scaling::of(pair);
            }
            *velocity = widen(law, &(*u).into());
        }
        elimination.lay_out(pairs.iter().map(|pair| pair.part.count::<D>()));
        let delassus = problem.factor.delassus();
        for (j, (law, pair)) in laws.iter().zip(pairs).enumerate() {
            let (start, count) = (elimination.columns(j).start, pair.part.count::<D>());
            let rows = matrix.iter_mut().zip(delassus);
            for (i, ((rows, sources), tested)) in rows.zip(laws.iter().zip(pairs)).enumerate() {
                if count == 0 || tested.1.part == Part::Nothing {
                    continue;
                }
                for (k, (row, source)) in rows.iter_mut().zip(sources).enumerate() {
                    rolled();
                    let mut entries = [T::ZERO; D];
                    if k < tested.1.part.count::<D>() {
                        let mut wide = widen(law, &(*source.get(j)?).into());
                        if k > 0 {
                            wide *= tested.0.cone.friction();
                        }
                        if i == j {
                            wide += scalings.get(i)?.row(pair, k);
                        }
                        for (entry, &wide) in entries.iter_mut().zip(wide.iter()).take(count) {
                            *entry = wide;
                        }
                    }
                    // Excess entries are overwritten by the next contact, or zero.
                    let target = row.as_flattened_mut().get_mut(start..)?;
                    *target.first_chunk_mut()? = entries;
                }
            }
        }
        elimination.factorise(matrix, false)?;
        Some(Self {
            scalings,
            pairs,
            velocities,
            matrix,
            elimination,
        })
    }

    /// Solves for the step that makes `dw + V⁻² dx = goal`, and the normal row `dy_N + y_N dx_N / x_N` its goal; `None` if it
    /// is not finite.
    #[inline(never)]
    fn solve(&self, goals: &[(SVector<T, D>, T); C]) -> Option<[Pair<T, D>; C]> {
        let mut unknowns = [[T::ZERO; D]; C];
        let unknowns = unknowns.as_flattened_mut();
        let contacts = self.pairs.iter().zip(&self.velocities).zip(goals);
        for (i, ((pair, velocity), (goal, normal))) in contacts.enumerate() {
            rolled();
            let mut right = pair.w + goal - velocity;
            if pair.part != Part::Cone {
                right = joined(pair.normal + *normal - first(velocity), right);
            }
            let own = unknowns.get_mut(self.elimination.columns(i))?;
            for (unknown, right) in own.iter_mut().zip(right.iter()) {
                *unknown = *right;
            }
        }
        self.elimination.solve(self.matrix, unknowns)?;
        let mut steps = [Pair::<T, D>::none(); C];
        let contacts = self.pairs.iter().zip(goals).zip(&self.scalings);
        for (i, (step, ((pair, (goal, normal)), scaling))) in
            steps.iter_mut().zip(contacts).enumerate()
        {
            rolled();
            let own = unknowns.get(self.elimination.columns(i))?;
            for (x, unknown) in step.x.iter_mut().zip(own) {
                *x = *unknown;
            }
            if matches!(pair.part, Part::Normal | Part::Coulomb) {
                step.normal = *normal - pair.normal / first(&pair.x) * first(&step.x);
            }
            if pair.part.is_cone::<D>() {
                step.w = goal - scaling.compliance(&step.x);
            }
        }
        let finite = |step: &Pair<T, D>| step.x.iter().chain(step.w.iter()).all(T::is_finite);
        steps.iter().all(finite).then_some(steps)
    }

    /// The predictor: the step to `tau = 0`.
    pub(super) fn predict(&self) -> Option<[Pair<T, D>; C]> {
        self.solve(&from_fn(|i| {
            let pair = self.pairs.get(i).copied().unwrap_or(Pair::none());
            (-pair.w, -pair.normal)
        }))
    }

    /// The corrector: the step to the pairs of a smaller `tau`, with the products of another step taken into account.
    pub(super) fn correct(
        &self,
        step: &[Pair<T, D>; C],
        tau: T,
        beta: T,
    ) -> Option<[Pair<T, D>; C]> {
        let mut goals = [(zeros(), T::ZERO); C];
        let contacts = self.pairs.iter().zip(step).zip(&self.scalings);
        for (goal, ((pair, step), scaling)) in goals.iter_mut().zip(contacts) {
            rolled();
            if pair.part != Part::Nothing {
                let normal = first(&pair.x);
                goal.1 = (tau - normal * pair.normal - first(&step.x) * step.normal) / normal;
            }
            if pair.part.is_cone::<D>() {
                goal.0 = scaling.corrected(pair, step, tau * beta);
            }
        }
        self.solve(&goals)
    }

    /// The greatest length up to a limit of a step inside the cones.
    pub(super) fn reach(&self, step: &[Pair<T, D>; C], limit: T) -> T {
        let contacts = self.pairs.iter().zip(step);
        contacts.fold(limit, |reach, (pair, step)| pair.reach(step, reach))
    }
}
