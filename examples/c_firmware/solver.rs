//! What lives in the caller's memory, and what is copied out of it.

use crate::header::{ending, size};
use crate::status::{Mode, Status};
use crate::{C, D, N, Real};
use core::fmt::{self, Write};
use core::mem::{align_of, size_of};
use stiction::nalgebra::SVector;
use stiction::{Error, Scene, Settings};

/// The kernel of the sizes in `stiction_sizes.h`.
pub type Kernel = stiction::Kernel<Real, N, D, C>;
type Outcome = stiction::Solution<Real, N, D, C>;
type Solve =
    for<'a> fn(&'a mut Kernel, &SVector<Real, N>, &Settings<Real>) -> Result<&'a Outcome, Error>;

/// What `stiction` is inside.
#[repr(C)]
pub struct Solver {
    /// [`Self::READY`] after `stiction_init`.
    ready: u32,
    /// The last error.
    pub(crate) error: Option<Error>,
    pub(crate) kernel: Kernel,
}

/// Bytes of one `stiction`.
pub const BYTES: usize = size("STICTION_BYTES");
const _: () = assert!(align_of::<Solver>() <= align_of::<u64>());
const _: () = assert!(size_of::<Solver>() <= BYTES.next_multiple_of(8), "{}", {
    const WRITE: [u8; 60] = ending(
        *b"write into stiction_sizes.h: #define STICTION_BYTES         ",
        size_of::<Solver>(),
    );
    match core::str::from_utf8(&WRITE) {
        Ok(text) => text,
        Err(_) => "STICTION_BYTES is too small",
    }
});

impl Solver {
    const READY: u32 = 0x57_1C_71_04;

    /// Makes memory a solver: its fields one by one, and the kernel as a constant of zeros, so that none of it passes
    /// over the stack.
    ///
    /// # Safety
    /// The memory is a `stiction`, which nothing else uses.
    pub(crate) unsafe fn init(memory: *mut Self) {
        // SAFETY: the caller's promise.
        unsafe {
            (&raw mut (*memory).kernel).write(const { Kernel::new() });
            (&raw mut (*memory).error).write(None);
            (&raw mut (*memory).ready).write(Self::READY);
        }
    }

    /// Says what is wrong with a pointer, if something is.
    ///
    /// # Safety
    /// The pointer is null, or points to a `stiction`.
    pub(crate) unsafe fn check(memory: *const Self) -> Result<(), Status> {
        if memory.is_null() {
            return Err(Status::Null);
        }
        // SAFETY: the caller's promise; before `stiction_init` the memory is some number as well.
        let ready = unsafe { (&raw const (*memory).ready).read() };
        if ready == Self::READY {
            Ok(())
        } else {
            Err(Status::NotInitialised)
        }
    }

    /// Changes the scene, and remembers what was wrong with that.
    pub(crate) fn change(
        &mut self,
        change: impl FnOnce(&mut Scene<Real, N, D, C>) -> Result<(), Error>,
    ) -> Status {
        let result = change(self.kernel.scene_mut());
        result.map_or_else(|error| self.refuse(error), |()| Status::Solved)
    }

    /// Solves or goes on, and remembers what was wrong with that.
    pub(crate) fn solve(
        &mut self,
        solve: Solve,
        free_impulse: &[Real; N],
        tolerance: Real,
        budget: usize,
    ) -> Status {
        let settings = Settings {
            budget,
            ..Settings::new(tolerance)
        };
        match solve(&mut self.kernel, &SVector::from(*free_impulse), &settings) {
            Ok(solution) => solution.status.into(),
            Err(error) => self.refuse(error),
        }
    }

    fn refuse(&mut self, error: Error) -> Status {
        self.error = Some(error);
        error.into()
    }

    /// The last error in words, cut to fit, in a text of zeros of which the last stays.
    pub(crate) fn describe(&self, text: &mut [u8]) {
        let room = text.len().saturating_sub(1);
        let mut text = Text(text.get_mut(..room).unwrap_or_default());
        // It fails where it is cut.
        let _ = match self.error {
            Some(error) => write!(text, "{error}"),
            None => write!(text, "no error"),
        };
    }
}

/// The room left in a text.
struct Text<'a>(&'a mut [u8]);

impl Write for Text<'_> {
    fn write_str(&mut self, words: &str) -> fmt::Result {
        let mut fits = self.0.len().min(words.len());
        while !words.is_char_boundary(fits) {
            fits -= 1;
        }
        let room = core::mem::take(&mut self.0);
        let Some((place, rest)) = room.split_at_mut_checked(fits) else {
            return Err(fmt::Error);
        };
        for (place, byte) in place.iter_mut().zip(words.as_bytes()) {
            *place = *byte; // `copy_from_slice` would link a panic
        }
        self.0 = rest;
        if fits < words.len() {
            Err(fmt::Error)
        } else {
            Ok(())
        }
    }
}

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
    pub certificate: Real,
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
}

impl Solution {
    pub(crate) fn of(solution: &Outcome) -> Self {
        let none = ContactOutcome {
            key: 0,
            mode: Mode::Open,
            impulse: [0.0; D],
            velocity: [0.0; D],
            certificate: 0.0,
        };
        let mut contacts = [none; C];
        for (i, (place, contact)) in contacts.iter_mut().zip(&solution.contacts).enumerate() {
            *place = ContactOutcome {
                key: contact.key,
                mode: contact.mode.into(),
                impulse: contact.impulse.into(),
                velocity: contact.velocity.into(),
                certificate: solution.certificate.get(i).copied().unwrap_or(0.0),
            };
        }
        let number = |x: usize| u32::try_from(x).unwrap_or(u32::MAX);
        Self {
            status: solution.status.into(),
            work: number(solution.work.total()),
            count: number(solution.contacts.len()),
            error: solution.error,
            velocity: solution.velocity.into(),
            contacts,
        }
    }
}
