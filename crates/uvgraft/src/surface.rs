//! A mesh as a surface: which triangles meet at which points, whatever its layout cuts apart.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use crate::mesh::Mesh;

/// The triangles of a mesh over points. Vertices at the same position that lie on open edges are one
/// point: exporters that split vertices along UV seams do not cut the surface, and sheets that lie on each
/// other stay two.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// `points + 1` offsets into `around`.
    starts: Vec<u32>,
    /// The triangles at each point.
    around: Vec<u32>,
}

impl Surface {
    pub fn new(mesh: &Mesh) -> Self {
        let is_open = on_open_edges(mesh);
        let mut known = HashMap::new();
        let mut positions = Vec::with_capacity(mesh.positions().len());
        let mut push = |position: &[f32; 3]| {
            positions.push(Vec3::from(*position).as_dvec3());
            positions.len() as u32 - 1
        };
        let point_of_vertex: Vec<u32> = mesh
            .positions()
            .iter()
            .zip(is_open)
            .map(|(position, is_open)| {
                if !is_open {
                    return push(position);
                }
                // Adding 0.0 makes one zero of the two.
                let key = position.map(|value| (value + 0.0).to_bits());
                *known.entry(key).or_insert_with(|| push(position))
            })
            .collect();
        let triangles: Vec<[u32; 3]> = mesh
            .faces()
            .iter()
            .map(|face| face.map(|vertex| point_of_vertex[vertex as usize]))
            .collect();
        let mut starts = vec![0; positions.len() + 1];
        for &point in triangles.as_flattened() {
            starts[point as usize + 1] += 1;
        }
        for point in 0..positions.len() {
            starts[point + 1] += starts[point];
        }
        let mut next = starts.clone();
        let mut around = vec![0; triangles.len() * 3];
        for (triangle, points) in (0..).zip(&triangles) {
            for &point in points {
                around[next[point as usize] as usize] = triangle;
                next[point as usize] += 1;
            }
        }
        Self { positions, triangles, starts, around }
    }

    /// Where the points are.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// The points of each triangle, corner by corner.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The triangles at a point.
    pub fn around(&self, point: u32) -> &[u32] {
        let point = point as usize;
        &self.around[self.starts[point] as usize..self.starts[point + 1] as usize]
    }

    /// Where the corners of a triangle are.
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|point| self.positions[point as usize])
    }

    /// The distance between two points through space.
    pub fn length(&self, a: u32, b: u32) -> f64 {
        self.positions[b as usize].distance(self.positions[a as usize])
    }

    /// The area of a triangle.
    pub fn area(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(c - a).length()
    }

    /// The mean length of the triangles' sides.
    pub fn mean_edge(&self) -> f64 {
        let sides = self.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        sides.map(|(a, b)| self.length(a, b)).sum::<f64>() / (3 * self.triangles.len()) as f64
    }
}

/// For each vertex, whether it is on an edge that has one triangle.
fn on_open_edges(mesh: &Mesh) -> Vec<bool> {
    let sides = mesh.faces().iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let mut edges: Vec<(u32, u32)> = sides.map(|(a, b)| (a.min(b), a.max(b))).collect();
    edges.sort_unstable();
    let mut is_open = vec![false; mesh.positions().len()];
    for edge in edges.chunk_by(PartialEq::eq).filter(|edge| edge.len() == 1) {
        is_open[edge[0].0 as usize] = true;
        is_open[edge[0].1 as usize] = true;
    }
    is_open
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_at_one_place_are_one_point() {
        let positions =
            vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, -0.0, 0.0], [1.0, 1.0, 0.0]];
        let uv = vec![[0.0; 2]; 5];
        let faces = [[0, 1, 2], [3, 4, 2]];
        let surface = Surface::new(&Mesh::from_triangles(positions, uv, &faces, &faces).unwrap());
        assert_eq!(surface.positions().len(), 4);
        assert_eq!(surface.triangles(), [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(surface.around(1), [0, 1]);
        assert_eq!(surface.around(3), [1]);
        assert_eq!(surface.area(0), 0.5);
        assert_eq!(surface.length(0, 3), 2.0_f64.sqrt());
    }

    #[test]
    fn sheets_on_one_place_stay_two() {
        // A tetrahedron twice: no edge is open.
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let positions = [corners, corners].concat();
        let sides = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
        let faces: Vec<[u32; 3]> = [0, 4]
            .into_iter()
            .flat_map(|first| sides.map(|side| side.map(|k| k + first)))
            .collect();
        let uv = vec![[0.0; 2]; 8];
        let surface = Surface::new(&Mesh::from_triangles(positions, uv, &faces, &faces).unwrap());
        assert_eq!(surface.positions().len(), 8);
    }
}
