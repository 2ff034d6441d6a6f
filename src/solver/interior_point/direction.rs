//! The predictor and the corrector of Mehrotra: two or three solves with one matrix.

use crate::Real;
use crate::laws::{Coulomb, Laws, Room};
use crate::linalg::blocks::{ContactMatrix, ContactVector};
use crate::linalg::elimination::Elimination;
use crate::linalg::hints::rolled;
use crate::problem::Problem;
use crate::solution::zeros;
use crate::solver::interior_point::lorentz::{first, joined};
use crate::solver::interior_point::pair::{Pair, Part, Scaling, widen, width};
use crate::solver::interior_point::row_pairs::RowPairs;
use core::array::from_fn;
use nalgebra::SVector;

/// What a step is to achieve at one contact, or at joint rows.
struct Goal<T: Real, const D: usize, L: Laws> {
    /// What is to come of `dw + V⁻² dx`.
    cone: SVector<T, D>,
    /// What is to come of `dw_N + w_N dx_N / x_N`.
    normal: T,
    rows: L::Room<[[T; 2]; D]>,
}

impl<T: Real, const D: usize, L: Laws> Goal<T, D, L> {
    const fn none() -> Self {
        Self {
            cone: zeros(),
            normal: T::ZERO,
            rows: L::Room::EMPTY,
        }
    }
}

/// What is to come of joint rows.
fn corrected<T: Real, const D: usize, L: Laws>(
    pair: &Pair<T, D, L>,
    step: Option<&RowPairs<T, D>>,
    tau: T,
) -> L::Room<[[T; 2]; D]> {
    match pair.rows.get() {
        Some(rows) => L::Room::with(rows.corrected(step, tau)),
        None => L::Room::EMPTY,
    }
}

/// The linearised equations of a point, factorised.
pub(super) struct System<'a, T: Real, const D: usize, const C: usize, L: Laws = Coulomb> {
    scalings: [Scaling<T, D>; C],
    pairs: &'a [Pair<T, D, L>; C],
    /// `y = Λ u`
    velocities: [SVector<T, D>; C],
    matrix: &'a ContactMatrix<T, D, C>,
    elimination: &'a Elimination<T, D, C>,
}

impl<'a, T: Real, const D: usize, const C: usize, L: Laws> System<'a, T, D, C, L> {
    /// Linearises at pairs with `u = W r + q`, and factorises `Λ W Λ + V⁻²`; the normal row of Coulomb's law has `y_N / x_N`
    /// in place of `V⁻²`. `None` if that is singular.
    #[inline(never)]
    pub(super) fn new<const N: usize>(
        problem: &Problem<'_, T, N, D, C, L>,
        pairs: &'a [Pair<T, D, L>; C],
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
        elimination.lay_out(pairs.iter().map(Pair::count));
        let delassus = problem.factor.delassus();
        for (j, (law, pair)) in laws.iter().zip(pairs).enumerate() {
            let (start, count) = (elimination.columns(j).start, pair.count());
            let rows = matrix.iter_mut().zip(delassus);
            for (i, ((rows, sources), tested)) in rows.zip(laws.iter().zip(pairs)).enumerate() {
                if count == 0 || tested.1.count() == 0 {
                    continue;
                }
                for (k, (row, source)) in rows.iter_mut().zip(sources).enumerate() {
                    rolled();
                    let mut entries = [T::ZERO; D];
                    if k < tested.1.count() {
                        let mut wide = widen(law, &(*source.get(j)?).into());
                        if k > 0 {
                            wide *= width(tested.0, k);
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

    /// Solves for the step that makes `dw + V⁻² dx = goal`, and the normal row `dy_N + y_N dx_N / x_N` its goal; `None` if
    /// `dx` or `dw` is not finite.
    #[inline(never)]
    fn solve(&self, goals: &[Goal<T, D, L>; C]) -> Option<[Pair<T, D, L>; C]> {
        let mut unknowns = [[T::ZERO; D]; C];
        let unknowns = unknowns.as_flattened_mut();
        for (i, (pair, goal)) in self.pairs.iter().zip(goals).enumerate() {
            rolled();
            let velocity = self.velocities.get(i)?;
            let mut right = pair.w + goal.cone - velocity;
            if let (Some(pairs), Some(goals)) = (pair.rows.get(), goal.rows.get()) {
                right = pairs.velocity() - velocity;
                for (right, &[p, n]) in right.iter_mut().zip(goals) {
                    *right += p - n;
                }
            } else if pair.part != Part::Cone {
                right = joined(pair.normal + goal.normal - first(velocity), right);
            }
            let own = unknowns.get_mut(self.elimination.columns(i))?;
            for (unknown, right) in own.iter_mut().zip(right.iter()) {
                *unknown = *right;
            }
        }
        self.elimination.solve(self.matrix, unknowns)?;
        let mut steps = [Pair::<T, D, L>::none(); C];
        let contacts = self.pairs.iter().zip(goals).zip(&self.scalings);
        for (i, (step, ((pair, goal), scaling))) in steps.iter_mut().zip(contacts).enumerate() {
            rolled();
            let own = unknowns.get(self.elimination.columns(i))?;
            for (x, unknown) in step.x.iter_mut().zip(own) {
                *x = *unknown;
            }
            if let (Some(pairs), Some(goals)) = (pair.rows.get(), goal.rows.get()) {
                step.rows = L::Room::with(pairs.step(&step.x, goals));
            }
            if matches!(pair.part, Part::Normal | Part::Coulomb) {
                step.normal = goal.normal - pair.normal / first(&pair.x) * first(&step.x);
            }
            if pair.part.is_cone::<D>() {
                step.w = goal.cone - scaling.compliance(&step.x);
            }
        }
        let finite = |step: &Pair<T, D, L>| step.x.iter().chain(step.w.iter()).all(T::is_finite);
        steps.iter().all(finite).then_some(steps)
    }

    /// The predictor: the step to `tau = 0`.
    pub(super) fn predict(&self) -> Option<[Pair<T, D, L>; C]> {
        self.solve(&from_fn(|i| {
            let pair = self.pairs.get(i).copied().unwrap_or(Pair::none());
            Goal {
                cone: -pair.w,
                normal: -pair.normal,
                rows: corrected(&pair, None, T::ZERO),
            }
        }))
    }

    /// The corrector: the step to the pairs of a smaller `tau`, with the products of another step taken into account.
    pub(super) fn correct(
        &self,
        step: &[Pair<T, D, L>; C],
        tau: T,
        beta: T,
    ) -> Option<[Pair<T, D, L>; C]> {
        let mut goals = [const { Goal::none() }; C];
        let contacts = self.pairs.iter().zip(step).zip(&self.scalings);
        for (goal, ((pair, step), scaling)) in goals.iter_mut().zip(contacts) {
            rolled();
            goal.rows = corrected(pair, step.rows.get(), tau);
            if pair.part != Part::Nothing {
                let normal = first(&pair.x);
                goal.normal = (tau - normal * pair.normal - first(&step.x) * step.normal) / normal;
            }
            if pair.part.is_cone::<D>() {
                goal.cone = scaling.corrected(pair, step, tau * beta);
            }
        }
        self.solve(&goals)
    }

    /// The greatest length up to a limit of a step inside the cones.
    pub(super) fn reach(&self, step: &[Pair<T, D, L>; C], limit: T) -> T {
        let contacts = self.pairs.iter().zip(step);
        contacts.fold(limit, |reach, (pair, step)| pair.reach(step, reach))
    }
}
