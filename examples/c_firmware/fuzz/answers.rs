//! What C is told, beside what Rust is told, and beside what a stranger says of it.

use crate::cases::is_tame;
use crate::machine::Machine;
use c_firmware as c;
use c_firmware::{Culprit, Mode, N, Real, Solution, Status};
use nalgebra::SVector;
use std::ffi::CStr;
use std::mem::MaybeUninit;
use testbed::measure;
use testbed::scene_file::SceneFile;

impl Machine {
    /// What C reads.
    fn read(&mut self) -> Solution {
        let mut solution = MaybeUninit::uninit();
        // SAFETY: both pointers are good, and a solution that was read is whole.
        unsafe {
            let status = c::stiction_read(self.memory.solver(), solution.as_mut_ptr());
            assert_eq!(status, Status::Solved);
            solution.assume_init()
        }
    }

    /// What the stranger of `testbed` says of what C reads.
    pub(crate) fn is_true(&mut self, push: &SVector<Real, N>, tolerance: Real) {
        let read = self.read();
        let numbers = read
            .contacts
            .iter()
            .flat_map(|c| c.impulse.iter().chain(&c.velocity));
        let is_finite = numbers.chain(&read.velocity).all(|x| x.is_finite());
        assert!(!read.error.is_nan());
        assert!(read.status != Status::Solved || is_finite && read.error <= tolerance);
        let (scene, solution) = (self.mirror.scene(), self.mirror.solution());
        let file = SceneFile::of(scene, push);
        let vectors = file.f.iter().chain(&file.w).chain(&file.mu);
        let all = file.mass.iter().chain(&file.h).chain(vectors);
        if is_tame::<Real>(all) && file.mass.clone().cholesky().is_some() {
            assert!(is_finite);
            let error = measure::error_of(scene, push, solution, measure::Law::Coulomb);
            let allowed = f64::from(tolerance);
            assert!(
                read.status != Status::Solved || error <= allowed,
                "{error:e}"
            );
        }
    }

    /// What C says of the last solution and the last error, beside what Rust says.
    pub(crate) fn explain(&mut self) {
        let (read, solution) = (self.read(), self.mirror.solution());
        assert_eq!(read.status, solution.status.into());
        assert_eq!(read.work as usize, solution.work.total());
        assert_eq!(read.count as usize, solution.contacts.len());
        assert_eq!(read.error.to_bits(), solution.error.to_bits());
        assert_eq!(read.velocity.map(Real::to_bits), bits(&solution.velocity));
        for (i, contact) in solution.contacts.iter().enumerate() {
            let read = &read.contacts[i];
            assert_eq!(
                (read.key, read.mode),
                (contact.key, Mode::from(contact.mode))
            );
            assert_eq!(read.impulse.map(Real::to_bits), bits(&contact.impulse));
            assert_eq!(read.velocity.map(Real::to_bits), bits(&contact.velocity));
            let proof = solution.certificate.get(i).map_or(0, |x| x.to_bits());
            assert_eq!(read.certificate.to_bits(), proof);
        }
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
            assert_eq!(status, Status::Solved);
            assert!(
                text[bytes..].iter().all(|&byte| byte == 1),
                "it writes beyond {bytes} bytes"
            );
            assert!(bytes == 0 || text[bytes - 1] == 0);
            text = [1; 64];
        }
        // SAFETY: pointers are good.
        let culprit = unsafe {
            let mut culprit = Culprit {
                row: 99,
                ..Culprit::NONE
            };
            assert_eq!(
                c::stiction_last_culprit(solver, &raw mut culprit),
                Status::Solved
            );
            let status = c::stiction_describe(solver, text.as_mut_ptr().cast(), text.len());
            assert_eq!(status, Status::Solved);
            culprit
        };
        let words = self
            .error
            .map_or("no error".to_owned(), |error| error.to_string());
        let text = CStr::from_bytes_until_nul(&text).expect("it ends");
        let text = text.to_str().expect("whole characters");
        assert!(words.starts_with(text) && text.len() >= words.len().min(60));
        assert_eq!(culprit, self.error.map_or(Culprit::NONE, Culprit::from));
    }
}

fn bits<const K: usize>(x: &SVector<Real, K>) -> [u32; K] {
    core::array::from_fn(|i| x[i].to_bits())
}
