//! The same scene told differently has the same solution: order, axes and units do not matter.

use crate::support::boxes::{BRICK, BoxScene};
use crate::support::random::{Case, draws, scenes};
use nalgebra::{Rotation2, SMatrix, SVector};
use proptest::array::uniform6;
use proptest::prelude::*;
use stiction::{Contact, Error, Real, Scene, Settings, Solution, Status};
use testbed::measure::{Law, error_of};
use testbed::method::Method;

const TOLERANCE: f64 = 1e-10;

/// The scene with other contacts.
fn with_contacts<T: Real, const N: usize, const D: usize, const C: usize>(
    scene: &Scene<T, N, D, C>,
    contacts: impl Iterator<Item = Contact<T, N, D>>,
) -> Result<Scene<T, N, D, C>, Error> {
    let mut other = Scene::new();
    other.set_mass(scene.mass())?;
    for contact in contacts {
        other.push(&contact)?;
    }
    Ok(other)
}

/// The contacts in reverse.
fn reversed<const N: usize, const D: usize, const C: usize>(
    scene: &Scene<f64, N, D, C>,
) -> Result<Scene<f64, N, D, C>, Error> {
    with_contacts(scene, scene.contacts().iter().rev().cloned())
}

/// Turns the tangents of a contact vector, or of each column of a Jacobian.
fn turn<const K: usize>(x: &SMatrix<f64, 3, K>, angle: f64) -> SMatrix<f64, 3, K> {
    let mut turned = *x;
    let tangents = Rotation2::new(angle) * x.fixed_rows::<2>(1);
    turned.fixed_rows_mut::<2>(1).copy_from(&tangents);
    turned
}

/// Each contact with its own tangents, contact `i` turned by `angle + i`.
fn turned<const N: usize, const C: usize>(
    scene: &Scene<f64, N, 3, C>,
    angle: f64,
) -> Result<Scene<f64, N, 3, C>, Error> {
    let contacts = scene.contacts().iter().zip(0_u8..);
    let contacts = contacts.map(|(contact, i)| Contact {
        jacobian: turn(&contact.jacobian, angle + f64::from(i)),
        offset: turn(&contact.offset, angle + f64::from(i)),
        mu: contact.mu,
        key: contact.key,
    });
    with_contacts(scene, contacts)
}

/// Binary exponents of the units: mass, velocity at the contacts, and of each dof its own.
#[derive(Clone, Copy, Debug)]
struct Units<const N: usize> {
    mass: i32,
    velocity: i32,
    dofs: [i32; N],
}

fn two<T: Real>(exponent: i32) -> T {
    T::literal(2_f64.powi(exponent))
}

impl<const N: usize> Units<N> {
    /// `M_jk 2^(m + s_j + s_k)`, `H_ij 2^s_j`, `w 2^b`, `f_j 2^(m + s_j + b)`.
    fn scene<T: Real, const D: usize, const C: usize>(
        &self,
        scene: &Scene<T, N, D, C>,
        push: &SVector<T, N>,
    ) -> Result<(Scene<T, N, D, C>, SVector<T, N>), Error> {
        let Self { mass: m, velocity: b, dofs: s } = *self;
        let mut other = Scene::new();
        let mass = scene.mass();
        other.set_mass(&SMatrix::from_fn(|j, k| mass[(j, k)] * two(m + s[j] + s[k])))?;
        for contact in scene.contacts() {
            other.push(&Contact {
                jacobian: SMatrix::from_fn(|i, j| contact.jacobian[(i, j)] * two(s[j])),
                offset: contact.offset * two::<T>(b),
                mu: contact.mu,
                key: contact.key,
            })?;
        }
        Ok((other, SVector::from_fn(|j, _| push[j] * two(m + s[j] + b))))
    }

    /// `v_j 2^(b - s_j)`
    fn velocity<T: Real>(&self, v: &SVector<T, N>) -> SVector<T, N> {
        SVector::from_fn(|j, _| v[j] * two(self.velocity - self.dofs[j]))
    }
}

/// Status, counts and every mantissa are those of the scene in other units, by every method.
fn is_independent_of<T: Real, const N: usize, const D: usize, const C: usize>(
    units: &Units<N>,
    scene: &Scene<T, N, D, C>,
    push: &SVector<T, N>,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let settings = Settings::new(T::literal(tolerance));
    let (other, other_f) = units.scene(scene, push)?;
    let counts = |solution: &Solution<T, N, D, C>| (solution.status, solution.work);
    for method in Method::ALL {
        let ours = method.solve(scene, push, &settings)?;
        let theirs = method.solve(&other, &other_f, &settings)?;
        prop_assert_eq!(counts(&ours), counts(&theirs), "{:?}", method);
        prop_assert_eq!(units.velocity(&ours.velocity), theirs.velocity, "{:?}", method);
        for (ours, theirs) in ours.contacts.iter().zip(&theirs.contacts) {
            let impulse = ours.impulse * two::<T>(units.mass + units.velocity);
            prop_assert_eq!(impulse, theirs.impulse);
            prop_assert_eq!(ours.velocity * two::<T>(units.velocity), theirs.velocity);
            prop_assert_eq!(ours.mode, theirs.mode);
        }
        if units.dofs == [units.dofs[0]; N] {
            prop_assert_eq!(ours.error, theirs.error);
        }
    }
    Ok(())
}

/// A box that slides and spins down a slope.
fn sliding<T: Real>() -> Result<(BoxScene<T>, SVector<T, 6>), Error> {
    let velocity = SVector::<f64, 6>::from([0.3, 0.1, 0.0, 0.0, 0.0, 2.0]);
    let push = BRICK.free_impulse::<f64>(0.4, 0.01) + BRICK.mass_matrix() * velocity;
    Ok((BRICK.on_plane(0.3)?, push.map(T::literal)))
}

/// Is the velocity the same, and for an isostatic scene the impulses after `back`? Both are solutions in any case.
fn agrees<const N: usize, const C: usize>(
    (scene, push): &Case<N, 3, C>,
    other: &Scene<f64, N, 3, C>,
    back: impl Fn(&Solution<f64, N, 3, C>) -> Vec<SVector<f64, 3>>,
) -> Result<bool, Error> {
    let settings = Settings { budget: 20_000, ..Settings::new(TOLERANCE) };
    let mut agrees = true;
    for method in [Method::Restart, Method::Default] {
        let ours = method.solve(scene, push, &settings)?;
        let theirs = method.solve(other, push, &settings)?;
        for (scene, solution) in [(scene, &ours), (other, &theirs)] {
            assert_eq!(solution.status, Status::Solved, "{method:?}");
            assert!(error_of(scene, push, solution, Law::Coulomb) <= TOLERANCE);
        }
        let size = ours.velocity.norm().max(1e-3);
        agrees &= (ours.velocity - theirs.velocity).norm() <= 1e-6 * size;
        if 3 * scene.contacts().len() <= N {
            let size = impulses(&ours).map(|impulse| impulse.norm()).sum::<f64>();
            for (ours, theirs) in impulses(&ours).zip(back(&theirs)) {
                agrees &= (ours - theirs).norm() <= 1e-6 * size.max(1e-3);
            }
        }
    }
    Ok(agrees)
}

fn impulses<const N: usize, const C: usize>(
    solution: &Solution<f64, N, 3, C>,
) -> impl DoubleEndedIterator<Item = SVector<f64, 3>> {
    solution.contacts.iter().map(|contact| contact.impulse)
}

fn turned_back<const N: usize, const C: usize>(
    solution: &Solution<f64, N, 3, C>,
    angle: f64,
) -> Vec<SVector<f64, 3>> {
    let contacts = impulses(solution).zip(0_u8..);
    contacts.map(|(impulse, i)| turn(&impulse, -angle - f64::from(i))).collect()
}

/// Coulomb's law can have several solutions, and the order or the axes may lead to another: to two in a thousand here.
#[test]
fn neither_the_order_of_the_contacts_nor_the_axes_of_the_tangents_matter() -> Result<(), Error> {
    let (mut order, mut axes) = (0, 0);
    for (case, angle) in draws((scenes::<18, 3, 12>(3, 1.0), 0.0..6.3), 1_000) {
        let reverse = |solution: &Solution<f64, 18, 3, 12>| impulses(solution).rev().collect();
        let turn = |solution: &Solution<f64, 18, 3, 12>| turned_back(solution, angle);
        order += usize::from(agrees(&case, &reversed(&case.0)?, reverse)?);
        axes += usize::from(agrees(&case, &turned(&case.0, angle)?, turn)?);
    }
    assert!(order >= 998 && axes >= 998, "{order}, {axes} of 1,000");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// It must not spin: the friction of a spinning box depends on how the corners share its weight,
    /// which four normals leave open, so that its velocity is not unique.
    #[test]
    fn a_hyperstatic_box_slides_alike_in_any_order_and_axes(angle in 0.0..6.3) {
        let case = (BRICK.on_plane(0.3)?, BRICK.free_impulse(0.4, 0.01));
        let reverse = |solution: &Solution<f64, 6, 3, 4>| impulses(solution).rev().collect();
        prop_assert!(agrees(&case, &reversed(&case.0)?, reverse)?);
        let turn = |solution: &Solution<f64, 6, 3, 4>| turned_back(solution, angle);
        prop_assert!(agrees(&case, &turned(&case.0, angle)?, turn)?);
    }

    #[test]
    fn units_of_mass_length_and_time_change_exponents_only(
        mass in -12..12, velocity in -12..12, dofs in -5..5,
        (scene, push) in scenes::<6, 3, 4>(3, 1.0),
    ) {
        let units = Units { mass, velocity, dofs: [dofs; 6] };
        is_independent_of(&units, &scene, &push, 1e-6)?;
        let (scene, push) = sliding::<f64>()?;
        is_independent_of(&units, &scene, &push, 1e-8)?;
        let (scene, push) = sliding::<f32>()?;
        is_independent_of(&units, &scene, &push, 1e-3)?;
    }

    #[test]
    fn the_unit_of_each_dof_changes_exponents_only(
        dofs in uniform6(-5..5),
        (scene, push) in scenes::<6, 3, 4>(3, 1.0),
    ) {
        let units = Units { mass: 0, velocity: 0, dofs };
        is_independent_of(&units, &scene, &push, 1e-6)?;
        let (scene, push) = sliding::<f64>()?;
        is_independent_of(&units, &scene, &push, 1e-8)?;
        let (scene, push) = sliding::<f32>()?;
        is_independent_of(&units, &scene, &push, 1e-3)?;
    }
}
