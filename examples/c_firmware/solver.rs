//! What lives in the caller's memory.

use super::given::{ContactImpulse, JointRow, ModelNumber, RowImpulse};
use super::header::{BYTES, C, D, L, N, PHASES, Phases, R, Real, S, ending};
use super::status::{self, Culprit, Status};
use core::fmt::{self, Write};
use core::mem::{align_of, size_of};
use stiction::heapless::Vec;
use stiction::nalgebra::SVector;
use stiction::{Contact, Error, List, Model, Scene, Settings};

/// The kernel of the sizes in `stiction_sizes.h`.
pub type Kernel = stiction::Kernel<Real, N, D, C, R, S, Phases>;
/// The same in `float`, for which the time of a call is bounded.
pub type FloatKernel = stiction::Kernel<f32, N, D, C, R, S, Phases>;
pub(super) type Outcome = stiction::Solution<Real, N, D, C, R>;
type Solve = for<'a> fn(&'a mut Kernel, &SVector<Real, N>, &Settings<Real>) -> Result<&'a Outcome, Error>;
type SolveWithLimits = for<'a> fn(
    &'a mut Kernel,
    &[stiction::JointRow<Real, N>],
    &SVector<Real, N>,
    &Settings<Real>,
) -> Result<&'a Outcome, Error>;

/// What `stiction` is inside.
#[repr(C)]
pub struct Solver {
    /// [`Self::READY`] after `stiction_init`.
    ready: u32,
    /// The law of contacts that solves obey.
    model: Model,
    /// Speed up to which a contact counts as one that sticks.
    still: Real,
    /// The last error.
    pub(super) error: Option<Refusal>,
    pub(super) kernel: Kernel,
}

const _: () = assert!(align_of::<Solver>() <= align_of::<u64>());
// Not too few, and not many more than are used: the same number has to do for pointers of 32 and of 64 bits.
const _: () = assert!(size_of::<Solver>() <= Solver::ROOM && BYTES <= Solver::MOST, "{}", {
    const WRITE: [u8; 60] =
        ending(*b"write into stiction_sizes.h: #define STICTION_BYTES         ", size_of::<Solver>());
    match core::str::from_utf8(&WRITE) {
        Ok(text) => text,
        Err(_) => "STICTION_BYTES is not what a stiction takes",
    }
});

impl Solver {
    const READY: u32 = 0x57_1C_71_04;
    /// The size of a `stiction` in C.
    pub(super) const ROOM: usize = BYTES.next_multiple_of(8);
    /// The largest `STICTION_BYTES`.
    const MOST: usize = size_of::<Self>() + size_of::<Self>().div_ceil(4) + 128;

    /// Makes memory a solver: its fields one by one, and the kernel as a constant of zeros, so that none of it passes
    /// over the stack.
    ///
    /// # Safety
    /// The memory is a `stiction`, which nothing else uses.
    pub(super) unsafe fn init(memory: *mut Self) {
        // SAFETY: the caller's promise.
        unsafe {
            (&raw mut (*memory).kernel).write(const { Kernel::with_phases(PHASES) });
            (&raw mut (*memory).model).write(Model::Coulomb);
            (&raw mut (*memory).still).write(0.0);
            (&raw mut (*memory).error).write(None);
            (&raw mut (*memory).ready).write(Self::READY);
        }
    }

    /// Says what is wrong with a pointer, if something is.
    ///
    /// # Safety
    /// The pointer is null, or points to a `stiction`.
    pub(super) unsafe fn check(memory: *const Self) -> Result<(), Status> {
        if memory.is_null() {
            return Err(Status::Null);
        }
        // SAFETY: the caller's promise; before `stiction_init` the memory is some number as well.
        let ready = unsafe { (&raw const (*memory).ready).read() };
        if ready == Self::READY { Ok(()) } else { Err(Status::NotInitialised) }
    }

    /// Chooses the law of contacts.
    pub(super) fn set_model(&mut self, number: ModelNumber) -> Status {
        const COULOMB: u32 = status::Model::Coulomb as u32;
        const RELAXATION: u32 = status::Model::ConvexRelaxation as u32;
        self.model = match number {
            COULOMB => Model::Coulomb,
            RELAXATION => Model::ConvexRelaxation,
            _ => return self.refuse(Refusal::Model),
        };
        Status::Ok
    }

    /// Chooses the speed up to which a contact counts as one that sticks; a solve refuses what is none.
    pub(super) const fn set_still(&mut self, speed: Real) {
        self.still = speed;
    }

    /// Settings of a call.
    pub(super) const fn settings(&self, tolerance: Real, budget: usize) -> Settings<Real> {
        Settings { tolerance, budget, model: self.model, still: self.still }
    }

    /// Changes the scene, and remembers what was wrong with that.
    pub(super) fn change(
        &mut self,
        change: impl FnOnce(&mut Scene<Real, N, D, C, R, S>) -> Result<(), Error>,
    ) -> Status {
        let result = change(self.kernel.scene_mut());
        self.end(result)
    }

    /// Adds a contact with one friction coefficient.
    pub(super) fn push(&mut self, contact: &Contact<Real, N, D>) -> Status {
        self.change(|scene| <OneCoefficient<{ D <= 3 }>>::push(scene, contact).map(|_| ()))
    }

    /// Starts the next solve at these impulses, and remembers what was wrong with that.
    pub(super) fn set_impulses(&mut self, contacts: &[ContactImpulse], rows: &[RowImpulse]) -> Status {
        let full = |list, capacity| Error::ListFull { list, capacity };
        let mut of_contacts = [(0, SVector::zeros()); C];
        let mut of_rows = [(0, 0.0); R];
        for (place, given) in of_contacts.iter_mut().zip(contacts) {
            *place = (given.key, SVector::from(given.impulse));
        }
        for (place, given) in of_rows.iter_mut().zip(rows) {
            *place = (given.key, given.impulse);
        }
        let contacts = of_contacts.get(..contacts.len());
        let rows = of_rows.get(..rows.len());
        let result = match (contacts, rows) {
            (None, _) => Err(full(List::InitialImpulses, C)),
            (_, None) => Err(full(List::InitialRowImpulses, R)),
            (Some(contacts), Some(rows)) => self.kernel.solver_mut().set_impulses(contacts, rows),
        };
        self.end(result)
    }

    /// Solves, goes on or advances, and remembers what was wrong with that. (A function by its pointer: there is one copy of this.)
    pub(super) fn solve(
        &mut self,
        solve: Solve,
        free_impulse: &[Real; N],
        tolerance: Real,
        budget: usize,
    ) -> Status {
        let settings = self.settings(tolerance, budget);
        match solve(&mut self.kernel, &SVector::from(*free_impulse), &settings) {
            Ok(solution) => solution.status.into(),
            Err(error) => self.refuse(Refusal::Error(error)),
        }
    }

    /// The same with limits.
    pub(super) fn solve_with_limits(
        &mut self,
        solve: SolveWithLimits,
        limits: &[JointRow],
        free_impulse: &[Real; N],
        (tolerance, budget): (Real, usize),
    ) -> Status {
        let settings = self.settings(tolerance, budget);
        let free_impulse = SVector::from(*free_impulse);
        let solve = |limits: Vec<_, L>| {
            let solution = solve(&mut self.kernel, &limits, &free_impulse, &settings);
            Ok(solution.map_err(Refusal::Error)?.status.into())
        };
        let result = limits_of(limits).and_then(solve);
        result.unwrap_or_else(|refusal| self.refuse(refusal))
    }

    fn end(&mut self, result: Result<(), Error>) -> Status {
        result.map_or_else(|error| self.refuse(Refusal::Error(error)), |()| Status::Ok)
    }

    /// Remembers what is wrong with a call, and says it.
    pub(super) fn refuse(&mut self, refusal: Refusal) -> Status {
        self.error = Some(refusal);
        match refusal {
            Refusal::Error(error) => error.into(),
            Refusal::Law => Status::InvalidLaw,
            Refusal::Model => Status::InvalidModel,
            Refusal::Limits => Status::LimitListFull,
        }
    }

    /// The last error in words, cut to fit, in a text of zeros of which the last stays.
    pub(super) fn describe(&self, text: &mut [u8]) {
        let room = text.len().saturating_sub(1);
        let mut text = Text(text.get_mut(..room).unwrap_or_default());
        // It fails where it is cut.
        let _ = match self.error {
            Some(error) => write!(text, "{error}"),
            None => write!(text, "no error"),
        };
    }
}

/// Works on a solve, whose solution is unsolved until it has ended.
pub(super) fn advance<'a>(
    kernel: &'a mut Kernel,
    free_impulse: &SVector<Real, N>,
    settings: &Settings<Real>,
) -> Result<&'a Outcome, Error> {
    kernel.advance(free_impulse, settings)?;
    Ok(kernel.solution())
}

/// The same with limits.
pub(super) fn advance_with_limits<'a>(
    kernel: &'a mut Kernel,
    limits: &[stiction::JointRow<Real, N>],
    free_impulse: &SVector<Real, N>,
    settings: &Settings<Real>,
) -> Result<&'a Outcome, Error> {
    kernel.advance_with_limits(limits, free_impulse, settings)?;
    Ok(kernel.solution())
}

/// Limits in the form of the library.
fn limits_of(limits: &[JointRow]) -> Result<Vec<stiction::JointRow<Real, N>, L>, Refusal> {
    let mut rows = Vec::new();
    for limit in limits {
        rows.push(limit.read()?).map_err(|_| Refusal::Limits)?;
    }
    Ok(rows)
}

/// What was wrong with a call.
#[derive(Clone, Copy)]
pub(super) enum Refusal {
    /// What the library says of it.
    Error(Error),
    /// A number that is no `enum stiction_law`.
    Law,
    /// A number that is no `enum stiction_model`.
    Model,
    /// More limits than there is room for.
    Limits,
}

impl Refusal {
    /// What it was about.
    pub(super) fn culprit(self) -> Culprit {
        match self {
            Self::Error(error) => error.into(),
            Self::Law | Self::Model => Culprit::NONE,
            Self::Limits => Culprit::limit(L),
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Error(error) => write!(f, "{error}"),
            Self::Law => write!(f, "a number that is no law of a joint row"),
            Self::Model => write!(f, "a number that is no law of contacts"),
            Self::Limits => write!(f, "limits are full (room for {L})"),
        }
    }
}

/// Adds a contact with one friction coefficient, as far as that has a meaning: are the rows behind the normal `TANGENTS` alone?
struct OneCoefficient<const TANGENTS: bool>;

/// What stands behind [`OneCoefficient`]. The number of rows is a parameter, so that what cannot be is not compiled.
trait Push {
    fn push<const ROWS: usize>(
        scene: &mut Scene<Real, N, ROWS, C, R, S>,
        contact: &Contact<Real, N, ROWS>,
    ) -> Result<usize, Error>;
}

impl Push for OneCoefficient<true> {
    fn push<const ROWS: usize>(
        scene: &mut Scene<Real, N, ROWS, C, R, S>,
        contact: &Contact<Real, N, ROWS>,
    ) -> Result<usize, Error> {
        scene.push(contact)
    }
}

impl Push for OneCoefficient<false> {
    /// `stiction.h` declares no such call then: spin and roll have lengths. Whoever calls it gets a contact that has none.
    fn push<const ROWS: usize>(
        scene: &mut Scene<Real, N, ROWS, C, R, S>,
        contact: &Contact<Real, N, ROWS>,
    ) -> Result<usize, Error> {
        scene.push_on(contact, &stiction::Surface::isotropic(contact.mu))
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
        if fits < words.len() { Err(fmt::Error) } else { Ok(()) }
    }
}
