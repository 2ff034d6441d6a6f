//! A scene in slices, row by row and without padding, and the places its solution goes to.

use stiction::{Error, Input, List, Real, Status, Work};

/// A scene of `c` contacts with `dim` rows each and of `k` joint rows, over `n` velocities.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a, T> {
    pub(crate) n: usize,
    pub(crate) dim: usize,
    pub(crate) dynamics: Dynamics<'a, T>,
    /// `w`, or `q`; `c × dim`.
    pub(crate) offsets: &'a [T],
    pub(crate) friction: Friction<'a, T>,
    /// Along normal and tangents, `c × 2`; empty if all are rigid.
    pub(crate) compliance: &'a [T],
    /// `c`, or empty if all are 0.
    pub(crate) keys: &'a [u32],
    pub(crate) rows: Rows<'a, T>,
}

/// What moves.
#[derive(Clone, Copy)]
pub(crate) enum Dynamics<'a, T> {
    /// `M` (`n × n`), `H` (`c × dim × n`) and the free impulse (`n`).
    Mass(&'a [T], &'a [T], &'a [T]),
    /// `W` (`m × m`).
    Delassus(&'a [T]),
}

/// Friction coefficients.
#[derive(Clone, Copy)]
pub(crate) enum Friction<'a, T> {
    /// One a contact.
    Round(&'a [T]),
    /// One for each row behind the normal, `c × (dim - 1)`.
    Shaped(&'a [T]),
}

/// Joint rows; without bounds there are none.
#[derive(Clone, Copy)]
pub(crate) struct Rows<'a, T> {
    /// `k × n`; empty beside a `W`.
    pub(crate) jacobian: &'a [T],
    pub(crate) offset: &'a [T],
    pub(crate) lower: &'a [T],
    pub(crate) upper: &'a [T],
    pub(crate) compliance: &'a [T],
    pub(crate) keys: &'a [u32],
}

impl<T> Rows<'_, T> {
    pub(crate) const NONE: Self = Self {
        jacobian: &[],
        offset: &[],
        lower: &[],
        upper: &[],
        compliance: &[],
        keys: &[],
    };
}

impl<T> Problem<'_, T> {
    pub(crate) fn contacts(&self) -> usize {
        self.offsets.len() / self.dim
    }

    /// What a compiled size has to hold.
    pub(crate) fn needs(&self) -> Needs {
        let (contacts, rows) = (self.contacts(), self.rows.lower.len());
        let n = match self.dynamics {
            Dynamics::Mass(..) => self.n,
            // The rank, as far as it is known.
            Dynamics::Delassus(_) => (self.dim * contacts + rows).clamp(1, self.n),
        };
        Needs {
            n,
            dim: self.dim,
            contacts,
            rows,
            surfaces: matches!(self.friction, Friction::Shaped(_)) || !self.compliance.is_empty(),
        }
    }
}

/// What a compiled size has to hold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Needs {
    pub(crate) n: usize,
    pub(crate) dim: usize,
    pub(crate) contacts: usize,
    pub(crate) rows: usize,
    pub(crate) surfaces: bool,
}

/// Where a solution goes.
pub(crate) struct Out<'a, T> {
    pub(crate) v: &'a mut [T],
    pub(crate) r: &'a mut [T],
    pub(crate) u: &'a mut [T],
    pub(crate) modes: &'a mut [i8],
    pub(crate) certificate: &'a mut [T],
    pub(crate) row_impulses: &'a mut [T],
    pub(crate) row_velocities: &'a mut [T],
    pub(crate) row_modes: &'a mut [i8],
    pub(crate) row_certificate: &'a mut [T],
}

/// The arrays of a solution.
#[derive(Default)]
pub(crate) struct Answer<T> {
    pub(crate) v: Vec<T>,
    pub(crate) r: Vec<T>,
    pub(crate) u: Vec<T>,
    pub(crate) modes: Vec<i8>,
    pub(crate) certificate: Vec<T>,
    /// Impulses, velocities and certificate of joint rows.
    pub(crate) rows: [Vec<T>; 3],
    pub(crate) row_modes: Vec<i8>,
}

impl<T: Real> Answer<T> {
    /// Places for so many velocities, contacts of so many rows, and joint rows.
    pub(crate) fn out(&mut self, [n, contacts, dim, rows]: [usize; 4]) -> Out<'_, T> {
        self.v.resize(n, T::ZERO);
        self.r.resize(contacts * dim, T::ZERO);
        self.u.resize(contacts * dim, T::ZERO);
        self.modes.resize(contacts, 0);
        self.certificate.resize(contacts * dim, T::ZERO);
        self.rows
            .iter_mut()
            .for_each(|list| list.resize(rows, T::ZERO));
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
pub(crate) struct Outcome {
    pub(crate) status: Status,
    pub(crate) error: f64,
    pub(crate) work: Work,
}

impl Outcome {
    /// Sweeps, chord steps, Newton steps, searches for a proof.
    pub(crate) fn work(&self) -> [i32; 4] {
        let Work {
            sweeps,
            chord_steps,
            newton_steps,
            proof_searches,
            ..
        } = self.work;
        [sweeps, chord_steps, newton_steps, proof_searches]
            .map(|count| i32::try_from(count).unwrap_or(i32::MAX))
    }
}

/// An error, after the name of the argument that it speaks of.
pub(crate) fn refusal(error: &Error) -> String {
    let argument = match error {
        Error::NotFinite { input, .. } => match input {
            Input::Mass => "M",
            Input::FreeImpulse => "free_impulse",
            Input::Jacobian { .. } => "H",
            Input::Offset { .. } => "w",
            Input::Delassus => "W",
            Input::JointRow { .. } => "rows",
            _ => "impulses",
        },
        Error::MassNotSymmetric { .. } | Error::MassNotPositiveDefinite { .. } => "M",
        Error::InvalidFriction { .. } => "mu",
        Error::InvalidTolerance => "tol",
        Error::DelassusOutOfRange { .. } => "H",
        Error::DelassusSize { .. } | Error::DelassusNotGram { .. } => "W",
        Error::InvalidCompliance { .. } => "compliance",
        Error::ListFull {
            list: List::Contacts | List::Surfaces | List::InitialImpulses,
            ..
        } => "contacts",
        _ => "rows",
    };
    format!("{argument}: {error}")
}
