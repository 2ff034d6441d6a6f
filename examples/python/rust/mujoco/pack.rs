//! Contacts and rows of one island, as arrays of a problem.

use super::inertia::Inertia;
use super::rows::{Kind, Row};
use super::touch::Touch;
use nalgebra::{DMatrix, DVector};
use stiction_kernels::problem::{Answer, Friction, Problem, Rows};
use stiction_kernels::sizes;

/// Up to so many velocities they are solved as they are.
const SMALL: usize = 20;

/// The arrays. Velocities that nothing of the island moves are left out.
#[derive(Default)]
pub(super) struct Pack {
    dofs: Vec<usize>,
    pub(super) dim: usize,
    is_shaped: bool,
    is_compliant: bool,
    mass: Vec<f64>,
    impulse: Vec<f64>,
    jacobian: Vec<f64>,
    offsets: Vec<f64>,
    round: Vec<f64>,
    shaped: Vec<f64>,
    compliance: Vec<f64>,
    keys: Vec<u32>,
    row_jacobian: Vec<f64>,
    row_offset: Vec<f64>,
    row_lower: Vec<f64>,
    row_upper: Vec<f64>,
    row_compliance: Vec<f64>,
    row_keys: Vec<u32>,
    reduced: Option<Reduced>,
}

/// Coordinates of unit masses: with `L Lᵀ = M` and `A = H L⁻ᵀ` the law is that of rows `A` and the free impulse `L⁻¹ b`, with the same
/// impulses; with `A = Rᵀ Qᵀ` that of rows `Rᵀ` and `Qᵀ L⁻¹ b`.
struct Reduced {
    /// `L⁻¹ b`, and `A` row by row.
    free: Vec<f64>,
    rows: Vec<f64>,
}

impl Pack {
    /// Begins a problem: its velocities, rows of a contact, and free impulse (of all velocities).
    pub(super) fn begin(&mut self, inertia: &Inertia, dofs: &[usize], dim: usize, impulse: Option<&[f64]>) {
        for list in [
            &mut self.mass,
            &mut self.impulse,
            &mut self.jacobian,
            &mut self.offsets,
            &mut self.round,
            &mut self.shaped,
            &mut self.compliance,
            &mut self.row_jacobian,
            &mut self.row_offset,
            &mut self.row_lower,
            &mut self.row_upper,
            &mut self.row_compliance,
        ] {
            list.clear();
        }
        self.keys.clear();
        self.row_keys.clear();
        self.reduced = None;
        self.dofs.clear();
        self.dofs.extend_from_slice(dofs);
        self.dim = dim;
        self.is_shaped = dim > 3;
        self.is_compliant = false;
        for &i in dofs {
            self.mass.extend(dofs.iter().map(|&j| inertia.entry(i, j)));
            self.impulse.push(impulse.map_or(0.0, |impulse| impulse[i]));
        }
    }

    /// Adds a contact with these velocities along its rows; without friction unless it `rubs`.
    pub(super) fn contact(&mut self, touch: &Touch, offset: [f64; 6], rubs: bool) {
        let dim = touch.dim.min(self.dim);
        let nv = touch.rows.len() / touch.dim;
        for row in touch.rows.chunks_exact(nv).take(dim) {
            self.jacobian.extend(self.dofs.iter().map(|&dof| row[dof]));
        }
        let contact = self.keys.len() + 1;
        self.jacobian.resize(contact * self.dim * self.dofs.len(), 0.0);
        self.offsets.extend_from_slice(&offset[..dim]);
        self.offsets.resize(contact * self.dim, 0.0);
        let friction = touch.friction.map(|friction| if rubs { friction } else { 0.0 });
        self.round.push(if rubs { touch.mu() } else { 0.0 });
        self.shaped.extend_from_slice(&friction[..dim - 1]);
        self.shaped.resize(contact * (self.dim - 1), 0.0);
        self.is_shaped |= touch.dim > 1 && touch.friction[0].to_bits() != touch.friction[1].to_bits();
        self.keys.push(touch.key);
    }

    /// Adds a row.
    pub(super) fn row(&mut self, row: &Row) {
        self.row_jacobian.extend(self.dofs.iter().map(|&dof| row.jacobian[dof]));
        let [lower, upper] = match row.kind {
            Kind::Equality => [-f64::INFINITY, f64::INFINITY],
            Kind::Friction => [-row.most, row.most],
            Kind::Limit => [0.0, f64::INFINITY],
        };
        self.row_lower.push(lower);
        self.row_upper.push(upper);
        self.row_keys.push(row.key);
    }

    /// Sets the compliance of contacts, along normal and tangents, and offset and compliance of rows.
    pub(super) fn ask(
        &mut self,
        contacts: impl Iterator<Item = [f64; 2]>,
        rows: impl Iterator<Item = [f64; 2]>,
    ) {
        self.compliance.clear();
        self.compliance.extend(contacts.flatten());
        self.is_compliant = self.compliance.iter().any(|&c| c != 0.0);
        self.row_offset.clear();
        self.row_compliance.clear();
        for [offset, compliance] in rows {
            self.row_offset.push(offset);
            self.row_compliance.push(compliance);
        }
    }

    /// Changes to coordinates of unit masses: to those that the rows move, or to as many as there are rows, if these are at most two thirds
    /// or no kernel has room for all.
    pub(super) fn reduce(&mut self, inertia: &Inertia) {
        let n = self.dofs.len();
        let count = (self.jacobian.len() + self.row_jacobian.len()) / n;
        if count == 0 || n <= SMALL {
            return;
        }
        let mut wide = vec![0.0; self.dofs.last().map_or(0, |last| last + 1)];
        let mut unit = |row: &[f64], out: &mut Vec<f64>| {
            let places = self.dofs.iter().zip(row);
            places.for_each(|(&dof, &entry)| wide[dof] = entry);
            inertia.to_unit(&self.dofs, &wide, out);
        };
        let mut rows = Vec::with_capacity(count * n);
        let all = self.jacobian.chunks_exact(n).chain(self.row_jacobian.chunks_exact(n));
        all.for_each(|row| unit(row, &mut rows));
        let is_moved = |&j: &usize| rows[j..].iter().step_by(n).any(|&entry| entry != 0.0);
        let moved: Vec<_> = (0..n).filter(is_moved).collect();
        let is_few = moved.len() <= count;
        if 3 * moved.len().min(count) > 2 * n && sizes::has_room(n, self.dim) {
            return;
        }
        let mut free = Vec::with_capacity(n);
        unit(&self.impulse, &mut free);
        let of_moved = |row: &[f64]| moved.iter().map(|&j| row[j]).collect::<Vec<_>>();
        let contact_rows = self.jacobian.len() / n;
        let (impulse, own): (Vec<f64>, Vec<f64>) = if is_few {
            (of_moved(&free), rows.chunks_exact(n).flat_map(of_moved).collect())
        } else {
            let columns = rows.chunks_exact(n).flat_map(of_moved);
            let parts = DMatrix::from_iterator(moved.len(), count, columns).qr();
            let mut along = DVector::from_vec(of_moved(&free));
            parts.q_tr_mul(&mut along);
            let triangle = parts.r();
            let own = triangle.column_iter().flat_map(|row| row.iter().copied().collect::<Vec<_>>());
            (along.as_slice()[..count.min(moved.len())].to_vec(), own.collect())
        };
        let size = impulse.len();
        (self.jacobian, self.row_jacobian) = {
            let (contacts, others) = own.split_at(contact_rows * size);
            (contacts.to_vec(), others.to_vec())
        };
        self.impulse = impulse;
        self.mass = DMatrix::<f64>::identity(size, size).as_slice().to_vec();
        self.reduced = Some(Reduced { free, rows });
    }

    /// Takes the velocities of an answer back to all coordinates.
    pub(super) fn expand(&self, inertia: &Inertia, answer: &mut Answer<f64>) {
        let Some(Reduced { free, rows }) = &self.reduced else {
            return;
        };
        let mut motion = free.clone();
        let impulses = answer.r.iter().chain(&answer.rows[0]);
        for (row, &impulse) in rows.chunks_exact(motion.len()).zip(impulses) {
            if impulse != 0.0 {
                motion.iter_mut().zip(row).for_each(|(v, a)| *v += impulse * a);
            }
        }
        answer.v.resize(motion.len(), 0.0);
        inertia.back_from_unit(&self.dofs, &mut motion, |dof, v| {
            if let Ok(place) = self.dofs.binary_search(&dof) {
                answer.v[place] = v;
            }
        });
    }

    pub(super) fn problem(&self) -> Problem<'_, f64> {
        Problem {
            n: self.impulse.len(),
            dim: self.dim,
            mass: &self.mass,
            jacobian: &self.jacobian,
            free_impulse: &self.impulse,
            offsets: &self.offsets,
            friction: if self.is_shaped {
                Friction::Shaped(&self.shaped)
            } else {
                Friction::Round(&self.round)
            },
            compliance: if self.is_compliant { &self.compliance } else { &[] },
            keys: &self.keys,
            rows: Rows {
                jacobian: &self.row_jacobian,
                offset: &self.row_offset,
                lower: &self.row_lower,
                upper: &self.row_upper,
                compliance: &self.row_compliance,
                keys: &self.row_keys,
            },
        }
    }
}
