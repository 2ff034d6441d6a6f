//! Time of the default method against the number of contacts and of dofs, over random scenes.

use crate::contestant::{Contestant, Id, Kind};
use crate::library::Library;
use crate::measure::{self, Patience};
use crate::progress::Progress;
use crate::race::geometric_mean;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use stiction::Real;
use testbed::kernel::Compiled;
use testbed::scene_file::SceneFile;

pub(crate) const CONTACTS: [usize; 9] = [1, 2, 3, 4, 5, 6, 8, 10, 12];
pub(crate) const DOFS: [usize; 9] = [2, 3, 4, 6, 9, 12, 18, 24, 30];
/// Dofs where contacts are counted, and contacts where dofs are.
pub(crate) const FIXED_DOFS: usize = 18;
pub(crate) const FIXED_CONTACTS: usize = 4;
pub(crate) const TOLERANCE: f64 = 1e-4;

/// Geometric means over the scenes of one size, ns.
pub(crate) struct Size {
    /// Contacts or dofs.
    pub(crate) count: usize,
    pub(crate) prepare: f64,
    pub(crate) solve: f64,
}

/// Times over sizes for one number type.
pub(crate) struct Scaling {
    pub(crate) id: Id,
    pub(crate) contacts: Vec<Size>,
    pub(crate) dofs: Vec<Size>,
}

/// Slope of `ln y` over `ln x` by least squares.
pub(crate) fn exponent(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let logarithms = || points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let (x, y) = logarithms().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / count, b + y / count));
    let (above, below) = logarithms()
        .fold((0.0, 0.0), |(above, below), (u, v)| (above + (u - x) * (v - y), below + (u - x) * (u - x)));
    above / below
}

/// Dense Jacobians on a dense mass matrix, at rest (`w = 0`, so that there is a solution).
fn scene(random: &mut Pcg64, dofs: usize, contacts: usize) -> SceneFile {
    let mut number = || random.random_range(-1.0..1.0);
    let root = DMatrix::from_fn(dofs, dofs, |_, _| number());
    SceneFile {
        name: String::new(),
        n_dof: dofs,
        n_contacts: contacts,
        dim: 3,
        mass: &root * root.transpose() + DMatrix::identity(dofs, dofs),
        h: DMatrix::from_fn(3 * contacts, dofs, |_, _| number()),
        f: DVector::from_fn(dofs, |_, _| number()),
        w: DVector::zeros(3 * contacts),
        mu: vec![0.7; contacts],
        keys: vec![0; contacts],
    }
}

fn measure<T: Real, const N: usize, const C: usize>(
    contacts: usize,
    scenes: usize,
    patience: &Patience,
    id: Id,
) -> (f64, f64) {
    let mut random = Pcg64::seed_from_u64(1);
    let (mut prepare, mut solve) = (Vec::new(), Vec::new());
    for _ in 0..scenes {
        let scene = scene(&mut random, N, contacts);
        let kernel = Box::new(Compiled::<T, N, 3, C>::default());
        let library = Library::new(kernel, &scene, id.kind).expect("the scene is valid");
        let library: Box<dyn Contestant> = Box::new(library);
        for run in measure::race(&scene, vec![(id, library)], &[TOLERANCE], patience) {
            prepare.push(run.prepare.least);
            solve.extend(run.rungs.iter().map(|rung| rung.time.least));
        }
    }
    let mean = |times: &[f64]| geometric_mean(times).unwrap_or(f64::NAN);
    (mean(&prepare), mean(&solve))
}

fn by_type<T: Real>(id: Id, scenes: usize, patience: &Patience, progress: &mut Progress) -> Scaling {
    let size = |count: usize, (prepare, solve): (f64, f64)| Size { count, prepare, solve };
    let contacts = CONTACTS.map(|contacts| {
        progress.step(&format!("{}, {contacts} contacts on {FIXED_DOFS} dofs", id.name()));
        size(contacts, measure::<T, FIXED_DOFS, 12>(contacts, scenes, patience, id))
    });
    macro_rules! dofs {
        ($($n:literal)*) => {
            vec![$({
                progress.step(&format!("{}, {FIXED_CONTACTS} contacts on {} dofs", id.name(), $n));
                size($n, measure::<T, $n, FIXED_CONTACTS>(FIXED_CONTACTS, scenes, patience, id))
            }),*]
        };
    }
    Scaling { id, contacts: contacts.into(), dofs: dofs!(2 3 4 6 9 12 18 24 30) }
}

/// Both number types, over so many scenes a size.
pub(crate) fn run(scenes: usize, patience: &Patience) -> Vec<Scaling> {
    let mut progress = Progress::new("scaling", 2 * (CONTACTS.len() + DOFS.len()));
    let (double, single) = (Kind::Default.double(), Kind::Default.single());
    vec![
        by_type::<f64>(double, scenes, patience, &mut progress),
        by_type::<f32>(single, scenes, patience, &mut progress),
    ]
}
