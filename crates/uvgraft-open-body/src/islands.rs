//! The islands of a UV layout: triangles that are connected in it.

use std::collections::BTreeMap;

use glam::Vec2;
use uvgraft::Mesh;
use uvgraft::disjoint::DisjointSets;

/// Triangles that are connected in the layout.
#[derive(Default)]
pub(crate) struct Island {
    pub(crate) faces: Vec<u32>,
    /// Indices of texture coordinates, ascending.
    pub(crate) coordinates: Vec<u32>,
}

impl Island {
    /// The corners of its box with the lowest and the highest coordinates.
    pub(crate) fn bounds(&self, uv: &[Vec2]) -> [Vec2; 2] {
        let places = || self.coordinates.iter().map(|&at| uv[at as usize]);
        [places().fold(Vec2::MAX, Vec2::min), places().fold(Vec2::MIN, Vec2::max)]
    }

    /// Moves and scales its box.
    pub(crate) fn place(&self, uv: &mut [Vec2], corner: Vec2, scale: f32) {
        let [low, _] = self.bounds(uv);
        for &at in &self.coordinates {
            let place = &mut uv[at as usize];
            *place = corner + (*place - low) * scale;
        }
    }
}

/// The islands of a mesh, by their lowest coordinate index.
pub(crate) fn islands(mesh: &Mesh) -> Vec<Island> {
    let mut sets = DisjointSets::new(mesh.uv().len() as u32);
    for &[a, b, c] in mesh.uv_faces() {
        sets.join(a, b);
        sets.join(a, c);
    }
    let mut islands: BTreeMap<u32, Island> = BTreeMap::new();
    for (face, corners) in (0..).zip(mesh.uv_faces()) {
        let island = islands.entry(sets.root(corners[0])).or_default();
        island.faces.push(face);
        island.coordinates.extend(corners);
    }
    let sorted = |mut island: Island| {
        island.coordinates.sort_unstable();
        island.coordinates.dedup();
        island
    };
    islands.into_values().map(sorted).collect()
}
