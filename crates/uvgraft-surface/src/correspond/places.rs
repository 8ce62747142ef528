//! Vertices at the same place, such as copies at UV seams.

use std::collections::HashMap;

use crate::mesh::{Mesh, bits_of};

/// For each vertex the first one at the same place.
pub(super) fn first_at_place(mesh: &Mesh) -> Vec<u32> {
    let mut known = HashMap::new();
    let vertices = mesh.positions().iter().map(|&position| bits_of(position)).zip(0_u32..);
    vertices.map(|(place, vertex)| *known.entry(place).or_insert(vertex)).collect()
}

/// The number of places, and each vertex's place in the order of their first vertices.
pub(super) fn places(first_at_place: &[u32]) -> (usize, Vec<u32>) {
    let mut count = 0;
    let mut numbers: Vec<u32> = Vec::with_capacity(first_at_place.len());
    for (vertex, &first) in first_at_place.iter().enumerate() {
        if first as usize == vertex {
            numbers.push(count);
            count += 1;
        } else {
            numbers.push(numbers[first as usize]);
        }
    }
    (count as usize, numbers)
}

/// Number of different places of a mesh's vertices.
pub(super) fn place_count(mesh: &Mesh) -> usize {
    places(&first_at_place(mesh)).0
}
