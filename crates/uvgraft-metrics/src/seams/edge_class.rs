//! Classification of edges, and their lengths.

use glam::Vec3;
use uvgraft::edges::{Edges, SharedEdge};
use uvgraft::mesh::Mesh;
use uvgraft::texture::Texture;

use super::walk::HalfKind;

/// Maximum number of points along an edge: a thousand characterise it well enough.
const MAX_POINTS: f64 = 1024.0;

/// The class of an edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct EdgeClass {
    pub is_uv_seam: bool,
    pub is_rim: bool,
    /// Whether both triangles belong to the region.
    pub is_inside: bool,
}

impl EdgeClass {
    pub fn of(mesh: &Mesh, edge: &SharedEdge, inside: &[bool]) -> Self {
        let [[a, b], [c, d]] = edge.uv(mesh);
        let [first, second] = edge.halves.map(|half| inside[half as usize / 3]);
        Self { is_uv_seam: a != c || b != d, is_rim: first != second, is_inside: first && second }
    }
}

/// Number of points at which an edge is measured.
pub(super) fn point_count(edge: &SharedEdge, mesh: &Mesh, texture: &Texture) -> usize {
    edge.texels(mesh, texture.size()).round().clamp(1.0, MAX_POINTS) as usize
}

pub(super) fn distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    Vec3::from(a).as_dvec3().distance(Vec3::from(b).as_dvec3())
}

/// The class of each half-edge.
pub(super) fn kinds_by_half(edges: &Edges, kinds: &[EdgeClass]) -> Vec<HalfKind> {
    let mut by_half = vec![HalfKind::default(); edges.opposite.len()];
    for (edge, kind) in edges.shared.iter().zip(kinds) {
        for half in edge.halves {
            by_half[half as usize] = HalfKind { is_uv_seam: kind.is_uv_seam, is_rim: kind.is_rim };
        }
    }
    by_half
}
