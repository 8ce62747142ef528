//! What kind of edge an edge is, and how long.

use super::walk::HalfKind;
use crate::edges::{Edges, Half, Shared};
use crate::mesh::Mesh;
use crate::texture::Texture;

/// Along an edge there are no more points than this: a thousand are enough to know it by.
const MOST_POINTS: f64 = 1024.0;

/// What an edge is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kind {
    pub is_uv_seam: bool,
    pub is_rim: bool,
    /// Whether both triangles belong to the region.
    pub is_inside: bool,
}

impl Kind {
    pub fn of(mesh: &Mesh, edge: &Shared, inside: &[bool]) -> Self {
        let [[a, b], [c, d]] = edge.uv(mesh);
        let [first, second] = edge.halves.map(|half| inside[half as usize / 3]);
        Self { is_uv_seam: a != c || b != d, is_rim: first != second, is_inside: first && second }
    }
}

impl Shared {
    /// The same edge with its sides changed.
    pub fn turned(self) -> Self {
        Self { halves: [self.halves[1], self.halves[0]], ..self }
    }

    /// A place along it, on each of its triangles' edges.
    pub fn places(&self, at: f64) -> [(Half, f64); 2] {
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

    pub fn length(&self, mesh: &Mesh) -> f64 {
        let [a, b] = self.positions(mesh);
        distance(a, b)
    }

    /// Its length in texels, on the side that has more of them.
    pub fn texels(&self, mesh: &Mesh, texture: &Texture) -> f64 {
        let size = texture.size();
        let length = |[a, b]: [[f32; 2]; 2]| {
            let [x, y] = [0, 1].map(|k| f64::from(b[k]) - f64::from(a[k]));
            (x * f64::from(size.width)).hypot(y * f64::from(size.height))
        };
        let [first, second] = self.uv(mesh).map(length);
        first.max(second)
    }

    /// How many points are measured along it.
    pub fn points(&self, mesh: &Mesh, texture: &Texture) -> usize {
        self.texels(mesh, texture).round().clamp(1.0, MOST_POINTS) as usize
    }
}

pub(super) fn distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| f64::from(b[k]) - f64::from(a[k]));
    (x * x + y * y + z * z).sqrt()
}

/// What each triangle's edge is.
pub(super) fn kinds_by_half(edges: &Edges, kinds: &[Kind]) -> Vec<HalfKind> {
    let mut by_half = vec![HalfKind::default(); edges.opposite.len()];
    for (edge, kind) in edges.shared.iter().zip(kinds) {
        for half in edge.halves {
            by_half[half as usize] = HalfKind { is_uv_seam: kind.is_uv_seam, is_rim: kind.is_rim };
        }
    }
    by_half
}
