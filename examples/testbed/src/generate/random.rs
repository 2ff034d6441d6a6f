//! Random numbers that are the same on every machine.

use nalgebra::{DVector, Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::TAU;

/// A count as a number to compute with.
pub(super) fn real(count: usize) -> f64 {
    u32::try_from(count).map_or(f64::INFINITY, f64::from)
}

/// A seeded source; logarithms and sines come from `libm`, so a seed means the same everywhere.
pub(super) struct Random(Pcg64Mcg);

impl Random {
    /// The source of the scene `index` of a campaign.
    pub(super) fn new(seed: u64, index: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed.rotate_left(32) ^ index))
    }

    pub(super) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// Uniform in the logarithm.
    pub(super) fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.uniform(libm::log(low), libm::log(high)))
    }

    /// `e` to a uniform power.
    pub(super) fn exp(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.uniform(low, high))
    }

    /// Ten to a uniform power.
    pub(super) fn power_of_ten(&mut self, low: f64, high: f64) -> f64 {
        libm::exp10(self.uniform(low, high))
    }

    /// Standard normal distribution.
    pub(super) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.uniform(0.0, 1.0))).sqrt();
        radius * libm::cos(self.uniform(0.0, TAU))
    }

    /// `n` numbers of the standard normal distribution.
    pub(super) fn normals(&mut self, n: usize) -> DVector<f64> {
        DVector::from_fn(n, |_, _| self.normal())
    }

    /// Three numbers of the standard normal distribution.
    pub(super) fn vector(&mut self) -> Vector3<f64> {
        self.vector_of(Self::normal)
    }

    /// Three numbers of any distribution.
    pub(super) fn vector_of(&mut self, mut entry: impl FnMut(&mut Self) -> f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| entry(self))
    }

    /// Nine numbers of the standard normal distribution.
    pub(super) fn matrix(&mut self) -> Matrix3<f64> {
        Matrix3::from_fn(|_, _| self.normal())
    }

    /// 1 or -1.
    pub(super) fn sign(&mut self) -> f64 {
        self.pick(&[-1.0, 1.0])
    }

    /// One of `low..=high`.
    pub(super) fn count(&mut self, low: usize, high: usize) -> usize {
        self.0.random_range(low..=high)
    }

    /// One of `low..=high`.
    pub(super) fn exponent(&mut self, low: i32, high: i32) -> i32 {
        self.0.random_range(low..=high)
    }

    /// True once in `n` times.
    pub(super) fn one_in(&mut self, n: u32) -> bool {
        self.0.random_ratio(1, n)
    }

    pub(super) fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.count(0, choices.len() - 1)]
    }

    /// A friction coefficient: now and then an extreme one.
    pub(super) fn friction(&mut self) -> f64 {
        let usual = self.uniform(0.1, 1.2);
        self.pick(&[0.0, 1e-6, 0.05, 0.3, 0.5, 0.8, 1.0, 5.0, 10.0, usual, usual, usual, usual, usual])
    }

    /// Two or three rows a contact: spatial three times in four.
    pub(super) fn dimension(&mut self) -> usize {
        self.pick(&[2, 3, 3, 3])
    }
}
