//! How many triangles of a polygon's fan are triangles of another mesh, for each apex.

use std::collections::HashMap;

use super::twins;

/// A triangle by its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Keyed {
    /// Its points, ascending.
    pub points: [u32; 3],
    /// Whether its corners are an odd permutation of them.
    pub is_odd: bool,
    pub face: u32,
}

impl Keyed {
    pub fn new(mut points: [u32; 3], face: u32) -> Self {
        let is_odd = twins::is_odd(points);
        points.sort_unstable();
        Self { points, is_odd, face }
    }
}

/// Triangles that are among others, and of these those that wind alike.
pub(super) type Matches = (usize, usize);

/// Whether a triangle is among others, and whether it winds alike.
fn matches(others: &[Keyed], corners: [u32; 3], is_turned: bool) -> Matches {
    let Keyed { points, is_odd, .. } = Keyed::new(corners, 0);
    let is_among = |is_odd: bool| {
        let order = |other: &Keyed| (other.points, other.is_odd).cmp(&(points, is_odd));
        others.binary_search_by(order).is_ok()
    };
    let is_alike = is_among(is_odd != is_turned);
    (usize::from(is_alike || is_among(is_odd == is_turned)), usize::from(is_alike))
}

/// The matches for each apex, triangle by triangle.
///
/// - `ring`: the points of a polygon's corners.
/// - `others`: sorted.
/// - `is_turned`: whether the other mesh is inside out, compared with the polygon's.
pub(super) fn matches_by_triangle(ring: &[u32], others: &[Keyed], is_turned: bool) -> Vec<Matches> {
    let of_apex = |apex: usize| {
        let at = |k: usize| ring[(apex + k) % ring.len()];
        let triangles = (1..ring.len() - 1).map(|k| [at(0), at(k), at(k + 1)]);
        triangles.fold((0, 0), |(found, alike), corners| {
            let (is_among, is_alike) = matches(others, corners, is_turned);
            (found + is_among, alike + is_alike)
        })
    };
    (0..ring.len()).map(of_apex).collect()
}

/// Triangles by their edges.
pub(super) struct AtEdges<'a> {
    others: &'a [Keyed],
    /// The lower and the higher point of an edge, and the third point of a triangle there; sorted, each
    /// once.
    thirds: Vec<[u32; 3]>,
}

impl<'a> AtEdges<'a> {
    /// - `others`: sorted.
    pub fn new(others: &'a [Keyed]) -> Self {
        let edges = |&Keyed { points: [a, b, c], .. }: &Keyed| [[a, b, c], [a, c, b], [b, c, a]];
        let mut thirds: Vec<[u32; 3]> = others.iter().flat_map(edges).collect();
        thirds.sort_unstable();
        thirds.dedup();
        Self { others, thirds }
    }

    /// As [`matches_by_triangle`], from the triangles at each edge of the polygon: most polygons have two
    /// there, whatever the number of their corners.
    pub fn matches(&self, ring: &[u32], is_turned: bool) -> Vec<Matches> {
        let edge = |k: usize| [ring[k], ring[(k + 1) % ring.len()]];
        // Directed edges that repeat are looked at once.
        let mut edges: Vec<[u32; 2]> = (0..ring.len()).map(edge).collect();
        edges.sort_unstable();
        let mut at_point: HashMap<u32, Matches> =
            ring.iter().map(|&point| (point, (0, 0))).collect();
        for same in edges.chunk_by(PartialEq::eq) {
            let [from, to] = same[0];
            let count = |third: u32, (found, alike): &mut Matches| {
                let (is_among, is_alike) = matches(self.others, [third, from, to], is_turned);
                *found += same.len() * is_among;
                *alike += same.len() * is_alike;
            };
            let key = [from.min(to), from.max(to)];
            let start = self.thirds.partition_point(|third| third[..2] < key[..]);
            let len = self.thirds[start..].partition_point(|third| third[..2] == key[..]);
            if len > at_point.len() {
                at_point.iter_mut().for_each(|(&third, matches)| count(third, matches));
                continue;
            }
            for &[.., third] in &self.thirds[start..start + len] {
                if let Some(matches) = at_point.get_mut(&third) {
                    count(third, matches);
                }
            }
        }
        // All edges but the two at an apex are opposite to it.
        let of_apex = |apex: usize| {
            let (mut found, mut alike) = at_point[&ring[apex]];
            for [from, to] in [edge((apex + ring.len() - 1) % ring.len()), edge(apex)] {
                let (is_among, is_alike) = matches(self.others, [ring[apex], from, to], is_turned);
                found -= is_among;
                alike -= is_alike;
            }
            (found, alike)
        };
        (0..ring.len()).map(of_apex).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_find_what_triangles_one_by_one_do() {
        let mut rng = fastrand::Rng::with_seed(4);
        for round in 0..300 {
            // Few points, so that rings touch themselves and triangles repeat.
            let points = 4 + round % 40;
            let ring: Vec<u32> = (0..3 + round % 60).map(|_| rng.u32(..points)).collect();
            let triangle = |rng: &mut fastrand::Rng| [(); 3].map(|()| rng.u32(..points));
            let mut others: Vec<Keyed> =
                (0..round * 3).map(|face| Keyed::new(triangle(&mut rng), face)).collect();
            others.sort_unstable();
            for is_turned in [false, true] {
                let found = AtEdges::new(&others).matches(&ring, is_turned);
                assert_eq!(found, matches_by_triangle(&ring, &others, is_turned), "{round}");
            }
        }
    }

    #[test]
    fn a_polygon_of_a_hundred_thousand_corners_finds_its_apex() {
        let ring: Vec<u32> = (0..100_000).collect();
        let apex = 70_001;
        let at = |k: usize| ring[(apex + k) % ring.len()];
        let mut others: Vec<Keyed> =
            (1..ring.len() - 1).map(|k| Keyed::new([at(0), at(k), at(k + 1)], k as u32)).collect();
        others.sort_unstable();
        let found = AtEdges::new(&others).matches(&ring, false);
        assert_eq!(found[apex], (ring.len() - 2, ring.len() - 2));
        assert_eq!(found.iter().filter(|found| found.0 > 1).count(), 1);
    }
}
