//! Edge adjacency of a mesh's triangles.
//!
//! Built on the welded points of the surface, so triangles are adjacent across UV seams even where
//! the mesh's vertices are split.

use glam::{DVec3, Vec3};

use crate::mesh::Mesh;
use crate::size::Size;
use crate::surface::Surface;

/// A directed edge of a triangle: index `3 * face + corner` runs from that corner to the next.
pub type HalfEdge = u32;

/// No half-edge.
pub const NO_HALF_EDGE: HalfEdge = u32::MAX;

/// Triangles beyond this number at one edge are not paired; a manifold mesh has two.
const MAX_AT_AN_EDGE: usize = 16;

/// Edge adjacency of a mesh: the edges that two triangles share.
#[derive(Debug)]
pub struct Edges {
    /// `[faces]`: the surface point at each corner.
    pub vertices: Vec<[u32; 3]>,
    /// Number of surface points.
    pub vertex_count: usize,
    /// Edges with a triangle on both sides, in ascending order of their first half-edge.
    pub shared: Vec<SharedEdge>,
    /// `[3 * faces]`: the opposite half-edge of each half-edge, or [`NO_HALF_EDGE`].
    pub opposite: Vec<HalfEdge>,
    /// Number of half-edges without an opposite.
    pub single: usize,
    /// Number of degenerate triangles, with the same point at two corners; they are skipped.
    pub collapsed: usize,
}

/// An edge that two triangles share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SharedEdge {
    /// The half-edge of each triangle, the lower index first.
    pub halves: [HalfEdge; 2],
    /// Whether the two run in opposite directions, as they do where the windings are consistent.
    pub opposed: bool,
}

impl SharedEdge {
    /// The same edge with its sides swapped.
    pub fn swapped(self) -> Self {
        Self { halves: [self.halves[1], self.halves[0]], ..self }
    }

    /// The point at `at`, 0 to 1 along the first half-edge, as a parameter of both half-edges.
    pub fn at(&self, at: f64) -> [(HalfEdge, f64); 2] {
        let second = if self.opposed { 1.0 - at } else { at };
        [(self.halves[0], at), (self.halves[1], second)]
    }

    /// The UV coordinates of the edge's ends on each side, in the order of the first half-edge.
    pub fn uv(&self, mesh: &Mesh) -> [[[f32; 2]; 2]; 2] {
        let [first, second] = self.halves.map(|half| {
            let corners = mesh.uv_triangle(half as usize / 3);
            [corners[half as usize % 3], corners[(half as usize % 3 + 1) % 3]]
        });
        [first, if self.opposed { [second[1], second[0]] } else { second }]
    }

    /// The positions of its ends, in the order of the first half-edge.
    pub fn positions(&self, mesh: &Mesh) -> [[f32; 3]; 2] {
        let half = self.halves[0] as usize;
        let face = mesh.faces()[half / 3];
        [face[half % 3], face[(half % 3 + 1) % 3]].map(|vertex| mesh.positions()[vertex as usize])
    }

    /// Its length, in the mesh's unit.
    pub fn length(&self, mesh: &Mesh) -> f64 {
        let [a, b] = self.positions(mesh).map(|position| Vec3::from(position).as_dvec3());
        a.distance(b)
    }

    /// Its length in texels, on the side where it is longer.
    pub fn texels(&self, mesh: &Mesh, size: Size) -> f64 {
        let length = |[a, b]: [[f32; 2]; 2]| {
            let [x, y] = [0, 1].map(|k| f64::from(b[k]) - f64::from(a[k]));
            (x * f64::from(size.width)).hypot(y * f64::from(size.height))
        };
        let [first, second] = self.uv(mesh).map(length);
        first.max(second)
    }
}

impl Edges {
    /// Finds the edges of a mesh.
    ///
    /// Where more than two triangles meet at an edge, they are paired greedily: first those
    /// that use the same two vertices, which are neighbours in the mesh itself; then those with
    /// opposite directions along the edge; then those with the flattest dihedral angle. A
    /// triangle left over has no opposite.
    pub fn new(mesh: &Mesh) -> Self {
        let surface = Surface::new(mesh);
        let (vertices, vertex_count) = (surface.triangles().to_vec(), surface.positions().len());
        let is_collapsed = |&[a, b, c]: &[u32; 3]| a == b || b == c || c == a;
        let mut keyed: Vec<(u32, u32, HalfEdge)> = Vec::with_capacity(vertices.len() * 3);
        for (face, corners) in (0u32..).zip(&vertices) {
            if !is_collapsed(corners) {
                let [a, b, c] = *corners;
                let ends = [(a, b), (b, c), (c, a)];
                let key = |(from, to): (u32, u32)| (from.min(to), from.max(to));
                let halves = (face * 3..).zip(ends.map(key));
                keyed.extend(halves.map(|(half, (low, high))| (low, high, half)));
            }
        }
        keyed.sort_unstable();
        let from = |half: HalfEdge| vertices[half as usize / 3][half as usize % 3];
        let mut opposite = vec![NO_HALF_EDGE; vertices.len() * 3];
        let mut shared = Vec::with_capacity(keyed.len() / 2);
        let mut halves = Vec::new();
        for group in keyed.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            halves.clear();
            halves.extend(group.iter().map(|&(_, _, half)| half));
            halves.truncate(MAX_AT_AN_EDGE);
            for [a, b] in pairs(mesh, &halves, from) {
                opposite[a as usize] = b;
                opposite[b as usize] = a;
                shared.push(SharedEdge { halves: [a, b], opposed: from(a) != from(b) });
            }
        }
        shared.sort_unstable_by_key(|edge| edge.halves);
        let single = keyed.len() - 2 * shared.len();
        let collapsed = vertices.iter().filter(|corners| is_collapsed(corners)).count();
        Self { vertices, vertex_count, shared, opposite, single, collapsed }
    }

    /// The surface points at the ends of a half-edge.
    pub fn ends(&self, half: HalfEdge) -> [u32; 2] {
        let corners = self.vertices[half as usize / 3];
        [corners[half as usize % 3], corners[(half as usize % 3 + 1) % 3]]
    }
}

/// Pairs the half-edges at one edge, each with at most one other.
fn pairs(mesh: &Mesh, halves: &[HalfEdge], from: impl Fn(HalfEdge) -> u32) -> Vec<[HalfEdge; 2]> {
    if let &[a, b] = halves {
        return vec![[a, b]];
    }
    let vertices = |half: HalfEdge| {
        let (face, corner) = (half as usize / 3, half as usize % 3);
        let corners = mesh.faces()[face];
        let [a, b] = [corners[corner], corners[(corner + 1) % 3]];
        (a.min(b), a.max(b))
    };
    let mut candidates = Vec::new();
    for (index, &a) in halves.iter().enumerate() {
        for &b in &halves[index + 1..] {
            let [x, y] = [a, b].map(|half| inward(mesh, half));
            let fold = x.dot(y);
            candidates.push((vertices(a) != vertices(b), from(a) == from(b), fold, [a, b]));
        }
    }
    candidates
        .sort_by(|x, y| (x.0, x.1).cmp(&(y.0, y.1)).then(x.2.total_cmp(&y.2)).then(x.3.cmp(&y.3)));
    let mut taken: Vec<HalfEdge> = Vec::new();
    let mut pairs = Vec::new();
    for (_, _, _, [a, b]) in candidates {
        if !taken.contains(&a) && !taken.contains(&b) {
            taken.extend([a, b]);
            pairs.push([a, b]);
        }
    }
    pairs
}

/// The unit vector from an edge into its triangle, normal to the edge; 0 for a degenerate triangle.
fn inward(mesh: &Mesh, half: HalfEdge) -> DVec3 {
    let (face, corner) = (half as usize / 3, half as usize % 3);
    let [a, b, c] = [0, 1, 2].map(|k| {
        let vertex = mesh.faces()[face][(corner + k) % 3];
        Vec3::from(mesh.positions()[vertex as usize]).as_dvec3()
    });
    let (edge, side) = (b - a, c - a);
    let across = side - edge * (side.dot(edge) / edge.length_squared());
    let unit = across / across.length();
    if unit.is_finite() { unit } else { DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Mesh {
        let uv = positions.iter().map(|&[x, y, _]| [x, y]).collect();
        Mesh::from_triangles(positions.to_vec(), uv, faces, faces).unwrap()
    }

    fn found(edges: &Edges) -> Vec<([HalfEdge; 2], bool)> {
        edges.shared.iter().map(|edge| (edge.halves, edge.opposed)).collect()
    }

    #[test]
    fn split_vertices_are_merged() {
        // The diagonal of a square, its ends duplicated for each half; one zero is negative.
        let positions = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [-0.0, 0.0, -0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
        ];
        let edges = Edges::new(&mesh(&positions, &[[0, 1, 2], [3, 4, 5]]));
        assert_eq!(found(&edges), [([2, 3], true)]);
        assert_eq!(edges.ends(2), [edges.vertices[0][2], edges.vertices[0][0]]);
        assert_eq!(edges.ends(3), [edges.vertices[0][0], edges.vertices[0][2]]);
        assert_eq!(edges.opposite, [NO_HALF_EDGE, NO_HALF_EDGE, 3, 2, NO_HALF_EDGE, NO_HALF_EDGE]);
        assert_eq!((edges.single, edges.collapsed, edges.vertex_count), (4, 0, 4));
        // The same with one triangle flipped.
        let edges = Edges::new(&mesh(&positions, &[[0, 1, 2], [4, 3, 5]]));
        assert_eq!(found(&edges), [([2, 3], false)]);
    }

    /// Four triangles around the edge from vertex 0 to vertex 1.
    fn crowd(outer: [[f32; 3]; 4]) -> Vec<[f32; 3]> {
        [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]].into_iter().chain(outer).collect()
    }

    #[test]
    fn the_flattest_are_paired() {
        let cross = crowd([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
        // Windings allow any two to be neighbours.
        let edges = Edges::new(&mesh(&cross, &[[0, 1, 2], [0, 1, 3], [1, 0, 4], [1, 0, 5]]));
        assert_eq!(found(&edges), [([0, 6], true), ([3, 9], true)]);
        // Three: the odd one has no opposite.
        let edges = Edges::new(&mesh(&cross, &[[0, 1, 3], [0, 1, 2], [1, 0, 4]]));
        assert_eq!(found(&edges), [([3, 6], true)]);
        assert_eq!(edges.single, 7);
    }

    #[test]
    fn shared_vertices_take_precedence() {
        // Flattest would be 0 with 2, but 0 and 1 use the same vertices, and so do 2 and 3.
        let mut positions =
            crowd([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
        positions.extend_from_within(0..2);
        let faces = [[0, 1, 2], [1, 0, 3], [7, 6, 4], [6, 7, 5]];
        let edges = Edges::new(&mesh(&positions, &faces));
        assert_eq!(found(&edges), [([0, 3], true), ([6, 9], true)]);
    }

    #[test]
    fn degenerate_triangles_are_skipped() {
        // A triangle with a repeated position lies between the other two.
        let positions =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        let edges = Edges::new(&mesh(&positions, &[[0, 1, 2], [0, 3, 1], [1, 3, 4]]));
        assert_eq!(found(&edges), [([0, 6], true)]);
        assert_eq!(edges.collapsed, 1);
    }

    #[test]
    fn thousands_of_triangles_at_one_edge_are_fast() {
        let positions = crowd([[1.0, 0.0, 0.0]; 4]);
        let edges = Edges::new(&mesh(&positions, &vec![[0, 1, 2]; 20_000]));
        assert!(edges.shared.len() <= 3 * MAX_AT_AN_EDGE / 2);
        assert_eq!(edges.single + 2 * edges.shared.len(), 60_000);
    }
}
