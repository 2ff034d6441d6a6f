//! A `stiction` of C, and a kernel in Rust that is given the same.

use crate::cases::is_tame;
use crate::pointers::{Fault, Memory};
use crate::steps::{Budget, Step};
use c_firmware as c;
use c_firmware::{C, Culprit, D, Mode, N, Real, Solution, Status};
use nalgebra::{SMatrix, SVector};
use std::ffi::CStr;
use std::mem::{MaybeUninit, zeroed};
use std::ptr::{null, null_mut};
use stiction::{Contact, Error, Kernel, Settings};
use testbed::measure;
use testbed::scene_file::SceneFile;

fn number(x: f64) -> Real {
    stiction::Real::literal(x)
}

fn at(numbers: &[f64], i: usize) -> Real {
    number(numbers[i % numbers.len()])
}

fn vector<const K: usize>(numbers: &[f64]) -> SVector<Real, K> {
    SVector::from_fn(|i, _| at(numbers, i))
}

/// A matrix row by row, as C has it.
fn rows<const K: usize>(matrix: &SMatrix<Real, K, N>) -> [[Real; N]; K] {
    matrix.transpose().into()
}

pub(crate) struct Machine {
    memory: Box<Memory>,
    raw: Box<Memory>,
    mirror: Box<Kernel<Real, N, D, C>>,
    error: Option<Error>,
    /// Free impulse and tolerance of a solve that can be resumed.
    paused: Option<(SVector<Real, N>, Real)>,
}

impl Machine {
    pub(crate) fn new() -> Self {
        let mut machine = Self {
            memory: Memory::new(),
            raw: Memory::new(),
            mirror: Box::new(Kernel::new()),
            error: None,
            paused: None,
        };
        machine.init();
        machine
    }

    fn init(&mut self) {
        // SAFETY: the memory is as large as C declares it.
        let status = unsafe { c::stiction_init(self.memory.solver()) };
        assert_eq!(status, Status::Solved);
        *self.mirror = Kernel::new();
        (self.error, self.paused) = (None, None);
    }

    /// Calls C and, if all pointers are good, Rust, and compares what they return.
    fn both(
        &mut self,
        fault: Fault,
        pointers: u8,
        in_c: impl FnOnce(*mut c::Solver) -> Status,
        in_rust: impl FnOnce(&mut Kernel<Real, N, D, C>) -> Result<Status, Error>,
    ) -> bool {
        let solver = match fault {
            Fault::NullSolver => null_mut(),
            Fault::Raw => self.raw.solver(),
            _ => self.memory.solver(),
        };
        let status = in_c(solver);
        let refused = match fault {
            Fault::NullSolver => Some(Status::Null),
            Fault::Null(which) if which <= pointers => Some(Status::Null),
            Fault::Raw => Some(Status::NotInitialised),
            _ => None,
        };
        let expected = refused.unwrap_or_else(|| {
            in_rust(&mut self.mirror).unwrap_or_else(|error| {
                self.error = Some(error);
                error.into()
            })
        });
        assert_eq!(status, expected);
        refused.is_none()
    }

    pub(crate) fn call(&mut self, step: &Step, fault: Fault) {
        if fault == Fault::Again {
            self.init();
        }
        match step {
            Step::Solve(push, budget) => self.solve(push, *budget, fault),
            Step::Resume(push, budget) => self.resume(push, *budget, fault),
            _ => {
                if self.change(step, fault) {
                    self.paused = None;
                }
            }
        }
        self.explain();
    }

    /// Calls that do not solve. Did one reach the solver?
    fn change(&mut self, step: &Step, fault: Fault) -> bool {
        let done = |result: Result<(), Error>| result.map(|()| Status::Solved);
        // SAFETY: of all calls here: pointers are null or good, as `stiction.h` asks for.
        match step {
            Step::Mass(x, raw) => {
                let root = SMatrix::<Real, N, N>::from_fn(|i, j| at(x, i.min(j) * N + i.max(j)));
                let more = SMatrix::identity() * (root.norm_squared() * number(0.01));
                let mass = if *raw {
                    root
                } else {
                    root * root.transpose() + more
                };
                let given = rows(&mass);
                let given = fault.pointer(1, &given);
                let call = |s| unsafe { c::stiction_set_mass(s, given) };
                self.both(fault, 1, call, |k| {
                    done(k.scene_mut().set_mass(&mass).map_err(c::turned))
                })
            }
            Step::Push(x, mu, key) => self.push(x, *mu, *key, fault),
            Step::PushOn(x, surface, key) => self.push(x, surface[0], *key, fault),
            Step::Jacobian(i, x) => {
                let jacobian = SMatrix::from_fn(|row, dof| at(x, row * N + dof));
                let given = rows(&jacobian);
                let given = fault.pointer(1, &given);
                let call = |s| unsafe { c::stiction_set_jacobian(s, *i as u32, given) };
                self.both(fault, 1, call, |k| {
                    done(k.scene_mut().set_jacobian(*i, &jacobian))
                })
            }
            Step::Offset(i, x) => {
                let offset = vector::<D>(x);
                let given: [Real; D] = offset.into();
                let given = fault.pointer(1, &given);
                let call = |s| unsafe { c::stiction_set_offset(s, *i as u32, given) };
                self.both(fault, 1, call, |k| {
                    done(k.scene_mut().set_offset(*i, &offset))
                })
            }
            Step::Friction(i, mu) => {
                let mu = number(*mu);
                let call = |s| unsafe { c::stiction_set_friction(s, *i as u32, mu) };
                self.both(fault, 0, call, |k| done(k.scene_mut().set_friction(*i, mu)))
            }
            Step::Clear => {
                let call = |s| unsafe { c::stiction_clear_contacts(s) };
                self.both(fault, 0, call, |k| {
                    k.scene_mut().clear_contacts();
                    Ok(Status::Solved)
                })
            }
            Step::Reset => {
                let call = |s| unsafe { c::stiction_reset(s) };
                self.both(fault, 0, call, |k| {
                    k.solver_mut().reset();
                    Ok(Status::Solved)
                })
            }
            _ => false,
        }
    }

    fn push(&mut self, x: &[f64], mu: f64, key: u32, fault: Fault) -> bool {
        let contact: Contact<Real, N, D> = Contact {
            jacobian: SMatrix::from_fn(|row, dof| at(x, row * N + dof)),
            offset: SVector::from_fn(|row, _| at(x, D * N + row)),
            mu: number(mu),
            key,
        };
        let (jacobian, offset): (_, [Real; D]) = (rows(&contact.jacobian), contact.offset.into());
        let (jacobian, offset) = (fault.pointer(1, &jacobian), fault.pointer(2, &offset));
        // SAFETY: pointers are null or good.
        let call = |s| unsafe { c::stiction_add_contact(s, jacobian, offset, contact.mu, key) };
        self.both(fault, 2, call, |k| {
            k.scene_mut().push(&contact).map(|_| Status::Solved)
        })
    }

    fn solve(&mut self, push: &[f64], budget: Budget, fault: Fault) {
        let (push, tolerance) = (vector::<N>(push), number(budget.tolerance));
        let settings = Settings {
            budget: budget.work,
            ..Settings::new(tolerance)
        };
        let given: [Real; N] = push.into();
        let given = fault.pointer(1, &given);
        // SAFETY: pointers are null or good.
        let call = |s| unsafe { c::stiction_solve(s, given, tolerance, budget.work as u32) };
        let solve = |k: &mut Kernel<Real, N, D, C>| Ok(k.solve(&push, &settings)?.status.into());
        let before = self.error.take();
        if self.both(fault, 1, call, solve) && self.error.is_none() {
            self.paused = Some((push, tolerance));
            self.is_true(&push, tolerance);
        }
        self.error = self.error.or(before);
    }

    fn resume(&mut self, push: &[f64], budget: Budget, fault: Fault) {
        let other = (vector(push), number(budget.tolerance));
        let (push, tolerance) = self.paused.unwrap_or(other);
        let settings = Settings {
            budget: budget.work,
            ..Settings::new(tolerance)
        };
        let given: [Real; N] = push.into();
        let given = fault.pointer(1, &given);
        // SAFETY: pointers are null or good.
        let call = |s| unsafe { c::stiction_resume(s, given, tolerance, budget.work as u32) };
        let resume = |k: &mut Kernel<Real, N, D, C>| Ok(k.resume(&push, &settings)?.status.into());
        let before = self.error.take();
        if self.both(fault, 1, call, resume) && self.error.is_none() && self.paused.is_some() {
            self.is_true(&push, tolerance);
        }
        self.error = self.error.or(before);
    }

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
    fn is_true(&mut self, push: &SVector<Real, N>, tolerance: Real) {
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
            let allowed = f64::from(tolerance) * 1.001 + 1e-10;
            assert!(
                read.status != Status::Solved || error <= allowed,
                "{error:e}"
            );
        }
    }

    /// What C says of the last solution and the last error, beside what Rust says.
    fn explain(&mut self) {
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
        // SAFETY: pointers are good; a culprit of zeros is one.
        let culprit = unsafe {
            let mut culprit: Culprit = zeroed();
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

    pub(crate) fn end(&mut self) {
        assert!(self.memory.is_unharmed() && self.raw.is_unharmed());
        // SAFETY: null and memory that was never initialised are said to be refused.
        unsafe {
            assert!(!c::stiction_is_usable(null(), 1.0));
            assert!(!c::stiction_is_usable(self.raw.solver(), 1.0));
            assert_eq!(
                c::stiction_read(self.memory.solver(), null_mut()),
                Status::Null
            );
        }
    }
}

fn bits<const K: usize>(x: &SVector<Real, K>) -> [u32; K] {
    core::array::from_fn(|i| x[i].to_bits())
}
