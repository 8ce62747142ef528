//! Which of several triangles at the same three points corresponds to which.
//!
//! Hair cards, leaves and cloth have a triangle for each side, with UV coordinates of its own. What
//! tells them apart is the way they wind, then their UV coordinates, then their order.

use std::collections::BTreeMap;
use std::iter::Peekable;

use crate::mesh::{Mesh, bits_of};

/// One of several triangles at the same points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Twin {
    face: u32,
    /// Whether it winds as the odd permutations of its points do.
    is_odd: bool,
    /// The bits of its UV coordinates, in the order of its points.
    uv: [[u32; 2]; 3],
}

impl Twin {
    /// - `points`: of the face's corners.
    /// - `is_turned`: whether the mesh is inside out, compared with the other.
    pub fn new(mesh: &Mesh, face: u32, points: [u32; 3], is_turned: bool) -> Self {
        let uv = mesh.uv_triangle(face as usize).map(bits_of);
        let mut order = [0, 1, 2];
        order.sort_by_key(|&corner| points[corner]);
        Self { face, is_odd: is_odd(points) != is_turned, uv: order.map(|corner| uv[corner]) }
    }
}

/// Whether the corners of a triangle are an odd permutation of its points in ascending order.
pub(super) fn is_odd([a, b, c]: [u32; 3]) -> bool {
    (a > b) ^ (b > c) ^ (a > c)
}

/// Pairs of source and target faces among twins: each face is in at least one, and those of the side
/// that has fewer share what is left of the other.
///
/// - `sources`, `targets`: all triangles at the same points, in ascending order of faces.
pub(super) fn matched(sources: &[Twin], targets: &[Twin]) -> Vec<[u32; 2]> {
    let mut left = [sources.to_vec(), targets.to_vec()];
    let mut found = Vec::with_capacity(sources.len().max(targets.len()));
    link_equal(&mut left, |twin| (twin.is_odd, twin.uv), &mut found);
    link_equal(&mut left, |twin| twin.is_odd, &mut found);
    link_equal(&mut left, |twin| twin.uv, &mut found);
    link_equal(&mut left, |_| (), &mut found);
    let [sources_left, targets_left] = left;
    let (all_sources, all_targets) = (Firsts::new(sources), Firsts::new(targets));
    found.extend(sources_left.iter().map(|twin| [twin.face, all_targets.nearest(twin)]));
    found.extend(targets_left.iter().map(|twin| [all_sources.nearest(twin), twin.face]));
    found
}

/// Links twins with equal keys in the order of their faces, and leaves the others.
fn link_equal<K: Ord>(
    left: &mut [Vec<Twin>; 2],
    key: impl Fn(&Twin) -> K,
    found: &mut Vec<[u32; 2]>,
) {
    let [sources, targets] = left.each_mut().map(|side| {
        side.sort_by_key(|twin| (key(twin), twin.face));
        std::mem::take(side).into_iter().peekable()
    });
    let mut sides = [sources, targets];
    let [sources_left, targets_left] = left;
    while let [Some(source), Some(target)] = sides.each_mut().map(Peekable::peek) {
        match key(source).cmp(&key(target)) {
            std::cmp::Ordering::Less => sources_left.extend(sides[0].next()),
            std::cmp::Ordering::Greater => targets_left.extend(sides[1].next()),
            std::cmp::Ordering::Equal => {
                found.push([source.face, target.face]);
                for side in &mut sides {
                    side.next();
                }
            }
        }
    }
    let [sources, targets] = sides;
    sources_left.extend(sources);
    targets_left.extend(targets);
}

/// The first face of each kind.
struct Firsts {
    by_all: BTreeMap<(bool, [[u32; 2]; 3]), u32>,
    by_winding: [Option<u32>; 2],
    any: u32,
}

impl Firsts {
    /// - `twins`: at least one.
    fn new(twins: &[Twin]) -> Self {
        let mut by_all = BTreeMap::new();
        let mut by_winding = [None; 2];
        for twin in twins {
            by_all.entry((twin.is_odd, twin.uv)).or_insert(twin.face);
            by_winding[usize::from(twin.is_odd)].get_or_insert(twin.face);
        }
        Self { by_all, by_winding, any: twins[0].face }
    }

    /// The face that is most like one of the other side.
    fn nearest(&self, twin: &Twin) -> u32 {
        let alike = self.by_all.get(&(twin.is_odd, twin.uv)).copied();
        alike.or(self.by_winding[usize::from(twin.is_odd)]).unwrap_or(self.any)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn twin(face: u32, is_odd: bool, uv: u32) -> Twin {
        Twin { face, is_odd, uv: [[uv; 2]; 3] }
    }

    fn sorted(sources: &[Twin], targets: &[Twin]) -> Vec<[u32; 2]> {
        let mut found = matched(sources, targets);
        found.sort_unstable();
        found
    }

    #[test]
    fn permutations_of_points_are_odd_or_even() {
        for points in [[1, 5, 9], [5, 9, 1], [9, 1, 5]] {
            assert!(!is_odd(points));
            let [a, b, c] = points;
            assert!(is_odd([b, a, c]));
        }
    }

    #[test]
    fn winding_comes_before_uv_and_uv_before_order() {
        let front_and_back = [twin(0, false, 1), twin(1, true, 2)];
        // Sides that changed places, in the layout or in the order of faces.
        let exchanged = [twin(0, false, 2), twin(1, true, 1)];
        assert_eq!(sorted(&front_and_back, &exchanged), [[0, 0], [1, 1]]);
        let reordered = [twin(0, true, 2), twin(1, false, 1)];
        assert_eq!(sorted(&front_and_back, &reordered), [[0, 1], [1, 0]]);
        // Sides that wind alike.
        let alike = [twin(0, false, 1), twin(1, false, 2)];
        assert_eq!(sorted(&alike, &[twin(0, false, 2), twin(1, false, 1)]), [[0, 1], [1, 0]]);
        assert_eq!(sorted(&alike, &[twin(0, false, 7), twin(1, false, 5)]), [[0, 0], [1, 1]]);
    }

    #[test]
    fn what_is_left_over_shares_what_is_most_like_it() {
        let two = [twin(0, false, 1), twin(1, true, 2)];
        let three = [twin(0, true, 2), twin(1, false, 1), twin(2, true, 2)];
        assert_eq!(sorted(&two, &three), [[0, 1], [1, 0], [1, 2]]);
        assert_eq!(sorted(&three, &two), [[0, 1], [1, 0], [2, 1]]);
        assert_eq!(sorted(&two, &[twin(7, true, 9)]), [[0, 7], [1, 7]]);
    }
}
