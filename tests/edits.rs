//! What is changed in a scene leaves it as one that was filled anew: the same factor, and the same bits of a solution.

use crate::support::random::{draws, numbers};
use crate::support::sizes::{bodies, joints};
use nalgebra::{SMatrix, SVector, vector};
use stiction::{Contact, Error, Factor, Input, JointRow, Kernel, RowLaw, Scene, Settings, Solution, Surface};

const N: usize = 10;
const D: usize = 3;
/// Contacts and joint rows of a scene: it has room for more.
const C: usize = 4;
const R: usize = 4;

type Whole = bodies::Scene<f64>;

/// What a scene is filled with; each contact with a surface, if it has one.
#[derive(Clone)]
struct Parts {
    mass: SMatrix<f64, N, N>,
    contacts: Vec<(Contact<f64, N, D>, Option<Surface<f64>>)>,
    rows: Vec<JointRow<f64, N>>,
    push: SVector<f64, N>,
}

impl Parts {
    /// Four contacts and four joint rows, two of each with the same key.
    fn drawn(x: &[f64]) -> Self {
        let mut x = x.iter().copied();
        let mut next = || x.next().expect("enough numbers");
        let root = SMatrix::<f64, N, N>::from_fn(|_, _| next());
        let mass = root * root.transpose() + SMatrix::identity();
        let contacts = [10, 20, 10, 30].map(|key| {
            let contact = Contact {
                jacobian: SMatrix::from_fn(|_, _| next()),
                offset: SVector::from_fn(|_, _| 0.1 * next()),
                mu: next().abs(),
                key,
            };
            (contact, None)
        });
        let (lower, upper) = (-0.2, 0.1);
        let laws = [RowLaw::Limit, RowLaw::Box { lower, upper }, RowLaw::Equality, RowLaw::Limit];
        let rows = [5, 6, 5, 7].into_iter().zip(laws).map(|(key, law)| JointRow {
            row: SVector::from_fn(|_, _| next()),
            offset: 0.1 * next(),
            law,
            compliance: 0.1 * next().max(0.0),
            key,
        });
        let rows = rows.collect();
        Self {
            mass: (mass + mass.transpose()) * 0.5,
            contacts: contacts.into(),
            rows,
            push: SVector::from_fn(|_, _| next()),
        }
    }

    fn many() -> impl Iterator<Item = Self> {
        draws(numbers(400), 30).map(|x| Self::drawn(&x))
    }

    fn fill(&self, scene: &mut Whole) -> Result<(), Error> {
        scene.clear();
        scene.set_mass(&self.mass)?;
        for (contact, surface) in &self.contacts {
            match surface {
                Some(surface) => scene.push_on(contact, surface)?,
                None => scene.push(contact)?,
            };
        }
        for row in &self.rows {
            scene.push_row(row)?;
        }
        Ok(())
    }

    fn scene(&self) -> Result<Whole, Error> {
        let mut scene = Scene::new();
        self.fill(&mut scene)?;
        Ok(scene)
    }

    /// Changes a scene in place, which is then as one that was filled with the changed parts: seen by a kernel that knows neither,
    /// and by one that has solved it before.
    fn check(&self, change: impl Fn(&mut Whole) -> Result<(), Error>, changed: &Self) -> Result<(), Error> {
        let (mut scene, anew) = (self.scene()?, changed.scene()?);
        let before = Factor::new(&scene)?;
        change(&mut scene)?;
        assert_eq!(scene.contacts(), anew.contacts());
        assert_eq!(scene.rows(), anew.rows());
        assert!(Factor::new(&anew)?.is_current(&scene));
        assert!(!before.is_current(&scene));
        for is_warm in [false, true] {
            let (mut one, mut other) = (Kernel::new(), Kernel::new());
            self.fill(one.scene_mut())?;
            self.fill(other.scene_mut())?;
            if is_warm {
                one.solve(&self.push, &settings())?;
                other.solve(&self.push, &settings())?;
            }
            change(one.scene_mut())?;
            changed.fill(other.scene_mut())?;
            let push = self.push * 0.9;
            let one = bits(one.solve(&push, &settings())?);
            assert_eq!(one, bits(other.solve(&push, &settings())?));
        }
        Ok(())
    }
}

fn settings() -> Settings<f64> {
    Settings::new(1e-10)
}

/// All of a solution: numbers are written so that they can be read back to the last bit.
fn bits<const N: usize, const D: usize, const C: usize, const R: usize>(
    solution: &Solution<f64, N, D, C, R>,
) -> String {
    format!("{solution:?}")
}

#[test]
fn a_contact_that_is_removed_leaves_a_scene_without_it() -> Result<(), Error> {
    for parts in Parts::many() {
        for place in 0..C {
            let mut fewer = parts.clone();
            fewer.contacts.remove(place);
            parts.check(|scene| scene.remove_contact(place), &fewer)?;
            // And another one.
            let (next, mut fewest) = (place % (C - 1), fewer.clone());
            fewest.contacts.remove(next);
            fewer.check(|scene| scene.remove_contact(next), &fewest)?;
        }
    }
    Ok(())
}

/// Each contact moves a body of its own, and only the entries there are looked at.
#[test]
fn a_contact_takes_the_places_of_its_entries_with_it() -> Result<(), Error> {
    for mut parts in Parts::many() {
        for (body, (contact, _)) in parts.contacts.iter_mut().enumerate() {
            for (dof, mut column) in contact.jacobian.column_iter_mut().enumerate() {
                if 2 * dof / 5 != body {
                    column.fill(0.0);
                }
            }
        }
        for place in 0..C {
            let mut fewer = parts.clone();
            fewer.contacts.remove(place);
            parts.check(|scene| scene.remove_contact(place), &fewer)?;
        }
        // To another body.
        let mut moved = parts.clone();
        let jacobian = parts.contacts[3].0.jacobian;
        moved.contacts[1].0.jacobian = jacobian;
        parts.check(|scene| scene.set_jacobian(1, &jacobian), &moved)?;
    }
    Ok(())
}

/// Surfaces move up with their contacts, and the last one that goes leaves nothing of itself.
#[test]
fn a_contact_takes_its_surface_with_it() -> Result<(), Error> {
    let track = Surface { friction: [0.9, 0.4], compliance: [0.02, 0.0], ..Surface::isotropic(0.0) };
    for mut parts in Parts::many() {
        for surfaces in [[false, true, false, true], [true; 4], [false, true, false, false]] {
            for ((_, place), has_one) in parts.contacts.iter_mut().zip(surfaces) {
                *place = has_one.then_some(track);
            }
            for ((contact, _), has_one) in parts.contacts.iter_mut().zip(surfaces) {
                contact.mu = if has_one { 0.9 } else { 0.5 };
            }
            for place in 0..C {
                let mut fewer = parts.clone();
                fewer.contacts.remove(place);
                parts.check(|scene| scene.remove_contact(place), &fewer)?;
            }
        }
    }
    Ok(())
}

/// The same without joint rows, where only a surface makes a scene more than one of contacts alone.
#[test]
fn the_last_surface_leaves_contacts_alone() -> Result<(), Error> {
    for mut parts in Parts::many() {
        parts.rows.clear();
        let soft = Surface { compliance: [0.02, 0.0], ..Surface::isotropic(0.5) };
        parts.contacts[1].1 = Some(soft);
        parts.contacts[1].0.mu = 0.5;
        let mut fewer = parts.clone();
        fewer.contacts.remove(1);
        parts.check(|scene| scene.remove_contact(1), &fewer)?;
    }
    Ok(())
}

#[test]
fn a_joint_row_that_is_removed_leaves_a_scene_without_it() -> Result<(), Error> {
    for parts in Parts::many() {
        for place in 0..R {
            let mut fewer = parts.clone();
            fewer.rows.remove(place);
            parts.check(|scene| scene.remove_row(place), &fewer)?;
        }
    }
    Ok(())
}

#[test]
fn a_joint_row_with_another_jacobian_or_compliance_is_another_row() -> Result<(), Error> {
    for parts in Parts::many() {
        for row in 0..R {
            let mut changed = parts.clone();
            let jacobian = changed.rows[row].row + SVector::ith(row, 0.5);
            changed.rows[row].row = jacobian;
            parts.check(|scene| scene.set_row_jacobian(row, &jacobian), &changed)?;
            let mut changed = parts.clone();
            let compliance = changed.rows[row].compliance + 0.125;
            changed.rows[row].compliance = compliance;
            parts.check(|scene| scene.set_row_compliance(row, compliance), &changed)?;
        }
    }
    Ok(())
}

/// What goes comes back, at the end of its list: a scene of the same contacts in another order.
#[test]
fn what_is_removed_may_be_pushed_again() -> Result<(), Error> {
    for parts in Parts::many() {
        let mut turned = parts.clone();
        turned.contacts.rotate_left(1);
        turned.rows.rotate_left(1);
        let again = |scene: &mut Whole| {
            scene.remove_contact(0)?;
            scene.remove_row(0)?;
            scene.push(&parts.contacts[0].0)?;
            scene.push_row(&parts.rows[0]).map(|_| ())
        };
        parts.check(again, &turned)?;
    }
    Ok(())
}

#[test]
fn a_key_finds_the_first_that_has_it() -> Result<(), Error> {
    let parts = Parts::many().next().expect("the first");
    let mut kernel = Kernel::new();
    parts.fill(kernel.scene_mut())?;
    kernel.solve(&parts.push, &settings())?;
    let (scene, solution) = (kernel.scene(), kernel.solution());
    for (key, place) in [(10, 0), (20, 1), (30, 3)] {
        assert_eq!(scene.contact_index(key), Some(place));
        assert_eq!(solution.contact_by_key(key), solution.contacts.get(place));
        assert_eq!(solution.contact_by_key(key).map(|c| c.key), Some(key));
    }
    for (key, place) in [(5, 0), (6, 1), (7, 3)] {
        assert_eq!(scene.row_index(key), Some(place));
        assert_eq!(solution.row_by_key(key), solution.rows.get(place));
        assert_eq!(solution.row_by_key(key).map(|row| row.key), Some(key));
    }
    // Keys of contacts and of joint rows are names of their own.
    assert!(scene.contact_index(5).is_none() && scene.row_index(10).is_none());
    assert!(solution.contact_by_key(5).is_none() && solution.row_by_key(10).is_none());
    Ok(())
}

#[test]
fn a_change_that_is_refused_changes_nothing() -> Result<(), Error> {
    let parts = Parts::many().next().expect("the first");
    let mut scene = parts.scene()?;
    let factor = Factor::new(&scene)?;
    let row = |row| Error::NoSuchRow { row };
    let input = Input::JointRow { row: 2 };
    let not_finite = Error::NotFinite { input, row: 4, column: 0 };
    let zeros = SVector::zeros();
    let nan = SVector::ith(4, f64::NAN);
    let none = usize::MAX;
    for (refused, error) in [
        (scene.remove_contact(4), Error::NoSuchContact { contact: 4 }),
        (scene.remove_contact(none), Error::NoSuchContact { contact: none }),
        (scene.remove_row(4), row(4)),
        (scene.remove_row(none), row(none)),
        (scene.set_row_jacobian(4, &zeros), row(4)),
        (scene.set_row_compliance(none, 0.0), row(none)),
        (scene.set_row_offset(4, 0.0), row(4)),
        (scene.set_row_law(4, RowLaw::Limit), row(4)),
        (scene.set_row_jacobian(2, &nan), not_finite),
    ] {
        assert_eq!(refused, Err(error));
    }
    for compliance in [-1e-9, f64::NAN, f64::INFINITY] {
        let refused = scene.set_row_compliance(2, compliance);
        assert_eq!(refused, Err(Error::InvalidRowCompliance { row: 2 }));
    }
    assert!(factor.is_current(&scene));
    assert_eq!((scene.contacts().len(), scene.rows()), (C, &*parts.rows));
    // What is replaced by itself leaves the factor as good as it was.
    for (place, row) in parts.rows.iter().enumerate() {
        scene.set_row_jacobian(place, &row.row)?;
        scene.set_row_compliance(place, row.compliance)?;
        assert!(factor.is_current(&scene));
    }
    Ok(())
}

/// Two rows that change at once in the same way, or change places: what one does to the fingerprint the other must not undo.
#[test]
fn changes_of_two_rows_do_not_cancel() -> Result<(), Error> {
    let row = |entry: f64, compliance: f64| JointRow {
        row: vector![entry, 0.5],
        offset: 0.0,
        law: RowLaw::Limit,
        compliance,
        key: 0,
    };
    let mut scene = joints::Scene::<f64>::new();
    scene.set_mass(&SMatrix::identity())?;
    for (entry, compliance) in [(1.0, 0.0), (1.0, 0.25)] {
        scene.push_row(&row(entry, compliance))?;
    }
    let factor = Factor::new(&scene)?;
    let flips: [fn(f64) -> f64; 3] = [|x| -x, |x| 2.0 * x, |x| x + 1.0];
    for flip in flips {
        for entry in 0..2 {
            let mut changed = scene.clone();
            let mut jacobian = row(1.0, 0.0).row;
            jacobian[entry] = flip(jacobian[entry]);
            for place in 0..2 {
                changed.set_row_jacobian(place, &jacobian)?;
                assert!(!factor.is_current(&changed));
            }
        }
    }
    scene.set_row_compliance(0, 0.25)?;
    scene.set_row_compliance(1, 0.0)?; // they have changed places
    assert!(!factor.is_current(&scene));
    Ok(())
}
