//! What derivatives cost, and what a solution bears: its least impulses, and how near to slipping it is.

use crate::counter::Counter;
use core::hint::black_box;
use cortex_m_semihosting::hprintln;
use stiction::{Derivative, Factor, Inputs, LeastImpulses, Outputs, Real, Scene, Settings, Solution};

/// Counts the derivative of a solution of the scene called so, a change forward and a gradient.
pub(crate) fn measure<T: Real, const N: usize, const D: usize, const C: usize>(
    name: &str,
    (scene, factor): (&Scene<T, N, D, C>, &Factor<T, N, D, C>),
    solution: &Solution<T, N, D, C>,
    settings: &Settings<T>,
    counter: &mut Counter,
) -> Option<()> {
    let new = || Derivative::new(scene, factor, black_box(solution), settings);
    let count = counter.count(|| _ = black_box(new()))?;
    hprintln!("{} derivative {}", name, count);
    let derivative = new().ok()?;
    let mut change = Inputs::<T, N, D, C>::zero();
    change.free_impulse.fill(T::ONE);
    change.friction.fill(T::ONE);
    let count = counter.count(|| _ = black_box(derivative.forward(black_box(&change))))?;
    hprintln!("{} forward {}", name, count);
    let mut weights = Outputs::<T, N, D, C>::zero();
    weights.velocity.fill(T::ONE);
    let count = counter.count(|| _ = black_box(derivative.adjoint(black_box(&weights))))?;
    hprintln!("{} adjoint {}", name, count);
    let least = || LeastImpulses::new(scene, factor, black_box(solution), settings);
    let count = counter.count(|| _ = black_box(least()))?;
    hprintln!("{} least {}", name, count);
    let percent = Settings { tolerance: T::literal(0.01), ..*settings };
    let count = counter.count(|| _ = black_box(solution.slip_reserve(scene, factor, &percent)))?;
    hprintln!("{} slip_reserve {}", name, count);
    (least().is_ok() && solution.slip_reserve(scene, factor, &percent).is_ok()).then_some(())
}
