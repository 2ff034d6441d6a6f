//! Trees among ground and each other, and their time step.

use crate::collide::{Point, collide};
use crate::tree::Tree;
use crate::{Base, Body, Failure, Joint};
use indicatif::{ProgressBar, ProgressStyle};
use nalgebra::{SVector, Vector3};
use parry3d_f64::math::Pose;
use std::path::Path;
use std::time::Instant;
use stiction::time_stepping::free_impulse;
use stiction::{ContactMode, ContactSolution, Error, Kernel, RowMode, Settings, Status, contact_frame};

/// Length of a step (s).
pub const STEP: f64 = 1e-3;

/// A world of `N` velocities in all, with room for `C` contacts and `R` joint rows: motors, joints that mimic others, and stops
/// that are reached at the same time.
pub struct World<const N: usize, const C: usize = 24, const R: usize = 32> {
    /// Friction coefficient of all that touches.
    pub mu: f64,
    /// How stiff rubber between all that touches is (N/m); infinite is rigid.
    pub stiffness: f64,
    /// Gains of each motor: of the position (N·m/rad, N/m), and of the velocity (N·m·s/rad, N·s/m).
    pub gains: [f64; 2],
    /// A body that is pushed at the origin of its link, and with which force (N).
    pub push: (usize, Vector3<f64>),
    /// What may touch: ground, and the shapes of all trees.
    pub bodies: Vec<Body>,
    /// Robots and things.
    pub trees: Vec<Tree>,
    /// Velocities of all trees, one after the other.
    pub velocity: SVector<f64, N>,
    pub(crate) kernel: Box<Kernel<f64, N, 3, C, R, C>>,
}

/// A contact that pushes.
pub struct Touch {
    /// The bodies.
    pub pair: [usize; 2],
    /// Where (m).
    pub place: Vector3<f64>,
    /// Force on the second body (N).
    pub force: Vector3<f64>,
    /// Its part along the normal (N).
    pub normal: f64,
    /// Its gap (m), negative in penetration.
    pub gap: f64,
    /// Speed along the surface (m/s).
    pub slip: f64,
    /// Whether it sticks or slips.
    pub mode: ContactMode,
}

/// What happened in a step.
pub struct Tick {
    /// Where the shapes of bodies were, and which line each joint makes from link to link.
    pub(crate) poses: Vec<Pose>,
    pub(crate) bones: Vec<[Vector3<f64>; 2]>,
    /// Where the world was pushed (m), and how (N).
    pub push: [Vector3<f64>; 2],
    /// Contacts that pushed.
    pub touches: Vec<Touch>,
    pub(crate) rows: Vec<RowMode>,
    /// Of dynamics, collision, contact (µs).
    pub(crate) cost: [f64; 3],
    /// Error of the solution (dimensionless).
    pub error: f64,
}

impl<const N: usize> World<N> {
    /// An empty world with a friction coefficient and the gains of all motors.
    #[must_use]
    pub fn new(mu: f64, gains: [f64; 2]) -> Self {
        Self::with_room(mu, gains)
    }
}

impl<const N: usize, const C: usize, const R: usize> World<N, C, R> {
    /// [`Self::new`] for other room.
    #[must_use]
    pub fn with_room(mu: f64, gains: [f64; 2]) -> Self {
        Self {
            mu,
            stiffness: f64::INFINITY,
            gains,
            push: (0, Vector3::zeros()),
            bodies: Vec::new(),
            trees: Vec::new(),
            velocity: SVector::zeros(),
            kernel: Box::new(Kernel::new()),
        }
    }

    /// Adds a block of ground between two corners (m).
    pub fn ground(&mut self, name: &str, from: [f64; 3], to: [f64; 3]) {
        self.bodies.push(Body::ground(name, from.into(), to.into()));
    }

    /// Adds a robot or a thing from a URDF file, with its root at a place (m).
    pub fn load(&mut self, file: &Path, base: Base, place: [f64; 3]) -> Result<(), Failure> {
        let (tree, bodies) = Tree::load(file, base)?;
        let passive = tree.passive().join(", ");
        if !passive.is_empty() {
            println!("{}: no motor (effort 0 or missing) at {passive}", file.display());
        }
        self.add(tree, bodies, place);
        Ok(())
    }

    /// Adds a tree and its bodies, with its root at a place (m).
    pub fn add(&mut self, mut tree: Tree, bodies: Vec<Body>, place: [f64; 3]) {
        tree.place = place.into();
        let index = self.trees.len();
        let owned = bodies.into_iter().map(|body| Body { tree: index, ..body });
        self.bodies.extend(owned);
        self.trees.push(tree);
    }

    /// How high the lowest point is of all shapes that are no ground (m); infinite if there is none.
    pub fn lowest(&mut self) -> Result<f64, Failure> {
        let poses = self.dynamics()?.poses;
        let owned = self.bodies.iter().zip(&poses).filter(|(body, _)| body.tree != Body::GROUND);
        Ok(owned.map(|(body, pose)| body.shape.compute_aabb(pose).mins.z).fold(f64::INFINITY, f64::min))
    }

    /// The joint of a name.
    pub fn joint(&mut self, name: &str) -> Result<&mut Joint, Failure> {
        let mut joints = self.trees.iter_mut().flat_map(|tree| &mut tree.joints);
        let found = joints.find(|joint| joint.name == name);
        found.ok_or_else(|| format!("there is no joint {name}").into())
    }

    /// The first body of a link of this name.
    pub fn body(&self, name: &str) -> Result<usize, Failure> {
        let found = self.bodies.iter().position(|body| body.name == name);
        found.ok_or_else(|| format!("there is no body {name}").into())
    }

    /// Tells the motor of a joint where to be after the next step (rad, m). One that has none, of effort 0, is refused.
    pub fn aim(&mut self, name: &str, angle: f64) -> Result<(), Failure> {
        let joint = self.joint(name)?;
        if joint.effort == 0.0 {
            let missing = "its effort is 0, or missing in the file's <limit>";
            let why = if joint.mimic.is_some() { "it mimics another joint" } else { missing };
            return Err(format!("joint {name} has no motor: {why}").into());
        }
        joint.target = [angle, (angle - joint.target[0]) / STEP];
        Ok(())
    }

    /// Lets `seconds` pass, with a progress bar; `control` aims and pushes before each step, which it is told the time of (s).
    pub fn run(
        &mut self,
        seconds: f64,
        mut control: impl FnMut(&mut Self, f64) -> Result<(), Failure>,
    ) -> Result<Vec<Tick>, Failure> {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let steps = (seconds / STEP).round() as u32;
        let style = ProgressStyle::with_template("{wide_bar} {pos} of {len} steps, {eta} left")?;
        let progress = ProgressBar::new(steps.into()).with_style(style);
        let mut ticks = Vec::new();
        for step in 0..steps {
            let time = f64::from(step) * STEP;
            control(self, time)?;
            let tick = self.step();
            ticks.push(tick.map_err(|error| format!("at {time:.3} s: {error}"))?);
            progress.inc(1);
        }
        progress.finish_and_clear();
        Ok(ticks)
    }

    /// One time step: dynamics, collisions, contacts and rows, their solution, new places.
    pub fn step(&mut self) -> Result<Tick, Failure> {
        let mut begin = Instant::now();
        let mut lap = || {
            let before = std::mem::replace(&mut begin, Instant::now());
            (begin - before).as_secs_f64() * 1e6
        };
        let dynamics = self.dynamics()?;
        if let Some(dof) = dynamics.without_inertia() {
            return Err(format!("{} moves no inertia: M is singular", self.velocity_name(dof)).into());
        }
        let dynamics_cost = lap();
        let points = collide(&self.bodies, &dynamics.poses, |body| dynamics.can_move(body))?;
        let collision_cost = lap();

        self.kernel.scene_mut().set_mass(&dynamics.mass)?;
        self.kernel.scene_mut().clear();
        self.push_contacts(&points, &dynamics)?;
        let stops = self.push_rows()?;
        let (pushed, push) = self.push;
        let linear = dynamics.jacobians[pushed].fixed_rows::<3>(3);
        let force = dynamics.force + linear.transpose() * push;
        let impulse = free_impulse(&dynamics.mass, &self.velocity, &force, STEP);
        let settings = Settings { budget: 100_000, ..Settings::new(1e-8) }; // nothing waits for a simulation
        let solution = self.kernel.solve_with_limits(&stops, &impulse, &settings)?;
        if !solution.is_usable(1e-3) {
            let (status, error) = (solution.status, solution.error);
            let culprits = self.culprits(&points);
            return Err(format!("{status}, error {error:.1e}: {culprits}").into());
        }

        let contacts = points.iter().zip(&solution.contacts);
        let pushing = contacts.filter(|(_, contact)| contact.mode != ContactMode::Open);
        let tick = Tick {
            rows: solution.rows.iter().map(|row| row.mode).collect(),
            touches: pushing.map(Touch::new).collect::<Result<_, _>>()?,
            push: [dynamics.origins[pushed], push],
            poses: dynamics.poses,
            bones: dynamics.bones,
            error: solution.error,
            cost: [dynamics_cost, collision_cost, lap()],
        };
        self.velocity = solution.velocity;
        let mut rest = self.velocity.as_slice();
        for tree in &mut self.trees {
            let (own, others) = rest.split_at(tree.size());
            tree.advance(own, STEP);
            rest = others;
        }
        Ok(tick)
    }
}

impl<const N: usize, const C: usize, const R: usize> World<N, C, R> {
    /// What a velocity moves, in words.
    fn velocity_name(&self, mut velocity: usize) -> String {
        for tree in &self.trees {
            if velocity < tree.size() {
                return tree.velocity_name(velocity);
            }
            velocity -= tree.size();
        }
        "nothing".into()
    }

    /// What the last solution, which is of no use, speaks of: the bodies and joints that exclude each other if that is proved,
    /// or else those that push.
    fn culprits(&self, points: &[Point]) -> String {
        let solution = self.kernel.solution();
        let proved = matches!(solution.status, Status::Infeasible | Status::Jammed);
        let speaks_of = |pushes: bool, part: Option<f64>| {
            if proved { part.is_some_and(|part| part != 0.0) } else { pushes }
        };
        let mut named = Vec::new();
        for (i, (point, contact)) in points.iter().zip(&solution.contacts).enumerate() {
            let pushes = contact.mode != ContactMode::Open;
            if speaks_of(pushes, solution.certificate.get(i).map(|d| d[0])) {
                let [a, b] = point.pair.map(|body| &self.bodies[body].name);
                named.push(format!("{a} and {b}"));
            }
        }
        for (i, row) in solution.rows.iter().enumerate() {
            if speaks_of(row.impulse != 0.0, solution.row_certificate.get(i).copied()) {
                named.push(self.row_name(row.key));
            }
        }
        named.dedup(); // a pair has several points
        let what = if proved { "these exclude each other" } else { "these push" };
        format!("{what}: {}", named.join(", "))
    }
}

impl Touch {
    /// That of a contact.
    fn new((point, contact): (&Point, &ContactSolution<f64, 3>)) -> Result<Self, Error> {
        Ok(Self {
            pair: point.pair,
            place: point.place,
            force: contact_frame(&point.normal)? * contact.impulse / STEP,
            normal: contact.impulse[0] / STEP,
            gap: point.gap,
            slip: contact.velocity.yz().norm(),
            mode: contact.mode,
        })
    }
}

impl Tick {
    /// The fastest slip of all contacts (m/s).
    #[must_use]
    pub fn slip(&self) -> f64 {
        self.touches.iter().map(|touch| touch.slip).fold(0.0, f64::max)
    }
}
