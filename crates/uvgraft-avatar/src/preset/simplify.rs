//! Fewer triangles, between fewer of the same vertices, so that what stays keeps its place, coordinates,
//! weights and offsets.
//!
//! Based on Garland and Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997, and Hoppe,
//! "New Quadric Metric for Simplifying Meshes with Appearance Attributes", 1999, by the library
//! meshoptimizer. Seams of the layout are edges with vertices on either side at one place; they collapse
//! on both sides at once, so nothing opens.

use glam::{Quat, Vec3};
use meshopt::{SimplifyOptions, simplify_with_attributes_and_locks_decoder};
use uvgraft::{Mesh, MeshError};

use super::subset::with_faces;
use crate::Avatar;
use crate::glb::shading::Shading;
use crate::glb::vertices::Vertices;
use crate::rig::Rigid;

/// What simplifying did.
#[derive(Debug, Clone)]
pub struct Simplified {
    /// The avatar with fewer triangles; its parts have no names any more.
    pub avatar: Avatar,
    /// How many triangles there were.
    pub before: usize,
    /// How many there are.
    pub after: usize,
    /// How many were wanted.
    pub wanted: usize,
}

impl Simplified {
    /// Whether there are at most 5 % more than wanted. Seams, borders and the shape of small pieces
    /// can be in the way.
    pub const fn reached(&self) -> bool {
        self.after as u64 * 20 <= self.wanted as u64 * 21
    }
}

/// A vertex's values that count beside its place: coordinate, normal, where bends take it, and where
/// morphs do. 32 is the most that meshoptimizer takes.
const MORPH_MIXES: usize = 6;
const BENDS: usize = 3;
const VALUES: usize = 2 + 3 + 3 * BENDS + 3 * MORPH_MIXES;

/// What they count, against a place in units of the mesh's extent. A coordinate's whole range is
/// somewhat longer than a body.
const COORDINATE: f32 = 0.5;
const NORMAL: f32 = 0.02;
const BEND: f32 = 1.0;
/// Faces move by millimetres and are looked at closely.
const MORPH: f32 = 4.0;

/// Simplifies an avatar to a number of triangles, or near it.
///
/// # Errors
/// [`MeshError`] if no triangle would be left.
pub fn simplify(avatar: Avatar, wanted: usize) -> Result<Simplified, MeshError> {
    let vertices = Vertices::new(&avatar.mesh, &Shading::new(&avatar.mesh), false);
    let before = avatar.mesh.faces().len();
    if vertices.indices.len() / 3 <= wanted {
        return Ok(Simplified { avatar, before, after: before, wanted });
    }
    let extent = extent(&vertices.positions);
    let values = values(&avatar, &vertices);
    let mut weights = [MORPH / extent; VALUES];
    weights[..2].fill(COORDINATE);
    weights[2..5].fill(NORMAL);
    weights[5..5 + 3 * BENDS].fill(BEND / extent);
    let unlocked = vec![false; vertices.count()];
    // As far as it takes: what the platform allows decides, not an error.
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
    let uv_faces: Vec<[u32; 3]> = indices.as_chunks().0.to_vec();
    let faces: Vec<[u32; 3]> =
        uv_faces.iter().map(|face| face.map(|index| vertices.from[index as usize])).collect();
    // Each vertex of a file has one coordinate, so those can have its numbers.
    let positions = avatar.mesh.positions().to_vec();
    let mesh = Mesh::from_triangles(positions, vertices.uv, &faces, &uv_faces)?;
    let avatar = with_faces(Avatar { mesh, ..avatar }, &faces, &uv_faces)?;
    Ok(Simplified { avatar, before, after: faces.len(), wanted })
}

fn extent(positions: &[[f32; 3]]) -> f32 {
    let places = || positions.iter().map(|&position| Vec3::from(position));
    let least = places().fold(Vec3::INFINITY, Vec3::min);
    let most = places().fold(Vec3::NEG_INFINITY, Vec3::max);
    (most - least).max_element().max(f32::MIN_POSITIVE)
}

/// For each vertex of a file its values, one after the other.
fn values(avatar: &Avatar, vertices: &Vertices) -> Vec<f32> {
    let mut all = vec![[0.0; VALUES]; vertices.count()];
    for (values, (uv, normal)) in all.iter_mut().zip(vertices.uv.iter().zip(&vertices.normals)) {
        values[..2].copy_from_slice(uv);
        values[2..5].copy_from_slice(normal);
    }
    let positions = avatar.mesh.positions();
    for axis in 0..BENDS {
        // Each joint turns by itself and against its neighbours, so where weights change, places do.
        let bent = avatar.skin.pose(positions, &twist(avatar, axis));
        for (values, &vertex) in all.iter_mut().zip(&vertices.from) {
            let offset = Vec3::from(bent[vertex as usize]) - Vec3::from(positions[vertex as usize]);
            values[5 + 3 * axis..8 + 3 * axis].copy_from_slice(&offset.to_array());
        }
    }
    for (number, morph) in avatar.morphs.iter().enumerate() {
        // Morphs beyond six share; what moves other parts of a face doesn't meet.
        let first = 5 + 3 * BENDS + 3 * (number % MORPH_MIXES);
        for (vertex, offset) in vertices.spread(&morph.offsets) {
            let values = &mut all[vertex as usize][first..first + 3];
            values.iter_mut().zip(offset).for_each(|(value, offset)| *value += offset);
        }
    }
    all.into_flattened()
}

/// Turns of each joint around its own place, by 45° or, for every other generation, back.
fn twist(avatar: &Avatar, axis: usize) -> Vec<Rigid> {
    let mut generations: Vec<usize> = Vec::new();
    for joint in avatar.skeleton.joints() {
        generations.push(joint.parent.map_or(0, |parent| generations[parent] + 1));
    }
    let turn = |(joint, generation): (&crate::rig::Joint, usize)| {
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
        let after = &simplified.avatar;
        after.check().unwrap();
        assert_eq!(after.mesh.faces().len(), simplified.after);
        for (vertex, position) in after.mesh.positions().iter().enumerate() {
            let known = avatar.mesh.positions().iter().position(|known| known == position).unwrap();
            assert_eq!(after.skin.of(vertex), avatar.skin.of(known));
            let offset = |avatar: &Avatar, vertex: usize| {
                let offsets = &avatar.morphs[1].offsets;
                offsets.iter().find(|(v, _)| *v as usize == vertex).map(|&(_, offset)| offset)
            };
            assert_eq!(offset(after, vertex), offset(&avatar, known));
        }
        // The tube is open at both ends and nowhere else.
        assert_eq!(borders(&after.mesh).loops, 2);
        assert_eq!(simplify(avatar.clone(), 96).unwrap().avatar.mesh, avatar.mesh);
    }

    #[test]
    fn five_in_a_hundred_more_are_near_enough() {
        let simplified = |after| Simplified { avatar: tube(), before: 96, after, wanted: 60 };
        assert!(simplified(63).reached() && !simplified(64).reached());
        assert_eq!(simplify(tube(), 0).unwrap_err(), MeshError::NoFaces);
    }
}
