//! What is copied out of a solver: the structs of `stiction.h` that a caller reads.

use super::header::{C, D, N, R, Real};
use super::solver::Outcome;
use super::status::{Mode, RowMode, Status};
use stiction::LeastImpulses;

/// `stiction_contact`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ContactOutcome {
    /// Which contact it is.
    pub key: u32,
    /// What it does.
    pub mode: Mode,
    /// Impulse, N s.
    pub impulse: [Real; D],
    /// Velocity, m/s.
    pub velocity: [Real; D],
    /// Its part in a proof.
    pub certificate: [Real; D],
}

impl ContactOutcome {
    const NONE: Self =
        Self { key: 0, mode: Mode::Open, impulse: [0.0; D], velocity: [0.0; D], certificate: [0.0; D] };

    /// A contact of a solution.
    pub(super) fn at(solution: &Outcome, place: usize) -> Option<Self> {
        solution.contacts.get(place).map(|contact| Self {
            key: contact.key,
            mode: contact.mode.into(),
            impulse: contact.impulse.into(),
            velocity: contact.velocity.into(),
            certificate: solution.certificate.get(place).map_or([0.0; D], |&d| d.into()),
        })
    }
}

/// `stiction_row`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RowOutcome {
    /// Which joint row it is.
    pub key: u32,
    /// What it does.
    pub mode: RowMode,
    /// Impulse, N s or N m s.
    pub impulse: Real,
    /// Velocity, m/s or rad/s.
    pub velocity: Real,
    /// Its part in a proof.
    pub certificate: Real,
}

impl RowOutcome {
    const NONE: Self = Self { key: 0, mode: RowMode::Open, impulse: 0.0, velocity: 0.0, certificate: 0.0 };

    /// A joint row of a solution.
    pub(super) fn at(solution: &Outcome, place: usize) -> Option<Self> {
        let certificate = solution.row_certificate.get(place).copied();
        solution.rows.get(place).map(|row| Self {
            key: row.key,
            mode: row.mode.into(),
            impulse: row.impulse,
            velocity: row.velocity,
            certificate: certificate.unwrap_or(0.0),
        })
    }
}

/// `stiction_solution`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Solution {
    /// How the solve ended.
    pub status: Status,
    /// Its work.
    pub work: u32,
    /// Contacts.
    pub count: u32,
    /// Its error.
    pub error: Real,
    /// Generalised velocity.
    pub velocity: [Real; N],
    /// The contacts, and zeros behind them.
    pub contacts: [ContactOutcome; C],
    /// Joint rows; without room for any it is not there.
    pub row_count: [u32; (R != 0) as usize],
    /// The joint rows, and zeros behind them.
    pub rows: [RowOutcome; R],
}

impl Solution {
    /// The same with other impulses, whose momentum error is that of the solution.
    pub(super) fn with(mut self, least: &LeastImpulses<Real, D, C, R>) -> Self {
        for (place, impulse) in self.contacts.iter_mut().zip(&least.contacts) {
            place.impulse = (*impulse).into();
        }
        for (place, &impulse) in self.rows.iter_mut().zip(&least.rows) {
            place.impulse = impulse;
        }
        self.error = least.momentum_error;
        self
    }

    pub(super) fn of(solution: &Outcome) -> Self {
        let number = |x: usize| u32::try_from(x).unwrap_or(u32::MAX);
        let mut read = Self {
            status: solution.status.into(),
            work: number(solution.work.total()),
            count: number(solution.contacts.len()),
            error: solution.error,
            velocity: solution.velocity.into(),
            contacts: [ContactOutcome::NONE; C],
            row_count: [number(solution.rows.len()); (R != 0) as usize],
            rows: [RowOutcome::NONE; R],
        };
        for (i, place) in read.contacts.iter_mut().enumerate() {
            *place = ContactOutcome::at(solution, i).unwrap_or(*place);
        }
        for (i, place) in read.rows.iter_mut().enumerate() {
            *place = RowOutcome::at(solution, i).unwrap_or(*place);
        }
        read
    }
}

/// `stiction_violation`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Violation {
    /// The fastest at which a closed gap closes, m/s.
    pub closing_speed: Real,
    /// The largest normal impulse of a contact that opens, N s.
    pub opening_impulse: Real,
    /// How far an impulse lies outside of its cone, N s.
    pub outside_cone: Real,
    /// The fastest that a contact moves which friction could stop, m/s.
    pub creep: Real,
    /// The most friction that a sliding contact lacks, N s.
    pub missing_friction: Real,
    /// The fastest at which a joint row goes where it must not, m/s or rad/s.
    pub row_speed: Real,
    /// How far the impulse of a joint row is from where its speed puts it, N s or N m s.
    pub row_impulse: Real,
}

impl From<stiction::Violation<Real>> for Violation {
    fn from(worst: stiction::Violation<Real>) -> Self {
        Self {
            closing_speed: worst.closing_speed,
            opening_impulse: worst.opening_impulse,
            outside_cone: worst.outside_cone,
            creep: worst.creep,
            missing_friction: worst.missing_friction,
            row_speed: worst.row_speed,
            row_impulse: worst.row_impulse,
        }
    }
}
