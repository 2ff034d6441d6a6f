//! The unit of mass, of length or of time changes no bit of a mantissa and no work, where it changes by a power of two: scenes of
//! contacts on surfaces and joint rows.

use crate::support::random::{draws, numbers};
use nalgebra::{SMatrix, SVector};
use stiction::{Contact, Error, JointRow, Kernel, Real, RowLaw, Settings, Solution, Status, Surface};

/// Three velocities along lengths, and three about axes.
const N: usize = 6;
const D: usize = 4;
const C: usize = 4;
const R: usize = 6;

type Outcome<T> = Result<Solution<T, N, D, C, R>, Error>;

/// Exponents of the units of mass, length and time.
#[derive(Clone, Copy, Debug, Default)]
struct Units {
    mass: i32,
    length: i32,
    time: i32,
}

fn two<T: Real>(exponent: i32) -> T {
    T::literal(2_f64.powi(exponent))
}

impl Units {
    /// kg^a m^b s^c
    fn of<T: Real>(self, [a, b, c]: [i32; 3]) -> T {
        two(a * self.mass + b * self.length + c * self.time)
    }

    /// Length per unit of a velocity: 1 along lengths, 0 about axes.
    const fn reach(k: usize) -> i32 {
        if k < 3 { 1 } else { 0 }
    }

    /// A kernel with a scene drawn from some numbers, and a free impulse.
    fn kernel<T: Real>(self, x: &[f64]) -> Result<(Kernel<T, N, D, C, R, C>, SVector<T, N>), Error> {
        let mut x = x.iter().copied();
        let mut next = || x.next().unwrap_or(0.5);
        let mut kernel = Kernel::new();
        let scene = kernel.scene_mut();
        let root = SMatrix::<f64, N, N>::from_fn(|_, _| next());
        let mass = root * root.transpose() + SMatrix::identity() * 0.1;
        let lengths = |i, j| 2 - Self::reach(i) - Self::reach(j);
        scene.set_mass(&SMatrix::from_fn(|i, j| {
            T::literal(mass[(i.min(j), i.max(j))]) * self.of([1, lengths(i, j), 0])
        }))?;
        for key in 0..2 {
            let contact = Contact {
                // Three rows along lengths, one about the normal.
                jacobian: SMatrix::from_fn(|row, k| {
                    let length = i32::from(row < 3) - Self::reach(k);
                    T::literal(next()) * self.of([0, length, 0])
                }),
                offset: SVector::from_fn(|row, _| {
                    T::literal(0.3 * next()) * self.of([0, i32::from(row < 3), -1])
                }),
                mu: T::ZERO,
                key,
            };
            let mut friction = || T::literal((next() + 0.4).max(0.0));
            let surface = Surface {
                friction: [friction(), friction()],
                spin: friction() * self.of([0, 1, 0]),
                roll: [T::ZERO; 2],
                compliance: [T::literal((0.1 * next()).max(0.0)) * self.of([-1, 0, 0]), T::ZERO],
            };
            scene.push_on(&contact, &surface)?;
        }
        for key in 0..5 {
            let bound = next();
            let impulse: T = self.of([1, 2, -1]);
            let law = match key {
                0 => RowLaw::Equality,
                1 | 2 => RowLaw::Limit,
                _ => RowLaw::Box {
                    lower: T::literal(-bound.abs()) * impulse,
                    upper: T::literal(2.0 * bound.abs()) * impulse,
                },
            };
            scene.push_row(&JointRow {
                // About an axis.
                row: SVector::from_fn(|k, _| T::literal(next()) * self.of([0, -Self::reach(k), 0])),
                offset: T::literal(0.5 * next()) * self.of([0, 0, -1]),
                law,
                compliance: T::literal((0.2 * next()).max(0.0)) * self.of([-1, -2, 0]),
                key,
            })?;
        }
        let push = SVector::from_fn(|k, _| T::literal(next()) * self.of([1, 2 - Self::reach(k), -1]));
        Ok((kernel, push))
    }

    fn solve<T: Real>(self, x: &[f64], tolerance: f64) -> Outcome<T> {
        let (mut kernel, push) = self.kernel::<T>(x)?;
        let settings = Settings { budget: 300, ..Settings::new(T::literal(tolerance)) };
        Ok(kernel.solve(&push, &settings)?.clone())
    }

    /// Is it what the plain units give, in these?
    fn check<T: Real>(self, plain: &Solution<T, N, D, C, R>, found: &Solution<T, N, D, C, R>) {
        assert_eq!((plain.status, plain.work), (found.status, found.work), "{self:?}");
        // The norm of momenta adds those along lengths to those about axes.
        assert!(self.length != 0 || plain.error == found.error, "{self:?}");
        for (k, (x, y)) in plain.velocity.iter().zip(found.velocity.iter()).enumerate() {
            assert_eq!(*x * self.of([0, Self::reach(k), -1]), *y, "{self:?}");
        }
        assert_eq!((plain.contacts.len(), plain.rows.len()), (2, 5));
        assert_eq!((found.contacts.len(), found.rows.len()), (2, 5));
        for (x, y) in plain.contacts.iter().zip(&found.contacts) {
            assert_eq!(x.mode, y.mode);
            for (row, (x, y)) in x.impulse.iter().zip(y.impulse.iter()).enumerate() {
                assert_eq!(*x * self.of([1, 2 - i32::from(row < 3), -1]), *y, "{self:?}");
            }
        }
        for (x, y) in plain.rows.iter().zip(&found.rows) {
            assert_eq!((x.key, x.mode), (y.key, y.mode));
            assert_eq!(x.impulse * self.of([1, 2, -1]), y.impulse, "{self:?}");
            // It is computed again where that norm is near the tolerance.
            let same = x.velocity * self.of([0, 0, -1]) == y.velocity;
            assert!(self.length != 0 || same, "{self:?}");
        }
    }
}

fn is_independent_of_units<T: Real>(tolerance: f64) {
    let units = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-3, 2, 5], [7, -4, -1]];
    let mut ended = [0; 2];
    for x in draws(numbers(160), 300) {
        let plain = Units::default().solve::<T>(&x, tolerance);
        if let Ok(plain) = &plain {
            ended[usize::from(plain.status == Status::Solved)] += 1;
        }
        for [mass, length, time] in units {
            let units = Units { mass, length, time };
            match (&plain, units.solve::<T>(&x, tolerance)) {
                (Ok(plain), Ok(found)) => units.check(plain, &found),
                (plain, found) => assert_eq!(plain.as_ref().err(), found.as_ref().err()),
            }
        }
    }
    assert!(ended[1] > 100, "{ended:?} of 300 are solved");
}

#[test]
fn in_double_precision() {
    is_independent_of_units::<f64>(1e-9);
}

#[test]
fn in_single_precision() {
    is_independent_of_units::<f32>(1e-4);
}
