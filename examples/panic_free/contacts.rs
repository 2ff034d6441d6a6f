//! Every public call of scenes, factors and solvers for contacts alone, and of friction cones.

use crate::derivatives::differentiate;
use crate::proof::{Sink, take};
use core::fmt::Write;
use core::hint::black_box;
use nalgebra::{SMatrix, SVector};
use stiction::{
    Acceleration, AdmmFactor, AdmmSolver, Contact, Factor, FrictionCone, Kernel, LeastImpulses, Real, Scene,
    Settings, SlipUpdate, Solver, Surface,
};

pub(crate) struct Bench<T: Real, const N: usize, const D: usize, const C: usize, const S: usize> {
    scene: Scene<T, N, D, C, 0, S>,
    factor: Factor<T, N, D, C>,
    admm_factor: AdmmFactor<T, N, D, C>,
    solver: Solver<T, N, D, C>,
    admm: AdmmSolver<T, N, D, C>,
    kernel: Kernel<T, N, D, C, 0, S>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize, const S: usize> Bench<T, N, D, C, S> {
    pub(crate) const fn new() -> Self {
        Self {
            scene: Scene::new(),
            factor: Factor::empty(),
            admm_factor: AdmmFactor::empty(),
            solver: Solver::new(),
            admm: AdmmSolver::with(Acceleration::Nesterov, SlipUpdate::OuterLoop),
            kernel: Kernel::new(),
        }
    }

    /// Every public call, on data the compiler knows nothing of.
    pub(crate) fn call(&mut self) {
        let mass: SMatrix<T, N, N> = black_box(SMatrix::identity());
        let contact: Contact<T, N, D> =
            black_box(Contact { jacobian: SMatrix::zeros(), offset: SVector::zeros(), mu: T::ONE, key: 7 });
        let push: SVector<T, N> = black_box(SVector::zeros());
        let settings: Settings<T> = black_box(Settings::default());
        self.call_scene(&mass, &contact);
        self.call_solvers(&contact, &push, &settings);
        self.scene.clear();
        self.call_kernel(&mass, &contact, &push, &settings);

        if let Some(cone) = black_box(FrictionCone::new(black_box(contact.mu))) {
            black_box(cone.contains(&contact.offset));
            black_box(cone.project(&contact.offset));
            black_box(cone.dual().project(&contact.offset));
        }
    }

    fn call_scene(&mut self, mass: &SMatrix<T, N, N>, contact: &Contact<T, N, D>) {
        let scene = &mut self.scene;
        let (index, key, number) = black_box((1, 7, T::ONE));
        take(scene.set_mass(mass));
        take(scene.push(contact));
        take(scene.push_on(contact, &black_box(Surface::isotropic(number))));
        take(scene.set_offset(index, &contact.offset));
        take(scene.set_friction(index, contact.mu));
        take(scene.set_jacobian(index, &contact.jacobian));
        take(scene.remove_contact(index));
        black_box(scene.contact_index(key));
        black_box((scene.mass(), scene.contacts()));
    }

    fn call_solvers(&mut self, contact: &Contact<T, N, D>, push: &SVector<T, N>, settings: &Settings<T>) {
        let Self { scene, factor, admm_factor, solver, admm, .. } = self;
        let (key, number) = black_box((7, T::ONE));
        take(factor.prepare(scene));
        take(admm_factor.prepare(scene));
        take(admm_factor.set_penalty(number));
        take(Factor::new(scene).map(|_| ()));
        take(AdmmFactor::new(scene).map(|_| ()));
        black_box(factor.is_current(scene));
        black_box((admm_factor.penalty(), admm_factor.factor()));

        take(solver.solve(scene, factor, push, settings));
        solver.reset();
        take(admm.solve(scene, admm_factor, push, settings));
        take(admm.resume(scene, admm_factor, push, settings));
        let impulses = black_box([(0, contact.offset); C]);
        take(solver.set_impulses(black_box(&impulses), black_box(&[])));
        take(solver.resume(scene, factor, push, settings));
        take(solver.advance(scene, factor, push, settings));
        let solution = solver.solution();
        black_box(solution.worst_contact(scene, factor));
        black_box(solution.violation(scene, factor));
        black_box(LeastImpulses::new(scene, factor, solution, settings).is_ok());
        black_box(solution.slip_reserve(scene, factor, settings).is_ok());
        black_box(solution.load_reserve(scene, factor, push, settings).is_ok());
        black_box(scene.rest_reserve(factor, push, settings).is_ok());
        black_box(solution.contact_by_key(key));
        black_box((solution.is_solved(), solution.is_usable(number)));
        black_box(solution.work.total());
        let _ = write!(Sink, "{}", solution.status);
        admm.reset();
        take(admm.set_impulses(black_box(&impulses)));
        black_box(admm.solution());
    }

    /// The same by way of `Kernel`.
    fn call_kernel(
        &mut self,
        mass: &SMatrix<T, N, N>,
        contact: &Contact<T, N, D>,
        push: &SVector<T, N>,
        settings: &Settings<T>,
    ) {
        let kernel = &mut self.kernel;
        let scene = kernel.scene_mut();
        take(scene.set_mass(mass));
        take(scene.push(contact));
        take(kernel.prepare());
        take(kernel.solve(push, settings));
        take(kernel.resume(push, settings));
        take(kernel.advance(push, settings));
        black_box(kernel.worst_contact());
        differentiate(kernel.derivative(settings));
        black_box(kernel.solution().error);
        kernel.solver_mut().reset();
        kernel.scene_mut().clear_contacts();
        kernel.reset();
        let (microseconds, megahertz, wait_percent) = black_box((2_000, 168, 55));
        black_box(Kernel::<f32, N, D, C, 0, S>::budget_within(microseconds, megahertz, wait_percent));
    }
}
