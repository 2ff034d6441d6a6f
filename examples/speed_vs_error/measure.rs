//! The race on one scene: every contestant at every tolerance, in turns.
//!
//! A first pass finds the error really reached and where the ladder of tolerances ends for each
//! contestant: after the first rung that its own stopping test does not meet. Then all of them take
//! turns, so that a slow moment of the machine hits all alike; each visit repeats its call for some
//! twenty microseconds, with the data and the code at hand, as in a control loop.

use crate::contestant::{Contestant, Effort, Id};
use std::time::Instant;
use testbed::measure::{self, Law};
use testbed::scene_file::SceneFile;

/// A contestant under its name.
pub(crate) type Entry = (Id, Box<dyn Contestant>);

/// Of one call, in ns, over the visits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Time {
    pub(crate) least: f64,
    pub(crate) median: f64,
}

/// One rung of the ladder.
#[derive(Clone, Debug)]
pub(crate) struct Rung {
    /// Recomputed in f64 from the scene as given.
    pub(crate) error: f64,
    pub(crate) effort: Effort,
    /// Contacts with an impulse.
    pub(crate) closed: usize,
    pub(crate) time: Time,
}

/// One contestant on one scene.
pub(crate) struct Run {
    pub(crate) id: Id,
    pub(crate) prepare: Time,
    pub(crate) rungs: Vec<Rung>,
}

impl Run {
    /// The fastest rung whose error really is at most this.
    pub(crate) fn fastest(&self, error: f64) -> Option<&Rung> {
        let reached = self.rungs.iter().filter(|rung| rung.error <= error);
        reached.min_by(|a, b| a.time.least.total_cmp(&b.time.least))
    }
}

/// One thing to time: a preparation, or a solve to a tolerance.
struct Task {
    contestant: usize,
    tolerance: Option<f64>,
    calls: usize,
    visits: usize,
    times: Vec<f64>,
}

impl Task {
    fn visit(&mut self, contestants: &mut [Entry]) {
        let contestant = &mut contestants[self.contestant].1;
        let mut call = || match self.tolerance {
            Some(tolerance) => _ = contestant.solve(tolerance),
            None => contestant.prepare(),
        };
        if self.calls > 1 {
            call();
        }
        let start = Instant::now();
        for _ in 0..self.calls {
            call();
        }
        self.times.push(start.elapsed().as_secs_f64() * 1e9 / self.calls as f64);
    }

    /// How often to call so that a visit lasts 20 µs, and to visit so that all take `budget` ns.
    fn plan(&mut self, contestants: &mut [Entry], patience: &Patience) {
        (self.calls, self.visits) = (2, 1);
        self.visit(contestants);
        let time = self.times.drain(..).fold(0.0, f64::max);
        self.calls = (20e3 / time).clamp(1.0, 100.0) as usize;
        let visit = time * self.calls as f64;
        self.visits = (patience.budget / visit).clamp(3.0, patience.visits as f64) as usize;
    }

    fn time(&self) -> Time {
        let mut times = self.times.clone();
        times.sort_unstable_by(f64::total_cmp);
        Time { least: times[0], median: times[times.len() / 2] }
    }
}

/// How long to measure.
pub(crate) struct Patience {
    /// Largest number of visits.
    pub(crate) visits: usize,
    /// ns for one task, beyond three visits.
    pub(crate) budget: f64,
}

/// Races contestants on a scene, each down the tolerances as far as it gets.
pub(crate) fn race(
    scene: &SceneFile,
    mut contestants: Vec<Entry>,
    tolerances: &[f64],
    patience: &Patience,
) -> Vec<Run> {
    let mut tasks = Vec::new();
    let mut reached: Vec<Vec<(f64, Effort, usize)>> = Vec::new();
    let task = |contestant, tolerance| Task { contestant, tolerance, calls: 1, visits: 0, times: Vec::new() };
    for (index, (_, contestant)) in contestants.iter_mut().enumerate() {
        contestant.prepare();
        tasks.push(task(index, None));
        let mut rungs = Vec::new();
        for &tolerance in tolerances {
            let effort = contestant.solve(tolerance);
            let (v, r) = contestant.answer();
            let error = measure::error(scene, &v, &r, Law::Coulomb);
            let closed = r.chunks_exact(scene.dim).filter(|r| r[0] > 0.0).count();
            rungs.push((error, effort, closed));
            tasks.push(task(index, Some(tolerance)));
            if !effort.finished {
                break;
            }
        }
        reached.push(rungs);
    }
    for task in &mut tasks {
        task.plan(&mut contestants, patience);
    }
    for visit in 0..patience.visits {
        for task in tasks.iter_mut().filter(|task| visit < task.visits) {
            task.visit(&mut contestants);
        }
    }
    let mut times = tasks.iter().map(Task::time);
    let mut next = || times.next().expect("a time for every task");
    let runs = contestants.iter().zip(reached).map(|(entry, rungs)| Run {
        id: entry.0,
        prepare: next(),
        rungs: rungs
            .into_iter()
            .map(|(error, effort, closed)| Rung { closed, error, effort, time: next() })
            .collect(),
    });
    runs.collect()
}
