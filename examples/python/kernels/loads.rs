//! What a solution bears: its least impulses, and how near to slipping it is.

use crate::derivative::find_again;
use crate::engine::{Compiled, Engine};
use crate::problem::{Out, Problem};
use stiction::nalgebra::SVector;
use stiction::{Error, Kernel, Settings};

/// Share of the tolerance that least impulses are to miss of the momentum of a step. If they miss more than the tolerance, those of the solution stay.
const MOMENTUM: f64 = 0.1;

/// What is asked of a solution.
#[derive(Clone, Copy, Debug)]
pub enum Asked<'a> {
    /// Least impulses: their momentum error, those of contacts, those of joint rows.
    Least,
    /// The least share of friction, to this accuracy.
    SlipReserve(f64),
    /// The largest factor on a further load, to this accuracy.
    LoadReserve(f64, &'a [f64]),
    /// The least share of friction with which all could rest, to this accuracy. It asks for no solution.
    RestReserve(f64),
}

/// Writes the least impulses of a kernel's last solution, if it has any.
pub(crate) fn read_least<const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
    kernel: &Kernel<f64, N, D, C, R, S>,
    settings: &Settings<f64>,
    out: &mut Out<'_, f64>,
) {
    let exact = Settings { tolerance: settings.tolerance * MOMENTUM, ..*settings };
    if let Ok(least) = kernel.least_impulses(&exact)
        && least.momentum_error <= settings.tolerance
    {
        for (place, impulse) in out.r.chunks_exact_mut(D).zip(&least.contacts) {
            place.copy_from_slice(impulse.as_slice());
        }
        out.row_impulses.copy_from_slice(&least.rows);
    }
}

/// Finds a solution again from its impulses, and tells what it bears; `None` if it is not found.
pub(crate) fn bear<const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
    kept: &mut Compiled<f64, N, D, C, R, S>,
    problem: &Problem<'_, f64>,
    settings: &Settings<f64>,
    impulses: [&[f64]; 2],
    asked: &Asked<'_>,
) -> Result<Option<Vec<f64>>, Error> {
    let full = |short: &[f64]| SVector::<f64, N>::from_fn(|i, _| short.get(i).copied().unwrap_or(0.0));
    if let Asked::RestReserve(accuracy) = *asked {
        kept.reset();
        kept.load(problem)?;
        let settings = Settings { tolerance: accuracy, ..*settings };
        return Ok(Some(vec![kept.kernel_mut().rest_reserve(&full(problem.free_impulse), &settings)?]));
    }
    let given = settings.tolerance;
    let Some((error, settings)) = find_again(kept, problem, settings, impulses)? else {
        return Ok(None);
    };
    let kernel = kept.kernel_mut();
    let to = |accuracy: f64| Settings { tolerance: accuracy.max(settings.tolerance), ..settings };
    Ok(Some(match *asked {
        Asked::Least => {
            let least = kernel.least_impulses(&Settings { tolerance: error.max(given), ..settings })?;
            let contacts = least.contacts.iter().flatten();
            let error = [least.momentum_error];
            error.iter().chain(contacts).chain(&least.rows).copied().collect()
        }
        Asked::SlipReserve(accuracy) => vec![kernel.slip_reserve(&to(accuracy))?],
        Asked::LoadReserve(accuracy, load) => vec![kernel.load_reserve(&full(load), &to(accuracy))?],
        Asked::RestReserve(_) => Vec::new(), // told above
    }))
}
