//! Least impulses and reserves against closed forms: what each foot of a table bears, when a ladder slips.
#![allow(clippy::float_cmp)] // with infinity, and of equal bits

use crate::support::random::{draws, numbers};
use crate::support::sizes::{cart, rolling};
use nalgebra::{DMatrix, Matrix3, SMatrix, SVector, Vector3, vector};
use stiction::{
    Contact, ContactMode, Error, Inputs, JointRow, Kernel, Model, Real, RowLaw, Scene, Settings, Surface,
    contact_frame,
};

/// Room for all scenes of this file: spatial bodies, two fingers, cables.
type Room<T> = Kernel<T, 8, 3, 8, 8>;

const G: f64 = 9.81;

fn skew(x: &Vector3<f64>) -> Matrix3<f64> {
    x.cross_matrix()
}

/// A scene in numbers of `f64`, to be filled into a kernel of any type.
#[derive(Clone, Default)]
struct Case {
    mass: Vec<f64>,
    /// Normal first: three rows over the velocities.
    contacts: Vec<(DMatrix<f64>, f64)>,
    rows: Vec<(Vec<f64>, RowLaw<f64>)>,
}

impl Case {
    /// A body (x, y, z and rotations) of mass `m` and these principal moments, touched at these places with these normals.
    fn body(m: f64, moments: [f64; 3], places: &[[f64; 3]], normals: &[[f64; 3]], mu: f64) -> Self {
        let mut mass = vec![m; 3];
        mass.extend(moments);
        let contacts = places.iter().zip(normals).map(|(place, normal)| {
            let (place, normal) = (Vector3::from(*place), Vector3::from(*normal));
            let frame = contact_frame(&normal).expect("a unit normal").transpose();
            let mut rows = DMatrix::zeros(3, 6);
            rows.view_mut((0, 0), (3, 3)).copy_from(&frame);
            rows.view_mut((0, 3), (3, 3)).copy_from(&-(frame * skew(&place)));
            (rows, mu)
        });
        Self { mass, contacts: contacts.collect(), rows: Vec::new() }
    }

    /// A body that stands on feet.
    fn on_feet(m: f64, moments: [f64; 3], feet: &[[f64; 3]], mu: f64) -> Self {
        Self::body(m, moments, feet, &vec![[0.0, 0.0, 1.0]; feet.len()], mu)
    }

    fn fill<T: Real>(&self, scene: &mut Scene<T, 8, 3, 8, 8>) -> Result<(), Error> {
        scene.clear();
        scene.set_velocities(self.mass.len())?;
        let n = self.mass.len();
        let mass =
            SMatrix::<T, 8, 8>::from_fn(|i, j| T::literal(if i == j && i < n { self.mass[i] } else { 0.0 }));
        scene.set_mass(&mass)?;
        for (key, (rows, mu)) in (0..).zip(&self.contacts) {
            let jacobian = SMatrix::from_fn(|i, j| T::literal(rows.get((i, j)).copied().unwrap_or(0.0)));
            scene.push(&Contact { jacobian, offset: SVector::repeat(T::ZERO), mu: T::literal(*mu), key })?;
        }
        for (key, (row, law)) in (0..).zip(&self.rows) {
            let law = match *law {
                RowLaw::Limit => RowLaw::Limit,
                RowLaw::Equality => RowLaw::Equality,
                RowLaw::Box { lower, upper } => {
                    RowLaw::Box { lower: T::literal(lower), upper: T::literal(upper) }
                }
            };
            let row = SVector::from_fn(|i, _| T::literal(row.get(i).copied().unwrap_or(0.0)));
            scene.push_row(&JointRow { row, offset: T::ZERO, law, compliance: T::ZERO, key })?;
        }
        Ok(())
    }

    fn solved<T: Real>(&self, push: &[f64], tolerance: f64) -> Result<(Box<Room<T>>, SVector<T, 8>), Error> {
        let mut kernel = Box::new(Room::<T>::new());
        self.fill(kernel.scene_mut())?;
        let push = SVector::from_fn(|i, _| T::literal(push.get(i).copied().unwrap_or(0.0)));
        let settings = Settings { budget: 5_000, ..Settings::new(T::literal(tolerance)) };
        let solution = kernel.solve(&push, &settings)?;
        assert!(solution.is_solved(), "{} {}", solution.status, solution.error);
        Ok((kernel, push))
    }
}

fn near(name: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    let size = expected.iter().fold(1e-12_f64, |size, x| size.max(x.abs()));
    let off = found.iter().zip(expected).fold(0.0_f64, |off, (x, y)| off.max((x - y).abs())) / size;
    println!("{name}: off by {off:.1e}");
    assert!(found.len() == expected.len() && off <= tolerance, "{name}: {found:?}, expected {expected:?}");
}

fn table() -> Case {
    let feet = [[0.2, 0.2, -0.4], [0.2, -0.2, -0.4], [-0.2, 0.2, -0.4], [-0.2, -0.2, -0.4]];
    Case::on_feet(5.4, [0.3, 0.3, 0.2], &feet, 0.5)
}

fn box_() -> Case {
    let feet = [[0.1, 0.1, -0.05], [0.1, -0.1, -0.05], [-0.1, 0.1, -0.05], [-0.1, -0.1, -0.05]];
    Case::on_feet(2.0, [0.02, 0.02, 0.02], &feet, 0.5)
}

fn rod() -> Case {
    Case::on_feet(1.0, [0.005, 0.08, 0.08], &[[0.5, 0.0, -0.02], [-0.5, 0.0, -0.02]], 0.5)
}

/// Normal impulses and shares of friction used of the least impulses.
fn least<T: Real>(case: &Case, push: &[f64], tolerance: f64) -> Result<[Vec<f64>; 3], Error> {
    let (kernel, _) = case.solved::<T>(push, tolerance)?;
    let f64_of = |x: T| x.to_subset().unwrap_or(f64::NAN);
    let least = kernel.least_impulses(&Settings::new(T::literal(tolerance)))?;
    assert!(f64_of(least.momentum_error) <= tolerance, "{}", f64_of(least.momentum_error));
    let loads = least.contacts.iter().map(|r| f64_of(r[0])).collect();
    let rubs = least.contacts.iter().map(|r| f64_of(r[1]).hypot(f64_of(r[2])));
    let used =
        rubs.zip(&least.contacts).zip(&case.contacts).map(|((rub, r), (_, mu))| rub / (mu * f64_of(r[0])));
    Ok([loads, used.collect(), least.rows.iter().map(|&r| f64_of(r)).collect()])
}

fn shares<T: Real>(tolerance: f64, close: f64) -> Result<(), Error> {
    // A dragged table: its weight, and the moment of the slide.
    let (m, mu) = (5.4, 0.5);
    let force = 1.01 * mu * m * G;
    let a = force / m - mu * G;
    let [loads, used, _] = least::<T>(&table(), &[force, 0.0, -m * G, 0.0, -0.4 * force, 0.0], tolerance)?;
    let more = m * a * 0.4 / 0.8;
    let (front, back) = (m * G / 4.0 - more, m * G / 4.0 + more);
    near("table dragged", &loads, &[front, front, back, back], close);
    near("table dragged, use", &used, &[1.0; 4], close);
    // Six feet anywhere in a plane: loads are affine in the place.
    let places = [[0.31, 0.02], [-0.12, 0.27], [-0.25, -0.08], [0.04, -0.22], [0.17, 0.13], [-0.15, -0.12]];
    let feet = places.map(|[x, y]| [x, y, -0.2]);
    let six = Case::on_feet(3.0, [0.1; 3], &feet, 0.6);
    let [loads, ..] = least::<T>(&six, &[1.0, 0.5, -3.0 * G, 0.0, 0.0, 0.0], tolerance)?;
    let plane = DMatrix::from_fn(6, 3, |i, j| if j == 0 { 1.0 } else { places[i][j - 1] });
    let loads = DMatrix::from_vec(6, 1, loads);
    let fit = plane.clone().svd(true, true).solve(&loads, 1e-12).expect("a plane");
    near("six feet", (plane * fit).as_slice(), loads.as_slice(), close);
    // A beam on three supports.
    let beam = Case::on_feet(
        1.0,
        [0.005, 0.08, 0.08],
        &[[-0.5, 0.0, -0.02], [0.0, 0.0, -0.02], [0.5, 0.0, -0.02]],
        0.5,
    );
    let [loads, ..] = least::<T>(&beam, &[0.0, 0.0, -G, 0.0, 0.0, 0.0], tolerance)?;
    near("beam", &loads, &[G / 3.0; 3], close);
    // A rod: friction is shared as the load.
    let [_, used, _] =
        least::<T>(&rod(), &[0.3 * 0.5 * G, 0.0, -G, 0.0, -0.02 * 0.3 * 0.5 * G, 0.0], tolerance)?;
    near("rod, use", &used, &[0.3; 2], close);
    // A box near its limit: the back feet are on their cones, the front ones carry the rest.
    let k = 0.95;
    let [loads, used, _] =
        least::<T>(&box_(), &[k * 0.5 * 2.0 * G, 0.0, -2.0 * G, 0.0, 0.0, 0.0], tolerance)?;
    let back = 2.0 * G / 4.0 * (1.0 - k * 0.5 * 0.05 / 0.1);
    let front = G - back;
    near("box at .95", &loads, &[front, front, back, back], close);
    let use_of_front = (k * 0.5 * G - 0.5 * back) / (0.5 * front);
    near("box at .95, use", &used, &[use_of_front, use_of_front, 1.0, 1.0], close);
    // Between two walls the one that is pushed bears alone.
    let walls = Case::body(
        1.0,
        [0.01; 3],
        &[[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0]],
        &[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        0.5,
    );
    let [loads, ..] = least::<T>(&walls, &[3.0, 0.0, 0.0, 0.0, 0.0, 0.0], tolerance)?;
    near("walls", &loads, &[3.0, 0.0], close);
    Ok(())
}

/// A platform of 10 kg on cables from above, or on eight from above and below.
fn cables(count: usize) -> Case {
    let mut case = Case { mass: vec![10.0, 10.0, 10.0, 0.43, 0.43, 0.6], ..Case::default() };
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
    for (height, side) in [(3.0, 0.2), (0.0, -0.2)].into_iter().take(count / 4) {
        for (x, y) in corners {
            let at: Vector3<f64> = vector![0.3 * x, 0.3 * y, side];
            let along = (vector![2.0 * x, 2.0 * y, height] - at - vector![0.0, 0.0, 1.5]).normalize();
            let turn = at.cross(&along);
            case.rows.push((along.iter().chain(turn.iter()).copied().collect(), RowLaw::Limit));
        }
    }
    case
}

fn cables_share<T: Real>(tolerance: f64, close: f64) -> Result<(), Error> {
    let push = [0.0, 0.0, -98.1, 0.0, 0.0, 0.0];
    let tension = 98.1 / 4.0 / cables(4).rows[0].0[2];
    let [_, _, rows] = least::<T>(&cables(4), &push, tolerance)?;
    near("four cables", &rows, &[tension; 4], close);
    let [_, _, rows] = least::<T>(&cables(8), &push, tolerance)?;
    near("eight cables", &rows, &[[tension; 4], [0.0; 4]].concat(), close);
    Ok(())
}

#[test]
fn springs_of_equal_stiffness_share_the_load() -> Result<(), Error> {
    shares::<f64>(1e-9, 1e-6)?;
    cables_share::<f64>(1e-9, 1e-6)
}

#[test]
fn they_share_it_in_single_precision() -> Result<(), Error> {
    shares::<f32>(1e-5, 3e-3)?;
    cables_share::<f32>(1e-5, 3e-3)
}

/// The ladder of the school book, in the plane (x, height, angle), on a floor and a wall. Its friction may fall to the `s` with
/// `tan = (1 - s² a b) / (2 s a)`.
fn ladder(angle: f64, [floor, wall]: [f64; 2]) -> Result<(Box<cart::Kernel<f64>>, f64), Error> {
    let (c, s) = (angle.cos(), angle.sin());
    let mut kernel = Box::new(cart::Kernel::new());
    let scene = kernel.scene_mut();
    scene.set_velocities(3)?;
    scene.set_mass(&SMatrix::from_diagonal(&vector![10.0, 10.0, 10.0 / 3.0, 0.0, 0.0, 0.0]))?;
    let row = |n: [f64; 2], r: [f64; 2]| [n[0], n[1], r[0] * n[1] - r[1] * n[0]];
    for (key, n, e, r, mu) in
        [(0, [0.0, 1.0], [1.0, 0.0], [c, -s], floor), (1, [1.0, 0.0], [0.0, 1.0], [-c, s], wall)]
    {
        let rows = [row(n, r), row(e, r)];
        let jacobian = SMatrix::from_fn(|i, j| rows[i].get(j).copied().unwrap_or(0.0));
        scene.push(&Contact { jacobian, offset: vector![0.0, 0.0], mu, key })?;
    }
    let (mut low, mut high) = (1e-9, 10.0);
    for _ in 0..100 {
        let share = 0.5 * (low + high);
        let tan = (1.0 - share * share * floor * wall) / (2.0 * share * floor);
        if tan > angle.tan() {
            low = share;
        } else {
            high = share;
        }
    }
    Ok((kernel, high))
}

#[test]
fn a_reserve_is_the_friction_that_statics_asks_for() -> Result<(), Error> {
    let settings = Settings { budget: 5_000, ..Settings::new(1e-4) };
    let reserve = |case: &Case, push: &[f64]| -> Result<[f64; 2], Error> {
        let (mut kernel, push) = case.solved::<f64>(push, 1e-10)?;
        Ok([kernel.slip_reserve(&settings)?, kernel.rest_reserve(&push, &settings)?])
    };
    let both = |name: &str, found: [f64; 2], expected: f64| {
        for found in found {
            println!("{name}: {found} {:.1e}", found - expected);
            assert!(
                found >= expected - 1e-6 && found <= expected + 1.1e-4 * expected.max(1e-2),
                "{name}: {found}, {expected}"
            );
        }
    };
    for k in [0.2, 0.8, 0.99] {
        both("box", reserve(&box_(), &[k * 0.5 * 2.0 * G, 0.0, -2.0 * G])?, k);
    }
    for degrees in [5.0_f64, 15.0, 25.0] {
        let t = degrees.to_radians();
        both("slope", reserve(&box_(), &[2.0 * G * t.sin(), 0.0, -2.0 * G * t.cos()])?, t.tan() / 0.5);
    }
    let twist = 0.5 * 0.5 * 5.4 * G * 0.2 * 2.0_f64.sqrt();
    both("table twisted", reserve(&table(), &[0.0, 0.0, -5.4 * G, 0.0, 0.0, twist])?, 0.5);
    both("rod turned", reserve(&rod(), &[0.0, 0.0, -G, 0.0, 0.0, 0.7 * 0.5 * G * 0.5])?, 0.7);
    both("nothing to hold", reserve(&box_(), &[0.0, 0.0, -2.0 * G])?, 0.0);
    for degrees in [50.0_f64, 60.0, 70.0] {
        let (mut kernel, expected) = ladder(degrees.to_radians(), [0.8, 0.6])?;
        let push = vector![0.0, -10.0 * G, 0.0, 0.0, 0.0, 0.0];
        assert!(kernel.solve(&push, &Settings { budget: 5_000, ..Settings::new(1e-10) })?.is_solved());
        both("ladder", [kernel.slip_reserve(&settings)?, kernel.rest_reserve(&push, &settings)?], expected);
    }
    // Two fingers pinch, each on a slide of its own with a force of 10 N.
    let mut pinch = Case::body(
        0.4,
        [1e-4; 3],
        &[[0.03, 0.0, 0.0], [-0.03, 0.0, 0.0]],
        &[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        0.5,
    );
    pinch.mass.extend([0.1, 0.1]);
    for (finger, (rows, _)) in pinch.contacts.iter_mut().enumerate() {
        let mut wider = DMatrix::zeros(3, 8);
        wider.view_mut((0, 0), (3, 6)).copy_from(rows);
        wider[(0, 6 + finger)] = -1.0;
        *rows = wider;
    }
    both(
        "pinch",
        reserve(&pinch, &[0.0, 0.0, -0.4 * G, 0.0, 0.0, 0.0, 10.0, 10.0])?,
        0.4 * G / (2.0 * 0.5 * 10.0),
    );
    // Pushed above its centre, it tips, whatever the friction; pushed too hard, it needs more friction than it has.
    let (mut kernel, push) =
        box_().solved::<f64>(&[0.4 * 2.0 * G, 0.0, -2.0 * G, 0.0, 0.4 * 2.0 * G * 0.3], 1e-10)?;
    assert_eq!(kernel.rest_reserve(&push, &settings)?, f64::INFINITY);
    let (mut kernel, push) = box_().solved::<f64>(&[1.2 * 0.5 * 2.0 * G, 0.0, -2.0 * G], 1e-10)?;
    let share = kernel.rest_reserve(&push, &settings)?;
    assert!((share - 1.2).abs() < 1.2e-4, "{share}");
    Ok(())
}

#[test]
fn a_load_reserve_is_the_force_at_which_a_box_slides_or_tips() -> Result<(), Error> {
    let settings = Settings::new(1e-5);
    let (kernel, _) = box_().solved::<f64>(&[0.0, 0.0, -2.0 * G], 1e-10)?;
    let mut push = SVector::<f64, 8>::zeros();
    push[0] = 1.0;
    near("slides", &[kernel.load_reserve(&push, &settings)?], &[0.5 * 2.0 * G], 2e-5);
    push[4] = 0.3;
    near("tips", &[kernel.load_reserve(&push, &settings)?], &[2.0 * G * 0.1 / 0.35], 2e-5);
    push = SVector::zeros();
    push[2] = -1.0;
    assert_eq!(kernel.load_reserve(&push, &settings)?, f64::INFINITY);
    push[2] = 1.0;
    // The same in single precision.
    let single = Settings::new(1e-3);
    let (weak, _) = box_().solved::<f32>(&[0.0, 0.0, -2.0 * G], 1e-5)?;
    assert_eq!(weak.load_reserve(&(push.cast::<f32>() * -1.0), &single)?, f32::INFINITY);
    near("lifts", &[kernel.load_reserve(&push, &settings)?], &[2.0 * G], 2e-5);
    Ok(())
}

#[test]
fn what_stands_sticks_though_a_corner_uses_all_its_friction() -> Result<(), Error> {
    for k in [0.3, 0.8, 0.9, 0.95, 0.99] {
        let (kernel, _) = box_().solved::<f64>(&[k * 0.5 * 2.0 * G, 0.0, -2.0 * G], 1e-9)?;
        for contact in &kernel.solution().contacts {
            assert_eq!(contact.mode, ContactMode::Stick, "{k}");
        }
    }
    Ok(())
}

/// Bodies at rest on 4 to 8 points of rough ground, some of them tilted, with a push that they may or may not withstand.
fn any_body(x: &[f64]) -> (Case, [f64; 6]) {
    let count =
        [4, 5, 6, 7, 8].into_iter().rfind(|&count| f64::from(count) <= 4.0 + 5.0 * x[0].abs()).unwrap_or(4);
    let mut draw = x[1..].iter().copied();
    let mut next = || draw.next().expect("enough numbers");
    let feet: Vec<_> = (0..count).map(|_| [0.3 * next(), 0.3 * next(), -0.1]).collect();
    let tilted = next() > 0.0;
    let normals = feet.iter().map(|_| {
        let slope = if tilted { 0.3 } else { 0.0 };
        let normal = vector![slope * next(), slope * next(), 1.0].normalize();
        [normal.x, normal.y, normal.z]
    });
    let case = Case::body(2.0, [0.04, 0.05, 0.06], &feet, &normals.collect::<Vec<_>>(), 0.6);
    (case, [4.0 * next(), 4.0 * next(), -2.0 * G, 0.3 * next(), 0.3 * next(), 0.5 * next()])
}

#[test]
fn the_past_plays_no_part() -> Result<(), Error> {
    let settings = Settings { budget: 5_000, ..Settings::new(1e-9) };
    let (mut kernel, mut apart, mut compared) = (Box::new(Room::<f64>::new()), 0.0_f64, 0);
    for x in draws(numbers(60), 200) {
        let (case, push) = any_body(&x);
        let push = SVector::<f64, 8>::from_fn(|i, _| push.get(i).copied().unwrap_or(0.0));
        let mut found = Vec::new();
        for past in 0..3 {
            kernel.solver_mut().reset();
            case.fill(kernel.scene_mut())?;
            for shake in 0..3 * past {
                let mut shaken = push;
                for (i, shaken) in shaken.iter_mut().take(6).enumerate() {
                    *shaken += 6.0 * x[(7 * shake + 11 * past + i) % 60];
                }
                kernel.solve(&shaken, &settings)?;
            }
            let solution = kernel.solve(&push, &settings)?.clone();
            if solution.is_solved() && solution.velocity.norm() < 1e-9 {
                let least = kernel.least_impulses(&settings)?;
                assert!(least.momentum_error <= 1e-9);
                for r in &least.contacts {
                    assert!(vector![r[1], r[2]].norm() <= 0.6 * r[0] * (1.0 + 1e-12), "{r}");
                }
                found.push((solution, least));
            }
        }
        if let [(raw, first), others @ ..] = &found[..] {
            let size = first.contacts.iter().map(SVector::norm_squared).sum::<f64>().sqrt();
            for (other, least) in others {
                for (a, b) in first.contacts.iter().zip(&least.contacts) {
                    assert!((a - b).norm() <= 1e-6 * size, "{a} {b}");
                }
                let off =
                    raw.contacts.iter().zip(&other.contacts).map(|(a, b)| (a.impulse - b.impulse).norm());
                apart = apart.max(off.fold(0.0, f64::max) / size);
                compared += 1;
            }
        }
    }
    println!("{compared} pairs; impulses of the solutions differ by up to {apart}");
    assert!(compared > 100 && apart > 0.1);
    Ok(())
}

#[test]
fn with_a_little_more_friction_a_body_rests_and_with_a_little_less_it_moves() -> Result<(), Error> {
    // By the relaxation: bodies that friction wedges may slide by Coulomb's law before.
    let exact = Settings { budget: 20_000, model: Model::ConvexRelaxation, ..Settings::new(1e-9) };
    let (mut kernel, mut rested) = (Box::new(Room::<f64>::new()), 0);
    for x in draws(numbers(60), 60) {
        let (mut case, push) = any_body(&x);
        let push = SVector::<f64, 8>::from_fn(|i, _| push.get(i).copied().unwrap_or(0.0));
        case.fill(kernel.scene_mut())?;
        let share = kernel.rest_reserve(&push, &Settings::new(1e-4))?;
        if kernel.solve(&push, &exact)?.velocity.norm() < 1e-9 {
            let own = kernel.slip_reserve(&Settings::new(1e-4))?;
            assert!((own - share).abs() <= 2e-4 * share.max(1e-3), "{own} {share}");
        }
        if !(1e-3..1.5).contains(&share) {
            continue;
        }
        for (times, rests) in [(1.0 + 1e-3, true), (1.0 - 1e-3, false)] {
            case.contacts.iter_mut().for_each(|(_, mu)| *mu = 0.6 * share * times);
            case.fill(kernel.scene_mut())?;
            let solution = kernel.solve(&push, &exact)?;
            if solution.is_solved() {
                assert_eq!(
                    solution.velocity.norm() < 1e-5,
                    rests,
                    "{share} {times}: {}",
                    solution.velocity.norm()
                );
                rested += 1;
            }
        }
    }
    assert!(rested > 60, "{rested}");
    Ok(())
}

#[test]
fn the_derivative_is_that_of_the_least_impulses() -> Result<(), Error> {
    let settings = Settings { budget: 5_000, ..Settings::new(1e-10) };
    let places = [[0.31, 0.02], [-0.12, 0.27], [-0.25, -0.08], [0.04, -0.22], [0.17, 0.13], [-0.15, -0.12]];
    let case = Case::on_feet(3.0, [0.1; 3], &places.map(|[x, y]| [x, y, -0.2]), 0.6);
    let push = [1.0, 0.5, -3.0 * G, 0.1, -0.2, 0.1];
    let (kernel, _) = case.solved::<f64>(&push, 1e-10)?;
    let derivative = kernel.derivative(&settings)?;
    assert!(!derivative.has_unique_impulses());
    for entry in 0..6 {
        let near = |step: f64| -> Result<_, Error> {
            let mut push = push;
            push[entry] += step;
            case.solved::<f64>(&push, 1e-10)?.0.least_impulses(&settings)
        };
        let (more, less) = (near(1e-3)?, near(-1e-3)?);
        let mut change = Inputs::<f64, 8, 3, 8, 8>::zero();
        change.free_impulse[entry] = 1.0;
        let response = derivative.forward(&change);
        for (i, (more, less)) in more.contacts.iter().zip(&less.contacts).enumerate() {
            let slope = (more - less) / 2e-3;
            assert!(
                (slope - response.impulses[i]).norm() < 1e-6,
                "{entry}: {slope} {}",
                response.impulses[i]
            );
        }
    }
    Ok(())
}

#[test]
fn a_solution_of_another_scene_bears_nothing() -> Result<(), Error> {
    let settings = Settings::new(1e-9);
    let (mut kernel, push) = box_().solved::<f64>(&[3.0, 0.0, -2.0 * G], 1e-9)?;
    assert!(kernel.least_impulses(&settings).is_ok() && kernel.derivative(&settings).is_ok());
    let wrong = Settings { still: f64::NAN, ..settings };
    assert_eq!(kernel.least_impulses(&wrong).err(), Some(Error::InvalidTolerance));
    assert_eq!(kernel.slip_reserve(&Settings::new(-1.0)).err(), Some(Error::InvalidTolerance));
    assert_eq!(kernel.rest_reserve(&push, &Settings::new(f64::NAN)).err(), Some(Error::InvalidTolerance));
    // The same contacts by their keys, of another shape: first with the old factor, then with a new one.
    let jacobian = kernel.scene().contacts()[0].jacobian * 2.0;
    kernel.scene_mut().set_jacobian(0, &jacobian)?;
    assert_eq!(kernel.least_impulses(&settings).err(), Some(Error::StaleFactor));
    kernel.prepare()?;
    assert_eq!(kernel.least_impulses(&settings).err(), Some(Error::SceneChanged));
    assert_eq!(kernel.slip_reserve(&settings).err(), Some(Error::SceneChanged));
    assert_eq!(kernel.load_reserve(&push, &settings).err(), Some(Error::SceneChanged));
    assert_eq!(kernel.derivative(&settings).err(), Some(Error::SceneChanged));
    // A relaxed solution is differentiated as one, whatever the settings say now.
    let relaxed = Settings { model: Model::ConvexRelaxation, ..settings };
    kernel.solve(&(push * 3.0), &relaxed)?;
    let response = |settings: &Settings<f64>| -> Result<_, Error> {
        let mut change = Inputs::<f64, 8, 3, 8, 8>::zero();
        change.friction[0] = 1.0;
        Ok(kernel.derivative(settings)?.forward(&change).velocity)
    };
    assert_eq!(response(&settings)?, response(&relaxed)?);
    Ok(())
}

#[test]
fn compliance_says_what_a_row_bears() -> Result<(), Error> {
    let mut case = cables(4);
    let mut kernel = Box::new(Room::<f64>::new());
    case.rows.truncate(4);
    case.fill(kernel.scene_mut())?;
    let tensions =
        |kernel: &Room<f64>| kernel.solution().rows.iter().map(|row| row.impulse).collect::<Vec<_>>();
    let settings = Settings { budget: 5_000, ..Settings::new(1e-11) };
    // Two cables across from each other give way: they bear less, and their compliance says how much.
    for row in [0, 3] {
        kernel.scene_mut().set_row_compliance(row, 0.01)?;
    }
    kernel.solve(&vector![0.0, 0.0, -98.1, 0.0, 0.0, 0.0, 0.0, 0.0], &settings)?;
    let found = tensions(&kernel);
    assert!(kernel.solution().is_solved() && found[0] < 0.9 * found[1], "{found:?}");
    near("soft cables", &kernel.least_impulses(&settings)?.rows, &found, 1e-5);
    Ok(())
}

#[test]
fn contacts_with_spin_and_roll_share_as_well() -> Result<(), Error> {
    let mut kernel = Box::new(rolling::Kernel::<f64>::new());
    kernel.scene_mut().set_mass(&SMatrix::identity())?;
    for key in 0..2 {
        let contact = Contact { jacobian: SMatrix::identity(), offset: SVector::zeros(), mu: 0.5, key };
        let surface = Surface { spin: 0.2, roll: [0.1, 0.1], ..Surface::isotropic(0.5) };
        kernel.scene_mut().push_on(&contact, &surface)?;
    }
    kernel.solver_mut().set_impulses(&[(0, vector![2.0, -0.2, 0.0, 0.0, 0.0, 0.0])], &[])?;
    let push = vector![-2.0, 0.2, 0.1, 0.05, 0.01, 0.02];
    let settings = Settings::new(1e-9);
    assert!(kernel.solve(&push, &settings)?.is_solved());
    for impulse in &kernel.least_impulses(&settings)?.contacts {
        assert!((impulse + push * 0.5).norm() < 1e-7, "{impulse}");
    }
    let used = vector![0.2 / 0.5, 0.1 / 0.5, 0.05 / 0.2, 0.01 / 0.1, 0.02 / 0.1].norm() / 2.0;
    near("all rows", &[kernel.slip_reserve(&Settings::new(1e-4))?], &[used], 1.1e-4);
    Ok(())
}

#[test]
fn what_creeps_bears_as_what_stands() -> Result<(), Error> {
    // 1 % too much for friction: all corners slide, slowly.
    let (mut kernel, _) = box_().solved::<f64>(&[1.01 * 0.5 * 2.0 * G, 0.0, -2.0 * G], 1e-9)?;
    let modes = |kernel: &Room<f64>| {
        kernel.solution().contacts.iter().map(|contact| contact.mode).collect::<Vec<_>>()
    };
    assert_eq!(modes(&kernel), [ContactMode::Slip; 4]);
    let still = Settings { still: 0.1, budget: 5_000, ..Settings::new(1e-9) };
    let push = vector![1.01 * 0.5 * 2.0 * G, 0.0, -2.0 * G, 0.0, 0.0, 0.0, 0.0, 0.0];
    let slides = kernel.solve(&push, &still)?.velocity[0];
    assert!(slides > 0.01 && slides < 0.1, "{slides}");
    assert_eq!(modes(&kernel), [ContactMode::Stick; 4]);
    Ok(())
}
