//! Forces of a box on a slope before and after a nudge that did not move it.

use crate::body::{GRAVITY, STEP};
use crate::run::{SETTINGS, Setting, double};
use nalgebra::{SMatrix, SVector, Vector3, vector};
use stiction::time_stepping::free_impulse;
use stiction::{Contact, Error, Kernel, Real, Settings};

const MASS: f64 = 2.0;
const HALF: [f64; 3] = [0.2, 0.15, 0.1];
const MU: f64 = 0.6;

/// Forces and torques of the nudge. The slope falls along -x.
const NUDGE: [f64; 6] = [0.0, 4.0, 0.0, 1.0, 0.0, 0.6];

/// Ticks before the nudge, and while it lasts.
const BEFORE: usize = 500;
const DURING: usize = 200;

/// Ticks after the nudge at whose end forces are printed.
const AFTER: [usize; 3] = [50, 500, 5_000];

pub(crate) fn print() {
    println!(
        "A box of {MASS} kg on its corners, mu {MU}, and a nudge of 0.4 s that does not move it. Forces by symmetry: half of what \
         statics gives the two below and the two above.\n"
    );
    println!("| slope | setting | when | below left | below right | above left | above right |");
    println!("|---|---|---|--:|--:|--:|--:|");
    for degrees in [0.0, 10.0, 20.0_f64] {
        let slope = degrees.to_radians();
        let (into, down) = (slope.cos(), slope.sin() * HALF[2] / HALF[0]);
        let [below, above] = [into + down, into - down].map(|g| MASS * GRAVITY * g / 4.0);
        row(degrees, "", "by symmetry", [below, below, above, above]);
        for setting in SETTINGS {
            let forces =
                if setting.is_single { forces::<f32>(slope, setting) } else { forces::<f64>(slope, setting) };
            for (when, forces) in forces.expect("the box is valid") {
                row(degrees, setting.name, &when, forces);
            }
        }
    }
}

fn row(degrees: f64, setting: &str, when: &str, forces: [f64; 4]) {
    let forces = forces.map(|force| format!("{force:.2} N"));
    println!("| {degrees}° | {setting} | {when} | {} |", forces.join(" | "));
}

/// Normal forces at rest and after the nudge.
fn forces<T: Real>(slope: f64, setting: Setting) -> Result<Vec<(String, [f64; 4])>, Error> {
    let mut kernel = Kernel::<T, 6, 3, 8>::new();
    let [a, b, c] = HALF.map(|half| half * half);
    let inertia = vector![b + c, a + c, a + b] * (MASS / 3.0);
    let masses = vector![MASS, MASS, MASS, inertia.x, inertia.y, inertia.z];
    let mass = SMatrix::from_diagonal(&masses).map(T::literal);
    kernel.scene_mut().set_mass(&mass)?;
    let [x, y, z] = HALF;
    for (key, (x, y)) in (0..).zip([(-x, y), (-x, -y), (x, y), (x, -y)]) {
        let mut velocity = SMatrix::<f64, 3, 6>::identity();
        let arm = Vector3::new(x, y, -z).cross_matrix();
        velocity.fixed_columns_mut::<3>(3).copy_from(&-arm);
        let up = vector![T::ZERO, T::ZERO, T::ONE];
        let contact = Contact::at_point(&up, &velocity.map(T::literal), T::literal(MU), key)?;
        kernel.scene_mut().push(&contact)?;
    }
    let settings = Settings::new(T::literal(setting.tolerance));
    let weight = MASS * GRAVITY;
    let weight = vector![-weight * slope.sin(), 0.0, -weight * slope.cos(), 0.0, 0.0, 0.0];
    let mut velocity = SVector::<T, 6>::zeros();
    let mut seen = Vec::new();
    for tick in 0..BEFORE + DURING + AFTER[2] {
        let is_nudged = (BEFORE..BEFORE + DURING).contains(&tick);
        let nudge = SVector::from(if is_nudged { NUDGE } else { [0.0; 6] });
        let force = (weight + nudge).map(T::literal);
        let push = free_impulse(&mass, &velocity, &force, T::literal(STEP));
        let solution = kernel.solve(&push, &settings)?;
        velocity = solution.velocity;
        let after = (tick + 1).checked_sub(BEFORE + DURING);
        let when = match after {
            None if tick + 1 == BEFORE => "at rest".to_owned(),
            None if tick + 1 == BEFORE + DURING / 2 => "nudged".to_owned(),
            Some(after) if AFTER.contains(&after) => {
                let seconds = STEP * after as f64;
                format!("{seconds:.1} s after the nudge, {:.0e} m/s", double(velocity.norm()))
            }
            _ => continue,
        };
        let mut forces = [0.0; 4];
        for (force, contact) in forces.iter_mut().zip(&solution.contacts) {
            *force = double(contact.impulse[0]) / STEP;
        }
        seen.push((when, forces));
    }
    Ok(seen)
}
