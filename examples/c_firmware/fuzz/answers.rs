//! What C is told, beside what Rust is told, and beside what a stranger says of it.

use crate::c;
use crate::c::{C, ContactOutcome, Culprit, Mode, N, R, Real, RowMode, RowOutcome};
use crate::c::{Solution, Status, Violation};
use crate::machine::Machine;
use crate::scene::is_measurable;
use nalgebra::SVector;
use std::ffi::CStr;
use std::mem::MaybeUninit;
use testbed::mixed_measure;

impl Machine {
    /// What a call of C writes, or how else it ends.
    fn told<T>(&mut self, call: impl FnOnce(*const c::Solver, *mut T) -> Status) -> Result<T, Status> {
        let mut told = MaybeUninit::uninit();
        match call(self.memory.solver(), told.as_mut_ptr()) {
            // SAFETY: what was told is whole.
            Status::Ok => Ok(unsafe { told.assume_init() }),
            status => Err(status),
        }
    }

    /// What C reads.
    fn read(&mut self) -> Solution {
        // SAFETY: both pointers are good.
        let read = self.told(|s, to| unsafe { c::stiction_read(s, to) });
        read.expect("it is there")
    }

    /// What the stranger of `testbed` says of what C reads.
    pub(crate) fn is_true(&mut self, push: &SVector<Real, N>, tolerance: Real) {
        let read = self.read();
        let contacts = &read.contacts[..read.count as usize];
        let rows = &read.rows[..read.row_count.first().map_or(0, |&count| count as usize)];
        let impulses: Vec<f64> = contacts.iter().flat_map(|c| doubles(&c.impulse)).collect();
        let of_rows: Vec<f64> = rows.iter().flat_map(|row| doubles(&[row.impulse])).collect();
        let velocity = doubles(&read.velocity);
        let others = contacts.iter().flat_map(|c| doubles(&c.velocity));
        let others = others.chain(rows.iter().flat_map(|row| doubles(&[row.velocity])));
        let numbers = impulses.iter().chain(&of_rows).chain(&velocity);
        let is_finite = numbers.copied().chain(others).all(f64::is_finite);
        assert!(!read.error.is_nan());
        assert!(read.status != Status::Solved || is_finite && read.error <= tolerance);
        let file = self.surfaces.file(self.mirror.scene(), push);
        if is_measurable(&file) {
            assert!(is_finite);
            let error = mixed_measure::error(&file, &velocity[..file.n_dof], &impulses, &of_rows);
            let allowed = double(tolerance);
            assert!(read.status != Status::Solved || error <= allowed, "{error:e}");
            if read.status == Status::Infeasible && Real::EPSILON < 1e-10 {
                let normals: Vec<f64> = contacts.iter().map(|c| double(c.certificate[0])).collect();
                let joints: Vec<f64> = rows.iter().map(|row| double(row.certificate)).collect();
                assert!(mixed_measure::proves(&file, &normals, &joints), "a proof that is none");
            }
        }
    }

    /// What C says of the last solution and the last error, beside what Rust says.
    pub(crate) fn explain(&mut self) {
        let read = self.read();
        let solution = self.mirror.solution();
        assert_eq!(read.status, solution.status.into());
        assert_eq!(read.work as usize, solution.work.total());
        assert_eq!(read.count as usize, solution.contacts.len());
        let count = read.row_count.first();
        assert!(count.is_none_or(|&count| count as usize == solution.rows.len()));
        assert_eq!(read.error.to_bits(), solution.error.to_bits());
        assert!(same(&read.velocity, solution.velocity.as_slice()));
        self.explain_contacts(&read);
        self.explain_rows(&read);
        let worst = self.mirror.violation();
        // SAFETY: both pointers are good.
        let told: Violation =
            self.told(|s, to| unsafe { c::stiction_worst_violation(s, to) }).expect("it is there");
        let told = [
            told.closing_speed,
            told.opening_impulse,
            told.outside_cone,
            told.creep,
            told.missing_friction,
            told.row_speed,
            told.row_impulse,
        ];
        let worst = [
            worst.closing_speed,
            worst.opening_impulse,
            worst.outside_cone,
            worst.creep,
            worst.missing_friction,
            worst.row_speed,
            worst.row_impulse,
        ];
        assert!(same(&told, &worst));
        self.explain_error();
    }

    /// The contacts in a list, one by one, and by their keys.
    fn explain_contacts(&mut self, read: &Solution) {
        let solution = self.mirror.solution().clone();
        let is = |told: &ContactOutcome, i: usize| {
            let contact = &solution.contacts[i];
            let proof = solution.certificate.get(i).copied().unwrap_or_default();
            (told.key, told.mode) == (contact.key, Mode::from(contact.mode))
                && same(&told.impulse, contact.impulse.as_slice())
                && same(&told.velocity, contact.velocity.as_slice())
                && same(&told.certificate, proof.as_slice())
        };
        for i in 0..C + 2 {
            // SAFETY: both pointers are good.
            let told = self.told(|s, to| unsafe { c::stiction_contact_at(s, i as u32, to) });
            if i < solution.contacts.len() {
                assert!(is(&read.contacts[i], i) && is(&told.expect("it is there"), i));
            } else {
                assert_eq!(told.err(), Some(Status::NoSuchContact));
                assert!(read.contacts.get(i).is_none_or(|none| none.key == 0));
            }
        }
        for key in [0, 1, 2, 3, 4, u32::MAX] {
            // SAFETY: both pointers are good.
            let told = self.told(|s, to| unsafe { c::stiction_contact_by_key(s, key, to) });
            match solution.contacts.iter().position(|c| c.key == key) {
                Some(i) => assert!(is(&told.expect("it is there"), i)),
                None => assert_eq!(told.err(), Some(Status::NoSuchKey)),
            }
            // SAFETY: the pointer is good.
            let index = unsafe { c::stiction_contact_index(self.memory.solver(), key) };
            assert_eq!(index, place(self.mirror.scene().contact_index(key)));
        }
    }

    /// The joint rows in a list, one by one, and by their keys.
    fn explain_rows(&mut self, read: &Solution) {
        let solution = self.mirror.solution().clone();
        let is = |told: &RowOutcome, i: usize| {
            let row = &solution.rows[i];
            let proof = solution.row_certificate.get(i).copied().unwrap_or(0.0);
            (told.key, told.mode) == (row.key, RowMode::from(row.mode))
                && same(&[told.impulse, told.velocity, told.certificate], &[row.impulse, row.velocity, proof])
        };
        for i in 0..R + 2 {
            // SAFETY: both pointers are good.
            let told = self.told(|s, to| unsafe { c::stiction_row_at(s, i as u32, to) });
            if i < solution.rows.len() {
                assert!(is(&read.rows[i], i) && is(&told.expect("it is there"), i));
            } else {
                assert_eq!(told.err(), Some(Status::NoSuchRow));
                assert!(read.rows.get(i).is_none_or(|none| none.key == 0));
            }
        }
        for key in [0, 1, 2, 3, 4, u32::MAX] {
            // SAFETY: both pointers are good.
            let told = self.told(|s, to| unsafe { c::stiction_row_by_key(s, key, to) });
            match solution.rows.iter().position(|row| row.key == key) {
                Some(i) => assert!(is(&told.expect("it is there"), i)),
                None => assert_eq!(told.err(), Some(Status::NoSuchKey)),
            }
            // SAFETY: the pointer is good.
            let index = unsafe { c::stiction_row_index(self.memory.solver(), key) };
            assert_eq!(index, place(self.mirror.scene().row_index(key)));
        }
    }

    /// What may be used, and the last error.
    fn explain_error(&mut self) {
        let solution = self.mirror.solution();
        let solver = self.memory.solver();
        for error in [0.0, 1e-2, 1.0, Real::NAN, Real::INFINITY] {
            // SAFETY: the pointer is good.
            let usable = unsafe { c::stiction_is_usable(solver, error) };
            assert_eq!(usable, solution.is_usable(error));
        }
        let mut text = [1_u8; 64];
        for bytes in [0, 1, 2, 11] {
            // SAFETY: pointers are good.
            let status = unsafe { c::stiction_describe(solver, text.as_mut_ptr().cast(), bytes) };
            assert_eq!(status, Status::Ok);
            assert!(text[bytes..].iter().all(|&byte| byte == 1), "it writes beyond {bytes} bytes");
            assert!(bytes == 0 || text[bytes - 1] == 0);
            text = [1; 64];
        }
        // SAFETY: pointers are good.
        let culprit = unsafe {
            let mut culprit = Culprit { row: 99, ..Culprit::NONE };
            assert_eq!(c::stiction_last_culprit(solver, &raw mut culprit), Status::Ok);
            let status = c::stiction_describe(solver, text.as_mut_ptr().cast(), text.len());
            assert_eq!(status, Status::Ok);
            culprit
        };
        let other = if self.no_law { "a number that is no law of a joint row" } else { "no error" };
        let words = self.error.map_or(other.to_owned(), |error| error.to_string());
        let text = CStr::from_bytes_until_nul(&text).expect("it ends");
        let text = text.to_str().expect("whole characters");
        assert!(words.starts_with(text) && text.len() >= words.len().min(60));
        assert_eq!(culprit, self.error.map_or(Culprit::NONE, Culprit::from));
    }
}

fn double(x: Real) -> f64 {
    nalgebra::try_convert(x).unwrap_or(f64::NAN)
}

fn doubles(x: &[Real]) -> Vec<f64> {
    x.iter().map(|x| double(*x)).collect()
}

/// An index as C is told it.
fn place(index: Option<usize>) -> i32 {
    index.map_or(Status::NoSuchKey as i32, |index| i32::try_from(index).expect("a few"))
}

/// The same bits?
fn same(x: &[Real], y: &[Real]) -> bool {
    let bits = |x: &[Real]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    bits(x) == bits(y)
}
