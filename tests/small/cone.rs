//! Statements about `K`, `K*` and the projections onto them, in 1 to 4 dimensions, f32 and f64.

use nalgebra::{SVector, Vector1, vector};
use proptest::array::uniform4;
use proptest::prelude::*;
use stiction::{FrictionCone, Real};

type Property = Result<(), TestCaseError>;

/// `property::<T, D>(arguments…)?` for both number types and every dimension.
macro_rules! everywhere {
    ($property:ident($($argument:expr),*)) => {
        everywhere!(f32, $property($($argument),*));
        everywhere!(f64, $property($($argument),*));
    };
    ($t:ty, $property:ident($($argument:expr),*)) => {
        $property::<$t, 1>($($argument),*)?;
        $property::<$t, 2>($($argument),*)?;
        $property::<$t, 3>($($argument),*)?;
        $property::<$t, 4>($($argument),*)?;
    };
}

/// ±10^[-12, 12], or 0.
fn entry() -> impl Strategy<Value = f64> {
    let magnitude = (-12.0..12.0).prop_map(|exponent: f64| 10_f64.powf(exponent));
    let signed = (magnitude, any::<bool>()).prop_map(|(x, minus)| if minus { -x } else { x });
    prop_oneof![1 => Just(0.0), 9 => signed]
}

/// Entries of any magnitude each, or all of one magnitude.
fn point() -> impl Strategy<Value = [f64; 4]> {
    let alike = (uniform4(-1.0..1.0), entry()).prop_map(|(x, scale)| x.map(|x| x * scale));
    prop_oneof![uniform4(entry()), alike]
}

/// 0, or 10^[-6, 1].
fn friction() -> impl Strategy<Value = f64> {
    let magnitude = (-6.0..1.0).prop_map(|exponent: f64| 10_f64.powf(exponent));
    prop_oneof![1 => Just(0.0), 5 => magnitude]
}

fn cone<T: Real>(mu: f64) -> FrictionCone<T> {
    FrictionCone::new(T::literal(mu)).expect("mu is valid")
}

/// `K_mu` and its dual.
fn both<T: Real>(mu: f64) -> [FrictionCone<T>; 2] {
    [cone(mu), cone(mu).dual()]
}

fn vector<T: Real, const D: usize>(x: [f64; 4]) -> SVector<T, D> {
    SVector::from_fn(|i, _| T::literal(x[i]))
}

/// Sixteen roundings of a number of this size.
fn rounding<T: Real>(size: T) -> T {
    T::literal(16.0) * T::EPSILON * size
}

/// How far `x` is out of `K_mu` and of `K*_mu`, from their definitions and in f64; negative inside.
fn depth<T: Real, const D: usize>(mu: f64, x: &SVector<T, D>) -> [f64; 2] {
    let mu: f64 = T::literal(mu).to_subset().expect("mu is a number");
    let x = x.map(|x| x.to_subset().expect("x is a number"));
    let length = x.iter().skip(1).fold(0.0_f64, |sum, x| sum.hypot(*x));
    [length - mu * x[0], mu * length - x[0]].map(|out| (out / mu.hypot(1.0)).max(-x[0]))
}

/// [`depth`], 0 inside.
fn outside<T: Real, const D: usize>(mu: f64, x: &SVector<T, D>) -> [f64; 2] {
    depth(mu, x).map(|depth| depth.max(0.0))
}

fn is_membership<T: Real, const D: usize>(mu: f64, x: [f64; 4]) -> Property {
    let x = vector::<T, D>(x);
    let slack: f64 = rounding(x.norm()).to_subset().expect("a number");
    for (cone, depth) in both::<T>(mu).into_iter().zip(depth(mu, &x)) {
        if cone.contains(&x) {
            prop_assert!(depth <= slack);
            prop_assert_eq!(cone.project(&x), x);
        } else {
            prop_assert!(depth >= -slack);
            prop_assert!(cone.project(&x) != x || depth <= slack);
        }
    }
    Ok(())
}

fn is_idempotent<T: Real, const D: usize>(mu: f64, x: [f64; 4]) -> Property {
    for cone in both::<T>(mu) {
        let once = cone.project(&vector::<T, D>(x));
        let twice = cone.project(&once);
        prop_assert!((twice - once).norm() <= rounding(once.norm()), "{once} {twice}");
    }
    Ok(())
}

fn is_nonexpansive<T: Real, const D: usize>(mu: f64, x: [f64; 4], y: [f64; 4]) -> Property {
    let (x, y) = (vector::<T, D>(x), vector::<T, D>(y));
    for cone in both::<T>(mu) {
        let distance = (cone.project(&x) - cone.project(&y)).norm();
        prop_assert!(distance <= (x - y).norm() + rounding(x.norm().max(y.norm())));
    }
    Ok(())
}

/// `x = Π_K(x) - Π_{K*}(-x)`, the two orthogonal; and the same with `K` and `K*` exchanged.
fn is_moreau<T: Real, const D: usize>(mu: f64, x: [f64; 4]) -> Property {
    let x = vector::<T, D>(x);
    for cone in both::<T>(mu) {
        let (inside, polar) = (cone.project(&x), cone.dual().project(&-x));
        prop_assert!((inside - polar - x).norm() <= rounding(x.norm()));
        prop_assert!(inside.dot(&polar).abs() <= rounding(x.norm_squared()));
    }
    Ok(())
}

/// `p = Π(x)` minimises (6): `p` in the cone, `p - x` in its dual, the two orthogonal.
fn is_nearest<T: Real, const D: usize>(mu: f64, x: [f64; 4]) -> Property {
    let x = vector::<T, D>(x);
    let slack: f64 = rounding(x.norm()).to_subset().expect("a number");
    for (which, cone) in both::<T>(mu).into_iter().enumerate() {
        let p = cone.project(&x);
        prop_assert!(outside(mu, &p)[which] <= slack);
        prop_assert!(outside(mu, &(p - x))[1 - which] <= slack);
        prop_assert!(p.dot(&(p - x)).abs() <= rounding(x.norm_squared()));
    }
    Ok(())
}

/// Spectral values and vectors of `x` for `K` and `K*`, Eqs. (3)-(5).
///
/// The values are the note's `lambda_1` and `lambda_2` multiplied by `mu` and 1 (for `K*`: by 1 and `mu`), the vectors
/// divided by the same, so that signs, products and Eq. (7) are the note's and `mu = 0` needs no case of its own.
fn spectral<T: Real, const D: usize>(mu: f64, x: &SVector<T, D>) -> [([T; 2], [SVector<T, D>; 2]); 2] {
    let mu = T::literal(mu);
    let mut direction = *x;
    direction[0] = T::ZERO;
    let length = direction.norm();
    if length > T::ZERO {
        direction /= length;
    } else if D > 1 {
        direction[1] = T::ONE; // any direction does
    }
    [(T::ONE, mu), (mu, T::ONE)].map(|(axial, radial)| {
        let vector = |axial: T, radial: T| {
            let mut vector = direction * radial;
            vector[0] = axial;
            vector / (T::ONE + mu * mu)
        };
        let values = [radial * x[0] - axial * length, axial * x[0] + radial * length];
        (values, [vector(radial, -axial), vector(axial, radial)])
    })
}

/// Eq. (3), orthogonality of the two vectors, and the second one on the boundary of the cone.
fn is_factorisation<T: Real, const D: usize>(mu: f64, x: [f64; 4]) -> Property {
    let x = vector::<T, D>(x);
    for (which, (values, [first, second])) in spectral(mu, &x).into_iter().enumerate() {
        prop_assert!((first * values[0] + second * values[1] - x).norm() <= rounding(x.norm()));
        if D > 1 {
            prop_assert!(first.dot(&second).abs() <= rounding(T::ONE));
            let eps: f64 = T::EPSILON.to_subset().expect("a number");
            prop_assert!(outside(mu, &second)[which] <= eps);
        }
    }
    Ok(())
}

/// Eq. (7) and the case forms (8), (10) are one projection.
fn is_one_projection<T: Real, const D: usize>(mu: f64, x: [f64; 4]) -> Property {
    let x = vector::<T, D>(x);
    for (cone, (values, [first, second])) in both::<T>(mu).into_iter().zip(spectral(mu, &x)) {
        let [one, other] = values.map(|value| value.max(T::ZERO));
        let difference = first * one + second * other - cone.project(&x);
        prop_assert!(difference.norm() <= rounding(x.norm()));
    }
    Ok(())
}

/// `K_0` is the ray along the normal, `K*_0` the half-space of all `x1 >= 0`.
fn is_exact_without_friction<T: Real, const D: usize>(x: [f64; 4]) -> Property {
    let x = vector::<T, D>(x);
    let [ray, half_space] = both::<T>(0.0).map(|cone| cone.project(&x));
    let height = x[0].max(T::ZERO);
    let mut expected = x;
    expected[0] = height;
    prop_assert_eq!(half_space, expected);
    expected.fill(T::ZERO);
    expected[0] = height;
    prop_assert_eq!(ray, expected);
    Ok(())
}

/// Beside a normal of 1e12 the square of a tangent vanishes that is not zero.
#[test]
fn a_ray_has_no_tangent_however_small() -> Property {
    for mu in [0.0, 0.5] {
        everywhere!(is_membership(mu, [6.9e11, 2.2e-12, 0.0, 0.0]));
    }
    everywhere!(is_exact_without_friction([6.9e11, 2.2e-12, 0.0, 0.0]));
    everywhere!(f64, is_exact_without_friction([1e140, 0.0, 1e-150, 0.0]));
    everywhere!(is_exact_without_friction([-4.4e11, 0.0, 5.9e-12, 0.0]));
    Ok(())
}

proptest! {
    #[test]
    fn a_cone_contains_what_its_definition_says(mu in friction(), x in point()) {
        everywhere!(is_membership(mu, x));
    }

    #[test]
    fn projection_is_idempotent(mu in friction(), x in point()) {
        everywhere!(is_idempotent(mu, x));
    }

    #[test]
    fn projection_is_nonexpansive(mu in friction(), x in point(), y in point()) {
        everywhere!(is_nonexpansive(mu, x, y));
    }

    #[test]
    fn a_vector_is_the_sum_of_its_projections_onto_cone_and_polar(mu in friction(), x in point()) {
        everywhere!(is_moreau(mu, x));
    }

    #[test]
    fn the_projection_is_the_nearest_point(mu in friction(), x in point()) {
        everywhere!(is_nearest(mu, x));
    }

    #[test]
    fn the_spectral_factorisation_reproduces_the_vector(mu in friction(), x in point()) {
        everywhere!(is_factorisation(mu, x));
    }

    #[test]
    fn spectral_and_case_form_are_one_projection(mu in friction(), x in point()) {
        everywhere!(is_one_projection(mu, x));
    }

    #[test]
    fn projection_without_friction_is_exact(x in point()) {
        everywhere!(is_exact_without_friction(x));
    }

    /// Eqs. (4), (5): `values` are the note's times `(mu, 1)`, for `K*` its `lambda*` times `(1, mu)`.
    #[test]
    fn spectral_values_are_those_of_the_note(mu in 1e-6..10.0, x in point()) {
        let x = vector::<f64, 3>(x);
        let length = x.y.hypot(x.z);
        let slack = rounding(x.norm()) * (1.0 + mu);
        let [(primal, vectors), (dual, _)] = spectral(mu, &x);
        let note = [x.x - length / mu, x.x + length * mu];
        prop_assert!((primal[0] - mu * note[0]).abs() <= slack);
        prop_assert!((primal[1] - note[1]).abs() <= slack);
        let note_dual = [x.x - length * mu, x.x + length / mu];
        prop_assert!((dual[0] - note_dual[0]).abs() <= slack);
        prop_assert!((dual[1] - mu * note_dual[1]).abs() <= slack);
        if length > 0.0 {
            let direction = vector![0.0, x.y, x.z] / length;
            let normal = vector![1.0, 0.0, 0.0];
            let first = (normal * mu * mu - direction * mu) / (1.0 + mu * mu);
            let second = (normal + direction * mu) / (1.0 + mu * mu);
            prop_assert!((vectors[0] * mu - first).norm() <= rounding(1.0));
            prop_assert!((vectors[1] - second).norm() <= rounding(1.0));
        }
    }

    #[test]
    fn the_dual_of_the_dual_is_the_cone(mu in friction()) {
        prop_assert_eq!(cone::<f64>(mu).dual().dual(), cone(mu));
        prop_assert_eq!(cone::<f32>(mu).dual().dual(), cone(mu));
    }
}

#[test]
fn only_a_friction_coefficient_makes_a_cone() {
    for mu in [-1.0, -f64::MIN_POSITIVE, f64::NAN, f64::INFINITY, -f64::INFINITY, 1e200] {
        assert_eq!(FrictionCone::new(mu), None, "{mu}");
    }
    assert_eq!(FrictionCone::new(1e20_f32), None);
    assert_eq!(FrictionCone::new(0.0), Some(FrictionCone::<f64>::frictionless()));
    assert!(FrictionCone::new(-0.0_f64).is_some());
}

#[test]
fn the_apex_belongs_to_every_cone_whatever_its_sign() {
    for cone in [0.0, 0.5, 10.0].into_iter().flat_map(both::<f64>) {
        for apex in [vector![0.0, 0.0, 0.0], vector![-0.0, 0.0, 0.0], vector![-0.0, -0.0, -0.0]] {
            assert!(cone.contains(&apex));
            assert_eq!(cone.project(&apex), apex);
        }
    }
}

#[test]
fn on_the_axis_only_the_sign_counts() {
    for cone in [0.0, 0.5, 10.0].into_iter().flat_map(both::<f64>) {
        assert_eq!(cone.project(&vector![2.0, 0.0, 0.0]), vector![2.0, 0.0, 0.0]);
        assert_eq!(cone.project(&vector![-2.0, 0.0, 0.0]), vector![0.0, 0.0, 0.0]);
        assert!(!cone.contains(&vector![-2.0, 0.0, 0.0]));
        assert_eq!(cone.project(&Vector1::new(-3.0)), Vector1::new(0.0));
        assert_eq!(cone.project(&Vector1::new(3.0)), Vector1::new(3.0));
    }
}

/// Whatever the units, a frictionless contact with the least tangential velocity is one.
#[test]
fn a_tiny_tangential_part_does_not_break_a_large_normal_one() {
    let ray = FrictionCone::<f32>::frictionless();
    assert_eq!(ray.project(&vector![1.0, 1e-40]), vector![1.0, 0.0]);
    let ray = FrictionCone::<f64>::frictionless();
    assert_eq!(ray.project(&vector![1.0, 1e-310]), vector![1.0, 0.0]);
}

/// Squares of small numbers vanish, and those of large ones have no number.
#[test]
fn no_square_hides_a_tangent() {
    let cone = FrictionCone::<f32>::new(0.5).expect("a coefficient");
    assert!(!cone.contains(&vector![0.0, 1e-23, 0.0]));
    assert!(!cone.contains(&vector![1e-23, 1e-23, 0.0]));
    assert!(cone.contains(&vector![3e-23, 1e-23, 1e-23]));
    for unit in [1e-30_f32, 1e-23, 1.0, 1e20, 1e30] {
        let projection = cone.project(&(vector![0.0, 3.0, 4.0] * unit));
        let wanted = vector![2.0, 0.6, 0.8] * unit;
        assert!((projection - wanted).amax() <= 1e-6 * unit, "{unit:e}");
        assert!(cone.contains(&(vector![2.1, 0.6, 0.8] * unit)));
        assert!(!cone.contains(&(vector![1.9, 0.6, 0.8] * unit)));
    }
}
