//! What scenes of contacts alone and scenes with joint rows do differently, and what a stranger says of their solutions.

use super::cases::is_tame;
use super::steps::Step;
use nalgebra::{SMatrix, SVector};
use stiction::{AdmmFactor, AdmmSolver, Contact, Model, Real, Scene, Settings, Solution, Status};
use testbed::measure;
use testbed::scene_file::SceneFile;

pub(super) fn double<T: Real>(x: T) -> f64 {
    x.to_subset().unwrap_or(f64::NAN)
}

pub(super) fn at<T: Real>(numbers: &[f64], i: usize) -> T {
    T::literal(numbers[i % numbers.len()])
}

pub(super) fn vector<T: Real, const K: usize>(numbers: &[f64]) -> SVector<T, K> {
    SVector::from_fn(|i, _| at(numbers, i))
}

/// `R Rᵀ + I / 100 |R|²`, or `raw` `R` itself, of so many velocities; behind them stands no number.
pub(super) fn mass<T: Real, const N: usize>(
    numbers: &[f64],
    raw: bool,
    velocities: usize,
) -> SMatrix<T, N, N> {
    let root = SMatrix::<T, N, N>::from_fn(|i, j| at(numbers, i.min(j) * N + i.max(j)));
    let more = SMatrix::identity() * (root.norm_squared() * T::literal(0.01));
    let mass = if raw { root } else { root * root.transpose() + more };
    SMatrix::from_fn(|i, j| if i.max(j) < velocities { mass[(i, j)] } else { T::literal(f64::NAN) })
}

pub(super) fn contact<T: Real, const N: usize, const D: usize>(
    numbers: &[f64],
    mu: f64,
    key: u32,
) -> Contact<T, N, D> {
    Contact {
        jacobian: SMatrix::from_fn(|i, j| at(numbers, i * N + j)),
        offset: SVector::from_fn(|i, _| at(numbers, D * N + i)),
        mu: T::literal(mu),
        key,
    }
}

/// What goes into a scene, and what comes with that.
pub(super) trait Kind<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
{
    /// What is remembered beside the kernel.
    type Beside: Default;

    /// Calls that only some scenes have. Those that all have come afterwards.
    fn call(beside: &mut Self::Beside, scene: &mut Scene<T, N, D, C, R, S>, step: &Step);

    /// Checks that come with a solve, if there are any.
    fn check(_: &mut Self::Beside, _: &Scene<T, N, D, C, R, S>, _: &SVector<T, N>, _: &Settings<T>) {}

    /// The error of a solution, unless f64 cannot tell; and whether its proof is one.
    fn judge(
        beside: &Self::Beside,
        scene: &Scene<T, N, D, C, R, S>,
        push: &SVector<T, N>,
        solution: &Solution<T, N, D, C, R>,
        model: Model,
    ) -> Option<(f64, bool)>;
}

/// Rigid contacts of one friction coefficient.
pub(super) struct Contacts;

impl<T: Real, const N: usize, const D: usize, const C: usize> Kind<T, N, D, C, 0, 0> for Contacts {
    type Beside = AdmmSolver<T, N, D, C>;

    fn call(_: &mut Self::Beside, scene: &mut Scene<T, N, D, C>, step: &Step) {
        if let Step::Push(x, mu, key) = step {
            let _ = scene.push(&contact(x, *mu, *key));
        }
    }

    /// ADMM's answer to the same.
    fn check(
        admm: &mut Self::Beside,
        scene: &Scene<T, N, D, C>,
        push: &SVector<T, N>,
        settings: &Settings<T>,
    ) {
        let Ok(factor) = AdmmFactor::new(scene) else {
            return;
        };
        if let Ok(solution) = admm.solve(scene, &factor, push, settings) {
            super::is_true::<T, N, D, C, 0, 0, Self>(&AdmmSolver::new(), scene, push, solution, settings);
            assert!(solution.work.total() <= settings.budget + 27);
        }
    }

    fn judge(
        _: &Self::Beside,
        scene: &Scene<T, N, D, C>,
        push: &SVector<T, N>,
        solution: &Solution<T, N, D, C>,
        model: Model,
    ) -> Option<(f64, bool)> {
        let file = SceneFile::of(scene, push);
        let vectors = file.f.iter().chain(&file.w).chain(&file.mu);
        if !is_tame::<T>(file.mass.iter().chain(&file.h).chain(vectors)) {
            return None;
        }
        file.mass.clone().cholesky()?;
        let law = match model {
            Model::Coulomb => measure::Law::Coulomb,
            Model::ConvexRelaxation => measure::Law::Relaxed,
        };
        let normals = solution.certificate.iter().map(|d| double(d[0]));
        let certificate: Vec<f64> = normals.collect();
        let proof = solution.status != Status::Infeasible
            || measure::proof(&file, &certificate) > 0.01 / double(T::EPSILON).sqrt();
        Some((measure::error_of(scene, push, solution, law), proof))
    }
}
