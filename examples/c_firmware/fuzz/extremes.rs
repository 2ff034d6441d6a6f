//! Sequences of calls whose numbers stand at the ends of what a type holds, more of them than there is room for.

use crate::c::{C, D, N, R};
use crate::steps::{Budget, Law, Step};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

/// Of each kind of number some, and such whose squares, products or sums overflow or vanish in `float` or in `double`.
const ENDS: [f64; 24] = [
    0.0,
    -0.0,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f32::MAX as f64,
    -(f32::MAX as f64),
    f32::MIN_POSITIVE as f64,
    1e-45, // the least float
    -1e-45,
    f64::MIN_POSITIVE,
    1e30,
    -1e30,
    1e-30,
    1e19, // its square is a float no more
    -1e19,
    1e-19,
    1e12,
    1e-12,
    16_777_217.0, // no float
    1.0,
    -1.0,
    0.5,
];

fn end() -> impl Strategy<Value = f64> {
    select(&ENDS[..])
}

/// So many numbers of one size, some of them at an end.
fn numbers(count: usize) -> impl Strategy<Value = Vec<f64>> {
    let finite = select(vec![1e-30, 1e-12, 1.0, 1.0, 1.0, 1e6, 1e12, 1e30]);
    let mild = prop_oneof![3 => -2.0..2.0, 2 => Just(0.0), 1 => Just(1.0)];
    let ends = vec((0..count, end()), 0..3);
    (vec(mild, count), finite, ends, prop::bool::weighted(0.5)).prop_map(|(mut numbers, size, ends, wild)| {
        for x in &mut numbers {
            *x *= size;
        }
        for (place, x) in ends.into_iter().filter(|_| wild) {
            numbers[place] = x;
        }
        numbers
    })
}

/// A diagonal matrix, entry by entry.
fn diagonal() -> impl Strategy<Value = Vec<f64>> {
    let entry = prop_oneof![4 => 0.1..2.0_f64, 2 => select(vec![1e-30, 1e-12, 1e12, 1e30]), 1 => end()];
    let ordinary = vec(0.1..2.0_f64, N);
    prop_oneof![ordinary, vec(entry, N)].prop_map(|diagonal| {
        let mut mass = vec![0.0; N * N];
        for (i, x) in diagonal.into_iter().enumerate() {
            mass[i * N + i] = x;
        }
        mass
    })
}

fn friction() -> impl Strategy<Value = f64> {
    prop_oneof![3 => select(vec![0.0, 0.5, 1.0, 1e3, 1e18, 1e19, 1e30]), 1 => end()]
}

fn place() -> impl Strategy<Value = usize> {
    prop_oneof![4 => 0..C, 1 => select(vec![C, C + 1, 1 << 31, u32::MAX as usize])]
}

fn law() -> impl Strategy<Value = Law> {
    let bound = || prop_oneof![3 => select(vec![-1e30, -1.0, -1e-30, 0.0, 1e-30, 1.0, 1e30]), 1 => end()];
    (0..3_u8, bound(), bound())
}

/// Of a surface: friction, spin, rolls, compliances.
fn surface() -> impl Strategy<Value = Vec<f64>> {
    let soft = prop_oneof![3 => Just(0.0), 2 => select(vec![1e-30, 0.5, 1e30]), 1 => end()];
    (vec(friction(), 5), vec(soft, 2)).prop_map(|(mut surface, soft)| {
        surface.extend(soft);
        surface
    })
}

/// A budget that is large goes with a tolerance that is: it would be spent to the end on what cannot be reached.
fn budget() -> impl Strategy<Value = Budget> {
    let tolerance = prop_oneof![4 => select(vec![0.0, 1e-45, 1e-7, 1e-4]), 1 => end()];
    let bounded = (select(vec![0, 1, 9, 1_000]), tolerance);
    prop_oneof![9 => bounded, 1 => Just((100_000, 1e30))].prop_map(|(work, tolerance)| Budget {
        work,
        tolerance,
        relaxed: false,
    })
}

fn step() -> impl Strategy<Value = Step> {
    let jacobian = || numbers(D * N + D);
    let key = || select(vec![0, 1, u32::MAX]);
    prop_oneof![
        2 => diagonal().prop_map(|mass| Step::Mass(mass, true)),
        1 => (numbers(N * N), any::<bool>()).prop_map(|(root, raw)| Step::Mass(root, raw)),
        9 => (jacobian(), friction(), key()).prop_map(|(x, mu, key)| Step::Push(x, mu, key)),
        3 => (jacobian(), surface(), key()).prop_map(|(x, surface, key)| Step::PushOn(x, surface, key)),
        6 => (numbers(N + 1), law(), friction(), key())
            .prop_map(|(x, law, soft, key)| Step::PushRow(x, law, if soft > 0.5 { soft } else { 0.0 }, key)),
        1 => (place(), numbers(D * N)).prop_map(|(i, x)| Step::Jacobian(i, x)),
        1 => (place(), numbers(D)).prop_map(|(i, x)| Step::Offset(i, x)),
        1 => (place(), friction()).prop_map(|(i, mu)| Step::Friction(i, mu)),
        1 => (place(), law()).prop_map(|(i, law)| Step::RowLaw(i, law)),
        1 => (place(), end()).prop_map(|(i, x)| Step::RowOffset(i, x)),
        1 => (place(), numbers(N)).prop_map(|(i, x)| Step::RowJacobian(i, x)),
        1 => (place(), end()).prop_map(|(i, soft)| Step::RowCompliance(i, soft)),
        1 => key().prop_map(Step::RemoveContact),
        1 => key().prop_map(Step::RemoveRow),
        1 => select(vec![Step::Clear, Step::ClearContacts, Step::ClearRows]),
        1 => Just(Step::Reset),
        1 => (vec((key(), end()), 0..C + 2), vec((key(), end()), 0..R + 2))
            .prop_map(|(contacts, rows)| Step::Impulses(contacts, rows)),
        4 => (numbers(N), budget()).prop_map(|(push, budget)| Step::Solve(push, budget)),
        2 => (numbers(N), budget()).prop_map(|(push, budget)| Step::Resume(push, budget)),
    ]
}

/// A sequence of calls, of which the first need not be a mass matrix.
pub(crate) fn sequence() -> impl Strategy<Value = Vec<Step>> {
    (diagonal(), any::<bool>(), vec(step(), 1..30)).prop_map(|(mass, first, mut steps)| {
        if first {
            steps.insert(0, Step::Mass(mass, true));
        }
        steps
    })
}
