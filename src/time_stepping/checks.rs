//! Checks of the arguments of the helpers.

use crate::error::Error;
use crate::parameter::Parameter;
use crate::real::Real;

impl Parameter {
    /// The error that names this parameter.
    pub(super) const fn error(self) -> Error {
        Error::InvalidParameter { parameter: self }
    }

    /// The number, if it fulfils the requirement.
    fn checked<T>(self, number: T, fulfils: bool) -> Result<T, Error> {
        if fulfils { Ok(number) } else { Err(self.error()) }
    }

    /// The number, if it is finite.
    pub(super) fn finite<T: Real>(self, number: T) -> Result<T, Error> {
        self.checked(number, number.is_finite())
    }

    /// The number, if it is finite and positive.
    pub(super) fn positive<T: Real>(self, number: T) -> Result<T, Error> {
        self.checked(number, number.is_finite() && number > T::ZERO)
    }

    /// The number, if it is positive; it may be infinite.
    pub(super) fn positive_or_infinite<T: Real>(self, number: T) -> Result<T, Error> {
        self.checked(number, number > T::ZERO)
    }

    /// The number, if it is finite and not negative.
    pub(super) fn not_negative<T: Real>(self, number: T) -> Result<T, Error> {
        self.checked(number, number.is_finite() && number >= T::ZERO)
    }

    /// The number, if it is a distance: finite, or infinitely far.
    pub(super) fn distance<T: Real>(self, number: T) -> Result<T, Error> {
        self.checked(number, number.is_finite() || number > T::ZERO)
    }

    /// The number, if it is not negative; it may be infinite.
    pub(super) fn bound<T: Real>(self, number: T) -> Result<T, Error> {
        self.checked(number, number >= T::ZERO)
    }

    /// The number, if it is from 0 to 1.
    pub(super) fn share<T: Real>(self, number: T) -> Result<T, Error> {
        self.checked(number, number >= T::ZERO && number <= T::ONE)
    }
}
