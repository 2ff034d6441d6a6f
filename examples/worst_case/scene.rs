//! Scenes from numbers in flash, as `bake by-size` writes them, and disturbed ones.

use crate::worst_case::Push;
use core::array::from_fn;
use nalgebra::{SMatrix, SVector};
use stiction::{Contact, JointRow, RowLaw, Scene, Surface};

/// A scene and its free impulse (N·s).
#[derive(Clone)]
pub(crate) struct Given<const N: usize, const D: usize, const C: usize, const R: usize> {
    mass: SMatrix<f32, N, N>,
    push: SVector<f32, N>,
    /// Contacts and joint rows in use.
    counts: [usize; 2],
    contacts: [(Contact<f32, N, D>, Surface<f32>); C],
    rows: [JointRow<f32, N>; R],
}

/// Numerical Recipes' generator: a number between -1 and 1.
pub(crate) struct Random(pub(crate) u32);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 16) as u16 as f32 / 32768.0 - 1.0
    }

    /// A number below `n`, or 0.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        self.next();
        (self.0 >> 12) as usize % n.max(1)
    }

    /// Often a plain number, sometimes a large or a small one.
    fn number(&mut self) -> f32 {
        let [sign, small] = [self.next(), self.next()];
        [0.0, 1.0, -1.0, 1e-3 * sign, 1e3 * sign, sign, small, sign * small][self.below(8)]
    }
}

impl<const N: usize, const D: usize, const C: usize, const R: usize> Given<N, D, C, R> {
    /// Velocities that the scene does not have are of bodies of their own. `None` if there are too few numbers.
    pub(crate) fn read(numbers: &[f32], has_surfaces: bool) -> Option<Self> {
        let mut numbers = numbers.iter().copied();
        let mut next = || numbers.next();
        let [velocities, contacts, rows] = [next()?, next()?, next()?].map(|count| count as usize);
        let mut given = Self {
            counts: [contacts, rows],
            mass: SMatrix::identity(),
            push: SVector::zeros(),
            contacts: from_fn(|_| {
                let contact =
                    Contact { jacobian: SMatrix::zeros(), offset: SVector::zeros(), mu: 0.0, key: 0 };
                (contact, Surface::isotropic(0.0))
            }),
            rows: from_fn(|_| JointRow {
                row: SVector::zeros(),
                offset: 0.0,
                law: RowLaw::Limit,
                compliance: 0.0,
                key: 0,
            }),
        };
        for mut column in given.mass.column_iter_mut().take(velocities) {
            for entry in column.iter_mut().take(velocities) {
                *entry = next()?; // it is symmetric
            }
        }
        for push in given.push.iter_mut().take(velocities) {
            *push = next()?;
        }
        for (key, (contact, surface)) in (0..).zip(&mut given.contacts).take(contacts) {
            contact.key = key;
            contact.mu = next()?;
            if has_surfaces {
                surface.friction = [contact.mu, next()?];
                surface.spin = next()?;
                surface.roll = [next()?, next()?];
                surface.compliance = [next()?, next()?];
            }
            for w in contact.offset.iter_mut() {
                *w = next()?;
            }
            for mut row in contact.jacobian.row_iter_mut() {
                for entry in row.iter_mut().take(velocities) {
                    *entry = next()?;
                }
            }
        }
        for (key, row) in (1000..).zip(&mut given.rows).take(rows) {
            row.key = key;
            for entry in row.row.iter_mut().take(velocities) {
                *entry = next()?;
            }
            (row.offset, row.compliance) = (next()?, next()?);
            let [kind, lower, upper] = [next()?, next()?, next()?];
            row.law = match kind {
                0.0 => RowLaw::Limit,
                1.0 => RowLaw::Equality,
                _ => RowLaw::Box { lower, upper },
            };
        }
        Some(given)
    }

    /// The same with other pushes, offsets and friction, the more the larger `share` is.
    pub(crate) fn disturb(&mut self, share: f32, random: &mut Random) {
        let largest = self.push.amax();
        for push in self.push.iter_mut() {
            *push += largest * share * random.next();
        }
        for (contact, _) in &mut self.contacts {
            contact.mu *= 1.0 + 0.5 * share.min(1.0) * random.next();
            for w in contact.offset.iter_mut() {
                *w += 0.1 * share * random.next();
            }
        }
        for row in &mut self.rows {
            row.offset += 0.1 * share * random.next();
        }
    }

    /// The same where everything moves everything, with as many contacts and joint rows as there is room for: no zeros in `M`, `H` and
    /// the joint rows.
    pub(crate) fn make_dense(&mut self, random: &mut Random) {
        let scale = self.mass.diagonal().amax();
        self.mass = SMatrix::from_diagonal_element(scale);
        for i in 0..N {
            for j in 0..i {
                let entry = scale / N as f32 * random.next();
                (self.mass[(i, j)], self.mass[(j, i)]) = (entry, entry);
            }
        }
        for (key, (contact, _)) in (0..).zip(&mut self.contacts) {
            if key as usize >= self.counts[0] {
                (contact.key, contact.mu) = (key, 0.5);
            }
            contact.jacobian.iter_mut().for_each(|h| *h = random.next());
        }
        self.counts[0] = C;
        for (key, row) in (1000..).zip(&mut self.rows) {
            row.key = key;
            row.row.iter_mut().for_each(|entry| *entry = random.next());
        }
        self.counts[1] = R;
    }

    /// Changes one number or one contact at random.
    pub(crate) fn change(&mut self, random: &mut Random) {
        let (c, other, row) = (random.below(C), random.below(C), random.below(R));
        let (i, axis, number) = (random.below(N), random.below(D), random.number());
        match random.below(8) {
            0 => self.push[i] = number,
            1 => self.push[i] *= 1.0 + 0.2 * random.next(),
            2 => {
                let scale = [0.1, 0.5, 2.0, 10.0][random.below(4)]; // of a mass: `M` stays positive definite
                self.mass.row_mut(i).scale_mut(scale);
                self.mass.column_mut(i).scale_mut(scale);
            }
            3 if R > 0 => self.rows[row].row[i] = number,
            4 if R > 0 => {
                self.rows[row].offset = number;
                self.rows[row].law = match random.below(3) {
                    0 => RowLaw::Limit,
                    1 => RowLaw::Equality,
                    _ => RowLaw::Box { lower: -number.abs(), upper: 1.0 },
                };
            }
            5 if C > 0 => self.contacts[c].0.offset[axis] = number,
            6 if C > 1 => {
                let (mut twin, surface) = self.contacts[other].clone();
                twin.key = self.contacts[c].0.key;
                twin.jacobian *= [1.0, -1.0][random.below(2)];
                self.contacts[c] = (twin, surface);
            }
            7 if C > 0 => {
                let (contact, surface) = &mut self.contacts[c];
                contact.mu = [0.0, 0.1, 0.5, 1.0, 100.0][random.below(5)];
                surface.friction = [contact.mu, contact.mu * random.next().abs()];
            }
            _ if C > 0 => self.contacts[c].0.jacobian[(axis, i)] = number,
            _ => {}
        }
    }

    /// Fills a scene; `None` if it refuses.
    pub(crate) fn fill<const S: usize>(
        &self,
        scene: &mut Scene<f32, N, D, C, R, S>,
        push: Push<N, D, C, R, S>,
    ) -> Option<()> {
        scene.clear();
        scene.set_mass(&self.mass).ok()?;
        for (contact, surface) in self.contacts.iter().take(self.counts[0]) {
            push(scene, contact, surface).ok()?;
        }
        for row in self.rows.iter().take(self.counts[1]) {
            scene.push_row(row).ok()?;
        }
        Some(())
    }

    /// Its free impulse.
    pub(crate) const fn push(&self) -> &SVector<f32, N> {
        &self.push
    }
}
