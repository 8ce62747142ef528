//! A tree of boxes over triangles that finds what is near a point or inside a box.
//!
//! Closest points on triangles follow C. Ericson, "Real-Time Collision Detection", 2005, section
//! 5.1.5.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;

use crate::piece::Weights;

/// Triangles in a leaf, at most.
const LEAF: usize = 4;

/// An axis-aligned box.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    pub min: DVec3,
    pub max: DVec3,
}

impl Bounds {
    const NOTHING: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::NOTHING, |bounds, point| Self {
            min: bounds.min.min(point),
            max: bounds.max.max(point),
        })
    }

    /// The same, larger by `margin` on every side.
    pub fn grown(self, margin: f64) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    pub fn size(self) -> DVec3 {
        (self.max - self.min).max(DVec3::ZERO)
    }

    fn joined(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    fn meets(self, other: Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// - `inverse`: of each coordinate of the direction.
    fn meets_ray(self, origin: DVec3, inverse: DVec3) -> bool {
        let (one, other) = ((self.min - origin) * inverse, (self.max - origin) * inverse);
        let (enters, leaves) = (one.min(other), one.max(other));
        enters.max_element().max(0.0) <= leaves.min_element()
    }

    fn distance_squared(self, point: DVec3) -> f64 {
        (self.min - point).max(point - self.max).max(DVec3::ZERO).length_squared()
    }
}

/// A point of a triangle near another point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nearest {
    pub triangle: u32,
    pub weights: Weights,
    pub point: DVec3,
    pub distance: f64,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Bounds,
    /// First triangle of a leaf in `order`, or index of the left child; the right child follows it.
    first: u32,
    /// Number of triangles; 0 for a node with children.
    count: u32,
}

/// Triangles in boxes.
#[derive(Debug, Clone)]
pub(crate) struct TriangleTree {
    corners: Vec<[DVec3; 3]>,
    order: Vec<u32>,
    nodes: Vec<Node>,
    effort: Arc<Effort>,
}

/// How many boxes and triangles searches look at, and how many they may. On surfaces a search looks at
/// a few dozen, where triangles lie all over each other at most of them.
#[derive(Debug)]
pub(crate) struct Effort {
    most: u64,
    spent: AtomicU64,
}

impl Effort {
    /// Searches of trees with this effort may look at `most` boxes and triangles together.
    pub fn new(most: u64) -> Arc<Self> {
        Arc::new(Self { most, spent: AtomicU64::new(0) })
    }

    /// Searches that may take as long as they do.
    pub fn unlimited() -> Arc<Self> {
        Self::new(u64::MAX / 2)
    }

    /// Whether searches looked at as many as they may; from then on they find nothing. Whether this
    /// happens depends on neither the order of searches nor threads, but what was found before does.
    pub fn is_spent(&self) -> bool {
        self.spent.load(Ordering::Relaxed) > self.most
    }

    /// How many may be looked at.
    pub fn most(&self) -> u64 {
        self.most
    }
}

/// The effort of one search, which is added to that of all at its end.
struct Steps<'a> {
    effort: &'a Effort,
    left: u64,
    taken: u64,
}

impl Steps<'_> {
    /// Takes some steps; false if there are no more.
    fn take(&mut self, steps: u64) -> bool {
        self.taken += steps;
        self.taken <= self.left
    }
}

impl Drop for Steps<'_> {
    fn drop(&mut self) {
        self.effort.spent.fetch_add(self.taken, Ordering::Relaxed);
    }
}

impl TriangleTree {
    pub fn new(corners: Vec<[DVec3; 3]>) -> Self {
        let mut order: Vec<u32> = (0..corners.len() as u32).collect();
        let effort = Effort::unlimited();
        let mut tree = Self { corners, order: Vec::new(), nodes: Vec::new(), effort };
        tree.nodes.push(Node { bounds: Bounds::NOTHING, first: 0, count: 0 });
        let count = order.len();
        tree.split(0, &mut order, 0, count);
        tree.order = order;
        tree
    }

    /// The same tree, whose searches share an effort with those of others.
    pub fn with_effort(self, effort: &Arc<Effort>) -> Self {
        Self { effort: Arc::clone(effort), ..self }
    }

    /// The effort of its searches.
    pub fn effort(&self) -> &Arc<Effort> {
        &self.effort
    }

    fn steps(&self) -> Steps<'_> {
        let spent = self.effort.spent.load(Ordering::Relaxed);
        // One more than is left makes it spent.
        let left = (self.effort.most + 1).saturating_sub(spent);
        Steps { effort: &self.effort, left, taken: 0 }
    }

    fn split(&mut self, node: usize, order: &mut [u32], start: usize, end: usize) {
        let bounds_of = |triangle: u32| Bounds::of(self.corners[triangle as usize]);
        let part = &mut order[start..end];
        let bounds = part.iter().fold(Bounds::NOTHING, |all, &one| all.joined(bounds_of(one)));
        if part.len() <= LEAF {
            self.nodes[node] = Node { bounds, first: start as u32, count: part.len() as u32 };
            return;
        }
        let size = bounds.size();
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let center = |triangle: u32| self.corners[triangle as usize].iter().sum::<DVec3>()[axis];
        let middle = part.len() / 2;
        part.select_nth_unstable_by(middle, |&a, &b| {
            center(a).total_cmp(&center(b)).then(a.cmp(&b))
        });
        let left = self.nodes.len();
        let nothing = Node { bounds: Bounds::NOTHING, first: 0, count: 0 };
        self.nodes.extend([nothing; 2]);
        self.nodes[node] = Node { bounds, first: left as u32, count: 0 };
        self.split(left, order, start, start + middle);
        self.split(left + 1, order, start + middle, end);
    }

    /// The point nearest to `point` within `reach` on a triangle that `accepts` takes.
    pub fn nearest(
        &self,
        point: DVec3,
        reach: f64,
        accepts: impl Fn(u32) -> bool,
    ) -> Option<Nearest> {
        if self.corners.is_empty() {
            return None;
        }
        let mut best: Option<Nearest> = None;
        let mut limit = reach * reach;
        let mut steps = self.steps();
        let mut stack = vec![(0_u32, self.nodes[0].bounds.distance_squared(point))];
        while let Some((index, distance)) = stack.pop() {
            if !steps.take(1) {
                return None;
            }
            if distance > limit {
                continue;
            }
            let node = self.nodes[index as usize];
            if node.count == 0 {
                let mut children = [node.first, node.first + 1].map(|child| {
                    (child, self.nodes[child as usize].bounds.distance_squared(point))
                });
                // The nearer child is popped first.
                if children[0].1 < children[1].1 {
                    children.swap(0, 1);
                }
                stack.extend(children);
                continue;
            }
            for &triangle in &self.order[node.first as usize..][..node.count as usize] {
                let corners = self.corners[triangle as usize];
                let weights = closest_weights(point, corners);
                let at = mixed(corners, weights);
                let distance = at.distance_squared(point);
                let is_nearer = distance < limit
                    || best.is_none_or(|best| distance <= limit && triangle < best.triangle);
                if distance <= limit && is_nearer && accepts(triangle) {
                    limit = distance;
                    best = Some(Nearest { triangle, weights, point: at, distance: 0.0 });
                }
            }
        }
        best.map(|nearest| Nearest { distance: limit.sqrt(), ..nearest })
    }

    /// Whether a ray meets a triangle, from either side.
    pub fn is_hit(&self, origin: DVec3, direction: DVec3) -> bool {
        let inverse = direction.recip();
        let mut steps = self.steps();
        let mut stack = if self.corners.is_empty() { Vec::new() } else { vec![0_u32] };
        while let Some(index) = stack.pop() {
            if !steps.take(1) {
                return false;
            }
            let node = self.nodes[index as usize];
            if !node.bounds.meets_ray(origin, inverse) {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first, node.first + 1]);
                continue;
            }
            let triangles = &self.order[node.first as usize..][..node.count as usize];
            let meets = |&triangle: &u32| {
                ray_distance(origin, direction, self.corners[triangle as usize]).is_some()
            };
            if triangles.iter().any(meets) {
                return true;
            }
        }
        false
    }

    /// Whether a line through a point meets a triangle that `accepts` takes within `reach`, on either
    /// side.
    ///
    /// - `direction`: of the line, normalised.
    pub fn is_met_along(
        &self,
        point: DVec3,
        direction: DVec3,
        reach: f64,
        accepts: impl Fn(u32) -> bool,
    ) -> bool {
        let mut is_met = false;
        let ends = [point - direction * reach, point + direction * reach];
        self.within(Bounds::of(ends), |triangle| {
            let corners = self.corners[triangle as usize];
            let on = |direction| ray_distance(point, direction, corners);
            let distance = on(direction).or_else(|| on(-direction));
            is_met |= distance.is_some_and(|distance| distance <= reach) && accepts(triangle);
        });
        is_met
    }

    /// Calls `visit` with every triangle whose box meets `bounds`.
    pub fn within(&self, bounds: Bounds, mut visit: impl FnMut(u32)) {
        let mut steps = self.steps();
        let mut stack = if self.corners.is_empty() { Vec::new() } else { vec![0_u32] };
        while let Some(index) = stack.pop() {
            if !steps.take(1) {
                return;
            }
            let node = self.nodes[index as usize];
            if !node.bounds.meets(bounds) {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first, node.first + 1]);
                continue;
            }
            for &triangle in &self.order[node.first as usize..][..node.count as usize] {
                if Bounds::of(self.corners[triangle as usize]).meets(bounds) {
                    visit(triangle);
                }
            }
        }
    }
}

/// Where a ray meets a triangle, in lengths of `direction` (T. Möller and B. Trumbore, "Fast, Minimum
/// Storage Ray-Triangle Intersection", 1997).
fn ray_distance(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(ac);
    let det = ab.dot(across);
    if !det.is_normal() {
        return None;
    }
    let from_a = origin - a;
    let u = from_a.dot(across) / det;
    let turned = from_a.cross(ab);
    let v = direction.dot(turned) / det;
    let along = ac.dot(turned) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && along > 0.0).then_some(along)
}

/// The point of a triangle with the given weights.
fn mixed(corners: [DVec3; 3], weights: Weights) -> DVec3 {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}

/// The weights of the point of a triangle that is closest to `point`.
fn closest_weights(point: DVec3, [a, b, c]: [DVec3; 3]) -> Weights {
    let (ab, ac) = (b - a, c - a);
    let from_a = point - a;
    let (d1, d2) = (ab.dot(from_a), ac.dot(from_a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let from_b = point - b;
    let (d3, d4) = (ab.dot(from_b), ac.dot(from_b));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let along = d1 / (d1 - d3);
        return [1.0 - along, along, 0.0];
    }
    let from_c = point - c;
    let (d5, d6) = (ab.dot(from_c), ac.dot(from_c));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let along = d2 / (d2 - d6);
        return [1.0 - along, 0.0, along];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - along, along];
    }
    let total = va + vb + vc;
    let (v, w) = (vb / total, vc / total);
    // A degenerate triangle was caught by one of its edges, or is a point.
    if total.is_normal() { [1.0 - v - w, v, w] } else { [1.0, 0.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(random: &mut fastrand::Rng) -> DVec3 {
        DVec3::new(random.f64(), random.f64(), random.f64())
    }

    #[test]
    fn answers_are_those_of_all_triangles_one_by_one() {
        let mut random = fastrand::Rng::with_seed(1);
        let mut triangles: Vec<[DVec3; 3]> = (0..300)
            .map(|_| {
                let at = point(&mut random);
                [at, at + point(&mut random) * 0.2, at + point(&mut random) * 0.2]
            })
            .collect();
        // Degenerate ones: a point, and a line.
        triangles.push([DVec3::ONE; 3]);
        triangles.push([DVec3::ZERO, DVec3::X, DVec3::X * 0.5]);
        let tree = TriangleTree::new(triangles.clone());
        for round in 0..500 {
            let at = point(&mut random) * 1.5 - 0.2;
            let accepts = |triangle: u32| !(triangle as usize + round).is_multiple_of(3);
            let slow = (0..triangles.len() as u32)
                .filter(|&triangle| accepts(triangle))
                .map(|triangle| {
                    let corners = triangles[triangle as usize];
                    mixed(corners, closest_weights(at, corners)).distance(at)
                })
                .fold(f64::INFINITY, f64::min);
            let fast = tree.nearest(at, f64::INFINITY, accepts).unwrap();
            assert!((fast.distance - slow).abs() < 1e-12);
            assert!(
                (mixed(triangles[fast.triangle as usize], fast.weights) - fast.point).length()
                    < 1e-12
            );
            assert_eq!(tree.nearest(at, slow * 0.99, accepts), None);
            let bounds = Bounds::of([at, point(&mut random)]);
            let mut found = Vec::new();
            tree.within(bounds, |triangle| found.push(triangle));
            found.sort_unstable();
            let meets = |triangle: &u32| Bounds::of(triangles[*triangle as usize]).meets(bounds);
            let all: Vec<u32> = (0..triangles.len() as u32).filter(meets).collect();
            assert_eq!(found, all);
        }
    }

    #[test]
    fn the_closest_point_is_closer_than_any_sample() {
        let mut random = fastrand::Rng::with_seed(2);
        for _ in 0..200 {
            let corners = [(); 3].map(|()| point(&mut random));
            let at = point(&mut random) * 2.0 - 0.5;
            let found = mixed(corners, closest_weights(at, corners)).distance(at);
            for _ in 0..50 {
                let (s, t) = (random.f64(), random.f64());
                let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                assert!(found <= mixed(corners, [1.0 - s - t, s, t]).distance(at) + 1e-12);
            }
        }
    }
}
