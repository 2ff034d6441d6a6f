//! Hard scenes, drawn at random and reproducible: class, seed and index give the same scene on
//! every machine.
//!
//! Odd seeds are for looking: constants are tuned on their scenes, and single scenes taken apart. Even seeds are for
//! deciding: what is said of the method in the end, of scenes that nobody has looked at. The classes of [`Class::HARD`] were
//! made to break a solver, and the method grew up on them; those of [`Class::DRAWN`] came after it.

mod bodies;
mod drawn;
mod generic;
mod mixed;
mod parts;
mod pushed;
mod random;
mod robot;
mod several;
mod single;
mod units;

pub use mixed::{mixed, time_steps};

use crate::scene_file::SceneFile;
use nalgebra::DVector;
use random::Random;

/// What makes a scene hard, or what it is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Boxes on each other, masses up to 1e6 apart.
    Stack,
    /// A grasped object, masses up to 1e6 apart.
    Hand,
    /// Contacts that are the same or nearly parallel.
    Redundant,
    /// A box on a slope at the friction angle or next to it.
    Slope,
    /// Friction coefficients 0, 1e-6, 5 and 10 in one scene.
    MixedFriction,
    /// A sliding rod.
    Painleve,
    /// A body between inclined walls.
    Wedge,
    /// Moving belts, impacts, gaps.
    Moving,
    /// No free impulse.
    Unloaded,
    /// All contacts open.
    Open,
    /// One velocity.
    OneDof,
    /// A mass matrix of condition up to 1e10.
    NearSingular,
    /// A scene of another class in other units, entries from 1e-12 to 1e12.
    Scaled,
    /// Walls that leave a millionth of their speed between them.
    Narrow,
    /// Walls that close on a body.
    Squeeze,
    /// A box whose vertices touch planes of one direction or of several, friction up to 3.
    Box,
    /// Two to four bodies on each other, masses up to 1000 apart, in patches.
    Pile,
    /// An object between two to seven fingers with mass matrices like those of joints.
    Grasp,
    /// A floating base with two to five limbs of three joints.
    Robot,
    /// Dense matrices of any kind, and surfaces that move; a few scenes have no solution.
    Generic,
    /// A bundled scene with another free impulse, other friction, and maybe fewer contacts.
    Pushed,
}

impl Class {
    pub const ALL: [Self; 21] = [
        Self::Stack,
        Self::Hand,
        Self::Redundant,
        Self::Slope,
        Self::MixedFriction,
        Self::Painleve,
        Self::Wedge,
        Self::Moving,
        Self::Unloaded,
        Self::Open,
        Self::OneDof,
        Self::NearSingular,
        Self::Scaled,
        Self::Narrow,
        Self::Squeeze,
        Self::Box,
        Self::Pile,
        Self::Grasp,
        Self::Robot,
        Self::Generic,
        Self::Pushed,
    ];

    /// Those made to break a solver.
    pub const HARD: &[Self] = Self::ALL.split_at(15).0;

    /// Those of what is met, from one contact and none that touches to ten and two dozen velocities.
    pub const DRAWN: &[Self] = Self::ALL.split_at(15).1;
}

/// Whether Coulomb's law has a solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existence {
    /// Some velocity has `H v + w` in `K*`, the criterion of Acary and Cadoux.
    Guaranteed,
    /// No such velocity is known.
    Unknown,
    /// No velocity has `H_N v + w_N >= 0`.
    Infeasible,
}

/// A scene and the velocity that may show that it has a solution.
struct Candidate {
    scene: SceneFile,
    witness: DVector<f64>,
}

impl Candidate {
    /// Whether `H v + w` is in `K*` for the witness, up to rounding.
    fn existence(self) -> (SceneFile, Existence) {
        let Self { scene, witness } = self;
        let u = &scene.h * &witness + &scene.w;
        let rounding = 1e-13 * (scene.h.abs() * witness.abs() + scene.w.abs());
        let in_dual_cone = scene.mu.iter().enumerate().all(|(i, mu)| {
            let (normal, tangent) = (i * scene.dim, scene.dim - 1);
            let slip = u.rows(normal + 1, tangent).norm();
            let allowance = rounding.rows(normal, scene.dim).sum() * (1.0 + mu);
            mu * slip <= u[normal] + allowance
        });
        let existence = if in_dual_cone { Existence::Guaranteed } else { Existence::Unknown };
        (scene, existence)
    }
}

/// The scene `index` of a class.
pub fn draw(class: Class, seed: u64, index: u64) -> (SceneFile, Existence) {
    let mut random = Random::new(seed, index);
    let (mut scene, existence) = draw_from(&mut random, class);
    scene.name = format!("{class:?}[{index}]");
    (scene, existence)
}

/// Five time steps of a scene, of which nobody knows whether they have solutions: contacts come, go and change places.
#[must_use]
pub fn steps(class: Class, seed: u64, index: u64) -> (Vec<SceneFile>, Existence) {
    let (scene, _) = draw(class, seed, index);
    (mixed::steps_of(seed, index, &scene), Existence::Unknown)
}

/// The first `count` scenes of a class that surely have a solution.
pub fn solvable(class: Class, count: usize) -> impl Iterator<Item = SceneFile> {
    let draws = (0..).map(move |index| draw(class, 1, index));
    let solvable = draws.filter(|(_, existence)| *existence == Existence::Guaranteed);
    solvable.map(|(scene, _)| scene).take(count)
}

fn draw_from(random: &mut Random, class: Class) -> (SceneFile, Existence) {
    let candidate = match class {
        Class::Stack => several::stack(random),
        Class::Hand => several::hand(random),
        Class::Redundant if random.one_in(2) => single::redundant_slope(random),
        Class::Redundant => generic::repeated(random),
        Class::Slope => single::slope(random),
        Class::MixedFriction => generic::mixed_friction(random),
        Class::Painleve => single::painleve(random),
        Class::Wedge => single::wedge(random),
        Class::Moving => several::moving(random),
        Class::Unloaded => generic::unloaded(random),
        Class::Open => generic::open(random),
        Class::OneDof => generic::one_dof(random),
        Class::NearSingular => generic::near_singular(random),
        Class::Narrow => generic::narrow(random),
        Class::Squeeze => return generic::squeeze(random),
        Class::Box => drawn::free_box(random),
        Class::Pile => drawn::column(random),
        Class::Grasp => drawn::grasp(random),
        Class::Robot => robot::robot(random),
        Class::Generic => drawn::generic(random),
        Class::Pushed => pushed::pushed(random),
        Class::Scaled => {
            let base = match random.pick(Class::HARD) {
                Class::Scaled => Class::Stack,
                other => other,
            };
            let (scene, existence) = draw_from(random, base);
            return (units::change(random, &scene), existence);
        }
    };
    candidate.existence()
}
