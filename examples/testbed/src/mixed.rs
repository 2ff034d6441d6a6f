//! Scenes with joint rows, compliance and shapes of friction, and their solve.

use crate::kernel::{Answer, rounded_settings};
use crate::measure;
use nalgebra::{DMatrix, SMatrix, SVector};
use serde::Deserialize;
use std::time::Instant;
use stiction::{Contact, Error, JointRow, Kernel, Real, RowLaw, Scene, Settings, Solution, Status, Surface};

/// A scene as it stands in a file: contacts and joint rows.
#[derive(Clone, Debug)]
pub struct MixedFile {
    pub name: String,
    pub n_dof: usize,
    pub n_contacts: usize,
    pub dim: usize,
    /// h, if the file says it (s).
    pub time_step: Option<f64>,
    pub mass: Vec<Vec<f64>>,
    pub h: Vec<Vec<f64>>,
    pub f: Vec<f64>,
    pub w: Vec<f64>,
    pub mu: Vec<Friction>,
    pub joints: Vec<Joint>,
    /// `[R_n, R_t]` a contact.
    pub compliance: Vec<[f64; 2]>,
    /// Keys of the contacts and then of the joint rows; their places in the file if there are none.
    pub keys: Vec<u32>,
    /// Are limits rows of the scene, or given to the solve?
    pub limits_inside: bool,
}

/// One coefficient, or one a row behind the normal.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum Friction {
    Isotropic(f64),
    Rows(Vec<f64>),
}

/// A joint row.
#[derive(Clone, Debug, Deserialize)]
pub struct Joint {
    pub kind: String,
    pub row: Vec<f64>,
    pub offset: f64,
    pub lower: Option<f64>,
    pub upper: Option<f64>,
    #[serde(default)]
    pub compliance: f64,
}

/// What a solve took.
#[derive(Clone, Copy, Debug)]
pub struct Times {
    pub prepare_ns: f64,
    pub solve_ns: f64,
}

impl MixedFile {
    /// The scene as a number type holds it.
    #[must_use]
    pub fn rounded<T: Real>(&self) -> Self {
        let round = |x: &f64| measure::double(&T::literal(*x));
        let all = |x: &[f64]| x.iter().map(round).collect::<Vec<_>>();
        let rows = |x: &[Vec<f64>]| x.iter().map(|row| all(row)).collect();
        let friction = |mu: &Friction| match mu {
            Friction::Isotropic(mu) => Friction::Isotropic(round(mu)),
            Friction::Rows(mu) => Friction::Rows(all(mu)),
        };
        let joint = |joint: &Joint| Joint {
            row: all(&joint.row),
            offset: round(&joint.offset),
            lower: joint.lower.as_ref().map(round),
            upper: joint.upper.as_ref().map(round),
            compliance: round(&joint.compliance),
            ..joint.clone()
        };
        Self {
            mass: rows(&self.mass),
            h: rows(&self.h),
            f: all(&self.f),
            w: all(&self.w),
            mu: self.mu.iter().map(friction).collect(),
            joints: self.joints.iter().map(joint).collect(),
            compliance: self.compliance.iter().map(|soft| [round(&soft[0]), round(&soft[1])]).collect(),
            ..self.clone()
        }
    }

    /// Does it have contacts of a round cone alone, and nothing soft?
    pub fn has_contacts_alone(&self) -> bool {
        let is_round = |mu: &Friction| matches!(mu, Friction::Isotropic(_));
        self.dim <= 3 && self.joints.is_empty() && self.compliance.is_empty() && self.mu.iter().all(is_round)
    }

    /// The key of a contact or a joint row, counted on.
    fn key(&self, place: usize) -> u32 {
        let own = place.checked_sub(self.n_contacts).unwrap_or(place);
        let default = u32::try_from(own).unwrap_or(u32::MAX);
        self.keys.get(place).copied().unwrap_or(default)
    }

    /// Fills a scene in the kernel's types, over as many of `N` velocities as the file has. Limits that are not to be inside are
    /// returned.
    pub fn fill<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
        &self,
        scene: &mut Scene<T, N, D, C, R, S>,
    ) -> Result<Vec<JointRow<T, N>>, Error> {
        scene.set_velocities(self.n_dof)?;
        scene.set_mass(&SMatrix::from_fn(|i, j| {
            let entry = self.mass.get(i).and_then(|row| row.get(j));
            T::literal(*entry.unwrap_or(&0.0))
        }))?;
        for (i, mu) in self.mu.iter().enumerate() {
            let row = |k: usize| &self.h[i * D + k];
            let contact = Contact {
                jacobian: SMatrix::from_fn(|k, j| T::literal(*row(k).get(j).unwrap_or(&0.0))),
                offset: SVector::from_fn(|k, _| T::literal(self.w[i * D + k])),
                mu: T::ZERO,
                key: self.key(i),
            };
            let compliance = self.compliance.get(i).copied().unwrap_or_default();
            scene.push_on(&contact, &surface(mu, compliance.map(T::literal)))?;
        }
        let mut limits = Vec::new();
        for (joint, place) in self.joints.iter().zip(self.n_contacts..) {
            let row = JointRow {
                row: SVector::from_fn(|j, _| T::literal(*joint.row.get(j).unwrap_or(&0.0))),
                offset: T::literal(joint.offset),
                law: joint.law().unwrap_or(RowLaw::Equality),
                compliance: T::literal(joint.compliance),
                key: self.key(place),
            };
            if row.law == RowLaw::Limit && !self.limits_inside {
                limits.push(row);
            } else {
                scene.push_row(&row)?;
            }
        }
        Ok(limits)
    }

    /// The free impulse `-f` in the kernel's type, and zeros behind it.
    pub fn free_impulse<T: Real, const N: usize>(&self) -> SVector<T, N> {
        SVector::from_fn(|i, _| T::literal(-self.f.get(i).copied().unwrap_or(0.0)))
    }

    /// `M` as a matrix.
    pub fn mass(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.n_dof, self.n_dof, |i, j| self.mass[i][j])
    }
}

impl Joint {
    pub(crate) fn law<T: Real>(&self) -> Result<RowLaw<T>, String> {
        match (self.kind.as_str(), self.lower, self.upper) {
            ("limit", ..) => Ok(RowLaw::Limit),
            ("equality", ..) => Ok(RowLaw::Equality),
            ("box", Some(lower), Some(upper)) => {
                Ok(RowLaw::Box { lower: T::literal(lower), upper: T::literal(upper) })
            }
            ("box", ..) => Err("joints: a box has lower and upper bounds".into()),
            (kind, ..) => Err(format!("joints: kind {kind:?} is not limit, equality or box")),
        }
    }
}

/// Of one coefficient, its cone is round in all rows.
fn surface<T: Real>(mu: &Friction, compliance: [T; 2]) -> Surface<T> {
    let row = |k: usize| {
        T::literal(match mu {
            Friction::Isotropic(mu) => *mu,
            Friction::Rows(mu) => mu.get(k).copied().unwrap_or(0.0),
        })
    };
    Surface { friction: [row(0), row(1)], spin: row(2), roll: [row(3), row(4)], compliance }
}

/// The kernel's answer to a scene in the smallest compiled size that holds it, solved so many times from nothing.
pub fn solve<T: Real>(
    file: &MixedFile,
    settings: &Settings<f64>,
    repeat: u32,
) -> Result<(Answer, Times), String> {
    let said = |error: Error| error.to_string();
    match (file.n_dof, file.dim, file.n_contacts, file.joints.len()) {
        (..=30, 2, ..=12, ..=36) => solve_in::<T, 30, 2, 12, 36>(file, settings, repeat).map_err(said),
        (..=30, 3, ..=12, ..=36) => solve_in::<T, 30, 3, 12, 36>(file, settings, repeat).map_err(said),
        (..=30, 4, ..=12, ..=36) => solve_in::<T, 30, 4, 12, 36>(file, settings, repeat).map_err(said),
        (..=30, 6, ..=12, ..=36) => solve_in::<T, 30, 6, 12, 36>(file, settings, repeat).map_err(said),
        (dofs, dim, contacts, rows) => {
            Err(format!("{dofs} dofs, dim {dim}, {contacts} contacts and {rows} joint rows: too many"))
        }
    }
}

/// The kernel's answers to scenes one after the other, each with a warm start from the last.
pub fn solve_all<T: Real>(files: &[MixedFile], settings: &Settings<f64>) -> Vec<Result<Answer, String>> {
    // The sizes of [`solve`]: no other is compiled.
    const N: usize = 30;
    const C: usize = 12;
    const R: usize = 36;
    match files.first().map_or(3, |file| file.dim) {
        2 => solve_all_in::<T, N, 2, C, R>(files, settings),
        3 => solve_all_in::<T, N, 3, C, R>(files, settings),
        4 => solve_all_in::<T, N, 4, C, R>(files, settings),
        _ => solve_all_in::<T, N, 6, C, R>(files, settings),
    }
}

fn solve_all_in<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    files: &[MixedFile],
    settings: &Settings<f64>,
) -> Vec<Result<Answer, String>> {
    let mut kernel = Box::new(Kernel::<T, N, D, C, R, C>::new());
    let settings = rounded_settings(settings);
    let mut solve = |file: &MixedFile| {
        kernel.scene_mut().clear();
        let limits = file.fill(kernel.scene_mut())?;
        let push = file.free_impulse();
        kernel.solve_with_limits(&limits, &push, &settings)?;
        Ok(answer(file, kernel.solution()))
    };
    let said = |error: Error| error.to_string();
    files.iter().map(|file| solve(file).map_err(said)).collect()
}

/// [`solve`] in this size.
pub fn solve_in<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    file: &MixedFile,
    settings: &Settings<f64>,
    repeat: u32,
) -> Result<(Answer, Times), Error> {
    let mut kernel = Box::new(Kernel::<T, N, D, C, R, C>::new());
    let limits = file.fill(kernel.scene_mut())?;
    let push = file.free_impulse();
    let settings = rounded_settings(settings);
    let mut times = Times { prepare_ns: f64::INFINITY, solve_ns: f64::INFINITY };
    for _ in 0..repeat.max(1) {
        // So that there is something to prepare.
        let mass = *kernel.scene().mass();
        kernel.scene_mut().set_mass(&(mass * T::literal(2.0)))?;
        kernel.prepare()?;
        kernel.scene_mut().set_mass(&mass)?;
        kernel.solver_mut().reset();
        let start = Instant::now();
        kernel.prepare()?;
        times.prepare_ns = times.prepare_ns.min(start.elapsed().as_secs_f64() * 1e9);
        let start = Instant::now();
        kernel.solve_with_limits(&limits, &push, &settings)?;
        times.solve_ns = times.solve_ns.min(start.elapsed().as_secs_f64() * 1e9);
    }
    Ok((answer(file, kernel.solution()), times))
}

/// The solution in f64, without padding.
fn answer<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    file: &MixedFile,
    solution: &Solution<T, N, D, C, R>,
) -> Answer {
    let double = |x: &T| measure::double(x);
    // A limit that was left out has no impulse.
    let rows = || {
        let places = (file.n_contacts..).take(file.joints.len());
        places.map(|place| {
            let row = solution.rows.iter().position(|row| row.key == file.key(place));
            row.map(|row| (solution.rows[row], solution.row_certificate.get(row)))
        })
    };
    let contacts = || solution.contacts.iter().take(file.n_contacts);
    let v = solution.velocity.iter().take(file.n_dof);
    let proved = solution.status == Status::Infeasible;
    let certificate = solution.certificate.iter().take(file.n_contacts);
    Answer {
        status: solution.status,
        work: solution.work,
        error: double(&solution.error),
        v: v.map(double).collect(),
        r: contacts().flat_map(|contact| contact.impulse.iter().map(double)).collect(),
        modes: contacts().map(|contact| contact.mode).collect(),
        certificate: certificate.map(|d| double(&d[0])).collect(),
        lambda: rows().map(|row| row.map_or(0.0, |(row, _)| double(&row.impulse))).collect(),
        certificate_lambda: rows()
            .filter(|_| proved)
            .map(|row| row.and_then(|(_, d)| d).map_or(0.0, double))
            .collect(),
    }
}
