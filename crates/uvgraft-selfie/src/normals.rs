//! Normals of a surface at its vertices.

use std::collections::HashMap;

use glam::DVec3;
use uvgraft::mesh::bits_of;

/// The unit normal at each vertex, by area; zero where there is none. Vertices are not welded.
pub(crate) fn normals(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for face in faces {
        let [a, b, c] = face.map(|vertex| glam::Vec3::from(positions[vertex as usize]).as_dvec3());
        let vector = (b - a).cross(c - a);
        face.iter().for_each(|&vertex| normals[vertex as usize] += vector);
    }
    // Split along UV seams, a vertex sees only the triangles on its side.
    let mut at_position: HashMap<[u32; 3], DVec3> = HashMap::new();
    for (position, normal) in positions.iter().zip(&normals) {
        *at_position.entry(bits_of(*position)).or_default() += *normal;
    }
    let whole = |position: &[f32; 3]| at_position[&bits_of(*position)];
    positions.iter().map(|position| whole(position).normalize_or_zero()).collect()
}
