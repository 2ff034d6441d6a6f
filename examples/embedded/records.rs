//! Scenes in flash: little-endian `f32`, as `examples/bake` writes them.
//!
//! A record is one time step: the number of contacts (`u32`); the lower triangle of `M`, row by
//! row; `f`; then for each contact its key (`u32`), `mu`, `w` and `H` row by row.

use nalgebra::{SMatrix, SVector};
use stiction::{Contact, Real, Scene};

/// The records not read yet.
pub(crate) struct Records<'a>(&'a [u8]);

/// One time step.
pub(crate) struct Step<T: Real, const N: usize, const D: usize, const C: usize> {
    pub(crate) scene: Scene<T, N, D, C>,
    pub(crate) push: SVector<T, N>,
}

impl<'a> Records<'a> {
    pub(crate) const fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    fn word(&mut self) -> Option<u32> {
        let (word, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u32::from_le_bytes(*word))
    }

    fn number<T: Real>(&mut self) -> Option<T> {
        let number = f32::from_bits(self.word()?);
        Some(T::literal(f64::from(number)))
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Step<T, N, D, C> {
    pub(crate) const fn new() -> Self {
        Self {
            scene: Scene::new(),
            push: SVector::from_array_storage(nalgebra::ArrayStorage([[T::ZERO; N]; 1])),
        }
    }

    /// Reads the next record; `None` at the end, or if the record is not of these sizes.
    pub(crate) fn read(&mut self, records: &mut Records<'_>) -> Option<()> {
        let contacts = records.word()?;
        let mut mass = SMatrix::<T, N, N>::zeros();
        for i in 0..N {
            for j in 0..=i {
                let entry = records.number()?;
                *mass.get_mut((i, j))? = entry;
                *mass.get_mut((j, i))? = entry;
            }
        }
        self.scene.set_mass(&mass).ok()?;
        for push in &mut self.push {
            *push = -records.number::<T>()?;
        }
        self.scene.clear();
        for _ in 0..contacts {
            let key = records.word()?;
            let mut contact = Contact::<T, N, D> {
                jacobian: SMatrix::zeros(),
                offset: SVector::zeros(),
                mu: records.number()?,
                key,
            };
            for w in &mut contact.offset {
                *w = records.number()?;
            }
            for row in 0..D {
                for dof in 0..N {
                    *contact.jacobian.get_mut((row, dof))? = records.number()?;
                }
            }
            self.scene.push(&contact).ok()?;
        }
        Some(())
    }
}
