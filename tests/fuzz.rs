//! Whatever is put in, in whatever order: no panic, no work beyond the budget, nothing called solved that is not, no
//! NaN in a solution, and the same bits however a solve is split over calls.
//!
//! `PROPTEST_CASES=100000 cargo test --release --test all fuzz::` takes as long as you like.

use cases::cases;
use kind::{Contacts, Kind, double, vector};
use mixed::{Mixed, Rolling};
use proptest::prelude::*;
use steps::{Budget, Step};
use stiction::{Error, Factor, Kernel, Model, Real, Scene, Settings, Solution, Status};

mod cases;
mod files;
mod found;
mod kind;
mod limits;
mod mixed;
mod steps;

/// Where a free velocity overflows there may be none, but of nothing that is solved.
fn has_numbers<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    solution: &Solution<T, N, D, C, R>,
) -> bool {
    let contacts = solution.contacts.iter();
    let contacts = contacts.flat_map(|c| c.impulse.iter().chain(c.velocity.iter()));
    let rows = solution.rows.iter();
    let rows = rows.flat_map(|row| [&row.impulse, &row.velocity]);
    let numbers = contacts
        .chain(rows)
        .chain(&solution.velocity)
        .chain(solution.certificate.iter().flatten())
        .chain(&solution.row_certificate);
    numbers.into_iter().all(nalgebra::ComplexField::is_finite)
}

/// What a solution may always be asked for.
fn is_true<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
    K: Kind<T, N, D, C, R, S>,
>(
    beside: &K::Beside,
    scene: &Scene<T, N, D, C, R, S>,
    push: &nalgebra::SVector<T, N>,
    solution: &Solution<T, N, D, C, R>,
    settings: &Settings<T>,
) {
    assert!(!double(solution.error).is_nan(), "error is NaN");
    assert_ne!(solution.status, Status::Unsolved);
    let (used, behind) = solution.velocity.as_slice().split_at(scene.velocities());
    let is_finite = used.iter().all(nalgebra::ComplexField::is_finite);
    assert!(!is_finite || behind.iter().all(|&v| v == T::ZERO), "{behind:?}");
    let tolerance = double(settings.tolerance);
    if solution.is_solved() {
        assert!(solution.error <= settings.tolerance);
        assert!(has_numbers(solution), "solved, and NaN");
    }
    if let Some((error, proved)) = K::judge(beside, scene, push, solution, settings.model) {
        assert!(proved, "a proof that is none");
        assert!(has_numbers(solution), "NaN, {:?}", solution.status);
        assert!(!solution.is_solved() || error <= tolerance, "solved to {error:e}, not {tolerance:e}");
        // Also of what is not solved.
        let claimed = double(solution.error);
        let claims = solution.is_usable(T::INFINITY);
        assert!(!claims || error <= claimed, "{error:e}, not {claimed:e}");
    }
}

/// All bits of a solution, and what it has cost but for the search for a proof.
fn bits<T: Real, const N: usize, const D: usize, const C: usize, const R: usize>(
    solution: &Solution<T, N, D, C, R>,
) -> (Vec<u64>, Status, usize) {
    let impulses = solution.contacts.iter().flat_map(|c| c.impulse.iter().chain(c.velocity.iter()));
    let rows = solution.rows.iter();
    let rows = rows.flat_map(|row| [&row.impulse, &row.velocity]);
    let numbers = solution.velocity.iter().chain(impulses).chain(rows).chain([&solution.error]);
    let work = solution.work.total() - 10 * solution.work.proof_searches;
    (numbers.map(|x| double(*x).to_bits()).collect(), solution.status, work)
}

/// A kernel, and what is remembered of its last solve.
struct Machine<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
    K: Kind<T, N, D, C, R, S>,
> {
    kernel: Box<Kernel<T, N, D, C, R, S>>,
    beside: K::Beside,
    /// Free impulse, tolerance and model of the last solve, with which a call goes on.
    paused: Option<(nalgebra::SVector<T, N>, f64, bool)>,
}

impl<
    T: Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
    K: Kind<T, N, D, C, R, S>,
> Machine<T, N, D, C, R, S, K>
{
    fn run(steps: &[Step]) {
        let mut machine =
            Self { kernel: Box::new(Kernel::new()), beside: K::Beside::default(), paused: None };
        for step in steps {
            machine.call(step);
        }
    }

    fn call(&mut self, step: &Step) {
        let whole = self.kernel.scene().clone();
        let scene = self.kernel.scene_mut();
        K::call(&mut self.beside, scene, step);
        // Calls that are refused are calls, too.
        let _ = match step {
            Step::Mass(x, raw) => scene.set_mass(&kind::mass(x, *raw, scene.velocities())),
            Step::Velocities(n, x) => {
                let before = scene.velocities();
                let changed = scene.set_velocities(*n);
                assert_eq!(changed.is_ok(), (1..=N).contains(n));
                assert_eq!(scene.velocities(), if changed.is_ok() { *n } else { before });
                changed.and_then(|()| scene.set_mass(&kind::mass(x, false, *n)))
            }
            Step::Jacobian(i, x) => scene.set_jacobian(*i, &kind::contact(x, 0.0, 0).jacobian),
            Step::Offset(i, x) => scene.set_offset(*i, &vector(x)),
            Step::Friction(i, mu) => scene.set_friction(*i, T::literal(*mu)),
            Step::RowJacobian(i, x) => scene.set_row_jacobian(*i, &vector(x)),
            Step::RowOffset(i, offset) => scene.set_row_offset(*i, T::literal(*offset)),
            Step::RemoveContact(key) => scene.remove_contact(scene.contact_index(*key).unwrap_or(C)),
            Step::RemoveRow(key) => scene.remove_row(scene.row_index(*key).unwrap_or(R)),
            Step::Impulses(of_contacts, of_rows) => {
                let of_contacts = of_contacts.iter().map(|(key, x)| (*key, vector(&[*x, x / 2.0, -x / 3.0])));
                let of_rows = of_rows.iter().map(|(key, x)| (*key, T::literal(*x)));
                let of_rows: Vec<_> = of_rows.collect();
                self.kernel.solver_mut().set_impulses(&of_contacts.collect::<Vec<_>>(), &of_rows)
            }
            _ => Ok(()),
        };
        // A call that is refused changes nothing, but for that: the sequence goes on without it.
        if let Err(Error::SceneIncomplete { .. }) = Factor::new(self.kernel.scene()) {
            *self.kernel.scene_mut() = whole;
        }
        match step {
            Step::Clear => self.kernel.scene_mut().clear(),
            Step::ClearContacts => self.kernel.scene_mut().clear_contacts(),
            Step::ClearRows => self.kernel.scene_mut().clear_rows(),
            Step::Reset => self.kernel.solver_mut().reset(),
            Step::Solve(push, budget) => self.solve(push, *budget),
            Step::Resume(push, budget) => self.resume(push, *budget),
            _ => {}
        }
        if !matches!(step, Step::Solve(..) | Step::Resume(..)) {
            self.paused = None;
        }
    }

    fn settings(budget: Budget) -> Settings<T> {
        Settings {
            budget: budget.work,
            model: if budget.relaxed { Model::ConvexRelaxation } else { Model::Coulomb },
            ..Settings::new(T::literal(budget.tolerance))
        }
    }

    fn solve(&mut self, push: &[f64], budget: Budget) {
        let (push, settings) = (vector(push), Self::settings(budget));
        let before = self.kernel.clone();
        if self.kernel.solve(&push, &settings).is_err() {
            return;
        }
        let (scene, solution) = (self.kernel.scene(), self.kernel.solution());
        assert!(solution.work.total() <= settings.budget + 27, "{:?}", solution.work);
        is_true::<T, N, D, C, R, S, K>(&self.beside, scene, &push, solution, &settings);
        K::check(&mut self.beside, scene, &push, &settings);
        self.look_into(&push, &settings);
        self.paused = Some((push, budget.tolerance, budget.relaxed));
        Self::is_as_new(&before, &push, &settings);
        // The end of a budget ends the rest question. (An error in twice the digits takes 20 from it, five times at most.)
        if solution.work.total() + 100 >= settings.budget {
            return;
        }
        for few in [1, 17] {
            Self::is_split((*before).clone(), solution, &push, &Settings { budget: few, ..settings });
        }
    }

    /// What a solution bears are numbers, and carry what its own impulses carry.
    fn look_into(&self, push: &nalgebra::SVector<T, N>, settings: &Settings<T>) {
        if let Ok(least) = self.kernel.least_impulses(settings) {
            let numbers = least.contacts.iter().flatten().chain(&least.rows);
            assert!(numbers.copied().all(|x| x.is_finite()) && least.momentum_error >= T::ZERO);
        }
        let percent = Settings { tolerance: T::literal(0.01), ..*settings };
        for reserve in [self.kernel.slip_reserve(&percent), self.kernel.load_reserve(push, &percent)] {
            assert!(reserve.is_err() || reserve.is_ok_and(|reserve| reserve >= T::ZERO));
        }
        assert!(
            self.kernel.slip_reserve(&percent).is_ok_and(|share| share <= T::ONE)
                || !self.kernel.solution().is_usable(percent.tolerance)
        );
    }

    /// After a reset a solver gives the bits of a new one, whatever it has solved before.
    fn is_as_new(before: &Kernel<T, N, D, C, R, S>, push: &nalgebra::SVector<T, N>, settings: &Settings<T>) {
        let [mut used, mut new] = [before.clone(), Kernel::new()];
        used.solver_mut().reset();
        *new.scene_mut() = before.scene().clone();
        for kernel in [&mut used, &mut new] {
            kernel.solve(push, settings).expect("it was accepted");
        }
        let [used, new] = [used.solution(), new.solution()];
        assert_eq!(used.work, new.work);
        assert_eq!(bits(used), bits(new));
    }

    /// In calls of a few, a solve gives the same bits.
    fn is_split(
        mut kernel: Kernel<T, N, D, C, R, S>,
        whole: &Solution<T, N, D, C, R>,
        push: &nalgebra::SVector<T, N>,
        few: &Settings<T>,
    ) {
        if matches!(whole.status, Status::OutOfBudget | Status::Jammed) {
            return;
        }
        kernel.solve(push, few).expect("it was accepted");
        let mut spent = kernel.solution().work.total();
        for _ in 0..3_000 {
            // A jam that is noticed between two calls may have a solution: the solve goes on.
            let status = kernel.solution().status;
            if !matches!(status, Status::OutOfBudget | Status::Jammed) {
                break;
            }
            kernel.resume(push, few).expect("it was accepted");
            let work = kernel.solution().work.total();
            // With twice the digits a call may do nothing else.
            assert!(spent <= work && work <= spent + few.budget + 19);
            spent = work;
        }
        let split = kernel.solution();
        let (split, whole) = (bits(split), bits(whole));
        // The question whether a body can stay at rest ends with a call, with a solution.
        let are_solved = split.1 == Status::Solved && whole.1 == Status::Solved;
        let ends_sooner = are_solved && split.2 < whole.2;
        if ![split.1, whole.1].contains(&Status::Infeasible) && !ends_sooner {
            assert_eq!(split, whole);
        }
        // Solved to a tolerance relative to huge impulses, and proved infeasible: both can be true, and either may be noticed first.
    }

    /// Goes on with the last solve, or with whatever it finds.
    fn resume(&mut self, push: &[f64], budget: Budget) {
        let mut settings = Self::settings(budget);
        let mut same = vector(push);
        if let Some((push, tolerance, relaxed)) = self.paused {
            same = push;
            settings = Self::settings(Budget { tolerance, relaxed, ..budget });
        }
        let status = self.kernel.solution().status;
        let paused = matches!(status, Status::OutOfBudget | Status::Jammed);
        let spent = if paused { self.kernel.solution().work.total() } else { 0 };
        if self.kernel.resume(&same, &settings).is_err() {
            return;
        }
        let (scene, solution) = (self.kernel.scene(), self.kernel.solution());
        assert!(solution.work.total() <= spent + settings.budget + 27);
        // A paused solve of other data is not gone on with: this is another one.
        is_true::<T, N, D, C, R, S, K>(&self.beside, scene, &same, solution, &settings);
        if self.paused.is_none() {
            self.paused = Some((same, budget.tolerance, budget.relaxed));
        }
    }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn contacts_in_double_precision(steps in steps::sequence()) {
        Machine::<f64, 3, 3, 3, 0, 0, Contacts>::run(&steps);
    }

    #[test]
    fn contacts_in_single_precision(steps in steps::sequence()) {
        Machine::<f32, 3, 3, 3, 0, 0, Contacts>::run(&steps);
    }

    #[test]
    fn planar_contacts(steps in steps::sequence()) {
        Machine::<f64, 6, 2, 4, 0, 0, Contacts>::run(&steps);
    }

    #[test]
    fn joint_rows_in_double_precision(steps in steps::sequence()) {
        Machine::<f64, 3, 3, 4, 6, 4, Mixed>::run(&steps);
    }

    #[test]
    fn joint_rows_in_single_precision(steps in steps::sequence()) {
        Machine::<f32, 3, 3, 4, 6, 4, Mixed>::run(&steps);
    }

    #[test]
    fn contacts_of_six_dofs(steps in steps::sequence()) {
        Machine::<f32, 6, 3, 4, 0, 0, Contacts>::run(&steps);
    }

    #[test]
    fn joint_rows_of_ten_dofs(steps in steps::sequence()) {
        Machine::<f64, 10, 3, 8, 6, 8, Mixed>::run(&steps);
    }

    #[test]
    fn joint_rows_without_contacts(steps in steps::sequence()) {
        Machine::<f64, 4, 3, 0, 8, 0, Mixed>::run(&steps);
    }

    #[test]
    fn surfaces_without_joint_rows(steps in steps::sequence()) {
        Machine::<f64, 3, 3, 3, 0, 3, Mixed>::run(&steps);
    }

    #[test]
    fn surfaces_of_the_first_contacts(steps in steps::sequence()) {
        Machine::<f64, 4, 3, 4, 2, 2, Mixed>::run(&steps);
    }

    #[test]
    fn rolling_contacts_and_joint_rows(steps in steps::sequence()) {
        Machine::<f64, 6, 6, 4, 6, 4, Rolling>::run(&steps);
    }
}
