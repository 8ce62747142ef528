//! The loop of edges where a head ends behind its lips.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap, HashMap, HashSet};

use uvgraft::{Anatomy, Area, Mesh};

use super::MouthError;
use super::frame::Frame;
use crate::eyes::eyeball::pieces;

/// Minimum weight for vertices inside a mouth sack, see [`Area::MouthInterior`].
const INSIDE: f32 = 0.5;

/// Minimum and maximum width of a mouth, in millimetres of [`Frame`].
const WIDTHS_MM: [f32; 2] = [20.0, 90.0];

/// Maximum distance of a loop's centre above or below the line between the lips, and behind it.
const OFF_MM: f32 = 20.0;
const BEHIND_MM: f32 = 50.0;

/// The rim of the opening, from the person's right corner of the mouth along the upper lip to the
/// left corner and back along the lower lip.
#[derive(Debug, Clone)]
pub(super) struct Rim {
    /// Vertices of the mesh, in the direction of the adjacent triangles.
    pub vertices: Vec<u32>,
    /// Number of steps to the left corner.
    pub upper: usize,
    /// The triangles of the mesh to be removed: those of a sack behind the lips.
    pub is_sack: Vec<bool>,
}

impl Rim {
    /// Finds the loop. If there is none, makes one by removing the sack behind the lips, which is
    /// flat while they are closed and has no room for teeth.
    ///
    /// # Errors
    /// [`MouthError::OwnMouth`] or [`MouthError::Closed`].
    pub fn find(mesh: &Mesh, anatomy: &Anatomy, frame: &Frame) -> Result<Self, MouthError> {
        let interior = anatomy.area(Area::MouthInterior);
        let own = own_pieces(mesh, interior);
        if own > 0 {
            return Err(MouthError::OwnMouth { pieces: own });
        }
        let mut is_sack = vec![false; mesh.faces().len()];
        let mut found = mouth_loop(mesh, &is_sack, frame);
        if found.is_none() {
            let inside = |vertex: &u32| interior[*vertex as usize] >= INSIDE;
            // Polygon by polygon, because halves of quads would leave a jagged rim.
            for polygon in (0..mesh.polygon_count()).map(|polygon| mesh.polygon(polygon)) {
                let is_inside = mesh.faces()[polygon.clone()].as_flattened().iter().all(inside);
                is_sack[polygon].fill(is_inside);
            }
            found = mouth_loop(mesh, &is_sack, frame);
        }
        let mut vertices = found.ok_or(MouthError::Closed)?;
        let x = |vertex: &u32| frame.local(mesh.positions()[*vertex as usize]).x;
        let extreme = |sign: f32| {
            let key = |index: &usize| sign * x(&vertices[*index]);
            (0..vertices.len()).min_by(|a, b| key(a).total_cmp(&key(b))).unwrap_or(0)
        };
        let (right, left) = (extreme(1.0), extreme(-1.0));
        let upper = (left + vertices.len() - right) % vertices.len();
        vertices.rotate_left(right);
        Ok(Self { vertices, upper, is_sack })
    }
}

impl Rim {
    /// Height of the line where the lips meet in the middle, in the frame's coordinates. Landmarks
    /// are accurate to some millimetres only; this is halfway between the lowest vertex of the
    /// upper lip and the highest one of the lower lip.
    pub fn line(&self, mesh: &Mesh, frame: &Frame) -> f32 {
        const LIPS_MM: f32 = 36.0;
        const MIDDLE_MM: f32 = 7.0;
        const TALL_MM: f32 = 10.0;
        let local = |vertex: u32| frame.local(mesh.positions()[vertex as usize]);
        let count = self.vertices.len();
        // The corners belong to both lips.
        let distances = |from: &[u32]| distances(mesh, frame, from, LIPS_MM);
        let upper = distances(&self.vertices[1..self.upper.max(1)]);
        let lower = distances(&self.vertices[(self.upper + 1).min(count)..]);
        let (mut lowest, mut highest) = (f32::INFINITY, f32::NEG_INFINITY);
        for (vertex, of_upper) in &upper {
            let Some(of_lower) = lower.get(vertex) else { continue };
            let point = local(*vertex);
            if point.x.abs() > MIDDLE_MM || point.y.abs() > TALL_MM {
                continue;
            }
            if of_upper < of_lower {
                lowest = lowest.min(point.y);
            } else if of_lower < of_upper {
                highest = highest.max(point.y);
            }
        }
        let line = 0.5 * (lowest + highest);
        if line.is_finite() { line } else { 0.0 }
    }
}

/// Distances of nearby vertices from the nearest of some vertices along edges (Dijkstra), in
/// micrometres of the frame; integers, so that they can be keys of the heap.
fn distances(mesh: &Mesh, frame: &Frame, from: &[u32], reach_mm: f32) -> HashMap<u32, u32> {
    let local = |vertex: u32| frame.local(mesh.positions()[vertex as usize]);
    let mut neighbours: HashMap<u32, Vec<(u32, u32)>> = HashMap::new();
    for &[a, b, c] in mesh.faces() {
        for (one, other) in [(a, b), (b, c), (c, a)] {
            let ends = [local(one), local(other)];
            if ends.iter().all(|end| end.length() < reach_mm) {
                let length = (1000.0 * ends[0].distance(ends[1])) as u32;
                neighbours.entry(one).or_default().push((other, length));
                neighbours.entry(other).or_default().push((one, length));
            }
        }
    }
    let mut found: HashMap<u32, u32> = HashMap::new();
    let mut queue: BinaryHeap<Reverse<(u32, u32)>> =
        from.iter().map(|&v| Reverse((0, v))).collect();
    while let Some(Reverse((distance, vertex))) = queue.pop() {
        if found.contains_key(&vertex) {
            continue;
        }
        found.insert(vertex, distance);
        for &(other, length) in neighbours.get(&vertex).into_iter().flatten() {
            if !found.contains_key(&other) {
                queue.push(Reverse((distance + length, other)));
            }
        }
    }
    found
}

/// Number of connected components that lie entirely inside the mouth.
fn own_pieces(mesh: &Mesh, interior: &[f32]) -> usize {
    let pieces = pieces(mesh);
    let used: HashSet<u32> = mesh.faces().as_flattened().iter().copied().collect();
    let (mut inside, mut outside) = (BTreeSet::new(), HashSet::new());
    for vertex in used {
        let piece = pieces[vertex as usize];
        if interior[vertex as usize] >= INSIDE {
            inside.insert(piece);
        } else {
            outside.insert(piece);
        }
    }
    inside.into_iter().filter(|piece| !outside.contains(piece)).count()
}

/// The longest boundary loop at the position of a mouth.
fn mouth_loop(mesh: &Mesh, left_out: &[bool], frame: &Frame) -> Option<Vec<u32>> {
    let is_mouth = |vertices: &Vec<u32>| {
        let points = vertices.iter().map(|&v| frame.local(mesh.positions()[v as usize]));
        let (mut least, mut most) = (glam::Vec3::INFINITY, glam::Vec3::NEG_INFINITY);
        for point in points {
            (least, most) = (least.min(point), most.max(point));
        }
        let (center, width) = ((least + most) / 2.0, (most - least).x);
        (WIDTHS_MM[0]..WIDTHS_MM[1]).contains(&width)
            && center.x.abs() < 0.2 * width
            && center.y.abs() < OFF_MM
            && (-BEHIND_MM..5.0).contains(&center.z)
    };
    loops(mesh, left_out).into_iter().filter(is_mouth).max_by_key(Vec::len)
}

/// The boundary loops of a mesh, in the direction of its triangles.
fn loops(mesh: &Mesh, left_out: &[bool]) -> Vec<Vec<u32>> {
    let kept = mesh.faces().iter().zip(left_out).filter(|(_, left_out)| !**left_out);
    let edges: HashSet<(u32, u32)> =
        kept.flat_map(|(&[a, b, c], _)| [(a, b), (b, c), (c, a)]).collect();
    let mut next: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for &(from, to) in edges.iter().filter(|(from, to)| !edges.contains(&(*to, *from))) {
        next.entry(from).or_default().insert(to);
    }
    let mut loops = Vec::new();
    while let Some((&first, _)) = next.first_key_value() {
        let (mut found, mut at) = (vec![first], first);
        while let Some(ends) = next.get_mut(&at) {
            let Some(to) = ends.pop_first() else { break };
            if ends.is_empty() {
                next.remove(&at);
            }
            // Where loops touch, each part that closes becomes a separate loop.
            if let Some(start) = found.iter().position(|&vertex| vertex == to) {
                loops.push(found.split_off(start));
                found.push(to);
            } else {
                found.push(to);
            }
            at = to;
        }
    }
    loops
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_follow_the_triangles_and_split_where_they_touch() {
        // The boundary loops of two triangles that share only a vertex are separate.
        let positions = vec![[0.0; 3]; 5];
        let faces = [[0, 1, 2], [2, 3, 4]];
        let mesh = Mesh::from_triangles(positions, vec![[0.0; 2]; 5], &faces, &faces).unwrap();
        let mut found = loops(&mesh, &[false; 2]);
        found.iter_mut().for_each(|found| {
            let lowest = (0..found.len()).min_by_key(|&k| found[k]).unwrap();
            found.rotate_left(lowest);
        });
        found.sort();
        assert_eq!(found, [vec![0, 1, 2], vec![2, 3, 4]]);
        assert_eq!(loops(&mesh, &[true, false]), [vec![2, 3, 4]]);
    }
}
