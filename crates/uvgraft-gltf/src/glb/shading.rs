//! Smooth vertex normals of a mesh, and how morphs change them.
//!
//! Based on Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal Facets", 1998: the
//! normals of triangles are weighted by their angle at the vertex, so the result depends on the
//! shape and not on its triangulation. [`uvgraft::tangents`] computes the same normals.

use std::collections::HashMap;

use glam::Vec3;
use uvgraft::Mesh;
use uvgraft::mesh::bits_of;

/// Shading normals of a mesh. Vertices at the same position share one normal, even if seams of the
/// layout or the file split them.
pub(crate) struct Shading<'a> {
    mesh: &'a Mesh,
    point_of_vertex: Vec<u32>,
    points: usize,
    /// Smooth normals of the rest shape, unit length.
    pub normals: Vec<Vec3>,
    /// The normals to display.
    pub shown: Vec<Vec3>,
}

impl<'a> Shading<'a> {
    pub fn new(mesh: &'a Mesh) -> Self {
        let mut known = HashMap::with_capacity(mesh.positions().len());
        let point = |position: &[f32; 3]| {
            let next = known.len() as u32;
            *known.entry(bits_of(*position)).or_insert(next)
        };
        let point_of_vertex: Vec<u32> = mesh.positions().iter().map(point).collect();
        let mut shading = Self {
            mesh,
            point_of_vertex,
            points: known.len(),
            normals: Vec::new(),
            shown: Vec::new(),
        };
        shading.normals = shading.smooth(mesh.positions(), None);
        shading.with_normals(&[])
    }

    /// Replaces the displayed normals, except by zero vectors. [`Self::changes`] remain
    /// relative to the smooth normals.
    pub fn with_normals(mut self, normals: &[[f32; 3]]) -> Self {
        self.shown.clone_from(&self.normals);
        for (shown, &normal) in self.shown.iter_mut().zip(normals) {
            *shown = Vec3::from(normal).try_normalize().unwrap_or(*shown);
        }
        self
    }

    /// Angle-weighted vertex normals, `normalize(Σ angle_f · normal_f)` over the adjacent
    /// triangles. Without the weights, splitting a triangle would count its side of the surface
    /// twice. If the triangles have no area or cancel out, the normal is that of the first
    /// non-degenerate triangle, else +Z.
    ///
    /// - `only`: mask of the points that need normals; results for others are unspecified.
    fn smooth(&self, positions: &[[f32; 3]], only: Option<&[bool]>) -> Vec<Vec3> {
        let mut sums = vec![Vec3::ZERO; self.points];
        let mut first = vec![Vec3::ZERO; self.points];
        for face in self.mesh.faces() {
            let points = face.map(|vertex| self.point_of_vertex[vertex as usize] as usize);
            if only.is_some_and(|only| !points.iter().any(|&point| only[point])) {
                continue;
            }
            let corners = face.map(|vertex| Vec3::from(positions[vertex as usize]));
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let Some(normal) = normal.try_normalize() else { continue };
            for (k, point) in points.into_iter().enumerate() {
                let [p, q] = [1, 2].map(|step| corners[(k + step) % 3] - corners[k]);
                let angle = p.cross(q).length().atan2(p.dot(q));
                sums[point] += angle * normal;
                if first[point] == Vec3::ZERO {
                    first[point] = normal;
                }
            }
        }
        let normal = |&point: &u32| {
            let (sum, first) = (sums[point as usize], first[point as usize]);
            // Opposite normals cancel up to rounding errors.
            let sum = Some(sum).filter(|sum| sum.length_squared() > 1e-12);
            sum.and_then(Vec3::try_normalize).or(first.try_normalize()).unwrap_or(Vec3::Z)
        };
        self.point_of_vertex.iter().map(normal).collect()
    }

    /// Changes of the normals under a morph: vertices, in ascending order, with those
    /// differences that are longer than `least`.
    pub fn changes(&self, offsets: &[(u32, [f32; 3])], least: f32) -> Vec<(u32, [f32; 3])> {
        let mut moved = vec![false; self.points];
        let mut positions = self.mesh.positions().to_vec();
        for &(vertex, offset) in offsets {
            moved[self.point_of_vertex[vertex as usize] as usize] = true;
            let position = &mut positions[vertex as usize];
            *position = (Vec3::from(*position) + Vec3::from(offset)).into();
        }
        // A moved corner changes the normals at all corners of its triangles.
        let mut changed = moved.clone();
        for face in self.mesh.faces() {
            let points = face.map(|vertex| self.point_of_vertex[vertex as usize] as usize);
            if points.iter().any(|&point| moved[point]) {
                points.into_iter().for_each(|point| changed[point] = true);
            }
        }
        let normals = self.smooth(&positions, Some(&changed));
        let mut changes = Vec::new();
        for (vertex, (new, old)) in (0..).zip(normals.iter().zip(&self.normals)) {
            let change = *new - *old;
            if changed[self.point_of_vertex[vertex as usize] as usize] && change.length() > least {
                changes.push((vertex, change.into()));
            }
        }
        changes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A roof: two squares that meet at a right angle along the Z axis, the ridge.
    fn roof(doubled: bool) -> Mesh {
        let left = [[-1.0, -1.0, 0.0], [-1.0, -1.0, 1.0]];
        let ridge = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let right = [[1.0, -1.0, 0.0], [1.0, -1.0, 1.0]];
        let (positions, faces) = if doubled {
            let positions = [left, ridge, ridge, right].concat();
            (positions, vec![[0, 1, 3], [0, 3, 2], [4, 5, 7], [4, 7, 6]])
        } else {
            ([left, ridge, right].concat(), vec![[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4]])
        };
        let uv = vec![[0.0, 0.0]; positions.len()];
        Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
    }

    #[test]
    fn normals_are_smooth_across_seams_and_independent_of_triangulation() {
        for doubled in [false, true] {
            let mesh = roof(doubled);
            let shading = Shading::new(&mesh);
            // Each side has an angle of 90° at both ends of the ridge, in one triangle or two.
            assert!(shading.normals[2].abs_diff_eq(Vec3::Y, 1e-6), "{}", shading.normals[2]);
            let slope = Vec3::new(-1.0, 1.0, 0.0).normalize();
            assert!(shading.normals[0].abs_diff_eq(slope, 1e-6));
        }
    }

    #[test]
    fn a_morph_changes_normals_where_triangles_move() {
        let mesh = roof(true);
        let shading = Shading::new(&mesh);
        // The right side rises until it is horizontal.
        let rise = [(6, [0.0, 1.0, 0.0]), (7, [0.0, 1.0, 0.0])];
        let changes = shading.changes(&rise, 1e-4);
        let vertices: Vec<u32> = changes.iter().map(|&(vertex, _)| vertex).collect();
        assert_eq!(vertices, [2, 3, 4, 5, 6, 7]);
        let flat = shading.normals[6] + Vec3::from(changes[4].1);
        assert!(flat.abs_diff_eq(Vec3::Y, 1e-6), "{flat}");
        assert!(shading.changes(&[], 1e-4).is_empty());
    }
}
