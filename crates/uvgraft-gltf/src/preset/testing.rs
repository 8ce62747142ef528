//! Mesh measurements for tests.

use std::collections::HashMap;

use uvgraft::Mesh;

/// Boundary of a surface.
#[derive(Debug, PartialEq)]
pub(crate) struct Borders {
    /// Edges with a single triangle.
    pub edges: usize,
    /// Connected components of these edges.
    pub loops: usize,
    /// Total length of these edges.
    pub length: f32,
}

/// The boundary edges of a surface; vertices at the same position are merged.
pub(crate) fn borders(mesh: &Mesh) -> Borders {
    let mut points = HashMap::new();
    let mut point = |vertex: u32| {
        let next = points.len();
        *points.entry(mesh.positions()[vertex as usize].map(f32::to_bits)).or_insert(next)
    };
    let mut uses: HashMap<(usize, usize), (usize, f32)> = HashMap::new();
    for face in mesh.faces() {
        for k in 0..3 {
            let (from, to) = (face[k], face[(k + 1) % 3]);
            let place = |vertex: u32| glam::Vec3::from(mesh.positions()[vertex as usize]);
            let length = place(from).distance(place(to));
            let (a, b) = (point(from), point(to));
            uses.entry((a.min(b), a.max(b))).or_insert((0, length)).0 += 1;
        }
    }
    let open: Vec<_> = uses.into_iter().filter(|(_, (count, _))| *count == 1).collect();
    let mut parents: Vec<usize> = (0..points.len()).collect();
    let root = |parents: &[usize], mut point: usize| {
        while parents[point] != point {
            point = parents[point];
        }
        point
    };
    for &((a, b), _) in &open {
        let (a, b) = (root(&parents, a), root(&parents, b));
        parents[a] = b;
    }
    let mut loops: Vec<usize> = open.iter().map(|&((a, _), _)| root(&parents, a)).collect();
    loops.sort_unstable();
    loops.dedup();
    let length = open.iter().map(|(_, (_, length))| length).sum();
    Borders { edges: open.len(), loops: loops.len(), length }
}
