//! Deviation of a simplified surface from the original.
//!
//! Distances are measured from the vertices of the original to the triangles of the simplified
//! mesh, with a bounding volume hierarchy. Closest points on triangles: Ericson, "Real-Time
//! Collision Detection", 2005, chapter 5.1.5.

use glam::Vec3;
use uvgraft::Mesh;

/// Distances from the vertices of a mesh to a surface that replaces it, in the mesh's unit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deviation {
    /// Mean over the vertices.
    pub mean: f32,
    /// Maximum.
    pub most: f32,
}

impl Deviation {
    /// Distances from the vertices used by triangles of `before` to the triangles of `after`; 0 if
    /// there are none.
    pub fn between(before: &Mesh, after: &Mesh) -> Self {
        let tree = Tree::new(after);
        let mut is_used = vec![false; before.positions().len()];
        for &vertex in before.faces().as_flattened() {
            is_used[vertex as usize] = true;
        }
        let (mut count, mut sum, mut most) = (0_u32, 0.0_f64, 0.0_f32);
        let used = before.positions().iter().zip(&is_used).filter(|(_, is_used)| **is_used);
        for (&position, _) in used {
            let distance = tree.distance(position.into());
            count += 1;
            sum += f64::from(distance);
            most = most.max(distance);
        }
        Self { mean: (sum / f64::from(count.max(1))) as f32, most }
    }
}

/// A bounding volume hierarchy over triangles: an implicit, balanced binary tree, whose nodes cover
/// contiguous halves of their parent's triangles.
struct Tree {
    triangles: Vec<[Vec3; 3]>,
    /// Bounding box of each node; the children of node `n` are `2 n + 1` and `2 n + 2`.
    boxes: Vec<(Vec3, Vec3)>,
    levels: u32,
}

/// Maximum number of triangles in a leaf.
const LEAF: usize = 4;

impl Tree {
    fn new(mesh: &Mesh) -> Self {
        let place = |vertex: u32| Vec3::from(mesh.positions()[vertex as usize]);
        let mut triangles: Vec<[Vec3; 3]> =
            mesh.faces().iter().map(|face| face.map(place)).collect();
        let leaves = triangles.len().div_ceil(LEAF).next_power_of_two();
        let levels = leaves.trailing_zeros();
        let mut tree = Self {
            triangles: Vec::new(),
            boxes: vec![(Vec3::ZERO, Vec3::ZERO); 2 * leaves - 1],
            levels,
        };
        tree.divide(&mut triangles, 0, 0);
        tree.triangles = triangles;
        tree
    }

    /// Splits triangles at the median centroid along the longest axis of their bounding box,
    /// recursively.
    fn divide(&mut self, triangles: &mut [[Vec3; 3]], node: usize, level: u32) {
        let corners = || triangles.iter().flatten();
        let low = corners().fold(Vec3::INFINITY, |low, &corner| low.min(corner));
        let high = corners().fold(Vec3::NEG_INFINITY, |high, &corner| high.max(corner));
        self.boxes[node] = (low, high);
        if level == self.levels {
            return;
        }
        let extent = high - low;
        let axis =
            (0..3).fold(0, |best, axis| if extent[axis] > extent[best] { axis } else { best });
        let middle = triangles.len() / 2;
        if !triangles.is_empty() {
            let key =
                |triangle: &[Vec3; 3]| triangle[0][axis] + triangle[1][axis] + triangle[2][axis];
            triangles.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
        }
        let (left, right) = triangles.split_at_mut(middle);
        self.divide(left, 2 * node + 1, level + 1);
        self.divide(right, 2 * node + 2, level + 1);
    }

    fn distance(&self, point: Vec3) -> f32 {
        if self.triangles.is_empty() {
            return 0.0;
        }
        let mut least = f32::INFINITY;
        self.search(point, (0, 0), 0..self.triangles.len(), &mut least);
        least.sqrt()
    }

    /// Branch and bound: visits the nearer child first and skips boxes that are farther
    /// than the best distance so far.
    ///
    /// - `at`: a node and its level.
    /// - `range`: the node's triangles.
    /// - `least`: the smallest squared distance so far.
    fn search(
        &self,
        point: Vec3,
        at: (usize, u32),
        range: std::ops::Range<usize>,
        least: &mut f32,
    ) {
        let (node, level) = at;
        if range.is_empty() || self.to_box(node, point) >= *least {
            return;
        }
        if level == self.levels {
            for triangle in &self.triangles[range] {
                *least = least.min(nearest(point, triangle).distance_squared(point));
            }
            return;
        }
        let middle = range.start + range.len() / 2;
        let mut halves = [(2 * node + 1, range.start..middle), (2 * node + 2, middle..range.end)];
        if self.to_box(halves[1].0, point) < self.to_box(halves[0].0, point) {
            halves.swap(0, 1);
        }
        for (child, range) in halves {
            self.search(point, (child, level + 1), range, least);
        }
    }

    /// Squared distance from a point to a node's box.
    fn to_box(&self, node: usize, point: Vec3) -> f32 {
        let (low, high) = self.boxes[node];
        point.clamp(low.min(high), high.max(low)).distance_squared(point)
    }
}

/// The point of a triangle closest to `point`: classifies the point by the Voronoi regions of the
/// triangle's vertices, edges and face (Ericson 2005, 5.1.5). Falls back to corner `a` for
/// degenerate triangles.
fn nearest(point: Vec3, &[a, b, c]: &[Vec3; 3]) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let sum = va + vb + vc;
    if sum > 0.0 { a + ab * (vb / sum) + ac * (vc / sum) } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glb::testing::tube;

    #[test]
    fn the_tree_agrees_with_a_brute_force_search() {
        let mesh = tube().mesh;
        let tree = Tree::new(&mesh);
        for k in 0..200 {
            let at = |step: f32| (k as f32 * step).sin();
            let point = Vec3::new(0.2 * at(1.1), 0.3 + 0.5 * at(0.7), 0.2 * at(2.3));
            let wanted =
                tree.triangles.iter().map(|triangle| nearest(point, triangle).distance(point));
            let wanted = wanted.fold(f32::INFINITY, f32::min);
            assert!((tree.distance(point) - wanted).abs() < 1e-6, "{point}");
        }
    }

    #[test]
    fn distances_by_hand() {
        let square = |z: f32, side: f32| {
            let positions =
                [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]].map(|[x, y]| [x, y, z]);
            let faces = [[0, 1, 2], [0, 2, 3]];
            Mesh::from_triangles(positions.into(), vec![[0.0; 2]; 4], &faces, &faces).unwrap()
        };
        // Three corners are outside the smaller square: two by 1, one by √2.
        let found = Deviation::between(&square(0.0, 2.0), &square(0.0, 1.0));
        assert!((found.most - 2.0_f32.sqrt()).abs() < 1e-6, "{found:?}");
        assert!((found.mean - (2.0 + 2.0_f32.sqrt()) / 4.0).abs() < 1e-6, "{found:?}");
        let found = Deviation::between(&square(0.5, 1.0), &square(0.0, 2.0));
        assert_eq!(found, Deviation { mean: 0.5, most: 0.5 });
    }
}
