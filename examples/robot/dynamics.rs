//! `M`, forces and Jacobians of all trees, from `dynibo`.

use crate::collide::vector;
use crate::{Failure, Tree, World};
use dynibo::{BaseState, Frame, Twist};
use nalgebra::{DMatrix, DVector, SMatrix, SVector, Vector3};
use parry3d_f64::math::{Pose, Rotation, Vector};

/// The dynamics of all trees, and of each body its pose, the origin of its link and the Jacobian of that.
pub(crate) struct Dynamics<const N: usize> {
    pub(crate) mass: SMatrix<f64, N, N>,
    pub(crate) force: SVector<f64, N>,
    pub(crate) poses: Vec<Pose>,
    pub(crate) origins: Vec<Vector3<f64>>,
    pub(crate) jacobians: Vec<SMatrix<f64, 6, N>>,
    pub(crate) bones: Vec<[Vector3<f64>; 2]>,
}

impl<const N: usize> World<N> {
    /// Trees do not act on each other without contacts: `M` consists of their blocks.
    pub(crate) fn dynamics(&mut self) -> Result<Dynamics<N>, Failure> {
        let size: usize = self.trees.iter().map(Tree::size).sum();
        if size != N {
            return Err(format!(
                "a world of {size} velocities is made with World::<{size}>, not {N}"
            )
            .into());
        }
        let mut all = Dynamics::<N> {
            mass: SMatrix::zeros(),
            force: SVector::zeros(),
            poses: self.bodies.iter().map(|body| body.local).collect(), // right for ground
            origins: vec![Vector3::zeros(); self.bodies.len()],
            jacobians: vec![SMatrix::zeros(); self.bodies.len()],
            bones: Vec::new(),
        };
        let mut first = 0;
        for (index, tree) in self.trees.iter_mut().enumerate() {
            let size = tree.size();
            let own = || {
                self.bodies
                    .iter()
                    .enumerate()
                    .filter(|(_, body)| body.tree == index)
            };
            let links = own().map(|(_, body)| body.link);
            let one = tree.dynamics(&self.velocity.as_slice()[first..first + size], links)?;
            all.mass
                .view_mut((first, first), (size, size))
                .copy_from(&one.mass);
            all.force.rows_mut(first, size).copy_from(&-one.bias);
            for ((i, body), jacobian) in own().zip(&one.jacobians) {
                all.poses[i] = one.frames[body.link] * body.local;
                all.origins[i] = vector(one.frames[body.link].translation);
                all.jacobians[i]
                    .columns_mut(first, size)
                    .copy_from(jacobian);
            }
            let bones = tree
                .bones
                .iter()
                .map(|bone| bone.map(|link| vector(one.frames[link].translation)));
            all.bones.extend(bones);
            first += size;
        }
        Ok(all)
    }
}

impl<const N: usize> Dynamics<N> {
    /// Jacobian of the velocity of a point of a body.
    pub(crate) fn jacobian(&self, body: usize, point: &Vector3<f64>) -> SMatrix<f64, 3, N> {
        let (jacobian, arm) = (&self.jacobians[body], point - self.origins[body]);
        jacobian.fixed_rows::<3>(3) - arm.cross_matrix() * jacobian.fixed_rows::<3>(0)
    }
}

/// Those of one tree: `M`, bias forces (Coriolis, centrifugal, weight), frames of links, and a Jacobian for each body.
struct OfTree {
    mass: DMatrix<f64>,
    bias: DVector<f64>,
    frames: Vec<Pose>,
    jacobians: Vec<DMatrix<f64>>,
}

impl Tree {
    /// Its dynamics at these velocities, with Jacobians of these links.
    fn dynamics(
        &mut self,
        velocity: &[f64],
        links: impl Iterator<Item = usize>,
    ) -> dynibo::Result<OfTree> {
        let (kept, all) = (self.kept(), 6 + self.joints.len());
        let mut v = vec![0.0; all];
        v[kept.clone()].copy_from_slice(velocity);
        // `dynibo` stands on another nalgebra than stiction: numbers go across as arrays.
        let vector = |first: usize| [v[first], v[first + 1], v[first + 2]].into();
        let array = |vector: Vector3<f64>| <[f64; 3]>::from(vector);
        let frame = Frame::new(
            array(self.place).into(),
            array(self.turn.scaled_axis()).into(),
        );
        let base = BaseState::new(frame, Twist::new(vector(0), vector(3)), Twist::zeros())?;
        let angles: Vec<_> = self.joints.iter().map(|joint| joint.angle).collect();
        let (mut mass, mut bias) = (DMatrix::zeros(all, all), DVector::zeros(all));
        let (model, still) = (&mut self.model, vec![0.0; angles.len()]);
        model.mass_matrix(&base, &angles, mass.as_mut_slice())?;
        model.inverse_dynamics(&base, &angles, &v[6..], &still, &[], bias.as_mut_slice())?;
        let mut frames = vec![Frame::identity(); model.link_count()];
        model.forward_kinematics_all(&base, &angles, &mut frames)?;
        let mut jacobians = Vec::new();
        for link in links {
            let mut jacobian = DMatrix::zeros(6, all);
            model.jacobian(
                &base,
                &angles,
                model.link_id_at(link)?,
                jacobian.as_mut_slice(),
            )?;
            jacobians.push(jacobian.columns_range(kept.clone()).into_owned());
        }
        let frames = frames.iter().map(|frame| {
            let (p, q) = (frame.translation, frame.rotation);
            Pose::from_parts(
                Vector::new(p.x, p.y, p.z),
                Rotation::from_xyzw(q.i, q.j, q.k, q.w),
            )
        });
        // A base that is bolted down neither moves nor accelerates: its rows and columns go.
        Ok(OfTree {
            mass: mass.view_range(kept.clone(), kept.clone()).into_owned(),
            bias: bias.rows_range(kept).into_owned(),
            frames: frames.collect(),
            jacobians,
        })
    }
}
