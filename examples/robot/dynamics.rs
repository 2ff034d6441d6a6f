//! `M`, forces and Jacobians of all trees, from `dynibo`.

use crate::collide::vector;
use crate::{Failure, Tree, World};
use dynibo::{BaseState, Frame, Twist};
use nalgebra::{DMatrix, DVector, SMatrix, SVector, Vector3};
use parry3d_f64::math::{Pose, Rotation, Vector};

/// What rounding leaves of an inertia that is 0, as a share.
const ROUNDING: f64 = 1e-12;

/// The dynamics of all trees, and of each body its pose, the origin of its link and the Jacobian of that.
pub(crate) struct Dynamics<const N: usize> {
    pub(crate) mass: SMatrix<f64, N, N>,
    /// Coriolis and centrifugal forces, and weight.
    pub(crate) force: SVector<f64, N>,
    pub(crate) poses: Vec<Pose>,
    pub(crate) origins: Vec<Vector3<f64>>,
    pub(crate) jacobians: Vec<SMatrix<f64, 6, N>>,
    pub(crate) bones: Vec<[Vector3<f64>; 2]>,
}

impl<const N: usize, const C: usize, const R: usize> World<N, C, R> {
    /// Trees do not act on each other without contacts: `M` consists of their blocks.
    pub(crate) fn dynamics(&mut self) -> Result<Dynamics<N>, Failure> {
        let size: usize = self.trees.iter().map(Tree::size).sum();
        if size > N {
            let right = format!("World::<{size}>, not {N}");
            return Err(format!("a world of {size} velocities is made with {right}").into());
        }
        if self.bodies.is_empty() {
            return Err("nothing has a shape that could collide".into());
        }
        let mut all = Dynamics::<N> {
            mass: SMatrix::identity(), // right for velocities that no tree has: they stay 0
            force: SVector::zeros(),
            poses: self.bodies.iter().map(|body| body.local).collect(), // right for ground
            origins: vec![Vector3::zeros(); self.bodies.len()],
            jacobians: vec![SMatrix::zeros(); self.bodies.len()],
            bones: Vec::new(),
        };
        let mut first = 0;
        for (index, tree) in self.trees.iter_mut().enumerate() {
            let (kept, size) = (tree.kept(), tree.size());
            let (base, v) = tree.state(&self.velocity.as_slice()[first..first + size])?;
            let angles: Vec<_> = tree.joints.iter().map(|joint| joint.angle).collect();
            let (rates, still, model) = (&v[6..], vec![0.0; angles.len()], &mut tree.model);
            let (mut mass, mut bias) = (DMatrix::zeros(v.len(), v.len()), DVector::zeros(v.len()));
            model.mass_matrix(&base, &angles, mass.as_mut_slice())?;
            model.inverse_dynamics(&base, &angles, rates, &still, &[], bias.as_mut_slice())?;
            // A base that is bolted down neither moves nor accelerates: its rows and columns go.
            let mut block = all.mass.view_mut((first, first), (size, size));
            block.copy_from(&mass.view_range(kept.clone(), kept.clone()));
            let mut force = all.force.rows_mut(first, size);
            force.copy_from(&-bias.rows_range(kept.clone()));

            let mut frames = vec![Frame::identity(); model.link_count()];
            model.forward_kinematics_all(&base, &angles, &mut frames)?;
            let frames: Vec<_> = frames.iter().map(pose).collect();
            let own = |(_, body): &(usize, &crate::Body)| body.tree == index;
            for (i, body) in self.bodies.iter().enumerate().filter(own) {
                all.poses[i] = frames[body.link] * body.local;
                all.origins[i] = vector(frames[body.link].translation);
                let (mut jacobian, link) = (DMatrix::zeros(6, v.len()), model.link_id_at(body.link)?);
                model.jacobian(&base, &angles, link, jacobian.as_mut_slice())?;
                let mut columns = all.jacobians[i].columns_mut(first, size);
                columns.copy_from(&jacobian.columns_range(kept.clone()));
            }
            let ends = |bone: &[usize; 2]| bone.map(|link| vector(frames[link].translation));
            all.bones.extend(tree.bones.iter().map(ends));
            first += size;
        }
        Ok(all)
    }
}

impl<const N: usize> Dynamics<N> {
    /// The first velocity that has no inertia, up to rounding, while the later ones move freely.
    pub(crate) fn without_inertia(&self) -> Option<usize> {
        let mut rest = self.mass;
        for dof in (0..N).rev() {
            let pivot = rest[(dof, dof)];
            if pivot <= ROUNDING * self.mass[(dof, dof)] {
                return Some(dof);
            }
            for i in 0..dof {
                let share = rest[(dof, i)] / pivot;
                if share == 0.0 {
                    continue; // joints of other limbs
                }
                for j in 0..=i {
                    rest[(i, j)] -= share * rest[(dof, j)];
                }
            }
        }
        None
    }

    /// Whether any velocity moves a body.
    pub(crate) fn can_move(&self, body: usize) -> bool {
        self.jacobians[body].iter().any(|&entry| entry != 0.0)
    }

    /// Jacobian of the velocity of a point of a body.
    pub(crate) fn jacobian(&self, body: usize, point: &Vector3<f64>) -> SMatrix<f64, 3, N> {
        let (jacobian, arm) = (&self.jacobians[body], point - self.origins[body]);
        jacobian.fixed_rows::<3>(3) - arm.cross_matrix() * jacobian.fixed_rows::<3>(0)
    }
}

impl Tree {
    /// Its base, and velocities with those of the base, also if that is bolted down.
    fn state(&self, velocity: &[f64]) -> dynibo::Result<(BaseState, Vec<f64>)> {
        let mut v = vec![0.0; 6 + self.joints.len()];
        v[self.kept()].copy_from_slice(velocity);
        // `dynibo` stands on another nalgebra than stiction: numbers go across as arrays.
        let part = |first: usize| [v[first], v[first + 1], v[first + 2]].into();
        let [place, turn] = [self.place, self.turn.scaled_axis()].map(<[f64; 3]>::from);
        let frame = Frame::new(place.into(), turn.into());
        let base = BaseState::new(frame, Twist::new(part(0), part(3)), Twist::zeros())?;
        Ok((base, v))
    }
}

/// A frame in the types of parry.
fn pose(frame: &Frame) -> Pose {
    let (p, q) = (frame.translation, frame.rotation);
    let turn = Rotation::from_xyzw(q.i, q.j, q.k, q.w);
    Pose::from_parts(Vector::new(p.x, p.y, p.z), turn)
}
