//! Avatars as GLB files, and as VRM 1.0, which is GLB with a mapping from joints to human bones.
//!
//! [`write()`] produces the bytes of a file, laid out for its typical readers: one mesh with one
//! primitive (a draw call) for each material, at the root of the scene next to the joints; vertices
//! split at UV seams; at most four joints for each vertex; named morph targets, sparse where that
//! is smaller; clips as rotations, and translations of the root. Nodes have the indices of their
//! joints; mesh nodes follow. In a VRM file, a head with its own material is a separate mesh, so
//! that first-person views can hide it. Coarser levels are nodes outside the scene (`MSFT_lod`):
//! readers without that extension show the finest level.
//!
//! Sources: Khronos Group, "glTF 2.0 Specification", 2021; VRM Consortium, "VRMC_vrm-1.0"
//! (specification, 2022).

mod buffer;
mod check;
mod clips;
mod embed_error;
mod embedded_image;
mod json;
#[cfg(feature = "ktx2")]
mod ktx2;
mod ktx2_header;
mod material;
mod mtoon;
mod nodes;
mod parts;
pub(crate) mod shading;
pub(crate) mod skin;
mod t_pose;
mod textures;
#[cfg(feature = "ktx2")]
mod uastc;
pub(crate) mod vertices;
pub mod vrm;

#[cfg(test)]
mod material_tests;
#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

use serde_json::{Map, Value};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::{Clip, MAX_INFLUENCES, Pose, Pruning};

use self::buffer::Buffer;
pub use self::check::GlbError;
pub use self::embed_error::{EmbedError, EmbeddedFormat};
pub use self::embedded_image::EmbeddedImage;
#[cfg(all(test, feature = "ktx2"))]
pub(crate) use self::ktx2::encode as encode_ktx2;
pub(crate) use self::ktx2_header::{KTX2_IDENTIFIER, Ktx2Header};
pub use self::material::{AvatarMaterial, ShadingModel};
pub use self::t_pose::t_pose;
pub use self::vrm::{Permissions, VrmError, VrmMeta};
use crate::container::Glb;

/// What to write besides the avatar and its materials.
#[derive(Debug, Clone, Default)]
pub struct Export {
    /// Name of the avatar; "avatar" if empty.
    pub name: String,
    /// Copyright notice: `asset.copyright`.
    pub copyright: Option<String>,
    /// Arbitrary metadata: `asset.extras`.
    pub extras: Map<String, Value>,
    /// VRM metadata; if present, the file is a VRM file.
    pub vrm: Option<VrmMeta>,
    /// Normals of the avatar's vertices in the rest pose, for example those of a finer mesh that it
    /// was simplified from. Without them they are computed as smooth normals.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Coarser levels of the avatar, finest first, for readers that support `MSFT_lod`; not allowed
    /// in VRM files.
    pub levels: Vec<CoarserLevel>,
    /// A square thumbnail image of the avatar, PNG or JPEG; written to VRM files only.
    pub thumbnail: Option<EmbeddedImage>,
}

/// An avatar with fewer triangles, for display at a distance.
#[derive(Debug, Clone)]
pub struct CoarserLevel {
    /// The avatar; it must have the joints and morphs of the finest level.
    pub avatar: Avatar,
    /// See [`Export::normals`].
    pub normals: Option<Vec<[f32; 3]>>,
}

/// A written file and a report on it.
#[derive(Debug, Clone)]
pub struct Exported {
    /// The bytes of the file.
    pub bytes: Vec<u8>,
    /// What the file contains.
    pub report: Report,
}

/// The contents of a file, and what was lost in writing it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// Vertices, after splitting them at UV seams.
    pub vertices: usize,
    /// Triangles of the finest level.
    pub triangles: usize,
    /// Meshes in the scene.
    pub meshes: usize,
    /// Materials, counted once for each mesh: draw calls.
    pub materials: usize,
    /// Joints.
    pub joints: usize,
    /// Morph targets.
    pub morphs: usize,
    /// Animations.
    pub clips: usize,
    /// Duration of the longest animation, in seconds.
    pub longest_clip: f32,
    /// Influences dropped because a vertex may have four at most.
    pub pruning: Pruning,
    /// Largest vertex displacement caused by pruning, in metres, over frames of the clips, or with
    /// all joints bent by 30° if there are none.
    pub pruning_most: f32,
    /// Mean of that displacement over all vertices and poses.
    pub pruning_mean: f32,
    /// Whether the nodes were moved to a T-pose, which VRM requires at rest.
    pub posed_as_t: bool,
    /// Size of the images, in bytes.
    pub image_bytes: usize,
    /// Size of the file, in bytes.
    pub bytes: usize,
}

/// Writes an avatar as a GLB file, or as a VRM file if `export` has VRM metadata. The output is
/// deterministic: the same input gives the same bytes.
///
/// The nodes of a VRM file are in a T-pose, see [`t_pose`]; the skin stays bound to the avatar's
/// own rest pose, so clips look the same as in a GLB file.
///
/// - `materials`: a single material, or all that [`Avatar::materials`] refers to.
///
/// # Errors
/// [`GlbError`] if the avatar is invalid, or if a VRM file is requested and the avatar does not
/// meet VRM's requirements for humanoids.
pub fn write(
    avatar: &Avatar,
    materials: &(impl AsRef<[AvatarMaterial]> + ?Sized),
    export: &Export,
) -> Result<Exported, GlbError> {
    write_all(avatar, materials.as_ref(), export)
}

fn write_all(
    avatar: &Avatar,
    materials: &[AvatarMaterial],
    export: &Export,
) -> Result<Exported, GlbError> {
    check::check(avatar, materials, export)?;
    let t_posed = match &export.vrm {
        Some(meta) => {
            vrm::check(meta, avatar)?;
            t_pose(avatar)?
        }
        None => None,
    };
    let posed_as_t = t_posed.is_some();
    let stand = t_posed.unwrap_or_else(|| Pose::rest(avatar.skeleton.joints().len()));
    let (skin, pruning) = avatar.skin.pruned(MAX_INFLUENCES);
    let (pruning_most, pruning_mean) = skin::error(avatar, &skin, &pruning)?;

    let mut buffer = Buffer::default();
    let parts = parts::write(avatar, &skin, export.normals.as_deref(), materials, &mut buffer);
    if parts.is_empty() {
        return Err(GlbError::NoTriangles);
    }
    let coarser = |CoarserLevel { avatar, normals }: &CoarserLevel| {
        let (skin, _) = avatar.skin.pruned(MAX_INFLUENCES);
        parts::write(avatar, &skin, normals.as_deref(), materials, &mut buffer)
    };
    let levels: Vec<_> = export.levels.iter().map(coarser).collect();
    let skin = skin::write_joints(avatar, &mut buffer);
    let clips = avatar.clips.iter();
    let animations =
        clips.map(|clip| clips::write(clip, &avatar.skeleton, &stand, &mut buffer)).collect();
    let is_inside = parts.iter().chain(levels.iter().flatten()).all(|part| part.is_inside);
    let thumbnail = export.thumbnail.as_ref().filter(|_| export.vrm.is_some());
    let written = textures::write(materials, is_inside, thumbnail, &mut buffer);
    let image_bytes = written.image_bytes;

    let vertices = parts.iter().map(|part| part.vertices).sum();
    let triangles = parts.iter().map(|part| part.triangles).sum();
    let slots = parts.len();
    let name = if export.name.is_empty() { "avatar" } else { &export.name };
    let graph = nodes::graph(avatar, &stand, name, materials, export.vrm.is_some(), parts, levels);
    let meshes = graph.shown.len();
    let root = document(avatar, export, graph, (skin, animations), written, &mut buffer);
    let bytes = Glb::write(&serde_json::to_vec(&root)?, &buffer.bytes)?;
    let report = Report {
        vertices,
        triangles,
        meshes,
        materials: slots,
        joints: avatar.skeleton.joints().len(),
        morphs: avatar.morphs.len(),
        clips: avatar.clips.len(),
        longest_clip: avatar.clips.iter().map(Clip::seconds).fold(0.0, f32::max),
        pruning,
        pruning_most,
        pruning_mean,
        posed_as_t,
        image_bytes,
        bytes: bytes.len(),
    };
    Ok(Exported { bytes, report })
}

/// The JSON chunk; takes the views and accessors of the buffer.
fn document(
    avatar: &Avatar,
    export: &Export,
    graph: nodes::Graph,
    (skin, animations): (json::Skin, Vec<json::Animation>),
    written: textures::Written,
    buffer: &mut Buffer,
) -> json::Root {
    let mut extensions = written.extensions;
    if !export.levels.is_empty() {
        extensions.push((nodes::LEVELS, false));
    }
    let vrm = export.vrm.as_ref().map(|meta| {
        extensions.push((vrm::EXTENSION, false));
        json::RootExtensions { vrm: vrm::extension(meta, avatar, &graph.shown, written.thumbnail) }
    });
    let required = extensions.iter().filter(|(_, required)| *required);
    json::Root {
        asset: json::Asset {
            version: "2.0",
            generator: concat!("uvgraft ", env!("CARGO_PKG_VERSION")).to_owned(),
            copyright: export.copyright.clone(),
            extras: export.extras.clone(),
        },
        extensions_used: extensions.iter().map(|&(name, _)| name).collect(),
        extensions_required: required.map(|&(name, _)| name).collect(),
        scene: 0,
        scenes: vec![graph.scene],
        nodes: graph.nodes,
        meshes: graph.meshes,
        skins: vec![skin],
        materials: written.materials,
        textures: written.textures,
        images: written.images,
        samplers: written.samplers,
        animations,
        accessors: std::mem::take(&mut buffer.accessors),
        buffers: vec![json::Buffer { byte_length: buffer.bytes.len() }],
        buffer_views: std::mem::take(&mut buffer.views),
        extensions: vrm,
    }
}
