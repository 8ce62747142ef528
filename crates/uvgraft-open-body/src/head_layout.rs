//! A UV layout of the head alone, which gives the face room.
//!
//! In MakeHuman's layout the head is one island with its seam at the back, nearly without
//! distortion of angles, but the face takes 3 % of the texture. Here this island fills the texture,
//! magnified most in the middle of the face: by a function of each axis that grows everywhere, so
//! that no triangle flips and nothing overlaps. Inner mouth, eyelids' backs, eyes, teeth, tongue
//! and lashes lie in a strip below.

use glam::Vec2;
use uvgraft::Mesh;

use crate::islands::{Island, islands};
use crate::t_pose::Weights;

/// Joints of the neck and head.
const HEAD_JOINTS: [usize; 5] = [12, 15, 22, 23, 24];
/// Margin around the layout, and between islands.
const MARGIN: f32 = 0.01;
/// Height of the strip of small islands, from the bottom.
const STRIP: f32 = 0.14;
/// Magnification of the middle: the steepness of the arc tangent across and down.
const ACROSS: f32 = 2.5;
const DOWN: f32 = 2.0;
/// The middle of the face, from the top of the island to its bottom.
const MIDDLE: f32 = 0.68;
/// Least side of a small island's box, so that none becomes a dot.
const LEAST: f32 = 0.02;

/// The head as a mesh of its own.
pub(crate) struct HeadLayout {
    /// The body's vertices that it has, ascending.
    pub(crate) vertices: Vec<u32>,
    /// Triangles, as indices into `vertices`, in the body's order.
    pub(crate) faces: Vec<[u32; 3]>,
    /// Texture coordinates, with the origin at the bottom left.
    pub(crate) uv: Vec<[f32; 2]>,
    /// Triangles, as indices into `uv`.
    pub(crate) uv_faces: Vec<[u32; 3]>,
}

impl HeadLayout {
    /// - `mesh`: the body in MakeHuman's layout.
    pub(crate) fn new(mesh: &Mesh, weights: &Weights) -> Self {
        let islands = islands_of_head(mesh, weights);
        let mut uv: Vec<Vec2> = mesh.uv().iter().map(|&[u, v]| Vec2::new(u, 1.0 - v)).collect();
        let largest = islands.iter().max_by_key(|island| island.faces.len());
        let mut small: Vec<&Island> = Vec::new();
        for island in &islands {
            if largest.is_some_and(|largest| std::ptr::eq(largest, island)) {
                magnify(&mut uv, island);
            } else {
                small.push(island);
            }
        }
        pack(&mut uv, &small);
        let mut body_faces: Vec<u32> =
            islands.iter().flat_map(|island| island.faces.iter().copied()).collect();
        body_faces.sort_unstable();
        let pick = |all: &[[u32; 3]]| -> Vec<[u32; 3]> {
            body_faces.iter().map(|&face| all[face as usize]).collect()
        };
        let (vertices, faces) = compact(&pick(mesh.faces()));
        let (coordinates, uv_faces) = compact(&pick(mesh.uv_faces()));
        let uv = coordinates.iter().map(|&at| uv[at as usize].into()).collect();
        Self { vertices, faces, uv, uv_faces }
    }
}

/// The islands that follow the head or neck for the most part.
fn islands_of_head(mesh: &Mesh, weights: &Weights) -> Vec<Island> {
    let share = |&face: &u32| -> f32 {
        let vertex = mesh.faces()[face as usize][0];
        let own = weights[vertex as usize].iter();
        own.filter(|(joint, _)| HEAD_JOINTS.contains(joint)).map(|(_, weight)| weight).sum()
    };
    let is_of_head = |island: &Island| {
        island.faces.iter().map(share).sum::<f32>() > 0.5 * island.faces.len() as f32
    };
    islands(mesh).into_iter().filter(is_of_head).collect()
}

/// Turns the head's island upright, and spreads it over the texture above the strip.
fn magnify(uv: &mut [Vec2], island: &Island) {
    let [low, high] = island.bounds(uv);
    let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
    let down = |t: f32| (DOWN * (t - MIDDLE)).atan();
    for &at in &island.coordinates {
        let place = &mut uv[at as usize];
        // The top of the head is at the left of MakeHuman's layout.
        let across = (place.y - middle.y) / half.y;
        let depth = (place.x - low.x) / (2.0 * half.x);
        let x = 0.5 + (0.5 - MARGIN) * (ACROSS * across).atan() / ACROSS.atan();
        let share = (down(depth) - down(0.0)) / (down(1.0) - down(0.0));
        let top = 1.0 - MARGIN;
        *place = Vec2::new(x, top - (top - STRIP) * share);
    }
}

/// Places islands side by side in the strip, with equal scale, from the widest to the narrowest.
fn pack(uv: &mut [Vec2], islands: &[&Island]) {
    let boxes: Vec<[Vec2; 2]> = islands.iter().map(|island| island.bounds(uv)).collect();
    let mut order: Vec<usize> = (0..islands.len()).collect();
    let height = |at: usize| (boxes[at][1] - boxes[at][0]).y;
    order.sort_by(|&a, &b| height(b).total_cmp(&height(a)).then(a.cmp(&b)));
    // The largest scale at which they fit in columns, found by halving.
    let (mut low, mut high) = (0.0, 16.0);
    for _ in 0..24 {
        let scale = f32::midpoint(low, high);
        *(if columns(&boxes, &order, scale).is_some() { &mut low } else { &mut high }) = scale;
    }
    for (at, corner) in columns(&boxes, &order, low).unwrap_or_default() {
        let [from, to] = boxes[at];
        islands[at].place(uv, corner, scale_of(to - from, low));
    }
}

/// Small islands are enlarged more.
fn scale_of(size: Vec2, scale: f32) -> f32 {
    scale.max(LEAST / size.max_element().max(f32::MIN_POSITIVE))
}

/// The lower left corners of boxes, filled into columns from left to right; `None` if they take
/// more than the strip.
fn columns(boxes: &[[Vec2; 2]], order: &[usize], scale: f32) -> Option<Vec<(usize, Vec2)>> {
    let room = STRIP - 2.0 * MARGIN;
    let (mut left, mut width, mut bottom) = (MARGIN, 0.0_f32, MARGIN);
    let mut places = Vec::new();
    for &at in order {
        let size = boxes[at][1] - boxes[at][0];
        let size = size * scale_of(size, scale);
        if size.y > room {
            return None;
        }
        if bottom + size.y > MARGIN + room {
            left += width + MARGIN;
            (width, bottom) = (0.0, MARGIN);
        }
        places.push((at, Vec2::new(left, bottom)));
        bottom += size.y + MARGIN;
        width = width.max(size.x);
    }
    (left + width <= 1.0 - MARGIN).then_some(places)
}

/// Replaces indices by their ranks, and returns the indices in ascending order.
fn compact(faces: &[[u32; 3]]) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut used: Vec<u32> = faces.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let rank = |index: u32| used.partition_point(|&other| other < index) as u32;
    let faces = faces.iter().map(|corners| corners.map(rank)).collect();
    (used, faces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joints;

    /// Grids of quads in MakeHuman's layout: a large one and two small ones of the head, and one of
    /// the trunk.
    fn body() -> (Mesh, Weights) {
        let (mut places, mut uv) = (Vec::new(), Vec::new());
        let (mut faces, mut weights): (Vec<[u32; 3]>, Weights) = Default::default();
        for (low, size, count, joint) in [
            ([0.6, 0.2], [0.35, 0.6], 12, joints::PELVIS + 15),
            ([0.1, 0.1], [0.1, 0.05], 3, 22),
            ([0.3, 0.1], [0.002, 0.002], 2, 23),
            ([0.1, 0.3], [0.4, 0.6], 20, 3),
        ] {
            let first = uv.len() as u32;
            for row in 0..=count {
                for column in 0..=count {
                    let share = [column, row].map(|at| at as f32 / count as f32);
                    let [u, v] = [0, 1].map(|axis| low[axis] + size[axis] * share[axis]);
                    places.push([u, v, 0.0]);
                    uv.push([u, 1.0 - v]);
                    weights.push(vec![(joint, 1.0)]);
                }
            }
            for cell in 0..count * count {
                let at = first + (cell / count * (count + 1) + cell % count) as u32;
                let up = at + count as u32 + 1;
                faces.extend([[at, at + 1, up + 1], [at, up + 1, up]]);
            }
        }
        (Mesh::from_triangles(places, uv, &faces, &faces).unwrap(), weights)
    }

    #[test]
    fn the_head_fills_the_texture_and_nothing_flips() {
        let (mesh, weights) = body();
        let head = HeadLayout::new(&mesh, &weights);
        assert_eq!(head.faces.len(), 2 * (144 + 9 + 4));
        assert_eq!(head.faces[..2], mesh.faces()[..2]);
        let area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|at| Vec2::from(head.uv[at as usize]));
            (b - a).perp_dot(c - a) / 2.0
        };
        assert!(head.uv_faces.iter().all(|corners| area(corners) > 0.0));
        assert!(head.uv.iter().flatten().all(|value| (0.0..=1.0).contains(value)));
        let (large, small) = head.uv_faces.split_at(288);
        let lowest = |faces: &[[u32; 3]], axis: usize| {
            faces.iter().flatten().map(|&at| head.uv[at as usize][axis]).fold(1.0, f32::min)
        };
        assert!((lowest(large, 1) - STRIP).abs() < 1e-5);
        let highest = small.iter().flatten().map(|&at| head.uv[at as usize][1]);
        assert!(highest.fold(0.0, f32::max) <= STRIP - MARGIN + 1e-5);
        // Below the middle, where the face is, triangles are larger.
        assert!(area(&large[2 * (12 * 6 + 8)]) > 2.0 * area(&large[2]));
    }
}
