//! Morphing, then linear blend skinning, vertex by vertex.
//!
//! # Source
//! Magnenat-Thalmann et al., "Joint-dependent local deformations for hand animation and object
//! grasping", 1988, in the form of glTF 2.0, section 3.7.3.

use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use uvgraft::threads;

use super::geometry::{Influences, Normals, Primitive};
use super::instances::InstancePose;
use super::transform::normal_matrix;

/// Vertices in a unit of parallel work, enough to amortise its overhead.
const CHUNK: usize = 1024;

/// World positions and unit normals of a primitive.
///
/// Positions are `Σ w_j M_j (p + Σ w_m Δ_m)`, with `M_j` the world transform of joint `j` times its
/// inverse bind matrix. Normals use the cofactor matrix of the blended transform, so they stay
/// perpendicular under scaling, and are defined even for singular transforms. Missing normals are
/// computed from the deformed triangles.
///
/// - `weights`: weights of the morph targets.
pub(super) fn deformed(
    primitive: &Primitive,
    weights: &[f32],
    pose: &InstancePose<'_>,
) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let mut positions = primitive.positions.to_vec();
    let mut normals = match &primitive.normals {
        Normals::Given(normals) => normals.to_vec(),
        Normals::Missing(_) => Vec::new(),
    };
    for (morph, &weight) in primitive.morphs.iter().zip(weights) {
        if weight != 0.0 {
            add(&mut positions, &morph.positions, weight);
            add(&mut normals, &morph.normals, weight);
        }
    }
    match (pose.joints, &primitive.influences) {
        (Some(joints), Some(influences)) => {
            skin(&mut positions, &mut normals, influences, joints);
            if let Some(moved) = &pose.moved {
                transform(&mut positions, &mut normals, moved);
            }
        }
        _ => transform(&mut positions, &mut normals, &pose.node),
    }
    if let Normals::Missing(first) = &primitive.normals {
        normals = area_weighted_normals(&positions, &primitive.triangles, first);
        // Mirroring reverses the winding.
        if pose.is_mirrored {
            normals.iter_mut().for_each(|normal| *normal = -*normal);
        }
    }
    let plain = |vectors: Vec<Vec3>| vectors.into_iter().map(Into::into).collect();
    (plain(positions), plain(normals))
}

fn add(vectors: &mut [Vec3], deltas: &[(u32, Vec3)], weight: f32) {
    for &(vertex, delta) in deltas {
        if let Some(vector) = vectors.get_mut(vertex as usize) {
            *vector += delta * weight;
        }
    }
}

fn map_normal(matrix: &Mat3A, normal: Vec3) -> Vec3 {
    (*matrix * normal).normalize_or_zero()
}

fn transform(positions: &mut [Vec3], normals: &mut [Vec3], node: &Affine3A) {
    let matrix = normal_matrix(&node.matrix3);
    threads::for_each_chunk(positions, CHUNK, |_, positions| {
        positions.iter_mut().for_each(|p| *p = node.transform_point3(*p));
    });
    threads::for_each_chunk(normals, CHUNK, |_, normals| {
        normals.iter_mut().for_each(|n| *n = map_normal(&matrix, *n));
    });
}

fn skin(
    positions: &mut [Vec3],
    normals: &mut [Vec3],
    influences: &Influences,
    joints: &[Affine3A],
) {
    let map = |vertex: usize| {
        let mut sum = Affine3A { matrix3: Mat3A::ZERO, translation: Vec3A::ZERO };
        for &(joint, weight) in influences.of(vertex) {
            let joint = &joints[usize::from(joint)];
            sum.matrix3 += joint.matrix3 * weight;
            sum.translation += joint.translation * weight;
        }
        sum
    };
    if normals.is_empty() {
        threads::for_each_chunk(positions, CHUNK, |chunk, positions| {
            for (k, p) in positions.iter_mut().enumerate() {
                *p = map(chunk * CHUNK + k).transform_point3(*p);
            }
        });
        return;
    }
    let chunks = positions.chunks_mut(CHUNK).zip(normals.chunks_mut(CHUNK));
    threads::for_each(chunks, |chunk, (positions, normals)| {
        for (k, (p, n)) in positions.iter_mut().zip(normals).enumerate() {
            let map = map(chunk * CHUNK + k);
            *p = map.transform_point3(*p);
            *n = map_normal(&normal_matrix(&map.matrix3), *n);
        }
    });
}

/// Area-weighted vertex normals, shared by all vertices at one position.
fn area_weighted_normals(positions: &[Vec3], triangles: &[[u32; 3]], first: &[u32]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::default(); positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
        let normal = (b - a).cross(c - a);
        for &vertex in triangle {
            let sum = &mut sums[first[vertex as usize] as usize];
            *sum += normal;
        }
    }
    first.iter().map(|&vertex| sums[vertex as usize].normalize_or_zero()).collect()
}
