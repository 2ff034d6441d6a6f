//! The anytime promise: within any budget all phases do about as well as sweeps alone, and more budget makes nothing worse.

use crate::support::balancer::{self, balance};
use crate::support::check::{self, Tally, USABLE};
use crate::support::gripper::hold;
use crate::support::random::{draws, numbers};
use nalgebra::SVector;
use stiction::{AllPhases, Error, JointRow, Kernel, Phases, Real, Settings, Solution, SweepsOnly};
use testbed::format;
use testbed::generate::{self, Class};
use testbed::mixed::MixedFile;
use testbed::scene_file::{SceneFile, bundled_scenes, json_files, repository};

/// The size of all scenes, with and without joint rows: that of [`testbed::mixed::solve`], compiled anyway.
const N: usize = 30;
const C: usize = 12;
const R: usize = 36;

type Tested<T, P> = Kernel<T, N, 3, C, R, C, P>;

const BUDGETS: [usize; 5] = [10, 20, 50, 100, 200];

/// A scene of contacts alone, or with joint rows.
enum Case {
    Contacts(SceneFile),
    Rows(MixedFile),
}

impl Case {
    fn fits(&self) -> bool {
        let (dim, dofs, contacts, rows) = match self {
            Self::Contacts(file) => (file.dim, file.n_dof, file.n_contacts, 0),
            Self::Rows(file) => (file.dim, file.n_dof, file.n_contacts, file.joints.len()),
        };
        dim == 3 && dofs <= N && contacts <= C && rows <= R
    }

    fn name(&self) -> &str {
        match self {
            Self::Contacts(file) => &file.name,
            Self::Rows(file) => &file.name,
        }
    }

    /// Fills the scene of a kernel: the free impulse, and the limits.
    fn fill<T: Real, P: Phases>(
        &self,
        kernel: &mut Tested<T, P>,
    ) -> Result<(SVector<T, N>, Vec<JointRow<T, N>>), Error> {
        let scene = kernel.scene_mut();
        scene.clear();
        match self {
            Self::Contacts(file) => {
                let plain = file.scene::<T, N, 3, C>()?;
                scene.set_velocities(file.n_dof)?;
                scene.set_mass(plain.mass())?;
                for contact in plain.contacts() {
                    scene.push(contact)?;
                }
                Ok((file.free_impulse(), Vec::new()))
            }
            Self::Rows(file) => Ok((file.free_impulse(), file.fill(scene)?)),
        }
    }

    /// The solution of a solver that knows nothing, or the solution to a free impulse that was a little different.
    fn solve<'a, T: Real, P: Phases>(
        &self,
        kernel: &'a mut Tested<T, P>,
        settings: &Settings<T>,
        other: Option<&[f64]>,
    ) -> Result<&'a Solution<T, N, 3, C, R>, Error> {
        kernel.solver_mut().reset();
        let (push, limits) = self.fill(kernel)?;
        if let Some(noise) = other {
            let other = SVector::from_fn(|i, _| push[i] * T::literal(1.0 + 0.05 * noise[i]));
            kernel.solve_with_limits(&limits, &other, settings)?;
        }
        kernel.solve_with_limits(&limits, &push, settings)
    }
}

/// Bundled scenes and drawn ones, of contacts alone and with joint rows.
fn cases() -> [(&'static str, Vec<Case>); 2] {
    let drawn = Class::DRAWN.iter().flat_map(|&class| generate::solvable(class, 60));
    let contacts = bundled_scenes().into_iter().chain(drawn).map(Case::Contacts);
    let bundled = json_files(&repository().join("tests/mixed"));
    let bundled = bundled.iter().flat_map(|path| format::read(path).expect("it can be read"));
    let drawn = (0..120)
        .map(|index| MixedFile { name: format!("mixed[{index}]"), ..generate::mixed(1, index, false) });
    let rows = bundled.chain(drawn).map(Case::Rows);
    [("contacts", contacts.filter(Case::fits).collect()), ("rows", rows.filter(Case::fits).collect())]
}

/// Cold and warm solves within each budget.
fn tallies<T: Real, P: Phases>(phases: P, cases: &[Case], tolerance: f64) -> Result<[[Tally; 2]; 5], Error> {
    let mut kernel = Box::new(Tested::<T, P>::with_phases(phases));
    let mut tallies = [[Tally::default(); 2]; 5];
    for (case, noise) in cases.iter().zip(draws(numbers(N), cases.len())) {
        for (budget, [cold, warm]) in BUDGETS.into_iter().zip(&mut tallies) {
            let settings = Settings { budget, ..Settings::new(T::literal(tolerance)) };
            cold.add(case.solve(&mut kernel, &settings, None)?);
            warm.add(case.solve(&mut kernel, &settings, Some(&noise))?);
        }
    }
    Ok(tallies)
}

/// What all phases promise within a budget.
struct Promise {
    /// Are cold solves compared with sweeps, too?
    cold: bool,
    /// Percent of what sweeps solve that is solved.
    solved: usize,
    /// More solutions than those of sweeps may be unusable.
    unusable: usize,
    /// More warm solves than cold ones may be unusable or unsolved.
    warm: usize,
}

impl Promise {
    /// What tallies, cold and warm, of all phases and of sweeps break.
    fn broken(&self, what: &str, all: [Tally; 2], sweeps: [Tally; 2]) -> Vec<String> {
        println!("{what}: all phases {all:?}, sweeps {sweeps:?}");
        let mut broken = Vec::new();
        let mut holds = |part: &str, is_true: bool| {
            if !is_true {
                broken.push(format!("{what}: {part}"));
            }
        };
        for (start, all, sweeps) in [("cold", all[0], sweeps[0]), ("warm", all[1], sweeps[1])] {
            if self.cold || start == "warm" {
                holds(&format!("{start}, unusable"), all.unusable <= sweeps.unusable + self.unusable);
                holds(&format!("{start}, solved"), 100 * all.solved >= self.solved * sweeps.solved);
            }
        }
        for (phases, [cold, warm], more) in [("all phases", all, self.warm), ("sweeps", sweeps, 0)] {
            holds(&format!("{phases}, warm, unusable"), warm.unusable <= cold.unusable + more);
            holds(&format!("{phases}, warm, solved"), warm.solved + more >= cold.solved);
        }
        broken
    }
}

fn none_of(broken: &[String]) {
    assert!(broken.is_empty(), "\n{}", broken.join("\n"));
}

/// Two in a hundred scenes more than of sweeps may be unusable; from a budget of 50 on as many are solved.
fn compare<T: Real>(tolerance: f64) -> Result<(), Error> {
    let mut broken = Vec::new();
    for (kind, cases) in cases() {
        let all = tallies::<T, _>(AllPhases, &cases, tolerance)?;
        let sweeps = tallies::<T, _>(SweepsOnly, &cases, tolerance)?;
        for ((budget, all), sweeps) in BUDGETS.into_iter().zip(all).zip(sweeps) {
            let solved = if budget < 50 { 0 } else { 100 };
            let promise = Promise { cold: true, solved, unusable: cases.len() / 50, warm: 0 };
            let what = format!("{} of {kind} to {tolerance:e} within {budget}", cases.len());
            broken.extend(promise.broken(&what, all, sweeps));
        }
    }
    none_of(&broken);
    Ok(())
}

#[test]
fn all_phases_do_as_well_as_sweeps_in_single_precision() -> Result<(), Error> {
    compare::<f32>(1e-4)
}

#[test]
fn all_phases_do_as_well_as_sweeps_in_double_precision() -> Result<(), Error> {
    compare::<f64>(1e-6)
}

/// Scenes that more budget makes worse: they are solved no more, have no answer any more, or more than twice the error.
///
/// An answer is usable, or a proof.
fn worse<T: Real>(cases: &[Case], tolerance: f64) -> Result<[usize; 3], Error> {
    let mut kernel = Box::new(Tested::<T, AllPhases>::new());
    let mut worse = [0; 3];
    for case in cases {
        let (mut best, mut least) = ([false; 2], f64::INFINITY);
        let mut is_worse = [false; 3];
        for budget in [10, 15, 20, 30, 50, 70, 100, 150, 200, 300, 500, 700, 1_000] {
            let settings = Settings { budget, ..Settings::new(T::literal(tolerance)) };
            let solution = case.solve(&mut kernel, &settings, None)?;
            let is_proof = check::is_proof(solution.status);
            let error = solution.error.to_subset().unwrap_or(f64::INFINITY).max(tolerance);
            let now = [solution.is_solved(), is_proof || solution.is_usable(T::literal(USABLE))];
            let is_larger = !is_proof && error > 2.0 * least;
            let lost = [best[0] && !now[0], best[1] && !now[1], is_larger];
            if lost.contains(&true) {
                let (name, status) = (case.name(), solution.status);
                println!("{name} within {budget}: {status}, {error:.1e} after {least:.1e}");
            }
            is_worse = [0, 1, 2].map(|k| is_worse[k] || lost[k]);
            best = [0, 1].map(|k| best[k] || now[k]);
            least = if is_proof { least } else { least.min(error) };
        }
        worse = [0, 1, 2].map(|k| worse[k] + usize::from(is_worse[k]));
    }
    println!("{} to {tolerance:e}: worse {worse:?}", cases.len());
    Ok(worse)
}

/// The error of what has no answer may rise, in three of a thousand scenes: it does in one of 463 in each precision. Both jam. In `f32` the
/// impulses of one grow from 170 to 650,000, of an infinite error; in `f64` the other reaches one more limit, which makes it another scene.
#[test]
fn more_budget_makes_nothing_worse() -> Result<(), Error> {
    let cases = cases().map(|(_, cases)| cases).into_iter().flatten().collect::<Vec<_>>();
    for [solved, answered, error] in [worse::<f32>(&cases, 1e-4)?, worse::<f64>(&cases, 1e-6)?] {
        assert_eq!([solved, answered], [0, 0]);
        assert!(1_000 * error <= 3 * cases.len(), "{error} of {}", cases.len());
    }
    Ok(())
}

/// Within 50 all phases solve 1,895 warm ticks of 2,600, where sweeps solve 2,026. Cold ticks are not compared: there 164 are unusable, and one of
/// sweeps. Warm, one tick in a thousand may be unusable: within 100 one is at the threshold, and a leg that is stronger by 1e-5 takes it to
/// either side.
#[test]
fn a_balancer_keeps_its_balance_within_any_budget() -> Result<(), Error> {
    let mut broken = Vec::new();
    for (budget, solved) in BUDGETS.into_iter().zip([0, 0, 90, 100, 100]) {
        let all = [balance(AllPhases, budget, true)?, balance(AllPhases, budget, false)?];
        let sweeps = [balance(SweepsOnly, budget, true)?, balance(SweepsOnly, budget, false)?];
        let promise =
            Promise { cold: false, solved, unusable: balancer::TICKS / 50, warm: balancer::TICKS / 1_000 };
        broken.extend(promise.broken(&format!("balancer within {budget}"), all, sweeps));
    }
    none_of(&broken);
    Ok(())
}

/// Forces of the relaxed law. Here sweeps are better within 20, where one tick in ten more is unusable, and within 50 a warm start costs what one
/// tick in six would be solved with.
#[test]
fn a_gripper_holds_within_any_budget() -> Result<(), Error> {
    let mut all = Box::new(Tested::<f32, _>::with_phases(AllPhases));
    let mut sweeps = Box::new(Tested::<f32, _>::with_phases(SweepsOnly));
    let mut broken = Vec::new();
    for (budget, unusable, warm) in [(10, 40, 0), (20, 200, 0), (50, 40, 370), (100, 0, 10), (200, 0, 0)] {
        let all = [hold(&mut all, budget, true)?, hold(&mut all, budget, false)?];
        let sweeps = [hold(&mut sweeps, budget, true)?, hold(&mut sweeps, budget, false)?];
        let promise = Promise { cold: false, solved: 100, unusable, warm };
        broken.extend(promise.broken(&format!("gripper within {budget}"), all, sweeps));
    }
    none_of(&broken);
    Ok(())
}
