//! `defmt::Format` for what a derive does not reach: nalgebra's vectors have none.

use crate::real::Real;
use crate::scene::{Contact, JointRow};
use crate::solution::{ContactSolution, Solution};
use defmt::{Format, Formatter, write};

impl<T: Format, const D: usize> Format for ContactSolution<T, D> {
    fn format(&self, fmt: Formatter<'_>) {
        let (impulse, velocity) = (self.impulse.data.as_slice(), self.velocity.data.as_slice());
        let (key, mode) = (self.key, self.mode);
        write!(fmt, "{}: {} r = {}, u = {}", key, mode, impulse, velocity);
    }
}

impl<T: Format, const N: usize, const D: usize> Format for Contact<T, N, D> {
    fn format(&self, fmt: Formatter<'_>) {
        let (columns, offset) = (self.jacobian.data.as_slice(), self.offset.data.as_slice());
        let (key, mu) = (self.key, &self.mu);
        write!(fmt, "{}: H {} by columns, w = {}, mu = {}", key, columns, offset, mu);
    }
}

impl<T: Format, const N: usize> Format for JointRow<T, N> {
    fn format(&self, fmt: Formatter<'_>) {
        let (row, offset, law) = (self.row.data.as_slice(), &self.offset, &self.law);
        let (key, compliance) = (self.key, &self.compliance);
        write!(fmt, "{}: {} on {}, offset {}, R = {}", key, law, row, offset, compliance);
    }
}

impl<T: Real + Format, const N: usize, const D: usize, const C: usize, const R: usize> Format
    for Solution<T, N, D, C, R>
{
    fn format(&self, fmt: Formatter<'_>) {
        let certificate = self.certificate.iter();
        let certificate: heapless::Vec<_, C> = certificate.map(|d| d.data.as_slice()).collect();
        write!(
            fmt,
            "{}: error {}, {}, v = {}, contacts {}, rows {}, certificate {} {}",
            self.status,
            self.error,
            self.work,
            self.velocity.data.as_slice(),
            self.contacts.as_slice(),
            self.rows.as_slice(),
            certificate.as_slice(),
            self.row_certificate.as_slice()
        );
    }
}
