//! The spring of a contact and that of a joint row: what each may bear, and how its impulse changes with the motion.

use crate::cone::{FrictionCone, split};
use crate::linalg::blocks::{product, row_times};
use crate::linalg::sparsity::GROUP;
use crate::linalg::vector::norm;
use crate::linalg::zip::zip3;
use crate::real::Real;
use nalgebra::SVector;

/// What a contact may bear at its velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Bearing<T, const D: usize> {
    /// The impulse that it has: nothing, for an open contact.
    Known,
    /// Any impulse of its cone: it sticks.
    Cone,
    /// An impulse along the unit vector on the boundary of its cone that opposes its slip.
    Ray([T; D]),
}

/// The spring of a contact, in scaled rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactSpring<T: Real, const D: usize> {
    pub(super) bearing: Bearing<T, D>,
    pub(super) cone: FrictionCone<T>,
    /// `k_i`
    pub(super) stiffness: T,
    /// `a_i`
    pub(super) anchor: [T; D],
}

/// The spring of a joint row.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowSpring<T> {
    /// The least and the largest impulse (N·s, N·m·s).
    pub(super) bounds: [T; 2],
    /// `k_j`, 0 if its impulse is known because the row moves.
    pub(super) stiffness: T,
    /// `a_j`
    pub(super) anchor: T,
}

impl<T: Real, const D: usize> ContactSpring<T, D> {
    /// A contact that bears nothing.
    pub(super) const fn none() -> Self {
        Self {
            bearing: Bearing::Known,
            cone: FrictionCone::frictionless(),
            stiffness: T::ZERO,
            anchor: [T::ZERO; D],
        }
    }

    /// Impulse of the spring where the contact moves by `u`, before the projection.
    pub(super) fn pull(&self, u: &[T; D]) -> [T; D] {
        let mut z = *u;
        for (z, &anchor) in z.iter_mut().zip(&self.anchor) {
            *z = (*z + anchor) * self.stiffness;
        }
        z
    }

    /// The nearest impulse that the contact may bear. It is 0 for one whose impulse is known.
    pub(super) fn project(&self, z: [T; D]) -> [T; D] {
        match &self.bearing {
            Bearing::Known => [T::ZERO; D],
            Bearing::Cone => self.cone.nearest(&z.into()).into(),
            Bearing::Ray(ray) => {
                let length = product(ray, &z).max(T::ZERO);
                ray.map(|ray| ray * length)
            }
        }
    }

    /// Adds `X B Xᵀ` to the lower triangle of a matrix, where `B` is the derivative of [`Self::project`] times the stiffness. The rows of
    /// `columns` are those of `X`. `is_free` takes the whole cone for its inside.
    pub(super) fn add_slope<const N: usize>(
        &self,
        z: &[T; D],
        is_free: bool,
        (columns, groups): (&[[T; D]; N], impl Iterator<Item = usize> + Clone),
        matrix: &mut [[T; N]; N],
    ) {
        let k = self.stiffness;
        match &self.bearing {
            Bearing::Known => {}
            Bearing::Ray(ray) => {
                if is_free || product(ray, z) > T::ZERO {
                    let column = columns.each_ref().map(|column| [product(column, ray)]);
                    add_outer(|x| x.map(|x| x * k), (&column, groups), matrix);
                }
            }
            Bearing::Cone => {
                let z = SVector::from(*z);
                if is_free || self.cone.has(&z) {
                    add_outer(|x| x.map(|x| x * k), (columns, groups), matrix);
                } else if let Some(block) = self.slope_of_boundary(&z) {
                    add_outer(|x| row_times(x, &block), (columns, groups), matrix);
                }
            }
        }
    }

    /// The derivative where `z` is projected onto the boundary of the cone, times the stiffness; `None` if it is projected onto 0.
    fn slope_of_boundary(&self, z: &SVector<T, D>) -> Option<[[T; D]; D]> {
        let (normal, tangent) = split(z);
        let (mu, length) = (self.cone.friction(), norm(tangent));
        let along = self.cone.along(normal, length);
        if along <= T::ZERO || length <= T::ZERO {
            return None;
        }
        let ray = self.stiffness * self.cone.shrink();
        let turn = self.stiffness * mu * along / length;
        let slide: [T; D] = (*z * (T::ONE / length)).into(); // behind the normal
        let mut block = [[T::ZERO; D]; D];
        for (i, row, &e) in zip3(0..D, &mut block, &slide) {
            for (j, entry, &f) in zip3(0..D, row, &slide) {
                *entry = match (i, j) {
                    (0, 0) => ray,
                    (0, _) => ray * mu * f,
                    (_, 0) => ray * mu * e,
                    _ => (ray * mu * mu - turn) * (e * f) + if i == j { turn } else { T::ZERO },
                };
            }
        }
        Some(block)
    }
}

impl<T: Real> RowSpring<T> {
    /// A row that bears nothing.
    pub(super) const fn none() -> Self {
        Self { bounds: [T::ZERO; 2], stiffness: T::ZERO, anchor: T::ZERO }
    }

    /// The nearest impulse within the bounds; 0 for a row whose impulse is known.
    pub(super) fn project(&self, z: T) -> T {
        if self.stiffness == T::ZERO {
            return T::ZERO;
        }
        let [lower, upper] = self.bounds;
        z.max(lower).min(upper)
    }

    /// Is an impulse between the bounds?
    pub(super) fn is_inside(&self, z: T) -> bool {
        let [lower, upper] = self.bounds;
        lower < z && z < upper
    }

    /// Has the spring an impulse where nothing moves?
    pub(super) fn pushes(&self) -> bool {
        self.stiffness > T::ZERO && self.project(self.anchor * self.stiffness) != T::ZERO
    }
}

/// `A += X B Xᵀ` in the lower triangle, and beside the diagonal. The rows of `columns` are those of `X`; those outside the support are zero.
#[inline]
pub(super) fn add_outer<T: Real, const N: usize, const K: usize>(
    times: impl Fn(&[T; K]) -> [T; K],
    (columns, groups): (&[[T; K]; N], impl Iterator<Item = usize> + Clone),
    matrix: &mut [[T; N]; N],
) {
    let add = |x: &[T; K], row: &mut [T], columns: &[[T; K]]| {
        for (entry, y) in row.iter_mut().zip(columns) {
            *entry += product(x, y);
        }
    };
    let (whole, rest) = columns.as_chunks::<GROUP>();
    let (rows, last) = matrix.as_chunks_mut::<GROUP>();
    for a in groups.clone() {
        let (Some(rows), Some(own)) = (rows.get_mut(a), whole.get(a)) else { continue };
        for (row, x) in rows.iter_mut().zip(own) {
            let (x, row) = (times(x), row.as_chunks_mut::<GROUP>().0);
            for b in groups.clone().take_while(|&b| b <= a) {
                if let (Some(row), Some(columns)) = (row.get_mut(b), whole.get(b)) {
                    add(&x, row, columns);
                }
            }
        }
    }
    for (row, x) in last.iter_mut().zip(rest) {
        add(&times(x), row, columns);
    }
}
