//! A mesh as a welded surface: points and their adjacent triangles, ignoring UV seams.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use crate::mesh::{Mesh, bits_of};

/// The triangles of a mesh over welded points. Vertices on open edges are merged if they
/// share a position, so vertices that an exporter split along UV seams don't cut the surface.
/// Interior vertices are never merged, so coincident sheets stay separate.
#[derive(Debug, Clone)]
pub struct Surface {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// `points + 1` offsets into `around`.
    starts: Vec<u32>,
    /// The triangles at each point, point by point.
    around: Vec<u32>,
}

impl Surface {
    /// Welds vertices on open edges by the bits of their positions, and indexes the triangles
    /// by point.
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
                *known.entry(bits_of(*position)).or_insert_with(|| push(position))
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

    /// The points' positions.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// The points at each triangle's corners.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The triangles at a point.
    pub fn around(&self, point: u32) -> &[u32] {
        let point = point as usize;
        &self.around[self.starts[point] as usize..self.starts[point + 1] as usize]
    }

    /// The positions of a triangle's corners.
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|point| self.positions[point as usize])
    }

    /// The Euclidean distance between two points.
    pub fn length(&self, a: u32, b: u32) -> f64 {
        self.positions[b as usize].distance(self.positions[a as usize])
    }

    /// The area of a triangle.
    pub fn area(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(c - a).length()
    }

    /// The mean side length over all triangles; shared edges count once for each triangle.
    pub fn mean_edge(&self) -> f64 {
        let sides = self.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        sides.map(|(a, b)| self.length(a, b)).sum::<f64>() / (3 * self.triangles.len()) as f64
    }
}

/// For each vertex, whether it is an end of an open edge, one with a single triangle.
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
    fn split_vertices_are_merged() {
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
    fn coincident_sheets_stay_separate() {
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
