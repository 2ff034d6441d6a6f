//! The methods of this crate.

use crate::contestant::{Contestant, Effort, Kind};
use crate::support::measure;
use crate::support::scene_file::SceneFile;
use crate::support::solve;
use nalgebra::SVector;
use std::hint::black_box;
use stiction::{AdmmSolver, Error, Factor, Real, Scene, Settings, Solver, Status};

pub(crate) struct Library<T, const N: usize, const D: usize, const C: usize> {
    method: Kind,
    n_dof: usize,
    /// Does a solve to 1e-6 do without the resolvent?
    spares_resolvent: bool,
    scene: Scene<T, N, D, C>,
    f: SVector<T, N>,
    factor: Factor<T, N, D, C>,
    solver: Solver<T, N, D, C>,
    admm: AdmmSolver<T, N, D, C>,
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Library<T, N, D, C> {
    /// # Errors
    /// What the kernel refuses of the scene.
    pub(crate) fn new(file: &SceneFile, method: Kind) -> Result<Box<Self>, Error> {
        let scene = file.scene()?;
        let f = file.free_impulse();
        let (mut factor, solver) = (Factor::empty(), Solver::new());
        let settings = Settings::new(T::literal(1e-6));
        let spares_resolvent = method == Kind::Default
            && solve::spares_resolvent(&scene, &mut factor, &solver, &f, &settings)?;
        factor.compute(&scene)?;
        Ok(Box::new(Self {
            method,
            n_dof: file.n_dof,
            spares_resolvent,
            f,
            scene,
            factor,
            solver,
            admm: AdmmSolver::new(),
        }))
    }
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Contestant for Library<T, N, D, C> {
    fn prepare(&mut self) {
        let scene = black_box(&self.scene);
        let computed = if self.spares_resolvent {
            self.factor.update(scene)
        } else {
            self.factor.compute(scene)
        };
        computed.expect("the scene was factorised before");
    }

    fn solve(&mut self, tolerance: f64) -> Effort {
        let settings = Settings::new(T::literal(tolerance));
        let (scene, factor) = (black_box(&self.scene), &self.factor);
        let f = black_box(&self.f);
        self.solver.reset();
        self.admm.reset();
        let solution = match self.method {
            Kind::Plain => self.admm.solve_plain(scene, factor, f, &settings),
            Kind::Fast => self.admm.solve_fast(scene, factor, f, &settings),
            Kind::Restart => self.admm.solve_restart(scene, factor, f, &settings),
            _ => self.solver.solve(scene, factor, f, &settings),
        };
        let solution = black_box(solution.expect("f is finite"));
        Effort {
            iterations: solution.iterations,
            newton_steps: solution.newton_steps,
            finished: solution.status == Status::Solved,
        }
    }

    fn answer(&self) -> (Vec<f64>, Vec<f64>) {
        let solution = match self.method {
            Kind::Default => self.solver.solution(),
            _ => self.admm.solution(),
        };
        let mut velocity = measure::velocity(solution);
        velocity.truncate(self.n_dof);
        (velocity, measure::impulses(solution))
    }
}
