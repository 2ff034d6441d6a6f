//! Hard scenes, drawn at random and reproducible: class, seed and index give the same scene on
//! every machine.

mod bodies;
mod generic;
mod random;
mod several;
mod single;
mod units;

use crate::scene_file::SceneFile;
use nalgebra::DVector;
use random::Random;

/// What makes a scene hard.
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
}

impl Class {
    pub const ALL: [Self; 15] = [
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
    ];
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
        let existence = if in_dual_cone {
            Existence::Guaranteed
        } else {
            Existence::Unknown
        };
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
        Class::Scaled => {
            let others = Class::ALL.map(|other| match other {
                Class::Scaled => Class::Stack,
                other => other,
            });
            let base = random.pick(&others);
            let (scene, existence) = draw_from(random, base);
            return (units::change(random, &scene), existence);
        }
    };
    candidate.existence()
}
