//! The second field of scenes: drawn and pushed ones that no constant was tuned on.

use crate::contestant::Id;
use crate::measure::Patience;
use crate::progress::Progress;
use crate::race::{LEVELS, Race};
use crate::tables::DOUBLE;
use std::path::Path;
use testbed::generate::{self, Class, Existence};
use testbed::scene_file::SceneFile;

/// The error that shows that a scene has a solution. In one that has none impulses may grow for ever, and the error falls as they
/// do, to 1e-8 before they are out of bounds.
const ENOUGH: f64 = LEVELS[2];

/// Scenes of the campaign's drawn classes, in turns.
fn scenes(seed: u64, count: usize) -> impl Iterator<Item = (SceneFile, Existence)> {
    let classes = Class::DRAWN.iter().cycle().take(count);
    let numbered = (0..).zip(classes);
    numbered.map(move |(index, &class)| generate::draw(class, seed, index))
}

/// Writes them as scene files.
pub(crate) fn write(folder: &Path, seed: u64, count: usize) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    for (scene, _) in scenes(seed, count) {
        let file = folder.join(format!("{}.json", scene.name));
        std::fs::write(file, scene.json())?;
    }
    Ok(())
}

/// The races on them.
pub(crate) struct Drawn {
    pub(crate) races: Vec<Race>,
    seed: u64,
    /// Scenes of which nobody knows whether they have a solution, and none was found.
    left_out: usize,
}

impl Drawn {
    pub(crate) fn new(seed: u64, count: usize, patience: &Patience) -> Self {
        let mut progress = Progress::new("drawn scene", count);
        let mut drawn = Self { races: Vec::new(), seed, left_out: 0 };
        for (scene, existence) in scenes(seed, count) {
            progress.step(&scene.name);
            let race = Race::new(scene, patience);
            let solved = |id: &Id| race.time(*id, ENOUGH, false).is_some();
            if existence == Existence::Guaranteed || Id::ALL.iter().any(solved) {
                drawn.races.push(race);
            } else {
                drawn.left_out += 1;
            }
        }
        drawn
    }

    /// The races on scenes of a class.
    pub(crate) fn of(&self, class: Class) -> Vec<&Race> {
        let prefix = format!("{class:?}[");
        let races = self.races.iter();
        races.filter(|race| race.scene.name.starts_with(&prefix)).collect()
    }

    /// The races on scenes with one contact.
    pub(crate) fn of_one_contact(&self) -> Vec<&Race> {
        let races = self.races.iter();
        races.filter(|race| race.scene.n_contacts == 1).collect()
    }

    /// The races on scenes whose contacts all open.
    pub(crate) fn of_no_touch(&self) -> Vec<&Race> {
        let apart = |race: &&Race| {
            let rung = race.run(DOUBLE).and_then(|run| run.fastest(ENOUGH));
            rung.is_some_and(|rung| rung.closed == 0)
        };
        self.races.iter().filter(apart).collect()
    }

    /// "300 scenes of seed 2 in turns of the classes ..."
    pub(crate) fn describe(&self) -> String {
        let classes: Vec<String> = Class::DRAWN.iter().map(|class| format!("`{class:?}`")).collect();
        format!(
            "{} scenes of seed {} of the campaign's classes {} in turns. {} more are left out, of which nobody knows whether \
             they have a solution, and that no contestant solves to {:e}.",
            self.races.len(),
            self.seed,
            classes.join(", "),
            self.left_out,
            ENOUGH
        )
    }
}
