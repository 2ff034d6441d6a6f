//! Scenes with joint rows: what goes in, and what a stranger says of their solutions.

use super::cases::is_tame;
use super::kind::{Kind, at, contact, double, vector};
use super::steps::{Law, Step};
use nalgebra::SVector;
use stiction::{
    JointRow, Kernel, Mixed, Model, Real, RowIndex, RowLaw, Scene, Settings, Solution, Status,
    Surface,
};
use testbed::mixed::{Friction, Joint, MixedFile};
use testbed::mixed_measure;

/// What went into a scene and cannot be read there.
#[derive(Default)]
pub(super) struct Record {
    /// Slot, shares of the friction coefficient, compliance.
    pub(super) contacts: Vec<(usize, Option<Vec<f64>>, [f64; 2])>,
    /// Place, law, compliance.
    pub(super) rows: Vec<(RowIndex, Law, f64)>,
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
    fn push_on<T: Real, const N: usize, const D: usize, const C: usize>(
        &mut self,
        scene: &mut Scene<T, N, D, C, Mixed>,
        (x, surface, key): (&[f64], &[f64], u32),
    ) {
        let s: Vec<T> = surface.iter().map(|x| T::literal(*x)).collect();
        let surface = Surface {
            friction: [s[0], s[1]],
            spin: s[2],
            roll: [s[3], s[4]],
            compliance: [s[5], s[6]],
        };
        if let Ok(slot) = scene.push_on(&contact(x, 0.0, key), &surface) {
            let reference = scene.contacts()[slot].mu;
            let share = |mu: &T| {
                if reference > T::ZERO {
                    double(*mu / reference)
                } else {
                    0.0
                }
            };
            let shares = s[..D - 1].iter().map(share);
            let soft = surface.compliance.map(double);
            self.contacts.push((slot, Some(shares.collect()), soft));
        }
    }

    fn push_row<T: Real, const N: usize, const D: usize, const C: usize>(
        &mut self,
        scene: &mut Scene<T, N, D, C, Mixed>,
        (x, bounds, compliance, key): (&[f64], Law, f64, u32),
    ) {
        let row = JointRow {
            row: vector::<T, N>(x),
            offset: at(x, N),
            law: law(bounds),
            compliance: T::literal(compliance),
            key,
        };
        if let Ok(index) = scene.push_row(&row) {
            self.rows.push((index, bounds, double(row.compliance)));
        }
    }

    /// All of a scene, contacts first.
    pub(super) fn file<T: Real, const N: usize, const D: usize, const C: usize>(
        &self,
        scene: &Scene<T, N, D, C, Mixed>,
        push: &SVector<T, N>,
    ) -> MixedFile {
        let mut file = MixedFile {
            name: String::new(),
            n_dof: N,
            n_contacts: self.contacts.len(),
            dim: D,
            mass: Vec::new(),
            h: Vec::new(),
            f: push.iter().map(|x| -double(*x)).collect(),
            w: Vec::new(),
            mu: Vec::new(),
            joints: Vec::new(),
            compliance: Vec::new(),
            keys: Vec::new(),
            limits_inside: true,
        };
        let mass = scene.mass().row_iter();
        file.mass = mass
            .map(|row| row.iter().map(|x| double(*x)).collect())
            .collect();
        let row = |(slot, k): (usize, usize)| -> Vec<f64> {
            let jacobian = &scene.contacts()[slot].jacobian;
            jacobian.row(k).iter().map(|x| double(*x)).collect()
        };
        for (slot, shares, soft) in &self.contacts {
            let contact = &scene.contacts()[*slot];
            file.h.extend((0..D).map(|k| row((*slot, k))));
            file.w.extend(contact.offset.iter().map(|x| double(*x)));
            let mu = double(contact.mu);
            file.mu
                .push(shares.as_ref().map_or(Friction::Isotropic(mu), |shares| {
                    Friction::Rows(shares.iter().map(|share| share * mu).collect())
                }));
            file.compliance.push(*soft);
        }
        for (index, (law, lower, upper), compliance) in &self.rows {
            file.joints.push(Joint {
                kind: ["limit", "equality", "box"][usize::from(*law)].to_owned(),
                row: row((index.slot, index.row)),
                offset: double(scene.contacts()[index.slot].offset[index.row]),
                lower: Some(double(T::literal(*lower))),
                upper: Some(double(T::literal(*upper))),
                compliance: *compliance,
            });
        }
        file
    }
}

pub(super) fn is_measurable<T: Real>(file: &MixedFile) -> bool {
    let joints = file.joints.iter();
    let own = joints
        .clone()
        .flat_map(|joint| [&joint.offset, &joint.compliance]);
    let bounds = joints
        .clone()
        .flat_map(|joint| joint.lower.iter().chain(&joint.upper));
    let rows = joints
        .flat_map(|joint| &joint.row)
        .chain(file.h.iter().flatten());
    let matrices = rows.chain(file.mass.iter().flatten());
    let mus = file.mu.iter().flat_map(|mu| match mu {
        Friction::Isotropic(mu) => vec![mu],
        Friction::Rows(mus) => mus.iter().collect(),
    });
    let vectors = file
        .f
        .iter()
        .chain(&file.w)
        .chain(file.compliance.iter().flatten());
    let all = matrices.chain(vectors).chain(own).chain(bounds).chain(mus);
    is_tame::<T>(all) && file.mass().cholesky().is_some()
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Kind<T, N, D, C> for Mixed {
    type Beside = Record;

    fn kernel() -> Kernel<T, N, D, C, Mixed> {
        Kernel::mixed()
    }

    fn call(record: &mut Record, scene: &mut Scene<T, N, D, C, Mixed>, step: &Step) {
        match step {
            Step::Push(x, mu, key) => {
                if let Ok(slot) = scene.push(&contact(x, *mu, *key)) {
                    record.contacts.push((slot, None, [0.0; 2]));
                }
            }
            Step::PushOn(x, surface, key) => record.push_on(scene, (x, surface, *key)),
            Step::PushRow(x, law, soft, key) => record.push_row(scene, (x, *law, *soft, *key)),
            Step::RowLaw(i, bounds) => {
                let nowhere = RowIndex { slot: *i, row: *i };
                let place = record.rows.get_mut(*i);
                let index = place.as_ref().map_or(nowhere, |(index, ..)| *index);
                let changed = scene.set_row_law(index, law(*bounds));
                if let (Ok(()), Some((_, law, _))) = (changed, place) {
                    *law = *bounds;
                }
            }
            Step::RowOffset(i, offset) => {
                let nowhere = RowIndex { slot: *i, row: *i };
                let index = record.rows.get(*i).map_or(nowhere, |(index, ..)| *index);
                let _ = scene.set_row_offset(index, T::literal(*offset));
            }
            Step::Clear => *record = Record::default(),
            _ => {}
        }
    }

    fn check(_: &mut Record, _: &Scene<T, N, D, C, Mixed>, _: &SVector<T, N>, _: &Settings<T>) {}

    fn judge(
        record: &Record,
        scene: &Scene<T, N, D, C, Mixed>,
        push: &SVector<T, N>,
        solution: &Solution<T, N, D, C, Mixed>,
        model: Model,
    ) -> Option<(f64, bool)> {
        let file = record.file(scene, push);
        if model == Model::ConvexRelaxation || !is_measurable::<T>(&file) {
            return None;
        }
        let v: Vec<f64> = solution.velocity.iter().map(|x| double(*x)).collect();
        let slots = record.contacts.iter().map(|(slot, ..)| *slot);
        let r = slots
            .clone()
            .flat_map(|slot| solution.contacts[slot].impulse.iter());
        let r: Vec<f64> = r.map(|x| double(*x)).collect();
        let rows = || {
            record
                .rows
                .iter()
                .filter_map(|(index, ..)| solution.row(*index))
        };
        let lambda: Vec<f64> = rows().map(|row| double(row.impulse)).collect();
        let mut proof = true;
        if solution.status == Status::Infeasible && double(T::EPSILON) < 1e-10 {
            let normals: Vec<f64> = slots
                .map(|slot| double(solution.certificate[slot]))
                .collect();
            let joints: Vec<f64> = rows().map(|row| double(row.certificate)).collect();
            proof = mixed_measure::proves(&file, &normals, &joints);
        }
        Some((mixed_measure::error(&file, &v, &r, &lambda), proof))
    }
}
