//! Corresponding triangles from a vertex map, which gives the target vertex of each source vertex.
//!
//! Triangles are matched by their unordered set of vertices, so the first corner and the winding
//! may differ between the meshes. Where the other mesh triangulates a polygon along other
//! diagonals, the polygon's fan is rotated to the apex that gives the most matching triangles.

use super::fans::{self, Keyed};
use super::places::place_count;
use super::twins::{self, Twin};
use crate::mesh::Mesh;
use crate::pair::Pair;
use crate::piece::Piece;

/// The message if triangles correspond, but no texture reaches any of them.
pub(super) const OUTSIDE: &str = "all matching faces have UV coordinates outside the unit square; \
    `outside` repeat moves them into it, unless they cross borders of tiles";

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
/// change. Pieces are in ascending order of their target face.
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
/// target face. Of several triangles at the same points, each is linked to its own ([`twins`]).
pub(super) fn link_faces(
    source: &mut Mesh,
    target: &mut Mesh,
    source_point: impl Fn(u32) -> u32,
    target_point: impl Fn(u32) -> u32,
) -> Vec<Piece> {
    let mut source_keys = sorted_keys(source, &source_point);
    let mut target_keys = sorted_keys(target, &target_point);
    let alone = [alone(source, &source_point), alone(target, &target_point)];
    // Only twins have to be told apart.
    let is_turned = alone.iter().flatten().any(|is_alone| !is_alone)
        && wind_oppositely([&source_keys, &target_keys], &alone);
    if rotate_fans(target, &target_point, &source_keys, is_turned) {
        target_keys = sorted_keys(target, &target_point);
    }
    if rotate_fans(source, &source_point, &target_keys, is_turned) {
        source_keys = sorted_keys(source, &source_point);
    }
    let source_points = |face: u32| source.faces()[face as usize].map(&source_point);
    let target_points = |face: u32| target.faces()[face as usize].map(&target_point);
    let mut found = Vec::with_capacity(target_keys.len());
    let mut link = |source_face: u32, target_face: u32| {
        let corners = permutation(target_points(target_face), source_points(source_face));
        found.extend(corners.map(|corners| Piece::whole(target_face, source_face, corners)));
    };
    let source_twin = |it: &Keyed| Twin::new(source, it.face, source_points(it.face), is_turned);
    let target_twin = |it: &Keyed| Twin::new(target, it.face, target_points(it.face), false);
    for_each_group(&source_keys, &target_keys, |sources, targets| {
        if let ([one], [other]) = (sources, targets) {
            return link(one.face, other.face);
        }
        let sources: Vec<Twin> = sources.iter().map(source_twin).collect();
        let targets: Vec<Twin> = targets.iter().map(target_twin).collect();
        twins::matched(&sources, &targets).into_iter().for_each(|[one, other]| link(one, other));
    });
    // Those of one face stay in their order.
    found.sort_by_key(|piece| piece.target);
    found
}

/// The triangles of a mesh by their points, sorted. Those with a vertex that has no counterpart are
/// left out.
fn sorted_keys(mesh: &Mesh, point: impl Fn(u32) -> u32) -> Vec<Keyed> {
    let mut keys: Vec<Keyed> = (0..)
        .zip(mesh.faces())
        .map(|(face, corners)| Keyed::new(corners.map(&point), face))
        .filter(|keyed| keyed.points[2] != u32::MAX)
        .collect();
    keys.sort_unstable();
    keys
}

/// Calls `visit` with the triangles of both meshes at the same points, for all points.
fn for_each_group(sources: &[Keyed], targets: &[Keyed], mut visit: impl FnMut(&[Keyed], &[Keyed])) {
    fn groups(keys: &[Keyed]) -> impl Iterator<Item = &[Keyed]> {
        keys.chunk_by(|one, other| one.points == other.points)
    }
    let mut others = groups(targets).peekable();
    for group in groups(sources) {
        let points = group[0].points;
        while others.next_if(|other| other[0].points < points).is_some() {}
        if let Some(other) = others.next_if(|other| other[0].points == points) {
            visit(group, other);
        }
    }
}

/// Whether one mesh is inside out, compared with the other, by the triangles of polygons that are
/// alone at their points.
fn wind_oppositely(keys: [&[Keyed]; 2], alone: &[Vec<bool>; 2]) -> bool {
    let (mut alike, mut opposite) = (0, 0);
    for_each_group(keys[0], keys[1], |sources, targets| {
        if let ([source], [target]) = (sources, targets)
            && alone[0][source.face as usize]
            && alone[1][target.face as usize]
        {
            *if source.is_odd == target.is_odd { &mut alike } else { &mut opposite } += 1;
        }
    });
    opposite > alike
}

/// For each triangle, whether no other polygon has the points of its polygon.
fn alone(mesh: &Mesh, point: impl Fn(u32) -> u32) -> Vec<bool> {
    // Independent of where a polygon starts and how it winds.
    let sum = |polygon: usize| {
        let fan = mesh.polygon(polygon);
        let [first, second, _] = mesh.faces()[fan.start];
        let others = fan.map(|face| mesh.faces()[face][2]);
        let vertices = others.chain([first, second]);
        vertices.map(|vertex| scrambled(point(vertex))).fold(0, u64::wrapping_add)
    };
    let sums: Vec<u64> = (0..mesh.polygon_count()).map(sum).collect();
    let mut order: Vec<u32> = (0..sums.len() as u32).collect();
    order.sort_unstable_by_key(|&polygon| sums[polygon as usize]);
    let mut alone = vec![false; mesh.faces().len()];
    for group in order.chunk_by(|&one, &other| sums[one as usize] == sums[other as usize]) {
        if let &[polygon] = group {
            alone[mesh.polygon(polygon as usize)].fill(true);
        }
    }
    alone
}

/// A number for each point, such that sums of several are different in practice.
fn scrambled(point: u32) -> u64 {
    let spread = (u64::from(point) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (spread ^ (spread >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9).rotate_left(27)
}

/// Corners of polygons that are matched triangle by triangle, whatever their apex: for more, that takes
/// the square of them.
const FEW_CORNERS: usize = 16;

/// Rotates each polygon's fan to the apex for which most of its triangles are among `others`, and of
/// those to the one where most wind as they do there. Returns whether any fan was rotated.
///
/// - `is_turned`: whether the other mesh is inside out, compared with this one.
fn rotate_fans(
    mesh: &mut Mesh,
    point: impl Fn(u32) -> u32,
    others: &[Keyed],
    is_turned: bool,
) -> bool {
    let mut any = false;
    let mut at_edges = None;
    for polygon in 0..mesh.polygon_count() {
        if mesh.polygon(polygon).len() == 1 {
            continue;
        }
        let corners = mesh.polygon_corners(polygon);
        let ring: Vec<u32> = corners.iter().map(|corner| point(corner.vertex)).collect();
        let matches = if ring.len() <= FEW_CORNERS {
            fans::matches_by_triangle(&ring, others, is_turned)
        } else {
            let at_edges = at_edges.get_or_insert_with(|| fans::AtEdges::new(others));
            at_edges.matches(&ring, is_turned)
        };
        let best = (0..ring.len()).rev().max_by_key(|&apex| matches[apex]).unwrap_or(0);
        if best != 0 {
            mesh.refan(polygon, best);
            any = true;
        }
    }
    any
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

    /// The source face of each target face.
    fn linked(mut source: Mesh, mut target: Mesh) -> Vec<(u32, u32)> {
        let identity: Vec<i64> = (0..7).collect();
        let found = pieces(&mut source, &mut target, &identity).unwrap();
        found.iter().map(|piece| (piece.target, piece.source)).collect()
    }

    #[test]
    fn both_sides_of_a_sheet_are_linked_to_their_own() {
        let same = |vertex| vertex;
        let sheet = mesh(&[&[0, 1, 2], &[0, 2, 3], &[2, 1, 0], &[3, 2, 0]], same);
        assert_eq!(linked(sheet.clone(), sheet.clone()), [(0, 0), (1, 1), (2, 2), (3, 3)]);
        let reordered = mesh(&[&[3, 2, 0], &[1, 2, 0], &[2, 1, 0], &[0, 2, 3]], same);
        assert_eq!(linked(sheet.clone(), reordered), [(0, 3), (1, 0), (2, 2), (3, 1)]);
        // Inside out, which a face that is alone shows.
        let alone = [&[0, 1, 2][..], &[0, 2, 1], &[1, 6, 5], &[5, 2, 1]];
        let turned = [&[0, 2, 1][..], &[0, 1, 2], &[1, 5, 6], &[5, 1, 2]];
        let found = linked(mesh(&alone, same), mesh(&turned, same));
        assert_eq!(found, [(0, 0), (1, 1), (2, 2), (3, 3)]);
        // A side that only one of the meshes has.
        let front = mesh(&[&[0, 1, 2], &[0, 2, 3]], same);
        assert_eq!(linked(front.clone(), sheet.clone()), [(0, 0), (1, 1), (2, 0), (3, 1)]);
        assert_eq!(linked(sheet, front), [(0, 0), (0, 2), (1, 1), (1, 3)]);
    }

    #[test]
    fn quads_of_both_sides_follow_the_triangles_of_their_own() {
        let same = |vertex| vertex;
        let quads = mesh(&[&[0, 1, 2, 3], &[3, 2, 1, 0]], same);
        // Each side is split along the diagonal that the quad of the other side is split along.
        let triangles = mesh(&[&[2, 1, 0], &[3, 2, 0], &[1, 2, 3], &[1, 3, 0]], same);
        for (source, target, front) in
            [(quads.clone(), triangles.clone(), [2, 3]), (triangles, quads, [0, 1])]
        {
            let found = linked(source.clone(), target.clone());
            assert_eq!(found.len(), 4);
            for (target, source) in found {
                let is_front = front.contains(&target);
                assert_eq!(is_front, if front[0] == 2 { source < 2 } else { source >= 2 });
            }
        }
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
