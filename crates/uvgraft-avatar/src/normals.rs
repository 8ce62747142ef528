//! Smooth normals of triangle meshes.

use glam::Vec3;

/// Area-weighted vertex normals of a triangle mesh; zero for vertices without triangles.
pub fn vertex_normals(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::default(); positions.len()];
    for face in faces {
        let [a, b, c] = face.map(|index| Vec3::from(positions[index as usize]));
        let normal = (b - a).cross(c - a);
        for &index in face {
            normals[index as usize] += normal;
        }
    }
    normals.into_iter().map(Vec3::normalize_or_zero).collect()
}
