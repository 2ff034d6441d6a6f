//! The loop that a firmware engineer writes in place of this crate: Gauss-Seidel in contact space, contact by contact, the normal impulse to
//! zero normal velocity, then the tangential one to zero slip, clamped to the cone.
//!
//! `W = H M⁻¹ Hᵀ` comes from one Cholesky factorisation, block by block, and a sweep touches nothing of `N` rows. The error is computed
//! after every second sweep. It knows no bound on rounding and no velocity `v`, and it does not notice that a scene has no solution.

use nalgebra::{ArrayStorage, SMatrix, SVector};
use stiction::{FrictionCone, Real, Scene};

pub(crate) struct GaussSeidel<T, const N: usize, const D: usize, const C: usize> {
    /// `H_i L⁻ᵀ`, with `M = L Lᵀ`.
    whitened: [SMatrix<T, D, N>; C],
    /// `W_ij`
    delassus: [[SMatrix<T, D, D>; C]; C],
    /// Velocities without impulses.
    free: [SVector<T, D>; C],
    /// Diagonal of `W_ii`, inverted; the tangents share the larger entry.
    normal: [T; C],
    tangent: [T; C],
    /// `1 / trace(W_ii)`
    step: [T; C],
    pub(crate) impulse: [SVector<T, D>; C],
    /// `alpha` of the convex relaxation with compliance, which takes the place of Coulomb's law.
    relaxed: Option<T>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> GaussSeidel<T, N, D, C> {
    /// For Coulomb's law, or for its convex relaxation with this compliance.
    pub(crate) const fn new(relaxed: Option<T>) -> Self {
        let zeros = ArrayStorage([[T::ZERO; D]; 1]);
        let block = ArrayStorage([[T::ZERO; D]; D]);
        Self {
            whitened: [SMatrix::from_array_storage(ArrayStorage([[T::ZERO; D]; N])); C],
            delassus: [[SMatrix::from_array_storage(block); C]; C],
            free: [SVector::from_array_storage(zeros); C],
            normal: [T::ZERO; C],
            tangent: [T::ZERO; C],
            step: [T::ZERO; C],
            impulse: [SVector::from_array_storage(zeros); C],
            relaxed,
        }
    }

    /// `W`, and velocities without impulses. `None` if `M` is not positive definite.
    #[inline(never)]
    pub(crate) fn prepare<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, 0, S>,
        push: &SVector<T, N>,
    ) -> Option<()> {
        let mass = &scene.mass().data.0;
        let mut lower = [[T::ZERO; N]; N]; // the diagonal inverted
        for i in 0..N {
            for j in 0..=i {
                let (row, other) = (&lower[i], &lower[j]);
                let products = row[..j].iter().zip(&other[..j]);
                let rest = products.fold(mass[i][j], |rest, (&a, &b)| rest - a * b);
                lower[i][j] = if j < i {
                    rest * other[j]
                } else if rest > T::ZERO {
                    T::ONE / rest.square_root()
                } else {
                    return None;
                };
            }
        }
        let mut free = push.transpose();
        forward(&lower, &mut free);
        for (i, contact) in scene.contacts().iter().enumerate() {
            let mut own = contact.jacobian;
            forward(&lower, &mut own);
            *self.free.get_mut(i)? = own * free.transpose() + contact.offset;
            for j in 0..i {
                let block = product(&own, self.whitened.get(j)?);
                *self.delassus.get_mut(i)?.get_mut(j)? = block;
                *self.delassus.get_mut(j)?.get_mut(i)? = block.transpose();
            }
            let mut block = product(&own, &own);
            for k in 0..D {
                block[(k, k)] += self.relaxed.unwrap_or(T::ZERO);
            }
            let diagonal = block.diagonal();
            let largest = diagonal.iter().skip(1).fold(T::ZERO, |a, &b| a.max(b));
            *self.normal.get_mut(i)? = T::ONE / diagonal[0];
            *self.tangent.get_mut(i)? = T::ONE / largest;
            *self.step.get_mut(i)? = T::ONE / diagonal.sum();
            *self.delassus.get_mut(i)?.get_mut(i)? = block;
            *self.whitened.get_mut(i)? = own;
        }
        Some(())
    }

    /// Forgets the impulses: the next sweep starts cold.
    pub(crate) fn reset(&mut self) {
        self.impulse = [SVector::zeros(); C];
    }

    /// Sweeps until a test after every second one says that the error is small enough. Returns how many.
    #[inline(never)]
    pub(crate) fn solve<const S: usize>(
        &mut self,
        scene: &Scene<T, N, D, C, 0, S>,
        tolerance: T,
        most: usize,
    ) -> usize {
        let mut sweeps = 0;
        while sweeps < most {
            self.sweep(scene);
            self.sweep(scene);
            sweeps += 2;
            if self.is_within(scene, tolerance) {
                break;
            }
        }
        sweeps
    }

    /// `u_i = W r + q` of a contact.
    #[inline]
    fn velocity(&self, i: usize, used: usize) -> Option<SVector<T, D>> {
        let mut u = *self.free.get(i)?;
        let blocks = self.delassus.get(i)?.iter().zip(&self.impulse);
        for (block, r) in blocks.take(used) {
            u += block * r;
        }
        Some(u)
    }

    /// One sweep over all contacts.
    #[inline(never)]
    pub(crate) fn sweep<const S: usize>(&mut self, scene: &Scene<T, N, D, C, 0, S>) -> Option<()> {
        let contacts = scene.contacts();
        for (i, contact) in contacts.iter().enumerate() {
            let u = self.velocity(i, contacts.len())?;
            let r = self.impulse.get_mut(i)?;
            if self.relaxed.is_some() {
                *r = cone(contact.mu).project(&(*r - u * *self.step.get(i)?));
                continue;
            }
            let normal = (r[0] - u[0] * *self.normal.get(i)?).max(T::ZERO);
            let (more, tangent) = (normal - r[0], *self.tangent.get(i)?);
            let own = self.delassus.get(i)?.get(i)?;
            r[0] = normal;
            let mut square = T::ZERO;
            for k in 1..D {
                r[k] -= (u[k] + own[(k, 0)] * more) * tangent;
                square += r[k] * r[k];
            }
            let limit = contact.mu * normal;
            if square > limit * limit {
                let shrink = limit / square.square_root();
                for k in 1..D {
                    r[k] *= shrink;
                }
            }
        }
        Some(())
    }

    /// Is the error of the guide within a tolerance, by the size of the impulses alone?
    #[inline(never)]
    fn is_within<const S: usize>(&self, scene: &Scene<T, N, D, C, 0, S>, tolerance: T) -> bool {
        let contacts = scene.contacts();
        let [mut residual, mut size] = [T::ZERO; 2];
        let pairs = self.impulse.iter().zip(&self.step);
        for (i, (contact, (r, &step))) in contacts.iter().zip(pairs).enumerate() {
            let Some(mut u) = self.velocity(i, contacts.len()) else {
                return false;
            };
            if self.relaxed.is_none() {
                let slip = u.rows_range(1..).norm_squared().square_root();
                u[0] += contact.mu * slip;
            }
            let step = step * T::literal(D as f64);
            residual += (r - cone(contact.mu).project(&(r - u * step))).norm_squared();
            size += r.norm_squared();
        }
        residual <= tolerance * tolerance * size
    }
}

fn cone<T: Real>(mu: T) -> FrictionCone<T> {
    FrictionCone::new(mu).unwrap_or(FrictionCone::frictionless())
}

/// `X L⁻ᵀ` in place of `X`, column by column, of an `L` whose diagonal is inverted.
#[inline]
fn forward<T: Real, const D: usize, const N: usize>(lower: &[[T; N]; N], x: &mut SMatrix<T, D, N>) {
    let x = &mut x.data.0;
    for (i, row) in lower.iter().enumerate() {
        let mut sums = x[i];
        for (column, &factor) in x[..i].iter().zip(row) {
            for (sum, &entry) in sums.iter_mut().zip(column) {
                *sum -= factor * entry;
            }
        }
        x[i] = sums.map(|sum| sum * row[i]);
    }
}

/// `X Yᵀ`
#[inline]
fn product<T: Real, const D: usize, const N: usize>(
    x: &SMatrix<T, D, N>,
    y: &SMatrix<T, D, N>,
) -> SMatrix<T, D, D> {
    let mut sums = [[T::ZERO; D]; D];
    for (x, y) in x.data.0.iter().zip(&y.data.0) {
        for (sums, &y) in sums.iter_mut().zip(y) {
            for (sum, &x) in sums.iter_mut().zip(x) {
                *sum += x * y;
            }
        }
    }
    SMatrix::from_array_storage(ArrayStorage(sums))
}
