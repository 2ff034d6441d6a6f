//! Contacts and rows of one island, as arrays of a problem.

use super::inertia::Inertia;
use super::rows::{Kind, Row};
use super::touch::Touch;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use stiction_kernels::problem::{Answer, Dynamics, Friction, Problem, Rows};
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

/// Coordinates of what the rows move: with `L Lᵀ = M` and `A = H L⁻ᵀ = Rᵀ Qᵀ` the law is that of unit masses, rows `Rᵀ` and the
/// free impulse `Qᵀ L⁻¹ b`, with the same impulses.
struct Reduced {
    factor: Cholesky<f64, Dyn>,
    /// `L⁻¹ b` and `Aᵀ`.
    free: DVector<f64>,
    columns: DMatrix<f64>,
}

impl Pack {
    /// Begins a problem: its velocities, rows of a contact, and free impulse (of all velocities).
    pub(super) fn begin(
        &mut self,
        inertia: &Inertia,
        dofs: &[usize],
        dim: usize,
        impulse: Option<&[f64]>,
    ) {
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

    /// Adds a contact with these velocities along its rows.
    pub(super) fn contact(&mut self, touch: &Touch, offset: [f64; 6]) {
        let dim = touch.dim.min(self.dim);
        let nv = touch.rows.len() / touch.dim;
        for row in touch.rows.chunks_exact(nv).take(dim) {
            self.jacobian.extend(self.dofs.iter().map(|&dof| row[dof]));
        }
        let contact = self.keys.len() + 1;
        self.jacobian
            .resize(contact * self.dim * self.dofs.len(), 0.0);
        self.offsets.extend_from_slice(&offset[..dim]);
        self.offsets.resize(contact * self.dim, 0.0);
        self.round.push(touch.mu());
        self.shaped.extend_from_slice(&touch.friction[..dim - 1]);
        self.shaped.resize(contact * (self.dim - 1), 0.0);
        self.is_shaped |=
            touch.dim > 1 && touch.friction[0].to_bits() != touch.friction[1].to_bits();
        let [first, second] = touch
            .face
            .geoms
            .map(|geom| u32::try_from(geom).unwrap_or(u32::MAX));
        self.keys.push(first << 16 ^ second);
    }

    /// Adds a row.
    pub(super) fn row(&mut self, row: &Row, offset: f64) {
        self.row_jacobian
            .extend(self.dofs.iter().map(|&dof| row.jacobian[dof]));
        self.row_offset.push(offset);
        let [lower, upper] = match row.kind {
            Kind::Equality => [-f64::INFINITY, f64::INFINITY],
            Kind::Friction => [-row.most, row.most],
            Kind::Limit => [0.0, f64::INFINITY],
        };
        self.row_lower.push(lower);
        self.row_upper.push(upper);
        self.row_keys.push(row.key);
    }

    /// Sets the compliance of contacts, along normal and tangents, and of rows.
    pub(super) fn soften(
        &mut self,
        contacts: impl Iterator<Item = [f64; 2]>,
        rows: impl Iterator<Item = f64>,
    ) {
        self.compliance.clear();
        self.compliance.extend(contacts.flatten());
        self.is_compliant = self.compliance.iter().any(|&c| c != 0.0);
        self.row_compliance.clear();
        self.row_compliance.extend(rows);
    }

    /// Changes to as many coordinates as there are rows, if these fit a smaller kernel.
    pub(super) fn reduce(&mut self) {
        let n = self.dofs.len();
        let rows = self
            .jacobian
            .chunks_exact(n)
            .chain(self.row_jacobian.chunks_exact(n));
        let count = rows.clone().count();
        if count == 0 || count >= n || n <= SMALL || sizes::room(count) == sizes::room(n) {
            return;
        }
        let Some(factor) = Cholesky::new(DMatrix::from_row_slice(n, n, &self.mass)) else {
            return;
        };
        let mut columns = DMatrix::from_iterator(n, count, rows.flatten().copied());
        let mut free = DVector::from_column_slice(&self.impulse);
        factor.l_dirty().solve_lower_triangular_mut(&mut columns);
        factor.l_dirty().solve_lower_triangular_mut(&mut free);
        let parts = columns.clone().qr();
        let (basis, triangle) = (parts.q(), parts.r());
        let contacts = self.jacobian.len() / n;
        let along = |row: usize| (0..count).map(move |i| (i, row));
        self.jacobian = (0..contacts)
            .flat_map(along)
            .map(|place| triangle[place])
            .collect();
        self.row_jacobian = (contacts..count)
            .flat_map(along)
            .map(|place| triangle[place])
            .collect();
        self.impulse = (basis.transpose() * &free).as_slice().to_vec();
        self.mass = DMatrix::<f64>::identity(count, count).as_slice().to_vec();
        self.reduced = Some(Reduced {
            factor,
            free,
            columns,
        });
    }

    /// Takes the velocities of an answer back to all coordinates.
    pub(super) fn expand(&self, answer: &mut Answer<f64>) {
        if let Some(Reduced {
            factor,
            free,
            columns,
        }) = &self.reduced
        {
            let impulses = DVector::from_iterator(
                columns.ncols(),
                answer.r.iter().chain(&answer.rows[0]).copied(),
            );
            let mut velocity = free + columns * impulses;
            factor
                .l_dirty()
                .tr_solve_lower_triangular_mut(&mut velocity);
            answer.v.clear();
            answer.v.extend(&velocity);
        }
    }

    pub(super) fn problem(&self) -> Problem<'_, f64> {
        Problem {
            n: self.impulse.len(),
            dim: self.dim,
            dynamics: Dynamics::Mass(&self.mass, &self.jacobian, &self.impulse),
            offsets: &self.offsets,
            friction: if self.is_shaped {
                Friction::Shaped(&self.shaped)
            } else {
                Friction::Round(&self.round)
            },
            compliance: if self.is_compliant {
                &self.compliance
            } else {
                &[]
            },
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
