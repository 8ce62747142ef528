//! Removes slivers that simplification leaves: nearly degenerate triangles, which flip as soon as
//! a morph moves one of their corners past the opposite edge. Their edges are swapped, which
//! hardly changes the rest shape.

use std::collections::HashMap;

use glam::{Vec2, Vec3};
use uvgraft_avatar::rig::Morph;

use crate::glb::shading::Shading;
use crate::glb::vertices::Vertices;

/// Smallest acceptable cosine between a triangle's normal and the mean normal of its corners.
const FACING: f32 = 0.1;

/// Maximum number of passes; one swap can make another one possible.
const ROUNDS: usize = 4;

/// Swaps edges of triangles that face the wrong way at rest or in a morph, where that helps.
///
/// A triangle's score is the cosine between its normal and the mean of its corners' smooth
/// normals, minimised over the rest shape and all morphs, since a triangle that is fine at rest
/// may flip in a morph. An edge is swapped only if the lower score of its two triangles increases,
/// so the worst triangle never gets worse.
///
/// - `shading`: normals of the original mesh, which define the correct orientation.
/// - `faces`: triangles of `vertices`, counter-clockwise seen from outside.
pub(super) fn swap_edges(
    shading: &Shading<'_>,
    morphs: &[Morph],
    vertices: &Vertices,
    faces: &mut [[u32; 3]],
) {
    let shapes = Shape::all(shading, morphs, vertices);
    let mut surface = Surface::new(faces, shapes, &vertices.uv);
    for _ in 0..ROUNDS {
        let mut has_swapped = false;
        for number in 0..surface.faces.len() {
            if surface.facing[number] >= FACING {
                continue;
            }
            if let Some(swap) = surface.best_swap(number) {
                surface.apply(&swap);
                has_swapped = true;
            }
        }
        if !has_swapped {
            break;
        }
    }
}

/// The triangle mesh being modified.
struct Surface<'a> {
    faces: &'a mut [[u32; 3]],
    shapes: Vec<Shape>,
    uv: &'a [[f32; 2]],
    /// Score of each triangle: the minimum over all shapes.
    facing: Vec<f32>,
    face_of_edge: HashMap<(u32, u32), usize>,
}

/// Two adjacent triangles, and their replacements if the shared edge is swapped.
struct Swap {
    numbers: [usize; 2],
    faces: [[u32; 3]; 2],
    facing: [f32; 2],
}

impl Swap {
    const fn least(&self) -> f32 {
        self.facing[0].min(self.facing[1])
    }
}

impl<'a> Surface<'a> {
    fn new(faces: &'a mut [[u32; 3]], shapes: Vec<Shape>, uv: &'a [[f32; 2]]) -> Self {
        let facing = faces.iter().map(|&face| facing(&shapes, face)).collect();
        let mut face_of_edge = HashMap::with_capacity(3 * faces.len());
        for (number, face) in faces.iter().enumerate() {
            face_of_edge.extend(edges(*face).map(|edge| (edge, number)));
        }
        Self { faces, shapes, uv, facing, face_of_edge }
    }

    /// The best of the swaps of a triangle's edges, if one is an improvement.
    fn best_swap(&self, number: usize) -> Option<Swap> {
        let swaps = (0..3).filter_map(|edge| self.swap(number, edge));
        swaps.max_by(|one, other| one.least().total_cmp(&other.least()))
    }

    fn swap(&self, number: usize, edge: usize) -> Option<Swap> {
        let face = self.faces[number];
        let (a, b) = edges(face)[edge];
        let &other = self.face_of_edge.get(&(b, a))?;
        let c = face[(edge + 2) % 3];
        let d = opposite(self.faces[other], a, b)?;
        let is_there = |edge| self.face_of_edge.contains_key(&edge);
        let new = [[a, d, c], [d, b, c]];
        // UV islands may be mirrored, but only as a whole.
        let mirrored = [self.faces[other], new[0], new[1]].map(|face| self.is_mirrored(face));
        let is_even = mirrored[1..].iter().all(|&one| one == mirrored[0]);
        if c == d || !is_even || is_there((c, d)) || is_there((d, c)) {
            return None;
        }
        let facing = new.map(|face| facing(&self.shapes, face));
        let swap = Swap { numbers: [number, other], faces: new, facing };
        (swap.least() > self.facing[number].min(self.facing[other])).then_some(swap)
    }

    fn is_mirrored(&self, face: [u32; 3]) -> bool {
        let [a, b, c] = face.map(|index| Vec2::from(self.uv[index as usize]));
        (b - a).perp_dot(c - a) < 0.0
    }

    fn apply(&mut self, swap: &Swap) {
        for edge in swap.numbers.map(|number| edges(self.faces[number])).as_flattened() {
            self.face_of_edge.remove(edge);
        }
        for (k, number) in swap.numbers.into_iter().enumerate() {
            (self.faces[number], self.facing[number]) = (swap.faces[k], swap.facing[k]);
            self.face_of_edge.extend(edges(swap.faces[k]).map(|edge| (edge, number)));
        }
    }
}

/// Score of a triangle: the minimum over all shapes.
fn facing(shapes: &[Shape], face: [u32; 3]) -> f32 {
    shapes.iter().map(|shape| shape.facing(face)).fold(f32::INFINITY, f32::min)
}

const fn edges([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

/// The corner of a triangle that is neither `a` nor `b`.
fn opposite(face: [u32; 3], a: u32, b: u32) -> Option<u32> {
    face.into_iter().find(|&corner| corner != a && corner != b)
}

/// Vertices of the original mesh at rest or in a morph.
struct Shape {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

impl Shape {
    fn all(shading: &Shading<'_>, morphs: &[Morph], vertices: &Vertices) -> Vec<Self> {
        let normals =
            vertices.from.iter().map(|&vertex| shading.normals[vertex as usize]).collect();
        let positions = vertices.positions.iter().map(|&position| position.into()).collect();
        let rest = Self { positions, normals };
        let morphed = |morph: &Morph| {
            let add = |values: &[Vec3], changes: &[(u32, [f32; 3])]| {
                let mut sums = values.to_vec();
                for (vertex, change) in vertices.spread(changes) {
                    sums[vertex as usize] += Vec3::from(change);
                }
                sums
            };
            Self {
                positions: add(&rest.positions, &morph.offsets),
                normals: add(&rest.normals, &shading.changes(&morph.offsets, 0.0)),
            }
        };
        let mut shapes: Vec<Self> = morphs.iter().map(morphed).collect();
        shapes.push(rest);
        shapes
    }

    /// The cosine between a triangle's normal and the mean of its corners' normals; 0 if it has no
    /// area.
    fn facing(&self, face: [u32; 3]) -> f32 {
        let [a, b, c] = face.map(|index| self.positions[index as usize]);
        let mean: Vec3 = face.iter().map(|&index| self.normals[index as usize]).sum();
        (b - a).cross(c - a).normalize_or_zero().dot(mean.normalize_or_zero())
    }
}

#[cfg(test)]
mod tests {
    use uvgraft::Mesh;

    use super::*;

    /// A square and an inner vertex very close to one of its sides.
    ///
    /// ```text
    /// 3 --- 2
    /// |     |      triangle 0 1 4 is a sliver; a morph moves 4
    /// |  4  |      below side 0 1, into triangle 0 5 1
    /// 0 --- 1
    ///    5
    /// ```
    fn square() -> Mesh {
        let positions = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.5, 0.001, 0.0],
            [0.5, -1.0, 0.0],
        ];
        let uv = positions.iter().map(|&[x, y, _]| [x * 0.5, y * 0.4 + 0.5]).collect();
        let faces = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [0, 5, 1]];
        Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
    }

    fn swapped(offset: [f32; 3]) -> (Vec<[u32; 3]>, Vec<[u32; 3]>) {
        let mesh = square();
        let shading = Shading::new(&mesh);
        let vertices = Vertices::new(&mesh, &shading, crate::glb::vertices::Inputs::default());
        let before: Vec<[u32; 3]> = vertices.indices.as_chunks().0.to_vec();
        let mut faces = before.clone();
        let morph = Morph { name: "down".to_owned(), offsets: vec![(4, offset)] };
        swap_edges(&shading, &[morph], &vertices, &mut faces);
        let named = |faces: Vec<[u32; 3]>| {
            faces.iter().map(|face| face.map(|index| vertices.from[index as usize])).collect()
        };
        (named(before), named(faces))
    }

    #[test]
    fn slivers_that_turn_over_are_swapped() {
        let (before, after) = swapped([0.0, -0.1, 0.0]);
        assert_ne!(before, after);
        let has = |a, b| after.iter().flat_map(|&face| edges(face)).any(|edge| edge == (a, b));
        assert!(has(5, 4) && has(4, 5) && !has(0, 1) && !has(1, 0), "{after:?}");
        assert_eq!(before.len(), after.len());
        for face in after {
            let [a, b, c] = face.map(|vertex| {
                let position = Vec3::from(square().positions()[vertex as usize]);
                if vertex == 4 { position - 0.1 * Vec3::Y } else { position }
            });
            assert!((b - a).cross(c - a).z > 0.0, "{face:?}");
        }
    }

    #[test]
    fn slivers_that_stay_are_left_alone() {
        let (before, after) = swapped([0.0, 0.1, 0.0]);
        assert_eq!(before, after);
    }
}
