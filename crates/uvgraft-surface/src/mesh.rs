//! A polygon mesh with one UV layout: validated on construction, immutable afterwards.
//!
//! `uv` has its origin at the top left: `v` grows downwards, like the rows of an image. Readers of
//! formats with the origin at the bottom left flip `v` once, on loading.

mod parts;
mod tiles;

use std::ops::Range;

use glam::{DVec3, Vec3};

pub(crate) use tiles::Placement;
pub use tiles::TileFaces;

/// The bits of a position or a coordinate, the same for equal ones: adding 0.0 turns −0 into +0.
pub fn bits_of<const N: usize>(values: [f32; N]) -> [u32; N] {
    values.map(|value| (value + 0.0).to_bits())
}

/// A mesh with a position and a UV coordinate at every corner.
///
/// Polygons are triangulated as fans around their first corner; [`Mesh::polygon`] returns the
/// triangles of one. Order and indices are those of the input.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    positions: Vec<[f32; 3]>,
    uv: Vec<[f32; 2]>,
    faces: Vec<[u32; 3]>,
    uv_faces: Vec<[u32; 3]>,
    /// `n + 1` offsets into `faces`.
    polygon_starts: Vec<u32>,
    parts: Vec<MeshPart>,
}

/// Consecutive polygons that share an object, a group and a material.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct MeshPart {
    /// Name of the object, empty where the file names none.
    pub object: String,
    /// Name of the group, empty where the file names none.
    pub group: String,
    /// Name of the material, empty where the file names none.
    pub material: String,
    /// The image of the material's base colour, by a name that no other image of the file has; empty
    /// for a material without an image, `None` where the format does not say. Parts with different
    /// images have layouts of their own: see [`Pair::in_one_layout`](crate::Pair::in_one_layout).
    pub image: Option<String>,
    /// Range of polygon indices.
    pub polygons: Range<u32>,
}

/// Why a mesh was refused. Indices start at 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// There is no surface for a texture.
    #[error("mesh has no faces")]
    NoFaces,
    /// A polygon with fewer than three corners.
    #[error("polygon {polygon} must have at least 3 corners, got {corners}")]
    TooFewCorners {
        /// Index of the polygon.
        polygon: usize,
        /// Number of its corners.
        corners: usize,
    },
    /// A corner refers to a vertex or a UV coordinate that does not exist.
    #[error("polygon {polygon} uses {what} {index}, but the mesh has only {count}")]
    Index {
        /// Index of the polygon.
        polygon: usize,
        /// `"vertex"` or `"UV coordinate"`.
        what: &'static str,
        /// The index that is out of range.
        index: u32,
        /// Number of vertices or UV coordinates.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("{what} {index} must be finite, got {value}")]
    NotFinite {
        /// `"vertex"` or `"UV coordinate"`.
        what: &'static str,
        /// Its index.
        index: usize,
        /// The value.
        value: f32,
    },
    /// Two counts that must be equal are not.
    #[error("mesh must have {wanted} {what}, got {found}")]
    Count {
        /// What was counted.
        what: &'static str,
        /// The actual count.
        found: usize,
        /// The required count.
        wanted: usize,
    },
    /// More elements than 32-bit indices can address.
    #[error("mesh must have at most {max} {what}, got {count}")]
    TooLarge {
        /// What there are too many of.
        what: &'static str,
        /// Their count.
        count: usize,
        /// The maximum.
        max: usize,
    },
}

/// An axis of UV coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum UvAxis {
    /// Across the texture.
    U,
    /// Down the texture.
    V,
}

crate::choices!(UvAxis {
    U => "u", "Across the texture";
    V => "v", "Down the texture";
});
#[cfg(feature = "serde")]
crate::serialize_by_name!(UvAxis);

/// One corner of a polygon: its vertex and its UV coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Corner {
    /// Index into the positions.
    pub vertex: u32,
    /// Index into the UV coordinates.
    pub uv: u32,
}

/// Maximum number of vertices or triangles: indices and run tables are 32 bits wide.
const MAX_ELEMENTS: usize = 1 << 28;

impl Mesh {
    /// Validates and triangulates polygons.
    ///
    /// - `positions`: `[vertices]`, in the mesh's own unit.
    /// - `uv`: `[uv coordinates]`, origin at the top left, `0.0..=1.0` inside the texture.
    /// - `corners`: the corners of all polygons, one polygon after the other.
    /// - `sizes`: `[polygons]`, the number of corners of each; their sum is `corners.len()`.
    ///
    /// # Errors
    /// [`MeshError`] if there are no polygons, a polygon has fewer than three corners, an index is
    /// out of range, a coordinate is not finite, there are more than 2²⁸ elements of a kind, or
    /// `sizes` do not add up to `corners.len()`.
    pub fn from_polygons(
        positions: Vec<[f32; 3]>,
        uv: Vec<[f32; 2]>,
        corners: &[Corner],
        sizes: &[u32],
    ) -> Result<Self, MeshError> {
        check_finite("vertex", &positions)?;
        check_finite("UV coordinate", &uv)?;
        for (what, count) in [
            ("vertices", positions.len()),
            ("UV coordinates", uv.len()),
            ("corners", corners.len()),
        ] {
            if count > MAX_ELEMENTS {
                return Err(MeshError::TooLarge { what, count, max: MAX_ELEMENTS });
            }
        }
        if sizes.is_empty() {
            return Err(MeshError::NoFaces);
        }
        let wanted = sizes.iter().map(|&size| u64::from(size)).sum::<u64>();
        if wanted != corners.len() as u64 {
            let wanted = usize::try_from(wanted).unwrap_or(usize::MAX);
            return Err(MeshError::Count { what: "corners", found: corners.len(), wanted });
        }
        let mut faces = Vec::with_capacity(corners.len());
        let mut uv_faces = Vec::with_capacity(corners.len());
        let mut polygon_starts = Vec::with_capacity(sizes.len() + 1);
        let mut rest = corners;
        for (polygon, &size) in sizes.iter().enumerate() {
            if size < 3 {
                return Err(MeshError::TooFewCorners { polygon, corners: size as usize });
            }
            let (ring, tail) = rest.split_at(size as usize);
            rest = tail;
            for corner in ring {
                check_index(polygon, "vertex", corner.vertex, positions.len())?;
                check_index(polygon, "UV coordinate", corner.uv, uv.len())?;
            }
            polygon_starts.push(faces.len() as u32);
            for pair in ring[1..].windows(2) {
                faces.push([ring[0].vertex, pair[0].vertex, pair[1].vertex]);
                uv_faces.push([ring[0].uv, pair[0].uv, pair[1].uv]);
            }
        }
        polygon_starts.push(faces.len() as u32);
        Ok(Self { positions, uv, faces, uv_faces, polygon_starts, parts: Vec::new() })
    }

    /// Validates a mesh of triangles; see [`Mesh::from_polygons`].
    ///
    /// # Errors
    /// As [`Mesh::from_polygons`]; [`MeshError::Count`] if `faces` and `uv_faces` differ in length.
    pub fn from_triangles(
        positions: Vec<[f32; 3]>,
        uv: Vec<[f32; 2]>,
        faces: &[[u32; 3]],
        uv_faces: &[[u32; 3]],
    ) -> Result<Self, MeshError> {
        if uv_faces.len() != faces.len() {
            let (found, wanted) = (uv_faces.len(), faces.len());
            return Err(MeshError::Count { what: "UV faces", found, wanted });
        }
        let corners: Vec<Corner> = faces
            .iter()
            .flatten()
            .zip(uv_faces.iter().flatten())
            .map(|(&vertex, &uv)| Corner { vertex, uv })
            .collect();
        Self::from_polygons(positions, uv, &corners, &vec![3; faces.len()])
    }

    /// Sets the objects, groups and materials of polygons; for information only.
    #[must_use]
    pub fn with_parts(mut self, parts: Vec<MeshPart>) -> Self {
        self.parts = parts;
        self
    }

    /// The same faces and layout with other positions.
    ///
    /// # Errors
    /// [`MeshError::NotFinite`]; [`MeshError::Count`] if the number of positions differs from the
    /// mesh's.
    pub fn with_positions(self, positions: Vec<[f32; 3]>) -> Result<Self, MeshError> {
        if positions.len() != self.positions.len() {
            let (found, wanted) = (positions.len(), self.positions.len());
            return Err(MeshError::Count { what: "positions", found, wanted });
        }
        check_finite("vertex", &positions)?;
        Ok(Self { positions, ..self })
    }

    /// `[vertices]` positions in the mesh's own unit.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// `[uv coordinates]`, origin at the top left.
    pub fn uv(&self) -> &[[f32; 2]] {
        &self.uv
    }

    /// `[triangles]` of indices into [`Mesh::positions`].
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// `[triangles]` of indices into [`Mesh::uv`], parallel to [`Mesh::faces`].
    pub fn uv_faces(&self) -> &[[u32; 3]] {
        &self.uv_faces
    }

    /// Number of polygons before triangulation.
    pub fn polygon_count(&self) -> usize {
        self.polygon_starts.len() - 1
    }

    /// The triangles of one polygon, as a range of [`Mesh::faces`].
    pub fn polygon(&self, polygon: usize) -> Range<usize> {
        self.polygon_starts[polygon] as usize..self.polygon_starts[polygon + 1] as usize
    }

    /// Objects, groups and materials, in the order of the polygons.
    pub fn parts(&self) -> &[MeshPart] {
        &self.parts
    }

    /// The corners of one polygon in order, recovered from its fan.
    pub fn polygon_corners(&self, polygon: usize) -> Vec<Corner> {
        let fan = self.polygon(polygon);
        let (first, first_uv) = (self.faces[fan.start], self.uv_faces[fan.start]);
        let corner = |vertex, uv| Corner { vertex, uv };
        let mut corners = vec![corner(first[0], first_uv[0]), corner(first[1], first_uv[1])];
        corners.extend(fan.map(|face| corner(self.faces[face][2], self.uv_faces[face][2])));
        corners
    }

    /// Retriangulates one polygon as a fan around its corner `apex`.
    pub(crate) fn refan(&mut self, polygon: usize, apex: usize) {
        let mut corners = self.polygon_corners(polygon);
        corners.rotate_left(apex);
        for (face, pair) in self.polygon(polygon).zip(corners[1..].windows(2)) {
            self.faces[face] = [corners[0].vertex, pair[0].vertex, pair[1].vertex];
            self.uv_faces[face] = [corners[0].uv, pair[0].uv, pair[1].uv];
        }
    }

    /// The three UV coordinates of a triangle.
    pub fn uv_triangle(&self, face: usize) -> [[f32; 2]; 3] {
        self.uv_faces[face].map(|index| self.uv[index as usize])
    }

    /// The three positions of a triangle.
    pub(crate) fn triangle(&self, face: usize) -> [DVec3; 3] {
        self.faces[face].map(|index| Vec3::from(self.positions[index as usize]).as_dvec3())
    }

    /// The same mesh with U or V counted from the other side of the unit square.
    #[must_use]
    pub fn flipped(mut self, axis: UvAxis) -> Self {
        for uv in &mut self.uv {
            uv[axis as usize] = 1.0 - uv[axis as usize];
        }
        self
    }

    /// Whether a triangle has a UV coordinate outside the unit square by more than a thousandth,
    /// which allows for rounding and half a texel. A texture has no texels there; in another UDIM
    /// tile another texture may.
    pub fn is_outside(&self, face: usize) -> bool {
        !self.uv_triangle(face).as_flattened().iter().all(is_inside)
    }

    /// Whether no triangle is outside: faster than testing each.
    pub(crate) fn is_all_inside(&self) -> bool {
        // No early exit, so that the compiler can vectorise the comparisons.
        self.uv.as_flattened().iter().fold(true, |all, coordinate| all & is_inside(coordinate))
    }
}

/// How far a face may reach beyond the border of its tile, which allows for rounding and half a texel.
const MARGIN: f32 = 1e-3;

/// Whether a UV coordinate is within the unit square, with a tolerance.
fn is_inside(coordinate: &f32) -> bool {
    (*coordinate >= -MARGIN) & (*coordinate <= 1.0 + MARGIN)
}

/// Twice the signed area of a triangle, positive when its corners run clockwise on screen
/// (`v` down). Exact in sign for 32-bit input up to the rounding of `f64`.
pub fn doubled_area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The area of a triangle in space.
pub(crate) fn triangle_area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

fn check_finite<const N: usize>(what: &'static str, values: &[[f32; N]]) -> Result<(), MeshError> {
    for (index, value) in values.iter().enumerate() {
        if let Some(&value) = value.iter().find(|value| !value.is_finite()) {
            return Err(MeshError::NotFinite { what, index, value });
        }
    }
    Ok(())
}

fn check_index(
    polygon: usize,
    what: &'static str,
    index: u32,
    count: usize,
) -> Result<(), MeshError> {
    if (index as usize) < count {
        Ok(())
    } else {
        Err(MeshError::Index { polygon, what, index, count })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners(indices: &[u32]) -> Vec<Corner> {
        indices.iter().map(|&index| Corner { vertex: index, uv: index }).collect()
    }

    fn square() -> (Vec<[f32; 3]>, Vec<[f32; 2]>) {
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        (uv.iter().map(|&[x, y]| [x, y, 0.0]).collect(), uv)
    }

    #[test]
    fn a_quad_is_a_fan_around_its_first_corner() {
        let (positions, uv) = square();
        let mut mesh =
            Mesh::from_polygons(positions, uv, &corners(&[3, 0, 1, 2, 0, 1, 2]), &[4, 3]).unwrap();
        assert_eq!(mesh.faces(), [[3, 0, 1], [3, 1, 2], [0, 1, 2]]);
        assert_eq!(mesh.polygon(0), 0..2);
        assert_eq!(mesh.polygon(1), 2..3);
        assert_eq!(mesh.polygon_corners(0), corners(&[3, 0, 1, 2]));
        mesh.refan(0, 1);
        assert_eq!(mesh.faces()[..2], [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.uv_faces(), mesh.faces());
    }

    #[test]
    fn invalid_meshes_are_refused() {
        let (positions, uv) = square();
        let build = |indices: &[u32], sizes: &[u32]| {
            Mesh::from_polygons(positions.clone(), uv.clone(), &corners(indices), sizes)
        };
        assert_eq!(build(&[], &[]), Err(MeshError::NoFaces));
        assert_eq!(build(&[0, 1], &[2]), Err(MeshError::TooFewCorners { polygon: 0, corners: 2 }));
        assert_eq!(
            build(&[0, 1, 4], &[3]),
            Err(MeshError::Index { polygon: 0, what: "vertex", index: 4, count: 4 })
        );
        let count = |what, found, wanted| Err(MeshError::Count { what, found, wanted });
        assert_eq!(build(&[0, 1, 2], &[4]), count("corners", 3, 4));
        assert_eq!(build(&[0, 1, 2, 3], &[3]), count("corners", 4, 3));
        let triangle = |uv_faces: &[[u32; 3]]| {
            Mesh::from_triangles(positions.clone(), uv.clone(), &[[0, 1, 2]], uv_faces)
        };
        assert_eq!(triangle(&[]), count("UV faces", 0, 1));
        let mesh = triangle(&[[0, 1, 2]]).unwrap();
        assert_eq!(mesh.with_positions(vec![[0.0; 3]; 3]), count("positions", 3, 4));
        let mut broken = positions.clone();
        broken[2][1] = f32::NEG_INFINITY;
        assert_eq!(
            Mesh::from_triangles(broken, uv.clone(), &[[0, 1, 2]], &[[0, 1, 2]]),
            Err(MeshError::NotFinite { what: "vertex", index: 2, value: f32::NEG_INFINITY })
        );
    }

    #[test]
    fn area_is_positive_clockwise_on_screen() {
        assert_eq!(doubled_area([[0.0, 0.0], [1.0, 0.0], [0.0, 0.5]]), 0.5);
        assert_eq!(doubled_area([[0.0, 0.0], [0.0, 0.5], [1.0, 0.0]]), -0.5);
    }
}
