//! The connected parts of a body: its skin, what lies loose in it, and where its head ends.

use std::collections::HashMap;

use uvgraft::disjoint::DisjointSets;
use uvgraft::mesh::bits_of;
use uvgraft::{Mesh, Pair};

/// The connected parts of a pair's target. Vertices at the same position are one point.
pub(super) struct BodyParts<'a> {
    pub mesh: &'a Mesh,
    /// `[faces]`
    is_linked: Vec<bool>,
    /// `[vertices]`: the first vertex at the same position.
    point: Vec<u32>,
    /// The vertices of each part.
    parts: Vec<Vec<u32>>,
    /// The part with most of the linked triangles.
    skin: usize,
}

impl<'a> BodyParts<'a> {
    pub fn new(pair: &'a Pair) -> Self {
        let mesh = pair.target();
        let mut is_linked = vec![false; mesh.faces().len()];
        pair.pieces().for_each(|piece| is_linked[piece.target as usize] = true);
        let mut at_position = HashMap::new();
        let point: Vec<u32> = (0..)
            .zip(mesh.positions())
            .map(|(vertex, position)| *at_position.entry(bits_of(*position)).or_insert(vertex))
            .collect();
        let mut body = Self { mesh, is_linked, point, parts: Vec::new(), skin: 0 };
        let mut sets = body.connected(|_| true);
        let mut numbers = HashMap::new();
        let mut part_of = |sets: &mut DisjointSets, point: u32, parts: &mut Vec<Vec<u32>>| {
            let number = *numbers.entry(sets.root(point)).or_insert(parts.len());
            if number == parts.len() {
                parts.push(Vec::new());
            }
            number
        };
        let mut parts = Vec::new();
        for (vertex, &point) in (0..).zip(&body.point) {
            let number = part_of(&mut sets, point, &mut parts);
            parts[number].push(vertex);
        }
        let mut linked = vec![0_usize; parts.len()];
        for (face, _) in mesh.faces().iter().zip(&body.is_linked).filter(|(_, linked)| **linked) {
            linked[part_of(&mut sets, body.point[face[0] as usize], &mut parts)] += 1;
        }
        body.skin = (0..parts.len()).max_by_key(|&part| linked[part]).unwrap_or(0);
        body.parts = parts;
        body
    }

    /// The points that triangles of a kind connect.
    fn connected(&self, counts: impl Fn(usize) -> bool) -> DisjointSets {
        let mut sets = DisjointSets::new(self.point.len() as u32);
        for (index, face) in self.mesh.faces().iter().enumerate() {
            if counts(index) {
                let [a, b, c] = face.map(|vertex| self.point[vertex as usize]);
                sets.join(a, b);
                sets.join(a, c);
            }
        }
        sets
    }

    pub fn skin(&self) -> &[u32] {
        self.parts.get(self.skin).map_or(&[], Vec::as_slice)
    }

    /// The other parts.
    pub fn loose(&self) -> impl Iterator<Item = &Vec<u32>> {
        self.parts
            .iter()
            .enumerate()
            .filter(|(number, _)| *number != self.skin)
            .map(|(_, part)| part)
    }

    /// Vertices of the skin on edges of what is linked.
    ///
    /// - `ends`: whether the head ends at such a vertex.
    pub fn end_of_head(&self, ends: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut edges: HashMap<[u32; 2], u32> = HashMap::new();
        for (face, _) in self.mesh.faces().iter().zip(&self.is_linked).filter(|(_, is)| **is) {
            let points = face.map(|vertex| self.point[vertex as usize]);
            for k in 0..3 {
                let (a, b) = (points[k], points[(k + 1) % 3]);
                *edges.entry([a.min(b), a.max(b)]).or_insert(0) += 1;
            }
        }
        let mut on_edge = vec![false; self.point.len()];
        let outer = edges.into_iter().filter(|&(_, count)| count == 1);
        outer.for_each(|(edge, _)| edge.iter().for_each(|&point| on_edge[point as usize] = true));
        let is_end = |&vertex: &u32| on_edge[self.point[vertex as usize] as usize] && ends(vertex);
        self.skin().iter().copied().filter(is_end).collect()
    }

    /// Vertices that are connected with an end of the head by what is not linked: the body.
    pub fn beyond(&self, ends: &[u32]) -> Vec<u32> {
        let mut sets = self.connected(|face| !self.is_linked[face]);
        let mut roots: Vec<u32> =
            ends.iter().map(|&vertex| sets.root(self.point[vertex as usize])).collect();
        roots.sort_unstable();
        roots.dedup();
        let is_beyond =
            |&vertex: &u32| roots.binary_search(&sets.root(self.point[vertex as usize])).is_ok();
        self.skin().iter().copied().filter(is_beyond).collect()
    }
}
