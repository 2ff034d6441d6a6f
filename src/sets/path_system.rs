//! The linearised equations of the central path ([`crate::guide::method`]). One matrix serves the predictor and the corrector of
//! Mehrotra, in two or three solves.

use crate::factor::Delassus;
use crate::linalg::elimination::Elimination;
use crate::linalg::stacked::{Stacked, StackedMatrix};
use crate::linalg::vector::zeros;
use crate::real::Real;
use crate::sets::Sets;
use crate::sets::contact::lorentz::{first, joined};
use crate::sets::contact::pair::{Pair, Part, Scaling, widen, width};
use crate::sets::pairs::Pairs;
use core::array::from_fn;
use nalgebra::SVector;

/// Enlargement of the diagonal of `W`, in units of `eps`. Along internal forces `W` is rounding alone, which at the end of a path
/// exceeds `V⁻²`: without it a step would leave the cones at once.
const REGULAR: f64 = 4.0;

/// Right-hand sides of the linearised equations of one contact.
#[derive(Clone, Copy)]
struct Goal<T, const D: usize> {
    /// `dw + V⁻² dx`, with the `w` of the pair's `dual`.
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
        let contacts = sets.contacts().iter().zip(&pairs.contacts);
        let targets = scalings.iter_mut().zip(&mut velocities.contacts);
        for ((scaling, velocity), (set, pair)) in targets.zip(contacts) {
            if pair.part.is_cone::<D>() {
                *scaling = Scaling::of(pair);
            }
            *velocity = widen(set, &(*velocity).into()).into();
        }
        Self { scalings, pairs, velocities, matrix, elimination }
    }

    /// Factorises `Λ W Λ + V⁻²`. A normal row with an equation of its own has `y_N / x_N` in place of `V⁻²`, a joint row its response.
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
        self.assemble_contacts(sets, delassus, regular)?;
        self.assemble_rows(sets, delassus, regular)?;
        self.elimination.factorise(self.matrix, false)
    }

    /// Writes the equations of contacts in the unknowns of contacts.
    #[inline]
    fn assemble_contacts(
        &mut self,
        sets: &Sets<T, D, C, R>,
        delassus: &Delassus<T, D, C, R>,
        regular: T,
    ) -> Option<()> {
        let contacts = || sets.contacts().iter().zip(&self.pairs.contacts);
        for (j, (set, pair)) in contacts().enumerate() {
            let (start, count) = (self.elimination.columns(j).start, pair.count());
            let blocks = self.matrix.contacts.iter_mut().zip(&delassus.contacts);
            for (i, ((rows, sources), (row_set, row_pair))) in blocks.zip(contacts()).enumerate() {
                if count == 0 || row_pair.count() == 0 {
                    continue;
                }
                for (k, (row, source)) in rows.iter_mut().zip(sources).enumerate() {
                    let mut entries = [T::ZERO; D];
                    if k < row_pair.count() {
                        let mut wide = widen(set, &(*source.get(j)?).into());
                        if k > 0 {
                            wide *= width(row_set, k);
                        }
                        if i == j {
                            if let Some(diagonal) = wide.as_mut_slice().get_mut(k) {
                                *diagonal *= regular;
                            }
                            wide += self.scalings.get(i)?.row(pair, k);
                        }
                        for (entry, &wide) in entries.iter_mut().zip(wide.iter()).take(count) {
                            *entry = wide;
                        }
                    }
                    // Zeros behind the columns of the contact: the next contact overwrites them.
                    let target = row.contacts.as_flattened_mut().get_mut(start..)?;
                    *target.first_chunk_mut()? = entries;
                }
            }
        }
        Some(())
    }

    /// Writes the equations of joint rows, and their unknowns into the equations of contacts.
    #[inline]
    fn assemble_rows(
        &mut self,
        sets: &Sets<T, D, C, R>,
        delassus: &Delassus<T, D, C, R>,
        regular: T,
    ) -> Option<()> {
        let pairs = self.pairs;
        let free = || {
            let rows = pairs.rows.iter().enumerate();
            rows.filter(|(_, pair)| pair.is_free)
        };
        for (index, (j, pair)) in free().enumerate() {
            let (coupling, sources) = (delassus.coupling.get(j)?, delassus.rows.get(j)?);
            let target = self.matrix.rows.get_mut(index)?;
            for (entry, (k, _)) in target.rows.iter_mut().zip(free()) {
                *entry = *sources.get(k)?;
            }
            let alpha = sets.rows().get(j)?.alpha;
            let diagonal = target.rows.get_mut(index)?;
            *diagonal = *diagonal * regular + pair.response(alpha);
            let contacts = sets.contacts().iter().zip(&pairs.contacts).zip(coupling);
            for (i, ((set, pair), &source)) in contacts.enumerate() {
                let wide = widen(set, &source.into());
                let columns = self.elimination.columns(i);
                let entries = target.contacts.as_flattened_mut().get_mut(columns)?;
                for (entry, &wide) in entries.iter_mut().zip(wide.iter()) {
                    *entry = wide;
                }
                let rows = self.matrix.contacts.get_mut(i)?.iter_mut();
                for (k, (row, &wide)) in rows.zip(wide.iter()).enumerate() {
                    let used = k < pair.count();
                    *row.rows.get_mut(index)? = if used { wide } else { T::ZERO };
                }
            }
        }
        Some(())
    }

    /// Solves the linearised equations with the right-hand sides `goals`, and fills in the step; `None` if `dx` or `dw` is not finite.
    /// Entries of `steps` without an equation stay as they are.
    #[inline(never)]
    fn solve(&self, goals: &Goals<T, D, C, R>, steps: &mut Pairs<T, D, C, R>) -> Option<()> {
        let mut unknowns = Stacked::zero();
        let of_contacts = unknowns.contacts.as_flattened_mut();
        for (i, (pair, goal)) in self.pairs.contacts.iter().zip(&goals.contacts).enumerate() {
            let velocity = SVector::from(*self.velocities.contacts.get(i)?);
            let mut right = pair.dual + goal.cone - velocity;
            if pair.part != Part::Cone {
                right = joined(pair.normal + goal.normal - first(&velocity), right);
            }
            let unknowns = of_contacts.get_mut(self.elimination.columns(i))?;
            for (unknown, right) in unknowns.iter_mut().zip(right.iter()) {
                *unknown = *right;
            }
        }
        let rows = self.pairs.rows.iter().zip(&goals.rows);
        let rows = rows.zip(&self.velocities.rows);
        let free = rows.filter(|((pair, _), _)| pair.is_free);
        for (unknown, ((pair, [p, n]), &velocity)) in unknowns.rows.iter_mut().zip(free) {
            *unknown = pair.velocity() - velocity + (*p - *n);
        }
        self.elimination.solve(self.matrix, &mut unknowns)?;
        let contacts = self.pairs.contacts.iter().zip(&goals.contacts);
        let contacts = contacts.zip(&self.scalings);
        for (i, (step, ((pair, goal), scaling))) in steps.contacts.iter_mut().zip(contacts).enumerate() {
            let of_contacts = unknowns.contacts.as_flattened();
            let unknowns = of_contacts.get(self.elimination.columns(i))?;
            for (x, unknown) in step.x.iter_mut().zip(unknowns) {
                *x = *unknown;
            }
            if matches!(pair.part, Part::Normal | Part::Coulomb) {
                step.normal = goal.normal - pair.normal / first(&pair.x) * first(&step.x);
            }
            if pair.part.is_cone::<D>() {
                step.dual = goal.cone - scaling.compliance(&step.x);
            }
        }
        let rows = self.pairs.rows.iter().zip(&goals.rows);
        let rows = steps.rows.iter_mut().zip(rows);
        let free = rows.filter(|(_, (pair, _))| pair.is_free);
        for ((step, (pair, goals)), &change) in free.zip(&unknowns.rows) {
            *step = pair.step(change, goals);
        }
        let mut contacts = steps.contacts.iter();
        let finite = contacts.all(|step| step.x.iter().chain(step.dual.iter()).all(T::is_finite))
            && steps.rows.iter().all(|step| step.impulse.is_finite());
        finite.then_some(())
    }

    /// The predictor: the step to `tau = 0`.
    #[cfg_attr(target_os = "none", inline(never))]
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
        let contacts = self.pairs.contacts.iter().zip(&step.contacts);
        let contacts = contacts.zip(&self.scalings);
        for (goal, ((pair, step), scaling)) in goals.contacts.iter_mut().zip(contacts) {
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
