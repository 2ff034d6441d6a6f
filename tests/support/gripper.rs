//! Three fingers of two joints hold a thing by up to nine tactile contacts: its forces are shared out within friction and torques.
//!
//! The velocities are what the grasp misses of the wanted force and moment (six), and what each joint would need beyond its torque (six).

use super::check::Tally;
use super::random::{draws, numbers};
use nalgebra::{SMatrix, SVector, Vector3, vector};
use stiction::{Contact, Error, JointRow, Kernel, Model, Phases, Real, RowLaw, Settings, Surface};

const DOFS: usize = 12;
const TOUCHES: u32 = 9;
/// The price of a force, of a missed moment (1/m²), and of a torque beyond its limit.
const ALPHA: f32 = 0.1;
const MOMENT: f32 = 600.0;
const BEYOND: f32 = 100.0;
/// The largest torque of a joint (N·m).
const TORQUE: f32 = 0.12;
/// Directions of the fingers.
const FINGERS: [[f32; 2]; 3] = [[1.0, 0.0], [-0.5, 0.866], [-0.5, -0.866]];

/// The contact with this key: one of three rings about a thing of four centimetres, and the finger in its direction.
fn touch<const N: usize>(key: u32, mu: f32, noise: &[f32]) -> Result<Contact<f32, N, 3>, Error> {
    let finger = key as usize % 3;
    let [x, y] = FINGERS[finger];
    let ring = [-0.25, 0.0, 0.25][key as usize / 3];
    let out = vector![x, y, ring].normalize();
    let at = out * 0.04 + Vector3::from_column_slice(&noise[..3]) * 5e-4;
    let inward = (Vector3::from_column_slice(&noise[3..6]) * 0.03 - out).normalize();
    let mut rows = SMatrix::<f32, 3, N>::identity();
    rows.fixed_columns_mut::<3>(3).copy_from(&-at.cross_matrix());
    for (k, (along, up)) in [(0.06, -0.1), (0.085, -0.05)].into_iter().enumerate() {
        let arm = at - vector![x * along, y * along, up];
        rows.set_column(6 + 2 * finger + k, &vector![y, -x, 0.0].cross(&arm));
    }
    Contact::at_point(&inward, &rows, mu, key)
}

/// Holds for 2,000 ticks, with noise, contacts that come, go and chatter, a load too large, and ice. How the ticks ended.
///
/// A cold gripper forgets each tick.
pub(crate) fn hold<P: Phases, const N: usize, const C: usize, const R: usize>(
    kernel: &mut Kernel<f32, N, 3, C, R, C, P>,
    budget: usize,
    is_cold: bool,
) -> Result<Tally, Error> {
    let settings = Settings { model: Model::ConvexRelaxation, budget, ..Settings::new(1e-4) };
    let mut mass = SMatrix::identity();
    for i in 3..DOFS {
        mass[(i, i)] = 1.0 / if i < 6 { MOMENT } else { BEYOND };
    }
    kernel.reset();
    kernel.scene_mut().set_velocities(DOFS)?;
    kernel.scene_mut().set_mass(&mass)?;
    let mut tally = Tally::default();
    for (noise, tick) in draws(numbers(6 * TOUCHES as usize + 6), 2_000).zip(0_u32..) {
        let noise = noise.into_iter().map(f32::literal).collect::<Vec<_>>();
        let (touches, wanted) = noise.split_at(6 * TOUCHES as usize);
        let mu = match tick {
            1_400..1_450 => 0.0,
            1_450..1_500 => 0.05,
            _ => 0.6,
        };
        let scene = kernel.scene_mut();
        scene.clear();
        for (key, noise) in (0..TOUCHES).zip(touches.chunks(6)) {
            let is_lost = match tick {
                ..300 => key >= 3,
                300..500 => key >= 6,
                700..800 => noise[0] > 0.6,
                800..900 => key > 2 && (tick + key) % 2 == 0,
                1_000..1_020 => key > 0,
                _ => false,
            };
            if !is_lost {
                let surface = Surface { compliance: [ALPHA; 2], ..Surface::isotropic(mu) };
                scene.push_on(&touch(key, mu, noise)?, &surface)?;
            }
        }
        for (i, key) in (6..DOFS).zip(0..) {
            let mut row = SVector::zeros();
            row[i] = 1.0;
            let law = RowLaw::Box { lower: -TORQUE, upper: TORQUE };
            scene.push_row(&JointRow { row, offset: 0.0, law, compliance: 0.0, key })?;
        }
        let load = if (1_200..1_250).contains(&tick) { 40.0 } else { 5.0 };
        let spread = [0.3, 0.3, 0.2, 0.005, 0.005, 0.005];
        let mut free = SVector::zeros();
        for (i, (noise, spread)) in wanted.iter().zip(spread).enumerate() {
            free[i] = -noise * spread;
        }
        free[2] -= load;
        if is_cold {
            kernel.solver_mut().reset();
        }
        tally.add(kernel.solve(&free, &settings)?);
    }
    Ok(tally)
}
