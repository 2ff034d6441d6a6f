//! The sizes that are compiled: a scene takes the smallest that holds it, for every contestant.

use crate::alart_curnier::AlartCurnier;
use crate::clarabel::Clarabel;
use crate::contestant::{Contestant, Id, Kind, Precision};
use crate::gauss_seidel::GaussSeidel;
use crate::library::Library;
use stiction::Real;
use testbed::kernel::{Constructor, Shape};
use testbed::scene_file::SceneFile;

/// A contestant of this name for this scene; `None` where its number type cannot hold the scene.
pub(crate) fn contestant(file: &SceneFile, id: Id) -> Option<Box<dyn Contestant>> {
    Some(match (id.kind, id.precision) {
        (Kind::Relaxation, _) => Box::new(Clarabel::new(file, false)),
        (Kind::OuterLoop, _) => Box::new(Clarabel::new(file, true)),
        (Kind::GaussSeidel | Kind::AlartCurnier, Precision::F64) => rival::<f64>(file, id.kind)?,
        (Kind::GaussSeidel | Kind::AlartCurnier, Precision::F32) => rival::<f32>(file, id.kind)?,
        (kind, precision) => {
            let kernel: Constructor = match precision {
                Precision::F64 => kernels_f64::kernel,
                Precision::F32 => kernels_f32::kernel,
            };
            let kernel = kernel(Shape::of(file)).expect("a size is compiled");
            Box::new(Library::new(kernel, file, kind).ok()?)
        }
    })
}

fn rival<T: Real>(file: &SceneFile, kind: Kind) -> Option<Box<dyn Contestant>> {
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
        _ => sizes!(3: 6 4, 6 12, 12 12, 18 4, 18 12, 24 12, 30 12),
    }
}

fn compiled<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    file: &SceneFile,
    kind: Kind,
) -> Option<Box<dyn Contestant>> {
    Some(match kind {
        Kind::GaussSeidel => Box::new(GaussSeidel::<T, N, D, C, R>::new(file)?),
        _ => Box::new(AlartCurnier::<T, N, D, C, R>::new(file)?),
    })
}
