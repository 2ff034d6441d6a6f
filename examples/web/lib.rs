//! Three planar scenes and the recorded trot, stepped by a web page.
//!
//! The page makes a [`World`], writes its `controls`, calls [`step`], and reads what stands behind them. All numbers are `f64`, in
//! m, kg, s, rad, N and N·m; the kernel solves in `f64` or in `f32`.
#![allow(unsafe_code)] // the attribute of exported functions, and no block

mod gripper;
mod leg;
#[path = "../embedded/records.rs"]
mod records;
mod slope;
mod solve;
#[path = "../firmware/trot.rs"]
mod trot;

use nalgebra::{SMatrix, SVector, Vector2, matrix, vector};
use solve::{Answer, solve};
use stiction::time_stepping::{Gap, free_impulse};
use stiction::{Contact, Error, JointRow, Kernel, heapless};

/// Room for velocities, contacts and joint rows of any scene.
const N: usize = 5;
const C: usize = 8;
const R: usize = 2;
/// Time step (s).
const STEP: f64 = 2e-3;
const GRAVITY: f64 = 9.81;
/// A penetration is pushed out at 0.1 m/s at most; nothing closes faster than 10 m/s.
const GAP: Gap<f64> = Gap { distance: 0.0, recovery: 0.1, reach: 10.0 };

type Vector = SVector<f64, N>;
/// Velocity of a point in the plane for the velocities of a scene.
type PointJacobian = SMatrix<f64, 2, N>;

/// What a scene is made of.
struct Scene {
    /// Masses and lengths, for the page.
    numbers: [f64; 6],
    /// How fast each slider acts (its unit a second), and where it begins if that is not at once.
    rates: [f64; 3],
    starts: [f64; 3],
    /// Whether the third velocity turns the body that the pointer pulls; the first two move it.
    turns: bool,
    /// Spring of the pointer (1/s²), for each kg of that body.
    spring: f64,
    /// Positions at first, for the sliders.
    begin: fn([f64; 3]) -> Vector,
    /// The step from these positions and velocities, for the sliders.
    given: fn(&Vector, &Vector, [f64; 3]) -> Result<Given, Error>,
}

/// The data of a step.
struct Given {
    velocities: usize,
    mass: SMatrix<f64, N, N>,
    force: Vector,
    touches: heapless::Vec<Touch, C>,
    rows: heapless::Vec<JointRow<f64, N>, R>,
}

/// A contact, and where it is. Its key is its place in [`World::contacts`].
struct Touch {
    point: Vector2<f64>,
    normal: Vector2<f64>,
    contact: Contact<f64, N, 2>,
}

impl Touch {
    fn new(
        key: u32,
        [point, normal]: [Vector2<f64>; 2],
        jacobian: &PointJacobian,
        mu: f64,
        distance: f64,
    ) -> Result<Self, Error> {
        let mut contact = Contact::at_point(&normal, jacobian, mu, key)?;
        contact.offset[0] = Gap { distance, ..GAP }.offset(STEP)?;
        Ok(Self { point, normal, contact })
    }
}

/// A vector of a body, turned with it.
fn turned(angle: f64, [x, y]: [f64; 2]) -> Vector2<f64> {
    let (sine, cosine) = angle.sin_cos();
    vector![cosine * x - sine * y, sine * x + cosine * y]
}

/// Velocity of a point at `lever` from the middle of a body that has the first three velocities.
fn of_body(lever: &Vector2<f64>) -> PointJacobian {
    matrix![1.0, 0.0, -lever.y, 0.0, 0.0; 0.0, 1.0, lever.x, 0.0, 0.0]
}

/// All that the page reads and writes, in this order, and behind it what it does not see.
#[repr(C)]
pub struct World {
    /// Three sliders; whether the pointer holds the body, where (in its axes), and where the pointer is; 1 to solve in `f32`.
    controls: [f64; 9],
    numbers: [f64; 6],
    positions: Vector,
    /// What the sliders have come to.
    hand: [f64; 3],
    /// Force of the pointer.
    pull: Vector2<f64>,
    /// Forces or torques of the joint rows.
    rows: [f64; R],
    /// Error of the solution; 1 if it was solved. Otherwise the world stands still.
    error: f64,
    solved: f64,
    /// Point, force and mode (0 open, 1 stick, 2 slip) of each contact, by its key.
    contacts: [[f64; 5]; C],
    velocity: Vector,
    scene: &'static Scene,
    double: Kernel<f64, N, 2, C, R>,
    single: Kernel<f32, N, 2, C, R>,
    text: String,
}

impl World {
    fn step(&mut self) -> Result<(), Error> {
        let scene = self.scene;
        for ((hand, &wanted), rate) in self.hand.iter_mut().zip(&self.controls).zip(scene.rates) {
            *hand += (wanted - *hand).clamp(-rate * STEP, rate * STEP);
        }
        let (positions, velocity) = (&self.positions, &self.velocity);
        let mut given = (scene.given)(positions, velocity, self.hand)?;
        let [_, _, _, held, x, y, to_x, to_y, single] = self.controls;
        self.pull = vector![0.0, 0.0];
        if held > 0.0 {
            let lever = if scene.turns { turned(positions[2], [x, y]) } else { vector![0.0, 0.0] };
            let jacobian = if scene.turns { of_body(&lever) } else { PointJacobian::identity() };
            let at = positions.fixed_rows::<2>(0) + lever;
            let damping = 2.0 * scene.spring.sqrt();
            let pull = (vector![to_x, to_y] - at) * scene.spring - jacobian * velocity * damping;
            self.pull = pull.cap_magnitude(40.0) * given.mass[(0, 0)];
            given.force += jacobian.tr_mul(&self.pull);
        }
        let free = free_impulse(&given.mass, velocity, &given.force, STEP);
        let Answer { velocity, impulses, rows, error, solved } = if single > 0.0 {
            solve(&mut self.single, &given, &free, 1e-4)?
        } else {
            solve(&mut self.double, &given, &free, 1e-9)?
        };
        self.error = error;
        if solved {
            self.solved = 1.0;
            self.velocity = velocity;
            self.positions += velocity * STEP;
            self.rows = rows.map(|impulse| impulse / STEP);
            self.contacts = [[0.0; 5]; C];
            for (touch, (impulse, mode)) in given.touches.iter().zip(impulses) {
                let force = impulse / STEP;
                let slot = self.contacts.get_mut(touch.contact.key as usize);
                if let Some(slot) = slot {
                    *slot = [touch.point.x, touch.point.y, force.x, force.y, mode];
                }
            }
        }
        Ok(())
    }
}

/// A new world, with the scene on a slope.
#[unsafe(no_mangle)]
pub extern "C" fn world() -> Box<World> {
    Box::new(World {
        controls: [0.0; 9],
        numbers: [0.0; 6],
        positions: Vector::zeros(),
        hand: [0.0; 3],
        pull: vector![0.0, 0.0],
        rows: [0.0; R],
        error: 0.0,
        solved: 1.0,
        contacts: [[0.0; 5]; C],
        velocity: Vector::zeros(),
        scene: &slope::SCENE,
        double: Kernel::new(),
        single: Kernel::new(),
        text: String::new(),
    })
}

/// Begins a scene: 0 the slope, 1 the leg, 2 the gripper.
#[unsafe(no_mangle)]
pub extern "C" fn begin(world: &mut World, scene: u32) {
    world.scene = match scene {
        0 => &slope::SCENE,
        1 => &leg::SCENE,
        _ => &gripper::SCENE,
    };
    world.numbers = world.scene.numbers;
    let [a, b, c, ..] = world.controls;
    let starts = world.scene.starts;
    world.hand = [a, b, c];
    for ((hand, start), rate) in world.hand.iter_mut().zip(starts).zip(world.scene.rates) {
        if rate.is_finite() {
            *hand = start;
        }
    }
    world.positions = (world.scene.begin)(world.hand);
    world.velocity = Vector::zeros();
    world.contacts = [[0.0; 5]; C];
    world.solved = 1.0;
    world.double.reset();
    world.single.reset();
}

/// Takes some steps of 2 ms.
#[unsafe(no_mangle)]
pub extern "C" fn step(world: &mut World, count: u32) {
    for _ in 0..count {
        world.solved = 0.0;
        if world.step().is_err() || world.solved == 0.0 {
            return;
        }
    }
}

/// Solves the forty steps of the trot in `f32`, and writes a line on each if asked to. Returns how many gave impulses to use.
#[unsafe(no_mangle)]
pub extern "C" fn trot(world: &mut World, write: bool) -> u32 {
    let mut trot = trot::Trot::<f32>::new();
    let mut good = 0;
    world.text.clear();
    while trot.sense() {
        good += u32::from(trot.solve());
        if write && trot.report(&mut world.text).is_ok() {
            world.text.push('\n');
        }
    }
    good
}

/// Where the text of the trot is.
#[unsafe(no_mangle)]
pub extern "C" fn text(world: &World) -> *const u8 {
    world.text.as_ptr()
}

/// How long it is.
#[unsafe(no_mangle)]
pub extern "C" fn text_length(world: &World) -> usize {
    world.text.len()
}
