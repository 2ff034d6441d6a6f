//! What the helpers of time stepping cannot mean is refused where it comes in, by its name.

use nalgebra::{SVector, vector};
use proptest::prelude::*;
use proptest::sample::select;
use stiction::time_stepping::{
    ClosedLoop, DryFriction, Gap, JointLimit, Motor, Parameter, Restitution, Spring, Suction,
};
use stiction::{Error, JointRow, Real, RowLaw};

/// [`Gap::offset`], by numbers in a row; so the others.
fn gap<T: Real>(distance: T, step: T, recovery: T, reach: T) -> Result<T, Error> {
    let gap = Gap { distance, recovery, reach };
    gap.offset(step)
}

fn restitution<T: Real>(coefficient: T, approach: T, threshold: T, gap_offset: T) -> Result<T, Error> {
    let law = Restitution { coefficient, threshold };
    law.offset(approach, gap_offset)
}

fn compliance<T: Real>(stiffness: T, relaxation: T, step: T) -> Result<T, Error> {
    let spring = Spring { stiffness, relaxation };
    spring.compliance(step)
}

/// Its stiffness does not matter.
fn compliant_gap<T: Real>(distance: T, relaxation: T, step: T, reach: T) -> Result<T, Error> {
    let spring = Spring { stiffness: T::literal(f64::NAN), relaxation };
    let gap = Gap { distance, reach, ..Gap::default() };
    spring.offset(&gap, step)
}

const NAN: f64 = f64::NAN;
const INFINITY: f64 = f64::INFINITY;
/// So small that its reciprocal overflows.
const TINY: f64 = 1e-310;

/// The parameter that a helper refuses.
fn refused<R: std::fmt::Debug>(result: Result<R, Error>) -> Parameter {
    match result {
        Err(Error::InvalidParameter { parameter }) => parameter,
        other => panic!("{other:?}"),
    }
}

/// Hands over four arguments, of which one in turn is a number that has no meaning.
fn each_refused<const K: usize>(
    good: [f64; K],
    helper: impl Fn([f64; K]) -> Result<f64, Error>,
    bad: [(Parameter, &[f64]); K],
) {
    assert!(helper(good).is_ok());
    for (i, (parameter, numbers)) in bad.into_iter().enumerate() {
        for &number in numbers {
            let mut arguments = good;
            arguments[i] = number;
            let named = refused(helper(arguments));
            assert_eq!(named, parameter, "{number} in place {i}");
        }
    }
}

const NOT_FINITE: &[f64] = &[NAN, INFINITY, -INFINITY];
const NOT_POSITIVE: &[f64] = &[NAN, INFINITY, -INFINITY, 0.0, -0.0, -1e-3];
/// Not a distance, which may be infinite.
const NO_DISTANCE: &[f64] = &[NAN, -INFINITY];
const NEGATIVE: &[f64] = &[NAN, INFINITY, -INFINITY, -1e-3];
/// Not a bound, which may be infinite.
const NO_BOUND: &[f64] = &[NAN, -INFINITY, -1e-3];

#[test]
fn a_gap_names_what_it_refuses() {
    for distance in [0.01, 0.0, -0.01] {
        each_refused(
            [distance, 1e-3, 0.1, 10.0],
            |[distance, step, recovery, reach]| gap(distance, step, recovery, reach),
            [
                (Parameter::Gap, NO_DISTANCE),
                (Parameter::Step, NOT_POSITIVE),
                (Parameter::Recovery, NO_BOUND),
                (Parameter::Reach, NO_BOUND),
            ],
        );
    }
    let no_bounds = |distance| gap(distance, 1e-3, INFINITY, INFINITY);
    assert_eq!(no_bounds(-3.0), Ok(-3.0 / 1e-3));
    assert_eq!(refused(no_bounds(1e307)), Parameter::Gap);
    assert_eq!(refused(no_bounds(-1e307)), Parameter::Gap);
    assert_eq!(refused(no_bounds(INFINITY)), Parameter::Gap);
    assert_eq!(gap(INFINITY, 1e-3, 0.1, 10.0), Ok(10.0)); // nothing near
    assert_eq!(gap(1e307, 1e-3, 0.1, 10.0), Ok(10.0)); // far away
    assert_eq!(gap(-1e307, 1e-3, 0.0, 10.0), Ok(0.0));
}

#[test]
fn a_bounce_names_what_it_refuses() {
    each_refused(
        [0.5, -3.0, 0.1, 0.0],
        |[e, approach, threshold, gap]| restitution(e, approach, threshold, gap),
        [
            (Parameter::Restitution, &[NAN, INFINITY, -0.1, 1.1]),
            (Parameter::Approach, NOT_FINITE),
            (Parameter::Threshold, NEGATIVE),
            (Parameter::GapOffset, NOT_FINITE),
        ],
    );
    assert_eq!(restitution(1.0, -1e308, 0.0, -1e308), Ok(-1e308)); // their sum overflows
}

#[test]
fn a_stop_names_what_it_refuses() {
    each_refused(
        [0.01, 1e-3, 0.1, 10.0],
        |[distance, step, recovery, reach]| {
            let stop = JointLimit { distance, recovery, reach };
            stop.row(vector![1.0], step, 0).map(|row| row.offset)
        },
        [
            (Parameter::Distance, NO_DISTANCE),
            (Parameter::Step, NOT_POSITIVE),
            (Parameter::Recovery, NO_BOUND),
            (Parameter::Reach, NO_BOUND),
        ],
    );
    each_refused(
        [0.01, 1e-3, 0.1],
        |[drift, step, recovery]| {
            let closed = ClosedLoop { drift, recovery };
            closed.row(vector![1.0], step, 0).map(|row| row.offset)
        },
        [(Parameter::Drift, NOT_FINITE), (Parameter::Step, NOT_POSITIVE), (Parameter::Recovery, NO_BOUND)],
    );
}

#[test]
fn dry_friction_names_what_it_refuses() {
    each_refused(
        [0.5, 1e-3],
        |[torque, step]| {
            let gear = DryFriction { torque }.row(vector![1.0], step, 0);
            gear.map(|row| row.offset)
        },
        [(Parameter::Torque, NEGATIVE), (Parameter::Step, NOT_POSITIVE)],
    );
    let long = DryFriction { torque: 1e300 }.row(vector![1.0], 1e10, 0);
    assert_eq!(refused(long), Parameter::Torque); // its impulse overflows
}

/// A motor of these gains, feedforward torque and limit.
fn motor([stiffness, damping, feedforward, limit, ahead, target, step]: [f64; 7]) -> Result<f64, Error> {
    let motor = Motor { stiffness, damping, feedforward, limit, ahead, target };
    motor.row(vector![1.0], step, 0).map(|row| row.offset)
}

#[test]
fn a_motor_names_what_it_refuses() {
    each_refused(
        [400.0, 20.0, 1.0, 30.0, 0.1, 2.0, 1e-3],
        motor,
        [
            (Parameter::MotorStiffness, NEGATIVE),
            (Parameter::MotorDamping, NEGATIVE),
            (Parameter::Feedforward, NOT_FINITE),
            (Parameter::TorqueLimit, NO_BOUND),
            (Parameter::Ahead, NOT_FINITE),
            (Parameter::Target, NOT_FINITE),
            (Parameter::Step, NOT_POSITIVE),
        ],
    );
    // One gain may be 0, both may not.
    assert!(motor([0.0, 20.0, 1.0, 30.0, 0.1, 2.0, 1e-3]).is_ok());
    assert!(motor([400.0, 0.0, 1.0, 30.0, 0.1, 2.0, 1e-3]).is_ok());
    for (arguments, parameter) in [
        ([0.0, 0.0, 1.0, 30.0, 0.1, 2.0, 1e-3], Parameter::MotorGains),
        ([TINY, 0.0, 1.0, 30.0, 0.1, 2.0, 1e-3], Parameter::MotorGains),
        ([0.0, 1e-306, 0.0, 30.0, 0.0, 0.0, 1e-3], Parameter::MotorGains), // its compliance
        ([1e300, 1.0, 1.0, 30.0, 0.1, 2.0, 1e10], Parameter::MotorStiffness),
        ([1e308, 1e308, 0.0, 30.0, 0.0, 0.0, 1.0], Parameter::MotorDamping),
        ([400.0, 20.0, 1.0, 1e300, 0.1, 2.0, 1e10], Parameter::TorqueLimit),
        ([400.0, 20.0, 1.0, 30.0, 1e307, 2.0, 1e-3], Parameter::Ahead),
        ([400.0, 20.0, 1.0, 30.0, 0.1, 1e307, 1e-3], Parameter::Target),
        ([1e-2, 1e-2, 1e307, 30.0, 0.0, 0.0, 1e-3], Parameter::Feedforward),
        ([400.0, 20.0, 1.0, 30.0, 0.1, 2.0, TINY], Parameter::Step),
    ] {
        assert_eq!(refused(motor(arguments)), parameter, "{arguments:?}");
    }
}

#[test]
fn a_motor_has_no_limit_unless_it_is_given_one() -> Result<(), Error> {
    let motor = Motor { stiffness: 400.0, damping: 20.0, ..Motor::default() };
    assert_eq!(motor.row(vector![1.0], 1e-3, 0)?.law, RowLaw::Equality);
    Ok(())
}

#[test]
fn compliance_names_what_it_refuses() {
    each_refused(
        [5e3, 5e-3, 1e-3],
        |[stiffness, relaxation, step]| compliance(stiffness, relaxation, step),
        [
            (Parameter::Stiffness, &[NAN, -INFINITY, -1.0, 0.0, TINY]),
            (Parameter::Relaxation, NEGATIVE),
            (Parameter::Step, NOT_POSITIVE),
        ],
    );
    assert_eq!(compliance(INFINITY, 0.0, 1e-3), Ok(0.0)); // rigid
    assert_eq!(refused(compliance(INFINITY, 0.0, 1e-200)), Parameter::Step); // its square is 0
    assert_eq!(refused(compliance(1.0, 0.0, 1e200)), Parameter::Step);
    assert_eq!(refused(compliance(1.0, 1e308, 1e308)), Parameter::Relaxation);
    each_refused(
        [-0.01, 5e-3, 1e-3, 10.0],
        |[gap, relaxation, step, reach]| compliant_gap(gap, relaxation, step, reach),
        [
            (Parameter::Gap, &[NAN, -INFINITY, -1e307]),
            (Parameter::Relaxation, NEGATIVE),
            (Parameter::Step, NOT_POSITIVE),
            (Parameter::Reach, NO_BOUND),
        ],
    );
    assert_eq!(compliant_gap(3.0, 0.0, 0.5, INFINITY), Ok(6.0));
    // A gap and a reach that are none are to blame before times that are too long together.
    for (gap, reach, culprit) in
        [(NAN, 10.0, Parameter::Gap), (-0.01, NAN, Parameter::Reach), (-0.01, 10.0, Parameter::Relaxation)]
    {
        assert_eq!(refused(compliant_gap(gap, 1e308, 1e308, reach)), culprit);
    }
}

#[test]
fn suction_names_what_it_refuses() {
    let cup = |force| Suction { force, touches: true };
    let up = vector![1.0].transpose();
    let push_back = |[force, step]: [f64; 2]| {
        let mut push = vector![0.0];
        cup(force).push_back(&up, step, &mut push)?;
        Ok(push[0])
    };
    let impulse = |[force, step]: [f64; 2]| {
        let impulse = cup(force).impulse(&vector![1.0, 2.0], step)?;
        Ok(impulse[0])
    };
    let bad = [(Parameter::Suction, NEGATIVE), (Parameter::Step, NOT_POSITIVE)];
    each_refused([16.0, 0.5], push_back, bad);
    each_refused([16.0, 0.5], impulse, bad);
    assert_eq!(push_back([16.0, 0.5]), Ok(-8.0));
    assert_eq!(impulse([16.0, 0.5]), Ok(-7.0));
    assert_eq!(refused(push_back([1e300, 1e10])), Parameter::Suction); // their product overflows
    // What is refused leaves the impulse as it was.
    let mut push = vector![3.0];
    assert!(cup(NAN).push_back(&up, 0.5, &mut push).is_err());
    assert_eq!(push, vector![3.0]);
}

#[test]
fn the_error_says_what_is_asked_of_the_parameter() {
    let error = gap(0.01, -1e-3, 0.1, 10.0).unwrap_err();
    let text = "step is not a positive number that can be divided by";
    assert_eq!(error.to_string(), text);
}

/// What is Ok is finite, of the sign it should have, and within its bounds.
fn finite_or_refused<T: Real>([a, b, c, d, e, f, g]: [T; 7]) {
    let row: SVector<T, 1> = SVector::from([T::ONE]);
    let motor = Motor { stiffness: a, damping: b, feedforward: c, limit: d, ahead: e, target: f };
    let stop = JointLimit { distance: a, recovery: c, reach: d };
    let closed = ClosedLoop { drift: a, recovery: c };
    if let Ok(offset) = gap(a, b, c, d) {
        assert!(offset.is_finite() && -c <= offset && offset <= d);
    }
    if let Ok(offset) = restitution(a, b, c, d) {
        assert!(offset.is_finite() && offset <= d);
    }
    if let Ok(offset) = compliant_gap(a, b, c, d) {
        assert!(offset.is_finite() && offset <= d);
    }
    if let Ok(compliance) = compliance(a, b, c) {
        assert!(compliance.is_finite() && compliance >= T::ZERO);
    }
    let rows: [Result<JointRow<T, 1>, Error>; 4] = [
        stop.row(row, b, 0),
        DryFriction { torque: a }.row(row, b, 0),
        motor.row(row, g, 0),
        closed.row(row, b, 0),
    ];
    for row in rows.into_iter().flatten() {
        assert!(row.offset.is_finite());
        assert!(row.compliance.is_finite() && row.compliance >= T::ZERO);
        if let RowLaw::Box { lower, upper } = row.law {
            assert!(upper.is_finite() && lower == -upper && upper >= T::ZERO);
        }
    }
}

/// Bits of any kind, numbers of use, and those at the ends of both number types.
fn number() -> impl Strategy<Value = f64> {
    let ends = [0.0, 1e-323, 1e-310, 1e-200, 1e-45, 1e-39, 1e38, 1e200, 1.7e308, INFINITY];
    let ends = select(ends.to_vec());
    prop_oneof![
        2 => proptest::num::f64::ANY,
        4 => 0.0..10.0_f64,
        1 => -10.0..0.0_f64,
        2 => ends,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]

    #[test]
    fn any_arguments_are_refused_or_give_finite_numbers(numbers in proptest::array::uniform7(number())) {
        finite_or_refused::<f64>(numbers);
        finite_or_refused::<f32>(numbers.map(Real::literal));
    }
}
