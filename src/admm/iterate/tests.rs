//! The iterates against the steps of the note, with a dense solve in `N` velocities.
#![allow(clippy::indexing_slicing, clippy::expect_used, clippy::integer_division)]

extern crate std;

use super::{Acceleration, Extrapolation, Iterate, SlipUpdate, iterate};
use crate::problem::{Age, Problem};
use crate::{AdmmFactor, Contact, FrictionCone, Model, Scene, Settings};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use proptest::collection::vec;
use proptest::prelude::*;
use std::vec::Vec;

const N: usize = 6;
const D: usize = 3;
const C: usize = 3;
const ROWS: usize = D * C;

/// Steps 1-8 of Algorithm 1 and 1-15 of Algorithm 2, as the module's doc puts them right.
struct Note {
    h: DMatrix<f64>,
    f: DVector<f64>,
    w: DVector<f64>,
    cones: Vec<(f64, FrictionCone<f64>)>,
    matrix: DMatrix<f64>,
    rho: f64,
    v: DVector<f64>,
    u: DVector<f64>,
    zeta: DVector<f64>,
    u_hat: DVector<f64>,
    zeta_hat: DVector<f64>,
    s: DVector<f64>,
    tau: f64,
    e: f64,
}

impl Note {
    fn new(scene: &Scene<f64, N, D, C>, f: &SVector<f64, N>, rho: f64) -> Self {
        let contacts = scene.contacts();
        let h = DMatrix::from_fn(ROWS, N, |i, j| contacts[i / D].jacobian[(i % D, j)]);
        let mass = DMatrix::from_fn(N, N, |i, j| scene.mass()[(i, j)]);
        let cone = |mu| (mu, FrictionCone::new(mu).expect("mu is valid"));
        Self {
            matrix: mass + h.transpose() * &h * rho,
            w: DVector::from_fn(ROWS, |i, _| contacts[i / D].offset[i % D]),
            f: DVector::from_column_slice(f.as_slice()),
            cones: contacts.iter().map(|contact| cone(contact.mu)).collect(),
            rho,
            h,
            v: DVector::zeros(N),
            u: DVector::zeros(ROWS),
            zeta: DVector::zeros(ROWS),
            u_hat: DVector::zeros(ROWS),
            zeta_hat: DVector::zeros(ROWS),
            s: DVector::zeros(C),
            tau: 1.0,
            e: f64::INFINITY,
        }
    }

    /// Goes on from the kernel's iterates: what rounding adds up to is no statement of this test.
    fn start_from(&mut self, iterates: &[Iterate<f64, D>; C]) {
        self.u = stack(iterates.map(|iterate| iterate.u));
        self.zeta = stack(iterates.map(|iterate| iterate.zeta));
        self.u_hat = stack(iterates.map(|iterate| iterate.u_hat));
        self.zeta_hat = stack(iterates.map(|iterate| iterate.zeta_hat));
    }

    fn step(&mut self, acceleration: Acceleration, model: Model) {
        let mut b = self.w.clone();
        for (i, (mu, _)) in self.cones.iter().enumerate() {
            b[i * D] += mu * self.s[i];
        }
        // 2
        let target = &self.u_hat - &b - &self.zeta_hat;
        let rhs = self.h.transpose() * target * self.rho - &self.f;
        self.v = self.matrix.clone().lu().solve(&rhs).expect("A is regular");
        // 3
        let z = &self.h * &self.v + &self.zeta_hat + &b;
        let mut u = z.clone();
        for (i, (_, cone)) in self.cones.iter().enumerate() {
            let block = SVector::<f64, D>::from_fn(|row, _| z[i * D + row]);
            u.rows_mut(i * D, D).copy_from(&cone.dual().nearest(&block));
        }
        // 4
        let zeta = &z - &u;
        // 5-8; 5-14
        let e = self.rho * ((&zeta - &self.zeta_hat).norm_squared() + (&u - &self.u_hat).norm_squared());
        let extrapolate = match acceleration {
            Acceleration::Plain => false,
            Acceleration::Nesterov => true,
            Acceleration::Restart => e < 0.999 * self.e,
        };
        let (next, c) = if extrapolate {
            let next = f64::midpoint(1.0, (1.0 + 4.0 * self.tau * self.tau).sqrt());
            (next, (self.tau - 1.0) / next)
        } else {
            (1.0, 0.0)
        };
        self.u_hat = &u + (&u - &self.u) * c;
        self.zeta_hat = &zeta + (&zeta - &self.zeta) * c;
        (self.tau, self.e, self.u, self.zeta) = (next, e, u, zeta);
        if model == Model::Coulomb {
            for i in 0..C {
                self.s[i] = self.u.rows(i * D + 1, D - 1).norm();
            }
        }
    }
}

/// Scenes with a dense mass matrix, moving surfaces and gaps; solvable or not.
fn scenes() -> impl Strategy<Value = (Scene<f64, N, D, C>, SVector<f64, N>)> {
    let numbers = |count| vec(-1.0..1.0, count);
    let contacts = vec((numbers(D * N), numbers(D), 0.0..1.5), C);
    (numbers(N * N), contacts, numbers(N)).prop_map(|(root, contacts, f)| {
        let root = SMatrix::<f64, N, N>::from_iterator(root);
        let mut scene = Scene::new();
        let mass = root * root.transpose() + SMatrix::identity();
        scene.set_mass(&mass).expect("M is symmetric");
        for (h, w, mu) in contacts {
            let contact = Contact {
                jacobian: SMatrix::from_iterator(h),
                offset: SVector::from_iterator(w) * 0.1,
                mu,
                key: 0,
            };
            scene.push(&contact).expect("the contact is valid");
        }
        (scene, SVector::from_iterator(f))
    })
}

/// The blocks of all contacts in one vector.
fn stack(blocks: [SVector<f64, D>; C]) -> DVector<f64> {
    DVector::from_iterator(ROWS, blocks.into_iter().flat_map(<[f64; D]>::from))
}

fn follows(
    (scene, f): &(Scene<f64, N, D, C>, SVector<f64, N>),
    acceleration: Acceleration,
) -> Result<(), TestCaseError> {
    follows_for(scene, f, acceleration, Model::Coulomb)?;
    follows_for(scene, f, acceleration, Model::ConvexRelaxation)
}

fn follows_for(
    scene: &Scene<f64, N, D, C>,
    f: &SVector<f64, N>,
    acceleration: Acceleration,
    model: Model,
) -> Result<(), TestCaseError> {
    let factor = AdmmFactor::new(scene).expect("M is positive definite");
    let free = -f;
    let mut problem =
        Problem::new(scene, factor.factor(), &free, &Settings { model, ..Settings::default() }, Age::New);
    problem.fill(false);
    let (sets, resolvent) = (problem.sets.contacts(), factor.resolvent());
    let start = Iterate::at(SVector::zeros(), SVector::zeros(), factor.penalty());
    let mut iterates = [start; C];
    let mut extrapolation = Extrapolation::none(acceleration);
    extrapolation.start();
    let mut note = Note::new(scene, f, factor.penalty());
    for k in 0..200 {
        note.start_from(&iterates);
        iterate(sets, resolvent, &mut iterates, &mut extrapolation, SlipUpdate::EveryIteration);
        note.step(acceleration, model);
        let pairs = [
            ("u", iterates.map(|iterate| iterate.u), &note.u),
            ("zeta", iterates.map(|iterate| iterate.zeta), &note.zeta),
            ("u_hat", iterates.map(|iterate| iterate.u_hat), &note.u_hat),
            ("zeta_hat", iterates.map(|iterate| iterate.zeta_hat), &note.zeta_hat),
        ];
        // All come from one vector of this size.
        let size = note.u.norm() + note.zeta.norm();
        for (name, ours, theirs) in pairs {
            let distance = (stack(ours) - theirs).norm();
            prop_assert!(distance <= 1e-12 * size, "{name} at {k}: {distance:e} of {size:e}");
        }
        // Where nothing moves any more, rounding decides whether e_k has decreased.
        if note.e <= note.rho * (1e-8 * size).powi(2) {
            break;
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn plain_iterates_are_those_of_the_note(scene in scenes()) {
        follows(&scene, Acceleration::Plain)?;
    }

    #[test]
    fn fast_iterates_are_those_of_algorithm_1(scene in scenes()) {
        follows(&scene, Acceleration::Nesterov)?;
    }

    #[test]
    fn restarted_iterates_are_those_of_algorithm_2(scene in scenes()) {
        follows(&scene, Acceleration::Restart)?;
    }

    /// `B = (I + rho W)⁻¹ = I - rho H A⁻¹ Hᵀ` with `A = M + rho HᵀH`, for any `rho`.
    #[test]
    fn the_resolvent_is_the_inverse_in_contact_space(
        (scene, f) in scenes(),
        exponent in -6.0..6.0,
    ) {
        let rho = 10_f64.powf(exponent);
        let mut factor = AdmmFactor::new(&scene).expect("M is positive definite");
        factor.set_penalty(rho).expect("rho is usable");
        let resolvent = factor.resolvent();
        let note = Note::new(&scene, &f, rho);
        let solved = note.matrix.lu().solve(&note.h.transpose()).expect("A is regular");
        let b = DMatrix::identity(ROWS, ROWS) - note.h * solved * rho;
        for column in 0..ROWS {
            let (mut unit, mut product) = ([[0.0; D]; C], [[0.0; D]; C]);
            unit[column / D][column % D] = 1.0;
            resolvent.times(&unit, &mut product);
            for (row, entry) in product.as_flattened().iter().enumerate() {
                let difference = entry - b[(row, column)];
                prop_assert!(difference.abs() < 1e-9, "{row} {column}: {difference:e}");
            }
        }
    }
}
