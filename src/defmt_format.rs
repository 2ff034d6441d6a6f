//! `defmt::Format` for what a derive does not reach: nalgebra's vectors have none.

use crate::real::Real;
use crate::solution::{ContactSolution, Solution};
use defmt::{Format, Formatter, write};

impl<T: Format, const D: usize> Format for ContactSolution<T, D> {
    fn format(&self, fmt: Formatter<'_>) {
        let (impulse, velocity) = (self.impulse.data.as_slice(), self.velocity.data.as_slice());
        let (key, mode) = (self.key, self.mode);
        write!(fmt, "{}: {} r = {}, u = {}", key, mode, impulse, velocity);
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
