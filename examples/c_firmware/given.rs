//! The structs of `stiction.h` that go into a scene, and a solve.

use super::header::{D, N, Real};
use super::solver::Refusal;
use super::status::Law;
use stiction::RowLaw;
use stiction::nalgebra::SVector;

/// `stiction_surface`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Surface {
    /// Friction coefficients along the tangents.
    pub friction: [Real; 2],
    /// That about the normal, m.
    pub spin: Real,
    /// Those about the tangents, m.
    pub roll: [Real; 2],
    /// Compliance along the normal and along the tangents, 1/kg.
    pub compliance: [Real; 2],
}

impl From<&Surface> for stiction::Surface<Real> {
    fn from(surface: &Surface) -> Self {
        Self {
            friction: surface.friction,
            spin: surface.spin,
            roll: surface.roll,
            compliance: surface.compliance,
        }
    }
}

/// An `enum stiction_law` as it comes from C, which may be any number.
pub type LawNumber = u32;

/// An `enum stiction_model` as it comes from C, which may be any number.
pub type ModelNumber = u32;

/// `stiction_joint_row`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct JointRow {
    /// The row over the velocities.
    pub row: [Real; N],
    /// What is added to its velocity, m/s or rad/s.
    pub offset: Real,
    /// Its law.
    pub law: LawNumber,
    /// The least impulse of a box, N s or N m s.
    pub lower: Real,
    /// The largest one.
    pub upper: Real,
    /// Its compliance.
    pub compliance: Real,
    /// Which row it is.
    pub key: u32,
}

impl JointRow {
    /// The row for a scene.
    pub(super) fn read(&self) -> Result<stiction::JointRow<Real, N>, Refusal> {
        Ok(stiction::JointRow {
            row: SVector::from(self.row),
            offset: self.offset,
            law: Self::law(self.law, self.lower, self.upper)?,
            compliance: self.compliance,
            key: self.key,
        })
    }

    /// A law for a scene.
    pub(super) fn law(number: LawNumber, lower: Real, upper: Real) -> Result<RowLaw<Real>, Refusal> {
        const LIMIT: u32 = Law::Limit as u32;
        const EQUALITY: u32 = Law::Equality as u32;
        const BOX: u32 = Law::Box as u32;
        match number {
            LIMIT => Ok(RowLaw::Limit),
            EQUALITY => Ok(RowLaw::Equality),
            BOX => Ok(RowLaw::Box { lower, upper }),
            _ => Err(Refusal::Law),
        }
    }
}

/// `stiction_contact_impulse`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ContactImpulse {
    /// Key of the contact.
    pub key: u32,
    /// Its impulse, N s.
    pub impulse: [Real; D],
}

/// `stiction_row_impulse`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RowImpulse {
    /// Key of the joint row.
    pub key: u32,
    /// Its impulse, N s or N m s.
    pub impulse: Real,
}
