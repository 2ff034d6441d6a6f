//! The note's iteration, step by step in velocity space, with what is open in it left open.

use crate::outcome::Outcome;
use nalgebra::{Cholesky, DVector, Dyn};
use testbed::measure::{self, Law};
use testbed::scene_file::SceneFile;

#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Acceleration {
    Plain,
    /// Algorithm 1.
    Fast,
    /// Algorithm 2.
    Restart,
}

/// Where the tangential speed `s` comes from.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Slip {
    /// `|ũ_T|`, at every iteration.
    Projected,
    /// `|u_T|` of `u = H v + w`, at every iteration.
    OfVelocity,
    /// `|ũ_T|`, each time the problem with `s` frozen is solved, to so many tolerances.
    OuterLoop(f64),
}

/// What is done as the note prints it; nothing is what the library does.
#[derive(Clone, Copy, Default)]
pub(crate) struct Printed {
    /// Step 2 starts from `ũ`, not `û`.
    pub(crate) step_2: bool,
    /// Steps 6-8 extrapolate from the `_hat` values, not from the new iterate.
    pub(crate) extrapolation: bool,
    /// A restart goes back to the previous iterate with `e_k = e_{k-1} / eta`, instead of staying
    /// at the current one with its own `e_k`.
    pub(crate) restart: bool,
}

#[derive(Clone, Copy)]
pub(crate) struct Variant {
    pub(crate) acceleration: Acceleration,
    pub(crate) slip: Slip,
    pub(crate) printed: Printed,
}

/// A scene ready to be iterated on.
pub(crate) struct Note<'a> {
    file: &'a SceneFile,
    rho: f64,
    mass: Cholesky<f64, Dyn>,
    /// `A = M + rho HᵀH`
    augmented: Cholesky<f64, Dyn>,
    /// `alpha_i = D / trace(W_ii)`, row by row.
    alpha: DVector<f64>,
    /// Of the impulses to expect, see `testbed::measure`.
    size: f64,
}

struct Iterate {
    u: DVector<f64>,
    zeta: DVector<f64>,
    u_hat: DVector<f64>,
    zeta_hat: DVector<f64>,
    /// `mu_i s_i e_N`
    lift: DVector<f64>,
    tau: f64,
    /// `e_{k-1}`
    residual: f64,
}

impl<'a> Note<'a> {
    pub(crate) fn new(file: &'a SceneFile, rho: f64) -> Self {
        let (h, d) = (&file.h, file.dim);
        let mass = file.mass.clone().cholesky().expect("M > 0");
        let augmented = (&file.mass + h.transpose() * h * rho).cholesky();
        let delassus = h * mass.solve(&h.transpose());
        let alpha = DVector::from_fn(file.w.len(), |row, _| {
            let mobility = delassus.diagonal().rows(row / d * d, d).mean();
            if mobility > 0.0 { 1.0 / mobility } else { 0.0 }
        });
        Self {
            file,
            rho,
            mass,
            augmented: augmented.expect("A > 0"),
            size: measure::size(file, Law::Coulomb),
            alpha,
        }
    }

    /// Iterates from rest until the measured error is at most the tolerance.
    pub(crate) fn solve(&self, variant: Variant, tolerance: f64, cap: usize) -> Outcome {
        let rest = DVector::zeros(self.file.w.len());
        let mut iterate = Iterate::at(&rest, &rest, &rest);
        let mut coulomb_error = self.error(&iterate);
        let mut iterations = 0;
        // The error costs more than an iteration: it is looked at where its estimate is near the tolerance.
        while coulomb_error > tolerance && iterations < cap {
            iterations += 1;
            let estimate = self.iterate(&mut iterate, variant);
            if let Slip::OuterLoop(share) = variant.slip
                && estimate <= share * tolerance
            {
                iterate.lift = self.lift(&iterate.u);
                iterate.tau = 1.0;
                iterate.residual = f64::INFINITY;
            }
            if estimate <= 2.0 * tolerance || iterations == cap {
                coulomb_error = self.error(&iterate);
            }
        }
        Outcome {
            solved: coulomb_error <= tolerance,
            iterations,
            coulomb_error,
            impulse: (&iterate.zeta * -self.rho).as_slice().to_vec(),
        }
    }

    /// Error that plain ADMM with `s` at every iteration has made, after so many iterations, of a
    /// solution it was started from.
    pub(crate) fn drift(&self, impulse: &[f64], iterations: usize) -> f64 {
        let r = DVector::from_column_slice(impulse);
        let zeta = &r / -self.rho;
        let relative = &self.file.h * self.velocity(&r) + &self.file.w;
        let lift = self.lift(&relative);
        let u = self.project(&(relative + &lift + &zeta));
        let mut iterate = Iterate::at(&u, &zeta, &lift);
        let variant =
            Variant { acceleration: Acceleration::Plain, slip: Slip::Projected, printed: Printed::default() };
        for _ in 0..iterations {
            self.iterate(&mut iterate, variant);
        }
        self.error(&iterate)
    }

    /// `v = M⁻¹ (Hᵀ r - f)`
    fn velocity(&self, r: &DVector<f64>) -> DVector<f64> {
        self.mass.solve(&(self.file.h.tr_mul(r) - &self.file.f))
    }

    /// Measured error of `r = -rho ζ` and the velocity it causes.
    fn error(&self, iterate: &Iterate) -> f64 {
        let r = &iterate.zeta * -self.rho;
        let v = self.velocity(&r);
        measure::error(self.file, v.as_slice(), r.as_slice(), Law::Coulomb)
    }

    /// `mu_i |u_Ti| e_N`
    fn lift(&self, u: &DVector<f64>) -> DVector<f64> {
        let (mut lift, d) = (DVector::zeros(u.len()), self.file.dim);
        for (i, mu) in self.file.mu.iter().enumerate() {
            lift[i * d] = mu * u.rows(i * d + 1, d - 1).norm();
        }
        lift
    }

    /// `Π_{K*}(z) = z + Π_K(-z)`, contact by contact.
    fn project(&self, z: &DVector<f64>) -> DVector<f64> {
        let minus = -z;
        let contacts = minus.as_slice().chunks_exact(self.file.dim);
        let impulses = contacts.zip(&self.file.mu);
        let r: Vec<f64> = impulses.flat_map(|(x, &mu)| measure::project(x, mu)).collect();
        z + DVector::from_vec(r)
    }

    /// Steps 2-14; returns an estimate of the error.
    fn iterate(&self, x: &mut Iterate, variant: Variant) -> f64 {
        let (h, printed) = (&self.file.h, variant.printed);
        let start = if printed.step_2 { &x.u } else { &x.u_hat };
        let b = &self.file.w + &x.lift;
        let pull = h.tr_mul(&(start - &b - &x.zeta_hat)) * self.rho;
        let v = self.augmented.solve(&(pull - &self.file.f));
        let z = h * &v + &b + &x.zeta_hat;
        let u = self.project(&z);
        let zeta = z - &u;

        let mut primal = &zeta - &x.zeta_hat;
        let dual = &u - start;
        let residual = self.rho * (primal.norm_squared() + dual.norm_squared());
        let lift = match variant.slip {
            Slip::Projected => self.lift(&u),
            Slip::OfVelocity => self.lift(&(h * &v + &self.file.w)),
            Slip::OuterLoop(_) => x.lift.clone(),
        };
        primal += &lift - &x.lift;
        let left = self.alpha.component_mul(&primal).norm();
        let left = left.hypot(self.rho * dual.norm());
        let estimate = left / self.size.max(self.rho * zeta.norm());

        x.lift = lift;
        x.extrapolate(u, zeta, residual, variant);
        estimate
    }
}

impl Iterate {
    /// An iterate without momentum.
    fn at(u: &DVector<f64>, zeta: &DVector<f64>, lift: &DVector<f64>) -> Self {
        Self {
            u: u.clone(),
            zeta: zeta.clone(),
            u_hat: u.clone(),
            zeta_hat: zeta.clone(),
            lift: lift.clone(),
            tau: 1.0,
            residual: f64::INFINITY,
        }
    }

    /// Steps 5-14, from the old iterate to the new one.
    fn extrapolate(&mut self, u: DVector<f64>, zeta: DVector<f64>, residual: f64, variant: Variant) {
        const ETA: f64 = 0.999;
        let previous = std::mem::replace(&mut self.residual, residual);
        let restart = variant.acceleration == Acceleration::Restart && residual >= ETA * previous;
        if restart {
            self.tau = 1.0;
            if variant.printed.restart {
                self.u_hat.clone_from(&self.u);
                self.zeta_hat.clone_from(&self.zeta);
                self.residual = previous / ETA;
            } else {
                self.u_hat.clone_from(&u);
                self.zeta_hat.clone_from(&zeta);
            }
        } else {
            let next = 0.5 * (1.0 + (1.0 + 4.0 * self.tau * self.tau).sqrt());
            let momentum = match variant.acceleration {
                Acceleration::Plain => 0.0,
                Acceleration::Fast | Acceleration::Restart => (self.tau - 1.0) / next,
            };
            self.tau = next;
            if !variant.printed.extrapolation {
                self.u_hat.clone_from(&u);
                self.zeta_hat.clone_from(&zeta);
            }
            self.u_hat += (&u - &self.u) * momentum;
            self.zeta_hat += (&zeta - &self.zeta) * momentum;
        }
        self.u = u;
        self.zeta = zeta;
    }
}
