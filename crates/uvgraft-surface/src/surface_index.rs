//! The nearest place on a mesh's surface.

use glam::DVec3;

use crate::mesh::Mesh;
use crate::triangle_tree::TriangleTree;

/// A place on a mesh's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// The triangle, an index into [`Mesh::faces`].
    pub face: u32,
    /// Barycentric weights of its corners; they sum to 1.
    pub weights: [f64; 3],
}

impl SurfacePoint {
    /// Where it lies, from values at the vertices: positions, or anything else that is linear
    /// within triangles.
    pub fn of(&self, mesh: &Mesh, values: &[[f64; 3]]) -> [f64; 3] {
        let corners = mesh.faces()[self.face as usize].map(|vertex| values[vertex as usize]);
        std::array::from_fn(|axis| (0..3).map(|k| self.weights[k] * corners[k][axis]).sum())
    }
}

/// A mesh's triangles, indexed by position.
#[derive(Debug)]
pub struct SurfaceIndex {
    tree: TriangleTree,
    normals: Vec<DVec3>,
}

impl SurfaceIndex {
    /// Indexes the triangles of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let at = |vertex: u32| glam::Vec3::from(mesh.positions()[vertex as usize]).as_dvec3();
        let corners: Vec<[DVec3; 3]> = mesh.faces().iter().map(|face| face.map(at)).collect();
        let normal = |&[a, b, c]: &[DVec3; 3]| (b - a).cross(c - a).normalize_or_zero();
        let normals = corners.iter().map(normal).collect();
        Self { tree: TriangleTree::new(corners), normals }
    }

    /// The place nearest to a position, and its distance in the mesh's unit; `None` if no triangle
    /// qualifies within `reach`.
    ///
    /// - `qualifies`: from a triangle's index and its unit normal (zero if it has no area).
    pub fn nearest(
        &self,
        position: [f64; 3],
        reach: f64,
        qualifies: impl Fn(u32, [f64; 3]) -> bool,
    ) -> Option<(SurfacePoint, f64)> {
        let is_good = |face: u32| qualifies(face, self.normals[face as usize].to_array());
        let nearest = self.tree.nearest(position.into(), reach, is_good)?;
        let at = SurfacePoint { face: nearest.triangle, weights: nearest.weights };
        Some((at, nearest.distance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_place_is_found_among_triangles_that_qualify() {
        // Two unit squares, one above the other.
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let above: Vec<[f32; 3]> = positions.iter().map(|&[x, y, _]| [x, y, 1.0]).collect();
        let positions = [positions, above].concat();
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let faces = [[0, 1, 2], [3, 4, 5]];
        let mesh = Mesh::from_triangles(positions, uv, &faces, &[[0, 1, 2]; 2]).unwrap();
        let index = SurfaceIndex::new(&mesh);
        let (at, distance) = index.nearest([0.25, 0.25, 0.3], 1.0, |_, _| true).unwrap();
        assert_eq!(at.face, 0);
        assert!((distance - 0.3).abs() < 1e-12);
        for (found, wanted) in at.weights.into_iter().zip([0.5, 0.25, 0.25]) {
            assert!((found - wanted).abs() < 1e-12);
        }
        let (at, _) = index.nearest([0.25, 0.25, 0.3], 1.0, |face, _| face == 1).unwrap();
        assert_eq!(at.face, 1);
        assert_eq!(index.nearest([0.25, 0.25, 0.3], 0.1, |_, _| true), None);
        let points: Vec<[f64; 3]> =
            mesh.positions().iter().map(|&point| point.map(f64::from)).collect();
        assert!((at.of(&mesh, &points)[2] - 1.0).abs() < 1e-12);
    }
}
