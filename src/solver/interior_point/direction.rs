//! The predictor and the corrector of Mehrotra: two or three solves with one matrix.

use crate::Real;
use crate::linalg::blocks::{ContactMatrix, ContactVector};
use crate::linalg::elimination::Elimination;
use crate::linalg::hints::rolled;
use crate::problem::Problem;
use crate::solution::zeros;
use crate::solver::interior_point::pair::{Pair, Part, Scaling, first, joined, widen};
use core::array::from_fn;
use nalgebra::SVector;

/// The linearised equations of a point, factorised.
pub(super) struct System<'a, T, const D: usize, const C: usize> {
    parts: [Part; C],
    scalings: [Scaling<T, D>; C],
    pairs: &'a [Pair<T, D>; C],
    /// `y = D u`
    velocities: [SVector<T, D>; C],
    matrix: &'a ContactMatrix<T, D, C>,
    elimination: &'a Elimination<T, D, C>,
}

impl<'a, T: Real, const D: usize, const C: usize> System<'a, T, D, C> {
    /// Linearises at pairs with `u = W r + q`, and factorises `D W D + V⁻²`, of which the normal row of Coulomb's law is
    /// `w_N / x_N` alone. `None` if that is singular.
    #[inline(never)]
    pub(super) fn new<const N: usize>(
        problem: &Problem<'_, T, N, D, C>,
        pairs: &'a [Pair<T, D>; C],
        u: &ContactVector<T, D, C>,
        matrix: &'a mut ContactMatrix<T, D, C>,
        elimination: &'a mut Elimination<T, D, C>,
    ) -> Option<Self> {
        let laws = problem.laws();
        let mut parts = [Part::Nothing; C];
        let mut scalings = [Scaling::none(); C];
        let mut velocities = [zeros(); C];
        let targets = parts.iter_mut().zip(&mut scalings).zip(&mut velocities);
        for (((part, scaling), velocity), (law, (pair, u))) in
            targets.zip(laws.iter().zip(pairs.iter().zip(u)))
        {
            rolled();
            *part = Part::of(law);
            if matches!(part, Part::Coulomb | Part::Cone) {
                *scaling = Scaling::of(pair);
            }
            *velocity = widen(law, u);
        }
        elimination.lay_out(parts.iter().map(|part| part.count::<D>()));
        for (j, (law, part)) in laws.iter().zip(&parts).enumerate() {
            let (start, count) = (elimination.columns(j).start, part.count::<D>());
            if count == 0 {
                continue;
            }
            let sources = problem.factor.delassus().iter();
            for (i, (rows, source)) in matrix.iter_mut().zip(sources).take(laws.len()).enumerate() {
                let other = *parts.get(i)?;
                if other == Part::Nothing {
                    continue;
                }
                let mu = laws.get(i)?.cone.friction();
                for (k, (row, source)) in rows.iter_mut().zip(source).enumerate() {
                    rolled();
                    let mut entries = [T::ZERO; D];
                    if k < other.count::<D>() {
                        let factor = if k == 0 { T::ONE } else { mu };
                        let wide = widen(law, source.get(j)?) * factor;
                        for (entry, wide) in entries.iter_mut().zip(wide.iter()).take(count) {
                            *entry = *wide;
                        }
                        if i == j {
                            let (pair, scaling) = (pairs.get(i)?, scalings.get(i)?);
                            if k == 0 && other != Part::Cone {
                                *entries.first_mut()? += pair.normal / first(&pair.x);
                            } else {
                                let own = scaling.row(k);
                                for (entry, own) in entries.iter_mut().zip(own.iter()) {
                                    *entry += *own;
                                }
                            }
                        }
                    }
                    // What is too much is overwritten by the next contact, or zero.
                    let target = row.as_flattened_mut().get_mut(start..)?;
                    *target.first_chunk_mut()? = entries;
                }
            }
        }
        elimination.factorise(matrix, false)?;
        Some(Self {
            parts,
            scalings,
            pairs,
            velocities,
            matrix,
            elimination,
        })
    }

    /// The step with which `dw + V⁻² dx` and `dw_N + w_N dx_N / x_N` become what is asked for; `None` if it is no number.
    #[inline(never)]
    fn solve(&self, goals: &[(SVector<T, D>, T); C]) -> Option<[Pair<T, D>; C]> {
        let mut unknowns = [[T::ZERO; D]; C];
        let unknowns = unknowns.as_flattened_mut();
        let contacts = self.pairs.iter().zip(&self.velocities).zip(goals);
        for (i, ((pair, velocity), (goal, normal))) in contacts.enumerate() {
            rolled();
            let mut right = pair.w + goal - velocity;
            if *self.parts.get(i)? != Part::Cone {
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
            let part = *self.parts.get(i)?;
            if part != Part::Nothing {
                step.normal = *normal - pair.normal / first(&pair.x) * first(&step.x);
            }
            if matches!(part, Part::Coulomb | Part::Cone) {
                step.w = goal - scaling.compliance(&step.x);
            }
        }
        let finite = |step: &Pair<T, D>| step.x.iter().chain(step.w.iter()).all(T::is_finite);
        steps.iter().all(finite).then_some(steps)
    }

    /// The step that would end the path at once.
    pub(super) fn predict(&self) -> Option<[Pair<T, D>; C]> {
        self.solve(&from_fn(|i| {
            let pair = self.pairs.get(i).copied().unwrap_or(Pair::none());
            (-pair.w, -pair.normal)
        }))
    }

    /// The step to the pairs of a smaller `tau`, with the products of another step taken into account.
    pub(super) fn correct(
        &self,
        step: &[Pair<T, D>; C],
        tau: T,
        beta: T,
    ) -> Option<[Pair<T, D>; C]> {
        let mut goals = [(zeros(), T::ZERO); C];
        let contacts = self.pairs.iter().zip(step);
        let contacts = contacts.zip(self.parts.iter().zip(&self.scalings));
        for (goal, ((pair, step), (part, scaling))) in goals.iter_mut().zip(contacts) {
            rolled();
            if *part == Part::Nothing {
                continue;
            }
            let normal = first(&pair.x);
            goal.1 = (tau - normal * pair.normal - first(&step.x) * step.normal) / normal;
            if *part != Part::Normal {
                goal.0 = scaling.corrected(pair, step, tau * beta);
            }
        }
        self.solve(&goals)
    }

    /// The greatest length up to a limit of a step inside the cones.
    pub(super) fn reach(&self, step: &[Pair<T, D>; C], limit: T) -> T {
        let contacts = self.parts.iter().zip(self.pairs.iter().zip(step));
        contacts.fold(limit, |reach, (&part, (pair, step))| {
            pair.reach(part, step, reach)
        })
    }
}
