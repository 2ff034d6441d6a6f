//! A kernel of one compiled size behind an interface for all: fills it and reads its solution.

use crate::problem::{Friction, Out, Outcome, Problem};
use crate::{loads, room, sizes};
use std::cell::RefCell;
use std::thread::LocalKey;
use stiction::nalgebra::{SMatrix, SVector};
use stiction::{
    Contact, ContactMode, Error, JointRow, Kernel, Real, RowLaw, RowMode, Scene, Settings, Surface, WarmStart,
};

/// A kernel for each size, as far as this thread has needed them.
pub type Engines<T> = RefCell<Vec<Option<Box<dyn Engine<T>>>>>;

/// `f32` and `f64`.
pub trait Number: Real + Default + Into<f64> + Send + Sync + 'static {
    /// This thread's kernels.
    fn engines() -> &'static LocalKey<Engines<Self>>;

    /// The sizes that are compiled, in the order in which they are tried.
    fn sizes() -> &'static [sizes::Entry<Self>];

    /// Writes the least impulses of a kernel's last solution, if it has any; in double precision alone, in which models are stepped.
    fn read_least<const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
        kernel: &Kernel<Self, N, D, C, R, S>,
        settings: &Settings<Self>,
        out: &mut Out<'_, Self>,
    );
}

macro_rules! number {
    ($($t:ty: $sizes:path, $read_least:path),*) => {$(
        impl Number for $t {
            fn engines() -> &'static LocalKey<Engines<Self>> {
                thread_local! {
                    static ENGINES: Engines<$t> = const { RefCell::new(Vec::new()) };
                }
                &ENGINES
            }

            fn sizes() -> &'static [sizes::Entry<Self>] {
                $sizes
            }

            fn read_least<const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
                kernel: &Kernel<Self, N, D, C, R, S>,
                settings: &Settings<Self>,
                out: &mut Out<'_, Self>,
            ) {
                $read_least(kernel, settings, out);
            }
        }
    )*};
}
number!(f32: sizes::SINGLE, read_none, f64: sizes::DOUBLE, loads::read_least);

fn read_none<const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
    _: &Kernel<f32, N, D, C, R, S>,
    _: &Settings<f32>,
    _: &mut Out<'_, f32>,
) {
}

/// A kernel of one size.
pub trait Engine<T>: Send + Sync {
    /// Takes a scene that fits.
    fn load(&mut self, problem: &Problem<'_, T>) -> Result<(), Error>;

    /// Solves it, or goes on.
    fn solve(&mut self, settings: &Settings<T>, resume: bool) -> Result<Outcome, Error>;

    /// Forgets the last solve.
    fn reset(&mut self);

    /// Declares that nothing moved before the next solve.
    fn presume_rest(&mut self);

    /// Where the next solve starts, for [`Self::set_warm_start`] of an engine of any size with contacts of as many rows.
    fn warm_start(&self) -> Vec<u64>;

    /// Starts the next solve there; `false` if there is no room for it.
    fn set_warm_start(&mut self, words: &[u64]) -> bool;

    /// Starts the next solve at impulses of contacts with these keys.
    fn start(&mut self, keys: &[u32], impulses: &[T]) -> Result<(), Error>;

    /// Writes the last solution.
    fn read(&self, out: &mut Out<'_, T>);

    /// Writes the least impulses of the last solution, if it has any ([`Number::read_least`]).
    fn read_least(&self, settings: &Settings<T>, out: &mut Out<'_, T>);
}

type Push<T, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize> =
    fn(&mut Scene<T, N, D, C, R, S>, &Contact<T, N, D>) -> Result<usize, Error>;

/// The kernel of a size.
pub struct Compiled<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize> {
    kernel: Kernel<T, N, D, C, R, S>,
    free_impulse: SVector<T, N>,
    push: Push<T, N, D, C, R, S>,
}

/// Runs what needs room for a kernel on the stack.
pub(crate) fn with_room<K, R: Send>(work: impl FnOnce() -> R + Send) -> R {
    room::with_room(size_of::<K>(), work)
}

impl<T: Number, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>
    Compiled<T, N, D, C, R, S>
{
    pub fn boxed(push: Push<T, N, D, C, R, S>) -> Box<Self> {
        with_room::<Self, _>(|| {
            let (kernel, free_impulse) = (Kernel::new(), SVector::zeros());
            Box::new(Self { kernel, free_impulse, push })
        })
    }

    pub(crate) fn kernel_mut(&mut self) -> &mut Kernel<T, N, D, C, R, S> {
        &mut self.kernel
    }

    fn set_mass(&mut self, n: usize, mass: &[T]) -> Result<(), Error> {
        let mut leading = SMatrix::<T, N, N>::zeros();
        for (j, column) in leading.data.0[..n].iter_mut().enumerate() {
            for (entry, row) in column.iter_mut().zip(mass.chunks_exact(n)) {
                *entry = row[j];
            }
        }
        self.kernel.scene_mut().set_mass(&leading)
    }

    fn push_contacts(&mut self, problem: &Problem<'_, T>) -> Result<(), Error> {
        let n = problem.n;
        for (i, offset) in problem.offsets.chunks_exact(D).enumerate() {
            let mut contact = Contact::<T, N, D> {
                jacobian: SMatrix::zeros(),
                offset: SVector::from_column_slice(offset),
                mu: T::ZERO,
                key: problem.keys.get(i).copied().unwrap_or(0),
            };
            let own = &problem.jacobian[i * D * n..][..D * n];
            for (j, column) in contact.jacobian.data.0[..n].iter_mut().enumerate() {
                for (entry, row) in column.iter_mut().zip(own.chunks_exact(n)) {
                    *entry = row[j];
                }
            }
            let compliance = problem.compliance.chunks_exact(2).nth(i);
            let scene = self.kernel.scene_mut();
            match (problem.friction, compliance) {
                (Friction::Round(mu), None) => {
                    contact.mu = mu[i];
                    (self.push)(scene, &contact)?;
                }
                (friction, compliance) => {
                    let surface = surface::<T, D>(friction, compliance, i);
                    scene.push_on(&contact, &surface)?;
                }
            }
        }
        Ok(())
    }

    fn push_rows(&mut self, problem: &Problem<'_, T>) -> Result<(), Error> {
        let (n, rows) = (problem.n, problem.rows);
        for (j, (&lower, &upper)) in rows.lower.iter().zip(rows.upper).enumerate() {
            let mut row = SVector::<T, N>::zeros();
            row.as_mut_slice()[..n].copy_from_slice(&rows.jacobian[j * n..][..n]);
            let law = if lower == T::ZERO && upper == T::INFINITY {
                RowLaw::Limit
            } else if lower == -T::INFINITY && upper == T::INFINITY {
                RowLaw::Equality
            } else {
                RowLaw::Box { lower, upper }
            };
            self.kernel.scene_mut().push_row(&JointRow {
                row,
                offset: rows.offset[j],
                law,
                compliance: rows.compliance.get(j).copied().unwrap_or(T::ZERO),
                key: rows.keys.get(j).copied().unwrap_or(0),
            })?;
        }
        Ok(())
    }
}

/// The surface of a contact.
fn surface<T: Real, const D: usize>(
    friction: Friction<'_, T>,
    compliance: Option<&[T]>,
    contact: usize,
) -> Surface<T> {
    let mut surface = match friction {
        Friction::Round(mu) => Surface::isotropic(mu[contact]),
        Friction::Shaped(mu) => {
            let own = &mu[contact * (D - 1)..][..D - 1];
            let of = |row: usize| own.get(row).copied().unwrap_or(T::ZERO);
            Surface {
                friction: [of(0), of(1)],
                spin: of(2),
                roll: [of(3), of(4)],
                ..Surface::isotropic(T::ZERO)
            }
        }
    };
    if let Some(&[normal, tangential]) = compliance {
        surface.compliance = [normal, tangential];
    }
    surface
}

impl<T: Number, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize> Engine<T>
    for Compiled<T, N, D, C, R, S>
{
    fn load(&mut self, problem: &Problem<'_, T>) -> Result<(), Error> {
        self.kernel.scene_mut().clear();
        self.kernel.scene_mut().set_velocities(problem.n)?;
        self.free_impulse = SVector::zeros();
        with_room::<SMatrix<T, N, N>, _>(|| self.set_mass(problem.n, problem.mass))?;
        self.free_impulse.as_mut_slice()[..problem.n].copy_from_slice(problem.free_impulse);
        self.push_contacts(problem)?;
        self.push_rows(problem)
    }

    fn solve(&mut self, settings: &Settings<T>, resume: bool) -> Result<Outcome, Error> {
        with_room::<Self, _>(|| {
            let solution = if resume {
                self.kernel.resume(&self.free_impulse, settings)?
            } else {
                self.kernel.solve(&self.free_impulse, settings)?
            };
            Ok(Outcome { status: solution.status, error: solution.error.into(), work: solution.work })
        })
    }

    fn reset(&mut self) {
        self.kernel.solver_mut().reset();
    }

    fn presume_rest(&mut self) {
        self.kernel.solver_mut().presume_rest();
    }

    fn warm_start(&self) -> Vec<u64> {
        self.kernel.solver().warm_start().words().collect()
    }

    fn set_warm_start(&mut self, words: &[u64]) -> bool {
        let warm_start = WarmStart::from_words(words.iter().copied());
        warm_start.map(|warm_start| self.kernel.solver_mut().set_warm_start(warm_start)).is_some()
    }

    fn start(&mut self, keys: &[u32], impulses: &[T]) -> Result<(), Error> {
        let contacts: Vec<_> = impulses
            .chunks_exact(D)
            .zip(keys)
            .map(|(impulse, &key)| (key, SVector::from_column_slice(impulse)))
            .collect();
        self.kernel.solver_mut().set_impulses(&contacts, &[])
    }

    fn read(&self, out: &mut Out<'_, T>) {
        let solution = self.kernel.solution();
        out.v.copy_from_slice(&solution.velocity.as_slice()[..out.v.len()]);
        for (i, contact) in solution.contacts.iter().enumerate() {
            out.r[i * D..][..D].copy_from_slice(contact.impulse.as_slice());
            out.u[i * D..][..D].copy_from_slice(contact.velocity.as_slice());
            out.modes[i] = match contact.mode {
                ContactMode::Open => 0,
                ContactMode::Stick => 1,
                ContactMode::Slip => 2,
            };
        }
        let certificate = solution.certificate.iter().flatten().copied();
        let certificate: Vec<T> = certificate.collect();
        copy_or_zero(out.certificate, &certificate);
        for (j, row) in solution.rows.iter().enumerate() {
            out.row_impulses[j] = row.impulse;
            out.row_velocities[j] = row.velocity;
            out.row_modes[j] = match row.mode {
                RowMode::Open => 0,
                RowMode::AtLimit => 1,
                RowMode::AtLower => 2,
                RowMode::AtUpper => 3,
                RowMode::Holding => 4,
            };
        }
        copy_or_zero(out.row_certificate, &solution.row_certificate);
    }

    fn read_least(&self, settings: &Settings<T>, out: &mut Out<'_, T>) {
        with_room::<Self, _>(|| T::read_least(&self.kernel, settings, out));
    }
}

/// Without a proof all numbers are 0.
fn copy_or_zero<T: Real>(to: &mut [T], from: &[T]) {
    for (i, to) in to.iter_mut().enumerate() {
        *to = from.get(i).copied().unwrap_or(T::ZERO);
    }
}
