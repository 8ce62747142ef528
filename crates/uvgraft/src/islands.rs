//! UV islands (charts) and their boundary edges.
//!
//! Two triangles belong to the same island when they share a corner: the same vertex at the same UV
//! coordinate. UV coordinates are compared by value, not by index, because many exporters repeat a
//! coordinate for every face.

use crate::disjoint::DisjointSets;
use crate::mesh::{Mesh, doubled_area};
use crate::piece::wide;

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
    let vertices = vertices.as_flattened();
    let uv_indices = mesh.uv_faces().as_flattened();
    let coordinate = |corner: u32| {
        // Adding 0.0 turns -0.0 into 0.0.
        mesh.uv()[uv_indices[corner as usize] as usize].map(|value| (value + 0.0).to_bits())
    };
    let mut welded = vec![[0; 3]; mesh.faces().len()];
    let mut id = 0;
    let by_vertex = Buckets::new(vertices, vertex_count);
    for_each_group(&by_vertex, coordinate, |corners| {
        for &(_, corner) in corners {
            welded.as_flattened_mut()[corner as usize] = id;
        }
        id += 1;
    });
    (welded, id)
}

/// The edges with triangles on one side only. Two triangles that share an edge need not lie on
/// opposite sides of it: the halves of a folded chart, or the two faces of a doubled surface, lie
/// on the same side. So the signed UV areas decide, not the number of triangles at the edge.
fn border(mesh: &Mesh, corners: &[[u32; 3]], count: u32) -> Vec<BoundaryEdge> {
    // Edge `e` runs from corner `e` to the next corner of its face.
    let ends = |edge: u32| {
        let (face, corner) = (edge as usize / 3, edge as usize % 3);
        (corners[face][corner], corners[face][(corner + 1) % 3])
    };
    // The sign says on which side of the edge its triangle lies, looking along the edge from its
    // lower to its higher corner index.
    let areas: Vec<f64> =
        (0..corners.len()).map(|face| doubled_area(wide(mesh.uv_triangle(face)))).collect();
    let side = |edge: u32| {
        let area = areas[edge as usize / 3];
        let (from, to) = ends(edge);
        if from < to { area } else { -area }
    };
    let lower = |&[a, b, c]: &[u32; 3]| [a.min(b), b.min(c), c.min(a)];
    let lower_ends: Vec<u32> = corners.iter().flat_map(lower).collect();
    let mut is_border = vec![false; lower_ends.len()];
    let by_lower_end = Buckets::new(&lower_ends, count as usize);
    for_each_group(
        &by_lower_end,
        |edge| ends(edge).0.max(ends(edge).1),
        |sharers| {
            // Triangles without area lie on neither side.
            let on = |sign: f64| sharers.iter().find(|&&(_, edge)| side(edge) * sign > 0.0);
            if let (Some(&(_, edge)), None) | (None, Some(&(_, edge))) = (on(1.0), on(-1.0)) {
                is_border[edge as usize] = true;
            }
        },
    );
    let border = is_border.into_iter().zip(0u32..).filter(|(is_border, _)| *is_border);
    border.map(|(_, edge)| BoundaryEdge { face: edge / 3, corner: (edge % 3) as u8 }).collect()
}

/// Items bucketed by a small integer key with a counting sort.
struct Buckets {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Buckets {
    /// Buckets the items `0..keys.len()`; every key must be below `count`.
    fn new(keys: &[u32], count: usize) -> Self {
        let mut starts = vec![0; count + 1];
        for &key in keys {
            starts[key as usize + 1] += 1;
        }
        for key in 0..count {
            starts[key + 1] += starts[key];
        }
        let mut next = starts.clone();
        let mut items = vec![0; keys.len()];
        for (&key, item) in keys.iter().zip(0..) {
            let place = &mut next[key as usize];
            items[*place as usize] = item;
            *place += 1;
        }
        Self { starts, items }
    }
}

/// Calls `visit` with each group of items that share a bucket and a key, in ascending item order.
fn for_each_group<K: Ord + Copy>(
    buckets: &Buckets,
    key: impl Fn(u32) -> K,
    mut visit: impl FnMut(&[(K, u32)]),
) {
    let mut bucket = Vec::new();
    for bounds in buckets.starts.windows(2) {
        bucket.clear();
        let items = &buckets.items[bounds[0] as usize..bounds[1] as usize];
        bucket.extend(items.iter().map(|&item| (key(item), item)));
        bucket.sort_unstable();
        bucket.chunk_by(|a, b| a.0 == b.0).for_each(&mut visit);
    }
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
