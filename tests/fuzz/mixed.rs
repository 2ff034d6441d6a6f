//! Scenes with joint rows: what goes in, and what a stranger says of their solutions.

use super::cases::is_tame;
use super::kind::{Kind, at, contact, double, vector};
use super::steps::{Law, Step};
use nalgebra::SVector;
use stiction::{JointRow, Model, Real, RowLaw, RowSolution, Scene, Solution, Status, Surface};
use testbed::mixed::{Friction, Joint, MixedFile};
use testbed::mixed_measure;

/// Contacts of three rows, on surfaces or not, and joint rows.
pub(super) struct Mixed;

/// Contacts that spin and roll, and joint rows.
pub(super) struct Rolling;

/// What went into a scene, in its order.
#[derive(Default)]
pub(super) struct Record {
    /// Shares of the friction coefficient, compliance.
    pub(super) contacts: Vec<(Option<Vec<f64>>, [f64; 2])>,
    /// Law, compliance.
    pub(super) rows: Vec<(Law, f64)>,
}

fn law<T: Real>((law, lower, upper): Law) -> RowLaw<T> {
    let (lower, upper) = (T::literal(lower), T::literal(upper));
    match law {
        0 => RowLaw::Limit,
        1 => RowLaw::Equality,
        _ => RowLaw::Box { lower, upper },
    }
}

impl Record {
    fn push_on<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
        &mut self,
        scene: &mut Scene<T, N, D, C, R, S>,
        (x, surface, key): (&[f64], &[f64], u32),
    ) {
        let s: Vec<T> = surface.iter().map(|x| T::literal(*x)).collect();
        let surface =
            Surface { friction: [s[0], s[1]], spin: s[2], roll: [s[3], s[4]], compliance: [s[5], s[6]] };
        if let Ok(place) = scene.push_on(&contact(x, 0.0, key), &surface) {
            assert_eq!(place, self.contacts.len());
            let reference = scene.contacts()[place].mu;
            let share = |mu: &T| {
                if reference > T::ZERO { double(*mu / reference) } else { 0.0 }
            };
            let shares = s[..D - 1].iter().map(share);
            let soft = surface.compliance.map(double);
            self.contacts.push((Some(shares.collect()), soft));
        }
    }

    fn push_row<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
        &mut self,
        scene: &mut Scene<T, N, D, C, R, S>,
        (x, bounds, compliance, key): (&[f64], Law, f64, u32),
    ) {
        let row = JointRow {
            row: vector::<T, N>(x),
            offset: at(x, N),
            law: law(bounds),
            compliance: T::literal(compliance),
            key,
        };
        if let Ok(place) = scene.push_row(&row) {
            assert_eq!(place, self.rows.len());
            self.rows.push((bounds, double(row.compliance)));
        }
    }

    /// All of a scene, contacts first.
    pub(super) fn file<
        T: Real,
        const N: usize,
        const D: usize,
        const C: usize,
        const R: usize,
        const S: usize,
    >(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        push: &SVector<T, N>,
    ) -> MixedFile {
        let counts = (scene.contacts().len(), scene.rows().len());
        assert_eq!(counts, (self.contacts.len(), self.rows.len()));
        let n = scene.velocities();
        let mut file = MixedFile {
            name: String::new(),
            n_dof: n,
            n_contacts: self.contacts.len(),
            dim: D,
            mass: Vec::new(),
            h: Vec::new(),
            f: push.iter().take(n).map(|x| -double(*x)).collect(),
            w: Vec::new(),
            mu: Vec::new(),
            joints: Vec::new(),
            compliance: Vec::new(),
            keys: Vec::new(),
            time_step: None,
            limits_inside: true,
        };
        let mass = scene.mass().row_iter().take(n);
        file.mass = mass.map(|row| row.iter().take(n).map(|x| double(*x)).collect()).collect();
        for ((shares, soft), contact) in self.contacts.iter().zip(scene.contacts()) {
            let rows = contact.jacobian.row_iter();
            file.h.extend(rows.map(|row| row.iter().take(n).map(|x| double(*x)).collect::<Vec<_>>()));
            file.w.extend(contact.offset.iter().map(|x| double(*x)));
            let mu = double(contact.mu);
            file.mu.push(shares.as_ref().map_or(Friction::Isotropic(mu), |shares| {
                Friction::Rows(shares.iter().map(|share| share * mu).collect())
            }));
            file.compliance.push(*soft);
        }
        for (((law, lower, upper), compliance), row) in self.rows.iter().zip(scene.rows()) {
            file.joints.push(Joint {
                kind: ["limit", "equality", "box"][usize::from(*law)].to_owned(),
                row: row.row.iter().take(n).map(|x| double(*x)).collect(),
                offset: double(row.offset),
                lower: Some(double(T::literal(*lower))),
                upper: Some(double(T::literal(*upper))),
                compliance: *compliance,
            });
        }
        file
    }

    /// Calls but for those that push a contact without a surface.
    fn call<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
        &mut self,
        scene: &mut Scene<T, N, D, C, R, S>,
        step: &Step,
    ) {
        match step {
            Step::PushOn(x, surface, key) => self.push_on(scene, (x, surface, *key)),
            Step::PushRow(x, law, soft, key) => self.push_row(scene, (x, *law, *soft, *key)),
            Step::RowLaw(i, bounds) => {
                let changed = scene.set_row_law(*i, law(*bounds));
                assert!(changed.is_err() || *i < self.rows.len());
                if let (Ok(()), Some((law, _))) = (changed, self.rows.get_mut(*i)) {
                    *law = *bounds;
                }
            }
            Step::RowCompliance(i, soft) => {
                let soft = T::literal(*soft);
                let changed = scene.set_row_compliance(*i, soft);
                if let (Ok(()), Some((_, compliance))) = (changed, self.rows.get_mut(*i)) {
                    *compliance = double(soft);
                }
            }
            Step::RemoveContact(key) => {
                if let Some(place) = scene.contact_index(*key) {
                    self.contacts.remove(place);
                }
            }
            Step::RemoveRow(key) => {
                if let Some(place) = scene.row_index(*key) {
                    self.rows.remove(place);
                }
            }
            Step::Velocities(n, _) if (1..=N).contains(n) && *n != scene.velocities() => {
                *self = Self::default();
            }
            Step::Clear => *self = Self::default(),
            Step::ClearContacts => self.contacts.clear(),
            Step::ClearRows => self.rows.clear(),
            _ => {}
        }
    }

    /// The error of a solution, unless f64 cannot tell; and whether its proof is one.
    fn judge<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
        &self,
        scene: &Scene<T, N, D, C, R, S>,
        push: &SVector<T, N>,
        solution: &Solution<T, N, D, C, R>,
        model: Model,
    ) -> Option<(f64, bool)> {
        let file = self.file(scene, push);
        if model == Model::ConvexRelaxation || !is_measurable::<T>(&file) {
            return None;
        }
        let counts = (solution.contacts.len(), solution.rows.len());
        assert_eq!(counts, (file.n_contacts, file.joints.len()));
        let v: Vec<f64> = solution.velocity.iter().take(file.n_dof).map(|x| double(*x)).collect();
        let r = solution.contacts.iter();
        let r = r.flat_map(|contact| contact.impulse.iter());
        let r: Vec<f64> = r.map(|x| double(*x)).collect();
        let lambda = |row: &RowSolution<T>| double(row.impulse);
        let lambda: Vec<f64> = solution.rows.iter().map(lambda).collect();
        let mut proof = true;
        if solution.status == Status::Infeasible && double(T::EPSILON) < 1e-10 {
            let [normals, joints] = proof_of(solution);
            assert_eq!((normals.len(), joints.len()), counts);
            proof = mixed_measure::proves(&file, &normals, &joints);
        }
        Some((mixed_measure::error(&file, &v, &r, &lambda), proof))
    }
}

pub(super) fn is_measurable<T: Real>(file: &MixedFile) -> bool {
    let joints = file.joints.iter();
    let own = joints.clone().flat_map(|joint| [&joint.offset, &joint.compliance]);
    let bounds = joints.clone().flat_map(|joint| joint.lower.iter().chain(&joint.upper));
    let rows = joints.flat_map(|joint| &joint.row).chain(file.h.iter().flatten());
    let matrices = rows.chain(file.mass.iter().flatten());
    let mus = file.mu.iter().flat_map(|mu| match mu {
        Friction::Isotropic(mu) => vec![mu],
        Friction::Rows(mus) => mus.iter().collect(),
    });
    let vectors = file.f.iter().chain(&file.w).chain(file.compliance.iter().flatten());
    let all = matrices.chain(vectors).chain(own).chain(bounds).chain(mus);
    is_tame::<T>(all) && file.mass().cholesky().is_some()
}

impl<T: Real, const N: usize, const C: usize, const R: usize, const S: usize> Kind<T, N, 3, C, R, S>
    for Mixed
{
    type Beside = Record;

    fn call(record: &mut Record, scene: &mut Scene<T, N, 3, C, R, S>, step: &Step) {
        let Step::Push(x, mu, key) = step else {
            return record.call(scene, step);
        };
        if scene.push(&contact(x, *mu, *key)).is_ok() {
            record.contacts.push((None, [0.0; 2]));
        }
    }

    fn judge(
        record: &Record,
        scene: &Scene<T, N, 3, C, R, S>,
        push: &SVector<T, N>,
        solution: &Solution<T, N, 3, C, R>,
        model: Model,
    ) -> Option<(f64, bool)> {
        record.judge(scene, push, solution, model)
    }
}

impl<T: Real, const N: usize, const C: usize, const R: usize> Kind<T, N, 6, C, R, C> for Rolling {
    type Beside = Record;

    fn call(record: &mut Record, scene: &mut Scene<T, N, 6, C, R, C>, step: &Step) {
        let Step::Push(x, mu, key) = step else {
            return record.call(scene, step);
        };
        let all = [*mu, *mu, *mu, *mu, *mu, 0.0, 0.0];
        record.push_on(scene, (x, &all, *key));
    }

    fn judge(
        record: &Record,
        scene: &Scene<T, N, 6, C, R, C>,
        push: &SVector<T, N>,
        solution: &Solution<T, N, 6, C, R>,
        model: Model,
    ) -> Option<(f64, bool)> {
        record.judge(scene, push, solution, model)
    }
}

/// The certificates of contacts and of joint rows.
pub(super) fn proof_of<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    solution: &Solution<T, N, D, C, R>,
) -> [Vec<f64>; 2] {
    [
        solution.certificate.iter().map(|d| double(d[0])).collect(),
        solution.row_certificate.iter().map(|d| double(*d)).collect(),
    ]
}
