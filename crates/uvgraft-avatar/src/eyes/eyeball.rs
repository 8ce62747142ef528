//! Eyeballs: pieces of a mesh that follow an eye's joint and are about a sphere.

use std::collections::HashMap;

use glam::{DMat3, DVec3, Vec3};
use uvgraft::Mesh;
use uvgraft::disjoint::DisjointSets;

use crate::Avatar;
use crate::rig::HumanBone;

/// How far an eyeball's vertices may be from a sphere, in parts of its radius: corneas bulge.
const ROUNDNESS: f32 = 0.2;

/// A piece of the mesh that is about a sphere.
#[derive(Debug, Clone)]
pub struct Eyeball {
    /// Which of [`pieces`].
    pub piece: u32,
    /// Its vertices, rising.
    pub vertices: Vec<u32>,
    /// The middle of the sphere, at rest.
    pub center: Vec3,
    /// The sphere's radius.
    pub radius: f32,
}

/// For each vertex the piece that it is in: vertices that triangles join, or that are at one place.
pub fn pieces(mesh: &Mesh) -> Vec<u32> {
    let count = mesh.positions().len() as u32;
    let mut sets = DisjointSets::new(count);
    let mut known = HashMap::new();
    for (vertex, position) in (0..).zip(mesh.positions()) {
        let key = position.map(|value| (value + 0.0).to_bits());
        sets.join(vertex, *known.entry(key).or_insert(vertex));
    }
    for &[a, b, c] in mesh.faces() {
        sets.join(a, b);
        sets.join(b, c);
    }
    (0..count).map(|vertex| sets.root(vertex)).collect()
}

/// The eyeballs that follow one of the two eye bones; none where the skeleton lacks it.
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
        let places: Vec<Vec3> =
            vertices.iter().map(|&vertex| positions[vertex as usize].into()).collect();
        let Some(ball) = sphere(&places).filter(|ball| is_round(&places, *ball)) else { continue };
        let (center, radius) = ball;
        eyeballs.push(Eyeball { piece, vertices, center, radius });
    }
    eyeballs
}

/// Whether points lie on a sphere, as far as those of eyeballs do.
pub fn is_round(places: &[Vec3], (center, radius): (Vec3, f32)) -> bool {
    places.iter().all(|place| (place.distance(center) - radius).abs() < ROUNDNESS * radius)
}

/// The sphere that is nearest to points by least squares: its centre and radius. Eyeballs may be open at
/// their backs, so the middle of a box would not do.
///
/// With points measured from their mean, |p|² = 2 c·p + constant is linear in the centre c.
pub fn sphere(places: &[Vec3]) -> Option<(Vec3, f32)> {
    let count = places.len() as f64;
    let mean = places.iter().map(|place| place.as_dvec3()).sum::<DVec3>() / count;
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for place in places {
        let p = place.as_dvec3() - mean;
        matrix += DMat3::from_cols(p * p.x, p * p.y, p * p.z);
        right += p * p.length_squared() / 2.0;
    }
    // What is flat has no sphere; the scale makes the determinant one of shape.
    let scale = (matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z) / 3.0;
    if matrix.determinant() <= 1e-6 * scale.powi(3) {
        return None;
    }
    let center = (mean + matrix.inverse() * right).as_vec3();
    let radius = places.iter().map(|place| place.distance(center)).sum::<f32>() / count as f32;
    Some((center, radius))
}
