//! Corresponding triangles from a vertex map: which target vertex each source vertex is.
//!
//! A triangle is known by its three vertices alone, so its corners may start anywhere and wind
//! either way. Where one mesh has polygons that the other triangulates along another diagonal, the
//! polygon's fan is turned until most of its triangles are found on the other side.

use crate::mesh::Mesh;
use crate::piece::Piece;

/// Why a vertex map does not join two meshes.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// One entry for each source vertex is wanted.
    #[error("vertex map has {found} entries, the source mesh has {wanted} vertices{}",
        if *.swapped { " (the target mesh has as many as the map has entries: are source and target swapped?)" } else { "" })]
    Length {
        /// Entries in the map.
        found: usize,
        /// Vertices of the source mesh.
        wanted: usize,
        /// Whether the target mesh has as many vertices as the map has entries.
        swapped: bool,
    },
    /// An entry names a vertex that the target does not have.
    #[error(
        "vertex map entry {entry} must be a vertex of the target mesh, from 0 to {}, or -1 for \
         none; got {found}{}",
        .vertices - 1,
        if *.found == *.vertices as i64 { "; are the indices 1-based?" } else { "" }
    )]
    Range {
        /// Which entry, from 0.
        entry: usize,
        /// What it says.
        found: i64,
        /// Vertices of the target mesh.
        vertices: usize,
    },
    /// The map and both meshes are sound by themselves, yet nothing matches.
    #[error(
        "none of the {source_faces} source faces has its vertices in a target face: \
         the vertex map does not belong to these meshes"
    )]
    Nothing {
        /// Triangles of the source mesh.
        source_faces: usize,
    },
    /// Faces match, and none of them is where a texture is.
    #[error("all matching faces have UV coordinates outside the unit square")]
    Outside,
}

/// Links the triangles of two meshes whose vertices correspond.
///
/// - `vertex_map`: `[source vertices]`, for each the target vertex it is, or -1 for none.
///
/// Polygons of either mesh may be triangulated anew (see the module's text); triangles never change.
/// Pieces come in the order of their target face. Faces that several faces share the vertices of
/// (doubled surfaces) are linked to each of them.
///
/// # Errors
/// [`LinkError`] for a map of the wrong length or with entries out of range, or if nothing matches.
pub(crate) fn pieces(
    source: &mut Mesh,
    target: &mut Mesh,
    vertex_map: &[i64],
) -> Result<Vec<Piece>, LinkError> {
    let vertices = target.positions().len();
    if vertex_map.len() != source.positions().len() {
        return Err(LinkError::Length {
            found: vertex_map.len(),
            wanted: source.positions().len(),
            swapped: vertex_map.len() == vertices,
        });
    }
    for (entry, &found) in vertex_map.iter().enumerate() {
        if !(-1..vertices as i64).contains(&found) {
            return Err(LinkError::Range { entry, found, vertices });
        }
    }
    // In target vertices; what has no counterpart gets a number that no target face uses.
    let common = |vertex: u32| u32::try_from(vertex_map[vertex as usize]).unwrap_or(u32::MAX);
    turn_fans(target, |vertex| vertex, &sorted_keys(source, common));
    turn_fans(source, common, &sorted_keys(target, |vertex| vertex));

    let source_keys = sorted_keys(source, common);
    let mut found = Vec::with_capacity(source_keys.len());
    for (target_face, corners) in target.faces().iter().enumerate() {
        let key = face_key(*corners);
        let first = source_keys.partition_point(|(other, _)| *other < key);
        for &(_, source_face) in source_keys[first..].iter().take_while(|(other, _)| *other == key)
        {
            let source_corners = source.faces()[source_face as usize].map(common);
            if let Some(corners) = permutation(*corners, source_corners) {
                found.push(Piece::whole(target_face as u32, source_face, corners));
            }
        }
    }
    if found.is_empty() {
        return Err(LinkError::Nothing { source_faces: source.faces().len() });
    }
    Ok(found)
}

type FaceKey = [u32; 3];

fn face_key(mut corners: [u32; 3]) -> FaceKey {
    corners.sort_unstable();
    corners
}

/// Every face by its vertices, sorted; equal keys in the order of their faces.
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

/// Turns each polygon's fan to the corner from which most of its triangles are among `others`.
fn turn_fans(mesh: &mut Mesh, common: impl Fn(u32) -> u32, others: &[(FaceKey, u32)]) {
    let known = |corners: [u32; 3]| {
        let key = face_key(corners.map(&common));
        others.binary_search_by_key(&key, |(other, _)| *other).is_ok()
    };
    for polygon in 0..mesh.polygon_count() {
        if mesh.polygon(polygon).len() == 1 {
            continue;
        }
        let corners = mesh.polygon_corners(polygon);
        let found_from = |apex: usize| {
            let at = |k: usize| corners[(apex + k) % corners.len()].vertex;
            (1..corners.len() - 1).filter(|&k| known([at(0), at(k), at(k + 1)])).count()
        };
        let best = (0..corners.len()).rev().max_by_key(|&apex| found_from(apex)).unwrap_or(0);
        if best != 0 {
            mesh.refan(polygon, best);
        }
    }
}

/// For each corner of `target`, the corner of `source` with the same vertex; `None` if a vertex
/// repeats, so that corners cannot be told apart.
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

    /// A pentagon and a quad beside it; vertex and UV indices are the same.
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

    /// Counts the pieces, and checks that every linked corner is the same vertex on both sides.
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
    fn any_start_corner_either_winding_and_other_numbers() {
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
    fn says_what_is_wrong_with_a_map() {
        let mut source = mesh(&[&[0, 1, 2]], |vertex| vertex);
        let mut target = mesh(&[&[0, 1, 3]], |vertex| vertex);
        let mut error =
            |map: &[i64]| pieces(&mut source, &mut target, map).unwrap_err().to_string();
        assert!(error(&[0, 1]).contains("2 entries, the source mesh has 7 vertices"));
        assert!(error(&[0, 1, 2, 3, 4, 5, 7]).contains("-1 for none; got 7"));
        assert!(error(&[0, 1, 2, -2, 4, 5, 6]).contains("-1 for none; got -2"));
        assert!(error(&[0, 1, 2, 3, 4, 5, 6]).contains("none of the 1 source faces"));
    }
}
