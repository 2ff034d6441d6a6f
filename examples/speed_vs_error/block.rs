//! Coulomb's law at one contact, solved exactly: the block step of Gauss-Seidel.
//!
//! With `û` the relative velocity that the other contacts leave: open if `û_N >= 0`; sticking if
//! `-W⁻¹ û` is in the cone; else slipping, `u_N = 0` and `u_T = -lambda r_T` with the `lambda > 0`
//! that puts `r` on the boundary. In the axes of the tangential Schur complement `S` the impulse is
//! `r_T = b / (s + lambda)`, and `mu r_N / |r_T| - 1` is nearly linear in `lambda`.

use nalgebra::SVector;
use stiction::Real;

/// `W_ii` in the form that the step needs. `D` = 2 has a second tangent that is always zero.
#[derive(Clone, Copy)]
pub(crate) struct Block<T, const D: usize> {
    mu: T,
    /// `1 / W_NN`
    compliance: T,
    /// First principal axis of `S = W_TT - W_TN W_NT / W_NN`, and its eigenvalues.
    axis: [T; 2],
    stiffness: [T; 2],
    /// `W_TN` along the principal axes.
    coupling: [T; 2],
}

/// A slipping or sticking impulse in principal axes, and what Newton's method asks of it.
struct Trial<T> {
    normal: T,
    tangent: [T; 2],
    length: T,
    /// Derivative of `normal` and `length` by `lambda`.
    slope: [T; 2],
}

impl<T: Real, const D: usize> Block<T, D> {
    pub(crate) const NONE: Self = Self {
        mu: T::ZERO,
        compliance: T::ZERO,
        axis: [T::ONE, T::ZERO],
        stiffness: [T::ONE; 2],
        coupling: [T::ZERO; 2],
    };

    /// `entry(a, b)` is `W_ii[a][b]`.
    pub(crate) fn new(mu: T, entry: impl Fn(usize, usize) -> T) -> Self {
        let rounding = T::EPSILON * (0..D).fold(T::ZERO, |sum, k| sum + entry(k, k));
        let compliance = T::ONE / entry(0, 0).max(rounding);
        let schur = |a: usize, b: usize| entry(a, b) - entry(a, 0) * entry(b, 0) * compliance;
        let mut block = Self {
            mu,
            compliance,
            stiffness: [schur(1, 1).max(rounding), T::ONE],
            coupling: [entry(1, 0), T::ZERO],
            ..Self::NONE
        };
        if D == 3 {
            let (a, b, c) = (schur(1, 1), schur(1, 2), schur(2, 2));
            let half = T::literal(0.5);
            let (mean, difference) = ((a + c) * half, (a - c) * half);
            let radius = (difference * difference + b * b).square_root();
            // Eigenvector of the larger eigenvalue, from the longer of its two forms.
            let axis = if difference > T::ZERO { [radius + difference, b] } else { [b, radius - difference] };
            let length = (axis[0] * axis[0] + axis[1] * axis[1]).square_root();
            if length > T::ZERO {
                block.axis = axis.map(|x| x / length);
            }
            block.stiffness = [mean + radius, mean - radius].map(|s| s.max(rounding));
            block.coupling = block.along_axes([entry(1, 0), entry(2, 0)]);
        }
        block
    }

    fn along_axes(&self, [x, y]: [T; 2]) -> [T; 2] {
        let [c, s] = self.axis;
        [c * x + s * y, c * y - s * x]
    }

    fn out_of_axes(&self, [x, y]: [T; 2]) -> [T; 2] {
        let [c, s] = self.axis;
        [c * x - s * y, s * x + c * y]
    }

    fn trial(&self, normal_velocity: T, b: [T; 2], lambda: T) -> Trial<T> {
        let [k0, k1] = self.stiffness.map(|s| T::ONE / (s + lambda));
        let tangent = [b[0] * k0, b[1] * k1];
        let bend = [tangent[0] * k0, tangent[1] * k1];
        let along = |x: [T; 2]| self.coupling[0] * x[0] + self.coupling[1] * x[1];
        let length = (tangent[0] * tangent[0] + tangent[1] * tangent[1]).square_root();
        Trial {
            normal: -(normal_velocity + along(tangent)) * self.compliance,
            slope: [along(bend) * self.compliance, -(tangent[0] * bend[0] + tangent[1] * bend[1]) / length],
            tangent,
            length,
        }
    }

    /// The impulse for the velocity `u` that the other contacts leave; `lambda` is where the last
    /// step ended, and is updated.
    pub(crate) fn solve(&self, u: &SVector<T, D>, lambda: &mut T) -> SVector<T, D> {
        if u[0] >= T::ZERO {
            return SVector::zeros();
        }
        let second = if D == 3 { u[D - 1] } else { T::ZERO };
        let [x, y] = self.along_axes([u[1], second]);
        let drop = u[0] * self.compliance;
        let b = [self.coupling[0] * drop - x, self.coupling[1] * drop - y];
        let mut trial = self.trial(u[0], b, T::ZERO);
        if trial.length > self.mu * trial.normal {
            trial = self.slip(u[0], b, lambda);
        }
        let tangent = self.out_of_axes(trial.tangent);
        SVector::from_fn(|k, _| if k == 0 { trial.normal } else { tangent[k - 1] })
    }

    /// The root of `mu r_N / |r_T| - 1`, negative at `lambda = 0` and positive far out.
    fn slip(&self, normal_velocity: T, b: [T; 2], lambda: &mut T) -> Trial<T> {
        if self.mu == T::ZERO {
            return Trial {
                normal: -normal_velocity * self.compliance,
                tangent: [T::ZERO; 2],
                length: T::ZERO,
                slope: [T::ZERO; 2],
            };
        }
        let (mut low, mut high) = (T::ZERO, None);
        let mut trial = self.trial(normal_velocity, b, *lambda);
        for _ in 0..40 {
            let excess = self.mu * trial.normal / trial.length - T::ONE;
            if excess.abs() <= T::literal(4.0) * T::EPSILON {
                break;
            }
            if excess < T::ZERO {
                low = *lambda;
            } else {
                high = Some(*lambda);
            }
            let [normal, length] = trial.slope;
            let slope = self.mu * (normal - trial.normal * length / trial.length) / trial.length;
            let newton = *lambda - excess / slope;
            let inside = newton > low && high.is_none_or(|high| newton < high);
            *lambda = match high {
                _ if inside => newton,
                Some(high) => (low + high) * T::literal(0.5),
                None => (*lambda + self.stiffness[0]) * T::literal(2.0),
            };
            trial = self.trial(normal_velocity, b, *lambda);
        }
        let fit = self.mu * trial.normal / trial.length;
        trial.tangent = trial.tangent.map(|x| x * fit);
        trial
    }
}
