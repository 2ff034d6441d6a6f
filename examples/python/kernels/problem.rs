//! A scene in slices, row by row, and the places its solution goes to.

use stiction::{Error, Input, List, Real, Status, Work};

/// A scene of `c` contacts with `dim` rows each and of `k` joint rows, over `n` velocities.
#[derive(Clone, Copy)]
pub struct Problem<'a, T> {
    pub n: usize,
    pub dim: usize,
    /// `M`, `n × n`.
    pub mass: &'a [T],
    /// `H`, `c × dim × n`.
    pub jacobian: &'a [T],
    /// `n`
    pub free_impulse: &'a [T],
    /// `w`, `c × dim`.
    pub offsets: &'a [T],
    pub friction: Friction<'a, T>,
    /// Along normal and tangents, `c × 2`; empty if all are rigid.
    pub compliance: &'a [T],
    /// `c`, or empty if all are 0.
    pub keys: &'a [u32],
    pub rows: Rows<'a, T>,
}

/// Friction coefficients.
#[derive(Clone, Copy)]
pub enum Friction<'a, T> {
    /// One a contact.
    Round(&'a [T]),
    /// One for each row behind the normal, `c × (dim - 1)`.
    Shaped(&'a [T]),
}

/// Joint rows; without bounds there are none.
#[derive(Clone, Copy)]
pub struct Rows<'a, T> {
    /// `k × n`
    pub jacobian: &'a [T],
    pub offset: &'a [T],
    pub lower: &'a [T],
    pub upper: &'a [T],
    pub compliance: &'a [T],
    pub keys: &'a [u32],
}

impl<T> Rows<'_, T> {
    pub const NONE: Self =
        Self { jacobian: &[], offset: &[], lower: &[], upper: &[], compliance: &[], keys: &[] };
}

impl<T> Problem<'_, T> {
    pub fn contacts(&self) -> usize {
        self.offsets.len() / self.dim
    }

    /// What a compiled size has to hold.
    pub fn needs(&self) -> Needs {
        let (contacts, rows) = (self.contacts(), self.rows.lower.len());
        Needs {
            n: self.n,
            dim: self.dim,
            contacts,
            rows,
            surfaces: matches!(self.friction, Friction::Shaped(_)) || !self.compliance.is_empty(),
        }
    }
}

/// What a compiled size has to hold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Needs {
    pub n: usize,
    pub dim: usize,
    pub contacts: usize,
    pub rows: usize,
    pub surfaces: bool,
}

/// Where a solution goes.
pub struct Out<'a, T> {
    pub v: &'a mut [T],
    pub r: &'a mut [T],
    pub u: &'a mut [T],
    pub modes: &'a mut [i8],
    pub certificate: &'a mut [T],
    pub row_impulses: &'a mut [T],
    pub row_velocities: &'a mut [T],
    pub row_modes: &'a mut [i8],
    pub row_certificate: &'a mut [T],
}

/// The arrays of a solution.
#[derive(Default)]
pub struct Answer<T> {
    pub v: Vec<T>,
    pub r: Vec<T>,
    pub u: Vec<T>,
    pub modes: Vec<i8>,
    pub certificate: Vec<T>,
    /// Impulses, velocities and certificate of joint rows.
    pub rows: [Vec<T>; 3],
    pub row_modes: Vec<i8>,
}

impl<T: Real> Answer<T> {
    /// Places for so many velocities, contacts of so many rows, and joint rows.
    pub fn out(&mut self, [n, contacts, dim, rows]: [usize; 4]) -> Out<'_, T> {
        self.v.resize(n, T::ZERO);
        self.r.resize(contacts * dim, T::ZERO);
        self.u.resize(contacts * dim, T::ZERO);
        self.modes.resize(contacts, 0);
        self.certificate.resize(contacts * dim, T::ZERO);
        self.rows.iter_mut().for_each(|list| list.resize(rows, T::ZERO));
        self.row_modes.resize(rows, 0);
        let [row_impulses, row_velocities, row_certificate] = &mut self.rows;
        Out {
            v: &mut self.v,
            r: &mut self.r,
            u: &mut self.u,
            modes: &mut self.modes,
            certificate: &mut self.certificate,
            row_impulses,
            row_velocities,
            row_modes: &mut self.row_modes,
            row_certificate,
        }
    }
}

/// How a solve ended.
#[derive(Clone, Copy)]
pub struct Outcome {
    pub status: Status,
    pub error: f64,
    pub work: Work,
}

impl Outcome {
    /// Adds the work of another solve.
    pub fn add(&mut self, work: &Work) {
        self.work.sweeps += work.sweeps;
        self.work.chord_steps += work.chord_steps;
        self.work.newton_steps += work.newton_steps;
        self.work.proof_searches += work.proof_searches;
    }

    /// Sweeps, chord steps, Newton steps, searches for a proof.
    pub fn work(&self) -> [i32; 4] {
        let Work { sweeps, chord_steps, newton_steps, proof_searches, .. } = self.work;
        [sweeps, chord_steps, newton_steps, proof_searches]
            .map(|count| i32::try_from(count).unwrap_or(i32::MAX))
    }
}

/// An error, after the name of the argument that it speaks of.
pub fn refusal(error: &Error) -> String {
    let argument = match error {
        Error::NotFinite { input, .. } => match input {
            Input::Mass => "M",
            Input::FreeImpulse => "free_impulse",
            Input::Jacobian { .. } => "H",
            Input::Offset { .. } => "w",
            Input::JointRow { .. } => "rows",
            _ => "impulses",
        },
        Error::MassNotSymmetric { .. }
        | Error::MassNotPositiveDefinite { .. }
        | Error::InvalidVelocityCount { .. } => "M",
        Error::InvalidFriction { .. } => "mu",
        Error::InvalidTolerance => "tol",
        Error::DelassusOutOfRange { .. } => "H",
        Error::InvalidCompliance { .. } => "compliance",
        Error::ListFull { list: List::Contacts | List::Surfaces | List::InitialImpulses, .. } => "contacts",
        _ => "rows",
    };
    format!("{argument}: {error}")
}
