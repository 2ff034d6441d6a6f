//! A factor in numbers, to be baked into firmware.

use super::{BAKED, Factor};
use crate::Real;
use crate::laws::{NoRoom, Room};
use crate::linalg::sparsity::Support;

/// The numbers of a [`Factor`] with `C` contacts, to be written by the host and read by firmware.
///
/// Blocks of `D` rows a contact; matrices row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorParts<T, const N: usize, const D: usize, const C: usize> {
    /// Number of dofs that contacts move.
    pub moved: usize,
    /// A bound on the rounding of `W`, relative to it.
    pub uncertainty: T,
    /// `M = Uᵀ D⁻¹ U`: below the diagonal `U`, which has `D` on its diagonal, and there `D⁻¹`; the
    /// upper triangle is not used.
    pub mass: [[T; N]; N],
    /// `X_i` of each contact, with `Uᵀ D⁻¹ X_i = H_iᵀ`.
    pub whitened: [[[T; D]; N]; C],
    /// `W = H M⁻¹ Hᵀ`.
    pub delassus: [[[[T; D]; C]; D]; C],
    /// The effective mass `W_ii⁻¹` of each contact; zero where `W_ii` is singular or nearly so, or `D > 3`.
    pub effective_mass: [[[T; D]; D]; C],
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Factor<T, N, D, C> {
    /// A factor from numbers that [`Self::parts`] gave, to stand in a `static`.
    ///
    /// Unchecked. With numbers of another scene all results are meaningless, [`crate::Status::Solved`] included: the error is
    /// measured with the steps `alpha_i` and the rounding bounds of this `W`. `examples/bake` writes such constants.
    ///
    /// ```
    /// use nalgebra::{Matrix2, matrix, vector};
    /// use stiction::{Contact, Factor, FactorParts, Scene, Settings, Solver};
    ///
    /// // On the host: from a checked scene to numbers.
    /// let contact = Contact { jacobian: matrix![0.0, 1.0; 1.0, 0.0], offset: vector![0.0, 0.0], mu: 0.5, key: 0 };
    /// let mass = Matrix2::identity() * 2.0;
    /// let mut scene = Scene::<f32, 2, 2, 1>::new();
    /// scene.set_mass(&mass)?;
    /// scene.push(&contact)?;
    /// let parts: FactorParts<f32, 2, 2, 1> = Factor::new(&scene)?.parts().expect("as many contacts as there is room for");
    ///
    /// // In firmware: nothing is factorised.
    /// let (scene, factor) = (Scene::from_parts(mass, [contact]), Factor::from_parts(&parts));
    /// let mut solver = Solver::new();
    /// assert!(solver.solve(&scene, &factor, &vector![0.0, -0.2], &Settings::default())?.is_solved());
    /// # Ok::<(), stiction::Error>(())
    /// ```
    #[must_use]
    pub const fn from_parts(parts: &FactorParts<T, N, D, C>) -> Self {
        Self {
            contacts: C,
            fingerprint: BAKED,
            moved: parts.moved,
            uncertainty: parts.uncertainty,
            mass: parts.mass,
            whitened: parts.whitened,
            supports: [Support::all(); C],
            delassus: parts.delassus,
            effective_mass: parts.effective_mass,
            scales: [const { NoRoom::EMPTY }; C],
        }
    }

    /// The numbers of this factor; `None` unless it has `C` contacts.
    #[must_use]
    pub fn parts(&self) -> Option<FactorParts<T, N, D, C>> {
        (self.contacts == C).then_some(FactorParts {
            moved: self.moved,
            uncertainty: self.uncertainty,
            mass: self.mass,
            whitened: self.whitened,
            delassus: self.delassus,
            effective_mass: self.effective_mass,
        })
    }
}
