//! A `stiction` of C, and a kernel in Rust that is given the same.

use crate::pointers::{Fault, Memory};
use crate::steps::{Budget, Step};
use c_firmware as c;
use c_firmware::{C, D, N, Real, Status};
use nalgebra::{SMatrix, SVector};
use std::ptr::{null, null_mut};
use stiction::{Contact, Error, Kernel, Settings};

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
    pub(crate) memory: Box<Memory>,
    raw: Box<Memory>,
    pub(crate) mirror: Box<Kernel<Real, N, D, C>>,
    pub(crate) error: Option<Error>,
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
