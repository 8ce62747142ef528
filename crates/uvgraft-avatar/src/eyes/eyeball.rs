//! Eyeballs: connected components that follow an eye joint and are nearly spherical.

use std::collections::HashMap;

use glam::{DMat3, DVec3, Vec3};
use uvgraft::Mesh;
use uvgraft::disjoint::DisjointSets;
use uvgraft::mesh::bits_of;

use crate::Avatar;
use crate::rig::HumanBone;

/// Tolerance of an eyeball's vertices around a sphere, relative to its radius: corneas bulge.
const ROUNDNESS: f32 = 0.2;

/// A nearly spherical connected component of a mesh.
#[derive(Debug, Clone)]
pub struct Eyeball {
    /// Its label in [`pieces`].
    pub piece: u32,
    /// Its vertices, ascending.
    pub vertices: Vec<u32>,
    /// The centre of the sphere, at rest.
    pub center: Vec3,
    /// The sphere's radius.
    pub radius: f32,
}

/// For each vertex the label of its connected component; triangles and equal positions
/// connect vertices.
pub fn pieces(mesh: &Mesh) -> Vec<u32> {
    let count = mesh.positions().len() as u32;
    let mut sets = DisjointSets::new(count);
    let mut known = HashMap::new();
    for (vertex, position) in (0..).zip(mesh.positions()) {
        sets.join(vertex, *known.entry(bits_of(*position)).or_insert(vertex));
    }
    for &[a, b, c] in mesh.faces() {
        sets.join(a, b);
        sets.join(b, c);
    }
    (0..count).map(|vertex| sets.root(vertex)).collect()
}

/// The eyeballs that follow one of the two eye bones; empty if the skeleton lacks it.
pub fn eyeballs(avatar: &Avatar, bone: HumanBone, pieces: &[u32]) -> Vec<Eyeball> {
    let Some(joint) = avatar.skeleton.human(bone) else { return Vec::new() };
    let follows = |vertex: usize| {
        matches!(avatar.skin.of(vertex), [(first, weight), ..]
            if usize::from(*first) == joint && *weight > 0.99)
    };
    let mut found: Vec<u32> =
        (0..pieces.len()).filter(|&v| follows(v)).map(|v| pieces[v]).collect();
    found.sort_unstable();
    found.dedup();
    let mut eyeballs = Vec::new();
    for piece in found {
        let own = || (0..pieces.len()).filter(|&v| pieces[v] == piece);
        if !own().all(follows) {
            continue;
        }
        let vertices: Vec<u32> = own().map(|vertex| vertex as u32).collect();
        let positions = avatar.mesh.positions();
        let points: Vec<Vec3> =
            vertices.iter().map(|&vertex| positions[vertex as usize].into()).collect();
        let Some(ball) = sphere(&points).filter(|ball| is_round(&points, *ball)) else { continue };
        let (center, radius) = ball;
        eyeballs.push(Eyeball { piece, vertices, center, radius });
    }
    eyeballs
}

/// Whether points lie on a sphere, within the tolerance for eyeballs.
pub fn is_round(points: &[Vec3], (center, radius): (Vec3, f32)) -> bool {
    points.iter().all(|point| (point.distance(center) - radius).abs() < ROUNDNESS * radius)
}

/// Fits a sphere to points by least squares; returns its centre and radius. Eyeballs may be open at
/// the back, so the centre of a bounding box would be wrong.
///
/// With points measured from their mean, |p|² = 2 c·p + constant is linear in the centre c.
pub fn sphere(points: &[Vec3]) -> Option<(Vec3, f32)> {
    let count = points.len() as f64;
    let mean = points.iter().map(|point| point.as_dvec3()).sum::<DVec3>() / count;
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for point in points {
        let p = point.as_dvec3() - mean;
        matrix += DMat3::from_cols(p * p.x, p * p.y, p * p.z);
        right += p * p.length_squared() / 2.0;
    }
    // Flat sets of points have no sphere; dividing by the scale makes the test independent of size.
    let scale = (matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z) / 3.0;
    if matrix.determinant() <= 1e-6 * scale.powi(3) {
        return None;
    }
    let center = (mean + matrix.inverse() * right).as_vec3();
    let radius = points.iter().map(|point| point.distance(center)).sum::<f32>() / count as f32;
    Some((center, radius))
}
