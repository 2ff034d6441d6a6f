//! A `stiction` of C, and a kernel in Rust that is given the same.

use crate::c;
use crate::c::{C, D, Kernel, L, N, R, Real, Status};
use crate::given::{
    at, contact, joint_row, joint_row_of_c, law, number, rows, surface, surface_of_c, vector,
};
use crate::pointers::{Fault, Memory, ROOM};
use crate::scene::Surfaces;
use crate::steps::{Budget, Law, Step};
use nalgebra::{SMatrix, SVector};
use std::mem::size_of;
use std::ptr::{null, null_mut};
use stiction::{Error, Settings};

pub(crate) struct Machine {
    pub(crate) memory: Box<Memory>,
    raw: Box<Memory>,
    pub(crate) mirror: Box<Kernel>,
    /// What of the mirror cannot be read there.
    pub(crate) surfaces: Surfaces,
    pub(crate) error: Option<Error>,
    /// Was there a number that is no law since?
    pub(crate) no_law: bool,
    /// Free impulse and tolerance of a solve that can be resumed.
    paused: Option<(SVector<Real, N>, Real)>,
}

impl Machine {
    pub(crate) fn new() -> Self {
        let mut machine = Self {
            memory: Memory::new(),
            raw: Memory::new(),
            mirror: Box::new(Kernel::new()),
            surfaces: Surfaces::default(),
            error: None,
            no_law: false,
            paused: None,
        };
        machine.init();
        machine
    }

    fn init(&mut self) {
        let (room, solution) = (ROOM, size_of::<c::Solution>());
        for (bytes, solution_bytes, expected) in [
            (room - 8, solution, Status::WrongSizes),
            (room, solution + 4, Status::WrongSizes),
            (room, solution, Status::Ok),
        ] {
            // SAFETY: the memory is as large as C declares it.
            let status = unsafe { c::stiction_init_sized(self.memory.solver(), bytes, solution_bytes) };
            assert_eq!(status, expected);
        }
        *self.mirror = Kernel::new();
        self.surfaces.clear();
        (self.error, self.no_law, self.paused) = (None, false, None);
    }

    /// Calls C and, if all pointers are good, Rust, and compares what they return.
    fn both(
        &mut self,
        fault: Fault,
        pointers: u8,
        in_c: impl FnOnce(*mut c::Solver) -> Status,
        in_rust: impl FnOnce(&mut Kernel) -> Result<Status, Error>,
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
        if status == Status::InvalidLaw {
            (self.error, self.no_law) = (None, true);
        }
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
        // SAFETY: of all calls here: pointers are null or good, as `stiction.h` asks for.
        match step {
            Step::Velocities(n, x) => {
                let call = |s| unsafe { c::stiction_set_velocities(s, *n as u32) };
                let before = self.mirror.scene().velocities();
                let reached = self.both(fault, 0, call, |k| done(k.scene_mut().set_velocities(*n)));
                if self.mirror.scene().velocities() != before {
                    self.surfaces.clear();
                }
                self.change(&Step::Mass(x.clone(), false), fault) || reached
            }
            Step::Mass(x, raw) => {
                let root = SMatrix::<Real, N, N>::from_fn(|i, j| at(x, i.min(j) * N + i.max(j)));
                let more = SMatrix::identity() * (root.norm_squared() * number(0.01));
                let mass = if *raw { root } else { root * root.transpose() + more };
                let given = rows(&mass);
                let given = fault.pointer(1, &given);
                let call = |s| unsafe { c::stiction_set_mass(s, given) };
                self.both(fault, 1, call, |k| done(k.scene_mut().set_mass(&mass).map_err(c::turned)))
            }
            Step::Clear => {
                let call = |s| unsafe { c::stiction_clear(s) };
                let reached = self.both(fault, 0, call, |k| {
                    k.scene_mut().clear();
                    Ok(Status::Ok)
                });
                if reached {
                    self.surfaces.clear();
                }
                reached
            }
            Step::Reset => {
                let call = |s| unsafe { c::stiction_reset(s) };
                self.both(fault, 0, call, |k| {
                    k.solver_mut().reset();
                    Ok(Status::Ok)
                })
            }
            Step::Impulses(contacts, rows) => self.impulses(contacts, rows, fault),
            _ => self.change_contacts(step, fault) || self.change_rows(step, fault),
        }
    }

    /// Calls for contacts.
    fn change_contacts(&mut self, step: &Step, fault: Fault) -> bool {
        // SAFETY: of all calls here: pointers are null or good, as `stiction.h` asks for.
        match step {
            Step::Push(x, mu, key) => self.push(x, *mu, *key, fault),
            Step::PushOn(x, surface, key) => self.push_on(x, surface, *key, fault),
            Step::Jacobian(i, x) => {
                let jacobian = SMatrix::from_fn(|row, dof| at(x, row * N + dof));
                let given = rows(&jacobian);
                let given = fault.pointer(1, &given);
                let call = |s| unsafe { c::stiction_set_jacobian(s, *i as u32, given) };
                self.both(fault, 1, call, |k| done(k.scene_mut().set_jacobian(*i, &jacobian)))
            }
            Step::Offset(i, x) => {
                let offset = vector::<D>(x);
                let given: [Real; D] = offset.into();
                let given = fault.pointer(1, &given);
                let call = |s| unsafe { c::stiction_set_offset(s, *i as u32, given) };
                self.both(fault, 1, call, |k| done(k.scene_mut().set_offset(*i, &offset)))
            }
            Step::Friction(i, mu) => {
                let mu = number(*mu);
                let call = |s| unsafe { c::stiction_set_friction(s, *i as u32, mu) };
                self.both(fault, 0, call, |k| done(k.scene_mut().set_friction(*i, mu)))
            }
            Step::RemoveContact(key) => {
                let place = self.mirror.scene().contact_index(*key);
                let i = place.unwrap_or(C);
                let call = |s| unsafe { c::stiction_remove_contact(s, i as u32) };
                let reached = self.both(fault, 0, call, |k| done(k.scene_mut().remove_contact(i)));
                if let Some(place) = place.filter(|_| reached) {
                    self.surfaces.remove(place);
                }
                reached
            }
            Step::ClearContacts => {
                let call = |s| unsafe { c::stiction_clear_contacts(s) };
                let reached = self.both(fault, 0, call, |k| {
                    k.scene_mut().clear_contacts();
                    Ok(Status::Ok)
                });
                if reached {
                    self.surfaces.clear();
                }
                reached
            }
            _ => false,
        }
    }

    /// Calls for joint rows.
    fn change_rows(&mut self, step: &Step, fault: Fault) -> bool {
        // SAFETY: of all calls here: pointers are null or good, as `stiction.h` asks for.
        match step {
            Step::PushRow(x, law, soft, key) => self.push_row(x, *law, *soft, *key, fault),
            Step::RowLaw(i, bounds) => self.row_law(*i, *bounds, fault),
            Step::RowOffset(i, offset) => {
                let offset = number(*offset);
                let call = |s| unsafe { c::stiction_set_row_offset(s, *i as u32, offset) };
                self.both(fault, 0, call, |k| done(k.scene_mut().set_row_offset(*i, offset)))
            }
            Step::RowJacobian(i, x) => {
                let jacobian = vector::<N>(x);
                let given: [Real; N] = jacobian.into();
                let given = fault.pointer(1, &given);
                let call = |s| unsafe { c::stiction_set_row_jacobian(s, *i as u32, given) };
                self.both(fault, 1, call, |k| done(k.scene_mut().set_row_jacobian(*i, &jacobian)))
            }
            Step::RowCompliance(i, soft) => {
                let soft = number(*soft);
                let call = |s| unsafe { c::stiction_set_row_compliance(s, *i as u32, soft) };
                self.both(fault, 0, call, |k| done(k.scene_mut().set_row_compliance(*i, soft)))
            }
            Step::RemoveRow(key) => {
                let i = self.mirror.scene().row_index(*key).unwrap_or(R);
                let call = |s| unsafe { c::stiction_remove_row(s, i as u32) };
                self.both(fault, 0, call, |k| done(k.scene_mut().remove_row(i)))
            }
            Step::ClearRows => {
                let call = |s| unsafe { c::stiction_clear_rows(s) };
                self.both(fault, 0, call, |k| {
                    k.scene_mut().clear_rows();
                    Ok(Status::Ok)
                })
            }
            _ => false,
        }
    }

    fn push(&mut self, x: &[f64], mu: f64, key: u32, fault: Fault) -> bool {
        let contact = contact(x, mu, key);
        let (jacobian, offset): (_, [Real; D]) = (rows(&contact.jacobian), contact.offset.into());
        let (jacobian, offset) = (fault.pointer(1, &jacobian), fault.pointer(2, &offset));
        // SAFETY: pointers are null or good.
        let call = |s| unsafe { c::stiction_add_contact(s, jacobian, offset, contact.mu, key) };
        let before = self.mirror.scene().contacts().len();
        let reached = self.both(fault, 2, call, |k| k.scene_mut().push(&contact).map(|_| Status::Ok));
        if self.mirror.scene().contacts().len() > before {
            self.surfaces.push(None);
        }
        reached
    }

    fn push_on(&mut self, x: &[f64], coefficients: &[f64], key: u32, fault: Fault) -> bool {
        let (contact, surface) = (contact(x, 0.0, key), surface(coefficients));
        let (jacobian, offset): (_, [Real; D]) = (rows(&contact.jacobian), contact.offset.into());
        let (jacobian, offset) = (fault.pointer(1, &jacobian), fault.pointer(2, &offset));
        let given = [surface_of_c(&surface)];
        let given = fault.pointer(3, &given);
        // SAFETY: pointers are null or good.
        let call = |s| unsafe { c::stiction_add_contact_on(s, jacobian, offset, given, key) };
        let before = self.mirror.scene().contacts().len();
        let reached =
            self.both(fault, 3, call, |k| k.scene_mut().push_on(&contact, &surface).map(|_| Status::Ok));
        if let Some(contact) = self.mirror.scene().contacts().get(before) {
            self.surfaces.push(Some((&surface, contact.mu)));
        }
        reached
    }

    fn push_row(&mut self, x: &[f64], bounds: Law, soft: f64, key: u32, fault: Fault) -> bool {
        let row = joint_row(x, bounds, soft, key);
        let given = [joint_row_of_c(&row, fault.law(bounds.0), bounds)];
        let given = fault.pointer(1, &given);
        // SAFETY: pointers are null or good.
        let call = |s| unsafe { c::stiction_add_row(s, given) };
        self.both(fault, 1, call, |k| match fault {
            Fault::Law(_) => Ok(Status::InvalidLaw),
            _ => k.scene_mut().push_row(&row).map(|_| Status::Ok),
        })
    }

    fn row_law(&mut self, place: usize, bounds: Law, fault: Fault) -> bool {
        let (kind, lower, upper) = bounds;
        let (kind, lower, upper) = (fault.law(kind), number(lower), number(upper));
        // SAFETY: the pointer is null or good.
        let call = |s| unsafe { c::stiction_set_row_law(s, place as u32, kind, lower, upper) };
        self.both(fault, 0, call, |k| match fault {
            Fault::Law(_) => Ok(Status::InvalidLaw),
            _ => done(k.scene_mut().set_row_law(place, law(bounds))),
        })
    }

    fn impulses(&mut self, contacts: &[(u32, f64)], joints: &[(u32, f64)], fault: Fault) -> bool {
        let contacts: Vec<(u32, SVector<Real, D>)> =
            contacts.iter().map(|(key, x)| (*key, vector(&[*x, x / 2.0, -x / 3.0]))).collect();
        let joints: Vec<_> = joints.iter().map(|(key, x)| (*key, number(*x))).collect();
        let of_contacts = contacts.iter().map(|&(key, r)| c::ContactImpulse { key, impulse: r.into() });
        let of_joints = joints.iter().map(|&(key, impulse)| c::RowImpulse { key, impulse });
        let of_contacts = of_contacts.collect::<Vec<_>>();
        let of_joints = of_joints.collect::<Vec<_>>();
        let first = fault.pointer(1, &of_contacts);
        let second = fault.pointer(2, &of_joints);
        let counts = (contacts.len() as u32, joints.len() as u32);
        // SAFETY: pointers are null or good.
        let call = |s| unsafe { c::stiction_set_impulses(s, first, counts.0, second, counts.1) };
        // A list of none may be null.
        let fault = match fault {
            Fault::Null(1) if contacts.is_empty() => Fault::No,
            Fault::Null(2) if joints.is_empty() => Fault::No,
            fault => fault,
        };
        self.both(fault, 2, call, |k| done(k.solver_mut().set_impulses(&contacts, &joints)))
    }

    /// Solves; with limits made of the same numbers where a scene in Rust would be relaxed.
    fn solve(&mut self, push: &[f64], budget: Budget, fault: Fault) {
        let (numbers, push, tolerance) = (push, vector::<N>(push), number(budget.tolerance));
        let settings = Settings { budget: budget.work, ..Settings::new(tolerance) };
        let work = budget.work as u32;
        let given: [Real; N] = push.into();
        let given = fault.pointer(1, &given);
        let before = self.error.take();
        let reached = if budget.relaxed {
            let law = (0, 0.0, 0.0);
            let row = |i: usize| joint_row(&numbers[i..], law, 0.0, i as u32);
            let mut rows = (0..budget.work % 4).map(row).collect::<Vec<_>>();
            rows.truncate(L);
            let count = rows.len();
            let in_c = rows.iter().map(|row| joint_row_of_c(row, 0, law));
            let in_c = in_c.collect::<Vec<_>>();
            let first = fault.pointer(2, &in_c);
            // A list of none may be null.
            let fault = match fault {
                Fault::Null(2) if count == 0 => Fault::No,
                fault => fault,
            };
            let calls = [
                c::stiction_solve_with_limits,
                c::stiction_resume_with_limits,
                c::stiction_advance_with_limits,
            ];
            let which = budget.work / 4 % 3;
            // SAFETY: pointers are null or good.
            let call = |s| unsafe { calls[which](s, first, count as u32, given, tolerance, work) };
            self.both(fault, 2, call, |k| {
                match which {
                    0 => k.solve_with_limits(&rows, &push, &settings).map(|_| ())?,
                    1 => k.resume_with_limits(&rows, &push, &settings).map(|_| ())?,
                    _ => k.advance_with_limits(&rows, &push, &settings).map(|_| ())?,
                }
                Ok(k.solution().status.into())
            })
        } else {
            // SAFETY: pointers are null or good.
            let call = |s| unsafe { c::stiction_solve(s, given, tolerance, work) };
            let solve = |k: &mut Kernel| Ok(k.solve(&push, &settings)?.status.into());
            self.both(fault, 1, call, solve)
        };
        self.paused = None;
        if reached && self.error.is_none() && !budget.relaxed {
            self.paused = Some((push, tolerance));
            self.is_true(&push, tolerance);
        }
        self.error = self.error.or(before);
    }

    /// Goes on, or where a scene in Rust would be relaxed advances.
    fn resume(&mut self, push: &[f64], budget: Budget, fault: Fault) {
        let other = (vector(push), number(budget.tolerance));
        let (push, tolerance) = self.paused.unwrap_or(other);
        let settings = Settings { budget: budget.work, ..Settings::new(tolerance) };
        let work = budget.work as u32;
        let given: [Real; N] = push.into();
        let given = fault.pointer(1, &given);
        let before = self.error.take();
        // SAFETY: of both calls: pointers are null or good.
        let reached = if budget.relaxed {
            let call = |s| unsafe { c::stiction_advance(s, given, tolerance, work) };
            let advance = |k: &mut Kernel| {
                k.advance(&push, &settings)?;
                Ok(k.solution().status.into())
            };
            self.both(fault, 1, call, advance)
        } else {
            let call = |s| unsafe { c::stiction_resume(s, given, tolerance, work) };
            let resume = |k: &mut Kernel| Ok(k.resume(&push, &settings)?.status.into());
            self.both(fault, 1, call, resume)
        };
        if reached && self.error.is_none() && self.paused.is_some() {
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
            for (solver, status) in [(null_mut(), Status::Null), (self.raw.solver(), Status::NotInitialised)]
            {
                let status = status as i32;
                assert_eq!(c::stiction_contact_index(solver, 0), status);
                assert_eq!(c::stiction_row_index(solver, 0), status);
            }
            let solver = self.memory.solver();
            assert_eq!(c::stiction_read(solver, null_mut()), Status::Null);
            for solver in [solver, null_mut()] {
                for status in [
                    c::stiction_contact_at(solver, 0, null_mut()),
                    c::stiction_contact_by_key(solver, 0, null_mut()),
                    c::stiction_row_at(solver, 0, null_mut()),
                    c::stiction_row_by_key(solver, 0, null_mut()),
                    c::stiction_worst_violation(solver, null_mut()),
                ] {
                    assert_eq!(status, Status::Null);
                }
            }
        }
    }
}

fn done(result: Result<(), Error>) -> Result<Status, Error> {
    result.map(|()| Status::Ok)
}
