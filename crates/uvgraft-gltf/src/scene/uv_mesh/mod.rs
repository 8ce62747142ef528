//! Reads a file, or a part of it, as one mesh with one of its UV sets.
//!
//! Only geometry is read: images may be missing or of any format.

mod choice;
mod gather;
mod image_names;
#[cfg(test)]
mod tests;

use std::path::Path;

use uvgraft::mesh::MeshError;
use uvgraft_files::input::{Input, ReadError};
use uvgraft_io::textured::TexturedMesh;

use self::gather::Gatherer;
use self::image_names::ImageNames;
use super::accessor::Accessors;
use super::asset::{Asset, folder_of};
use super::budget::MAX_BYTES;
use super::error::{SceneError, known};
use super::{Hierarchy, geometry, skins, unpack};

/// A part of a file, and one of its UV sets. The default is the whole scene, with the UV set of each
/// material's base colour.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct MeshChoice {
    /// Name of nodes; if no nodes with triangles have it, of meshes; and otherwise of materials.
    /// A node without a mesh stands for all nodes below it.
    pub name: Option<String>,
    /// `n` of `TEXCOORD_n`; `None` for the set that the base colour of each material uses, 0 where
    /// it has no texture.
    pub uv_set: Option<u32>,
}

/// Why a file was refused as a mesh.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneMeshError {
    /// The file is damaged, too large, or not supported.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene is empty, or has points and lines only.
    #[error("mesh must have triangles, but the scene of the file has none")]
    NoTriangles,
    /// Nothing that has triangles has the name.
    #[error("no node, mesh or material with triangles is named {name:?}; {}", known(choices))]
    Unknown {
        /// The name.
        name: String,
        /// The names that exist, shortened.
        choices: Vec<String>,
    },
    /// No primitive has the UV set.
    #[error("{place}: must have the UV set {set} (TEXCOORD_{set}), but has {}", sets_of(sets))]
    NoUvSet {
        /// The first primitive.
        place: String,
        /// The requested set.
        set: u32,
        /// Names of the sets that it has.
        sets: Vec<String>,
    },
    /// The mesh as a whole was rejected.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

fn sets_of(sets: &[String]) -> String {
    if sets.is_empty() { "no UV coordinates".to_owned() } else { sets.join(", ") }
}

/// Reads a self-contained GLB, VRM or glTF file as one mesh.
///
/// - Positions are in world space at rest: as the nodes of the file's scene place them, with the
///   rest weights of morph targets. Meshes with a skin follow their joints at rest, not their node.
///   VRM 0.x is turned to face +Z, as [`Scene`](super::Scene) does.
/// - UV coordinates are as stored, with the origin at the top left, unless the textures of the
///   material that use the set have a `KHR_texture_transform`, which is applied.
/// - Each instance of a node is there, with vertices and UV coordinates of its own.
/// - Nodes are in the order of the file, and so are the primitives of their meshes, and the vertices
///   and triangles of these. Primitives of a node that share their positions share vertices, and
///   likewise UV coordinates. Strips and fans become triangles; points and lines are skipped.
/// - Triangles of mirrored nodes are reversed, so that their fronts stay in front.
/// - Primitives without the UV set are left out, as long as others have it.
/// - [`Mesh::parts`](uvgraft::Mesh::parts) has the name of the node as object, that of the mesh as
///   group, that of the material, and that of the image of its base colour. Images with the same bytes
///   are one.
///
/// # Errors
/// [`SceneMeshError`] for anything truncated, damaged, dangling or too large, for unknown names,
/// and if no triangle has the UV set.
pub fn read_mesh(bytes: &[u8], choice: &MeshChoice) -> Result<TexturedMesh, SceneMeshError> {
    read_in(bytes, None, choice)
}

/// Reads a GLB, VRM or glTF file and its external buffers, which bytes cannot have, as one mesh; see [`read_mesh`].
///
/// # Errors
/// As [`read_mesh`], with the path; also if it refers to a file outside its folder.
pub fn load_mesh(
    input: impl Into<Input>,
    choice: &MeshChoice,
) -> Result<TexturedMesh, ReadError<SceneMeshError>> {
    let input = input.into();
    input.parse(MAX_BYTES, |bytes| read_in(bytes, folder_of(&input), choice))
}

fn read_in(
    bytes: &[u8],
    folder: Option<&Path>,
    choice: &MeshChoice,
) -> Result<TexturedMesh, SceneMeshError> {
    let mut asset = Asset::for_geometry(bytes, folder)?;
    let mut buffers = asset.buffers()?;
    let mut demand = asset.demand();
    demand.add_nodes(&asset.document)?;
    demand.add_unpacked(&asset.document)?;
    demand.check()?;
    unpack::unpack(&mut asset.document, &mut buffers)?;
    let document = &asset.document;
    let mut accessors = Accessors::new(document, &buffers);
    let hierarchy = Hierarchy::new(document, &geometry::outlines(document)?, Some(&mut accessors))?;
    let chosen = choice::chosen(document, &hierarchy, choice.name.as_deref())?;
    let skins = skins(document, &mut accessors)?;
    let image_names = ImageNames::new(document, &accessors);
    let mut gatherer = Gatherer::new(document, &hierarchy, &skins, choice.uv_set, image_names);
    gatherer.check_demand(&chosen, demand)?;
    for primitive in &chosen {
        gatherer.add(primitive, &mut accessors)?;
    }
    gatherer.finish()
}
