//! The matrix of a Newton step, transposed ([`crate::linalg::elimination`]): a row has the entries of one unknown in the equations of
//! contacts and joint rows in their frames.

use super::Jacobian;
use crate::factor::Delassus;
use crate::linalg::blocks::{product, row_times};
use crate::linalg::stacked::StackedMatrix;
use crate::linalg::zip::zip3;
use crate::real::Real;
use crate::sets::Sets;
use crate::sets::contact::frame::Kind;

impl<T: Real, const D: usize, const C: usize, const R: usize> Jacobian<T, D, C, R> {
    /// Writes the unknowns of contacts in the equations of contacts.
    pub(super) fn assemble_contacts(
        &self,
        delassus: &Delassus<T, D, C, R>,
        symmetric: bool,
        matrix: &mut StackedMatrix<T, D, C, R>,
    ) -> Option<()> {
        let delassus = &delassus.contacts;
        let frames = self.frames.get(..self.counts.contacts)?;
        let damping = self.damping;
        for (j, frame) in frames.iter().enumerate() {
            let start = self.elimination.columns(j).start;
            if frame.kind == Kind::Open {
                continue;
            }
            for (i, rows, row_frame) in zip3(0..C, &mut matrix.contacts, frames) {
                if symmetric && i > j {
                    break;
                }
                if row_frame.kind == Kind::Open {
                    continue;
                }
                let mut block = [[T::ZERO; D]; D];
                for (entries, source) in block.iter_mut().zip(delassus.get(i)?) {
                    *entries = frame.tested(source.get(j)?);
                }
                for (k, row) in rows.iter_mut().enumerate() {
                    let mut entries = [T::ZERO; D];
                    if k < row_frame.count() {
                        entries = match row_frame.push(k) {
                            Some(push) => row_times(push, &block),
                            None => *block.get(k)?,
                        };
                        if i == j {
                            *entries.get_mut(k)? += frame.diagonal(k, damping);
                        }
                    }
                    // Zeros behind the columns of the contact: the next contact overwrites them.
                    let target = row.contacts.as_flattened_mut().get_mut(start..)?;
                    *target.first_chunk_mut()? = entries;
                }
            }
        }
        Some(())
    }

    /// Writes the unknowns of joint rows, and those of contacts in the equations of joint rows.
    pub(super) fn assemble_rows(
        &self,
        sets: &Sets<T, D, C, R>,
        delassus: &Delassus<T, D, C, R>,
        symmetric: bool,
        matrix: &mut StackedMatrix<T, D, C, R>,
    ) -> Option<()> {
        let frames = self.frames.get(..self.counts.contacts)?;
        for (index, j) in self.holding_rows().enumerate() {
            let sources = delassus.rows.get(j)?;
            let target = matrix.rows.get_mut(index)?;
            for (entry, k) in target.rows.iter_mut().zip(self.holding_rows()) {
                *entry = *sources.rows.get(k)?;
            }
            // `δ A⁻¹ / (1 + δ)`, as for contacts that stick.
            let set = sets.rows().get(j)?;
            let damped = self.damping / (set.alpha * (T::ONE + self.damping));
            *target.rows.get_mut(index)? += damped;
            for (i, frame, source) in zip3(0..C, frames, &sources.contacts) {
                if frame.kind == Kind::Open {
                    continue;
                }
                if !symmetric {
                    let entries = frame.tested(source);
                    let target = target.contacts.as_flattened_mut();
                    let start = self.elimination.columns(i).start;
                    *target.get_mut(start..)?.first_chunk_mut()? = entries;
                }
                for (k, row) in matrix.contacts.get_mut(i)?.iter_mut().enumerate() {
                    let mut entry = T::ZERO;
                    if k < frame.count() {
                        entry = match frame.push(k) {
                            Some(push) => product(push, source),
                            None => *source.get(k)?,
                        };
                    }
                    *row.rows.get_mut(index)? = entry;
                }
            }
        }
        Some(())
    }
}
