//! The linearised equations of the central path ([`crate::guide::method`]). One matrix serves the predictor and the corrector of
//! Mehrotra, in two or three solves.

use crate::factor::Delassus;
use crate::linalg::elimination::Elimination;
use crate::linalg::stacked::{Stacked, StackedMatrix};
use crate::linalg::vector::zeros;
use crate::linalg::zip::{zip3, zip4, zip5};
use crate::real::Real;
use crate::sets::assembly::{Linear, assemble};
use crate::sets::contact::lorentz::{first, joined};
use crate::sets::contact::pair::{Pair, Part, Scaling, widen, width};
use crate::sets::pairs::Pairs;
use crate::sets::{ContactSet, Sets};
use core::array::from_fn;
use nalgebra::SVector;

/// Enlargement of the diagonal of `W`, in units of `eps`. Along internal forces `W` is rounding alone. At the end of a path that
/// rounding exceeds the scaling `V⁻²` ([`Scaling`]), and without the enlargement a step would leave the cones at once.
const REGULAR: f64 = 4.0;

/// Right-hand sides of the linearised equations of one contact.
#[derive(Clone, Copy)]
struct Goal<T, const D: usize> {
    /// `dw + V⁻² dx`, where `w` is [`Pair::dual`] and `V` the [`Scaling`].
    cone: SVector<T, D>,
    /// `dy_N + y_N dx_N / x_N`
    normal: T,
}

/// Right-hand sides of the linearised equations of all contacts and joint rows.
struct Goals<T, const D: usize, const C: usize, const R: usize> {
    contacts: [Goal<T, D>; C],
    /// Changes of `p` and `n` at constant impulse, [`crate::sets::row::pair::RowPair::goals`].
    rows: [[T; 2]; R],
}

/// The linearised equations at some pairs.
pub(crate) struct PathSystem<'a, T: Real, const D: usize, const C: usize, const R: usize> {
    scalings: [Scaling<T, D>; C],
    pairs: &'a Pairs<T, D, C, R>,
    /// `y = Λ u`
    velocities: Stacked<T, D, C, R>,
    matrix: &'a mut StackedMatrix<T, D, C, R>,
    elimination: &'a mut Elimination<T, D, C, R>,
}

/// The unknowns and equations of a contact on the central path.
struct OnPath<'a, T: Real, const D: usize> {
    set: &'a ContactSet<T, D>,
    pair: &'a Pair<T, D>,
    scaling: &'a Scaling<T, D>,
    /// Factor by which the diagonal of `W` is enlarged.
    regular: T,
}

impl<T: Real, const D: usize> Linear<T, D> for OnPath<'_, T, D> {
    fn count(&self) -> usize {
        self.pair.count()
    }

    #[inline]
    fn tested(&self, velocities: &[T; D]) -> [T; D] {
        let wide = widen(self.set, &(*velocities).into());
        let wide = if self.pair.part == Part::Normal { joined(first(&wide), zeros()) } else { wide };
        wide.into()
    }

    #[inline]
    fn pushed<const L: usize>(&self, k: usize, velocities: &[[T; L]; D]) -> [T; L] {
        let mut wide = velocities.get(k).copied().unwrap_or([T::ZERO; L]);
        if k > 0 {
            let width = width(self.set, k);
            for wide in &mut wide {
                *wide *= width;
            }
        }
        wide
    }

    #[inline]
    fn add_own(&self, k: usize, entries: &mut [T; D]) {
        if let Some(diagonal) = entries.get_mut(k) {
            *diagonal *= self.regular;
        }
        for (entry, &own) in entries.iter_mut().zip(&self.scaling.column(self.pair, k)) {
            *entry += own;
        }
    }
}

impl<'a, T: Real, const D: usize, const C: usize, const R: usize> PathSystem<'a, T, D, C, R> {
    /// The equations at `pairs`, whose impulses cause the velocities `u = W r + q`. [`Self::factorise`] comes next.
    #[inline]
    pub(crate) fn new(
        sets: &Sets<T, D, C, R>,
        pairs: &'a Pairs<T, D, C, R>,
        u: &Stacked<T, D, C, R>,
        matrix: &'a mut StackedMatrix<T, D, C, R>,
        elimination: &'a mut Elimination<T, D, C, R>,
    ) -> Self {
        let mut scalings = [Scaling::none(); C];
        let mut velocities = *u;
        for (scaling, velocity, set, pair) in
            zip4(&mut scalings, &mut velocities.contacts, sets.contacts(), &pairs.contacts)
        {
            if pair.part.is_cone::<D>() {
                *scaling = Scaling::of(pair);
            }
            *velocity = widen(set, &(*velocity).into()).into();
        }
        Self { scalings, pairs, velocities, matrix, elimination }
    }

    /// Factorises the transpose of `Λ W Λ + V⁻²`. A normal row with an equation of its own has `y_N / x_N` in place of `V⁻²`, a joint row its response.
    /// `None` if the matrix is singular.
    #[inline(never)]
    pub(crate) fn factorise(
        &mut self,
        sets: &Sets<T, D, C, R>,
        delassus: &Delassus<T, D, C, R>,
    ) -> Option<()> {
        let pairs = self.pairs;
        let rows = pairs.rows.iter().filter(|pair| pair.is_free).count();
        self.elimination.lay_out(pairs.contacts.iter().map(Pair::count), rows);
        let regular = T::ONE + T::literal(REGULAR) * T::EPSILON;
        let contacts = sets.contacts().iter().zip(&pairs.contacts).zip(&self.scalings);
        let contacts = contacts.map(|((set, pair), scaling)| OnPath { set, pair, scaling, regular });
        let add_own = |j: usize, entry: &mut T| {
            *entry = *entry * regular + pairs.rows.get(j)?.response(sets.rows().get(j)?.alpha);
            Some(())
        };
        let free = pairs.rows.iter().enumerate().filter(|(_, pair)| pair.is_free);
        let rows = (free.map(|(j, _)| j), add_own);
        assemble((delassus, self.matrix), self.elimination, &contacts, rows, false)?;
        self.elimination.factorise(self.matrix, false)
    }

    /// Solves the linearised equations with the right-hand sides `goals`, and fills in the step; `None` if `dx` or `dw` is not finite.
    /// Entries of `steps` without an equation stay as they are.
    #[inline(never)]
    fn solve(&self, goals: &Goals<T, D, C, R>, steps: &mut Pairs<T, D, C, R>) -> Option<()> {
        let mut unknowns = Stacked::zero();
        let of_contacts = unknowns.contacts.as_flattened_mut();
        for (i, pair, goal, &velocity) in
            zip4(0..C, &self.pairs.contacts, &goals.contacts, &self.velocities.contacts)
        {
            let velocity = SVector::from(velocity);
            let mut right = pair.dual + goal.cone - velocity;
            if pair.part != Part::Cone {
                right = joined(pair.normal + goal.normal - first(&velocity), right);
            }
            let unknowns = of_contacts.get_mut(self.elimination.columns(i))?;
            for (unknown, right) in unknowns.iter_mut().zip(right.iter()) {
                *unknown = *right;
            }
        }
        let mut of_rows = unknowns.rows.iter_mut();
        for (pair, [p, n], &velocity) in zip3(&self.pairs.rows, &goals.rows, &self.velocities.rows) {
            if pair.is_free {
                *of_rows.next()? = pair.velocity() - velocity + (*p - *n);
            }
        }
        self.elimination.solve(self.matrix, &mut unknowns)?;
        for (i, step, pair, goal, scaling) in
            zip5(0..C, &mut steps.contacts, &self.pairs.contacts, &goals.contacts, &self.scalings)
        {
            let of_contacts = unknowns.contacts.as_flattened();
            let unknowns = of_contacts.get(self.elimination.columns(i))?;
            for (x, unknown) in step.x.iter_mut().zip(unknowns) {
                *x = *unknown;
            }
            if matches!(pair.part, Part::Normal | Part::Coulomb) {
                step.normal = goal.normal - pair.normal / first(&pair.x) * first(&step.x);
            }
            if pair.part.is_cone::<D>() {
                step.dual = goal.cone - scaling.inverse_square(&step.x);
            }
        }
        let mut changes = unknowns.rows.iter();
        for (step, pair, goals) in zip3(&mut steps.rows, &self.pairs.rows, &goals.rows) {
            if pair.is_free {
                *step = pair.step(*changes.next()?, goals);
            }
        }
        let mut contacts = steps.contacts.iter();
        let finite = contacts.all(|step| step.x.iter().chain(step.dual.iter()).all(T::is_finite))
            && steps.rows.iter().all(|step| step.impulse.is_finite());
        finite.then_some(())
    }

    /// The predictor: the step to `tau = 0`.
    pub(crate) fn predict(&self, step: &mut Pairs<T, D, C, R>) -> Option<()> {
        let goals = Goals {
            contacts: self.pairs.contacts.map(|pair| Goal { cone: -pair.dual, normal: -pair.normal }),
            rows: self.pairs.rows.map(|pair| pair.goals(None, T::ZERO)),
        };
        self.solve(&goals, step)
    }

    /// The corrector: the step to the pairs of a smaller `tau`, with the second-order terms of the predictor `step`.
    pub(crate) fn correct(
        &self,
        step: &Pairs<T, D, C, R>,
        (tau, beta): (T, T),
        corrected: &mut Pairs<T, D, C, R>,
    ) -> Option<()> {
        let mut goals = Goals {
            contacts: [Goal { cone: zeros(), normal: T::ZERO }; C],
            rows: from_fn(|j| {
                let pair = self.pairs.rows.get(j);
                pair.map_or([T::ZERO; 2], |pair| pair.goals(step.rows.get(j), tau))
            }),
        };
        for (goal, pair, step, scaling) in
            zip4(&mut goals.contacts, &self.pairs.contacts, &step.contacts, &self.scalings)
        {
            if pair.part != Part::Nothing {
                let normal = first(&pair.x);
                goal.normal = (tau - normal * pair.normal - first(&step.x) * step.normal) / normal;
            }
            if pair.part.is_cone::<D>() {
                goal.cone = scaling.corrected(pair, step, tau * beta);
            }
        }
        self.solve(&goals, corrected)
    }
}

#[cfg(test)]
mod tests;
