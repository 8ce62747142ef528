//! Smooth normals at the vertices of a mesh, and what morphs change of them.
//!
//! Based on Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal Facets", 1998: triangles
//! count by their angle at the vertex, so normals depend on the shape and not on how it is cut into
//! triangles. [`uvgraft::tangents`] has the same normals.

use std::collections::HashMap;

use glam::Vec3;
use uvgraft::Mesh;

/// Where triangles meet: vertices at the same place are one point, whatever seams of the layout or the
/// file made of them.
pub(crate) struct Shading<'a> {
    mesh: &'a Mesh,
    point_of_vertex: Vec<u32>,
    points: usize,
    /// Smooth normals at rest, of length 1.
    pub normals: Vec<Vec3>,
    /// Those that are shown.
    pub shown: Vec<Vec3>,
}

impl<'a> Shading<'a> {
    pub fn new(mesh: &'a Mesh) -> Self {
        let mut known = HashMap::with_capacity(mesh.positions().len());
        let point = |position: &[f32; 3]| {
            let next = known.len() as u32;
            // Adding 0.0 makes one zero of the two.
            *known.entry(position.map(|value| (value + 0.0).to_bits())).or_insert(next)
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

    /// With other normals for vertices, as far as those have a length. Changes stay what they are of
    /// smooth ones.
    pub fn with_normals(mut self, normals: &[[f32; 3]]) -> Self {
        self.shown.clone_from(&self.normals);
        for (shown, &normal) in self.shown.iter_mut().zip(normals) {
            *shown = Vec3::from(normal).try_normalize().unwrap_or(*shown);
        }
        self
    }

    /// Normals of vertices. One whose triangles have no area or cancel out takes that of its first
    /// triangle that has one, else +Z.
    ///
    /// - `only`: points for which normals are wanted; others may come out as anything.
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
            // What cancels out leaves rounding.
            let sum = Some(sum).filter(|sum| sum.length_squared() > 1e-12);
            sum.and_then(Vec3::try_normalize).or(first.try_normalize()).unwrap_or(Vec3::Z)
        };
        self.point_of_vertex.iter().map(normal).collect()
    }

    /// How normals change where a morph moves vertices: vertices, rising, and differences longer than
    /// `least`.
    pub fn changes(&self, offsets: &[(u32, [f32; 3])], least: f32) -> Vec<(u32, [f32; 3])> {
        let mut moved = vec![false; self.points];
        let mut positions = self.mesh.positions().to_vec();
        for &(vertex, offset) in offsets {
            moved[self.point_of_vertex[vertex as usize] as usize] = true;
            let position = &mut positions[vertex as usize];
            *position = (Vec3::from(*position) + Vec3::from(offset)).into();
        }
        // The triangles around a point are changed by all of their corners.
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

    /// A roof: two squares that meet at right angles along the Z axis, the ridge.
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
    fn normals_are_smooth_across_seams_and_do_not_count_triangles() {
        for doubled in [false, true] {
            let mesh = roof(doubled);
            let shading = Shading::new(&mesh);
            // Each side has 90° at either end of the ridge, cut into one triangle or two.
            assert!(shading.normals[2].abs_diff_eq(Vec3::Y, 1e-6), "{}", shading.normals[2]);
            let slope = Vec3::new(-1.0, 1.0, 0.0).normalize();
            assert!(shading.normals[0].abs_diff_eq(slope, 1e-6));
        }
    }

    #[test]
    fn a_morph_changes_normals_where_triangles_move() {
        let mesh = roof(true);
        let shading = Shading::new(&mesh);
        // The right side rises until the roof is flat there.
        let rise = [(6, [0.0, 1.0, 0.0]), (7, [0.0, 1.0, 0.0])];
        let changes = shading.changes(&rise, 1e-4);
        let vertices: Vec<u32> = changes.iter().map(|&(vertex, _)| vertex).collect();
        assert_eq!(vertices, [2, 3, 4, 5, 6, 7]);
        let flat = shading.normals[6] + Vec3::from(changes[4].1);
        assert!(flat.abs_diff_eq(Vec3::Y, 1e-6), "{flat}");
        assert!(shading.changes(&[], 1e-4).is_empty());
    }
}
