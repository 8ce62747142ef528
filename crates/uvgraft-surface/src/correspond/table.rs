//! Vertex tables: for each vertex of one mesh, the corresponding point on the surface of another.
//!
//! This is what publications of correspondences have in common: a face and barycentric weights per
//! vertex, a sparse matrix that takes the vertices of one mesh to those of another, or a grid of
//! source positions from which they can be recovered. Each constructor checks its input once, so
//! that a table needs no further checks except against the numbers of vertices of its meshes.

mod link;
mod locator;
mod matrix;
mod texels;

pub use self::link::{TableLinkError, TableReport, TableRows, link};
pub use self::locator::{Located, UvLocator};
pub use self::matrix::RowCounts;
pub use self::texels::TexelCounts;
use crate::piece::Weights;

/// How far the sum of weights may be from 1: published weights are often rounded to three digits.
const SUM_TOLERANCE: f64 = 1e-3;

/// How negative a weight may be: a point that was projected on a face from beside it.
const MOST_NEGATIVE: f64 = -1e-2;

/// A weight that is closer to 1 than this makes the point a vertex.
const SNAP: f64 = 1e-4;

/// A point on a mesh's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Vertices of the mesh, usually the corners of one of its faces. Those of weight 0 don't matter
    /// and may repeat another.
    pub vertices: [u32; 3],
    /// Their weights, not negative; they add up to 1.
    pub weights: Weights,
}

impl SurfacePoint {
    /// The vertex at which the point lies, if it lies at one.
    pub fn vertex(&self) -> Option<u32> {
        let at = self.weights.iter().position(|&weight| weight == 1.0)?;
        Some(self.vertices[at])
    }

    /// Makes weights non-negative with a sum of 1, and turns those next to a vertex into the vertex
    /// itself; `None` if they are not weights of a point on a surface.
    fn new(vertices: [u32; 3], weights: Weights) -> Option<Self> {
        let sum: f64 = weights.iter().sum();
        // Not written as `>`: NaN must fail too.
        let is_one = (sum - 1.0).abs() <= SUM_TOLERANCE;
        if !is_one || weights.iter().any(|&weight| weight < MOST_NEGATIVE) {
            return None;
        }
        let weights = weights.map(|weight| weight.max(0.0));
        let sum: f64 = weights.iter().sum();
        let point = Self { vertices, weights: weights.map(|weight| weight / sum) };
        let near = point.weights.iter().position(|&weight| weight >= 1.0 - SNAP);
        Some(near.map_or(point, |corner| point.at_corner(corner)))
    }

    fn at_corner(self, corner: usize) -> Self {
        let mut weights = [0.0; 3];
        weights[corner] = 1.0;
        Self { weights, ..self }
    }

    /// Sum of the absolute differences of two points' weights, from 0 to 2.
    fn difference(&self, other: &Self) -> f64 {
        let weight = |point: &Self, vertex: u32| -> f64 {
            let at = |&(found, _): &(u32, f64)| found == vertex;
            point.parts().filter(at).map(|(_, weight)| weight).sum()
        };
        let mut vertices: Vec<u32> = self.parts().chain(other.parts()).map(|part| part.0).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices.iter().map(|&vertex| (weight(self, vertex) - weight(other, vertex)).abs()).sum()
    }

    fn parts(&self) -> impl Iterator<Item = (u32, f64)> {
        self.vertices.into_iter().zip(self.weights)
    }
}

/// Where each vertex of one mesh lies on another.
#[derive(Debug, Clone, PartialEq)]
pub struct VertexTable {
    points: Vec<Option<SurfacePoint>>,
    onto_vertices: usize,
}

/// Why a vertex table was refused. Indices start at 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// Two lists that must be equally long are not.
    #[error("there must be {wanted} {what}, got {found}")]
    Length {
        /// What the list has.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The required length.
        wanted: usize,
    },
    /// A face that the mesh does not have.
    #[error(
        "the face of vertex {vertex} must be from 0 to {}, or -1 for none; got {found}",
        .faces.saturating_sub(1)
    )]
    Face {
        /// The vertex of the table.
        vertex: usize,
        /// Its face.
        found: i64,
        /// Number of faces of the mesh that the table refers to.
        faces: usize,
    },
    /// A vertex that the mesh does not have.
    #[error(
        "vertex {vertex} of the table must lie between vertices from 0 to {} of the other mesh, got \
         {found}",
        .vertices.saturating_sub(1)
    )]
    Vertex {
        /// The vertex of the table.
        vertex: usize,
        /// The index that is out of range.
        found: i64,
        /// Number of vertices of the mesh that the table refers to.
        vertices: usize,
    },
    /// Weights that are not those of a point on a surface.
    #[error(
        "the weights of vertex {vertex} must be finite, not negative and add up to 1, got {found:?}"
    )]
    Weights {
        /// The vertex of the table.
        vertex: usize,
        /// Its weights.
        found: Weights,
    },
    /// A matrix of another width.
    #[error(
        "the matrix must have {wanted} columns, one for each vertex of the other mesh, or twice as \
         many with normals; got {found}"
    )]
    Columns {
        /// Number of columns.
        found: usize,
        /// Number of vertices of the other mesh.
        wanted: usize,
    },
    /// A matrix element that is NaN or infinite.
    #[error("the matrix must be finite, got {value} in row {row}, column {column}")]
    Element {
        /// Its row.
        row: usize,
        /// Its column.
        column: u32,
        /// Its value.
        value: f64,
    },
    /// The table is valid, but has no point.
    #[error("none of the {vertices} vertices of the table has a point on the other mesh")]
    Nothing {
        /// Number of vertices of the table.
        vertices: usize,
    },
}

impl VertexTable {
    /// A table of points.
    ///
    /// - `points`: `[vertices]`; `None` where nothing corresponds. Weights down to -0.01 become 0, sums
    ///   within 0.001 of 1 become 1, and points within a weight of 0.0001 of a vertex become that vertex.
    /// - `onto_vertices`: number of vertices of the mesh on which the points lie.
    ///
    /// # Errors
    /// [`TableError::Vertex`] for indices out of range, [`TableError::Weights`] for other weights,
    /// [`TableError::Nothing`] if there is no point.
    pub fn new(
        points: Vec<Option<SurfacePoint>>,
        onto_vertices: usize,
    ) -> Result<Self, TableError> {
        let checked = |(vertex, point): (usize, Option<SurfacePoint>)| {
            let Some(SurfacePoint { vertices, weights }) = point else { return Ok(None) };
            let is_beyond = |found: &&u32| **found as usize >= onto_vertices;
            if let Some(&found) = vertices.iter().find(is_beyond) {
                let found = found.into();
                return Err(TableError::Vertex { vertex, found, vertices: onto_vertices });
            }
            let point = SurfacePoint::new(vertices, weights);
            point.map(Some).ok_or(TableError::Weights { vertex, found: weights })
        };
        let points = points.into_iter().enumerate().map(checked).collect::<Result<Vec<_>, _>>()?;
        if points.iter().all(Option::is_none) {
            return Err(TableError::Nothing { vertices: points.len() });
        }
        Ok(Self { points, onto_vertices })
    }

    /// A table of faces and barycentric weights.
    ///
    /// - `faces`, `onto_vertices`: the faces of the mesh on which the points lie, and its number of
    ///   vertices.
    /// - `face_ids`: `[vertices]` indices into `faces`, or -1 for none.
    /// - `weights`: `[vertices]` weights of the face's corners, in its order; unused where there is no
    ///   face.
    ///
    /// # Errors
    /// As [`VertexTable::new`]; [`TableError::Length`] for lists of different lengths,
    /// [`TableError::Face`] for faces out of range.
    pub fn from_faces(
        faces: &[[u32; 3]],
        onto_vertices: usize,
        face_ids: &[i64],
        weights: &[Weights],
    ) -> Result<Self, TableError> {
        check_length(weights.len(), face_ids.len())?;
        let point = |(vertex, (&found, &weights))| {
            if found == -1 {
                return Ok(None);
            }
            let corners = usize::try_from(found).ok().and_then(|face| faces.get(face));
            match corners {
                Some(&vertices) => Ok(Some(SurfacePoint { vertices, weights })),
                None => Err(TableError::Face { vertex, found, faces: faces.len() }),
            }
        };
        let points = face_ids.iter().zip(weights).enumerate().map(point);
        Self::new(points.collect::<Result<_, _>>()?, onto_vertices)
    }

    /// A table of the vertices of faces and their weights, as SMPL-X's flip correspondences have.
    ///
    /// - `corners`: `[vertices]`, three vertices of the mesh on which the points lie; -1 as the first
    ///   for none.
    /// - `weights`: `[vertices]`, their weights; unused where there are none.
    /// - `onto_vertices`: number of vertices of that mesh.
    ///
    /// # Errors
    /// As [`VertexTable::new`]; [`TableError::Length`] for lists of different lengths.
    pub fn from_corners(
        corners: &[[i64; 3]],
        weights: &[Weights],
        onto_vertices: usize,
    ) -> Result<Self, TableError> {
        check_length(weights.len(), corners.len())?;
        let point = |(vertex, (corners, &weights)): (usize, (&[i64; 3], &Weights))| {
            if corners[0] == -1 {
                return Ok(None);
            }
            let mut vertices = [0; 3];
            for (to, &found) in vertices.iter_mut().zip(corners) {
                *to = u32::try_from(found).map_err(|_| TableError::Vertex {
                    vertex,
                    found,
                    vertices: onto_vertices,
                })?;
            }
            Ok(Some(SurfacePoint { vertices, weights }))
        };
        let points = corners.iter().zip(weights).enumerate().map(point);
        Self::new(points.collect::<Result<_, _>>()?, onto_vertices)
    }

    /// `[vertices]` points; `None` where nothing corresponds.
    pub fn points(&self) -> &[Option<SurfacePoint>] {
        &self.points
    }

    /// Number of vertices of the mesh on which the points lie.
    pub const fn onto_vertices(&self) -> usize {
        self.onto_vertices
    }

    /// Number of vertices that have a point.
    pub fn count(&self) -> usize {
        self.points.iter().flatten().count()
    }

    /// As a vertex map: the vertex at which each vertex's point lies, -1 where there is none; `None` if
    /// a point lies between vertices.
    pub fn vertex_map(&self) -> Option<Vec<i64>> {
        let entry = |point: &Option<SurfacePoint>| match point {
            Some(point) => point.vertex().map(i64::from),
            None => Some(-1),
        };
        self.points.iter().map(entry).collect()
    }
}

fn check_length(found: usize, wanted: usize) -> Result<(), TableError> {
    let what = "barycentric weights, as many as faces";
    if found == wanted { Ok(()) } else { Err(TableError::Length { what, found, wanted }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_made_exact() {
        let point = |weights| SurfacePoint::new([4, 5, 6], weights);
        assert_eq!(point([0.25, 0.5, 0.25]).unwrap().weights, [0.25, 0.5, 0.25]);
        let clamped = point([0.5, 0.509, -0.009]).unwrap().weights;
        assert_eq!((clamped[2], clamped[0] + clamped[1]), (0.0, 1.0));
        assert_eq!(point([0.25, 0.25, 0.5005]).unwrap().weights.iter().sum::<f64>(), 1.0);
        let snapped = point([5e-5, 0.999_95, 0.0]).unwrap();
        assert_eq!((snapped.weights, snapped.vertex()), ([0.0, 1.0, 0.0], Some(5)));
        assert_eq!(point([2e-4, 0.9998, 0.0]).unwrap().vertex(), None);
        for refused in [
            [0.5, 0.5, 0.01],
            [0.5, 0.52, -0.02],
            [f64::NAN, 0.5, 0.5],
            [f64::INFINITY, f64::NEG_INFINITY, 0.0],
            [0.0; 3],
        ] {
            assert_eq!(point(refused), None, "{refused:?}");
        }
    }

    #[test]
    fn faces_give_the_same_table_as_their_corners() {
        let faces = [[0, 1, 2], [2, 1, 3]];
        let weights = [[0.2, 0.3, 0.5], [0.0, 1.0, 0.0], [f64::NAN; 3]];
        let table = VertexTable::from_faces(&faces, 4, &[1, 0, -1], &weights).unwrap();
        let corners = [[2, 1, 3], [0, 1, 2], [-1, -1, -1]];
        assert_eq!(VertexTable::from_corners(&corners, &weights, 4).unwrap(), table);
        assert_eq!(table.points()[0].unwrap().vertices, [2, 1, 3]);
        assert_eq!((table.count(), table.points()[2], table.vertex_map()), (2, None, None));
        let whole = VertexTable::from_faces(&faces, 4, &[1, -1], &[[0.0, 0.0, 1.0]; 2]).unwrap();
        assert_eq!(whole.vertex_map(), Some(vec![3, -1]));
    }

    #[test]
    fn errors_name_the_vertex() {
        let faces = [[0, 1, 2]];
        let middle = [1.0 / 3.0; 3];
        let error = |ids: &[i64], weights: &[Weights], vertices| {
            VertexTable::from_faces(&faces, vertices, ids, weights).unwrap_err().to_string()
        };
        assert!(error(&[0, 0], &[middle], 3).contains("must be 2 barycentric weights"));
        assert_eq!(
            error(&[0, 1], &[middle; 2], 3),
            "the face of vertex 1 must be from 0 to 0, or -1 for none; got 1"
        );
        assert!(error(&[-2], &[middle], 3).contains("got -2"));
        assert!(error(&[0], &[[0.5; 3]], 3).contains("weights of vertex 0 must be finite"));
        assert!(error(&[0], &[middle], 2).contains("from 0 to 1 of the other mesh, got 2"));
        assert!(error(&[-1; 3], &[middle; 3], 3).contains("none of the 3 vertices"));
        let corners = |corners| VertexTable::from_corners(&[corners], &[middle], 9).unwrap_err();
        for found in [-3, 9, 1 << 40] {
            assert_eq!(
                corners([0, found, 1]),
                TableError::Vertex { vertex: 0, found, vertices: 9 }
            );
        }
    }
}
