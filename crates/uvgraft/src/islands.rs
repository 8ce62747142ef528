//! UV islands (charts) and their edges.
//!
//! Two triangles belong to one island when they share a corner: the same vertex at the same UV
//! coordinate. Indices into the UV list are not asked, because many exporters repeat a coordinate
//! for every face.

use crate::mesh::Mesh;

/// The islands of a layout, numbered by their lowest face.
#[derive(Debug, Clone)]
pub struct Islands {
    of_face: Vec<u32>,
    first_faces: Vec<u32>,
    border: Vec<BorderEdge>,
}

/// An edge that only one triangle has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BorderEdge {
    /// The triangle.
    pub face: u32,
    /// The edge runs from this corner (0, 1 or 2) of the triangle to the next.
    pub corner: u8,
}

impl Islands {
    /// Finds the islands of a mesh's UV layout.
    pub fn new(mesh: &Mesh) -> Self {
        let corners = weld(mesh);
        let mut parent: Vec<u32> = (0..corners.len() as u32 * 3).collect();
        for &[a, b, c] in &corners {
            union(&mut parent, a, b);
            union(&mut parent, a, c);
        }
        let mut island_of_root = vec![u32::MAX; parent.len()];
        let mut first_faces = Vec::new();
        let mut of_face = Vec::with_capacity(corners.len());
        for (face, &[a, ..]) in corners.iter().enumerate() {
            let island = &mut island_of_root[find(&mut parent, a) as usize];
            if *island == u32::MAX {
                *island = first_faces.len() as u32;
                first_faces.push(face as u32);
            }
            of_face.push(*island);
        }
        Self { of_face, first_faces, border: border(&corners) }
    }

    /// How many islands there are.
    pub fn count(&self) -> usize {
        self.first_faces.len()
    }

    /// The island of each triangle.
    pub fn of_faces(&self) -> &[u32] {
        &self.of_face
    }

    /// The edges at which islands end, in the order of their triangles.
    pub fn border(&self) -> &[BorderEdge] {
        &self.border
    }
}

/// One number for each distinct pair of vertex and UV coordinate, per corner.
fn weld(mesh: &Mesh) -> Vec<[u32; 3]> {
    let key = |corner: usize| {
        let (vertex, uv) = (
            mesh.faces()[corner / 3][corner % 3],
            mesh.uv()[mesh.uv_faces()[corner / 3][corner % 3] as usize],
        );
        // Adding 0.0 makes one zero of the two.
        (vertex, uv.map(|coordinate| (coordinate + 0.0).to_bits()))
    };
    let mut order: Vec<u32> = (0..mesh.faces().len() as u32 * 3).collect();
    order.sort_unstable_by_key(|&corner| (key(corner as usize), corner));
    let mut welded = vec![[0; 3]; mesh.faces().len()];
    let mut previous = None;
    let mut id = 0;
    for &corner in &order {
        let current = key(corner as usize);
        if previous.is_some_and(|previous| previous != current) {
            id += 1;
        }
        previous = Some(current);
        welded[corner as usize / 3][corner as usize % 3] = id;
    }
    welded
}

fn border(corners: &[[u32; 3]]) -> Vec<BorderEdge> {
    let mut edges: Vec<([u32; 2], BorderEdge)> = Vec::with_capacity(corners.len() * 3);
    for (face, corner_ids) in corners.iter().enumerate() {
        for corner in 0..3u8 {
            let (a, b) = (corner_ids[corner as usize], corner_ids[(corner as usize + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], BorderEdge { face: face as u32, corner }));
        }
    }
    edges.sort_unstable_by_key(|(ends, edge)| (*ends, edge.face, edge.corner));
    let mut border: Vec<BorderEdge> = edges
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|sharers| sharers.len() == 1)
        .map(|sharers| sharers[0].1)
        .collect();
    border.sort_unstable_by_key(|edge| (edge.face, edge.corner));
    border
}

fn find(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        let grandparent = parent[parent[node as usize] as usize];
        parent[node as usize] = grandparent;
        node = grandparent;
    }
    node
}

fn union(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(parent, a), find(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles of a square on their own UV coordinates each, then a third apart.
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
        let ends: Vec<_> = islands.border().iter().map(|edge| (edge.face, edge.corner)).collect();
        assert_eq!(ends, [(0, 0), (0, 1), (1, 1), (1, 2), (2, 0), (2, 1), (2, 2)]);
    }

    #[test]
    fn a_seam_parts_islands() {
        let islands = Islands::new(&mesh(0.5));
        assert_eq!(islands.of_faces(), [0, 1, 2]);
        assert_eq!(islands.border().len(), 9);
    }
}
