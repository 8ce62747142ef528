//! UV islands (charts) and their boundary edges.
//!
//! Two triangles belong to the same island when they share a corner: the same vertex at the same UV
//! coordinate. UV coordinates are compared by value, not by index, because many exporters repeat a
//! coordinate for every face.

use crate::disjoint::DisjointSets;
use crate::mesh::{Mesh, bits_of, doubled_area};
use crate::piece::wide;
use crate::threads::map_indices;

/// The islands of a layout, in ascending order of their lowest face.
#[derive(Debug, Clone)]
pub struct Islands {
    of_face: Vec<u32>,
    first_faces: Vec<u32>,
    border: Vec<BoundaryEdge>,
}

/// A boundary edge: one with triangles on one side only, given by one of these triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoundaryEdge {
    /// The triangle.
    pub face: u32,
    /// The edge runs from this corner (0, 1 or 2) of the triangle to the next corner.
    pub corner: u8,
}

impl Islands {
    /// Finds the islands of a mesh's UV layout.
    pub fn new(mesh: &Mesh) -> Self {
        let (corners, count) = weld_corners(mesh, mesh.faces(), mesh.positions().len());
        let mut sets = DisjointSets::new(count);
        for &[a, b, c] in &corners {
            sets.join(a, b);
            sets.join(a, c);
        }
        let mut island_of_root = vec![u32::MAX; count as usize];
        let mut first_faces = Vec::new();
        let mut of_face = Vec::with_capacity(corners.len());
        for (face, &[a, ..]) in corners.iter().enumerate() {
            let island = &mut island_of_root[sets.root(a) as usize];
            if *island == u32::MAX {
                *island = first_faces.len() as u32;
                first_faces.push(face as u32);
            }
            of_face.push(*island);
        }
        Self { of_face, first_faces, border: border(mesh, &corners, count) }
    }

    /// Number of islands.
    pub fn count(&self) -> usize {
        self.first_faces.len()
    }

    /// The island of each triangle.
    pub fn of_faces(&self) -> &[u32] {
        &self.of_face
    }

    /// The boundary edges of the islands, in the order of their triangles.
    pub fn boundary_edges(&self) -> &[BoundaryEdge] {
        &self.border
    }
}

/// Gives each corner an index that is the same for corners with the same vertex and UV coordinate;
/// also returns the number of distinct indices.
///
/// - `vertices`: `[triangles]`, the vertex at each corner: those of the mesh, or welded points. Each
///   is below `vertex_count`.
pub(crate) fn weld_corners(
    mesh: &Mesh,
    vertices: &[[u32; 3]],
    vertex_count: usize,
) -> (Vec<[u32; 3]>, u32) {
    /// Of a vertex that no corner has seen; no coordinate is NaN.
    const UNSEEN: [u32; 2] = [u32::MAX; 2];
    let key = |uv: u32| bits_of(mesh.uv()[uv as usize]);
    let corners = || vertices.as_flattened().iter().zip(mesh.uv_faces().as_flattened());
    // Most vertices have one coordinate. Those of the others, which lie on seams, are sorted.
    let mut first = vec![UNSEEN; vertex_count];
    let mut is_on_seam = vec![false; vertex_count];
    for (&vertex, &uv) in corners() {
        let (first, key) = (&mut first[vertex as usize], key(uv));
        if *first == UNSEEN {
            *first = key;
        } else if *first != key {
            is_on_seam[vertex as usize] = true;
        }
    }
    let on_seams = corners().filter(|(vertex, _)| is_on_seam[**vertex as usize]);
    let mut on_seams: Vec<(u32, [u32; 2])> =
        on_seams.map(|(&vertex, &uv)| (vertex, key(uv))).collect();
    on_seams.sort_unstable();
    on_seams.dedup();
    let of_vertex = |vertex: u32| {
        let first = on_seams.partition_point(|other| other.0 < vertex);
        let count = on_seams[first..].iter().take_while(|other| other.0 == vertex).count();
        first..first + count
    };
    let mut id = 0;
    let mut ids = Vec::with_capacity(vertex_count);
    for (vertex, first) in (0..).zip(first) {
        ids.push(id);
        id += match first {
            UNSEEN => 0,
            _ if is_on_seam[vertex as usize] => of_vertex(vertex).len() as u32,
            _ => 1,
        };
    }
    let welded = map_indices(vertices.len(), |face| {
        [0, 1, 2].map(|k| {
            let vertex = vertices[face][k];
            let id = ids[vertex as usize];
            if !is_on_seam[vertex as usize] {
                return id;
            }
            let (key, others) = (key(mesh.uv_faces()[face][k]), &on_seams[of_vertex(vertex)]);
            id + others.partition_point(|other| other.1 < key) as u32
        })
    });
    (welded, id)
}

/// The edges with triangles on one side only. Two triangles that share an edge need not lie on
/// opposite sides of it: the halves of a folded chart, or the two faces of a doubled surface, lie
/// on the same side. So the signed UV areas decide, not the number of triangles at the edge.
fn border(mesh: &Mesh, corners: &[[u32; 3]], count: u32) -> Vec<BoundaryEdge> {
    /// Faces are searched in this many parts, and edges are compared in this many, by their lower
    /// corner: sorting them all at once would mean writing all over main memory.
    const FACES: usize = 16;
    const PARTS: usize = 64;
    let corners_per_part = (count as usize).div_ceil(PARTS).max(1);
    // For each part, its edges: the lower corner, counted from the part's first one, with the side on
    // which the triangle lies, looking along the edge from there to the higher corner; the higher
    // corner; and the edge. Edge `e` runs from corner `e` to the next of its face.
    let found = map_indices(FACES, |part| {
        let faces = corners.len() * part / FACES..corners.len() * (part + 1) / FACES;
        let few = 3 * faces.len() / PARTS * 5 / 4;
        let mut found: Vec<Vec<[u32; 3]>> = (0..PARTS).map(|_| Vec::with_capacity(few)).collect();
        for face in faces {
            let area = doubled_area(wide(mesh.uv_triangle(face)));
            // Triangles without area lie on neither side.
            if area == 0.0 {
                continue;
            }
            for k in 0..3 {
                let (from, to) = (corners[face][k], corners[face][(k + 1) % 3]);
                let (lower, higher) = (from.min(to), from.max(to));
                let side = u32::from((area > 0.0) == (from < to));
                let part = lower as usize / corners_per_part;
                let local = lower - (part * corners_per_part) as u32;
                found[part].push([2 * local + side, higher, (3 * face + k) as u32]);
            }
        }
        found
    });
    let of_part = |part: usize| {
        unpaired(found.iter().flat_map(|found| found[part].iter().copied()), corners_per_part)
    };
    let mut border: Vec<u32> = map_indices(PARTS, of_part).into_iter().flatten().collect();
    border.sort_unstable();
    let place = |edge: u32| BoundaryEdge { face: edge / 3, corner: (edge % 3) as u8 };
    border.into_iter().map(place).collect()
}

/// The edges of a part that no edge between the same corners lies opposite to.
///
/// - `edges`: as [`border`] has them.
/// - `corners`: number of lower corners of the part.
fn unpaired(edges: impl Iterator<Item = [u32; 3]> + Clone, corners: usize) -> Vec<u32> {
    let mut starts = vec![0_u32; 2 * corners + 1];
    for [side, ..] in edges.clone() {
        starts[side as usize + 1] += 1;
    }
    for side in 0..2 * corners {
        starts[side + 1] += starts[side];
    }
    let mut next = starts.clone();
    let mut sorted = vec![(0, 0); starts[2 * corners] as usize];
    for [side, higher, edge] in edges {
        let place = &mut next[side as usize];
        sorted[*place as usize] = (higher, edge);
        *place += 1;
    }
    let mut unpaired = Vec::new();
    let mut sides = [Vec::new(), Vec::new()];
    for starts in starts.windows(3).step_by(2) {
        for (side, edges) in sides.iter_mut().enumerate() {
            edges.clear();
            edges.extend_from_slice(&sorted[starts[side] as usize..starts[side + 1] as usize]);
            edges.sort_unstable();
            // Of several triangles on one side, the first stands for all.
            edges.dedup_by_key(|edge| edge.0);
        }
        for (side, other) in [(0, 1), (1, 0)] {
            let others = &sides[other];
            let alone =
                |edge: &&(u32, u32)| others.binary_search_by_key(&edge.0, |other| other.0).is_err();
            unpaired.extend(sides[side].iter().filter(alone).map(|&(_, edge)| edge));
        }
    }
    unpaired
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of two triangles that do not share UV indices, then a separate third triangle.
    fn mesh(shift: f32) -> Mesh {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let uv = vec![
            [0.0, 0.0],
            [0.4, 0.0],
            [0.4, 0.4],
            [0.0 + shift, -0.0],
            [0.4 + shift, 0.4],
            [0.0 + shift, 0.4],
            [0.6, 0.6],
            [0.9, 0.6],
            [0.9, 0.9],
        ];
        let faces = [[0, 1, 2], [0, 2, 3], [0, 1, 2]];
        Mesh::from_triangles(positions, uv, &faces, &[[0, 1, 2], [3, 4, 5], [6, 7, 8]]).unwrap()
    }

    #[test]
    fn repeated_coordinates_are_one_island() {
        let islands = Islands::new(&mesh(0.0));
        assert_eq!(islands.of_faces(), [0, 0, 1]);
        assert_eq!(islands.count(), 2);
        // The diagonal of the square is shared; the two sides of each triangle remain.
        let ends: Vec<_> =
            islands.boundary_edges().iter().map(|edge| (edge.face, edge.corner)).collect();
        assert_eq!(ends, [(0, 0), (0, 1), (1, 1), (1, 2), (2, 0), (2, 1), (2, 2)]);
    }

    #[test]
    fn a_seam_parts_islands() {
        let islands = Islands::new(&mesh(0.5));
        assert_eq!(islands.of_faces(), [0, 1, 2]);
        assert_eq!(islands.boundary_edges().len(), 9);
    }

    #[test]
    fn an_edge_with_triangles_on_one_side_is_a_border() {
        let border = |faces: &[[u32; 3]]| -> Vec<(u32, u8)> {
            let uv = vec![[0.2, 0.2], [0.8, 0.2], [0.2, 0.8], [0.8, 0.2], [0.5, 0.2], [0.8, 0.8]];
            let positions = (0..6).map(|vertex| [vertex as f32, 0.0, 0.0]).collect();
            let mesh = Mesh::from_triangles(positions, uv, faces, faces).unwrap();
            Islands::new(&mesh)
                .boundary_edges()
                .iter()
                .map(|edge| (edge.face, edge.corner))
                .collect()
        };
        let all: Vec<(u32, u8)> = vec![(0, 0), (0, 1), (0, 2)];
        assert_eq!(border(&[[0, 1, 2]]), all);
        // A doubled surface, seen from both sides.
        assert_eq!(border(&[[0, 1, 2], [2, 1, 0]]), all);
        // A triangle without area along an edge.
        assert_eq!(border(&[[0, 1, 2], [1, 0, 4]]), all);
        // The other half lies on top, as in layouts that are mirrored onto themselves.
        let folded = [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1)];
        assert_eq!(border(&[[0, 1, 2], [2, 3, 0]]), folded);
        // A true neighbour.
        assert_eq!(border(&[[0, 1, 2], [1, 5, 2]]), [(0, 0), (0, 2), (1, 0), (1, 1)]);
    }
}
