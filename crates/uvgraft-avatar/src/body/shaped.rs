//! One person of a body model, at rest and posed.

use glam::{Affine3A, Quat, Vec3, Vec3A};
use uvgraft::threads;

use super::BodyModel;
use super::correctives::{BLOCK, TILE, features};
use crate::motion::Soles;
use crate::rig::{Pose, RigError, Rigid, Skeleton};

/// One person: a model with a given shape and expression.
#[derive(Debug, Clone)]
pub struct Shaped<'m> {
    pub(super) model: &'m BodyModel,
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) skeleton: Skeleton,
}

impl Shaped<'_> {
    /// The model.
    pub const fn model(&self) -> &BodyModel {
        self.model
    }

    /// Vertex positions at rest, in metres.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// The joints at rest.
    pub const fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// The soles of this person's feet; `None` for a head.
    pub fn soles(&self) -> Option<Soles> {
        Soles::new(&self.positions, &self.model.skin, &self.skeleton)
    }

    /// Joint positions in a pose, in metres.
    ///
    /// # Errors
    /// See [`Pose::check`].
    pub fn joints(&self, pose: &Pose) -> Result<Vec<[f32; 3]>, RigError> {
        let joints = self.skeleton.joints().iter().zip(self.skeleton.motions(pose)?);
        Ok(joints.map(|(joint, motion)| motion.point(joint.position)).collect())
    }

    /// Vertex positions in a pose, with its correctives, in metres.
    ///
    /// # Errors
    /// See [`Pose::check`].
    pub fn posed(&self, pose: &Pose) -> Result<Vec<[f32; 3]>, RigError> {
        Ok(self.posed_frames(std::slice::from_ref(pose))?.pop().unwrap_or_default())
    }

    /// [`Shaped::posed`] for several poses, with identical results; much faster than one by one,
    /// because the correctives are read once for every eight poses.
    ///
    /// # Errors
    /// See [`Pose::check`].
    pub fn posed_frames(&self, poses: &[Pose]) -> Result<Vec<Vec<[f32; 3]>>, RigError> {
        let mut frames = Vec::with_capacity(poses.len());
        for poses in poses.chunks(BLOCK) {
            let matrices: Vec<Vec<Affine3A>> = poses
                .iter()
                .map(|pose| Ok(self.skeleton.motions(pose)?.iter().map(matrix).collect()))
                .collect::<Result<_, RigError>>()?;
            let features: Vec<Vec<f32>> =
                poses.iter().map(|pose| features(&pose.rotations)).collect();
            frames.extend(self.block(&matrices, &features));
        }
        Ok(frames)
    }

    /// Poses a block of frames by linear blend skinning: `x' = Σ w_j M_j (x + offset)`, where the
    /// offset comes from the pose correctives. Threads take tiles of vertices and pose each in all
    /// frames, so that a tile's correctives are read from memory once.
    fn block(&self, matrices: &[Vec<Affine3A>], features: &[Vec<f32>]) -> Vec<Vec<[f32; 3]>> {
        let vertices = self.positions.len();
        let mut frames = vec![vec![[0.0; 3]; vertices]; features.len()];
        let mut tiles: Vec<Vec<&mut [[f32; 3]]>> = Vec::new();
        tiles.resize_with(vertices.div_ceil(TILE), Vec::new);
        for frame in &mut frames {
            for (tile, piece) in tiles.iter_mut().zip(frame.chunks_mut(TILE)) {
                tile.push(piece);
            }
        }
        let scratch = || vec![0.0; BLOCK * TILE * 3];
        threads::for_each_with(tiles.into_iter(), scratch, |scratch, tile, mut pieces| {
            let first = tile * TILE;
            let width = pieces[0].len() * 3;
            let sums = &mut scratch[..width * pieces.len()];
            self.model.correctives.tile(tile, features, sums);
            let frames = pieces.iter_mut().zip(sums.chunks_exact(width)).zip(matrices);
            for ((posed, offsets), matrices) in frames {
                let offsets = offsets.as_chunks::<3>().0;
                for (at, (posed, &offset)) in posed.iter_mut().zip(offsets).enumerate() {
                    let vertex = first + at;
                    let rest = Vec3A::from(self.positions[vertex]) + Vec3A::from(offset);
                    *posed = self.blend(vertex, matrices).transform_point3a(rest).into();
                }
            }
        });
        frames
    }

    fn blend(&self, vertex: usize, matrices: &[Affine3A]) -> Affine3A {
        let mut blended = Affine3A::ZERO;
        for &(joint, weight) in self.model.skin.of(vertex) {
            let matrix = &matrices[usize::from(joint)];
            blended.matrix3 += matrix.matrix3 * weight;
            blended.translation += matrix.translation * weight;
        }
        blended
    }

    /// The specification of [`Shaped::posed`]: one vertex after the other; never tuned.
    ///
    /// # Errors
    /// See [`Pose::check`].
    pub fn posed_reference(&self, pose: &Pose) -> Result<Vec<[f32; 3]>, RigError> {
        let motions = self.skeleton.motions(pose)?;
        let offsets = self.model.correctives.reference(&features(&pose.rotations));
        let posed =
            self.positions.iter().zip(offsets).enumerate().map(|(vertex, (rest, offset))| {
                let rest = Vec3::from(*rest) + Vec3::from(offset);
                let mut sum = Vec3::ZERO;
                for &(joint, weight) in self.model.skin.of(vertex) {
                    sum += weight * Vec3::from(motions[usize::from(joint)].point(rest.into()));
                }
                sum.into()
            });
        Ok(posed.collect())
    }
}

fn matrix(motion: &Rigid) -> Affine3A {
    let rotation = Quat::from_array(motion.rotation);
    Affine3A::from_rotation_translation(rotation, motion.translation.into())
}
