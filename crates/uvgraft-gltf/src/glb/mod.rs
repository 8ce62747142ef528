//! Avatars as GLB files, and as VRM 1.0, which is GLB that knows which joints make a human.
//!
//! [`write()`] makes the bytes of a file. Its shape suits what reads such files: one mesh with one
//! primitive (a draw call) for each material, at the root of the scene beside the joints; vertices split
//! where the layout is; at most four joints a vertex; morph targets with names, sparse where that is smaller;
//! clips as rotations, and translations of the root. Nodes have the numbers of joints, the mesh's comes after
//! them. In a VRM file a head with a material of its own is a mesh of its own, so that its wearer need not see
//! it. Coarser levels are nodes beside the scene (`MSFT_lod`): who does not know them shows the finest.
//!
//! Sources: Khronos Group, "glTF 2.0 Specification", 2021; VRM Consortium, "VRMC_vrm-1.0"
//! (specification, 2022).

mod buffer;
mod check;
mod clips;
mod json;
#[cfg(feature = "ktx2")]
mod ktx2;
mod ktx2_header;
mod material;
mod mtoon;
mod nodes;
mod parts;
mod picture;
mod picture_error;
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
use uvgraft_avatar::rig::{MOST_INFLUENCES, Pose, Pruning};

use self::buffer::Buffer;
pub use self::check::GlbError;
#[cfg(all(test, feature = "ktx2"))]
pub(crate) use self::ktx2::encode as encode_ktx2;
pub(crate) use self::ktx2_header::KTX2_IDENTIFIER;
pub use self::material::{AvatarMaterial, Style};
pub use self::picture::Picture;
pub use self::picture_error::{PictureError, PictureFormat};
pub use self::t_pose::t_pose;
pub use self::vrm::{Permissions, VrmError, VrmMeta};
use crate::container::Glb;

/// What to write beside the avatar and its materials.
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
    /// Coarser levels of the avatar, the finest of them first, for readers that know `MSFT_lod`; not in VRM files.
    pub levels: Vec<CoarserLevel>,
    /// A square picture of the avatar, PNG or JPEG; VRM files alone have a place for it.
    pub thumbnail: Option<Picture>,
}

/// An avatar with fewer triangles, for when it is far away.
#[derive(Debug, Clone)]
pub struct CoarserLevel {
    /// With the joints and morphs of the avatar itself.
    pub avatar: Avatar,
    /// As [`Export::normals`].
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
    /// Triangles, of the finest level.
    pub triangles: usize,
    /// Meshes that are shown.
    pub meshes: usize,
    /// Materials, counted for each mesh: draw calls.
    pub materials: usize,
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

/// Writes an avatar as a GLB file, or as a VRM file if `export` has VRM's meta data. The same input
/// makes the same bytes.
///
/// The nodes of a VRM stand in a T-pose, by [`t_pose`]; the skin stays bound to the avatar's own rest, so
/// clips show what they show in a GLB.
///
/// - `materials`: one material, or all that [`Avatar::materials`] name.
///
/// # Errors
/// [`GlbError`] if the avatar is not sound, or is no human by VRM's rules where VRM is asked for.
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
    let mut t_posed = None;
    if let Some(meta) = &export.vrm {
        vrm::check(meta, avatar)?;
        t_posed = t_pose(avatar)?;
    }
    let posed_as_t = t_posed.is_some();
    let stand = t_posed.unwrap_or_else(|| Pose::rest(avatar.skeleton.joints().len()));
    let (skin, pruning) = avatar.skin.pruned(MOST_INFLUENCES);
    let (pruning_most, pruning_mean) = skin::error(avatar, &skin, &pruning)?;

    let mut buffer = Buffer::default();
    let parts = parts::write(avatar, &skin, export.normals.as_deref(), materials, &mut buffer);
    if parts.is_empty() {
        return Err(GlbError::NoTriangles);
    }
    let mut levels = Vec::with_capacity(export.levels.len());
    for level in &export.levels {
        let (skin, _) = level.avatar.skin.pruned(MOST_INFLUENCES);
        levels.push(parts::write(
            &level.avatar,
            &skin,
            level.normals.as_deref(),
            materials,
            &mut buffer,
        ));
    }
    let joints = avatar.skeleton.joints().len();
    let skin = skin::write_joints(avatar, &mut buffer);
    let clips = avatar.clips.iter();
    let animations =
        clips.map(|clip| clips::write(clip, &avatar.skeleton, &stand, &mut buffer)).collect();
    let is_inside = parts.iter().chain(levels.iter().flatten()).all(|part| part.is_inside);
    let thumbnail = export.thumbnail.as_ref().filter(|_| export.vrm.is_some());
    let written = textures::write(materials, is_inside, thumbnail, &mut buffer);
    let textures::Written { textures, images, samplers, image_bytes, .. } = written;
    let mut extensions = written.extensions;

    let vertices = parts.iter().map(|part| part.vertices).sum();
    let triangles = parts.iter().map(|part| part.triangles).sum();
    let slots = parts.len();
    let name = if export.name.is_empty() { "avatar" } else { &export.name };
    let graph = nodes::graph(avatar, &stand, name, materials, export.vrm.is_some(), parts, levels);
    if !export.levels.is_empty() {
        extensions.push((nodes::LEVELS, false));
    }
    let required = extensions.iter().filter(|(_, required)| *required).map(|&(name, _)| name);
    let extensions_required: Vec<&'static str> = required.collect();
    let root_extensions = export.vrm.as_ref().map(|meta| {
        extensions.push((vrm::EXTENSION, false));
        json::RootExtensions { vrm: vrm::extension(meta, avatar, &graph.shown, written.thumbnail) }
    });
    let meshes = graph.shown.len();
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
        scenes: vec![graph.scene],
        nodes: graph.nodes,
        meshes: graph.meshes,
        skins: vec![skin],
        materials: written.materials,
        textures,
        images,
        samplers,
        animations,
        accessors: buffer.accessors,
        buffers: vec![json::Buffer { byte_length: buffer.bytes.len() }],
        buffer_views: buffer.views,
        extensions: root_extensions,
    };
    let bytes = Glb::write(&serde_json::to_vec(&root)?, &buffer.bytes)?;
    let report = Report {
        vertices,
        triangles,
        meshes,
        materials: slots,
        joints,
        morphs: avatar.morphs.len(),
        clips: avatar.clips.len(),
        longest_clip: avatar
            .clips
            .iter()
            .map(uvgraft_avatar::rig::Clip::seconds)
            .fold(0.0, f32::max),
        pruning,
        pruning_most,
        pruning_mean,
        posed_as_t,
        image_bytes,
        bytes: bytes.len(),
    };
    Ok(Exported { bytes, report })
}
