//! A tick of the quadruped with joint limits: its scene is filled, prepared and solved to 1e-4.

use crate::counter::Counter;
use crate::records::{Records, Step};
use core::array::from_fn;
use cortex_m_semihosting::hprintln;
use nalgebra::SVector;
use stiction::{JointRow, Kernel, Real, RowLaw, Settings};

const N: usize = 18;
/// Of its twelve joints, the first velocity.
const FIRST: usize = 6;
const JOINTS: usize = 12;

/// The kernels that are compared.
pub(crate) struct Limits<T: Real> {
    contacts: Kernel<T, N, 3, 4>,
    /// The same, with room for a limit of each joint.
    lazy: Kernel<T, N, 3, 4, JOINTS>,
    step: Step<T, N, 3, 4>,
}

impl<T: Real> Limits<T> {
    pub(crate) const fn new() -> Self {
        Self { contacts: Kernel::new(), lazy: Kernel::new(), step: Step::new() }
    }

    /// Contacts alone; the same with room for twelve joint rows; twelve limits far away; two of them reached, cold and from
    /// the solution of a free impulse 1 % smaller; the pieces of the cold one. `None` if something does not succeed.
    pub(crate) fn measure(&mut self, records: &[u8], counter: &mut Counter) -> Option<()> {
        self.step.read(&mut Records::new(records))?;
        let push = self.step.push;
        let mut ok = true;
        let count = counter.count(|| ok &= self.tick_contacts(&push).is_some())?;
        hprintln!("limits contacts {}", count);
        let velocity = self.contacts.solution().velocity;
        let [none, two] = [false, true].map(|reached| limits(&velocity, reached));
        let mut tick = |name, limits: &[JointRow<T, N>], push: &SVector<T, N>| {
            self.lazy.solver_mut().reset();
            self.forget()?;
            let mut found = None;
            let count = counter.count(|| found = self.tick(limits, push))?;
            hprintln!("limits {} {}", name, count);
            found
        };
        ok &= tick("none", &[], &push)? == 0;
        ok &= tick("far", &none, &push)? == 0;
        ok &= tick("two_cold", &two, &push)? == 2;
        self.lazy.solver_mut().reset();
        ok &= self.tick(&two, &(push * T::literal(0.99)))? == 2;
        self.forget()?;
        let mut found = None;
        let count = counter.count(|| found = self.tick(&two, &push))?;
        hprintln!("limits two_warm {}", count);
        // The same from nothing in the smallest pieces, prepared.
        self.lazy.solver_mut().reset();
        let piece = Settings { budget: 1, ..Settings::default() };
        let (mut sum, mut calls, mut longest, mut has_ended) = (0, 0, 0, false);
        while ok && !has_ended {
            let mut call =
                || self.lazy.advance_with_limits(&two, &push, &piece).inspect(|&ended| has_ended = ended);
            let count = counter.count(|| ok &= call().is_ok())?;
            (sum, calls, longest) = (sum + count, calls + 1, count.max(longest));
        }
        hprintln!("limits slice_mean {}", sum.checked_div(calls)?);
        hprintln!("limits slice {}", longest);
        hprintln!("limits ram_contacts {}", size_of_val(&self.contacts));
        hprintln!("limits ram {}", size_of_val(&self.lazy));
        (ok && found? == 2).then_some(())
    }

    #[inline(never)]
    fn tick_contacts(&mut self, push: &SVector<T, N>) -> Option<()> {
        let scene = self.contacts.scene_mut();
        scene.set_mass(self.step.scene.mass()).ok()?;
        scene.clear();
        for contact in self.step.scene.contacts() {
            scene.push(contact).ok()?;
        }
        let solution = self.contacts.solve(push, &Settings::default()).ok()?;
        solution.is_solved().then_some(())
    }

    /// Prepares another mass, so that the next tick has to prepare its own.
    fn forget(&mut self) -> Option<()> {
        let mass = self.step.scene.mass() * T::literal(2.0);
        self.lazy.scene_mut().set_mass(&mass).ok()?;
        self.lazy.prepare().ok()
    }

    /// How many limits push.
    #[inline(never)]
    fn tick(&mut self, limits: &[JointRow<T, N>], push: &SVector<T, N>) -> Option<usize> {
        let scene = self.lazy.scene_mut();
        scene.set_mass(self.step.scene.mass()).ok()?;
        scene.clear();
        for contact in self.step.scene.contacts() {
            scene.push(contact).ok()?;
        }
        let settings = Settings::default();
        let solution = self.lazy.solve_with_limits(limits, push, &settings).ok()?;
        let pushing = limits.iter().filter_map(|limit| solution.row_by_key(limit.key));
        let pushing = pushing.filter(|row| row.impulse > T::ZERO).count();
        solution.is_solved().then_some(pushing)
    }
}

/// A limit for each joint, which moves towards it at this velocity: a radian a second too slow to reach it, or two of them
/// twice as fast as they may.
fn limits<T: Real>(velocity: &SVector<T, N>, reached: bool) -> [JointRow<T, N>; JOINTS] {
    from_fn(|joint| {
        let speed = velocity.get(FIRST + joint).copied().unwrap_or(T::ZERO);
        let mut row = SVector::<T, N>::zeros();
        if let Some(entry) = row.get_mut(FIRST + joint) {
            *entry = if speed > T::ZERO { -T::ONE } else { T::ONE };
        }
        let beyond = reached && joint % 6 == 2;
        JointRow {
            row,
            offset: if beyond { speed.abs() * T::literal(0.5) } else { speed.abs() + T::ONE },
            law: RowLaw::Limit,
            compliance: T::ZERO,
            key: u32::try_from(joint).unwrap_or(0),
        }
    })
}
