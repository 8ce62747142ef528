//! One side of sheets that have polygons on both, which a net has no place for.

use std::collections::{HashMap, VecDeque};

use glam::DVec3;

/// Of rings with the same points only one, such that neighbours wind alike.
///
/// Which side of a whole sheet is taken follows from where it faces, so that it is the same in another
/// version of the mesh.
pub(super) fn one_side(rings: Vec<Vec<u32>>, positions: &[DVec3]) -> Vec<Vec<u32>> {
    let groups = groups(&rings);
    if groups.len() == rings.len() {
        return rings;
    }
    let mut sides = Sides::new(&rings, &groups);
    // What has one side only decides for what is connected with it.
    let mut starts: Vec<usize> = (0..groups.len()).collect();
    starts.sort_by_key(|&group| groups[group].len() > 1);
    for start in starts {
        let part = sides.spread_from(start);
        if part.iter().all(|&group| groups[group].len() > 1) {
            sides.turn_up(&part, positions);
        }
    }
    let mut is_kept = vec![false; rings.len()];
    sides.chosen.iter().flatten().for_each(|&ring| is_kept[ring] = true);
    let kept = rings.into_iter().zip(is_kept).filter(|(_, is_kept)| *is_kept);
    kept.map(|(ring, _)| ring).collect()
}

/// The rings with the same points, in the order of their first ones.
fn groups(rings: &[Vec<u32>]) -> Vec<Vec<usize>> {
    let sorted = |(index, ring): (usize, &Vec<u32>)| {
        let mut points = ring.clone();
        points.sort_unstable();
        (points, index)
    };
    let mut by_points: Vec<(Vec<u32>, usize)> = rings.iter().enumerate().map(sorted).collect();
    by_points.sort_unstable();
    let mut groups: Vec<Vec<usize>> = by_points
        .chunk_by(|(one, _), (other, _)| one == other)
        .map(|group| group.iter().map(|&(_, index)| index).collect())
        .collect();
    groups.sort_unstable_by_key(|group| group[0]);
    groups
}

/// The ring that is taken of each group.
struct Sides<'a> {
    rings: &'a [Vec<u32>],
    groups: &'a [Vec<usize>],
    /// The groups at each edge, whose lower point comes first.
    at_edge: HashMap<[u32; 2], Vec<usize>>,
    chosen: Vec<Option<usize>>,
}

impl<'a> Sides<'a> {
    fn new(rings: &'a [Vec<u32>], groups: &'a [Vec<usize>]) -> Self {
        let mut at_edge: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
        for (index, group) in groups.iter().enumerate() {
            for edge in edges(&rings[group[0]]) {
                at_edge.entry(undirected(edge)).or_default().push(index);
            }
        }
        Self { rings, groups, at_edge, chosen: vec![None; groups.len()] }
    }

    /// Chooses for a group and all that are connected with it; returns these, or nothing if that has
    /// been done.
    fn spread_from(&mut self, start: usize) -> Vec<usize> {
        if self.chosen[start].is_some() {
            return Vec::new();
        }
        self.chosen[start] = Some(self.groups[start][0]);
        let (mut part, mut queue) = (vec![start], VecDeque::from([start]));
        while let Some(group) = queue.pop_front() {
            for [from, to] in edges(self.ring(group)) {
                for &next in &self.at_edge[&undirected([from, to])] {
                    if self.chosen[next].is_none() {
                        // Neighbours that wind alike go along the edge between them in opposite directions.
                        let alike = self.going_along(next, [to, from]);
                        self.chosen[next] = Some(alike.unwrap_or(self.groups[next][0]));
                        part.push(next);
                        queue.push_back(next);
                    }
                }
            }
        }
        part
    }

    /// The first ring of a group with a directed edge.
    fn going_along(&self, group: usize, edge: [u32; 2]) -> Option<usize> {
        let goes_along = |&&ring: &&usize| edges(&self.rings[ring]).any(|other| other == edge);
        self.groups[group].iter().find(goes_along).copied()
    }

    /// Takes the other side of a part that faces down, in a direction that no sheet is likely to lie in.
    fn turn_up(&mut self, part: &[usize], positions: &[DVec3]) {
        const UP: DVec3 = DVec3::new(0.31, 0.87, 0.53);
        let facing: DVec3 = part.iter().map(|&group| area(self.ring(group), positions)).sum();
        if facing.dot(UP) >= 0.0 {
            return;
        }
        for &group in part {
            let [from, to] = [self.ring(group)[0], self.ring(group)[1]];
            if let Some(other) = self.going_along(group, [to, from]) {
                self.chosen[group] = Some(other);
            }
        }
    }

    /// The ring that is taken of a group, or would be.
    fn ring(&self, group: usize) -> &'a [u32] {
        &self.rings[self.chosen[group].unwrap_or(self.groups[group][0])]
    }
}

fn edges(ring: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    (0..ring.len()).map(|k| [ring[k], ring[(k + 1) % ring.len()]])
}

fn undirected([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// A vector along the normal of a ring, as long as twice its area.
fn area(ring: &[u32], positions: &[DVec3]) -> DVec3 {
    edges(ring)
        .map(|edge| edge.map(|point| positions[point as usize]))
        .map(|[a, b]| a.cross(b))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rings of a strip of `n` quads in the plane, from above.
    fn strip(n: u32) -> (Vec<Vec<u32>>, Vec<DVec3>) {
        let rings = (0..n).map(|k| vec![2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2]).collect();
        let place = |k: u32| DVec3::new(f64::from(k / 2), 0.0, f64::from(k % 2));
        (rings, (0..2 * n + 2).map(place).collect())
    }

    fn turned(ring: &[u32]) -> Vec<u32> {
        ring.iter().rev().copied().collect()
    }

    #[test]
    fn the_same_side_is_taken_in_any_order() {
        let (above, positions) = strip(9);
        let mut both: Vec<Vec<u32>> =
            above.iter().cloned().chain(above.iter().map(|ring| turned(ring))).collect();
        for seed in 0..20 {
            fastrand::Rng::with_seed(seed).shuffle(&mut both);
            let mut found = one_side(both.clone(), &positions);
            found.sort();
            assert_eq!(found, above, "{seed}");
        }
        assert_eq!(one_side(above.clone(), &positions), above);
    }

    #[test]
    fn what_has_one_side_decides() {
        let (above, positions) = strip(5);
        let below: Vec<Vec<u32>> = above.iter().map(|ring| turned(ring)).collect();
        // The last quad is there from below alone.
        let rings: Vec<Vec<u32>> = above[..4].iter().chain(&below).cloned().collect();
        assert_eq!(one_side(rings, &positions), below);
    }
}
