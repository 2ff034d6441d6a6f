//! The sizes that are compiled: a scene takes the smallest that holds it, for every contestant.

use crate::alart_curnier::AlartCurnier;
use crate::clarabel::Clarabel;
use crate::contestant::{Contestant, Id, Kind, Precision};
use crate::gauss_seidel::GaussSeidel;
use crate::library::Library;
use crate::support::scene_file::SceneFile;
use stiction::Real;

/// A contestant of this name for this scene.
pub(crate) fn contestant(file: &SceneFile, id: Id) -> Box<dyn Contestant> {
    match (id.kind, id.precision) {
        (Kind::Relaxation, _) => Box::new(Clarabel::new(file, false)),
        (Kind::OuterLoop, _) => Box::new(Clarabel::new(file, true)),
        (kind, Precision::F64) => sized::<f64>(file, kind),
        (kind, Precision::F32) => sized::<f32>(file, kind),
    }
}

fn sized<T: Real>(file: &SceneFile, kind: Kind) -> Box<dyn Contestant> {
    macro_rules! sizes {
        ($d:literal: $($n:literal $c:literal),*) => {
            match (file.n_dof, file.n_contacts) {
                $((..=$n, ..=$c) => compiled::<T, $n, $d, $c, { $d * $c }>(file, kind),)*
                (n, c) => panic!("no size compiled for {n} dofs and {c} contacts"),
            }
        };
    }
    match file.dim {
        2 => sizes!(2: 6 4),
        _ => sizes!(3: 6 4, 6 8, 12 4, 12 12, 18 4, 18 12, 24 4, 24 12),
    }
}

fn compiled<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    file: &SceneFile,
    kind: Kind,
) -> Box<dyn Contestant> {
    match kind {
        Kind::GaussSeidel => Box::new(GaussSeidel::<T, N, D, C, R>::new(file)),
        Kind::AlartCurnier => Box::new(AlartCurnier::<T, N, D, C, R>::new(file)),
        kind => Library::<T, N, D, C>::new(file, kind).expect("bundled scenes are valid"),
    }
}
