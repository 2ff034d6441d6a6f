//! A push on a box grows until it slides: what warns, and what does not.
//!
//! The box stands on four corners and is pushed at half of its height. Friction to spare falls evenly to 0 and says how much the push may still
//! grow. The share of its friction that one corner uses reaches 1 long before.
//!
//! `cargo run --release -p pictures --bin near_slipping [FILE.svg]`

use nalgebra::{Matrix6, SVector, Vector3, matrix, vector};
use pictures::{curve, panel};
use std::error::Error;
use stiction::{Contact, ContactMode, Kernel, Settings};

const MU: f64 = 0.5;
const MASS: f64 = 2.0;
const WEIGHT: f64 = MASS * 9.81;
const STEP: f64 = 1e-3;
const HEIGHT: f64 = 0.05;
const STEPS: i32 = 400;

fn kernel() -> Result<Kernel<f64, 6, 3, 4>, stiction::Error> {
    let mut kernel = Kernel::new();
    let mass = Matrix6::from_diagonal(&vector![MASS, MASS, MASS, 0.01, 0.01, 0.01]);
    kernel.scene_mut().set_mass(&mass)?;
    for (key, [x, y]) in (0..).zip([[0.1, 0.1], [0.1, -0.1], [-0.1, 0.1], [-0.1, -0.1]]) {
        let corner: Vector3<f64> = vector![x, y, -HEIGHT];
        let jacobian = matrix![
            0.0, 0.0, 1.0, corner.y, -corner.x, 0.0;
            1.0, 0.0, 0.0, 0.0, corner.z, -corner.y;
            0.0, 1.0, 0.0, -corner.z, 0.0, corner.x
        ];
        kernel.scene_mut().push(&Contact { jacobian, offset: SVector::zeros(), mu: MU, key })?;
    }
    Ok(kernel)
}

/// The largest share of its friction that a corner uses.
fn use_of<'a>(impulses: impl Iterator<Item = &'a SVector<f64, 3>>) -> f64 {
    impulses.map(|r| r.yz().norm() / (MU * r.x)).fold(0.0, f64::max)
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut kernel, settings) = (kernel()?, Settings::new(1e-6));
    let (mut spare, mut raw, mut least, mut slips) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for step in 1..=STEPS {
        let share = 1.1 * f64::from(step) / f64::from(STEPS);
        let push = vector![share * MU * WEIGHT, 0.0, -WEIGHT, 0.0, 0.0, 0.0] * STEP;
        let solution = kernel.solve(&push, &settings)?;
        let slipping = solution.contacts.iter().filter(|contact| contact.mode == ContactMode::Slip).count();
        slips.push((share, f64::from(u32::try_from(slipping)?)));
        raw.push((share, use_of(solution.contacts.iter().map(|contact| &contact.impulse))));
        least.push((share, use_of(kernel.least_impulses(&settings)?.contacts.iter())));
        // Once it slides, nothing sticks that could slip.
        let reserve = if slipping == 0 { kernel.slip_reserve(&Settings::new(1e-4))? } else { 1.0 };
        spare.push((share, 1.0 - reserve));
        if step % 40 == 0 {
            let [use_of_one, shared] = [&raw, &least].map(|points| points[points.len() - 1].1);
            println!(
                "{share:.2} of the limit: {:.4} of the friction to spare; a corner uses {use_of_one:.2} of its own, \
                 {shared:.2} of least impulses; {slipping} slip",
                1.0 - reserve
            );
        }
    }
    let x = "push, as a share of what friction bears";
    pictures::draw(
        "near_slipping",
        &[
            panel(
                "A box is pushed until it slides",
                x,
                "share of friction",
                [
                    curve("to spare: 1 - slip_reserve", spare),
                    curve("used by a corner", raw),
                    curve("the same, least impulses", least),
                ],
            ),
            panel("Corners that slip", x, "", [curve("", slips)]),
        ],
    )
}
