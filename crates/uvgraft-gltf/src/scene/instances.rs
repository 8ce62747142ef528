//! Instances: a node that draws its mesh several times, each with a transform of its own.
//!
//! # Source
//! Khronos, "EXT_mesh_gpu_instancing".

use glam::Affine3A;

use super::Node;
use super::accessor::Accessors;
use super::document::{self, Instancing};
use super::error::SceneError;
use super::transform::{LocalTransform, unit};

/// The transforms that place the instances in the space of their node; `None` if the mesh is drawn once,
/// at the node.
///
/// The caller has limited their number.
///
/// # Errors
/// If the attributes are damaged or differ in their count.
pub(super) fn read(
    node: &document::Node,
    accessors: &mut Accessors<'_>,
) -> Result<Option<Vec<Affine3A>>, SceneError> {
    let Some(Instancing { attributes }) = &node.extensions.instancing else { return Ok(None) };
    let attribute = |name: &str| attributes.get(name).copied();
    let known = ["TRANSLATION", "ROTATION", "SCALE"].map(attribute);
    // Attributes of applications count instances, too, if there are no others.
    let first = known.into_iter().flatten().chain(attributes.values().copied()).next();
    let (Some(first), Some(_)) = (first, node.mesh) else { return Ok(None) };
    let count = accessors.count(first)?;
    let mut placed = vec![LocalTransform::default(); count];
    let [translation, rotation, scale] = known;
    if let Some(index) = translation {
        let values = accessors.floats::<3>(index, Some(count))?;
        placed.iter_mut().zip(values).for_each(|(it, value)| it.translation = value);
    }
    if let Some(index) = rotation {
        let values = accessors.floats::<4>(index, Some(count))?;
        placed.iter_mut().zip(values).for_each(|(it, value)| it.rotation = unit(value).into());
    }
    if let Some(index) = scale {
        let values = accessors.floats::<3>(index, Some(count))?;
        placed.iter_mut().zip(values).for_each(|(it, value)| it.scale = value);
    }
    Ok(Some(placed.iter().map(LocalTransform::affine).collect()))
}

impl Node {
    /// Transforms from each instance of its mesh to the node; one if the file states none.
    pub(super) fn instances(&self) -> &[Affine3A] {
        self.instances.as_deref().unwrap_or(&[Affine3A::IDENTITY])
    }
}

/// How the vertices of an instance get to the world.
pub(super) struct InstancePose<'a> {
    /// World transform of primitives without skin weights.
    pub node: Affine3A,
    /// Transforms of the skin's joints from the bind pose to the world.
    pub joints: Option<&'a [Affine3A]>,
    /// What moves a skinned primitive in the world; `None` if nothing does.
    ///
    /// Joints place it, whatever its node is, so an instance is taken to be the posed mesh, moved as
    /// seen from the node.
    pub moved: Option<Affine3A>,
    /// Whether it is mirrored, which turns triangles over.
    pub is_mirrored: bool,
}

impl<'a> InstancePose<'a> {
    /// - `node`: world transform of the node.
    /// - `instance`: transform from the instance to the node.
    /// - `joints`: transforms of the skin's joints from the bind pose to the world.
    pub fn new(node: &Affine3A, instance: &Affine3A, joints: Option<&'a [Affine3A]>) -> Self {
        let placed = *node * *instance;
        let moved = placed * node.inverse();
        // A node that is scaled to nothing has no inverse.
        let moved = Some(moved).filter(|it| *instance != Affine3A::IDENTITY && it.is_finite());
        let turns = if joints.is_some() { instance } else { &placed };
        let is_mirrored = turns.matrix3.determinant() < 0.0;
        Self { node: placed, joints, moved, is_mirrored }
    }
}
