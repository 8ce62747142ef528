//! Which lip a vertex is of. Lips touch, so height alone does not tell.

use std::collections::{HashMap, HashSet, VecDeque};

use glam::Vec3;
use uvgraft::Mesh;
use uvgraft::anatomy::{Anatomy, Landmark};

/// A template's lips.
pub(super) struct Lips {
    /// For each vertex of the lips whether it is the lower one's; nothing for others.
    pub is_lower: Vec<Option<bool>>,
    /// Where the lips meet in the middle, in the head's coordinates.
    pub middle: Vec3,
}

impl Lips {
    /// From the loop at which templates end behind the lips: vertices around it, by whether fewer edges lead to
    /// its upper or to its lower half.
    pub fn find(mesh: &Mesh, anatomy: &Anatomy) -> Self {
        /// How far around the middle of the mouth lips reach, and how far up and down.
        const NEAR: f32 = 0.45;
        const TALL: f32 = 0.17;
        let frame = anatomy.frame();
        let place = |vertex: u32| {
            let local = frame.local(mesh.positions()[vertex as usize].map(f64::from));
            Vec3::from(local.map(|value| value as f32))
        };
        let mouth = anatomy.point(Landmark::Mouth).expect("a template with a mouth");
        let mouth = Vec3::from(frame.local(mouth).map(|value| value as f32));
        let rim = rim(mesh, |vertex| place(vertex).distance(mouth) < 0.8);
        let corner = |sign: f32| {
            let x = |at: &usize| sign * place(rim[*at]).x;
            (0..rim.len()).min_by(|a, b| x(a).total_cmp(&x(b))).expect("a loop")
        };
        let (right, left) = (corner(1.0), corner(-1.0));
        let steps = (left + rim.len() - right) % rim.len();
        let along = |from: usize, to: usize| -> Vec<u32> {
            (from..to).map(|step| rim[(right + step) % rim.len()]).collect()
        };
        let (upper, lower) = (along(1, steps), along(steps + 1, rim.len()));
        let near = |vertex: u32| {
            let off = place(vertex) - mouth;
            off.length() < NEAR && off.y.abs() < TALL
        };
        let (to_upper, to_lower) = (edges(mesh, &upper, near), edges(mesh, &lower, near));
        let is_lower: Vec<Option<bool>> = (0..mesh.positions().len() as u32)
            .map(|vertex| match (to_upper.get(&vertex), to_lower.get(&vertex)) {
                (None, None) => None,
                (Some(_), None) => Some(false),
                (None, Some(_)) => Some(true),
                (Some(upper), Some(lower)) => Some(lower < upper),
            })
            .collect();
        let heights = |wanted: bool| {
            let is_its = move |vertex: &u32, is: Option<bool>, place: Vec3| {
                is == Some(wanted) && place.x.abs() < 0.1 && near(*vertex)
            };
            let all = (0..).zip(&is_lower).map(|(vertex, &is)| (vertex, is, place(vertex)));
            all.filter(move |(vertex, is, place)| is_its(vertex, *is, *place))
                .map(|entry| entry.2.y)
        };
        let y = 0.5
            * (heights(false).fold(f32::MAX, f32::min) + heights(true).fold(f32::MIN, f32::max));
        Self { is_lower, middle: Vec3::new(0.0, y, mouth.z) }
    }
}

/// The loop of edges with triangles on one side, among vertices near the mouth, along its triangles: over the
/// upper lip from the person's right to the left.
fn rim(mesh: &Mesh, near: impl Fn(u32) -> bool) -> Vec<u32> {
    let edges: HashSet<(u32, u32)> =
        mesh.faces().iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
    let open = edges.iter().filter(|(a, b)| !edges.contains(&(*b, *a)) && near(*a) && near(*b));
    let next: HashMap<u32, u32> = open.copied().collect();
    let first = *next.keys().min().expect("a template that is open behind its lips");
    let mut rim = vec![first];
    while let Some(&to) = next.get(&rim[rim.len() - 1]).filter(|&&to| to != first) {
        rim.push(to);
    }
    rim
}

/// How many edges lead from some vertices to each that is near.
fn edges(mesh: &Mesh, from: &[u32], near: impl Fn(u32) -> bool) -> HashMap<u32, u32> {
    let mut beside: HashMap<u32, Vec<u32>> = HashMap::new();
    for &[a, b, c] in mesh.faces() {
        for (one, other) in [(a, b), (b, c), (c, a)] {
            beside.entry(one).or_default().push(other);
            beside.entry(other).or_default().push(one);
        }
    }
    let mut found: HashMap<u32, u32> = from.iter().map(|&vertex| (vertex, 0)).collect();
    let mut queue: VecDeque<u32> = from.iter().copied().collect();
    while let Some(vertex) = queue.pop_front() {
        let steps = found[&vertex] + 1;
        for &other in &beside[&vertex] {
            if near(other) && !found.contains_key(&other) {
                found.insert(other, steps);
                queue.push_back(other);
            }
        }
    }
    found
}
