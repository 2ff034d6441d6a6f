//! The kernel behind one interface for all compiled sizes, so that a size is compiled once and not in every tool.

use crate::measure;
use crate::method::{Factors, Method, Solvers};
use crate::scene_file::SceneFile;
use nalgebra::SVector;
use std::hint::black_box;
use stiction::{ContactMode, Error, Real, Scene, Settings, SlipUpdate, Solution, Status, Work};

/// What a compiled size has to hold.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    pub dofs: usize,
    /// Rows of a contact.
    pub dim: usize,
    pub contacts: usize,
}

impl Shape {
    pub fn of(file: &SceneFile) -> Self {
        Self { dofs: file.n_dof, dim: file.dim, contacts: file.n_contacts }
    }

    /// Of the time steps of a sequence: contacts come and go.
    pub fn of_all(steps: &[SceneFile]) -> Option<Self> {
        let largest = steps.iter().max_by_key(|step| step.n_contacts);
        largest.map(Self::of)
    }
}

/// Constructor of a kernel for scenes of a shape: `kernels_f64::kernel` or `kernels_f32::kernel`.
pub type Constructor = fn(Shape) -> Result<Box<dyn Kernel>, String>;

/// A scene, its factor and the solvers' states.
pub trait Kernel {
    /// A scene as its number type holds it.
    fn rounded(&self, file: &SceneFile) -> SceneFile;

    /// Takes a scene of the shape; the states stay.
    fn load(&mut self, file: &SceneFile) -> Result<(), Error>;

    /// Computes the factor that a method needs.
    fn prepare(&mut self, method: Method) -> Result<(), Error>;

    /// Forgets the states; solvers by ADMM update `s` so from now on.
    fn set_slip_update(&mut self, slip_update: SlipUpdate);

    /// Forgets the states.
    fn reset(&mut self);

    /// Remembers the states for [`Kernel::rewind`] by this method.
    fn keep(&mut self, method: Method);

    /// Goes back to the states that were kept.
    fn rewind(&mut self);

    fn solve(&mut self, method: Method, settings: &Settings<f64>) -> Result<(), Error>;

    /// Goes on with a solve by the default method.
    fn resume(&mut self, settings: &Settings<f64>) -> Result<(), Error>;

    /// The penalty `rho` of ADMM.
    fn penalty(&self) -> f64;

    /// How the last solve ended, and what it has cost.
    fn outcome(&self) -> (Status, Work);

    /// The solution of the last solve.
    fn answer(&self) -> Answer;
}

/// A solution in f64, without padding.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    pub status: Status,
    pub work: Work,
    /// As the kernel says.
    pub error: f64,
    pub v: Vec<f64>,
    /// Contact by contact, normal first.
    pub r: Vec<f64>,
    pub modes: Vec<ContactMode>,
    /// `d`, one number a contact, if the scene is infeasible.
    pub certificate: Vec<f64>,
    /// Impulses of joint rows.
    pub lambda: Vec<f64>,
    /// Their part of the proof.
    pub certificate_lambda: Vec<f64>,
}

/// The kernel in one size.
pub struct Compiled<T: Real, const N: usize, const D: usize, const C: usize> {
    n_dof: usize,
    scene: Scene<T, N, D, C>,
    push: SVector<T, N>,
    factors: Factors<T, N, D, C>,
    solvers: Solvers<T, N, D, C>,
    kept: Solvers<T, N, D, C>,
    /// Of the last solve.
    method: Method,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Default for Compiled<T, N, D, C> {
    fn default() -> Self {
        Self {
            n_dof: N,
            scene: Scene::new(),
            push: SVector::zeros(),
            factors: Factors::empty(),
            solvers: Solvers::default(),
            kept: Solvers::default(),
            method: Method::Default,
        }
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Compiled<T, N, D, C> {
    fn solution(&self) -> &Solution<T, N, D, C> {
        self.solvers.solution(self.method)
    }
}

pub(crate) fn rounded_settings<T: Real>(settings: &Settings<f64>) -> Settings<T> {
    Settings {
        tolerance: T::literal(settings.tolerance),
        budget: settings.budget,
        model: settings.model,
        still: T::literal(settings.still),
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Kernel for Compiled<T, N, D, C> {
    fn rounded(&self, file: &SceneFile) -> SceneFile {
        file.rounded::<T>()
    }

    fn load(&mut self, file: &SceneFile) -> Result<(), Error> {
        self.scene = file.scene()?;
        self.push = file.free_impulse();
        self.n_dof = file.n_dof;
        Ok(())
    }

    fn prepare(&mut self, method: Method) -> Result<(), Error> {
        self.factors.prepare(method, black_box(&self.scene))
    }

    fn set_slip_update(&mut self, slip_update: SlipUpdate) {
        self.solvers = Solvers::new(slip_update);
    }

    fn reset(&mut self) {
        self.solvers.reset();
    }

    fn keep(&mut self, method: Method) {
        self.method = method;
        self.kept.take(method, &self.solvers);
    }

    fn rewind(&mut self) {
        // One state alone: those of all methods would drive out of the caches what is to be timed.
        self.solvers.take(self.method, &self.kept);
    }

    fn solve(&mut self, method: Method, settings: &Settings<f64>) -> Result<(), Error> {
        self.method = method;
        let (scene, factors, push) = black_box((&self.scene, &self.factors, &self.push));
        let solution = method.run(&mut self.solvers, scene, factors, push, &rounded_settings(settings))?;
        black_box(solution);
        Ok(())
    }

    fn resume(&mut self, settings: &Settings<f64>) -> Result<(), Error> {
        self.method = Method::Default;
        let solver = &mut self.solvers.default;
        solver.resume(&self.scene, &self.factors.default, &self.push, &rounded_settings(settings))?;
        Ok(())
    }

    fn penalty(&self) -> f64 {
        measure::double(&self.factors.admm.penalty())
    }

    fn outcome(&self) -> (Status, Work) {
        let solution = self.solution();
        (solution.status, solution.work)
    }

    fn answer(&self) -> Answer {
        let solution = self.solution();
        let mut v = measure::velocity(solution);
        v.truncate(self.n_dof);
        Answer {
            status: solution.status,
            work: solution.work,
            error: measure::double(&solution.error),
            v,
            r: measure::impulses(solution),
            modes: solution.contacts.iter().map(|contact| contact.mode).collect(),
            certificate: solution.certificate.iter().map(|d| measure::double(&d[0])).collect(),
            lambda: Vec::new(),
            certificate_lambda: Vec::new(),
        }
    }
}

/// The kernel in the smallest compiled size that holds scenes of this shape.
///
/// The sizes: each is compiled once for f64 and once for f32, a second or two of a build for both.
pub fn smallest<T: Real>(shape: Shape) -> Result<Box<dyn Kernel>, String> {
    macro_rules! sizes {
        ($d:literal: $($n:literal x $c:literal),*) => {
            match (shape.dofs, shape.contacts) {
                $((..=$n, ..=$c) => Ok(Box::new(Compiled::<T, $n, $d, $c>::default())),)*
                (n, c) => Err(format!("{n} dofs and {c} contacts: at most 30 and 12")),
            }
        };
    }
    match shape.dim {
        2 => sizes!(2: 6 x 4, 30 x 12),
        3 => sizes!(3: 6 x 4, 18 x 12, 30 x 12),
        dim => Err(format!("dim {dim} is not 2 or 3")),
    }
}

/// The kernel with a scene and the factor that a method needs; the smallest compiled size has to hold the scene.
pub fn prepared(kernel: Constructor, file: &SceneFile, method: Method) -> Result<Box<dyn Kernel>, Error> {
    let mut kernel = kernel(Shape::of(file)).expect("a size is compiled");
    kernel.load(file)?;
    kernel.prepare(method)?;
    Ok(kernel)
}
