//! The vertices of a file: corners of triangles are merged if they have the same mesh vertex, UV
//! coordinate and material, and the same tangent if there are tangents.

use std::collections::HashMap;

use uvgraft::mesh::bits_of;
use uvgraft::{Mesh, TangentFrames};

use super::shading::Shading;

/// Which triangles to create vertices for, and their attributes besides positions, normals and UV
/// coordinates.
#[derive(Clone, Copy, Default)]
pub(crate) struct Inputs<'a> {
    /// Source of tangents, if they are needed.
    pub frames: Option<&'a TangentFrames>,
    /// See [`Avatar::materials`](uvgraft_avatar::Avatar::materials).
    pub materials: &'a [u8],
    /// Restricts the output to triangles of this material.
    pub only: Option<u8>,
}

#[derive(Default)]
pub(crate) struct Vertices {
    /// For each vertex, the mesh vertex it is a copy of.
    pub from: Vec<u32>,
    /// For each vertex, the material of its triangles.
    pub materials: Vec<u8>,
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    /// `[x, y, z, sign of the bitangent]`.
    pub tangents: Option<Vec<[f32; 4]>>,
    pub uv: Vec<[f32; 2]>,
    /// Three indices for each triangle.
    pub indices: Vec<u32>,
    /// Copies of mesh vertex `v`, in ascending order, are `copies[starts[v]..starts[v + 1]]`.
    starts: Vec<u32>,
    copies: Vec<u32>,
}

impl Vertices {
    /// Merges equal corners into vertices and builds the index list. glTF has one index for all
    /// attributes of a vertex, so a mesh vertex needs a copy for each combination of attributes at
    /// its corners. Triangles that have a vertex twice are invisible and left out.
    pub fn new(mesh: &Mesh, shading: &Shading<'_>, inputs: Inputs<'_>) -> Self {
        let Inputs { frames, materials, only } = inputs;
        let mut known = HashMap::with_capacity(mesh.positions().len() * 5 / 4);
        let mut vertices = Self {
            tangents: frames.is_some().then(Vec::new),
            indices: Vec::with_capacity(mesh.faces().len() * 3),
            ..Self::default()
        };
        for (face, (corners, uv_corners)) in mesh.faces().iter().zip(mesh.uv_faces()).enumerate() {
            let [a, b, c] = *corners;
            let material = materials.get(face).copied().unwrap_or(0);
            if a == b || b == c || c == a || only.is_some_and(|only| only != material) {
                continue;
            }
            for k in 0..3 {
                let (vertex, uv) = (corners[k], mesh.uv()[uv_corners[k] as usize]);
                let tangent = frames.map(|frames| {
                    let frame = frames.faces()[face][k];
                    let [x, y, z] = frame.tangent;
                    [x, y, z, frame.sign]
                });
                let key = (vertex, material, bits_of(uv), tangent.map(bits_of));
                let index = *known.entry(key).or_insert_with(|| {
                    vertices.from.push(vertex);
                    vertices.materials.push(material);
                    vertices.positions.push(mesh.positions()[vertex as usize]);
                    vertices.normals.push(shading.shown[vertex as usize].into());
                    if let (Some(tangents), Some(tangent)) = (&mut vertices.tangents, tangent) {
                        tangents.push(tangent);
                    }
                    vertices.uv.push(uv);
                    vertices.from.len() as u32 - 1
                });
                vertices.indices.push(index);
            }
        }
        vertices.list_copies(mesh.positions().len());
        vertices
    }

    /// Fills `starts` and `copies` by a counting sort on the mesh vertex.
    fn list_copies(&mut self, count: usize) {
        self.starts = vec![0; count + 1];
        for &vertex in &self.from {
            self.starts[vertex as usize + 1] += 1;
        }
        for vertex in 0..count {
            self.starts[vertex + 1] += self.starts[vertex];
        }
        let mut next = self.starts.clone();
        self.copies = vec![0; self.from.len()];
        for (index, &vertex) in (0..).zip(&self.from) {
            self.copies[next[vertex as usize] as usize] = index;
            next[vertex as usize] += 1;
        }
    }

    pub const fn count(&self) -> usize {
        self.from.len()
    }

    /// Converts offsets of mesh vertices into offsets of these vertices, in ascending order.
    pub fn spread(&self, offsets: &[(u32, [f32; 3])]) -> Vec<(u32, [f32; 3])> {
        let mut spread = Vec::with_capacity(offsets.len());
        for &(vertex, offset) in offsets {
            let range = self.starts[vertex as usize]..self.starts[vertex as usize + 1];
            let copies = &self.copies[range.start as usize..range.end as usize];
            spread.extend(copies.iter().map(|&copy| (copy, offset)));
        }
        spread.sort_unstable_by_key(|&(vertex, _)| vertex);
        spread
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_split_where_their_coordinates_differ() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        // The second triangle has a different coordinate at vertex 0 and repeats that of vertex 2.
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.5], [1.0, 1.0], [0.0, 1.0]];
        let faces = [[0, 1, 2], [0, 2, 3], [1, 1, 2]];
        let uv_faces = [[0, 1, 2], [3, 4, 5], [0, 1, 2]];
        let mesh = Mesh::from_triangles(positions, uv, &faces, &uv_faces).unwrap();
        let shading = Shading::new(&mesh);
        let vertices = Vertices::new(&mesh, &shading, Inputs::default());
        assert_eq!(vertices.from, [0, 1, 2, 0, 3]);
        assert_eq!(vertices.indices, [0, 1, 2, 3, 2, 4]);
        assert_eq!(vertices.normals, [[0.0, 0.0, 1.0]; 5]);
        let offset = [0.1, 0.2, 0.3];
        assert_eq!(vertices.spread(&[(3, offset), (0, offset)]), [0, 3, 4].map(|v| (v, offset)));

        // Triangles of different materials share no vertices, whatever their coordinates.
        let inputs = Inputs { materials: &[0, 1, 0], ..Inputs::default() };
        let vertices = Vertices::new(&mesh, &shading, inputs);
        assert_eq!(vertices.from, [0, 1, 2, 0, 2, 3]);
        assert_eq!(vertices.materials, [0, 0, 0, 1, 1, 1]);
        let vertices = Vertices::new(&mesh, &shading, Inputs { only: Some(1), ..inputs });
        assert_eq!((vertices.from, vertices.indices), (vec![0, 2, 3], vec![0, 1, 2]));
    }
}
