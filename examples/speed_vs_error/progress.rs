//! Says on stderr what is being measured, and how far it is.

use std::time::Instant;

pub(crate) struct Progress {
    what: &'static str,
    done: usize,
    steps: usize,
    start: Instant,
}

impl Progress {
    pub(crate) fn new(what: &'static str, steps: usize) -> Self {
        Self { what, done: 0, steps, start: Instant::now() }
    }

    /// Announces the next step.
    pub(crate) fn step(&mut self, name: &str) {
        self.done += 1;
        let Self { what, done, steps, .. } = self;
        let seconds = self.start.elapsed().as_secs_f64();
        eprintln!("{what} {done:>2}/{steps}, {seconds:>4.0} s: {name}");
    }
}
