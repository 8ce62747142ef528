//! Corresponding triangles from a vertex map, which gives the target vertex of each source vertex.
//!
//! Triangles are matched by their unordered set of vertices, so the first corner and the winding
//! may differ between the meshes. Where the other mesh triangulates a polygon along other
//! diagonals, the polygon's fan is rotated to the apex that gives the most matching triangles.

use super::places::place_count;
use crate::mesh::Mesh;
use crate::pair::Pair;
use crate::piece::Piece;

/// Why links that were found are none.
pub(super) const OUTSIDE: &str = "all matching faces have UV coordinates outside the unit square; \
    `outside` repeat moves them into it";

/// Why a vertex map can't link two meshes.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// The map does not have one entry per source vertex.
    #[error("vertex map must have one entry per vertex of the source mesh, {wanted}{}, got {found}{}",
        if .places == .wanted { String::new() } else { format!(" (at {places} different places)") },
        if *.swapped { " (the number of vertices of the target mesh: are source and target swapped?)" } else { "" })]
    Length {
        /// Number of entries in the map.
        found: usize,
        /// Number of vertices of the source mesh.
        wanted: usize,
        /// Number of different places of the source mesh's vertices.
        places: usize,
        /// Whether the target mesh has as many vertices as the map has entries.
        swapped: bool,
    },
    /// An entry is not a vertex index of the target mesh.
    #[error(
        "vertex map entry {entry} must be a vertex of the target mesh, from 0 to {}, or -1 for \
         none; got {found}{}",
        .vertices - 1,
        if *.found == *.vertices as i64 { "; are the indices 1-based?" } else { "" }
    )]
    Range {
        /// Index of the entry, 0-based.
        entry: usize,
        /// Its value.
        found: i64,
        /// Number of vertices of the target mesh.
        vertices: usize,
    },
    /// The map and both meshes are valid, but no triangles match.
    #[error(
        "none of the {source_faces} source faces maps to a target face; check that the vertex map \
         belongs to these meshes"
    )]
    Nothing {
        /// Number of triangles of the source mesh.
        source_faces: usize,
    },
    /// Triangles match, but none of them lies in the unit square of its texture.
    #[error("{OUTSIDE}")]
    Outside,
}

impl LinkError {
    /// A map that does not have as many entries as the source has vertices.
    pub(super) fn length(vertex_map: &[i64], source: &Mesh, target: &Mesh) -> Self {
        Self::Length {
            found: vertex_map.len(),
            wanted: source.positions().len(),
            places: place_count(source),
            swapped: vertex_map.len() == target.positions().len(),
        }
    }
}

/// Checks that all entries are vertices of the target or -1.
pub(super) fn check_entries(vertex_map: &[i64], vertices: usize) -> Result<(), LinkError> {
    let mut entries = vertex_map.iter().enumerate();
    match entries.find(|&(_, found)| !(-1..vertices as i64).contains(found)) {
        Some((entry, &found)) => Err(LinkError::Range { entry, found, vertices }),
        None => Ok(()),
    }
}

impl Pair {
    /// Links two meshes whose vertices correspond.
    ///
    /// - `vertex_map`: `[source vertices]`, for each the corresponding target vertex, or -1 for
    ///   none.
    ///
    /// Faces are matched by their vertices, whichever corner they start at and whichever way they
    /// wind. Polygons may be retriangulated where the two meshes chose different diagonals.
    /// Triangles outside the unit square of their layout are linked in their tiles alone: see
    /// [`Pair::from_pieces`].
    ///
    /// # Errors
    /// [`LinkError`] for a map of the wrong length or with entries out of range, or if no face
    /// matches.
    pub fn by_vertex_map(
        mut source: Mesh,
        mut target: Mesh,
        vertex_map: &[i64],
    ) -> Result<Self, LinkError> {
        let pieces = pieces(&mut source, &mut target, vertex_map)?;
        Self::of_found(source, target, pieces).ok_or(LinkError::Outside)
    }
}

/// Links the triangles of two meshes whose vertices correspond.
///
/// - `vertex_map`: `[source vertices]`, the target vertex of each source vertex, or -1 for none.
///
/// Polygons of either mesh may be retriangulated (see the module documentation); triangles never
/// change. Pieces are in ascending order of their target face. Where several faces have the same
/// vertices (doubled surfaces), each is linked to every match.
///
/// # Errors
/// [`LinkError`] for a map of the wrong length or with entries out of range, or if nothing matches.
fn pieces(
    source: &mut Mesh,
    target: &mut Mesh,
    vertex_map: &[i64],
) -> Result<Vec<Piece>, LinkError> {
    let vertices = target.positions().len();
    if vertex_map.len() != source.positions().len() {
        return Err(LinkError::length(vertex_map, source, target));
    }
    check_entries(vertex_map, vertices)?;
    // Source vertices as target vertices; those without a counterpart get an unused index.
    let common = |vertex: u32| u32::try_from(vertex_map[vertex as usize]).unwrap_or(u32::MAX);
    let found = link_faces(source, target, common, |vertex| vertex);
    if found.is_empty() {
        return Err(LinkError::Nothing { source_faces: source.faces().len() });
    }
    Ok(found)
}

/// Links the triangles whose corners are the same points, given for the vertices of both meshes;
/// `u32::MAX` for none. Polygons may be retriangulated; pieces are in ascending order of their
/// target face.
pub(super) fn link_faces(
    source: &mut Mesh,
    target: &mut Mesh,
    source_point: impl Fn(u32) -> u32,
    target_point: impl Fn(u32) -> u32,
) -> Vec<Piece> {
    rotate_fans(target, &target_point, &sorted_keys(source, &source_point));
    rotate_fans(source, &source_point, &sorted_keys(target, &target_point));
    let source_keys = sorted_keys(source, &source_point);
    let mut found = Vec::with_capacity(source_keys.len());
    for (target_face, corners) in target.faces().iter().enumerate() {
        let corners = corners.map(&target_point);
        let key = face_key(corners);
        if key[2] == u32::MAX {
            continue;
        }
        let first = source_keys.partition_point(|(other, _)| *other < key);
        for &(_, source_face) in source_keys[first..].iter().take_while(|(other, _)| *other == key)
        {
            let source_corners = source.faces()[source_face as usize].map(&source_point);
            if let Some(corners) = permutation(corners, source_corners) {
                found.push(Piece::whole(target_face as u32, source_face, corners));
            }
        }
    }
    found
}

type FaceKey = [u32; 3];

fn face_key(mut corners: [u32; 3]) -> FaceKey {
    corners.sort_unstable();
    corners
}

/// The sorted vertices of each face with its index, sorted; equal keys are in ascending
/// face order. Faces with a vertex that has no counterpart are left out.
fn sorted_keys(mesh: &Mesh, common: impl Fn(u32) -> u32) -> Vec<(FaceKey, u32)> {
    let mut keys: Vec<(FaceKey, u32)> = mesh
        .faces()
        .iter()
        .zip(0..)
        .map(|(corners, face)| (face_key(corners.map(&common)), face))
        .filter(|(key, _)| key[2] != u32::MAX)
        .collect();
    keys.sort_unstable();
    keys
}

/// Rotates each polygon's fan to the apex for which most of its triangles are among `others`.
fn rotate_fans(mesh: &mut Mesh, common: impl Fn(u32) -> u32, others: &[(FaceKey, u32)]) {
    let known = |corners: [u32; 3]| {
        let key = face_key(corners.map(&common));
        others.binary_search_by_key(&key, |(other, _)| *other).is_ok()
    };
    for polygon in 0..mesh.polygon_count() {
        if mesh.polygon(polygon).len() == 1 {
            continue;
        }
        let corners = mesh.polygon_corners(polygon);
        let matches = |apex: usize| {
            let at = |k: usize| corners[(apex + k) % corners.len()].vertex;
            (1..corners.len() - 1).filter(|&k| known([at(0), at(k), at(k + 1)])).count()
        };
        let best = (0..corners.len()).rev().max_by_key(|&apex| matches(apex)).unwrap_or(0);
        if best != 0 {
            mesh.refan(polygon, best);
        }
    }
}

/// For each corner of `target`, the corner of `source` with the same vertex; `None` if `target`
/// repeats a vertex, which makes the assignment ambiguous.
fn permutation(target: [u32; 3], source: [u32; 3]) -> Option<[u8; 3]> {
    let [a, b, c] = target;
    if a == b || b == c || c == a {
        return None;
    }
    let mut corners = [0; 3];
    for (corner, vertex) in corners.iter_mut().zip(target) {
        *corner = source.iter().position(|&other| other == vertex)? as u8;
    }
    Some(corners)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Corner;
    use crate::piece::Extent;

    /// A pentagon with an adjacent quad; vertex and UV indices are the same.
    fn ring() -> Vec<[f32; 2]> {
        vec![[0.5, 0.0], [0.9, 0.3], [0.7, 0.8], [0.3, 0.8], [0.1, 0.3], [1.0, 0.8], [1.0, 0.4]]
    }

    fn mesh(polygons: &[&[u32]], renumber: impl Fn(u32) -> u32) -> Mesh {
        let mut uv = vec![[0.0; 2]; 7];
        for (vertex, at) in ring().into_iter().enumerate() {
            uv[renumber(vertex as u32) as usize] = at;
        }
        let positions = uv.iter().map(|&[x, y]| [x, y, 0.0]).collect();
        let corners: Vec<Corner> = polygons
            .iter()
            .flat_map(|polygon| polygon.iter().map(|&vertex| renumber(vertex)))
            .map(|vertex| Corner { vertex, uv: vertex })
            .collect();
        let sizes: Vec<u32> = polygons.iter().map(|polygon| polygon.len() as u32).collect();
        Mesh::from_polygons(positions, uv, &corners, &sizes).unwrap()
    }

    /// Number of pieces and of flipped ones; checks that linked corners are the same vertex.
    fn count(mut source: Mesh, mut target: Mesh, vertex_map: &[i64]) -> (usize, usize) {
        let found = pieces(&mut source, &mut target, vertex_map).unwrap();
        for piece in &found {
            let Extent::Whole(corners) = piece.extent else { panic!("{piece:?}") };
            for k in 0..3 {
                let source_vertex = source.faces()[piece.source as usize][corners[k] as usize];
                let target_vertex = target.faces()[piece.target as usize][k];
                assert_eq!(vertex_map[source_vertex as usize], i64::from(target_vertex));
            }
        }
        (found.len(), found.iter().filter(|piece| piece.flips()).count())
    }

    #[test]
    fn first_corner_winding_and_indices_may_differ() {
        let vertex_map: Vec<i64> = (0..7).map(|vertex| (vertex * 3 + 2) % 7).collect();
        let source = mesh(&[&[0, 1, 2, 3, 4], &[1, 6, 5, 2]], |vertex| vertex);
        for polygons in [
            [&[0, 1, 2, 3, 4][..], &[1, 6, 5, 2]],
            [&[3, 4, 0, 1, 2], &[6, 5, 2, 1]],
            [&[4, 3, 2, 1, 0], &[1, 2, 5, 6]],
        ] {
            let flipped = if polygons[0][0] == 4 { 5 } else { 0 };
            let target = mesh(&polygons, |vertex| (vertex * 3 + 2) % 7);
            assert_eq!(count(source.clone(), target, &vertex_map), (5, flipped));
        }
    }

    #[test]
    fn polygons_follow_the_other_sides_triangles() {
        let identity: Vec<i64> = (0..7).collect();
        let polygons = mesh(&[&[0, 1, 2, 3, 4], &[1, 6, 5, 2]], |vertex| vertex);
        let triangles =
            mesh(&[&[2, 3, 4], &[4, 0, 2], &[0, 1, 2], &[6, 5, 2], &[6, 2, 1]], |vertex| vertex);
        assert_eq!(count(polygons.clone(), triangles.clone(), &identity), (5, 0));
        assert_eq!(count(triangles, polygons, &identity), (5, 0));
    }

    #[test]
    fn vertices_without_counterpart_leave_their_faces_unlinked() {
        let mut vertex_map: Vec<i64> = (0..7).collect();
        vertex_map[6] = -1;
        let source = mesh(&[&[0, 1, 2, 3, 4], &[1, 6, 5, 2]], |vertex| vertex);
        assert_eq!(count(source.clone(), source, &vertex_map).0, 4);
    }

    #[test]
    fn errors_name_the_problem() {
        let mut source = mesh(&[&[0, 1, 2]], |vertex| vertex);
        let mut target = mesh(&[&[0, 1, 3]], |vertex| vertex);
        let mut error =
            |map: &[i64]| pieces(&mut source, &mut target, map).unwrap_err().to_string();
        assert!(error(&[0, 1]).contains("one entry per vertex of the source mesh, 7, got 2"));
        assert!(error(&[0, 1, 2, 3, 4, 5, 7]).contains("-1 for none; got 7"));
        assert!(error(&[0, 1, 2, -2, 4, 5, 6]).contains("-1 for none; got -2"));
        assert!(error(&[0, 1, 2, 3, 4, 5, 6]).contains("none of the 1 source faces"));
    }

    #[test]
    fn faces_outside_the_unit_square_are_not_linked() {
        let triangle_at = |u: f32| {
            let uv = vec![[u, 0.0], [u + 1.0, 0.0], [u, 1.0]];
            let positions = uv.iter().map(|&[x, y]| [x, y, 0.0]).collect();
            Mesh::from_triangles(positions, uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap()
        };
        let linked = |source, target| Pair::by_vertex_map(source, target, &[0, 1, 2]);
        assert_eq!(linked(triangle_at(2.0), triangle_at(0.0)), Err(LinkError::Outside));
        assert_eq!(linked(triangle_at(0.0), triangle_at(-0.01)), Err(LinkError::Outside));
        // Within the tolerance for rounding.
        assert!(linked(triangle_at(0.0005), triangle_at(0.0)).is_ok());
    }
}
