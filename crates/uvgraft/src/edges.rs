//! Which triangles meet at which edges of the surface.
//!
//! Vertices count as one where they are one point of the surface, so meshes whose vertices are split
//! at UV seams are whole again.

use glam::{DVec3, Vec3};

use crate::mesh::Mesh;
use crate::surface::Surface;
use crate::texture::Size;

/// A triangle's edge: number `3 * face + corner` runs from that corner to the next.
pub type HalfEdge = u32;

/// No edge.
pub const NONE: HalfEdge = u32::MAX;

/// More triangles than this at one edge are not paired; a sound mesh has two.
const MOST_AT_AN_EDGE: usize = 16;

/// The edges of a mesh that two triangles share.
#[derive(Debug)]
pub struct Edges {
    /// `[faces]` for each corner, which point of the surface it is.
    pub vertices: Vec<[u32; 3]>,
    /// How many points there are.
    pub vertex_count: usize,
    /// Edges with a triangle on both sides, in the order of their first triangle's edge.
    pub shared: Vec<SharedEdge>,
    /// `[3 * faces]` for each triangle's edge the one on its other side, or [`NONE`].
    pub opposite: Vec<HalfEdge>,
    /// Edges of triangles without a triangle on the other side.
    pub single: usize,
    /// Triangles that have one point at two corners; they are passed over.
    pub collapsed: usize,
}

/// An edge that two triangles share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SharedEdge {
    /// The edge in each of them, the lower one first.
    pub halves: [HalfEdge; 2],
    /// Whether the two run along it in opposite directions, as they do where both wind alike.
    pub opposed: bool,
}

impl SharedEdge {
    /// The same edge with its sides changed.
    pub fn turned(self) -> Self {
        Self { halves: [self.halves[1], self.halves[0]], ..self }
    }

    /// A place along it, on each of its triangles' edges.
    pub fn places(&self, at: f64) -> [(HalfEdge, f64); 2] {
        let second = if self.opposed { 1.0 - at } else { at };
        [(self.halves[0], at), (self.halves[1], second)]
    }

    /// On each side, the UV coordinates of the edge's ends, in the order of its first triangle.
    pub fn uv(&self, mesh: &Mesh) -> [[[f32; 2]; 2]; 2] {
        let [first, second] = self.halves.map(|half| {
            let corners = mesh.uv_triangle(half as usize / 3);
            [corners[half as usize % 3], corners[(half as usize % 3 + 1) % 3]]
        });
        [first, if self.opposed { [second[1], second[0]] } else { second }]
    }

    /// The positions of its ends, in the order of its first triangle.
    pub fn positions(&self, mesh: &Mesh) -> [[f32; 3]; 2] {
        let half = self.halves[0] as usize;
        let face = mesh.faces()[half / 3];
        [face[half % 3], face[(half % 3 + 1) % 3]].map(|vertex| mesh.positions()[vertex as usize])
    }

    /// Its length, in the unit of the mesh.
    pub fn length(&self, mesh: &Mesh) -> f64 {
        let [a, b] = self.positions(mesh).map(|position| Vec3::from(position).as_dvec3());
        a.distance(b)
    }

    /// Its length in texels, on the side that has more of them.
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
    /// Where more than two triangles meet at an edge, those are paired first that name the same two
    /// vertices, which the mesh itself thus says to be neighbours; then those that run along the edge
    /// in opposite directions; then those that lie flattest to each other. A triangle that is left
    /// over has nothing on its other side.
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
        let mut opposite = vec![NONE; vertices.len() * 3];
        let mut shared = Vec::with_capacity(keyed.len() / 2);
        let mut crowd = Vec::new();
        for group in keyed.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            crowd.clear();
            crowd.extend(group.iter().map(|&(_, _, half)| half));
            crowd.truncate(MOST_AT_AN_EDGE);
            for [a, b] in pairs(mesh, &crowd, from) {
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

    /// The two ends of a triangle's edge.
    pub fn ends(&self, half: HalfEdge) -> [u32; 2] {
        let corners = self.vertices[half as usize / 3];
        [corners[half as usize % 3], corners[(half as usize % 3 + 1) % 3]]
    }
}

/// Pairs the triangles that meet at one edge, each with one other at most.
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
            let [x, y] = [a, b].map(|half| away(mesh, half));
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

/// The direction from an edge into its triangle, of length 1; 0 for a triangle without area.
fn away(mesh: &Mesh, half: HalfEdge) -> DVec3 {
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
    fn split_vertices_are_one() {
        // The diagonal of a square, its ends repeated for each half; one zero is negative.
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
        assert_eq!(edges.opposite, [NONE, NONE, 3, 2, NONE, NONE]);
        assert_eq!((edges.single, edges.collapsed, edges.vertex_count), (4, 0, 4));
        // The same, one of them turned over.
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
        // All wind so that any two could be neighbours.
        let edges = Edges::new(&mesh(&cross, &[[0, 1, 2], [0, 1, 3], [1, 0, 4], [1, 0, 5]]));
        assert_eq!(found(&edges), [([0, 6], true), ([3, 9], true)]);
        // Three: the odd one has nothing on its other side.
        let edges = Edges::new(&mesh(&cross, &[[0, 1, 3], [0, 1, 2], [1, 0, 4]]));
        assert_eq!(found(&edges), [([3, 6], true)]);
        assert_eq!(edges.single, 7);
    }

    #[test]
    fn what_the_mesh_says_comes_first() {
        // Flattest would be 0 with 2; but 0 and 1 name the same vertices, and so do 2 and 3.
        let mut positions =
            crowd([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
        positions.extend_from_within(0..2);
        let faces = [[0, 1, 2], [1, 0, 3], [7, 6, 4], [6, 7, 5]];
        let edges = Edges::new(&mesh(&positions, &faces));
        assert_eq!(found(&edges), [([0, 3], true), ([6, 9], true)]);
    }

    #[test]
    fn collapsed_triangles_are_passed_over() {
        // Between two triangles lies one that has the same position twice.
        let positions =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        let edges = Edges::new(&mesh(&positions, &[[0, 1, 2], [0, 3, 1], [1, 3, 4]]));
        assert_eq!(found(&edges), [([0, 6], true)]);
        assert_eq!(edges.collapsed, 1);
    }

    #[test]
    fn thousands_of_triangles_at_one_edge_take_no_time() {
        let positions = crowd([[1.0, 0.0, 0.0]; 4]);
        let edges = Edges::new(&mesh(&positions, &vec![[0, 1, 2]; 20_000]));
        assert!(edges.shared.len() <= 3 * MOST_AT_AN_EDGE / 2);
        assert_eq!(edges.single + 2 * edges.shared.len(), 60_000);
    }
}
