//! What a file contains, for a report: its parts, images, skeleton, expressions and clips.
//!
//! Neither geometry nor images are decoded, so damaged ones do not stop the report.

mod images;
#[cfg(test)]
mod tests;

use std::path::Path;

use serde::Serialize;
use uvgraft_files::input::{Input, ReadError};

pub use self::images::{ImageContents, ImageUse};
use super::accessor::Accessors;
use super::asset::{Asset, folder_of};
use super::budget::{MAX_BYTES, MAX_NAME_BYTES, MAX_PRIMITIVES, Purpose};
use super::check::{find, too_many};
use super::document::{Document, Mesh, Primitive};
use super::error::SceneError;
use super::geometry::is_surface;
use super::{Clip, Hierarchy, clip, geometry, humanoid, unpack};

/// What a GLB, VRM or glTF file contains.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Contents {
    /// The program that wrote it, as it says.
    pub generator: Option<String>,
    /// The version of VRM, if it is one.
    pub vrm: Option<&'static str>,
    /// The surfaces of the file's scene: a primitive of a mesh, as a node shows it.
    pub parts: Vec<PartContents>,
    /// All images.
    pub images: Vec<ImageContents>,
    /// Number of joints of all skins together.
    pub joints: usize,
    /// VRM names of the humanoid bones, given by VRM or by the names of nodes.
    pub bones: Vec<String>,
    /// Names of VRM's expressions.
    pub expressions: Vec<String>,
    /// Names of morph targets.
    pub morph_targets: Vec<String>,
    /// The animations.
    pub clips: Vec<ClipContents>,
}

/// A surface with one material.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PartContents {
    /// Name of the node.
    pub node: String,
    /// Name of the mesh.
    pub mesh: String,
    /// Name of the material.
    pub material: String,
    /// Number of vertices of all instances together.
    pub vertices: usize,
    /// Number of triangles of all instances together.
    pub triangles: usize,
    /// How often the node draws it: 1 unless the file uses `EXT_mesh_gpu_instancing`.
    pub instances: usize,
    /// The UV sets: `n` of `TEXCOORD_n`.
    pub uv_sets: Vec<u32>,
    /// Number of morph targets.
    pub morph_targets: usize,
    /// Whether it follows a skeleton.
    pub is_skinned: bool,
}

/// An animation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClipContents {
    /// Its name.
    pub name: String,
    /// Its length.
    pub seconds: f32,
    /// Number of its channels that are ignored because they have no keys.
    pub channels_without_keys: usize,
}

impl ClipContents {
    fn of(clip: Clip) -> Self {
        let Clip { name, seconds, channels_without_keys, .. } = clip;
        Self { name, seconds, channels_without_keys }
    }
}

/// Reads what a GLB, VRM or glTF file contains.
///
/// # Errors
/// [`ReadError`] with the path or name, for files that are damaged, too large or refer to what does
/// not exist.
pub fn contents(input: impl Into<Input>) -> Result<Contents, ReadError<SceneError>> {
    let input = input.into();
    input.parse(MAX_BYTES, |bytes| read_in(bytes, folder_of(&input)))
}

fn read_in(bytes: &[u8], folder: Option<&Path>) -> Result<Contents, SceneError> {
    let mut asset = Asset::for_geometry(bytes, folder)?;
    let mut buffers = asset.buffers()?;
    let mut demand = asset.demand();
    demand.add_nodes(&asset.document)?;
    demand.add_clips(&asset.document)?;
    demand.add_expressions(&asset.document)?;
    demand.add_unpacked(&asset.document)?;
    demand.add(Purpose::Structure, parts_of(&asset.document)?, PART);
    demand.check()?;
    unpack::unpack(&mut asset.document, &mut buffers)?;
    let document = &asset.document;
    let json: serde_json::Value = serde_json::from_slice(asset.json)?;
    let mut accessors = Accessors::new(document, &buffers);
    let hierarchy = Hierarchy::new(document, &geometry::outlines(document)?, None)?;
    let targets: Vec<usize> = hierarchy.nodes.iter().map(|node| node.weights.len()).collect();
    let clips = clip::clips(document, &mut accessors, &targets)?.into_iter();
    let vrm0 = document.extensions.vrm0.as_ref();
    let from_vrm0 = vrm0.map(|vrm0| vrm0.as_vrm1(document)).transpose()?;
    let vrm = document.extensions.vrm.as_ref();
    let version = vrm.map(|_| "1.0").or(from_vrm0.as_ref().map(|_| "0.x"));
    let vrm = vrm.or(from_vrm0.as_ref());
    let expressions = vrm.iter().flat_map(|vrm| {
        vrm.expressions.preset.keys().chain(vrm.expressions.custom.keys()).cloned()
    });
    let mut joints: Vec<u32> =
        document.skins.iter().flat_map(|skin| skin.joints.iter().copied()).collect();
    joints.sort_unstable();
    joints.dedup();
    Ok(Contents {
        generator: json["asset"]["generator"].as_str().map(str::to_owned),
        vrm: version,
        parts: parts(document, &hierarchy, &accessors)?,
        images: images::images(&asset, &json, &accessors)?,
        joints: joints.len(),
        bones: humanoid::bones(vrm, &document.nodes)?.into_keys().collect(),
        expressions: expressions.collect(),
        morph_targets: target_names(document),
        clips: clips.map(ClipContents::of).collect(),
    })
}

/// Bytes of a part, without its names.
const PART: u64 = 256;

/// Number of the parts of all nodes.
///
/// # Errors
/// If there are too many, or if their names are too long.
fn parts_of(document: &Document) -> Result<u64, SceneError> {
    let name = |name: Option<&String>| name.map_or(0, String::len) as u64;
    let of_mesh = |mesh: &Mesh| {
        let materials = mesh.primitives.iter().filter_map(|it| it.material);
        let materials = materials.filter_map(|index| document.materials.get(index as usize));
        let materials: u64 = materials.map(|material| name(material.name.as_ref())).sum();
        let sets: u64 = mesh.primitives.iter().map(|it| it.attributes.len() as u64).sum();
        let count = mesh.primitives.len() as u64;
        (count, count * name(mesh.name.as_ref()) + materials + 4 * sets)
    };
    let of_meshes: Vec<_> = document.meshes.iter().map(of_mesh).collect();
    let (mut parts, mut bytes) = (0_u64, 0_u64);
    for node in &document.nodes {
        let Some(&(count, of_mesh)) = node.mesh.and_then(|it| of_meshes.get(it as usize)) else {
            continue;
        };
        parts = parts.saturating_add(count);
        bytes = bytes.saturating_add(of_mesh).saturating_add(count * name(node.name.as_ref()));
    }
    too_many("parts, of all nodes", parts, MAX_PRIMITIVES)?;
    too_many("bytes of names of parts", bytes, MAX_NAME_BYTES)?;
    Ok(parts)
}

fn parts(
    document: &Document,
    hierarchy: &Hierarchy,
    accessors: &Accessors<'_>,
) -> Result<Vec<PartContents>, SceneError> {
    let mut parts = Vec::new();
    for &index in &hierarchy.shown {
        let node = &hierarchy.nodes[index];
        let Some(number) = node.mesh else { continue };
        let mesh = find(&document.meshes, number as u32, "mesh", &format!("node {index}"))?;
        for primitive in mesh.primitives.iter().filter(|primitive| is_surface(primitive)) {
            let material = primitive.material.and_then(|it| document.materials.get(it as usize));
            let name = |name: Option<&String>| name.cloned().unwrap_or_default();
            let vertices = primitive.attributes.get("POSITION").map(|&it| accessors.count(it));
            let vertices = vertices.transpose()?.unwrap_or(0);
            let instances = instances_of(document, index);
            let triangles = triangles(primitive, vertices, accessors)?;
            parts.push(PartContents {
                node: node.name.clone(),
                mesh: name(mesh.name.as_ref()),
                material: name(material.and_then(|material| material.name.as_ref())),
                vertices: instances.saturating_mul(vertices),
                triangles: instances.saturating_mul(triangles),
                instances,
                uv_sets: uv_sets(primitive),
                morph_targets: primitive.targets.len(),
                is_skinned: node.skin.is_some(),
            });
        }
    }
    Ok(parts)
}

/// How often a node draws its mesh. Nodes that readers add, at the end, have none.
fn instances_of(document: &Document, node: usize) -> usize {
    let count = document.nodes.get(node).map_or(1, |node| document.instances(node));
    usize::try_from(count).unwrap_or(usize::MAX)
}

/// Number of triangles of a list, a strip or a fan.
fn triangles(
    primitive: &Primitive,
    vertices: usize,
    accessors: &Accessors<'_>,
) -> Result<usize, SceneError> {
    let corners = primitive.indices.map_or(Ok(vertices), |indices| accessors.count(indices))?;
    Ok(if primitive.mode.unwrap_or(4) == 4 { corners / 3 } else { corners.saturating_sub(2) })
}

fn uv_sets(primitive: &Primitive) -> Vec<u32> {
    let number = |name: &String| name.strip_prefix("TEXCOORD_")?.parse().ok();
    let mut sets: Vec<u32> = primitive.attributes.keys().filter_map(number).collect();
    sets.sort_unstable();
    sets
}

/// The names of all morph targets, without repetition.
fn target_names(document: &Document) -> Vec<String> {
    let mut known = std::collections::HashSet::new();
    let of_mesh = |mesh: &'_ Mesh| {
        let of_primitives = mesh.primitives.iter().flat_map(|it| it.extras.target_names.clone());
        mesh.extras.target_names.iter().cloned().chain(of_primitives).collect::<Vec<_>>()
    };
    let names = document.meshes.iter().flat_map(of_mesh);
    names.filter(|name| known.insert(name.clone())).collect()
}
