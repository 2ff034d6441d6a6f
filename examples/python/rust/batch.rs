//! Many scenes, on the cores of the machine.

use crate::arrays::Arrays;
use crate::arrays::Number;
use crate::solve::{SettingsArguments, run, settings, value_error, with_engine};
use numpy::{Element, PyArrayDyn, PyArrayMethods, PyReadwriteArrayDyn};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;
use stiction::Error;
use stiction_kernels::problem::{Out, Outcome};
use stiction_kernels::{room, sizes};

/// How often Ctrl-C is asked for.
pub(crate) const PATIENCE: Duration = Duration::from_millis(50);
/// Scenes that a thread takes at once, at least.
const PORTION: usize = 16;

/// Solves all scenes of a batch, each from nothing, returns their fingerprint, and writes into arrays that Python has made:
/// `(v, r, u, modes, certificate, row impulses, row velocities, row modes, row certificate, status, error, work)`.
#[pyfunction]
pub(crate) fn solve_batch<'py>(
    py: Python<'py>,
    scenes: &Bound<'py, PyTuple>,
    settings: SettingsArguments<'py>,
    threads: usize,
    out: &Bound<'py, PyTuple>,
    single: bool,
) -> PyResult<u64> {
    if single {
        solve_all::<f32>(py, scenes, &settings, threads, out)
    } else {
        solve_all::<f64>(py, scenes, &settings, threads, out)
    }
}

/// How many scenes, velocities, contacts, rows of a contact and joint rows the arrays of a batch have.
#[pyfunction]
pub(crate) fn batch_shape(scenes: &Bound<'_, PyTuple>, single: bool) -> PyResult<[usize; 5]> {
    fn shape<T: Number>(scenes: &Bound<'_, PyTuple>) -> PyResult<[usize; 5]> {
        let arrays = Arrays::<T>::new(scenes, true)?;
        Ok([arrays.lead, arrays.n, arrays.contacts, arrays.dim, arrays.rows])
    }
    if single { shape::<f32>(scenes) } else { shape::<f64>(scenes) }
}

fn solve_all<T: Number>(
    py: Python<'_>,
    scenes: &Bound<'_, PyTuple>,
    given: &SettingsArguments<'_>,
    threads: usize,
    out: &Bound<'_, PyTuple>,
) -> PyResult<u64> {
    let arrays = Arrays::<T>::new(scenes, true)?;
    let (n, c, k, count) = (arrays.n, arrays.contacts, arrays.rows, arrays.lead);
    let fingerprint = arrays.loaded().fingerprint;
    if count == 0 {
        return Ok(fingerprint);
    }
    let index = sizes::index::<T>(&arrays.problem(0).needs()).map_err(PyValueError::new_err)?;
    let (mut v, mut r, mut u) = (writable::<T>(out, 0)?, writable::<T>(out, 1)?, writable::<T>(out, 2)?);
    let (mut modes, mut certificate) = (writable::<i8>(out, 3)?, writable::<T>(out, 4)?);
    let (mut impulses, mut velocities) = (writable::<T>(out, 5)?, writable::<T>(out, 6)?);
    let (mut row_modes, mut row_certificate) = (writable::<i8>(out, 7)?, writable::<T>(out, 8)?);
    let (mut status, mut error, mut work) =
        (writable::<i8>(out, 9)?, writable::<T>(out, 10)?, writable::<i32>(out, 11)?);

    let (mut v, mut r, mut u) = (
        Pieces(v.as_slice_mut()?, n),
        Pieces(r.as_slice_mut()?, c * arrays.dim),
        Pieces(u.as_slice_mut()?, c * arrays.dim),
    );
    let (mut modes, mut certificate) =
        (Pieces(modes.as_slice_mut()?, c), Pieces(certificate.as_slice_mut()?, c * arrays.dim));
    let (mut impulses, mut velocities) =
        (Pieces(impulses.as_slice_mut()?, k), Pieces(velocities.as_slice_mut()?, k));
    let (mut row_modes, mut row_certificate) =
        (Pieces(row_modes.as_slice_mut()?, k), Pieces(row_certificate.as_slice_mut()?, k));
    let (mut status, mut error, mut work) = (
        Pieces(status.as_slice_mut()?, 1),
        Pieces(error.as_slice_mut()?, 1),
        Pieces(work.as_slice_mut()?, 4),
    );
    let tasks: Vec<_> = (0..count)
        .map(|scene| {
            let out = Out {
                v: v.next(),
                r: r.next(),
                u: u.next(),
                modes: modes.next(),
                certificate: certificate.next(),
                row_impulses: impulses.next(),
                row_velocities: velocities.next(),
                row_modes: row_modes.next(),
                row_certificate: row_certificate.next(),
            };
            (scene, out, status.next(), error.next(), work.next())
        })
        .collect();

    let problems: Vec<_> = (0..count).map(|scene| arrays.problem(scene)).collect();
    let (settings, stopped) = (settings::<T>(given)?, AtomicBool::new(false));
    let pool = pool(threads)?;
    // The first that is refused, whichever thread comes to it.
    let solve = || {
        let tasks = tasks.into_par_iter().with_min_len(PORTION);
        tasks
            .filter_map(|(scene, mut out, status, error, work)| {
                if stopped.load(Ordering::Relaxed) {
                    return None;
                }
                let problem = &problems[scene];
                match with_engine(index, |engine| run(engine, problem, &settings, &mut out)) {
                    Ok(outcome) => {
                        write(&outcome, status, error, work);
                        None
                    }
                    Err(refused) => Some((scene, refused)),
                }
            })
            .min_by_key(|&(scene, _)| scene)
    };
    let refused = waited(py, &pool, &stopped, solve)?;
    match refused {
        None => Ok(fingerprint),
        Some((scene, error)) => {
            let text = value_error(&error).value(py).to_string();
            Err(PyValueError::new_err(format!("{text} (scene {scene} of the batch)")))
        }
    }
}

/// Threads with room for kernels of all sizes.
pub(crate) fn pool(threads: usize) -> PyResult<rayon::ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .stack_size(room::STACK)
        .start_handler(|_| room::note())
        .build()
        .map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// Runs on a pool, without the interpreter's lock, and asks now and then for signals.
fn waited(
    py: Python<'_>,
    pool: &rayon::ThreadPool,
    stopped: &AtomicBool,
    solve: impl FnOnce() -> Option<(usize, Error)> + Send,
) -> PyResult<Option<(usize, Error)>> {
    py.detach(|| {
        std::thread::scope(|scope| {
            let (sender, receiver) = channel();
            scope.spawn(move || sender.send(pool.install(solve)));
            let mut interrupt = Ok(());
            loop {
                match receiver.recv_timeout(PATIENCE) {
                    Ok(refused) => return interrupt.map(|()| refused),
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(PyRuntimeError::new_err("a solve panicked"));
                    }
                    Err(RecvTimeoutError::Timeout) if interrupt.is_ok() => {
                        let ask = |py: Python<'_>| py.check_signals();
                        interrupt = Python::attach(ask);
                        stopped.store(interrupt.is_err(), Ordering::Relaxed);
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                }
            }
        })
    })
}

fn write<T: Number>(outcome: &Outcome, status: &mut [i8], error: &mut [T], work: &mut [i32]) {
    status.fill(outcome.status as i8);
    error.fill(T::literal(outcome.error));
    work.copy_from_slice(&outcome.work());
}

/// An array to write to.
fn writable<'py, T: Element>(
    out: &Bound<'py, PyTuple>,
    place: usize,
) -> PyResult<PyReadwriteArrayDyn<'py, T>> {
    let array = out.get_item(place)?;
    let array =
        array.cast::<PyArrayDyn<T>>().map_err(|_| PyValueError::new_err("out: an array of another type"))?;
    array.try_readwrite().map_err(|error| PyValueError::new_err(format!("out: {error}")))
}

/// An array, cut into pieces of one length.
struct Pieces<'a, T>(&'a mut [T], usize);

impl<'a, T> Pieces<'a, T> {
    fn next(&mut self) -> &'a mut [T] {
        self.0.split_off_mut(..self.1).unwrap_or_default()
    }
}
