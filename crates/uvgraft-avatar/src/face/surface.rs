//! The mesh of a head in head coordinates: ray casting, distances along the surface,
//! points fixed to it.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use glam::Vec3;
use uvgraft::Mesh;
use uvgraft::anatomy::HeadFrame;
use uvgraft::disjoint::DisjointSets;
use uvgraft::mesh::bits_of;

use crate::ray::{TriangleHit, intersect};

/// Limit of the head around the point between the eyes, in distances between the eyes.
const REACH: f32 = 3.0;

/// A point fixed to the surface, or a mean of several: vertices with weights that sum to 1.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spot(Vec<(u32, f32)>);

impl Spot {
    /// The weighted mean of vertices; `None` if all weights are 0.
    pub(super) fn mean(weights: impl IntoIterator<Item = (u32, f32)>) -> Option<Self> {
        let mut parts: Vec<(u32, f32)> =
            weights.into_iter().filter(|&(_, weight)| weight > 0.0).collect();
        let sum: f32 = parts.iter().map(|&(_, weight)| weight).sum();
        parts.iter_mut().for_each(|(_, weight)| *weight /= sum);
        (sum > 0.0).then_some(Self(parts))
    }

    pub(super) fn parts(&self) -> &[(u32, f32)] {
        &self.0
    }

    /// Its position, or its offset: the weighted mean of values at the vertices.
    pub(super) fn of(&self, values: &[[f32; 3]]) -> Vec3 {
        self.0.iter().map(|&(vertex, part)| Vec3::from(values[vertex as usize]) * part).sum()
    }
}

/// An intersection of a ray with the surface.
#[derive(Debug, Clone)]
pub(super) struct Hit {
    pub distance: f32,
    pub triangle: [u32; 3],
    pub weights: [f32; 3],
}

impl Hit {
    pub(super) fn spot(&self) -> Spot {
        Spot(self.triangle.into_iter().zip(self.weights).collect())
    }

    /// The corner with the largest weight.
    pub(super) fn vertex(&self) -> u32 {
        let best = (0..3).max_by(|&a, &b| self.weights[a].total_cmp(&self.weights[b]));
        self.triangle[best.unwrap_or(0)]
    }
}

/// A head's mesh in head coordinates: origin between the eyes, x to the person's left, y up, z
/// forward, and the distance between the eyes as the unit.
#[derive(Debug)]
pub(super) struct Surface {
    pub positions: Vec<Vec3>,
    /// Those of the head.
    pub triangles: Vec<[u32; 3]>,
    /// For each vertex its connected component; triangles and equal positions connect vertices.
    pub piece: Vec<u32>,
    /// Adjacent vertices, including those at the same position.
    neighbours: Vec<Vec<u32>>,
}

impl Surface {
    pub(super) fn new(mesh: &Mesh, frame: &HeadFrame) -> Self {
        let local = |place: &[f32; 3]| {
            Vec3::from(frame.local(place.map(f64::from)).map(|value| value as f32))
        };
        let positions: Vec<Vec3> = mesh.positions().iter().map(local).collect();
        let is_near = |triangle: &&[u32; 3]| {
            triangle.iter().all(|&vertex| positions[vertex as usize].length() < REACH)
        };
        let triangles: Vec<[u32; 3]> = mesh.faces().iter().filter(is_near).copied().collect();
        let mut sets = DisjointSets::new(positions.len() as u32);
        let mut neighbours = vec![Vec::new(); positions.len()];
        let mut known = HashMap::new();
        let mut join = |a: u32, b: u32| {
            if a != b {
                neighbours[a as usize].push(b);
                neighbours[b as usize].push(a);
            }
            sets.join(a, b);
        };
        for (vertex, place) in (0..).zip(mesh.positions()) {
            join(*known.entry(bits_of(*place)).or_insert(vertex), vertex);
        }
        for &[a, b, c] in &triangles {
            [(a, b), (b, c), (c, a)].into_iter().for_each(|(a, b)| join(a, b));
        }
        let piece = (0..positions.len() as u32).map(|vertex| sets.root(vertex)).collect();
        Self { positions, triangles, piece, neighbours }
    }

    /// The triangles that may reach into a ball, for rays that stay within it.
    pub(super) fn within(&self, center: Vec3, radius: f32) -> Vec<[u32; 3]> {
        let reaches = |triangle: &&[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| self.positions[vertex as usize]);
            let middle = (a + b + c) / 3.0;
            let size = middle.distance(a).max(middle.distance(b)).max(middle.distance(c));
            middle.distance(center) < radius + size
        };
        self.triangles.iter().filter(reaches).copied().collect()
    }

    /// Intersections of a ray with some triangles, nearest first.
    pub(super) fn hits(&self, origin: Vec3, direction: Vec3, triangles: &[[u32; 3]]) -> Vec<Hit> {
        let hit = |triangle: &[u32; 3]| {
            let corners = triangle.map(|vertex| self.positions[vertex as usize]);
            let TriangleHit { distance, weights } = intersect(origin, direction, &corners)?;
            Some(Hit { distance, triangle: *triangle, weights })
        };
        let mut hits: Vec<Hit> = triangles.iter().filter_map(hit).collect();
        hits.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        hits
    }

    /// The vertex of a component that is nearest to a point.
    pub(super) fn nearest(&self, place: Vec3, piece: u32) -> Option<u32> {
        let own = (0..self.positions.len()).filter(|&vertex| self.piece[vertex] == piece);
        let from = |vertex: usize| self.positions[vertex].distance_squared(place);
        own.min_by(|&a, &b| from(a).total_cmp(&from(b))).map(|vertex| vertex as u32)
    }

    /// Distances of all vertices from one of them along edges (Dijkstra); infinite for vertices
    /// that are not connected to it, or farther away than the head's limit.
    pub(super) fn distances(&self, from: u32) -> Vec<f32> {
        let mut distances = vec![f32::INFINITY; self.positions.len()];
        distances[from as usize] = 0.0;
        // The bits of positive floats have the same order as the floats.
        let mut queue = BinaryHeap::from([Reverse((0_u32, from))]);
        while let Some(Reverse((bits, vertex))) = queue.pop() {
            let distance = f32::from_bits(bits);
            if distance > distances[vertex as usize] {
                continue;
            }
            for &next in &self.neighbours[vertex as usize] {
                let (a, b) = (self.positions[vertex as usize], self.positions[next as usize]);
                let found = distance + a.distance(b);
                if found < distances[next as usize] && found < REACH {
                    distances[next as usize] = found;
                    queue.push(Reverse((found.to_bits(), next)));
                }
            }
        }
        distances
    }
}
