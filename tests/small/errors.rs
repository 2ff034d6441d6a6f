//! Bad data: each kind has its error, which names the culprit, and changes nothing.

use crate::support::check;
use crate::support::sizes::block_rows;
use nalgebra::{SMatrix, SVector, matrix, vector};
use stiction::{
    AdmmFactor, AdmmSolver, Contact, Error, Factor, Input, JointRow, List, Model, Part, RowLaw, Scene,
    Settings, Solver, Status, Surface,
};
use testbed::measure::{Law, error_of};

type Planar = Scene<f64, 2, 2, 2>;

const NOT_FINITE: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
const NOT_FRICTION: [f64; 5] = [-1e-9, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200];

fn floor() -> Contact<f64, 2, 2> {
    Contact { jacobian: matrix![0.0, 1.0; 1.0, 0.0], offset: vector![0.1, 0.0], mu: 0.5, key: 0 }
}

/// Two kilogrammes on a floor.
fn scene() -> Planar {
    let mut scene = Scene::new();
    scene.set_mass(&MASS).expect("a mass matrix");
    scene.push(&floor()).expect("a contact");
    scene
}

/// The call fails with this error and leaves the scene as it was.
fn refuses(error: Error, call: impl FnOnce(&mut Planar) -> Result<(), Error>) {
    let mut scene = scene();
    let (mass, contacts) = (*scene.mass(), scene.contacts().to_vec());
    assert_eq!(call(&mut scene), Err(error));
    assert_eq!(*scene.mass(), mass);
    assert_eq!(scene.contacts(), contacts);
}

#[test]
fn a_mass_matrix_is_made_of_numbers() {
    for (row, column, bad) in NOT_FINITE.into_iter().flat_map(|x| [(0, 0, x), (1, 0, x), (0, 1, x)]) {
        let mut mass = matrix![1.0, 0.0; 0.0, 1.0];
        mass[(row, column)] = bad;
        let input = Input::Mass;
        refuses(Error::NotFinite { input, row, column }, |scene| scene.set_mass(&mass));
    }
}

#[test]
fn a_mass_matrix_is_symmetric_up_to_rounding() {
    for bad in [0.5, -1.0, 1e-6] {
        let mass = matrix![1.0, bad; 0.0, 1.0];
        let error = Error::MassNotSymmetric { row: 1, column: 0 };
        refuses(error, |scene| scene.set_mass(&mass));
    }
    let rounded = matrix![1.0, 0.1; 0.1 + f64::EPSILON, 1.0];
    assert_eq!(scene().set_mass(&rounded), Ok(()));
    // In f32 products of two of these overflow and vanish.
    let mut scene = Scene::<f32, 2, 2, 1>::new();
    let (size, refused) = (1e20, Err(Error::MassNotSymmetric { row: 1, column: 0 }));
    assert_eq!(scene.set_mass(&matrix![size, 0.0; 1e18, size]), refused);
    let (size, entry) = (1e-25, 1e-26_f32);
    let next = entry.next_up();
    assert_eq!(scene.set_mass(&matrix![size, entry; next, size]), Ok(()));
}

/// What is overlooked in a mass matrix must not stand between its factor and the judge of the error.
#[test]
fn a_mass_matrix_that_is_nearly_symmetric_is_made_so() -> Result<(), Error> {
    let mut scene = scene();
    scene.set_mass(&matrix![1.0, 1e-9; 0.0, 1.0])?;
    assert_eq!(*scene.mass(), matrix![1.0, 1e-9; 1e-9, 1.0]);
    let (factor, mut solver) = (Factor::new(&scene)?, Solver::new());
    let solution = solver.solve(&scene, &factor, &vector![1.0, -1.0], &Settings::new(1e-12))?;
    assert_eq!(solution.status, Status::Solved);
    Ok(())
}

#[test]
fn a_mass_matrix_is_positive_definite() {
    let indefinite = [
        (0, matrix![-1.0, 0.0; 0.0, 1.0]),
        (0, matrix![0.0, 0.0; 0.0, 1.0]),
        (1, matrix![1.0, 0.0; 0.0, 0.0]),
        // Velocities are eliminated from the last to the first.
        (0, matrix![1.0, 2.0; 2.0, 1.0]),
        (0, matrix![1.0, 1.0; 1.0, 1.0]),
    ];
    for (dof, mass) in indefinite {
        let mut scene = scene();
        assert_eq!(scene.set_mass(&mass), Ok(()));
        let error = Factor::new(&scene).map(|_| ());
        assert_eq!(error, Err(Error::MassNotPositiveDefinite { dof }));
    }
}

#[test]
fn a_scene_without_mass_is_not_factorised() {
    let error = Factor::new(&Planar::new()).map(|_| ());
    assert_eq!(error, Err(Error::MassNotPositiveDefinite { dof: 1 }));
}

#[test]
fn a_jacobian_is_made_of_numbers() {
    for (row, column, bad) in NOT_FINITE.into_iter().flat_map(|x| [(0, 1, x), (1, 0, x)]) {
        let mut contact = floor();
        contact.jacobian[(row, column)] = bad;
        let error = |contact| {
            let input = Input::Jacobian { contact };
            Error::NotFinite { input, row, column }
        };
        refuses(error(1), |scene| scene.push(&contact).map(|_| ()));
        refuses(error(0), |scene| scene.set_jacobian(0, &contact.jacobian));
    }
}

#[test]
fn an_offset_is_made_of_numbers() {
    for (row, bad) in NOT_FINITE.into_iter().flat_map(|x| [(0, x), (1, x)]) {
        let mut contact = floor();
        contact.offset[row] = bad;
        let error = |contact| {
            let input = Input::Offset { contact };
            Error::NotFinite { input, row, column: 0 }
        };
        refuses(error(1), |scene| scene.push(&contact).map(|_| ()));
        refuses(error(0), |scene| scene.set_offset(0, &contact.offset));
    }
}

#[test]
fn a_friction_coefficient_is_a_number_from_zero_up() {
    for mu in NOT_FRICTION {
        let contact = Contact { mu, ..floor() };
        let error = |contact| Error::InvalidFriction { contact, row: 1 };
        refuses(error(1), |scene| scene.push(&contact).map(|_| ()));
        refuses(error(0), |scene| scene.set_friction(0, mu));
    }
}

#[test]
fn a_contact_that_is_not_there_cannot_be_changed() {
    for contact in [1, 2, usize::MAX] {
        let error = Error::NoSuchContact { contact };
        refuses(error, |scene| scene.set_friction(contact, 0.1));
        refuses(error, |scene| scene.set_offset(contact, &SVector::zeros()));
        refuses(error, |scene| scene.set_jacobian(contact, &SMatrix::zeros()));
    }
}

#[test]
fn a_full_scene_takes_no_contact() {
    let mut scene = scene();
    assert_eq!(scene.push(&floor()), Ok(1));
    assert_eq!(scene.push(&floor()), Err(Error::ListFull { list: List::Contacts, capacity: 2 }));
    assert_eq!(scene.contacts().len(), 2);
    scene.clear_contacts();
    assert_eq!(scene.push(&floor()), Ok(0));
}

#[test]
fn a_penalty_is_a_usable_positive_number() -> Result<(), Error> {
    let (scene, push) = (scene(), vector![0.1, -1.0]);
    let untouched = AdmmFactor::new(&scene)?;
    let mut factor = untouched.clone();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(factor.set_penalty(bad), Err(Error::InvalidPenalty), "{bad}");
        assert_eq!(factor.penalty().to_bits(), untouched.penalty().to_bits());
    }
    let status = check::same_by_admm(&scene, [&untouched, &factor], &push, &Settings::new(1e-9))?;
    assert_eq!(status, Status::Solved);
    Ok(())
}

/// The same with one row a contact, where the last pivot is the only one of its block.
#[test]
fn a_penalty_that_drowns_the_unit_matrix_is_refused_without_friction() -> Result<(), Error> {
    let mut scene = Scene::<f64, 1, 1, 2>::new();
    scene.set_mass(&matrix![2.0])?;
    for key in 0..2 {
        scene.push(&Contact { jacobian: matrix![1.0], offset: vector![0.0], mu: 0.0, key })?;
    }
    let mut factor = AdmmFactor::new(&scene)?;
    assert_eq!(factor.set_penalty(1e300), Err(Error::InvalidPenalty));
    Ok(())
}

/// `rho W` swallows the unit matrix: two contacts on one point make `W` singular.
#[test]
fn a_penalty_that_drowns_the_unit_matrix_is_refused() -> Result<(), Error> {
    let mut scene = scene();
    scene.push(&floor())?;
    let untouched = AdmmFactor::new(&scene)?;
    let mut factor = untouched.clone();
    assert_eq!(factor.set_penalty(1e300), Err(Error::InvalidPenalty));
    assert_eq!(factor.penalty().to_bits(), untouched.penalty().to_bits());
    let (push, settings) = (vector![0.1, -1.0], Settings::new(1e-9));
    check::same_by_admm(&scene, [&untouched, &factor], &push, &settings)?;
    Ok(())
}

#[test]
fn a_tolerance_is_a_number() -> Result<(), Error> {
    let scene = scene();
    let (factor, push) = (AdmmFactor::new(&scene)?, SVector::zeros());
    let refused = Some(Error::InvalidTolerance);
    for bad in [f64::NAN, f64::INFINITY, -1e-9] {
        let settings = Settings::new(bad);
        let (mut solver, mut admm) = (Solver::new(), AdmmSolver::new());
        assert_eq!(solver.solve(&scene, factor.factor(), &push, &settings).err(), refused);
        assert_eq!(solver.resume(&scene, factor.factor(), &push, &settings).err(), refused);
        let restart = admm.solve(&scene, &factor, &push, &settings);
        assert_eq!(restart.err(), refused);
    }
    Ok(())
}

#[test]
fn a_factor_belongs_to_its_number_of_contacts() -> Result<(), Error> {
    let mut scene = scene();
    let factor = AdmmFactor::new(&scene)?;
    scene.push(&floor())?;
    let (push, settings) = (SVector::zeros(), Settings::default());
    let error = Error::StaleFactor;
    assert_eq!(Solver::new().solve(&scene, factor.factor(), &push, &settings).err(), Some(error));
    let mut admm = AdmmSolver::new();
    assert_eq!(admm.solve(&scene, &factor, &push, &settings).err(), Some(error));
    Ok(())
}

fn built_anew(scene: &mut Planar, jacobian: SMatrix<f64, 2, 2>) -> Result<(), Error> {
    *scene = Planar::new();
    scene.set_mass(&MASS)?;
    let contact = Contact { jacobian, ..floor() };
    scene.push(&contact).map(|_| ())
}

type Change = dyn Fn(&mut Planar) -> Result<(), Error>;

const MASS: SMatrix<f64, 2, 2> = matrix![2.0, 0.5; 0.5, 2.0];
const OTHER: SMatrix<f64, 2, 2> = matrix![0.1, 1.0; 1.0, 0.0];

/// What changes a scene's `M` or `H`; what changes neither leaves the factor as good as it was.
#[test]
fn a_stale_factor_is_refused_until_it_is_prepared_anew() -> Result<(), Error> {
    let (push, settings) = (vector![0.1, -1.0], Settings::new(1e-9));

    let changes: [(&Change, bool); 8] = [
        (&|scene| scene.set_mass(&matrix![3.0, 0.5; 0.5, 2.0]), true),
        (&|scene| scene.set_mass(&MASS), false),
        (&|scene| scene.set_jacobian(0, &OTHER), true),
        (&|scene| scene.set_jacobian(0, &floor().jacobian), false),
        (&|scene| built_anew(scene, floor().jacobian), false),
        // As often changed as the one that the factor is of.
        (&|scene| built_anew(scene, OTHER), true),
        (&|scene| scene.set_offset(0, &vector![0.2, 0.0]), false),
        (&|scene| scene.set_friction(0, 0.7), false),
    ];
    for (change, makes_stale) in changes {
        let mut scene = scene();
        let mut factor = AdmmFactor::new(&scene)?;
        change(&mut scene)?;
        let (mut solver, mut admm) = (Solver::new(), AdmmSolver::new());
        let refused = makes_stale.then_some(Error::StaleFactor);
        let solved = solver.solve(&scene, factor.factor(), &push, &settings);
        assert_eq!(solved.err(), refused);
        let solved = admm.solve(&scene, &factor, &push, &settings);
        assert_eq!(solved.err(), refused);
        factor.prepare(&scene)?;
        let solution = solver.solve(&scene, factor.factor(), &push, &settings)?;
        assert!(solution.is_solved());
    }
    let (mut empty, mut solver) = (Planar::new(), Solver::new());
    empty.set_mass(&SMatrix::identity())?;
    let refused = solver.solve(&empty, &Factor::empty(), &push, &settings).err();
    assert_eq!(refused, Some(Error::StaleFactor));
    Ok(())
}

/// Two Jacobians that change at once in the same way: what one does to the fingerprint the other must not undo.
#[test]
fn changes_that_resemble_each_other_do_not_cancel() -> Result<(), Error> {
    let flips: [fn(f64) -> f64; 3] = [|x| -x, |x| 2.0 * x, |x| x + 1.0];
    for flip in flips {
        for entry in 0..4 {
            let mut scene = scene();
            scene.push(&floor())?;
            let factor = Factor::new(&scene)?;
            let mut jacobian = floor().jacobian;
            jacobian[entry] = flip(jacobian[entry] + 0.5);
            for contact in 0..2 {
                scene.set_jacobian(contact, &jacobian)?;
                assert!(!factor.is_current(&scene), "entry {entry} of contact {contact}");
            }
        }
    }
    Ok(())
}

#[test]
fn nothing_is_solved_before_the_first_solve() {
    let solver = Solver::<f64, 2, 2, 2>::new();
    assert_eq!(solver.solution().status, Status::Unsolved);
    assert!(!solver.solution().is_solved());
    let admm = AdmmSolver::<f64, 2, 2, 2>::new();
    assert_eq!(admm.solution().status, Status::Unsolved);
}

#[test]
fn a_free_impulse_is_made_of_numbers_and_a_refusal_keeps_the_solution() -> Result<(), Error> {
    let scene = scene();
    let (factor, settings) = (Factor::new(&scene)?, Settings::new(1e-9));
    let mut solver = Solver::new();
    let before = solver.solve(&scene, &factor, &vector![0.1, -1.0], &settings)?.clone();
    for (row, bad) in NOT_FINITE.into_iter().flat_map(|x| [(0, x), (1, x)]) {
        let mut push = vector![0.1, -1.0];
        push[row] = bad;
        let input = Input::FreeImpulse;
        let error = Error::NotFinite { input, row, column: 0 };
        assert_eq!(solver.solve(&scene, &factor, &push, &settings).err(), Some(error));
        let after = solver.solution();
        assert_eq!((after.velocity, after.status), (before.velocity, before.status));
    }
    Ok(())
}

/// A failed factorisation must not serve a scene it does not belong to.
#[test]
fn a_factor_that_failed_solves_nothing() -> Result<(), Error> {
    let good = scene();
    let mut factor = Factor::new(&good)?;
    let mut bad = scene();
    bad.set_mass(&-SMatrix::identity())?;
    for _ in 0..2 {
        assert!(factor.prepare(&bad).is_err());
        let mut solver = Solver::new();
        let solution = solver.solve(&good, &factor, &vector![0.1, -1.0], &Settings::default());
        assert!(solution.is_err());
        factor.prepare(&good)?;
    }
    Ok(())
}

/// Finite data may overflow on the way; that is an error or an unsolved scene, not a panic.
#[test]
fn extreme_numbers_do_not_panic() -> Result<(), Error> {
    for size in [1e-300, 1e-150, 1e150, 1e300] {
        for mass in [1e-300, 1.0, 1e300] {
            let mut scene = Scene::<f64, 2, 2, 2>::new();
            scene.set_mass(&SMatrix::from_diagonal_element(mass))?;
            let jacobian = floor().jacobian * size;
            scene.push(&Contact { jacobian, ..floor() })?;
            let Ok(factor) = Factor::new(&scene) else {
                continue;
            };
            let push = vector![size, -size];
            let mut solver = Solver::new();
            let solution = solver.solve(&scene, &factor, &push, &Settings::new(1e-6))?;
            let finite = solution.velocity.iter().all(|v| v.is_finite());
            assert!(solution.status != Status::Solved || finite, "{size:e} {mass:e}");
        }
    }
    Ok(())
}

#[test]
fn every_error_says_which_datum_is_wrong() {
    let full = |list, capacity| Error::ListFull { list, capacity };
    let texts = [
        (Error::NotFinite { input: Input::Mass, row: 3, column: 4 }, "mass matrix M: entry (3, 4)"),
        (
            Error::NotFinite { input: Input::Jacobian { contact: 5 }, row: 1, column: 2 },
            "Jacobian H of contact 5: entry (1, 2)",
        ),
        (
            Error::NotFinite { input: Input::Offset { contact: 6 }, row: 1, column: 0 },
            "offset w of contact 6: entry (1, 0)",
        ),
        (Error::NotFinite { input: Input::FreeImpulse, row: 7, column: 0 }, "free impulse: entry (7, 0)"),
        (
            Error::NotFinite { input: Input::InitialImpulse { contact: 2 }, row: 1, column: 0 },
            "initial impulse 2: entry (1, 0)",
        ),
        (Error::MassNotSymmetric { row: 3, column: 4 }, "M is not symmetric at (3, 4)"),
        (Error::MassNotPositiveDefinite { dof: 8 }, "dof 8"),
        (Error::InvalidFriction { contact: 9, row: 3 }, "mu of contact 9, row 3"),
        (full(List::Contacts, 10), "contacts are full (room for 10)"),
        (
            Error::InvalidVelocityCount { velocities: 31, capacity: 30 },
            "a scene cannot have 31 velocities (1 to 30)",
        ),
        (Error::NoSuchContact { contact: 11 }, "no contact 11"),
        (full(List::Rows, 36), "joint rows are full (room for 36)"),
        (full(List::Surfaces, 2), "contacts with surfaces are full (room for 2)"),
        (Error::NoSuchRow { row: 13 }, "no joint row 13"),
        (Error::LimitsLeftOut, "the paused solve has limits"),
        (Error::NoSolution, "no solution with an error within the tolerance"),
        (Error::SceneChanged, "the scene is not that of the solution"),
        (Error::InvalidRowCompliance { row: 14 }, "compliance of joint row 14"),
        (Error::InvalidLimit { limit: 14 }, "bounds or compliance of limit 14"),
        (Error::LimitKeyTaken { limit: 16 }, "limit 16 has the key of another"),
        (Error::InvalidBounds { row: 15 }, "bounds of joint row 15"),
        (
            Error::NotFinite { input: Input::InitialRowImpulse { row: 17 }, row: 0, column: 0 },
            "initial impulse 17 of joint rows",
        ),
        (
            Error::NotFinite { input: Input::JointRow { row: 18 }, row: 1, column: 0 },
            "joint row 18: entry (1, 0)",
        ),
        (Error::InvalidPenalty, "penalty rho"),
        (Error::DelassusOutOfRange { contact: 14 }, "contact 14 overflows"),
        (Error::InvalidTolerance, "tolerance"),
        (Error::StaleFactor, "factor is not that of the scene"),
    ];
    for (error, text) in texts {
        assert!(error.to_string().contains(text), "{error}");
    }
}

/// A contact between two things that stand still: whether it is met is known, and no impulse changes it.
#[test]
fn a_contact_that_nothing_moves_is_met_or_infeasible() -> Result<(), Error> {
    let mut scene = scene();
    scene.push(&Contact { jacobian: SMatrix::zeros(), ..floor() })?;
    let factor = Factor::new(&scene)?;
    let push = vector![0.3, -0.2];
    let settings = Settings::new(1e-9);
    for (offset, is_met) in [
        (vector![0.1, 3.0], true),
        (vector![0.0, 3.0], true),
        (vector![0.0, 0.0], true),
        (vector![-1e-3, 0.0], false),
    ] {
        scene.set_offset(1, &offset)?;
        let mut solver = Solver::new();
        let solution = solver.solve(&scene, &factor, &push, &settings)?;
        let worst = solution.worst_contact(&scene, &factor);
        let error = error_of(&scene, &push, solution, Law::Coulomb);
        if is_met {
            assert!(solution.is_solved() && error <= 1e-9);
        } else {
            assert_eq!(solution.status, Status::Infeasible);
            assert!(solution.work.total() <= 30); // not the budget
            assert!(solution.error == f64::INFINITY && error == f64::INFINITY);
            assert!(solution.certificate[0][0] == 0.0 && solution.certificate[1][0] > 0.0);
            assert_eq!(worst, Some(1));
        }
        let relaxed = Settings { model: Model::ConvexRelaxation, ..settings };
        let solution = solver.solve(&scene, &factor, &push, &relaxed)?;
        // It would have to separate as it slides.
        assert_eq!(solution.is_solved(), offset[0] >= 0.5 * offset[1]);
        // And without Newton's method.
        let factor = AdmmFactor::new(&scene)?;
        let mut solver = AdmmSolver::new();
        let solution = solver.solve(&scene, &factor, &push, &Settings { budget: 2_000, ..settings })?;
        assert_eq!(solution.is_solved(), is_met);
    }
    Ok(())
}

/// A solver whose first call is refused claims no error of 0.
#[test]
fn what_was_refused_first_has_an_infinite_error() -> Result<(), Error> {
    let scene = scene();
    let factor = AdmmFactor::new(&scene)?;
    let mut solver = AdmmSolver::new();
    let refused = solver.solve(&scene, &factor, &vector![f64::NAN, 0.0], &Settings::new(1e-4));
    assert!(refused.is_err());
    let solution = solver.solution();
    assert_eq!((solution.status, solution.error), (Status::Unsolved, f64::INFINITY));
    Ok(())
}

/// Half a scene would be solved as if nothing else were there: a foot whose Jacobian is broken would push with nothing.
#[test]
fn half_a_scene_is_not_solved() -> Result<(), Error> {
    let mut kernel = block_rows::Kernel::<f64>::new();
    let (push, settings) = (vector![0.0, -1.0], Settings::new(1e-9));
    let nan = f64::NAN;
    let bad = Contact { offset: vector![nan, 0.0], ..floor() };
    let soft = Surface { compliance: [nan, 0.0], ..Surface::isotropic(0.5) };
    let row =
        |offset| JointRow { row: vector![1.0, 0.0], offset, law: RowLaw::Limit, compliance: 0.0, key: 0 };
    let mut refused = |part, fill: &mut dyn FnMut(&mut block_rows::Scene<f64>)| {
        let error = Err(Error::SceneIncomplete { part });
        let scene = kernel.scene_mut();
        scene.clear();
        scene.set_mass(&MASS)?;
        scene.push(&floor())?;
        assert!(kernel.solve(&push, &settings)?.is_solved());
        // Also where the factor is that of what is there.
        fill(kernel.scene_mut());
        assert_eq!(kernel.solve(&push, &settings).map(|_| ()), error);
        assert_eq!(kernel.resume(&push, &settings).map(|_| ()), error);
        assert_eq!(kernel.advance(&push, &settings).map(|_| ()), error);
        let limited = kernel.solve_with_limits(&[], &push, &settings);
        assert_eq!(limited.map(|_| ()), error);
        assert_eq!(Factor::new(kernel.scene()).map(|_| ()), error);
        assert!(kernel.solution().is_solved()); // the last one stays
        // A contact more does not make it whole.
        kernel.scene_mut().remove_contact(0)?;
        kernel.scene_mut().push(&floor())?;
        assert_eq!(kernel.solve(&push, &settings).map(|_| ()), error);
        // Nor does another part.
        if part == Part::Mass {
            kernel.scene_mut().clear();
        } else {
            kernel.scene_mut().set_mass(&MASS)?;
        }
        assert_eq!(kernel.solve(&push, &settings).map(|_| ()), error);
        let scene = kernel.scene_mut();
        match part {
            Part::Mass => scene.set_mass(&MASS)?,
            Part::Contact => scene.clear_contacts(),
            _ => scene.clear_rows(),
        }
        assert!(kernel.solve(&push, &settings)?.is_solved());
        Ok::<_, Error>(())
    };
    refused(Part::Contact, &mut |scene| {
        assert!(scene.push(&bad).is_err());
    })?;
    refused(Part::Contact, &mut |scene| {
        assert!(scene.push_on(&floor(), &soft).is_err());
    })?;
    refused(Part::JointRow, &mut |scene| {
        assert!(scene.push_row(&row(nan)).is_err());
    })?;
    refused(Part::Mass, &mut |scene| {
        assert!(scene.set_mass(&(MASS * nan)).is_err());
    })?;
    // One too many is missing as well.
    refused(Part::Contact, &mut |scene| {
        assert_eq!(scene.push(&floor()), Ok(1));
        assert!(scene.push(&floor()).is_err());
        assert_eq!(scene.remove_contact(0), Ok(()));
    })
}
