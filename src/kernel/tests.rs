//! A scene with fewer velocities than there is room for is solved as in a kernel of its own size.

extern crate std;

use crate::{Contact, Error, JointRow, Kernel, RowLaw, Settings};
use nalgebra::{SMatrix, SVector};

/// Room for velocities.
const N: usize = 20;

type Large = Kernel<f64, N, 3, 4, 2, 0>;

/// Numbers between -1 and 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(self.0 >> 32).unwrap()) / f64::from(1_u32 << 31) - 1.0
    }
}

/// A scene over `K` velocities.
struct Data<const K: usize> {
    mass: SMatrix<f64, K, K>,
    contacts: std::vec::Vec<Contact<f64, K, 3>>,
    rows: std::vec::Vec<JointRow<f64, K>>,
    push: SVector<f64, K>,
}

impl<const K: usize> Data<K> {
    fn random(numbers: &mut Numbers, rows: usize) -> Self {
        let root = SMatrix::<f64, K, K>::from_fn(|_, _| numbers.next());
        let mut contact = |key| {
            let mut jacobian = SMatrix::<f64, 3, K>::from_fn(|_, _| numbers.next());
            // As the leg of a robot: a joint of another leg has no part.
            for column in 6..K {
                if column % 3 == usize::try_from(key).unwrap() % 3 {
                    jacobian.column_mut(column).fill(0.0);
                }
            }
            let offset = SVector::from_fn(|_, _| 0.1 * numbers.next());
            Contact { jacobian, offset, mu: 0.3 + 0.2 * f64::from(key), key }
        };
        let contacts = (0..4).map(&mut contact).collect();
        let rows = (0..rows).map(|key| JointRow {
            row: SVector::from_fn(|_, _| numbers.next()),
            offset: 0.1 * numbers.next(),
            law: RowLaw::Limit,
            compliance: 0.0,
            key: u32::try_from(key).unwrap(),
        });
        let rows = rows.collect();
        let mass = root * root.transpose() + SMatrix::identity();
        Self { mass, contacts, rows, push: SVector::from_fn(|_, _| numbers.next()) }
    }

    fn fill<const M: usize>(
        &self,
        kernel: &mut Kernel<f64, M, 3, 4, 2, 0>,
    ) -> Result<SVector<f64, M>, Error> {
        // What is not in use is no number.
        let scene = kernel.scene_mut();
        scene.clear();
        scene.set_velocities(K)?;
        scene.set_mass(&self.mass.fixed_resize(f64::NAN))?;
        for contact in &self.contacts {
            let Contact { offset, mu, key, .. } = *contact;
            let jacobian = contact.jacobian.fixed_resize(f64::NAN);
            scene.push(&Contact { jacobian, offset, mu, key })?;
        }
        for row in &self.rows {
            let JointRow { offset, law, compliance, key, .. } = *row;
            scene.push_row(&JointRow {
                row: row.row.fixed_resize(f64::NAN),
                offset,
                law,
                compliance,
                key,
            })?;
        }
        Ok(self.push.fixed_resize(f64::NAN))
    }
}

fn compare<const K: usize>(large: &mut Large, numbers: &mut Numbers, rows: usize) -> Result<(), Error> {
    let data = Data::<K>::random(numbers, rows);
    let mut own = Kernel::<f64, K, 3, 4, 2, 0>::new();
    let push = data.fill(&mut own)?;
    let large_push = data.fill(large)?;
    large.solver_mut().reset();
    for tolerance in [1e-3, 1e-9, 1e-15] {
        let settings = Settings::new(tolerance);
        let expected = own.solve(&push, &settings)?.clone();
        let found = large.solve(&large_push, &settings)?.clone();
        assert!(found.velocity.iter().skip(K).all(|&v| v == 0.0));
        assert!(found.error.is_finite() && found.velocity.iter().all(|v| v.is_finite()));
        assert_eq!((found.status, found.work), (expected.status, expected.work));
        assert_eq!((found.contacts, found.rows), (expected.contacts, expected.rows));
        assert_eq!(found.error.to_bits(), expected.error.to_bits());
        assert_eq!(found.velocity.fixed_rows::<K>(0), expected.velocity);
        assert_eq!(found.certificate, expected.certificate);
    }
    Ok(())
}

#[test]
fn a_scene_in_a_large_kernel_has_the_bits_of_its_own() -> Result<(), Error> {
    let (mut large, mut numbers) = (Large::new(), Numbers(1));
    for rows in [0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 2] {
        compare::<20>(&mut large, &mut numbers, rows)?;
        compare::<3>(&mut large, &mut numbers, rows)?;
        compare::<18>(&mut large, &mut numbers, rows)?;
        compare::<1>(&mut large, &mut numbers, rows)?;
        compare::<7>(&mut large, &mut numbers, rows)?;
        compare::<16>(&mut large, &mut numbers, rows)?;
        compare::<6>(&mut large, &mut numbers, rows)?;
        compare::<5>(&mut large, &mut numbers, rows)?;
        compare::<9>(&mut large, &mut numbers, rows)?;
        compare::<12>(&mut large, &mut numbers, rows)?;
        compare::<2>(&mut large, &mut numbers, rows)?;
    }
    Ok(())
}

#[test]
fn there_is_room_for_so_many_velocities() {
    let mut large = Large::new();
    for velocities in [0, N + 1, usize::MAX] {
        let refused = Err(Error::InvalidVelocityCount { velocities, capacity: N });
        assert_eq!(large.scene_mut().set_velocities(velocities), refused);
    }
    assert_eq!(large.scene().velocities(), N);
    assert_eq!(large.scene_mut().set_velocities(1), Ok(()));
    assert_eq!(large.scene().velocities(), 1);
}
