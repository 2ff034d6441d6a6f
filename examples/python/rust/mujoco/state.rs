//! What the next step takes from those before it, as words.

use super::engines::Engines;
use super::locks::{Locks, Name};
use super::stepper::Stepper;
use super::touch::{Face, Live};
use nalgebra::Vector3;
use std::collections::HashMap;

/// Words of a state on the way back, one after the other.
pub(super) struct Reader<'a>(&'a [u64]);

impl Reader<'_> {
    pub(super) fn word(&mut self) -> Option<u64> {
        self.0.split_off_first().copied()
    }

    pub(super) fn number(&mut self) -> Option<f64> {
        self.word().map(f64::from_bits)
    }

    pub(super) fn numbers<const K: usize>(&mut self) -> Option<[f64; K]> {
        let mut numbers = [0.0; K];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Some(numbers)
    }

    /// A key, or a number of steps.
    pub(super) fn small(&mut self) -> Option<u32> {
        u32::try_from(self.word()?).ok()
    }

    /// A count, or the place of something.
    pub(super) fn count(&mut self) -> Option<usize> {
        usize::try_from(self.word()?).ok()
    }

    /// As many words as the next one says.
    pub(super) fn block(&mut self) -> Option<Vec<u64>> {
        let count = self.count()?;
        self.0.split_off(..count).map(<[u64]>::to_vec)
    }

    pub(super) fn vector(&mut self) -> Option<Vector3<f64>> {
        self.numbers().map(Vector3::from)
    }
}

/// Words of a state.
#[derive(Default)]
pub(super) struct Writer(Vec<u64>);

impl Writer {
    pub(super) fn word(&mut self, word: u64) {
        self.0.push(word);
    }

    pub(super) fn words(&mut self, words: impl IntoIterator<Item = u64>) {
        self.0.extend(words);
    }

    pub(super) fn count(&mut self, count: usize) {
        self.0.push(count as u64);
    }

    pub(super) fn numbers<'a>(&mut self, numbers: impl IntoIterator<Item = &'a f64>) {
        self.0.extend(numbers.into_iter().map(|number| number.to_bits()));
    }

    pub(super) fn block(&mut self, words: &[u64]) {
        self.count(words.len());
        self.0.extend_from_slice(words);
    }
}

/// The numbers of velocities, bodies of motion capture and geoms: a state is of a model with these.
fn sizes(stepper: &Stepper) -> [usize; 3] {
    let sizes = &stepper.model.sizes;
    [sizes.velocities, sizes.mocaps, sizes.geoms]
}

/// Writes the state. From here on the stepper goes on as one that takes it over.
pub(super) fn write(stepper: &mut Stepper) -> Vec<u64> {
    let mut out = Writer::default();
    out.words(sizes(stepper).map(|size| size as u64));
    stepper.follower.write(&mut out);
    let mut blocked: Vec<_> = stepper.velocity_pass.blocked.iter().collect();
    blocked.sort_unstable();
    out.count(blocked.len());
    for (&island, &steps) in blocked {
        out.count(island);
        out.word(steps.into());
    }
    write_locks(&stepper.position_pass.locks, &mut out);
    out.word(stepper.next_key.into());
    out.count(stepper.live.len());
    for Live { key, face: Face { geoms, normal }, places, crept, bears } in &stepper.live {
        out.words([*key, (*bears).into()].map(u64::from));
        out.words(geoms.map(|geom| geom as u64));
        out.numbers([normal, &places[0], &places[1], crept].into_iter().flatten());
    }
    stepper.engines.write(&mut out);
    out.0
}

/// Takes a state over, of the data of this address; `None` if it is none of this model.
pub(super) fn read(stepper: &mut Stepper, place: usize, words: &[u64]) -> Option<()> {
    let mut words = Reader(words);
    for size in sizes(stepper) {
        (words.count()? == size).then_some(())?;
    }
    let follower = stepper.follower.read(&stepper.model, place, &mut words)?;
    let mut blocked = HashMap::new();
    for _ in 0..words.count()? {
        blocked.insert(words.count()?, words.small()?);
    }
    let locks = read_locks(&mut words)?;
    let (next_key, mut live) = (words.small()?, Vec::new());
    let geoms = stepper.model.sizes.geoms;
    for _ in 0..words.count()? {
        let (key, bears, own) = (words.small()?, words.small()? != 0, [words.count()?, words.count()?]);
        own.iter().all(|&geom| geom < geoms).then_some(())?;
        let (normal, places) = (words.vector()?, [words.vector()?, words.vector()?]);
        live.push(Live { key, face: Face { geoms: own, normal }, places, crept: words.vector()?, bears });
    }
    let engines = Engines::read(&mut words)?;
    words.0.is_empty().then_some(())?;
    (stepper.follower, stepper.next_key, stepper.live) = (follower, next_key, live);
    stepper.engines = engines;
    (stepper.velocity_pass.blocked, stepper.position_pass.locks) = (blocked, locks);
    Some(())
}

fn write_locks(Locks(locks): &Locks, out: &mut Writer) {
    let mut locks: Vec<_> = locks.iter().collect();
    locks.sort_unstable();
    out.count(locks.len());
    for (&name, &steps) in locks {
        let words = match name {
            Name::Touch(key) => [0, key],
            Name::Row(key) => [1, key],
        };
        out.words(words.into_iter().chain([steps]).map(u64::from));
    }
}

fn read_locks(words: &mut Reader<'_>) -> Option<Locks> {
    let mut locks = HashMap::new();
    for _ in 0..words.count()? {
        let (kind, key) = (words.word()?, words.small()?);
        let name = if kind == 0 { Name::Touch(key) } else { Name::Row(key) };
        locks.insert(name, words.small()?);
    }
    Some(Locks(locks))
}
