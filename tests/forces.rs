//! Sharing out forces: a scene of the convex relaxation is the cone programme `min ½ |A f - b|²_S + ½ α |f|²`.

use crate::support::boxes::point_jacobian;
use crate::support::sizes::body_rows;
use nalgebra::{SMatrix, SVector, vector};
use proptest::prelude::*;
use stiction::{Contact, Model, Settings, Surface};

const FEET: [[f64; 2]; 4] = [[0.2, 0.15], [0.2, -0.15], [-0.2, 0.15], [-0.2, -0.15]];

/// `S`, `α` and `mu`.
type Wish = (SVector<f64, 6>, f64, f64);

/// `A`, and the forces on so many feet.
fn share(
    (weights, alpha, mu): Wish,
    feet: usize,
    wanted: &SVector<f64, 6>,
) -> (SMatrix<f64, 6, 12>, SVector<f64, 12>) {
    let mut kernel = body_rows::Kernel::<f64>::new();
    let scene = kernel.scene_mut();
    let masses = SMatrix::from_diagonal(&weights.map(|weight| 1.0 / weight));
    scene.set_mass(&masses).expect("positive weights");
    let mut grasp = SMatrix::<f64, 6, 12>::zeros();
    for (i, [x, y]) in FEET.into_iter().enumerate().take(feet) {
        let jacobian = point_jacobian(&vector![x, y, -0.3]);
        grasp.fixed_columns_mut::<3>(3 * i).copy_from(&jacobian.transpose());
        let foot = Contact { jacobian, offset: SVector::zeros(), mu, key: 0 };
        let surface = Surface { compliance: [alpha; 2], ..Surface::isotropic(mu) };
        scene.push_on(&foot, &surface).expect("a foot");
    }
    let settings = Settings { model: Model::ConvexRelaxation, budget: 10_000, ..Settings::new(1e-9) };
    let solution = kernel.solve(&-wanted, &settings).expect("finite data");
    assert!(solution.is_solved(), "{}", solution.status);
    let forces = solution.contacts.iter().flat_map(|foot| foot.impulse.data.0[0]);
    (grasp, SVector::from_iterator(forces.chain([0.0; 12]).take(12)))
}

proptest! {
    /// `f` in `K`, the gradient `Aᵀ S (A f - b) + α f` in `K*`, and the two orthogonal: the conditions of a convex programme.
    #[test]
    fn shared_forces_are_optimal(
        weights in prop::array::uniform6(0.5_f64..20.0),
        (alpha, mu, feet) in (1e-3_f64..1.0, 0.1_f64..1.0, 2..=4_usize),
        (push, moment) in (prop::array::uniform2(-80.0_f64..80.0), prop::array::uniform3(-10.0_f64..10.0)),
    ) {
        let weights = SVector::from(weights);
        let [x, y] = push;
        let [roll, pitch, yaw] = moment;
        let wanted = vector![x, y, 100.0, roll, pitch, yaw];
        let (grasp, forces) = share((weights, alpha, mu), feet, &wanted);
        let missed = grasp * forces - wanted;
        let gradient = grasp.transpose() * weights.component_mul(&missed) + forces * alpha;
        let (largest, steepest) = (forces.norm(), (grasp.transpose() * weights.component_mul(&wanted)).norm());
        let feet = forces.as_slice().chunks_exact(3).zip(gradient.as_slice().chunks_exact(3)).take(feet);
        for (f, u) in feet {
            prop_assert!(f[1].hypot(f[2]) <= mu * f[0] + 1e-9 * largest);
            prop_assert!(mu * u[1].hypot(u[2]) <= u[0] + 1e-7 * steepest, "{u:?}");
            let work = f[0] * u[0] + f[1] * u[1] + f[2] * u[2];
            prop_assert!(work.abs() <= 1e-7 * largest * steepest, "{work:e}");
        }
    }
}
