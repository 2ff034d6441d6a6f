//! Scenes with fewer velocities than there is room for: one kernel serves several robots.
#![allow(clippy::float_cmp)] // to the last bit

use crate::support::random::{draws, numbers};
use crate::support::sizes::{bodies, body_rows};
use nalgebra::{SMatrix, SVector};
use stiction::{
    Contact, Error, Factor, Inputs, JointRow, Outputs, RowLaw, Scene, Settings, Solution, Solver, Surface,
};
use testbed::format;
use testbed::kernel::{Constructor, Shape, smallest};
use testbed::measure::{self, Law};
use testbed::method::Method;
use testbed::mixed::{self, MixedFile};
use testbed::mixed_measure;
use testbed::scene_file::{bundled_scenes, json_files, repository};

const NAN: f64 = f64::NAN;

/// The room of [`bodies`], and of [`body_rows`].
const LARGE: usize = 10;
const SMALL: usize = 6;

#[test]
fn a_bundled_scene_in_a_larger_size_has_the_bits_of_its_own() -> Result<(), Error> {
    let (double, single): (Constructor, Constructor) = (smallest::<f64>, smallest::<f32>);
    let mut compared = 0;
    for file in bundled_scenes() {
        let large = Shape { dofs: 30, contacts: 12, ..Shape::of(&file) };
        for (kernel, method, tolerance) in [
            (double, Method::Default, 1e-3),
            (double, Method::Default, 1e-9),
            (double, Method::Restart, 1e-3),
            (single, Method::Default, 1e-4),
            (single, Method::Restart, 1e-3),
        ] {
            let settings = Settings { budget: 1_000, ..Settings::new(tolerance) };
            let answers = [Shape::of(&file), large].map(|shape| {
                let mut kernel = kernel(shape).expect("a size is compiled");
                kernel.load(&file)?;
                kernel.prepare(method)?;
                kernel.solve(method, &settings)?;
                Ok(kernel.answer())
            });
            let [own, found] = answers;
            let (own, found) = (own?, found?);
            let name = format!("{} to {tolerance:e} by {method:?}", file.name);
            assert_eq!(found, own, "{name}");
            if found.status == stiction::Status::Solved {
                let error = measure::error(&file, &found.v, &found.r, Law::Coulomb);
                assert!(error <= tolerance, "{name}: {error:e}");
            }
            compared += usize::from(file.n_dof < 30);
        }
    }
    assert!(compared > 200);
    Ok(())
}

/// With joint rows, surfaces and limits. (The sizes differ in their room for contacts and rows, too.)
#[test]
fn a_bundled_scene_with_rows_in_a_larger_size_ends_as_in_a_smaller_one() {
    let mut compared = 0;
    for path in json_files(&repository().join("tests/mixed")) {
        let mut file = format::read(&path).expect("it can be read").remove(0);
        for (inside, tolerance) in [(false, 1e-6), (true, 1e-9)] {
            file.limits_inside = inside;
            let settings = Settings::new(tolerance);
            let small = match (file.dim, file.n_dof) {
                (3, ..=SMALL) => mixed::solve_in::<f64, SMALL, 3, 8, 6>(&file, &settings, 1),
                (3, ..=LARGE) => mixed::solve_in::<f64, LARGE, 3, 8, 6>(&file, &settings, 1),
                (4, ..=6) => mixed::solve_in::<f64, 6, 4, 4, 6>(&file, &settings, 1),
                (6, ..=6) => mixed::solve_in::<f64, 6, 6, 4, 6>(&file, &settings, 1),
                _ => continue,
            };
            let (small, _) = small.expect("it is sound");
            let (large, _) = mixed::solve::<f64>(&file, &settings, 1).expect("it is sound");
            assert_eq!(large.status, small.status, "{}", file.name);
            for answer in [&small, &large] {
                assert_eq!(answer.v.len(), file.n_dof);
                if answer.status == stiction::Status::Solved {
                    let error = mixed_measure::error(&file, &answer.v, &answer.r, &answer.lambda);
                    assert!(error <= tolerance, "{} to {tolerance:e}: {error:e}", file.name);
                }
            }
            compared += 1;
        }
    }
    assert!(compared >= 20, "{compared}");
}

/// Some bodies: what is asked of them, and what stands behind their velocities.
struct Bodies<'a> {
    n: usize,
    numbers: &'a [f64],
    /// Of the first contact and row.
    key: u32,
    behind: f64,
}

impl Bodies<'_> {
    fn at(&self, place: usize) -> f64 {
        self.numbers[place % self.numbers.len()]
    }

    /// An entry over the velocities.
    fn over(&self, j: usize, place: usize) -> f64 {
        if j < self.n { self.at(place + 7 * j) } else { self.behind }
    }

    fn mass<const N: usize>(&self) -> SMatrix<f64, N, N> {
        SMatrix::from_fn(|i, j| {
            if i.max(j) >= self.n {
                return self.behind;
            }
            let product = |k| self.at(31 * i + k) * self.at(31 * j + k);
            (0..self.n).map(product).sum::<f64>() + if i == j { 1.0 } else { 0.0 }
        })
    }

    fn contact<const N: usize>(&self, i: usize) -> Contact<f64, N, 3> {
        Contact {
            jacobian: SMatrix::from_fn(|row, j| self.over(j, 101 * i + 37 * row + 5)),
            // At rest no contact closes and no limit is violated: there is a solution.
            offset: SVector::from_fn(|row, _| if row == 0 { 0.01 * self.at(11 * i).abs() } else { 0.0 }),
            mu: 0.2 + 0.3 * self.at(i).abs(),
            key: self.key + u32::try_from(i).expect("a few"),
        }
    }

    fn row<const N: usize>(&self, i: usize) -> JointRow<f64, N> {
        let bounds = RowLaw::Box { lower: -0.1, upper: 0.2 };
        JointRow {
            row: SVector::from_fn(|j, _| self.over(j, 53 * i + 3)),
            offset: 0.01 * self.at(13 * i).abs(),
            law: if i.is_multiple_of(2) { RowLaw::Limit } else { bounds },
            compliance: 0.0,
            key: self.key + u32::try_from(i).expect("a few"),
        }
    }

    fn push<const N: usize>(&self) -> SVector<f64, N> {
        SVector::from_fn(|j, _| self.over(j, 2))
    }

    /// Three contacts, one on a surface, and two joint rows.
    fn fill<const N: usize>(&self, scene: &mut Scene<f64, N, 3, 8, 6, 8>) -> Result<(), Error> {
        scene.clear();
        scene.set_velocities(self.n)?;
        scene.set_mass(&self.mass())?;
        scene.push(&self.contact(0))?;
        let (friction, compliance) = ([0.3, 0.5], [0.01, 0.02]);
        scene.push_on(&self.contact(1), &Surface { friction, spin: 0.0, roll: [0.0; 2], compliance })?;
        scene.push(&self.contact(2))?;
        scene.push_row(&self.row(0))?;
        scene.push_row(&self.row(1))?;
        Ok(())
    }

    /// The scene in the file that a stranger reads.
    fn file(&self, scene: &Scene<f64, LARGE, 3, 8, 6, 8>) -> MixedFile {
        let n = self.n;
        let text = serde_json::json!({
            "name": "bodies",
            "n_dof": n,
            "n_contacts": 3,
            "dim": 3,
            "M": scene.mass().row_iter().take(n).map(|row| row.iter().take(n).copied().collect::<Vec<_>>()).collect::<Vec<_>>(),
            "H": scene.contacts().iter().flat_map(|contact| {
                let rows = contact.jacobian.row_iter();
                rows.map(|row| row.iter().take(n).copied().collect::<Vec<_>>()).collect::<Vec<_>>()
            }).collect::<Vec<_>>(),
            "f": self.push::<LARGE>().iter().take(n).map(|x| -x).collect::<Vec<_>>(),
            "w": scene.contacts().iter().flat_map(|contact| contact.offset.iter().copied().collect::<Vec<_>>()).collect::<Vec<_>>(),
            "mu": [serde_json::json!(scene.contacts()[0].mu), serde_json::json!([0.3, 0.5]), serde_json::json!(scene.contacts()[2].mu)],
            "compliance": [[0.0, 0.0], [0.01, 0.02], [0.0, 0.0]],
            "joints": [
                { "kind": "limit", "row": scene.rows()[0].row.as_slice()[..n], "offset": scene.rows()[0].offset },
                { "kind": "box", "row": scene.rows()[1].row.as_slice()[..n], "offset": scene.rows()[1].offset, "lower": -0.1, "upper": 0.2 },
            ],
        });
        format::read_text(&text.to_string(), "bodies").expect("it can be read").remove(0)
    }
}

/// What the stranger says of a solution.
fn error(bodies: &Bodies<'_>, scene: &Scene<f64, LARGE, 3, 8, 6, 8>, found: &bodies::Solution<f64>) -> f64 {
    let r: Vec<f64> = found.contacts.iter().flat_map(|c| c.impulse.iter().copied()).collect();
    let lambda: Vec<f64> = found.rows.iter().map(|row| row.impulse).collect();
    mixed_measure::error(&bodies.file(scene), &found.velocity.as_slice()[..bodies.n], &r, &lambda)
}

/// All numbers of a solution, without those behind its velocities, which are 0.
fn bits<const N: usize>(n: usize, solution: &Solution<f64, N, 3, 8, 6>) -> Vec<u64> {
    assert!(solution.velocity.iter().skip(n).all(|&v| v == 0.0));
    let contacts = solution.contacts.iter().flat_map(|c| c.impulse.iter().chain(&c.velocity));
    let rows = solution.rows.iter().flat_map(|row| [&row.impulse, &row.velocity]);
    let numbers = solution.velocity.iter().take(n).chain(contacts).chain(rows).chain([&solution.error]);
    // Zeros of both signs are equal.
    let mut bits: Vec<u64> = numbers.map(|x| (x + 0.0).to_bits()).collect();
    bits.push(u64::try_from(solution.work.total()).expect("not many"));
    bits
}

const TICK: Settings<f64> = Settings::new(1e-9);

/// Numbers of velocities, tick by tick: robots take turns, pick something up, put it down.
const TICKS: [usize; 16] = [10, 6, 6, 9, 3, 10, 1, 6, 2, 2, 6, 5, 9, 4, 7, 8];

#[test]
fn a_kernel_changes_between_robots_tick_by_tick() -> Result<(), Error> {
    let mut kernel = Box::new(bodies::Kernel::<f64>::new());
    for (tick, x) in (0_u32..).zip(draws(numbers(97), 64)) {
        let n = TICKS[usize::try_from(tick).expect("few") % TICKS.len()];
        let bodies = Bodies { n, numbers: &x, key: 100 * tick, behind: NAN };
        bodies.fill(kernel.scene_mut())?;
        let found = kernel.solve(&bodies.push(), &TICK)?.clone();
        // No contact is known from the last tick: it starts cold, whatever was before.
        let mut new = Box::new(bodies::Kernel::<f64>::new());
        bodies.fill(new.scene_mut())?;
        let cold = new.solve(&bodies.push(), &TICK)?;
        assert_eq!(bits(n, &found), bits(n, cold), "{tick}: {n}");
        assert!(found.is_solved(), "{tick}: {n} {:?}", found.status);
        let error = error(&bodies, kernel.scene(), &found);
        assert!(error <= TICK.tolerance, "{tick}: {n} {error:e}");
        if n <= SMALL {
            let mut own = Box::new(body_rows::Kernel::<f64>::new());
            bodies.fill(own.scene_mut())?;
            assert_eq!(bits(n, own.solve(&bodies.push(), &TICK)?), bits(n, &found), "{tick}: {n}");
        }
    }
    Ok(())
}

/// Contacts with the same keys start where they were, and are solved nonetheless.
#[test]
fn impulses_of_other_robots_under_the_same_keys_do_no_harm() -> Result<(), Error> {
    let mut kernel = Box::new(bodies::Kernel::<f64>::new());
    let mut moved = 0;
    for (tick, x) in draws(numbers(97), 64).enumerate() {
        let bodies = Bodies { n: TICKS[tick % TICKS.len()], numbers: &x, key: 0, behind: NAN };
        bodies.fill(kernel.scene_mut())?;
        let found = kernel.solve(&bodies.push(), &TICK)?.clone();
        assert!(found.is_solved(), "{tick}: {:?}", found.status);
        let error = error(&bodies, kernel.scene(), &found);
        assert!(error <= TICK.tolerance, "{tick}: {error:e}");
        kernel.solver_mut().reset();
        let cold = kernel.solve(&bodies.push(), &TICK)?;
        moved += usize::from(bits(bodies.n, &found) != bits(bodies.n, cold));
    }
    assert!(moved > 16, "no warm start: {moved}");
    Ok(())
}

#[test]
fn a_factor_of_another_number_of_velocities_is_stale() -> Result<(), Error> {
    let x = draws(numbers(97), 1).next().expect("one");
    let bodies = |n| Bodies { n, numbers: &x, key: 0, behind: NAN };
    let mut scene = Box::new(Scene::new());
    bodies(6).fill(&mut scene)?;
    let (mut factor, mut solver) = (Factor::new(&scene)?, Solver::<f64, LARGE, 3, 8, 6>::new());
    assert!(factor.is_current(&scene));
    bodies(7).fill(&mut scene)?;
    let (push, stale) = (bodies(7).push(), Some(Error::StaleFactor));
    assert_eq!(solver.solve(&scene, &factor, &push, &TICK).err(), stale);
    factor.prepare(&scene)?;
    assert!(solver.solve(&scene, &factor, &push, &TICK)?.is_solved());
    // A paused solve of the other robot is not gone on with.
    let one = Settings { budget: 1, ..TICK };
    let mut kernel = Box::new(bodies::Kernel::<f64>::new());
    bodies(7).fill(kernel.scene_mut())?;
    kernel.solve(&bodies(7).push(), &one)?;
    bodies(6).fill(kernel.scene_mut())?;
    kernel.solver_mut().reset();
    let mut whole = kernel.clone();
    while kernel.resume(&bodies(6).push(), &one)?.status == stiction::Status::OutOfBudget {}
    let whole = whole.solve(&bodies(6).push(), &TICK)?;
    assert_eq!(bits(6, kernel.solution()), bits(6, whole));
    Ok(())
}

/// The same number is no change, a new one removes all there was, and there is no mass then.
#[test]
fn a_new_number_empties_the_scene() -> Result<(), Error> {
    let x = draws(numbers(97), 1).next().expect("one");
    let mut kernel = Box::new(bodies::Kernel::<f64>::new());
    assert_eq!(kernel.scene().velocities(), LARGE);
    let bodies = Bodies { n: 6, numbers: &x, key: 0, behind: 0.0 };
    bodies.fill(kernel.scene_mut())?;
    let before = kernel.solve(&bodies.push(), &TICK)?.velocity;
    kernel.scene_mut().set_velocities(6)?;
    assert_eq!((kernel.scene().contacts().len(), kernel.scene().rows().len()), (3, 2));
    assert_eq!(kernel.solve(&bodies.push(), &TICK)?.velocity, before);
    // Also what was refused is forgotten.
    assert!(kernel.scene_mut().push(&Contact { mu: -1.0, ..bodies.contact(0) }).is_err());
    kernel.scene_mut().set_velocities(7)?;
    let scene = kernel.scene();
    assert_eq!((scene.velocities(), scene.contacts().len(), scene.rows().len()), (7, 0, 0));
    assert_eq!(scene.mass().amax(), 0.0);
    let no_mass = Some(Error::MassNotPositiveDefinite { dof: 6 });
    assert_eq!(kernel.solve(&bodies.push(), &TICK).err(), no_mass);
    kernel.reset();
    assert_eq!(kernel.scene().velocities(), LARGE);
    Ok(())
}

#[test]
fn a_number_that_is_refused_leaves_the_scene_as_it_was() -> Result<(), Error> {
    let x = draws(numbers(97), 1).next().expect("one");
    let bodies = Bodies { n: 6, numbers: &x, key: 0, behind: NAN };
    let mut kernel = Box::new(bodies::Kernel::<f64>::new());
    bodies.fill(kernel.scene_mut())?;
    let expected = bits(6, kernel.solve(&bodies.push(), &TICK)?);
    let factor = Factor::new(kernel.scene())?;
    for velocities in [0, LARGE + 1, usize::MAX] {
        let refused = kernel.scene_mut().set_velocities(velocities);
        assert_eq!(refused, Err(Error::InvalidVelocityCount { velocities, capacity: LARGE }));
        assert_eq!(kernel.scene().velocities(), 6);
        assert!(factor.is_current(kernel.scene()));
        kernel.solver_mut().reset();
        assert_eq!(bits(6, kernel.solve(&bodies.push(), &TICK)?), expected);
    }
    // A matrix or a row that is refused names an entry in use.
    let wrong = |n: usize| {
        let mut contact = bodies.contact::<LARGE>(0);
        contact.jacobian[(1, n)] = NAN;
        contact
    };
    kernel.scene_mut().push(&wrong(6))?;
    let input = stiction::Input::Jacobian { contact: 4 };
    let refused = Err(Error::NotFinite { input, row: 1, column: 5 });
    assert_eq!(kernel.scene_mut().push(&wrong(5)), refused);
    let mut mass = bodies.mass::<LARGE>();
    (mass[(5, 2)], mass[(2, 5)]) = (NAN, NAN);
    let refused = Err(Error::NotFinite { input: stiction::Input::Mass, row: 5, column: 2 });
    assert_eq!(kernel.scene_mut().set_mass(&mass), refused);
    mass = bodies.mass();
    mass[(5, 2)] += 1.0;
    assert_eq!(kernel.scene_mut().set_mass(&mass), Err(Error::MassNotSymmetric { row: 5, column: 2 }));
    Ok(())
}

/// What stands behind the velocities is not read: no number and another number make no difference, and nothing of it is in the scene.
#[test]
fn what_stands_behind_the_velocities_is_ignored() -> Result<(), Error> {
    for x in draws(numbers(97), 20) {
        for n in [1, 5, 6, 9] {
            let with = |behind| Bodies { n, numbers: &x, key: 0, behind };
            let [mut kernel, mut clean] = [(); 2].map(|()| Box::new(bodies::Kernel::<f64>::new()));
            with(0.0).fill(clean.scene_mut())?;
            with(NAN).fill(kernel.scene_mut())?;
            // Each call that changes a part of a scene.
            for (i, bodies) in [with(NAN), with(f64::INFINITY), with(3.0), with(NAN)].iter().enumerate() {
                let factor = Factor::new(kernel.scene())?;
                let scene = kernel.scene_mut();
                scene.set_mass(&bodies.mass())?;
                scene.set_jacobian(2, &bodies.contact(2).jacobian)?;
                scene.set_row_jacobian(1, &bodies.row(1).row)?;
                assert!(factor.is_current(scene), "{i}");
                assert_eq!(scene.mass(), clean.scene().mass());
                assert_eq!(scene.contacts(), clean.scene().contacts());
                assert_eq!(scene.rows(), clean.scene().rows());
            }
            let expected = bits(n, clean.solve(&with(0.0).push(), &TICK)?);
            assert_eq!(bits(n, kernel.solve(&with(NAN).push(), &TICK)?), expected);
            kernel.solver_mut().reset();
            clean.solver_mut().reset();
            let piece = Settings { budget: 3, ..TICK };
            while !kernel.advance(&with(NAN).push(), &piece)? {}
            assert_eq!(bits(n, kernel.solution()), expected);
        }
    }
    Ok(())
}

/// Limits are rows like others: what is behind is ignored, also of those that are not reached.
#[test]
fn limits_end_where_the_velocities_do() -> Result<(), Error> {
    let (mut left_out, mut reached) = (0, 0);
    for x in draws(numbers(97), 60) {
        for n in [1, 4, 6] {
            let bodies = Bodies { n, numbers: &x, key: 0, behind: NAN };
            let mut kernel = Box::new(bodies::Kernel::<f64>::new());
            let mut own = Box::new(body_rows::Kernel::<f64>::new());
            bodies.fill(kernel.scene_mut())?;
            bodies.fill(own.scene_mut())?;
            let keys = 0..4;
            let limit = |row: usize| JointRow {
                law: RowLaw::Limit,
                key: 50 + u32::try_from(row).expect("few"),
                ..bodies.row(2 * row)
            };
            let mut limits: Vec<_> = keys.clone().map(limit).collect();
            // One that is far away, and one that is open by less than its rounding would be over all velocities.
            limits[3].offset = 100.0;
            let few: Vec<_> = keys
                .map(|row| {
                    let JointRow { row, offset, law, compliance, key } = limits[row].clone();
                    JointRow { row: SVector::from_fn(|j, _| row[j]), offset, law, compliance, key }
                })
                .collect();
            let found = kernel.solve_with_limits(&limits, &bodies.push(), &TICK)?.clone();
            let expected = own.solve_with_limits(&few, &bodies.push(), &TICK)?;
            assert_eq!(bits(n, &found), bits(n, expected));
            assert!(found.row_by_key(53).is_none());
            left_out += limits.iter().filter(|row| found.row_by_key(row.key).is_none()).count();
            reached += found.rows.len() - 2;
            if found.is_solved() {
                kernel.solver_mut().reset();
                let piece = Settings { budget: 3, ..TICK };
                while !kernel.advance_with_limits(&limits, &bodies.push(), &piece)? {}
                assert_eq!(bits(n, kernel.solution()), bits(n, &found));
            }
        }
    }
    assert!(left_out > 250 && reached > 50, "{left_out} {reached}");
    Ok(())
}

#[test]
fn derivatives_are_those_of_the_own_size_and_zero_behind() -> Result<(), Error> {
    for x in draws(numbers(97), 30) {
        for n in [1, 4, 6] {
            let bodies = Bodies { n, numbers: &x, key: 0, behind: NAN };
            let mut kernel = Box::new(bodies::Kernel::<f64>::new());
            let mut own = Box::new(body_rows::Kernel::<f64>::new());
            bodies.fill(kernel.scene_mut())?;
            bodies.fill(own.scene_mut())?;
            kernel.solve(&bodies.push(), &TICK)?;
            own.solve(&bodies.push(), &TICK)?;
            let (derivative, expected) = (kernel.derivative(&TICK)?, own.derivative(&TICK)?);
            assert_eq!(derivative.margin(), expected.margin());
            assert_eq!(derivative.has_unique_velocity(), expected.has_unique_velocity());
            let (mut change, mut same) = (Inputs::zero(), Inputs::zero());
            (change.free_impulse, same.free_impulse) = (bodies.push(), bodies.push());
            (change.friction[0], same.friction[0]) = (1.0, 1.0);
            let (found, wanted) = (derivative.forward(&change), expected.forward(&same));
            assert_eq!(found.impulses, wanted.impulses);
            assert_eq!(found.row_impulses, wanted.row_impulses);
            is_cut(n, &found.velocity, &wanted.velocity);
            assert_eq!(derivative.misfit(&change), expected.misfit(&same));
            let (mut weights, mut same) = (Outputs::zero(), Outputs::zero());
            (weights.velocity, same.velocity) = (bodies.push(), bodies.push());
            (weights.impulses[1][0], same.impulses[1][0]) = (1.0, 1.0);
            let (found, wanted) = (derivative.adjoint(&weights), expected.adjoint(&same));
            assert_eq!((found.offsets, found.friction), (wanted.offsets, wanted.friction));
            assert_eq!((found.row_offsets, found.bounds), (wanted.row_offsets, wanted.bounds));
            is_cut(n, &found.free_impulse, &wanted.free_impulse);
        }
    }
    Ok(())
}

/// The same numbers over the velocities in use, and zeros behind them.
fn is_cut(n: usize, found: &SVector<f64, LARGE>, wanted: &SVector<f64, SMALL>) {
    assert_eq!(found.rows(0, n), wanted.rows(0, n));
    assert!(found.iter().skip(n).chain(wanted.iter().skip(n)).all(|&x| x == 0.0));
}
