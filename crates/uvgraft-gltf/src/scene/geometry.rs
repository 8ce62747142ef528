//! Reads meshes: primitives with their vertex attributes, morph targets and skin weights.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use glam::Vec3;

use super::accessor::Accessors;
use super::appearance::UvSource;
use super::document::{self, Document};
use super::error::SceneError;
use super::shared::SharedArrays;

/// The mesh of a node: primitives with one material each, and common morph weights.
#[derive(Debug)]
pub(crate) struct Mesh {
    pub primitives: Vec<Primitive>,
    /// Names of the morph targets; may be shorter than the number of targets.
    pub target_names: Vec<String>,
    /// Default weights of the targets, one each.
    pub weights: Vec<f32>,
}

/// Triangles with one material.
#[derive(Debug)]
pub(crate) struct Primitive {
    pub positions: Arc<[Vec3]>,
    pub normals: Normals,
    pub uv: Arc<[[f32; 2]]>,
    /// Further texture coordinates, for textures that have their own.
    pub more_uv: Vec<Arc<[[f32; 2]]>>,
    /// Linear RGBA.
    pub colors: Option<Arc<[[f32; 4]]>>,
    pub triangles: Arc<[[u32; 3]]>,
    pub material: usize,
    pub influences: Option<Arc<Influences>>,
    pub morphs: Vec<Morph>,
}

#[derive(Debug)]
pub(crate) enum Normals {
    Given(Arc<[Vec3]>),
    /// To be computed from the triangles: for each vertex, the first vertex at its position, so
    /// that seams of the layout do not show.
    Missing(Arc<[u32]>),
}

/// Non-zero displacements of a morph target at weight 1, by vertex.
#[derive(Debug, Default)]
pub(crate) struct Morph {
    pub positions: Displacements,
    pub normals: Displacements,
}

/// Vertices, and by how much they are displaced.
pub(crate) type Displacements = Arc<[(u32, Vec3)]>;

/// Joints of each vertex with their weights, which sum to 1.
#[derive(Debug)]
pub(crate) struct Influences {
    /// Start of each vertex's entries, and the end of the last.
    pub starts: Vec<u32>,
    pub entries: Vec<(u16, f32)>,
    /// Largest joint index plus one.
    pub joints: usize,
}

impl Influences {
    pub fn of(&self, vertex: usize) -> &[(u16, f32)] {
        &self.entries[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}

/// Reads all meshes.
///
/// - `uv_sources`: UV sources of each material, the last for primitives without one.
pub(super) fn meshes(
    document: &Document,
    accessors: &mut Accessors<'_>,
    uv_sources: &[Vec<UvSource>],
) -> Result<Vec<Mesh>, SceneError> {
    let mut arrays = SharedArrays::new(accessors);
    document
        .meshes
        .iter()
        .enumerate()
        .map(|(index, mesh)| read(mesh, index, &mut arrays, uv_sources))
        .collect()
}

/// All meshes without their primitives.
pub(super) fn outlines(document: &Document) -> Result<Vec<Mesh>, SceneError> {
    let outline = |(index, mesh): (usize, &document::Mesh)| {
        let targets = mesh.primitives.iter().map(|primitive| primitive.targets.len()).max();
        Ok(Mesh {
            primitives: Vec::new(),
            target_names: Vec::new(),
            weights: default_weights(mesh, index, targets.unwrap_or(0))?,
        })
    };
    document.meshes.iter().enumerate().map(outline).collect()
}

/// The weights of a mesh's morph targets where nodes do not state others.
fn default_weights(
    mesh: &document::Mesh,
    index: usize,
    targets: usize,
) -> Result<Vec<f32>, SceneError> {
    if mesh.weights.iter().any(|weight| !weight.is_finite()) {
        let reason = "weights must be finite";
        return Err(SceneError::content(format!("mesh {index}"), reason));
    }
    let mut weights = mesh.weights.clone();
    weights.resize(targets, 0.0);
    Ok(weights)
}

fn read(
    mesh: &document::Mesh,
    index: usize,
    arrays: &mut SharedArrays<'_, '_>,
    uv_sources: &[Vec<UvSource>],
) -> Result<Mesh, SceneError> {
    let mut primitives = Vec::new();
    for (number, primitive) in mesh.primitives.iter().enumerate() {
        let place = format!("mesh {index}, primitive {number}");
        if let Some(primitive) = read_primitive(primitive, &place, arrays, uv_sources)? {
            primitives.push(primitive);
        }
    }
    let targets = primitives.iter().map(|primitive| primitive.morphs.len()).max().unwrap_or(0);
    let weights = default_weights(mesh, index, targets)?;
    let named = |extras: &document::MeshExtras| !extras.target_names.is_empty();
    let extras = mesh.primitives.iter().map(|primitive| &primitive.extras);
    let target_names = std::iter::once(&mesh.extras)
        .chain(extras)
        .find(|extras| named(extras))
        .map_or_else(Vec::new, |extras| extras.target_names.clone());
    Ok(Mesh { primitives, target_names, weights })
}

/// A primitive; `None` if it has no positions, or consists of points or lines.
///
/// Indices and array lengths are checked against the number of vertices here, so that
/// posing can index without checks. There is one UV array for each UV source of the
/// material, already transformed.
fn read_primitive(
    primitive: &document::Primitive,
    place: &str,
    arrays: &mut SharedArrays<'_, '_>,
    uv_sources: &[Vec<UvSource>],
) -> Result<Option<Primitive>, SceneError> {
    if !is_surface(primitive) {
        return Ok(None);
    }
    let attribute = |name: &str| primitive.attributes.get(name).copied();
    let Some(place_of) = attribute("POSITION") else { return Ok(None) };
    let positions = arrays.vectors(place_of, None)?;
    let count = positions.len();
    let triangles = arrays.triangles(primitive, count, place)?;

    let material = primitive.material.map_or(uv_sources.len() - 1, |index| index as usize);
    let sources = uv_sources.get(material).ok_or_else(|| {
        let found = uv_sources.len() - 1;
        SceneError::content(
            place,
            format!("refers to material {material}, but the file has {found}"),
        )
    })?;
    let mut all_uv = Vec::new();
    for source in sources {
        let stored = attribute(&format!("TEXCOORD_{}", source.set));
        all_uv.push(arrays.uv(stored, count, source)?);
    }

    let colors = attribute("COLOR_0").map(|index| arrays.colors(index, count)).transpose()?;
    let normals = match attribute("NORMAL") {
        Some(index) => Normals::Given(arrays.vectors(index, Some(count))?),
        None => Normals::Missing(arrays.first_at_position(place_of, &positions)),
    };
    let mut moved = |target: &BTreeMap<String, u32>, name: &str| match target.get(name) {
        Some(&index) => arrays.displacements(index, count),
        None => Ok(Arc::default()),
    };
    let mut morphs = Vec::with_capacity(primitive.targets.len());
    for target in &primitive.targets {
        let (positions, normals) = (moved(target, "POSITION")?, moved(target, "NORMAL")?);
        morphs.push(Morph { positions, normals });
    }
    let influences = arrays.influences(primitive, count)?;
    Ok(Some(Primitive {
        positions,
        normals,
        uv: all_uv.remove(0),
        more_uv: all_uv,
        colors,
        triangles,
        material,
        influences,
        morphs,
    }))
}

/// Whether a primitive consists of triangles rather than points or lines, and has positions.
pub(super) fn is_surface(primitive: &document::Primitive) -> bool {
    primitive.mode.unwrap_or(4) >= 4 && primitive.attributes.contains_key("POSITION")
}

/// The triangles of a primitive that is a surface, with all indices checked.
///
/// - `count`: its number of vertices.
pub(super) fn read_triangles(
    primitive: &document::Primitive,
    count: usize,
    place: &str,
    accessors: &mut Accessors<'_>,
) -> Result<Vec<[u32; 3]>, SceneError> {
    let corners = match primitive.indices {
        Some(indices) => accessors.uints::<1>(indices, None)?.into_iter().map(|[i]| i).collect(),
        None => (0..count as u32).collect::<Vec<_>>(),
    };
    if let Some(at) = corners.iter().position(|&corner| corner as usize >= count) {
        let reason = format!("index {at} must be less than {count}, got {}", corners[at]);
        return Err(SceneError::content(place, reason));
    }
    triangles(&corners, primitive.mode.unwrap_or(4), place)
}

/// The vertices of a primitive and how a skin and morph targets move them, without any looks.
///
/// - `weights`: targets of weight 0 are not read.
pub(super) fn read_vertices(
    primitive: &document::Primitive,
    weights: &[f32],
    is_skinned: bool,
    accessors: &mut Accessors<'_>,
) -> Result<Primitive, SceneError> {
    let positions = match primitive.attributes.get("POSITION") {
        Some(&index) => vectors(accessors.floats(index, None)?),
        None => Vec::new(),
    };
    let count = positions.len();
    let mut morphs = Vec::new();
    for (target, &weight) in primitive.targets.iter().zip(weights) {
        let mut morph = Morph::default();
        if let (true, Some(&index)) = (weight != 0.0, target.get("POSITION")) {
            morph.positions = read_displacements(index, count, accessors)?;
        }
        morphs.push(morph);
    }
    let influences = match is_skinned {
        true => read_influences(&influence_sets(primitive), count, accessors)?.map(Arc::new),
        false => None,
    };
    Ok(Primitive {
        positions: positions.into(),
        normals: Normals::Given(Arc::default()),
        uv: Arc::from([]),
        more_uv: Vec::new(),
        colors: None,
        triangles: Arc::from([]),
        material: 0,
        influences,
        morphs,
    })
}

pub(super) fn vectors(values: Vec<[f32; 3]>) -> Vec<Vec3> {
    values.into_iter().map(Vec3::from).collect()
}

/// Converts lists, strips and fans to triangles; incomplete lists are an error.
fn triangles(corners: &[u32], mode: u32, place: &str) -> Result<Vec<[u32; 3]>, SceneError> {
    match mode {
        4 if corners.len().is_multiple_of(3) => {
            Ok(corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect())
        }
        4 => {
            let reason =
                format!("the number of indices must be a multiple of 3, got {}", corners.len());
            Err(SceneError::content(place, reason))
        }
        5 => Ok(corners
            .windows(3)
            .enumerate()
            .map(|(k, c)| if k % 2 == 0 { [c[0], c[1], c[2]] } else { [c[1], c[0], c[2]] })
            .collect()),
        6 => Ok(corners
            .get(1..)
            .unwrap_or_default()
            .windows(2)
            .map(|c| [c[0], c[1], corners[0]])
            .collect()),
        _ => Err(SceneError::content(place, format!("mode must be 0 to 6, got {mode}"))),
    }
}

pub(super) fn read_colors(
    index: u32,
    count: usize,
    accessors: &mut Accessors<'_>,
) -> Result<Vec<[f32; 4]>, SceneError> {
    if accessors.width(index)? == 3 {
        let colors = accessors.floats::<3>(index, Some(count))?;
        return Ok(colors.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect());
    }
    accessors.floats::<4>(index, Some(count))
}

pub(super) fn first_at_position(positions: &[Vec3]) -> Vec<u32> {
    let mut first = HashMap::new();
    (0u32..)
        .zip(positions)
        .map(|(vertex, p)| *first.entry([p.x, p.y, p.z].map(f32::to_bits)).or_insert(vertex))
        .collect()
}

/// The displacements of a morph target's positions or normals.
pub(super) fn read_displacements(
    index: u32,
    count: usize,
    accessors: &mut Accessors<'_>,
) -> Result<Displacements, SceneError> {
    let deltas = vectors(accessors.floats(index, Some(count))?);
    let moves = |delta: &Vec3| *delta != Vec3::default();
    let mut moved = Vec::with_capacity(deltas.iter().filter(|delta| moves(delta)).count());
    moved.extend((0u32..).zip(deltas).filter(|(_, delta)| moves(delta)));
    Ok(moved.into())
}

/// Accessors of joints and weights of all sets: `JOINTS_0` and `WEIGHTS_0`, `JOINTS_1`, ...
pub(super) fn influence_sets(primitive: &document::Primitive) -> Vec<[u32; 2]> {
    let named = |name: &str, set: u32| primitive.attributes.get(&format!("{name}_{set}")).copied();
    (0..).map_while(|set| Some([named("JOINTS", set)?, named("WEIGHTS", set)?])).collect()
}

/// Joints and weights from all sets, normalised to sum to 1; `None` without sets.
pub(super) fn read_influences(
    sets: &[[u32; 2]],
    count: usize,
    accessors: &mut Accessors<'_>,
) -> Result<Option<Influences>, SceneError> {
    if sets.is_empty() {
        return Ok(None);
    }
    let read = |&[joints, weights]: &[u32; 2]| {
        let joints = accessors.uints::<4>(joints, Some(count))?;
        Ok::<_, SceneError>((joints, accessors.floats::<4>(weights, Some(count))?))
    };
    let sets = sets.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let mut influences = Influences { starts: vec![0], entries: Vec::new(), joints: 0 };
    for vertex in 0..count {
        let start = influences.entries.len();
        for (joints, weights) in &sets {
            for (&joint, &weight) in joints[vertex].iter().zip(&weights[vertex]) {
                if weight > 0.0 {
                    // glTF stores joints in at most 16 bits, but `uints` also reads 32-bit values.
                    let small = u16::try_from(joint).map_err(|_| {
                        SceneError::content(
                            "joints",
                            format!("joint must be at most 65535, got {joint}"),
                        )
                    })?;
                    influences.entries.push((small, weight));
                }
            }
        }
        let own = &mut influences.entries[start..];
        let sum: f32 = own.iter().map(|entry| entry.1).sum();
        own.iter_mut().for_each(|entry| entry.1 /= sum);
        if own.is_empty() {
            // Vertices without weights follow the first joint, as in other viewers.
            influences.entries.push((0, 1.0));
        }
        influences.starts.push(influences.entries.len() as u32);
    }
    let largest = influences.entries.iter().map(|entry| usize::from(entry.0)).max();
    influences.joints = largest.map_or(0, |joint| joint + 1);
    Ok(Some(influences))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_the_winding() {
        let corners = [10, 11, 12, 13];
        assert_eq!(triangles(&corners, 5, "").unwrap(), [[10, 11, 12], [12, 11, 13]]);
        assert_eq!(triangles(&corners, 6, "").unwrap(), [[11, 12, 10], [12, 13, 10]]);
        assert!(triangles(&corners, 4, "").is_err() && triangles(&corners, 7, "").is_err());
        assert!(triangles(&[], 6, "").unwrap().is_empty());
    }
}
