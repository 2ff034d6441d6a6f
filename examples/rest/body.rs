//! A body at rest and its load.

use nalgebra::{DMatrix, DVector};
use stiction::{Contact, Error, JointRow, Kernel, Real, RowLaw};

/// m/s²
pub(crate) const GRAVITY: f64 = 9.81;

/// Length of a tick, s.
pub(crate) const STEP: f64 = 2e-3;

#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A box on its four corners on a slope.
    Box4,
    /// A box on eight points on a slope.
    Box8,
    /// A body on four feet, each on ground of its own slope.
    Uneven,
    /// A box in the corner of a floor and a wall.
    Corner,
    /// A Go2 whose joints are free: its forces follow from the load.
    Free,
    /// A Go2 whose joints are held: its forces do not.
    Held,
    /// A rover of four wheels with brakes or locked.
    Rover,
}

impl Kind {
    pub(crate) const ALL: [Self; 7] =
        [Self::Box4, Self::Box8, Self::Uneven, Self::Corner, Self::Free, Self::Held, Self::Rover];

    /// In the order of [`Self::ALL`].
    pub(crate) const NAMES: [&str; 7] = [
        "box on four points",
        "box on eight points",
        "uneven feet",
        "floor and wall",
        "Go2 with free joints",
        "Go2 with held joints",
        "rover with brakes",
    ];

    pub(crate) fn name(self) -> &'static str {
        let mut named = Self::ALL.iter().zip(Self::NAMES);
        named.find(|(kind, _)| **kind == self).map_or("", |(_, name)| name)
    }
}

/// A joint that a brake holds.
#[derive(Clone, Copy)]
pub(crate) struct Brake {
    /// The velocity which it brakes.
    pub(crate) column: usize,
    /// Its largest torque, N·m; infinite if it is locked.
    pub(crate) torque: f64,
}

/// A place where a rigid body is supported: what `tests/rest_kept.json` keeps of a contact.
#[derive(Clone, Copy)]
pub(crate) struct Foot {
    pub(crate) point: [f64; 3],
    pub(crate) normal: [f64; 3],
}

#[derive(Clone)]
pub(crate) struct Body {
    pub(crate) kind: Kind,
    pub(crate) mass: DMatrix<f64>,
    /// Three rows a contact, normal first.
    pub(crate) jacobian: DMatrix<f64>,
    pub(crate) mu: Vec<f64>,
    pub(crate) brakes: Vec<Brake>,
    pub(crate) weight: DVector<f64>,
    pub(crate) load: DVector<f64>,
    /// Norm of the contact forces that hold both, N.
    pub(crate) force: f64,
    /// Empty of a Go2.
    pub(crate) feet: Vec<Foot>,
    /// Radius of the wheels, m, if it has some.
    pub(crate) radius: f64,
}

impl Body {
    /// With so many times its load.
    pub(crate) fn loaded(&self, share: f64) -> Self {
        Self { load: &self.load * share, ..self.clone() }
    }

    /// Mass of the whole body, kg.
    pub(crate) fn kilograms(&self) -> f64 {
        self.mass[(0, 0)]
    }

    /// The sizes of the body must be at most those of the kernel.
    pub(crate) fn kernel<T: Real, const N: usize, const C: usize, const R: usize>(
        &self,
    ) -> Result<Kernel<T, N, 3, C, R>, Error> {
        let mut kernel = Kernel::new();
        let scene = kernel.scene_mut();
        scene.set_mass(&self.mass.fixed_view::<N, N>(0, 0).map(T::literal))?;
        for (i, &mu) in (0..).zip(&self.mu) {
            let first_row = 3 * i as usize;
            scene.push(&Contact {
                jacobian: self.jacobian.fixed_view::<3, N>(first_row, 0).map(T::literal),
                offset: [T::ZERO; 3].into(),
                mu: T::literal(mu),
                key: i,
            })?;
        }
        for (key, brake) in (0..).zip(&self.brakes) {
            let impulse = T::literal(brake.torque * STEP);
            let law = if brake.torque.is_finite() {
                RowLaw::Box { lower: -impulse, upper: impulse }
            } else {
                RowLaw::Equality
            };
            let mut row = nalgebra::SVector::<T, N>::zeros();
            row[brake.column] = T::ONE;
            scene.push_row(&JointRow { row, offset: T::ZERO, law, compliance: T::ZERO, key })?;
        }
        Ok(kernel)
    }
}
