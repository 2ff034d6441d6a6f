//! Every public call of scenes of contacts and joint rows.

use crate::derivatives::differentiate;
use crate::helpers;
use crate::proof::take;
use core::hint::black_box;
use nalgebra::{SMatrix, SVector};
use stiction::{Contact, Factor, Kernel, Real, Settings, Solver, Surface};

/// A kernel, and a factor and a solver of their own.
pub(crate) struct Rows<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
> {
    kernel: Kernel<T, N, D, C, R, S>,
    factor: Factor<T, N, D, C, R>,
    solver: Solver<T, N, D, C, R>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Rows<T, N, D, C, R, S>
{
    pub(crate) const fn new() -> Self {
        Self { kernel: Kernel::new(), factor: Factor::empty(), solver: Solver::new() }
    }

    /// Every public call, on data the compiler knows nothing of.
    pub(crate) fn call(&mut self) {
        let (push, settings) = black_box((SVector::zeros(), Settings::default()));
        let contact = self.call_contacts();
        self.call_rows();
        self.call_kernel(&push, &settings);
        self.call_parts(&contact, &push, &settings);
        let scene = self.kernel.scene_mut();
        scene.clear_contacts();
        scene.clear_rows();
        scene.clear();
    }

    /// Contacts on surfaces of their own.
    fn call_contacts(&mut self) -> Contact<T, N, D> {
        let scene = self.kernel.scene_mut();
        let contact =
            black_box(Contact { jacobian: SMatrix::zeros(), offset: SVector::zeros(), mu: T::ONE, key: 7 });
        let [a, b, c, d] = black_box([T::ONE; 4]);
        let surface = black_box(Surface { friction: [a, b], spin: c, roll: [a, d], compliance: [c, d] });
        let (index, key) = black_box((1, 7));
        take(scene.set_mass(&black_box(SMatrix::identity())));
        take(scene.push_on(&contact, &surface));
        take(scene.set_offset(index, &contact.offset));
        take(scene.set_friction(index, contact.mu));
        take(scene.set_jacobian(index, &contact.jacobian));
        take(scene.remove_contact(index));
        black_box(scene.contact_index(key));
        black_box((scene.mass(), scene.contacts()));
        contact
    }

    /// Joint rows of each kind.
    fn call_rows(&mut self) {
        let scene = self.kernel.scene_mut();
        let (number, index, key) = black_box((T::ONE, 1, 2));
        for row in helpers::rows::<T, N>() {
            let Ok(row) = row else {
                take(row);
                continue;
            };
            let index = black_box(scene.push_row(&row)).unwrap_or(1);
            take(scene.set_row_offset(index, number));
            take(scene.set_row_law(index, row.law));
            take(scene.set_row_jacobian(index, &row.row));
            take(scene.set_row_compliance(index, number));
        }
        take(scene.remove_row(index));
        black_box(scene.row_index(key));
        black_box(scene.rows());
    }

    /// Solves as they stand, and with limits.
    fn call_kernel(&mut self, push: &SVector<T, N>, settings: &Settings<T>) {
        let (key, number) = black_box((4, T::ONE));
        let kernel = &mut self.kernel;
        take(kernel.solve(push, settings));
        take(kernel.resume(push, settings));
        take(kernel.advance(push, settings));
        if let [Ok(a), Ok(b), Ok(c), Ok(d)] = helpers::rows() {
            let limits = [a, b, c, d];
            take(kernel.solve_with_limits(black_box(&limits), push, settings));
            take(kernel.resume_with_limits(black_box(&limits), push, settings));
            take(kernel.advance_with_limits(black_box(&limits), push, settings));
        }
        take(kernel.prepare());
        let solution = kernel.solution();
        black_box(solution.row_by_key(key));
        black_box(solution.contact_by_key(key));
        black_box(kernel.violation());
        black_box((solution.is_solved(), solution.is_usable(number)));
        black_box(kernel.worst_contact());
        differentiate(kernel.derivative(settings));
        black_box(kernel.least_impulses(settings).is_ok());
        black_box(kernel.slip_reserve(settings).is_ok());
        black_box(kernel.load_reserve(push, settings).is_ok());
        black_box(kernel.rest_reserve(push, settings).is_ok());
        let (microseconds, megahertz, wait_percent) = black_box((2_000, 168, 55));
        black_box(Kernel::<f32, N, D, C, R, S>::budget_within(microseconds, megahertz, wait_percent));
        kernel.solver_mut().reset();
        kernel.reset();
    }

    /// The same in parts.
    fn call_parts(&mut self, contact: &Contact<T, N, D>, push: &SVector<T, N>, settings: &Settings<T>) {
        let Self { kernel, factor, solver } = self;
        let scene = kernel.scene();
        take(factor.prepare(scene));
        take(Factor::new(scene).map(|_| ()));
        black_box(factor.is_current(scene));
        let contacts = [(black_box(0), contact.offset); C];
        let rows = [black_box((0, T::ONE)); R];
        take(solver.set_impulses(black_box(&contacts), black_box(&rows)));
        take(solver.solve(scene, factor, push, settings));
        take(solver.resume(scene, factor, push, settings));
        take(solver.advance(scene, factor, push, settings));
        black_box(solver.solution().worst_contact(scene, factor));
        solver.reset();
    }
}
