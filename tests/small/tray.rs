//! A box that is carried by a tray: how far it is taken back to its place, from the impulses that press it already.

use crate::support::random::{draws, numbers};
use crate::support::sizes::body_rows;
use nalgebra::{SMatrix, SVector, Vector3, matrix, vector};
use stiction::{Contact, Error, Settings, Status, Surface};

const MASS: f64 = 0.5;
const HALF: f64 = 0.03;
const MU: f64 = 0.8;
const STEP: f64 = 0.005;

/// The Jacobian of a corner of the box at `place`, seen from its middle: height and two tangents.
fn corner(place: Vector3<f64>) -> SMatrix<f64, 3, 6> {
    let axes = matrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0];
    let turned = axes * -place.cross_matrix();
    SMatrix::from_fn(|i, j| if j < 3 { axes[(i, j)] } else { turned[(i, j - 3)] })
}

/// A kernel with the box on its four corners, with a compliance of all rows (1/kg) and an offset of each.
fn on_tray(
    compliance: f64,
    offset: impl Fn(usize) -> SVector<f64, 3>,
) -> Result<body_rows::Kernel<f64>, Error> {
    let mut kernel = body_rows::Kernel::new();
    let scene = kernel.scene_mut();
    let inertia = MASS * (2.0 * HALF).powi(2) / 6.0;
    scene.set_mass(&SMatrix::from_diagonal(&SVector::from([MASS, MASS, MASS, inertia, inertia, inertia])))?;
    let surface = Surface { compliance: [compliance; 2], ..Surface::isotropic(MU) };
    for (i, (x, y)) in [(-HALF, -HALF), (-HALF, HALF), (HALF, -HALF), (HALF, HALF)].into_iter().enumerate() {
        let contact =
            Contact { jacobian: corner(Vector3::new(x, y, -HALF)), offset: offset(i), mu: MU, key: 0 };
        scene.push_on(&contact, &surface)?;
    }
    Ok(kernel)
}

/// The tray speeds up by a share of what friction bears. The box is off by the creep of a step or a part of it, and its corners by
/// nanometres; one of them may have no load. Each is solved within the budget, at any compliance.
#[test]
fn a_box_on_a_tray_is_taken_back() -> Result<(), Error> {
    let draw = (0.0..0.95, -1.5_f64..0.0, numbers(4), -12.0_f64..-8.0, 0_usize..8);
    for (share, part, gaps, scale, unloaded) in draws(draw, 60) {
        let gain: f64 = share * MU * 9.81 * STEP;
        let settings = Settings::new(1e-8);
        let mut weight = SVector::zeros();
        weight[2] = -MASS * 9.81 * STEP;
        let mut kernel = on_tray(0.0, |_| vector![0.0, -gain, 0.0])?;
        let solution = kernel.solve(&weight, &settings)?;
        assert_eq!(solution.status, Status::Solved);
        let pressing: Vec<f64> = solution.contacts.iter().map(|contact| contact.impulse[0]).collect();
        for compliance in [0.0, 1e-7, 1e-6, 1e-5, 1e-4] {
            let soft = compliance / MASS;
            let mut kernel = on_tray(soft, |i| {
                let gap = gaps[i] * 10_f64.powf(scale) + if i == unloaded { 1e-9 } else { 0.0 };
                vector![gap / STEP - soft * pressing[i], 10_f64.powf(part) * gain, 0.0]
            })?;
            // M z = Hᵀ (r - r₀)
            let mut push = SVector::zeros();
            for (contact, pressing) in kernel.scene_mut().contacts().iter().zip(&pressing) {
                push -= contact.jacobian.row(0).transpose() * *pressing;
            }
            let solution = kernel.solve(&push, &settings)?;
            assert_eq!(solution.status, Status::Solved, "{compliance}: {:?}", solution.work);
        }
    }
    Ok(())
}
