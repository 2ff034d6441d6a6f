//! Limits that are given to a solve: the same promises, about all of them.

use super::cases::cases;
use super::kind::{Kind, at, double, mass, vector};
use super::mixed::{Mixed, Record, is_measurable, proof_of};
use super::steps::{self, Budget, Step};
use proptest::prelude::*;
use stiction::{JointRow, Kernel, Real, RowLaw, RowSolution, Settings, Status};
use testbed::mixed::Joint;
use testbed::mixed_measure;

/// Their keys begin here, beyond those of other rows.
const FIRST: u32 = 100;

/// Takes a sequence of calls, of which rows that are limits are given to the solves.
pub(super) fn run<T: Real, const N: usize, const C: usize, const R: usize>(steps: &[Step]) {
    let mut kernel = Box::new(Kernel::<T, N, 3, C, R, C>::new());
    let (mut record, mut limits) = (Record::default(), Vec::new());
    for step in steps {
        match step {
            Step::PushRow(x, (0, ..), soft, _) => limits.push(JointRow {
                row: vector(x),
                offset: at(x, N),
                law: RowLaw::Limit,
                compliance: T::literal(*soft),
                key: FIRST + u32::try_from(limits.len()).expect("few"),
            }),
            Step::Mass(x, false) => {
                let mass = mass(x, false, kernel.scene().velocities());
                let _ = kernel.scene_mut().set_mass(&mass);
            }
            Step::Velocities(n, x) => {
                Mixed::call(&mut record, kernel.scene_mut(), step);
                if kernel.scene_mut().set_velocities(*n).is_ok() {
                    let _ = kernel.scene_mut().set_mass(&mass(x, false, *n));
                }
            }
            Step::Clear => {
                kernel.scene_mut().clear();
                limits.clear();
                Mixed::call(&mut record, kernel.scene_mut(), step);
            }
            Step::Push(..) | Step::PushOn(..) | Step::PushRow(..) => {
                Mixed::call(&mut record, kernel.scene_mut(), step);
            }
            Step::Solve(push, budget) => solve(&mut kernel, &record, &limits, (push, *budget)),
            _ => {}
        }
    }
}

fn solve<T: Real, const N: usize, const C: usize, const R: usize>(
    kernel: &mut Kernel<T, N, 3, C, R, C>,
    record: &Record,
    limits: &[JointRow<T, N>],
    (push, budget): (&[f64], Budget),
) {
    let (push, tolerance) = (vector(push), T::literal(budget.tolerance));
    let n = kernel.scene().velocities();
    let settings = Settings { budget: budget.work, ..Settings::new(tolerance) };
    let rows = kernel.scene().rows().to_vec();
    let was_paused = kernel.solution().status == Status::OutOfBudget;
    let mut in_pieces = kernel.clone();
    let done = kernel.solve_with_limits(limits, &push, &settings).is_ok();
    assert!(kernel.scene().rows() == rows);
    if !done {
        return;
    }
    let solution = kernel.solution();
    if solution.is_solved() && !was_paused && solution.work.total() + 100 < settings.budget {
        let piece = Settings { budget: 7, ..settings };
        while !in_pieces.advance_with_limits(limits, &push, &piece).expect("it was solved") {
            assert!(in_pieces.scene().rows() == rows);
        }
        assert_eq!(in_pieces.solution().velocity, solution.velocity);
        assert_eq!(in_pieces.solution().work, solution.work);
    }
    assert!(solution.work.total() <= settings.budget + 27);
    assert_ne!(solution.status, Status::Unsolved);
    let of = |key| solution.row_by_key(key);
    if solution.is_solved() {
        let left_out = limits.iter().filter(|row| of(row.key).is_none());
        for row in left_out {
            let [row_in_use, v] = [&row.row, &solution.velocity].map(|x| x.rows(0, n));
            assert!(row_in_use.dot(&v) + row.offset >= T::ZERO);
        }
    }
    let mut file = record.file(kernel.scene(), &push);
    file.joints.extend(limits.iter().map(|row| Joint {
        kind: "limit".to_owned(),
        row: row.row.iter().take(n).map(|x| double(*x)).collect(),
        offset: double(row.offset),
        lower: None,
        upper: None,
        compliance: double(row.compliance),
    }));
    if !is_measurable::<T>(&file) {
        return;
    }
    let v: Vec<f64> = solution.velocity.iter().take(n).map(|x| double(*x)).collect();
    let r = solution.contacts.iter();
    let r = r.flat_map(|contact| contact.impulse.iter());
    let r: Vec<f64> = r.map(|x| double(*x)).collect();
    // The scene's own rows, and then the limits; those that were left out have no impulse.
    let place = |key| solution.rows.iter().position(|row| row.key == key);
    let own = (0..rows.len()).map(Some);
    let places: Vec<_> = own.chain(limits.iter().map(|row| place(row.key))).collect();
    if solution.is_solved() {
        let impulse = |row: &RowSolution<T>| double(row.impulse);
        let lambda = |place: &Option<usize>| place.map_or(0.0, |i| impulse(&solution.rows[i]));
        let lambda: Vec<f64> = places.iter().map(lambda).collect();
        let error = mixed_measure::error(&file, &v, &r, &lambda);
        assert!(error <= double(tolerance), "solved to {error:e}");
    }
    if solution.status == Status::Infeasible && double(T::EPSILON) < 1e-10 {
        let [normals, joints] = proof_of(solution);
        let joints = places.iter().map(|place| place.map_or(0.0, |i| joints[i]));
        let joints: Vec<f64> = joints.collect();
        assert!(mixed_measure::proves(&file, &normals, &joints), "a proof that is none");
    }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn limits_in_double_precision(steps in steps::sequence()) {
        run::<f64, 3, 4, 6>(&steps);
    }

    #[test]
    fn limits_in_single_precision(steps in steps::sequence()) {
        run::<f32, 3, 4, 6>(&steps);
    }
}
