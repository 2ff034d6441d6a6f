//! The scene of the kernel in Rust, for a stranger to judge.

use crate::c::{D, N, R, Real, S};
use crate::cases::is_tame;
use nalgebra::SVector;
use stiction::{RowLaw, Scene, Surface};
use testbed::mixed::{Friction, Joint, MixedFile};

/// What went into a scene and cannot be read there: of each contact with a surface the shares of its coefficients, and its
/// compliance.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surfaces(Vec<Option<(Vec<f64>, [f64; 2])>>);

fn double(x: Real) -> f64 {
    nalgebra::try_convert(x).unwrap_or(f64::NAN)
}

fn all<'a>(numbers: impl IntoIterator<Item = &'a Real>) -> Vec<f64> {
    numbers.into_iter().map(|x| double(*x)).collect()
}

impl Surfaces {
    /// A contact was added, which now has this friction coefficient.
    pub(crate) fn push(&mut self, surface: Option<(&Surface<Real>, Real)>) {
        let own = surface.map(|(surface, reference)| {
            let ([x, y], [about_x, about_y]) = (surface.friction, surface.roll);
            let share = |mu: &Real| {
                if reference > 0.0 { double(*mu / reference) } else { 0.0 }
            };
            let coefficients = [x, y, surface.spin, about_x, about_y];
            let shares = coefficients[..D - 1].iter().map(share).collect();
            (shares, surface.compliance.map(double))
        });
        self.0.push(own);
    }

    pub(crate) fn remove(&mut self, place: usize) {
        self.0.remove(place);
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// All of a scene.
    pub(crate) fn file<const C: usize>(
        &self,
        scene: &Scene<Real, N, D, C, R, S>,
        push: &SVector<Real, N>,
    ) -> MixedFile {
        let n = scene.velocities();
        let used = |row: &mut dyn Iterator<Item = &Real>| row.take(n).map(|x| double(*x)).collect::<Vec<_>>();
        let contacts = || scene.contacts().iter();
        assert_eq!(contacts().len(), self.0.len());
        let own = || contacts().zip(&self.0);
        let joints = scene.rows().iter().map(|row| {
            let (kind, bounds) = match row.law {
                RowLaw::Limit => ("limit", None),
                RowLaw::Equality => ("equality", None),
                RowLaw::Box { lower, upper } => ("box", Some([lower, upper].map(double))),
            };
            Joint {
                kind: kind.to_owned(),
                row: used(&mut row.row.iter()),
                offset: double(row.offset),
                lower: bounds.map(|[lower, _]| lower),
                upper: bounds.map(|[_, upper]| upper),
                compliance: double(row.compliance),
            }
        });
        MixedFile {
            name: String::new(),
            n_dof: n,
            n_contacts: scene.contacts().len(),
            dim: D,
            mass: scene.mass().row_iter().take(n).map(|row| used(&mut row.iter())).collect(),
            h: contacts()
                .flat_map(|contact| (0..D).map(|k| used(&mut contact.jacobian.row(k).iter())))
                .collect(),
            f: push.iter().take(n).map(|x| -double(*x)).collect(),
            w: contacts().flat_map(|contact| all(&contact.offset)).collect(),
            mu: own()
                .map(|(contact, surface)| {
                    let mu = double(contact.mu);
                    surface.as_ref().map_or(Friction::Isotropic(mu), |(shares, _)| {
                        Friction::Rows(shares.iter().map(|share| share * mu).collect())
                    })
                })
                .collect(),
            joints: joints.collect(),
            compliance: own()
                .map(|(_, surface)| surface.as_ref().map_or([0.0; 2], |(_, soft)| *soft))
                .collect(),
            keys: Vec::new(),
            time_step: None,
            limits_inside: true,
        }
    }
}

/// Can a stranger tell the error?
pub(crate) fn is_measurable(file: &MixedFile) -> bool {
    let matrices = file.mass.iter().chain(&file.h).flatten();
    let vectors = file.f.iter().chain(&file.w);
    let surfaces = file.compliance.iter().flatten();
    let mus = file.mu.iter().flat_map(|mu| match mu {
        Friction::Isotropic(mu) => vec![mu],
        Friction::Rows(mus) => mus.iter().collect(),
    });
    let joints = file.joints.iter().flat_map(|joint| {
        let own = [&joint.offset, &joint.compliance];
        let bounds = joint.lower.iter().chain(&joint.upper);
        joint.row.iter().chain(own).chain(bounds)
    });
    let all = matrices.chain(vectors).chain(surfaces);
    is_tame::<Real>(all.chain(mus).chain(joints)) && file.mass().cholesky().is_some()
}
