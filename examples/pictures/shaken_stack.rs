//! Three boxes of 1, 10 and 100 kg, the heaviest on top, on a table that is shaken harder and harder.
//!
//! While the table accelerates at less than `mu g` the stack moves as one; beyond that the heaviest
//! box, on the smoothest contact, stays behind. `M` stays, `H` and `w` are set anew at every step, in place.
//!
//! `cargo run --release -p pictures --bin shaken_stack [FILE.svg]`

use nalgebra::{SMatrix, SVector, Vector2, matrix, vector};
use pictures::{curve, dots, panel};
use std::error::Error;
use stiction::time_stepping::{Gap, free_impulse, moving_surface};
use stiction::{Contact, Factor, Scene, Settings, Solver, Status, contact_frame};

const GRAVITY: f64 = 9.81;
const STEP: f64 = 1e-3;
/// Masses (kg), half widths (m) and friction underneath, from below; all boxes are 20 cm high.
const MASSES: [f64; 3] = [1.0, 10.0, 100.0];
const WIDTHS: [f64; 3] = [0.30, 0.28, 0.26];
const MU: [f64; 3] = [0.6, 0.5, 0.3];
const HALF: f64 = 0.1;
/// A penetration is pushed out at 0.1 m/s at most; nothing closes faster than 10 m/s.
const GAP: Gap<f64> = Gap { distance: 0.0, recovery: 0.1, reach: 10.0 };

/// Position (x, height, angle) or velocity of each box.
type Coordinates = SVector<f64, 9>;

/// Unit vectors along and out of the top of a body at an angle.
fn axes(angle: f64) -> [Vector2<f64>; 2] {
    let (sin, cos) = angle.sin_cos();
    [vector![cos, sin], vector![-sin, cos]]
}

/// Distance and contact between the lower left or right corner of a box and what it stands on.
fn touch(
    position: &Coordinates,
    upper: usize,
    side: f64,
) -> Result<(f64, Contact<f64, 9, 2>), stiction::Error> {
    let body = |i: usize| position.fixed_rows::<3>(3 * i).clone_owned();
    let (above, below) = (body(upper), upper.checked_sub(1).map(body));
    let [along, out] = axes(above.z);
    let arm = along * (side * WIDTHS[upper]) - out * HALF;
    let corner = above.xy() + arm;
    // The table is below all, its top at height 0.
    let support = below.unwrap_or_else(|| vector![corner.x, -HALF, 0.0]);
    let [_, normal] = axes(support.z);
    let reach = corner - support.xy();
    // Velocity of the corner, and of what is under it.
    let mut jacobian = SMatrix::<f64, 2, 9>::zeros();
    let mut add = |body: usize, sign: f64, arm: Vector2<f64>| {
        let entries = matrix![1.0, 0.0, -arm.y; 0.0, 1.0, arm.x] * sign;
        let mut block = jacobian.fixed_view_mut::<2, 3>(0, 3 * body);
        block.copy_from(&entries);
    };
    add(upper, 1.0, arm);
    if upper > 0 {
        add(upper - 1, -1.0, reach);
    }
    let contact = Contact::at_point(&normal, &jacobian, MU[upper], 0)?;
    Ok((normal.dot(&reach) - HALF, contact))
}

/// Velocity of the table: 2 shakes a second, the acceleration grows by 2 m/s² each second.
fn table(time: f64) -> f64 {
    let frequency = 4.0 * std::f64::consts::PI;
    2.0 * time / frequency * (frequency * time).sin()
}

fn main() -> Result<(), Box<dyn Error>> {
    let inertia = |m: f64, width: f64| m * (width * width + HALF * HALF) / 3.0;
    let bodies = MASSES.into_iter().zip(WIDTHS);
    let masses = bodies.flat_map(|(m, width)| [m, m, inertia(m, width)]);
    let mass = SMatrix::<f64, 9, 9>::from_diagonal(&SVector::from_iterator(masses));
    let weight = MASSES.into_iter().flat_map(|m| [0.0, -GRAVITY * m, 0.0]);
    let weight = Coordinates::from_iterator(weight);
    let heights = [HALF, 3.0 * HALF, 5.0 * HALF].into_iter();
    let mut position = Coordinates::from_iterator(heights.flat_map(|height| [0.0, height, 0.0]));
    let mut velocity = Coordinates::zeros();

    let mut scene = Scene::<f64, 9, 2, 6>::new();
    scene.set_mass(&mass)?;
    let contacts: [(usize, f64); 6] = std::array::from_fn(|k| (k / 2, [-1.0, 1.0][k % 2]));
    for (upper, side) in contacts {
        scene.push(&touch(&position, upper, side)?.1)?;
    }
    let mut factor = Factor::empty();
    let mut solver = Solver::new();
    let settings = Settings::new(1e-9);

    let (mut speeds, mut slips) = ([const { Vec::new() }; 4], [const { Vec::new() }; 3]);
    let mut ground = 0.0;
    for step in 1..=3500 {
        let time = STEP * f64::from(step);
        for (contact, &(upper, side)) in contacts.iter().enumerate() {
            let (distance, Contact { jacobian, .. }) = touch(&position, upper, side)?;
            let mut offset = vector![Gap { distance, ..GAP }.offset(STEP)?, 0.0];
            if upper == 0 {
                let frame = contact_frame(&vector![0.0, 1.0])?;
                offset += moving_surface(&frame.transpose(), &vector![table(time), 0.0]);
            }
            scene.set_jacobian(contact, &jacobian)?;
            scene.set_offset(contact, &offset)?;
        }
        factor.prepare(&scene)?;
        let push = free_impulse(&mass, &velocity, &weight, STEP);
        let solution = solver.solve(&scene, &factor, &push, &settings)?;
        if solution.status != Status::Solved {
            return Err(format!("step {step}: {:?}", solution.status).into());
        }
        velocity = solution.velocity;
        position += velocity * STEP;
        ground += table(time) * STEP;

        let speed = [table(time), velocity[0], velocity[3], velocity[6]];
        let place = [ground, position[0], position[3], position[6]];
        for (curve, speed) in speeds.iter_mut().zip(speed) {
            curve.push((time, speed));
        }
        for (curve, pair) in slips.iter_mut().zip(place.windows(2)) {
            curve.push((time, 100.0 * (pair[1] - pair[0])));
        }
    }
    let expected = MU[2] * GRAVITY / 2.0;
    println!(
        "3500 steps solved to 1e-9; on paper the table outruns the heaviest box from {expected:.2} s on"
    );
    let title = "Three boxes on a shaken table";
    let labels = ["table", "1 kg", "10 kg", "100 kg"].into_iter().zip(speeds);
    let speeds = labels.map(|(label, points)| curve(label, points));
    let labels = ["1 kg on the table", "10 kg on 1 kg", "100 kg on 10 kg"];
    let slips = labels.into_iter().zip(slips);
    let slips = slips.map(|(label, points)| curve(label, points));
    let slips = slips.chain([dots("limit, on paper", vec![(expected, 0.0)])]);
    pictures::draw(
        "shaken_stack",
        &[
            panel(title, "time (s)", "velocity (m/s)", speeds),
            panel("How far they have slipped", "time (s)", "slip (cm)", slips),
        ],
    )
}
