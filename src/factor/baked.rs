//! A factor in numbers, to be baked into firmware.

use super::{BAKED, Delassus, Factor};
use crate::linalg::sparsity::Support;
use crate::linalg::stacked::Counts;
use crate::real::Real;

/// The numbers of a [`Factor`] with `C` contacts and `R` joint rows, to be written by the host and read by firmware.
///
/// Blocks of `D` rows a contact; matrices row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorParts<T, const N: usize, const D: usize, const C: usize, const R: usize = 0> {
    /// Number of dofs that contacts and joint rows move.
    pub moved: usize,
    /// A bound on the rounding of `W`, relative to it.
    pub uncertainty: T,
    /// `M = Uᵀ D⁻¹ U`: below the diagonal `U`, which has `D` on its diagonal, and there `D⁻¹`; the
    /// upper triangle is not used.
    pub mass: [[T; N]; N],
    /// `X_i` of each contact, with `Uᵀ D⁻¹ X_i = H_iᵀ`.
    pub whitened: [[[T; D]; N]; C],
    /// The same of each joint row.
    pub whitened_rows: [[[T; 1]; N]; R],
    /// `W = H M⁻¹ Hᵀ` of contacts.
    pub delassus: [[[[T; D]; C]; D]; C],
    /// `W` of joint rows with contacts.
    pub coupling: [[[T; D]; C]; R],
    /// `W` of joint rows.
    pub row_delassus: [[T; R]; R],
    /// The effective mass `W_ii⁻¹` of each contact; zero where `W_ii` is singular or nearly so, or `D > 3`.
    pub effective_mass: [[[T; D]; D]; C],
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>
    Factor<T, N, D, C, R>
{
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
    /// let (scene, factor): (Scene<_, _, _, _>, _) = (Scene::from_parts(mass, [contact], []), Factor::from_parts(&parts));
    /// let mut solver = Solver::new();
    /// assert!(solver.solve(&scene, &factor, &vector![0.0, -0.2], &Settings::default())?.is_solved());
    /// # Ok::<(), stiction::Error>(())
    /// ```
    #[must_use]
    pub const fn from_parts(parts: &FactorParts<T, N, D, C, R>) -> Self {
        Self {
            counts: Counts {
                contacts: C,
                rows: R,
            },
            fingerprint: BAKED,
            moved: parts.moved,
            uncertainty: parts.uncertainty,
            mass: parts.mass,
            whitened: parts.whitened,
            whitened_rows: parts.whitened_rows,
            supports: [Support::all(); C],
            delassus: Delassus {
                contacts: parts.delassus,
                coupling: parts.coupling,
                rows: parts.row_delassus,
            },
            effective_mass: parts.effective_mass,
        }
    }

    /// The numbers of this factor; `None` unless it has `C` contacts and `R` joint rows.
    #[must_use]
    pub fn parts(&self) -> Option<FactorParts<T, N, D, C, R>> {
        (self.counts.contacts == C && self.counts.rows == R).then_some(FactorParts {
            moved: self.moved,
            uncertainty: self.uncertainty,
            mass: self.mass,
            whitened: self.whitened,
            whitened_rows: self.whitened_rows,
            delassus: self.delassus.contacts,
            coupling: self.delassus.coupling,
            row_delassus: self.delassus.rows,
            effective_mass: self.effective_mass,
        })
    }
}
