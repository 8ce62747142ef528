//! The mesh as distinct points, welded by position, with connected components and normals.

use glam::{DVec3, Vec3};

use super::AnatomyError;
use crate::directions::direction;
use crate::disjoint::DisjointSets;
use crate::mesh::{Mesh, bits_of};

/// With fewer points or triangles, no face can be detected. Origin not recorded.
pub(super) const MIN_POINTS: usize = 120;

/// Distinct positions of a mesh and the triangles between them.
pub(super) struct Points {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals, weighted by area; zero where the triangles' normals cancel.
    pub normals: Vec<DVec3>,
    /// The connected component of each point.
    pub component: Vec<u32>,
    pub component_count: usize,
    of_vertex: Vec<u32>,
    /// The lowest and highest corner of the bounding box.
    pub bounds: [DVec3; 2],
}

impl Points {
    pub fn new(mesh: &Mesh) -> Result<Self, AnatomyError> {
        let (of_vertex, mut positions) = weld(mesh);
        let used = mesh.faces().iter().map(|face| face.map(|vertex| of_vertex[vertex as usize]));
        let triangles: Vec<[u32; 3]> =
            used.filter(|&[a, b, c]| a != b && b != c && c != a).collect();
        let too_coarse = |found| Err(AnatomyError::TooCoarse { found, needed: MIN_POINTS });
        if positions.len() < MIN_POINTS || triangles.len() < MIN_POINTS {
            return too_coarse(positions.len().min(triangles.len()));
        }
        let (component, component_count) = components(positions.len(), &triangles);
        let bounds = bounds(&positions, &triangles);
        let diagonal = bounds[1].distance(bounds[0]);
        if !(diagonal.is_normal() && diagonal < 1e30) {
            return too_coarse(1);
        }
        // Reject meshes of extreme size that are so far from the origin that little precision is
        // left.
        let center = bounds[0].midpoint(bounds[1]);
        let is_extreme = !(1e-6..1e9).contains(&diagonal);
        if is_extreme && center.length() > 1e6 * diagonal {
            return too_coarse(1);
        }
        positions.shrink_to_fit();
        let normals = normals(&positions, &triangles);
        Ok(Self { positions, triangles, normals, component, component_count, of_vertex, bounds })
    }

    pub fn diagonal(&self) -> f64 {
        self.bounds[1].distance(self.bounds[0])
    }

    /// Expands values of points to values of the mesh's vertices.
    pub fn to_vertices(&self, values: &[f32]) -> Vec<f32> {
        self.of_vertex.iter().map(|&point| values[point as usize]).collect()
    }

    /// The connected component of a vertex of the mesh.
    pub fn component_of(&self, vertex: u32) -> u32 {
        self.component[self.of_vertex[vertex as usize] as usize]
    }

    pub fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|point| self.positions[point as usize])
    }
}

/// Merges vertices with the same position: returns the point of each vertex, and the points'
/// positions. Uses a hash table with linear probing, keyed by the bits of the coordinates.
fn weld(mesh: &Mesh) -> (Vec<u32>, Vec<DVec3>) {
    const EMPTY: u32 = u32::MAX;
    let vertices = mesh.positions();
    let mask = (2 * vertices.len()).next_power_of_two().max(2) - 1;
    let mut table = vec![EMPTY; mask + 1];
    let mut first_vertex: Vec<u32> = Vec::with_capacity(vertices.len());
    let mut of_vertex = Vec::with_capacity(vertices.len());
    let key = |vertex: usize| bits_of(vertices[vertex]);
    for vertex in 0..vertices.len() {
        let bits = key(vertex);
        let hash = bits.iter().fold(0u64, |hash, &bits| {
            (hash ^ u64::from(bits)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
        });
        let mut slot = hash as usize & mask;
        while table[slot] != EMPTY && key(first_vertex[table[slot] as usize] as usize) != bits {
            slot = (slot + 1) & mask;
        }
        if table[slot] == EMPTY {
            table[slot] = first_vertex.len() as u32;
            first_vertex.push(vertex as u32);
        }
        of_vertex.push(table[slot]);
    }
    let position = |&vertex: &u32| Vec3::from(vertices[vertex as usize]).as_dvec3();
    (of_vertex, first_vertex.iter().map(position).collect())
}

/// The component of each point, numbered from 0 by first point, and the number of components.
fn components(count: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, usize) {
    let mut sets = DisjointSets::new(count as u32);
    for &[a, b, c] in triangles {
        sets.join(a, b);
        sets.join(a, c);
    }
    let mut number = vec![u32::MAX; count];
    let mut next = 0;
    let component = (0..count as u32).map(|point| {
        let number = &mut number[sets.root(point) as usize];
        if *number == u32::MAX {
            *number = next;
            next += 1;
        }
        *number
    });
    (component.collect(), next as usize)
}

pub(super) fn bounds(positions: &[DVec3], triangles: &[[u32; 3]]) -> [DVec3; 2] {
    let corners = triangles.as_flattened().iter().map(|&point| positions[point as usize]);
    corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], corner| {
        [low.min(corner), high.max(corner)]
    })
}

fn normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|point| positions[point as usize]);
        let normal = (b - a).cross(c - a);
        for &point in triangle {
            normals[point as usize] += normal;
        }
    }
    normals.into_iter().map(|normal| direction(normal).unwrap_or_default()).collect()
}
