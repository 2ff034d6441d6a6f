//! The methods of this crate.

use crate::contestant::{Contestant, Effort, Kind};
use stiction::{Error, Status};
use testbed::kernel::Kernel;
use testbed::method::Method;
use testbed::scene_file::SceneFile;
use testbed::solve::patient;

pub(crate) struct Library {
    method: Method,
    kernel: Box<dyn Kernel>,
}

impl Library {
    /// # Errors
    /// What the kernel refuses of the scene.
    pub(crate) fn new(mut kernel: Box<dyn Kernel>, file: &SceneFile, kind: Kind) -> Result<Self, Error> {
        let method = match kind {
            Kind::Plain => Method::Plain,
            Kind::Fast => Method::Fast,
            Kind::Restart => Method::Restart,
            _ => Method::Default,
        };
        kernel.load(file)?;
        kernel.prepare(method)?;
        Ok(Self { method, kernel })
    }
}

impl Contestant for Library {
    fn prepare(&mut self) {
        let prepared = self.kernel.prepare(self.method);
        prepared.expect("the scene was factorised before");
    }

    fn solve(&mut self, tolerance: f64) -> Effort {
        self.kernel.reset();
        let solved = self.kernel.solve(self.method, &patient(tolerance));
        solved.expect("f is finite");
        let (status, work) = self.kernel.outcome();
        Effort {
            iterations: work.total() - 10 * work.newton_steps,
            newton_steps: work.newton_steps,
            finished: status == Status::Solved,
        }
    }

    fn answer(&self) -> (Vec<f64>, Vec<f64>) {
        let answer = self.kernel.answer();
        (answer.v, answer.r)
    }
}
