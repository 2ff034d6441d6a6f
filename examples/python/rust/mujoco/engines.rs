//! Kernels of the islands, each of the smallest compiled size that holds what it has seen.

use super::creep::STICK;
use super::state::{Reader, Writer};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use stiction::{Settings, Status};
use stiction_kernels::engine::Engine;
use stiction_kernels::problem::{Answer, Needs, Outcome, Problem};
use stiction_kernels::sizes;

/// A rigid velocity is solved to this share of the tolerance, so that what rests is seen to rest and residuals do not add up; but to no less
/// than `FINE`, unless less is asked.
const FINER: f64 = 1e-3;
const FINE: f64 = 1e-9;
/// A refinement aims at this share of the speed up to which what sticks counts as still, at an error of no less than `FINEST`, and takes
/// this much work.
const STILLER: f64 = 0.1;
const FINEST: f64 = 1e-12;
const REFINING: usize = 20;

/// What an island's kernel is used for.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Pass {
    Velocity,
    Position,
}

/// How a problem is to be solved.
pub(super) struct Ask {
    /// Not from where the last solve ended?
    pub(super) cold: bool,
    /// What sticks moves no faster (m/s), as far as a little work can bring that about: the error counts a velocity by the lighter mass of a
    /// contact. A contact that opens or slips no faster bears as one that sticks.
    pub(super) still: f64,
    /// Asks for least impulses, where they may differ from those at which a solve ends: with at least as many unknown impulses as so many
    /// velocities, but for two, some may be internal.
    pub(super) least: Option<usize>,
}

/// How fast a contact moves that sticks, at most (m/s), along the rows that do not give way.
fn slip(answer: &Answer<f64>, problem: &Problem<'_, f64>) -> f64 {
    let contacts = answer.u.chunks_exact(problem.dim).zip(&answer.modes).enumerate();
    let sticking = contacts.filter(|&(_, (_, &mode))| mode == STICK);
    sticking.fold(0.0, |most, (i, (u, _))| {
        let soft = |row: usize| problem.compliance.get(2 * i + row.min(1)).is_some_and(|&soft| soft > 0.0);
        let rigid = u.iter().take(3).enumerate().filter(|&(row, _)| !soft(row));
        rigid.fold(most, |most, (_, u)| most.max(u.abs()))
    })
}

/// Rows of contacts that push and joint rows that hold: their impulses are unknown.
fn unknowns(answer: &Answer<f64>, dim: usize) -> usize {
    let contacts = answer.modes.iter().filter(|&&mode| mode != 0).count();
    let rows = answer.row_modes.iter().filter(|&&mode| mode == 1 || mode == 4).count();
    dim * contacts + rows
}

struct Slot {
    needs: Needs,
    index: usize,
    engine: Box<dyn Engine<f64>>,
}

/// Kernels, by the first velocity of their island.
#[derive(Default)]
pub(super) struct Engines(HashMap<(usize, Pass), Slot>);

impl Engines {
    /// Solves a problem from where the island's last solve ended. `None` if no compiled size holds it, or its numbers are out of range.
    pub(super) fn solve(
        &mut self,
        (island, pass): (usize, Pass),
        problem: &Problem<'_, f64>,
        settings: &Settings<f64>,
        Ask { cold, still, least }: Ask,
        answer: &mut Answer<f64>,
    ) -> Option<Outcome> {
        let now = problem.needs();
        let place = self.0.entry((island, pass));
        let mut needs = now;
        if let Entry::Occupied(slot) = &place {
            let seen = slot.get().needs;
            if seen.n == now.n && seen.dim == now.dim {
                needs.contacts = needs.contacts.max(seen.contacts);
                needs.rows = needs.rows.max(seen.rows);
                needs.surfaces |= seen.surfaces;
            }
        }
        let index = sizes::index::<f64>(&needs).ok()?;
        let slot = match place {
            Entry::Occupied(slot) if slot.get().index == index => slot.into_mut(),
            place => {
                let mut engine = sizes::engine(index);
                if let Entry::Occupied(slot) = &place {
                    engine.set_warm_start(&slot.get().engine.warm_start());
                }
                let slot = Slot { needs, index, engine };
                place.insert_entry(slot).into_mut()
            }
        };
        slot.needs = needs;
        if cold {
            slot.engine.reset();
        }
        slot.engine.load(problem).ok()?;
        let is_rigid = pass == Pass::Velocity && problem.compliance.is_empty();
        let aim = if is_rigid { (FINER * settings.tolerance).max(FINE) } else { f64::INFINITY };
        let within = |tolerance: f64| Settings { tolerance: tolerance.min(settings.tolerance), ..*settings };
        let mut outcome = slot.engine.solve(&within(aim), false).ok()?;
        if matches!(outcome.status, Status::OutOfBudget | Status::PrecisionLimit)
            && outcome.error <= settings.tolerance
        {
            outcome.status = Status::Solved;
        }
        let sizes = [problem.n, problem.contacts(), problem.dim, problem.rows.lower.len()];
        slot.engine.read(&mut answer.out(sizes));
        let aim = (outcome.error * STILLER * still / slip(answer, problem)).max(FINEST);
        if outcome.status == Status::Solved && outcome.error > aim {
            let finer = slot.engine.solve(&Settings { budget: REFINING, ..within(aim) }, false).ok()?;
            outcome.add(&finer.work);
            if finer.error <= settings.tolerance {
                slot.engine.read(&mut answer.out(sizes));
                outcome.error = finer.error;
            }
        }
        if let Some(dofs) = least
            && outcome.status == Status::Solved
            && unknowns(answer, problem.dim) + 3 > dofs
        {
            slot.engine.read_least(&Settings { still, ..*settings }, &mut answer.out(sizes));
        }
        Some(outcome)
    }

    /// Writes where solves start. From here on they go on as those of an engine that starts there.
    pub(super) fn write(&mut self, out: &mut Writer) {
        let mut slots: Vec<_> = self.0.iter_mut().collect();
        slots.sort_unstable_by_key(|&(&(island, pass), _)| (island, pass == Pass::Position));
        out.count(slots.len());
        for ((island, pass), Slot { needs, engine, .. }) in slots {
            out.count(*island);
            let flags = [*pass == Pass::Position, needs.surfaces].map(u64::from);
            out.words(flags);
            out.words([needs.n, needs.dim, needs.contacts, needs.rows].map(|count| count as u64));
            let start = engine.warm_start();
            engine.set_warm_start(&start);
            out.block(&start);
        }
    }

    /// Takes them over; `None` if these are none.
    pub(super) fn read(words: &mut Reader<'_>) -> Option<Self> {
        let mut slots = HashMap::new();
        for _ in 0..words.count()? {
            let island = words.count()?;
            let pass = if words.word()? == 0 { Pass::Velocity } else { Pass::Position };
            let surfaces = words.word()? != 0;
            let [n, dim, contacts, rows] = [words.count()?, words.count()?, words.count()?, words.count()?];
            let needs = Needs { n, dim, contacts, rows, surfaces };
            let index = sizes::index::<f64>(&needs).ok()?;
            let mut engine = sizes::engine(index);
            engine.set_warm_start(&words.block()?).then_some(())?;
            slots.insert((island, pass), Slot { needs, index, engine });
        }
        Some(Self(slots))
    }

    /// Forgets the last solves, and how large they were.
    pub(super) fn reset(&mut self) {
        for slot in self.0.values_mut() {
            slot.engine.reset();
            slot.needs = Needs::default();
        }
    }

    /// Forgets the last solve of an island.
    pub(super) fn forget(&mut self, island: usize) {
        if let Some(slot) = self.0.get_mut(&(island, Pass::Velocity)) {
            slot.engine.reset();
        }
    }
}
