//! A box on a slope: sliders for the slope (degrees), the friction, and a push up the slope (N).
//!
//! Axes along the slope (up is positive) and out of it. The third velocity turns the box.

use crate::{GRAVITY, Given, Scene, Touch, Vector, of_body, turned};
use nalgebra::{SMatrix, vector};
use stiction::{Error, heapless};

const MASS: f64 = 5.0;
/// Half the length and half the height.
const HALF: [f64; 2] = [0.5, 0.3];

pub(crate) const SCENE: Scene = Scene {
    numbers: [MASS, HALF[0], HALF[1], 0.0, 0.0, 0.0],
    rates: [f64::INFINITY; 3],
    starts: [0.0; 3],
    turns: true,
    spring: 60.0,
    begin: |_| vector![0.0, HALF[1], 0.0, 0.0, 0.0],
    given,
};

fn given(q: &Vector, _: &Vector, [slope, mu, push]: [f64; 3]) -> Result<Given, Error> {
    let [w, h] = HALF;
    let inertia = MASS * (w * w + h * h) / 3.0;
    let (sine, cosine) = slope.to_radians().sin_cos();
    let mut touches = heapless::Vec::new();
    for (key, corner) in (0..).zip([[-w, -h], [w, -h], [w, h], [-w, h]]) {
        let lever = turned(q[2], corner);
        let point = q.fixed_rows::<2>(0) + lever;
        let touch = Touch::new(key, [point, vector![0.0, 1.0]], &of_body(&lever), mu, point.y)?;
        let _ = touches.push(touch);
    }
    let weight = MASS * GRAVITY;
    Ok(Given {
        velocities: 3,
        mass: SMatrix::from_diagonal(&vector![MASS, MASS, inertia, 0.0, 0.0]),
        force: vector![push - weight * sine, -weight * cosine, 0.0, 0.0, 0.0],
        touches,
        rows: heapless::Vec::new(),
    })
}
