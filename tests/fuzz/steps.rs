//! What a sequence of calls is made of, with numbers mild and wild.

use proptest::collection::vec;
use proptest::prelude::*;

/// One call. Numbers are taken in order, and from the front again where more are needed.
#[derive(Clone, Debug)]
pub(super) enum Step {
    /// `M = R Rᵀ + I / 100 |R|²`, or `R` itself, its upper triangle mirrored.
    Mass(Vec<f64>, bool),
    /// So many velocities, and a mass matrix of them.
    Velocities(usize, Vec<f64>),
    /// A contact: Jacobian, offset, friction; key.
    Push(Vec<f64>, f64, u32),
    /// A contact with a surface: two frictions, spin, two rolls, two compliances.
    PushOn(Vec<f64>, Vec<f64>, u32),
    /// A joint row: row, offset; law; compliance; key.
    PushRow(Vec<f64>, Law, f64, u32),
    Jacobian(usize, Vec<f64>),
    Offset(usize, Vec<f64>),
    Friction(usize, f64),
    RowLaw(usize, Law),
    RowOffset(usize, f64),
    RowJacobian(usize, Vec<f64>),
    RowCompliance(usize, f64),
    /// The first one with this key, if there is one.
    RemoveContact(u32),
    RemoveRow(u32),
    Clear,
    ClearContacts,
    ClearRows,
    Reset,
    /// Of contacts, and of joint rows.
    Impulses(Vec<(u32, f64)>, Vec<(u32, f64)>),
    Solve(Vec<f64>, Budget),
    Resume(Vec<f64>, Budget),
}

/// 0 a limit, 1 an equality, else a box.
pub(super) type Law = (u8, f64, f64);

#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    pub(super) work: usize,
    pub(super) tolerance: f64,
    pub(super) relaxed: bool,
}

fn mild() -> impl Strategy<Value = f64> {
    prop_oneof![6 => -2.0..2.0, 1 => Just(0.0), 1 => Just(1.0), 1 => Just(-1.0)]
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        proptest::num::f64::ANY,
        proptest::num::f32::ANY.prop_map(f64::from),
        (-1.0..1.0, -320..308).prop_map(|(x, power): (f64, i32)| x * 10_f64.powi(power)),
    ]
}

fn wild() -> impl Strategy<Value = f64> {
    prop_oneof![3 => mild(), 1 => any_number()]
}

/// Some numbers, mostly of one size.
fn numbers() -> impl Strategy<Value = Vec<f64>> {
    let some = || vec(mild(), 25);
    let scaled = |(numbers, power): (Vec<f64>, i32)| {
        let scale = 10_f64.powi(power);
        numbers.into_iter().map(|x| x * scale).collect::<Vec<_>>()
    };
    let with_one = |(mut numbers, place, x): (Vec<f64>, usize, f64)| {
        numbers[place] = x;
        numbers
    };
    prop_oneof![
        24 => some(),
        3 => (some(), -6..6).prop_map(scaled),
        1 => (some(), -44..38).prop_map(scaled),
        1 => (some(), -320..308).prop_map(scaled),
        2 => (some(), 0..25_usize, any_number()).prop_map(with_one),
        1 => vec(wild(), 25),
    ]
}

/// Not negative, mostly.
fn friction() -> impl Strategy<Value = f64> {
    prop_oneof![8 => 0.0..1.5, 1 => Just(0.0), 1 => 0.0..1e3, 1 => any_number()]
}

fn compliance() -> impl Strategy<Value = f64> {
    prop_oneof![8 => Just(0.0), 3 => 0.0..1.0, 1 => any_number()]
}

fn law() -> impl Strategy<Value = Law> {
    let bounds = prop_oneof![
        6 => (-1.0..0.0, 0.0..1.0),
        1 => Just((0.0, 0.0)),
        1 => (any_number(), any_number()),
    ];
    (0..3_u8, bounds).prop_map(|(law, (lower, upper))| (law, lower, upper))
}

fn key() -> impl Strategy<Value = u32> {
    prop_oneof![0..4_u32, Just(u32::MAX)]
}

fn budget() -> impl Strategy<Value = Budget> {
    let budgets = prop_oneof![6 => Just(2_000_usize), 1 => Just(0), 1 => Just(1), 3 => 2..60_usize];
    let tolerances = prop_oneof![
        6 => Just(1e-9), 6 => Just(1e-4), 1 => Just(0.0), 1 => Just(1e-14), 1 => Just(1e-300), 1 => Just(0.5),
        1 => any_number()
    ];
    let relaxed = prop::bool::weighted(0.2);
    (budgets, tolerances, relaxed).prop_map(|(work, tolerance, relaxed)| Budget { work, tolerance, relaxed })
}

fn surface() -> impl Strategy<Value = Vec<f64>> {
    (vec(friction(), 5), vec(compliance(), 2)).prop_map(|(mut surface, compliance)| {
        surface.extend(compliance);
        surface
    })
}

fn step() -> impl Strategy<Value = Step> {
    let place = || 0..5_usize;
    let impulses = || vec((key(), wild()), 0..5);
    prop_oneof![
        1 => (numbers(), prop::bool::weighted(0.2)).prop_map(|(root, raw)| Step::Mass(root, raw)),
        1 => (0..12_usize, numbers()).prop_map(|(n, root)| Step::Velocities(n, root)),
        4 => (numbers(), friction(), key()).prop_map(|(x, mu, key)| Step::Push(x, mu, key)),
        3 => (numbers(), surface(), key()).prop_map(|(x, mu, key)| Step::PushOn(x, mu, key)),
        4 => (numbers(), law(), compliance(), key())
            .prop_map(|(x, law, soft, key)| Step::PushRow(x, law, soft, key)),
        1 => (place(), numbers()).prop_map(|(i, x)| Step::Jacobian(i, x)),
        1 => (place(), numbers()).prop_map(|(i, x)| Step::Offset(i, x)),
        1 => (place(), friction()).prop_map(|(i, mu)| Step::Friction(i, mu)),
        1 => (place(), law()).prop_map(|(i, law)| Step::RowLaw(i, law)),
        1 => (place(), wild()).prop_map(|(i, x)| Step::RowOffset(i, x)),
        1 => (place(), numbers()).prop_map(|(i, x)| Step::RowJacobian(i, x)),
        1 => (place(), compliance()).prop_map(|(i, soft)| Step::RowCompliance(i, soft)),
        1 => key().prop_map(Step::RemoveContact),
        1 => key().prop_map(Step::RemoveRow),
        1 => prop_oneof![Just(Step::Clear), Just(Step::ClearContacts), Just(Step::ClearRows)],
        1 => Just(Step::Reset),
        1 => (impulses(), impulses()).prop_map(|(of_contacts, of_rows)| Step::Impulses(of_contacts, of_rows)),
        8 => (numbers(), budget()).prop_map(|(push, budget)| Step::Solve(push, budget)),
        3 => (numbers(), budget()).prop_map(|(push, budget)| Step::Resume(push, budget)),
    ]
}

/// A sequence of calls that begins with a mass matrix and ends with a solve.
pub(super) fn sequence() -> impl Strategy<Value = Vec<Step>> {
    let last = (numbers(), budget()).prop_map(|(push, budget)| Step::Solve(push, budget));
    let first = numbers().prop_map(|root| Step::Mass(root, false));
    (first, vec(step(), 1..16), last).prop_map(|(first, mut steps, last)| {
        steps.insert(0, first);
        steps.push(last);
        steps
    })
}
