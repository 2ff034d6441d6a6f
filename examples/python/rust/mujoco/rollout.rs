//! Many copies of a model, each stepped through its own controls, on several threads.

use super::ffi::Data;
use super::softness::{Given, Springs};
use super::tally::Tally;
use super::{heard, opened, settings_of};
use crate::batch::PATIENCE;
use numpy::{PyReadonlyArrayDyn, PyReadwriteArrayDyn};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use stiction_kernels::room;

/// What is known of one copy, and where its results go: its first state, its controls; its states, readings of sensors, and number
/// of steps that were not solved.
struct Copy<'a> {
    first: &'a [f64],
    controls: &'a [f64],
    states: &'a mut [f64],
    readings: &'a mut [f64],
    unsolved: &'a mut i64,
}

/// Steps all copies `from_` first states, `(copies, state)`, by controls, `(copies, steps, nu)`, and writes states and readings after
/// each step, and how many steps of a copy were not solved, `to` where they belong. `kind` is the `mjtState` of a state, `soft` what of the
/// model is soft.
///
/// # Errors
/// An array is not contiguous, MuJoCo gives up, a mass matrix is not positive definite, or a signal was heard.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn rollout(
    py: Python<'_>,
    library: PathBuf,
    model: usize,
    kind: i32,
    from_: (PyReadonlyArrayDyn<'_, f64>, PyReadonlyArrayDyn<'_, f64>),
    to: (PyReadwriteArrayDyn<'_, f64>, PyReadwriteArrayDyn<'_, f64>, PyReadwriteArrayDyn<'_, i64>),
    settings: (f64, usize),
    threads: usize,
    soft: Given,
) -> PyResult<()> {
    let ((first, controls), (mut states, mut readings, mut unsolved)) = (from_, to);
    let copies = unsolved.len()?;
    let share = |len: usize| (len / copies.max(1)).max(1);
    let (first, controls) = (first.as_slice()?, controls.as_slice()?);
    let mut first = first.chunks_exact(share(first.len()));
    let mut controls_of = controls.chunks_exact(share(controls.len()));
    let states = states.as_slice_mut()?;
    let mut states = states.chunks_exact_mut(share(states.len()));
    let readings = readings.as_slice_mut()?;
    let mut readings = readings.chunks_exact_mut(share(readings.len()));
    let tasks = unsolved.as_slice_mut()?.iter_mut().map(|unsolved| Copy {
        first: first.next().unwrap_or(&[]),
        controls: controls_of.next().unwrap_or(&[]),
        states: states.next().unwrap_or(&mut []),
        readings: readings.next().unwrap_or(&mut []),
        unsolved,
    });
    let tasks = Mutex::new(tasks.collect::<Vec<_>>().into_iter());
    let next = || tasks.lock().ok().and_then(|mut tasks| tasks.next());
    let springs = Springs(soft);
    let steppers = (0..threads.clamp(1, copies.max(1)))
        .map(|_| opened(&library, model, springs.clone()))
        .collect::<PyResult<Vec<_>>>()?;
    let stopped = AtomicBool::new(false);
    let work = |mut stepper: super::stepper::Stepper| {
        room::note();
        let library = stepper.model.library();
        let done = library.watched(|| {
            let mut data = Data::scratch(&stepper.model);
            while let Some(copy) = next() {
                run(&mut stepper, &mut data, copy, kind, settings, &stopped)?;
            }
            Ok(())
        });
        heard(done)
    };
    py.detach(|| {
        std::thread::scope(|scope| {
            let (sender, receiver) = channel::<()>();
            let threads: Vec<_> = steppers
                .into_iter()
                .map(|stepper| {
                    let thread = std::thread::Builder::new().stack_size(room::STACK);
                    let (work, sender) = (&work, sender.clone());
                    thread.spawn_scoped(scope, move || {
                        let _sender = sender; // it ends with the thread
                        work(stepper)
                    })
                })
                .collect::<Result<_, _>>()?;
            drop(sender);
            let mut heard: PyResult<()> = Ok(());
            while let Err(RecvTimeoutError::Timeout) = receiver.recv_timeout(PATIENCE) {
                let ask = |py: Python<'_>| py.check_signals();
                heard = heard.and(Python::attach(ask));
                stopped.store(heard.is_err(), Ordering::Relaxed);
            }
            let ends = threads
                .into_iter()
                .map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
            heard.and(ends.collect::<Vec<_>>().into_iter().collect::<PyResult<()>>())
        })
    })
}

fn run(
    stepper: &mut super::stepper::Stepper,
    data: &mut Data,
    copy: Copy<'_>,
    kind: i32,
    settings: (f64, usize),
    stopped: &AtomicBool,
) -> Result<(), &'static str> {
    let (mut tally, settings) = (Tally::default(), settings_of(settings));
    stepper.reset();
    data.set_state(&stepper.model, copy.first, kind);
    let (nu, sensors) = (stepper.model.sizes.controls, stepper.model.sizes.readings);
    for (step, state) in copy.states.chunks_exact_mut(copy.first.len()).enumerate() {
        if stopped.load(Ordering::Relaxed) {
            break;
        }
        data.ctrl_mut().copy_from_slice(&copy.controls[step * nu..][..nu]);
        stepper.step1(data);
        tally.add(&stepper.step2(data, &settings)?);
        data.state(&stepper.model, state, kind);
        copy.readings[step * sensors..][..sensors].copy_from_slice(data.sensordata());
    }
    *copy.unsolved = i64::try_from(tally.unsolved).unwrap_or(i64::MAX);
    Ok(())
}
