//! Avatars as GLB files, and as VRM 1.0, which is GLB that knows which joints make a human.
//!
//! [`write()`] makes the bytes of a file. Its shape suits what reads such files: one mesh with one
//! material (a draw call), at the root of the scene beside the joints; vertices split where the layout
//! is; at most four joints a vertex; morph targets with names, sparse where that is smaller; clips as
//! rotations, and translations of the root. Nodes have the numbers of joints, the mesh's comes last.
//!
//! Sources: Khronos Group, "glTF 2.0 Specification", 2021; VRM Consortium, "VRMC_vrm-1.0"
//! (specification, 2022).

mod buffer;
mod clips;
mod container;
mod json;
#[cfg(feature = "ktx2")]
mod ktx2;
mod looks;
pub(crate) mod shading;
pub(crate) mod skin;
mod t_pose;
mod textures;
#[cfg(feature = "ktx2")]
mod uastc;
pub(crate) mod vertices;
pub mod vrm;

#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

use serde_json::{Map, Value};

pub(crate) use self::container::pack;
#[cfg(all(test, feature = "ktx2"))]
pub(crate) use self::ktx2::encode as encode_ktx2;
pub(crate) use self::looks::KTX2_IDENTIFIER;
pub use self::looks::{Looks, Picture, PictureError, PictureFormat};
pub(crate) use self::skin::written as written_skin;
pub use self::t_pose::t_pose;
pub use self::vrm::{Permissions, VrmMeta};

use self::buffer::Buffer;
use self::json::ARRAY_BUFFER;
use self::shading::Shading;
use self::vertices::Vertices;
use crate::Avatar;
use crate::rig::{Pose, Pruning, RigError};

/// What to write beside the avatar and its looks.
#[derive(Debug, Clone, Default)]
pub struct Export {
    /// What the avatar is called; "avatar" if empty.
    pub name: String,
    /// Who may copy it: `asset.copyright`.
    pub copyright: Option<String>,
    /// Facts for whoever wants them: `asset.extras`.
    pub extras: Map<String, Value>,
    /// Makes it a VRM file.
    pub vrm: Option<VrmMeta>,
    /// Normals of the avatar's vertices at rest, such as those of a finer mesh that it was simplified
    /// from. Without them, and with a normal map, they are smooth.
    pub normals: Option<Vec<[f32; 3]>>,
}

/// A file, and what it holds.
#[derive(Debug, Clone)]
pub struct Exported {
    /// The whole file.
    pub bytes: Vec<u8>,
    /// What there is to tell about it.
    pub report: Report,
}

/// What a file holds, and what it lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// Vertices, after splitting them along seams of the layout.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Joints.
    pub joints: usize,
    /// Morph targets.
    pub morphs: usize,
    /// Animations.
    pub clips: usize,
    /// Seconds of the longest of them.
    pub longest_clip: f32,
    /// Influences beyond four a vertex, which are gone.
    pub pruning: Pruning,
    /// How far that takes a vertex from where it was, in metres, at most: in frames of the clips, or
    /// with all joints bent by 30° if there are none.
    pub pruning_most: f32,
    /// The mean of that over all vertices.
    pub pruning_mean: f32,
    /// The nodes were turned into T-pose, which VRM wants at rest.
    pub posed_as_t: bool,
    /// Bytes of images.
    pub image_bytes: usize,
    /// Bytes of the whole file.
    pub bytes: usize,
}

/// Why an avatar cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GlbError {
    /// The avatar's parts do not fit each other.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// Every triangle has a vertex twice.
    #[error("the mesh has no triangle with three vertices")]
    NoTriangles,
    /// Two morphs or two expressions have one name, by which they could not be told apart.
    #[error("two {what} have the name `{name}`")]
    Name {
        /// Of what.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A factor of the material is out of its range.
    #[error("the {what} is {found}, wanted 0 to 1")]
    Factor {
        /// Which.
        what: &'static str,
        /// What was found.
        found: f32,
    },
    /// Lengths in GLB files have 32 bits.
    #[error("the file would have {bytes} bytes, more than GLB's 4 GiB")]
    TooLarge {
        /// How many.
        bytes: u64,
    },
    /// What VRM asks for beyond glTF is not there.
    #[error(transparent)]
    Vrm(#[from] vrm::VrmError),
    /// The JSON could not be made.
    #[error("cannot write the JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// Writes an avatar as a GLB file, or as a VRM file if `export` has VRM's meta data. The same input
/// makes the same bytes.
///
/// The nodes of a VRM stand in a T-pose, by [`t_pose`]; the skin stays bound to the avatar's own rest, so
/// clips show what they show in a GLB.
///
/// # Errors
/// [`GlbError`] if the avatar is not sound, or is no human by VRM's rules where VRM is asked for.
pub fn write(avatar: &Avatar, looks: &Looks, export: &Export) -> Result<Exported, GlbError> {
    check(avatar, looks)?;
    let normals = export.normals.as_deref();
    if let Some(found) = normals.map(<[_]>::len) {
        let wanted = avatar.mesh.positions().len();
        if found != wanted {
            return Err(RigError::Count { what: "normals", found, wanted }.into());
        }
    }
    let mut t_posed = None;
    if let Some(meta) = &export.vrm {
        vrm::check(meta, avatar)?;
        t_posed = t_pose(avatar)?;
    }
    let posed_as_t = t_posed.is_some();
    let stand = t_posed.unwrap_or_else(|| Pose::rest(avatar.skeleton.joints().len()));
    let (skin, pruning) = avatar.skin.pruned(skin::MOST_INFLUENCES);
    let (pruning_most, pruning_mean) = skin::error(avatar, &skin, &pruning)?;

    let shading = Shading::new(&avatar.mesh).with_normals(normals.unwrap_or(&[]));
    let vertices = Vertices::new(&avatar.mesh, &shading, looks.normal.is_some());
    if vertices.indices.is_empty() {
        return Err(GlbError::NoTriangles);
    }
    let joints = avatar.skeleton.joints().len();
    let mut buffer = Buffer::default();
    let (joint_numbers, weights) = skin::write(&skin, joints, &vertices, &mut buffer);
    let attributes = json::Attributes {
        position: buffer.floats(&vertices.positions, Some(ARRAY_BUFFER), true),
        normal: buffer.floats(&vertices.normals, Some(ARRAY_BUFFER), false),
        tangent: vertices
            .tangents
            .as_ref()
            .map(|tangents| buffer.floats(tangents, Some(ARRAY_BUFFER), false)),
        texcoord: buffer.floats(&vertices.uv, Some(ARRAY_BUFFER), false),
        joints: joint_numbers,
        weights,
    };
    let indices = buffer.indices(&vertices.indices, Some(json::ELEMENT_ARRAY_BUFFER));
    let targets = targets(avatar, &shading, &vertices, &mut buffer);
    let skin = skin::write_joints(avatar, &mut buffer);
    let clips = avatar.clips.iter();
    let animations =
        clips.map(|clip| clips::write(clip, &avatar.skeleton, &stand, &mut buffer)).collect();
    let material = textures::write(looks, &vertices, &mut buffer);

    let name = if export.name.is_empty() { "avatar" } else { &export.name };
    let primitive = json::Primitive { attributes, indices, material: 0, targets };
    let target_names: Vec<String> = avatar.morphs.iter().map(|morph| morph.name.clone()).collect();
    let mesh = json::Mesh {
        name: name.to_owned(),
        primitives: vec![primitive],
        weights: vec![0.0; target_names.len()],
        extras: (!target_names.is_empty()).then_some(json::MeshExtras { target_names }),
    };
    let textures::Written { material, textures, images, samplers, image_bytes, mut extensions } =
        material;
    let required = extensions.iter().filter(|(_, required)| *required).map(|&(name, _)| name);
    let extensions_required: Vec<&'static str> = required.collect();
    let root_extensions = export.vrm.as_ref().map(|meta| {
        extensions.push((vrm::EXTENSION, false));
        json::RootExtensions { vrm: vrm::extension(meta, avatar) }
    });
    let root = json::Root {
        asset: json::Asset {
            version: "2.0",
            generator: concat!("uvgraft ", env!("CARGO_PKG_VERSION")).to_owned(),
            copyright: export.copyright.clone(),
            extras: export.extras.clone(),
        },
        extensions_used: extensions.iter().map(|&(name, _)| name).collect(),
        extensions_required,
        scene: 0,
        scenes: vec![json::Scene { name: name.to_owned(), nodes: vec![0, joints] }],
        nodes: nodes(avatar, &stand, name),
        meshes: vec![mesh],
        skins: vec![skin],
        materials: vec![material],
        textures,
        images,
        samplers,
        animations,
        accessors: buffer.accessors,
        buffers: vec![json::Buffer { byte_length: buffer.bytes.len() }],
        buffer_views: buffer.views,
        extensions: root_extensions,
    };
    let bytes = container::pack(&serde_json::to_vec(&root)?, &buffer.bytes)?;
    let report = Report {
        vertices: vertices.count(),
        triangles: vertices.indices.len() / 3,
        joints,
        morphs: avatar.morphs.len(),
        clips: avatar.clips.len(),
        longest_clip: avatar.clips.iter().map(crate::rig::Clip::seconds).fold(0.0, f32::max),
        pruning,
        pruning_most,
        pruning_mean,
        posed_as_t,
        image_bytes,
        bytes: bytes.len(),
    };
    Ok(Exported { bytes, report })
}

fn check(avatar: &Avatar, looks: &Looks) -> Result<(), GlbError> {
    avatar.check()?;
    for (what, found) in
        [("roughness", looks.roughness_factor), ("metalness", looks.metallic_factor)]
    {
        if !(0.0..=1.0).contains(&found) {
            return Err(GlbError::Factor { what, found });
        }
    }
    unique("morphs", avatar.morphs.iter().map(|morph| &morph.name))?;
    unique("expressions", avatar.expressions.iter().map(|expression| &expression.name))
}

fn unique<'a>(what: &'static str, names: impl Iterator<Item = &'a String>) -> Result<(), GlbError> {
    let mut known = std::collections::HashSet::new();
    for name in names {
        if !known.insert(name) {
            return Err(GlbError::Name { what, name: name.clone() });
        }
    }
    Ok(())
}

/// Normals that change by less are left as they are: a tenth of a degree is not seen.
const LEAST_NORMAL_CHANGE: f32 = 0.002;

/// Appends the morphs.
fn targets(
    avatar: &Avatar,
    shading: &Shading<'_>,
    vertices: &Vertices,
    buffer: &mut Buffer,
) -> Vec<json::Target> {
    let mut target = |morph: &crate::rig::Morph| {
        let normals = shading.changes(&morph.offsets, LEAST_NORMAL_CHANGE);
        let count = vertices.count();
        json::Target {
            position: buffer.offsets(&vertices.spread(&morph.offsets), count, true),
            normal: buffer.offsets(&vertices.spread(&normals), count, false),
        }
    };
    avatar.morphs.iter().map(&mut target).collect()
}

/// One node for each joint, then the mesh's. The mesh is at the scene's root, because the transforms
/// of its parents would not count.
///
/// - `stand`: the pose in which they are.
fn nodes(avatar: &Avatar, stand: &Pose, name: &str) -> Vec<json::Node> {
    let joints = avatar.skeleton.joints();
    let mut nodes: Vec<json::Node> = Vec::with_capacity(joints.len() + 1);
    for (index, joint) in joints.iter().enumerate() {
        // The root is moved by the pose, all others keep their place beside their parents.
        let moved = glam::Vec3::from(stand.translation);
        let from = joint.parent.map_or(-moved, |parent| joints[parent].position.into());
        let offset = glam::Vec3::from(joint.position) - from;
        let turn = stand.rotations[index];
        nodes.push(json::Node {
            name: joint.name.clone(),
            translation: Some(offset.into()),
            rotation: (turn != [0.0, 0.0, 0.0, 1.0]).then_some(turn),
            ..json::Node::default()
        });
        if let Some(parent) = joint.parent {
            nodes[parent].children.push(index);
        }
    }
    // Players find nodes by name, so it must not be that of a joint.
    let mut name = name.to_owned();
    while joints.iter().any(|joint| joint.name == name) {
        name.push_str(" mesh");
    }
    nodes.push(json::Node { name, mesh: Some(0), skin: Some(0), ..json::Node::default() });
    nodes
}
