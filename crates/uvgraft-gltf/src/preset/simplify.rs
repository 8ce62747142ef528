//! Mesh simplification that keeps a subset of the vertices, so the remaining ones keep their
//! positions, UV coordinates, weights and offsets.
//!
//! Based on Garland and Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997, and
//! Hoppe, "New Quadric Metric for Simplifying Meshes with Appearance Attributes", 1999, as
//! implemented by the library meshoptimizer. UV seams are edges with separate vertices on both
//! sides at the same position; they collapse on both sides at once, so they do not open. Boundaries
//! between materials are seams too.

use glam::{Quat, Vec3};
use meshopt::{SimplifyOptions, simplify_with_attributes_and_locks_decoder};
use uvgraft::{Mesh, MeshError};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::{HumanBone, Rigid};

use super::slivers::swap_edges;
use super::subset::{Triangles, kept, with_faces};
use crate::glb::shading::Shading;
use crate::glb::vertices::{Inputs, Vertices};

/// Result of a simplification.
#[derive(Debug, Clone)]
pub struct Simplified {
    /// The simplified avatar; names of its mesh parts are lost.
    pub avatar: Avatar,
    /// The original normals of its vertices: triangles are larger now, and keeping these normals
    /// makes that less visible in the shading.
    pub normals: Vec<[f32; 3]>,
    /// Number of triangles before.
    pub before: usize,
    /// Number of triangles after.
    pub after: usize,
    /// The requested number of triangles.
    pub wanted: usize,
}

impl Simplified {
    /// Whether the result exceeds the requested number by at most 5 %. Seams, boundaries and the
    /// shape of small components can prevent it.
    pub const fn reached(&self) -> bool {
        self.after as u64 * 20 <= self.wanted as u64 * 21
    }
}

/// Layout of a vertex's attributes: UV coordinate, normal, displacement under bends, position
/// within the head, and displacement by morphs. 32 is meshoptimizer's maximum.
const BENDS: usize = 3;
const MORPH_MIXES: usize = 5;
const NORMAL_AT: usize = 2;
const BENDS_AT: usize = 5;
const HEAD_AT: usize = BENDS_AT + 3 * BENDS;
const MORPHS_AT: usize = HEAD_AT + 3;
const VALUES: usize = MORPHS_AT + 3 * MORPH_MIXES;

/// Weights of attribute errors relative to a position error of one metre: for UV coordinates, whose
/// full range is about as long as a body, for displacements by rotations of 45°, and for
/// displacements by full morphs, both in metres.
///
/// Chosen on the example figure at 10,000 of 30,000 triangles. Compared with positions alone, UV
/// errors are halved (1.7 instead of 3.4 texels of 1024 at the 95th percentile), pose errors are
/// about a quarter (2.4 instead of 11 mm), the face is more accurate, and errors on the rest of the
/// body are doubled (1.9 instead of 0.9 mm).
const COORDINATE: f32 = 0.3;
const BEND: f32 = 0.03;
const MORPH: f32 = 1.0;
/// Extra weight of position errors on the head, because faces are seen close up.
const HEAD: f32 = 3.0;
/// Weight of normal errors, multiplied by the edge length.
const NORMAL: f32 = 0.3;

/// Simplifies an avatar to about the given number of triangles.
///
/// # Errors
/// [`MeshError`] if no triangle would be left.
pub fn simplify(avatar: Avatar, wanted: usize) -> Result<Simplified, MeshError> {
    simplify_shown(avatar, &[], wanted)
}

/// Like [`simplify`], for an avatar with given normals.
///
/// Collapses edges in the order of their quadric error, measured on positions and on the attributes
/// from [`values`]. Without the attributes, simplification is optimal for the rest shape only:
/// textures slide, and joints and faces lose the vertices that they need to deform. Slivers are
/// then removed by edge swaps, and unused vertices dropped.
///
/// - `normals`: `[vertices]`, or empty for smooth normals.
pub(super) fn simplify_shown(
    avatar: Avatar,
    normals: &[[f32; 3]],
    wanted: usize,
) -> Result<Simplified, MeshError> {
    let shading = Shading::new(&avatar.mesh).with_normals(normals);
    let inputs = Inputs { materials: &avatar.materials, ..Inputs::default() };
    let vertices = Vertices::new(&avatar.mesh, &shading, inputs);
    let before = avatar.mesh.faces().len();
    let all_normals: Vec<[f32; 3]> = shading.shown.iter().map(|&normal| normal.into()).collect();
    if vertices.indices.len() / 3 <= wanted {
        return Ok(Simplified { avatar, normals: all_normals, before, after: before, wanted });
    }
    let values = values(&avatar, &vertices);
    let weights = weights(&avatar.mesh, wanted);
    let unlocked = vec![false; vertices.count()];
    // No error limit: the triangle budget decides.
    let any_error = f32::MAX;
    let indices = simplify_with_attributes_and_locks_decoder(
        &vertices.indices,
        &vertices.positions,
        &values,
        &weights,
        VALUES * size_of::<f32>(),
        &unlocked,
        wanted * 3,
        any_error,
        SimplifyOptions::None,
        None,
    );
    let mut uv_faces: Vec<[u32; 3]> = indices.as_chunks().0.to_vec();
    swap_edges(&shading, &avatar.morphs, &vertices, &mut uv_faces);
    let faces: Vec<[u32; 3]> =
        uv_faces.iter().map(|face| face.map(|index| vertices.from[index as usize])).collect();
    // Vertices are not merged across seams, so all corners of a triangle have the same material.
    let material = |face: &[u32; 3]| vertices.materials[face[0] as usize];
    let is_of_several = !avatar.materials.is_empty();
    let materials = uv_faces.iter().filter(|_| is_of_several).map(material).collect();
    // Each vertex has one UV coordinate, so vertex indices are also UV indices.
    let positions = avatar.mesh.positions().to_vec();
    let mesh = Mesh::from_triangles(positions, vertices.uv, &faces, &uv_faces)?;
    let normals = kept(&faces, &all_normals);
    let triangles = Triangles { faces: &faces, uv_faces: &uv_faces, materials };
    let avatar = with_faces(Avatar { mesh, ..avatar }, triangles)?;
    Ok(Simplified { avatar, normals, before, after: faces.len(), wanted })
}

/// Attribute weights in meshoptimizer's units: it measures positions relative to the mesh's extent,
/// and multiplies attribute errors by the length of the collapsed edge.
///
/// With `edge = sqrt(area / triangles)` as the expected edge length, a weight `w` per metre becomes
/// `w / edge`, and a UV weight `w · extent / edge`.
fn weights(mesh: &Mesh, wanted: usize) -> [f32; VALUES] {
    let places = || mesh.positions().iter().map(|&position| Vec3::from(position));
    let least = places().fold(Vec3::INFINITY, Vec3::min);
    let most = places().fold(Vec3::NEG_INFINITY, Vec3::max);
    let extent = (most - least).max_element();
    let area = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|vertex| Vec3::from(mesh.positions()[vertex as usize]));
        (b - a).cross(c - a).length() / 2.0
    };
    let area: f32 = mesh.faces().iter().map(area).sum();
    let edge = (area / wanted.max(1) as f32).sqrt().max(f32::MIN_POSITIVE);
    let mut weights = [MORPH / edge; VALUES];
    weights[..NORMAL_AT].fill(COORDINATE * extent / edge);
    weights[NORMAL_AT..BENDS_AT].fill(NORMAL);
    weights[BENDS_AT..HEAD_AT].fill(BEND / edge);
    weights[HEAD_AT..MORPHS_AT].fill(HEAD / edge);
    weights
}

/// The attributes of all vertices, concatenated.
fn values(avatar: &Avatar, vertices: &Vertices) -> Vec<f32> {
    let mut all = vec![[0.0; VALUES]; vertices.count()];
    for (values, (uv, normal)) in all.iter_mut().zip(vertices.uv.iter().zip(&vertices.normals)) {
        values[..NORMAL_AT].copy_from_slice(uv);
        values[NORMAL_AT..BENDS_AT].copy_from_slice(normal);
    }
    let positions = avatar.mesh.positions();
    let mut put = |at: usize, of: &dyn Fn(usize) -> Vec3| {
        for (values, &vertex) in all.iter_mut().zip(&vertices.from) {
            values[at..at + 3].copy_from_slice(&of(vertex as usize).to_array());
        }
    };
    for axis in 0..BENDS {
        // Each joint rotates on its own and opposite to its neighbours, so displacements
        // differ wherever weights change.
        let bent = avatar.skin.pose(positions, &twist(avatar, axis));
        put(BENDS_AT + 3 * axis, &|v| Vec3::from(bent[v]) - Vec3::from(positions[v]));
    }
    if let Some((place, shares)) = head(avatar) {
        put(HEAD_AT, &|v| shares[v] * (Vec3::from(positions[v]) - place));
    }
    for (number, morph) in avatar.morphs.iter().enumerate() {
        // There are fewer slots than morphs, so morphs share them; usually they move different
        // parts of a face.
        let at = MORPHS_AT + 3 * (number % MORPH_MIXES);
        for (vertex, offset) in vertices.spread(&morph.offsets) {
            let values = &mut all[vertex as usize][at..at + 3];
            values.iter_mut().zip(offset).for_each(|(value, offset)| *value += offset);
        }
    }
    all.into_flattened()
}

/// Position of the head joint, and the total weight of the head joint and its descendants at each
/// vertex.
fn head(avatar: &Avatar) -> Option<(Vec3, Vec<f32>)> {
    let head = avatar.skeleton.human(HumanBone::Head)?;
    let position = avatar.skeleton.joints()[head].position;
    Some((position.into(), avatar.skin.weights_below(&avatar.skeleton, head)))
}

/// Rotations of each joint about its own position, by 45°, or -45° in every other generation.
fn twist(avatar: &Avatar, axis: usize) -> Vec<Rigid> {
    let mut generations: Vec<usize> = Vec::new();
    for joint in avatar.skeleton.joints() {
        generations.push(joint.parent.map_or(0, |parent| generations[parent] + 1));
    }
    let turn = |(joint, generation): (&uvgraft_avatar::rig::Joint, usize)| {
        let angle = if generation.is_multiple_of(2) { 45.0_f32 } else { -45.0 };
        let rotation = Quat::from_axis_angle(Vec3::AXES[axis], angle.to_radians());
        let place = Vec3::from(joint.position);
        Rigid { rotation: rotation.into(), translation: (place - rotation * place).into() }
    };
    avatar.skeleton.joints().iter().zip(generations).map(turn).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glb::testing::tube;
    use crate::preset::testing::borders;

    #[test]
    fn fewer_triangles_between_the_same_vertices() {
        let avatar = tube();
        let simplified = simplify(avatar.clone(), 60).unwrap();
        assert_eq!((simplified.before, simplified.wanted), (96, 60));
        assert!(simplified.reached(), "{}", simplified.after);
        let (after, shading) = (&simplified.avatar, Shading::new(&avatar.mesh));
        after.check().unwrap();
        assert_eq!(after.mesh.faces().len(), simplified.after);
        for (vertex, position) in after.mesh.positions().iter().enumerate() {
            let known = avatar.mesh.positions().iter().position(|known| known == position).unwrap();
            assert_eq!(after.skin.of(vertex), avatar.skin.of(known));
            assert_eq!(Vec3::from(simplified.normals[vertex]), shading.normals[known]);
            let offset = |avatar: &Avatar, vertex: usize| {
                let offsets = &avatar.morphs[1].offsets;
                offsets.iter().find(|(v, _)| *v as usize == vertex).map(|&(_, offset)| offset)
            };
            assert_eq!(offset(after, vertex), offset(&avatar, known));
        }
        // The tube is open only at its ends.
        assert_eq!(borders(&after.mesh).loops, 2);
        assert_eq!(simplify(avatar.clone(), 96).unwrap().avatar.mesh, avatar.mesh);
    }

    #[test]
    fn materials_keep_their_triangles() {
        let mut avatar = tube();
        // The upper half has another material; the UV islands are unchanged.
        avatar.materials = (0..96).map(|face| u8::from(face >= 48)).collect();
        let after = simplify(avatar, 60).unwrap().avatar;
        after.check().unwrap();
        let vertices = Vertices::new(
            &after.mesh,
            &Shading::new(&after.mesh),
            Inputs { materials: &after.materials, ..Inputs::default() },
        );
        for (face, corners) in after.mesh.faces().iter().enumerate() {
            let side = |vertex: u32| after.mesh.positions()[vertex as usize][1] - 0.3;
            let wanted = if after.material(face) == 1 { 1.0 } else { -1.0 };
            let off = corners.iter().map(|&vertex| wanted * side(vertex)).fold(1.0, f32::min);
            assert!(off > -1e-6, "{face}: {off}");
        }
        assert!(vertices.materials.contains(&0) && vertices.materials.contains(&1));
        assert_eq!(borders(&after.mesh).loops, 2);
    }

    #[test]
    fn five_percent_over_budget_is_accepted() {
        let normals = Vec::new();
        let start = Simplified { avatar: tube(), normals, before: 96, after: 96, wanted: 60 };
        let simplified = |after| Simplified { after, ..start.clone() };
        assert!(simplified(63).reached() && !simplified(64).reached());
        assert_eq!(simplify(tube(), 0).unwrap_err(), MeshError::NoFaces);
    }
}
