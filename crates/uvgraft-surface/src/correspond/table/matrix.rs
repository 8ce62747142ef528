//! Tables from sparse matrices that take the vertices of one mesh to those of another.
//!
//! The published ones are deformation-transfer matrices (`smpl2smplx_deftrafo_setup.pkl` and
//! others of SMPL-X's `model_transfer`): each row has the barycentric weights of one vertex on the
//! other mesh. Their second half of columns multiplies vertex normals: an offset from the surface,
//! which a texture has no use for.

use super::{MOST_NEGATIVE, SUM_TOLERANCE, SurfacePoint, TableError, VertexTable};

/// What the rows of a matrix are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RowCounts {
    /// One element: a vertex of the other mesh.
    pub vertices: usize,
    /// Two elements: a point on an edge, or between any two vertices.
    pub edges: usize,
    /// Three elements: a point on a face.
    pub faces: usize,
    /// More elements, of which all but three add up to less than 0.001: counted here, and used like
    /// those of three.
    pub shortened: usize,
    /// More elements of weight, so not a point on a face: left out.
    pub spread: usize,
    /// Elements that don't add up to 1, or are negative: left out.
    pub unweighted: usize,
    /// No elements.
    pub empty: usize,
}

impl VertexTable {
    /// A table from the rows of a sparse matrix, and what they are.
    ///
    /// - `rows`: for each vertex, the columns and values of its row's elements.
    /// - `columns`: number of columns, `onto_vertices` or twice that. Only the first half is used then.
    /// - `onto_vertices`: number of vertices of the mesh on which the points lie.
    ///
    /// # Errors
    /// [`TableError::Columns`] for another number of columns, [`TableError::Vertex`] for a column out
    /// of range, [`TableError::Element`] for NaN, [`TableError::Nothing`] if no row is a point.
    pub fn from_rows<'a>(
        rows: impl IntoIterator<Item = (&'a [u32], &'a [f64])>,
        columns: usize,
        onto_vertices: usize,
    ) -> Result<(Self, RowCounts), TableError> {
        if columns != onto_vertices && Some(columns) != onto_vertices.checked_mul(2) {
            return Err(TableError::Columns { found: columns, wanted: onto_vertices });
        }
        let mut counts = RowCounts::default();
        let mut points = Vec::new();
        let mut elements = Vec::new();
        for (row, (places, values)) in rows.into_iter().enumerate() {
            elements.clear();
            for (&column, &value) in places.iter().zip(values) {
                if column as usize >= columns {
                    let found = column.into();
                    return Err(TableError::Vertex { vertex: row, found, vertices: columns });
                }
                if !value.is_finite() {
                    return Err(TableError::Element { row, column, value });
                }
                if value != 0.0 && (column as usize) < onto_vertices {
                    elements.push((column, value));
                }
            }
            points.push(point(&mut elements, &mut counts));
        }
        Ok((Self::new(points, onto_vertices)?, counts))
    }
}

/// The point of a row, which is counted.
fn point(elements: &mut [(u32, f64)], counts: &mut RowCounts) -> Option<SurfacePoint> {
    elements.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()).then(a.0.cmp(&b.0)));
    let (kept, rest) = elements.split_at(elements.len().min(3));
    let Some(&(first, _)) = kept.first() else {
        counts.empty += 1;
        return None;
    };
    let left_out: f64 = rest.iter().map(|element| element.1.abs()).sum();
    if left_out >= SUM_TOLERANCE {
        counts.spread += 1;
        return None;
    }
    let mut vertices = [first; 3];
    let mut weights = [0.0; 3];
    for (k, &(column, value)) in kept.iter().enumerate() {
        (vertices[k], weights[k]) = (column, value);
    }
    let sum: f64 = weights.iter().sum();
    let is_one = (sum + rest.iter().map(|element| element.1).sum::<f64>() - 1.0).abs();
    if is_one > SUM_TOLERANCE || weights.iter().any(|&weight| weight < MOST_NEGATIVE) {
        counts.unweighted += 1;
        return None;
    }
    *match (kept.len(), rest.len()) {
        (1, _) => &mut counts.vertices,
        (2, _) => &mut counts.edges,
        (_, 0) => &mut counts.faces,
        _ => &mut counts.shortened,
    } += 1;
    // What was left out is distributed, so that no sum is refused later.
    Some(SurfacePoint { vertices, weights: weights.map(|weight| weight / sum) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(
        rows: &[(&[u32], &[f64])],
        columns: usize,
    ) -> Result<(VertexTable, RowCounts), TableError> {
        VertexTable::from_rows(rows.iter().copied(), columns, 6)
    }

    #[test]
    fn rows_of_every_kind() {
        let rows: [(&[u32], &[f64]); 9] = [
            (&[3], &[1.0]),
            (&[1, 4], &[0.25, 0.75]),
            (&[0, 2, 5], &[0.5, 0.3, 0.2]),
            // Tiny elements beside three, and four of weight.
            (&[0, 1, 2, 3], &[0.4, 0.0004, 0.3, 0.2996]),
            (&[0, 1, 2, 3], &[0.25; 4]),
            (&[0, 1], &[0.5, 0.4]),
            (&[0, 1], &[1.2, -0.2]),
            (&[], &[]),
            // Zeros that are stored, and normals.
            (&[0, 1, 2, 3, 9], &[0.0, 0.0, 0.0, 1.0, -0.01]),
        ];
        let (table, counts) = table(&rows, 12).unwrap();
        let wanted = RowCounts {
            vertices: 2,
            edges: 1,
            faces: 1,
            shortened: 1,
            spread: 1,
            unweighted: 2,
            empty: 1,
        };
        assert_eq!(counts, wanted);
        let points = table.points();
        assert_eq!((points[0].unwrap().vertex(), points[8].unwrap().vertex()), (Some(3), Some(3)));
        let edge = points[1].unwrap();
        assert_eq!((edge.vertices, edge.weights), ([4, 1, 4], [0.75, 0.25, 0.0]));
        assert_eq!(points[2].unwrap().weights, [0.5, 0.3, 0.2]);
        assert!((points[3].unwrap().weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(points[4..8].iter().all(Option::is_none));
    }

    #[test]
    fn matrices_of_other_meshes_are_refused() {
        let row: [(&[u32], &[f64]); 1] = [(&[0], &[1.0])];
        let error = |columns| table(&row, columns).unwrap_err().to_string();
        assert!(error(7).contains("must have 6 columns") && error(7).ends_with("got 7"));
        assert!(error(24).ends_with("got 24"));
        let nan: [(&[u32], &[f64]); 1] = [(&[7], &[f64::NAN])];
        let error = table(&nan, 12).unwrap_err().to_string();
        assert_eq!(error, "the matrix must be finite, got NaN in row 0, column 7");
        let beyond: [(&[u32], &[f64]); 1] = [(&[6], &[1.0])];
        assert!(matches!(table(&beyond, 6), Err(TableError::Vertex { found: 6, .. })));
        // All weights in the half of the normals.
        assert_eq!(table(&beyond, 12).unwrap_err(), TableError::Nothing { vertices: 1 });
        assert_eq!(table(&[], 6).unwrap_err(), TableError::Nothing { vertices: 0 });
        assert!(VertexTable::from_rows(row, usize::MAX, usize::MAX / 2 + 1).is_err());
    }
}
