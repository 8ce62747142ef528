//! Distinguishes the lips by distance along the surface.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::Vec3;
use uvgraft::Mesh;
use uvgraft::anatomy::{Anatomy, Landmark};

/// For each vertex, from 1 at the base of the nose through 0, where the chin is equally near along
/// edges, to -1 at the chin. Lips that touch are far apart along the surface, so the sign
/// distinguishes them.
pub(super) fn upper(mesh: &Mesh, anatomy: &Anatomy) -> Vec<f32> {
    let positions: Vec<Vec3> = mesh.positions().iter().map(|&place| place.into()).collect();
    let mut neighbours = vec![Vec::new(); positions.len()];
    for &[a, b, c] in mesh.faces() {
        for (from, to) in [(a, b), (b, c), (c, a), (b, a), (c, b), (a, c)] {
            neighbours[from as usize].push(to as usize);
        }
    }
    let [nose, chin] = [Landmark::NoseBase, Landmark::Chin].map(|landmark| {
        let place = anatomy.point(landmark).expect("a template with a whole face");
        distances(&positions, &neighbours, Vec3::from(place.map(|value| value as f32)))
    });
    let side = |(nose, chin): (f32, f32)| {
        let both = nose + chin;
        if both.is_finite() { (chin - nose) / both } else { 0.0 }
    };
    nose.into_iter().zip(chin).map(side).collect()
}

/// Distances along edges from the vertex nearest to a point (Dijkstra).
fn distances(positions: &[Vec3], neighbours: &[Vec<usize>], from: Vec3) -> Vec<f32> {
    let nearer = |&a: &usize, &b: &usize| {
        positions[a].distance_squared(from).total_cmp(&positions[b].distance_squared(from))
    };
    let start = (0..positions.len()).min_by(nearer).expect("a vertex");
    let mut distances = vec![f32::INFINITY; positions.len()];
    distances[start] = 0.0;
    // Non-negative floats sort like their bit patterns.
    let mut queue = BinaryHeap::from([Reverse((0_u32, start))]);
    while let Some(Reverse((bits, vertex))) = queue.pop() {
        for &next in &neighbours[vertex] {
            let found = f32::from_bits(bits) + positions[vertex].distance(positions[next]);
            if found < distances[next] {
                distances[next] = found;
                queue.push(Reverse((found.to_bits(), next)));
            }
        }
    }
    distances
}
