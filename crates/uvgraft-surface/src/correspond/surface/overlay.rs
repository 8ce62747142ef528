//! Laying two surfaces over each other exactly: every part of a registered target triangle gets the
//! part of a source triangle that lies over it.
//!
//! Source points are projected along normals that are interpolated over the target triangle, so
//! that neighbouring triangles project alike along their common edge. Within a target triangle,
//! source triangles are clipped in barycentric coordinates. Where a source edge crosses a target
//! edge is computed from these two edges alone, so every triangle that meets there has the same
//! point, and pieces fit together without gaps.

use glam::DVec3;

use super::kinds::TriangleKind;
use super::register::Goal;
use super::shape::Shape;
use crate::piece::{Piece, Weights};
use crate::threads::map_indices;
use crate::triangle_tree::Bounds;

/// Pieces, and what they cover.
#[derive(Debug, Clone, Default)]
pub(super) struct Overlay {
    /// Ascending by target triangle.
    pub pieces: Vec<Piece>,
    /// The share of each target triangle that is covered.
    pub covered: Vec<f64>,
    /// Distances of covered target corners from the source.
    pub distances: Vec<f64>,
}

/// Smaller weights are rounding.
const ROUNDING: f64 = 1e-7;

/// Pieces that are smaller, relative to their target triangle, are left out.
const LEAST_AREA: f64 = 1e-9;

/// Lays the goal over a registered target.
///
/// - `kinds`: of the target's triangles.
/// - `reach`: the largest distance along the normal.
/// - `visibility`: the least cosine between the normals of two triangles.
pub(super) fn overlay(
    goal: &Goal,
    target: &Shape,
    kinds: &[TriangleKind],
    reach: f64,
    visibility: f64,
) -> Overlay {
    let context = Context {
        goal,
        target,
        kinds,
        normals: target.normals(),
        neighbours: neighbours(&goal.shape),
        reach,
        visibility,
    };
    let overlaid =
        map_indices(target.triangles.len(), |triangle| context.triangle(triangle as u32));
    let mut overlay = Overlay::default();
    for OverTriangle { pieces, covered, distance } in overlaid {
        overlay.pieces.extend(pieces);
        overlay.covered.push(covered);
        overlay.distances.extend(distance);
    }
    overlay
}

/// The triangle on the other side of each side, or `u32::MAX`.
fn neighbours(shape: &Shape) -> Vec<u32> {
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(shape.triangles.len() * 3);
    for (triangle, points) in (0..).zip(&shape.triangles) {
        for k in 0..3 {
            let (a, b) = (points[k], points[(k + 1) % 3]);
            sides.push((a.min(b), a.max(b), 3 * triangle + k as u32));
        }
    }
    sides.sort_unstable();
    let mut found = vec![u32::MAX; sides.len()];
    for group in sides.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
        if let &[(.., one), (.., other)] = group {
            found[one as usize] = other / 3;
            found[other as usize] = one / 3;
        }
    }
    found
}

struct Context<'a> {
    goal: &'a Goal,
    target: &'a Shape,
    kinds: &'a [TriangleKind],
    normals: Vec<DVec3>,
    neighbours: Vec<u32>,
    reach: f64,
    visibility: f64,
}

/// What lies over one target triangle.
#[derive(Debug, Clone, Default)]
struct OverTriangle {
    pieces: Vec<Piece>,
    covered: f64,
    distance: Option<f64>,
}

/// A source triangle over a target triangle.
#[derive(Debug, Clone)]
struct Candidate {
    source: u32,
    /// What of it lies over the target triangle: convex.
    polygon: Vec<Clipped>,
    /// Mean distance.
    height: f64,
    /// Whether its normal and kind are those of a partner. Others belong to a layer by connection.
    is_seed: bool,
}

impl Candidate {
    /// Whether both lie over the same part of the target triangle.
    fn overlaps(&self, other: &Self) -> bool {
        // Neighbours share an edge, of which each knows the ends but for rounding.
        let is_apart = |one: &[Clipped], other: &[Clipped]| {
            (0..one.len()).any(|k| {
                let (from, to) = (one[k].target, one[(k + 1) % one.len()].target);
                let length = (0..3).map(|i| (to[i] - from[i]).abs()).fold(0.0, f64::max);
                let is_outside = |at: &Clipped| area([from, to, at.target]) <= ROUNDING * length;
                length > ROUNDING && other.iter().all(is_outside)
            })
        };
        !is_apart(&self.polygon, &other.polygon) && !is_apart(&other.polygon, &self.polygon)
    }
}

/// A corner of a clipped source triangle.
#[derive(Debug, Clone, Copy)]
struct Clipped {
    target: Weights,
    source: Weights,
    height: f64,
    /// Bit `k` is set where the weight of target corner `k` is exactly 0: on an edge.
    on_target: u8,
    /// The same for the source.
    on_source: u8,
}

/// A corner of the part of a source triangle that is near a target triangle.
#[derive(Debug, Clone, Copy)]
struct SourceCorner {
    at: DVec3,
    weights: Weights,
    /// As [`Clipped::on_source`].
    on_source: u8,
}

impl Context<'_> {
    fn triangle(&self, triangle: u32) -> OverTriangle {
        /// Gaps that are smaller are where the source ends. Origin not recorded.
        const GAP: f64 = 0.1;
        let Some(frame) = Prism::new(self, triangle) else { return OverTriangle::default() };
        let found = self.lay_over(&frame);
        if found.covered > 1.0 - GAP {
            return found;
        }
        // Where noise folds a surface, interpolated normals may cross even near the triangle. Its own
        // normal always projects, if not quite as its neighbours do.
        let flat = self.lay_over(&frame.flat());
        if flat.covered > found.covered + GAP { flat } else { found }
    }

    fn lay_over(&self, frame: &Prism) -> OverTriangle {
        let candidates = self.candidates(frame);
        let mut found = OverTriangle::default();
        let mut heights = Vec::new();
        for index in self.layer(frame, &candidates) {
            let Candidate { source, polygon, .. } = &candidates[index];
            let corners: Vec<[Weights; 2]> =
                polygon.iter().map(|corner| self.exact(frame, *source, corner)).collect();
            for k in 1..corners.len() - 1 {
                let fan = [corners[0], corners[k], corners[k + 1]];
                let area = area(fan.map(|corner| corner[0]));
                if area > LEAST_AREA {
                    found.covered += area;
                    found.pieces.push(piece(frame.triangle, *source, fan));
                }
            }
            heights.extend(polygon.iter().map(|corner| corner.height.abs()));
        }
        let mean = heights.iter().sum::<f64>() / heights.len().max(1) as f64;
        found.distance = (!found.pieces.is_empty()).then_some(mean);
        found
    }

    /// Every source triangle that may lie over the target triangle, clipped; ascending.
    fn candidates(&self, frame: &Prism) -> Vec<Candidate> {
        let bounds = Bounds::of(frame.corners).grown(2.0 * self.reach);
        let mut found = Vec::new();
        self.goal.tree.within(bounds, |source| {
            let kind = self.goal.kinds[source as usize];
            let along = self.goal.face_normals[source as usize].dot(frame.normal);
            if along <= 0.0 || !frame.kind.is_of_body(kind) {
                return;
            }
            let corners = self.goal.shape.corners(source as usize);
            let Some(polygon) = frame
                .near_part(corners)
                .into_iter()
                .map(|corner| {
                    let (target, height) = frame.project(corner.at)?;
                    let SourceCorner { weights: source, on_source, .. } = corner;
                    Some(Clipped { target, source, height, on_target: 0, on_source })
                })
                .collect::<Option<Vec<Clipped>>>()
            else {
                return;
            };
            let is_aside = |k: usize| polygon.iter().all(|corner| corner.target[k] <= 0.0);
            if (0..3).any(is_aside) || signed_area(&polygon) <= 0.0 {
                return;
            }
            let polygon = (0..3).fold(polygon, |polygon, k| clip_to_edge(&polygon, k));
            if polygon.len() > 2 {
                let height = polygon.iter().map(|corner| corner.height.abs()).sum::<f64>()
                    / polygon.len() as f64;
                let is_seed = along > self.visibility && frame.kind.may_meet(kind);
                found.push(Candidate { source, polygon, height, is_seed });
            }
        });
        found.sort_unstable_by_key(|candidate| candidate.source);
        found
    }

    /// The candidates of one layer: those that are connected to a partner of the triangle's centre or
    /// of its corners, nearest first, without those that lie over what is covered already. Behind
    /// them there may be others: teeth behind lips, the skull behind ears.
    fn layer(&self, frame: &Prism, candidates: &[Candidate]) -> Vec<usize> {
        let position = |source: u32| {
            candidates.binary_search_by_key(&source, |candidate| candidate.source).ok()
        };
        let mut next: Vec<usize> = Vec::new();
        for (seed, closest) in seeds(frame.corners).into_iter().zip(frame.closest) {
            let partner = self.goal.tree.nearest(seed, self.reach * 2.0, |source| {
                position(source).is_some_and(|index| candidates[index].is_seed)
            });
            let Some(partner) = partner else { continue };
            // The nearest of all must not be on another layer.
            let is_first =
                closest.is_none_or(|closest| partner.distance < 2.0 * closest + ROUNDING);
            next.extend(position(partner.triangle).filter(|_| is_first));
        }
        let mut is_reached = vec![false; candidates.len()];
        next.iter().for_each(|&index| is_reached[index] = true);
        next.sort_unstable();
        next.dedup();
        let mut chosen: Vec<usize> = Vec::new();
        // Few at a time, so looking for the nearest is cheaper than a queue.
        while let Some(nearest) = (0..next.len()).min_by(|&one, &other| {
            candidates[next[one]].height.total_cmp(&candidates[next[other]].height)
        }) {
            let index = next.swap_remove(nearest);
            let candidate = &candidates[index];
            let is_free = |&other: &usize| !candidate.overlaps(&candidates[other]);
            if candidate.height > self.reach || !chosen.iter().all(is_free) {
                continue;
            }
            chosen.push(index);
            for k in 0..3 {
                let neighbour = self.neighbours[3 * candidate.source as usize + k];
                let neighbour = position(neighbour).filter(|&neighbour| !is_reached[neighbour]);
                if let Some(neighbour) = neighbour {
                    is_reached[neighbour] = true;
                    next.push(neighbour);
                }
            }
        }
        chosen.sort_unstable();
        chosen
    }

    /// The weights of a clipped corner in the target and in the source triangle, computed from what
    /// every triangle that has this corner knows.
    fn exact(&self, frame: &Prism, source: u32, corner: &Clipped) -> [Weights; 2] {
        let bits = (corner.on_target.count_ones(), corner.on_source.count_ones());
        let exact = match bits {
            (1, 1) => self.crossing(frame, source, corner),
            (2, 0) => self.above_corner(frame, source, corner),
            _ => None,
        };
        let [target, source] = exact.unwrap_or([corner.target, corner.source]);
        [cleaned(target, corner.on_target), cleaned(source, corner.on_source)]
    }

    /// Where an edge of the target and one of the source cross: `det[d, n(a), p - e(a)] = 0`, where
    /// the target's edge `e` and normal `n` are linear in `a`, and the source's edge runs from `p`
    /// along `d`.
    fn crossing(&self, frame: &Prism, source: u32, corner: &Clipped) -> Option<[Weights; 2]> {
        const SLACK: f64 = 1e-6;
        let ends = |zero: u8, points: [u32; 3]| {
            let k = zero.trailing_zeros() as usize;
            let ends = [(k + 1) % 3, (k + 2) % 3];
            // In an order that doesn't depend on the triangle.
            if points[ends[0]] < points[ends[1]] { ends } else { [ends[1], ends[0]] }
        };
        let points = self.goal.shape.triangles[source as usize];
        let [i, j] = ends(corner.on_target, frame.points);
        let [p, q] = ends(corner.on_source, points);
        let [from, to] = [p, q].map(|k| self.goal.shape.points[points[k] as usize]);
        let (d, e) = (to - from, frame.corners[j] - frame.corners[i]);
        let (n, m) = (frame.normals[i], frame.normals[j] - frame.normals[i]);
        let offset = from - frame.corners[i];
        let det = |a: DVec3, b: DVec3, c: DVec3| a.dot(b.cross(c));
        let roots = quadratic(-det(d, m, e), det(d, m, offset) - det(d, n, e), det(d, n, offset));
        let range = -SLACK..=1.0 + SLACK;
        let place = |a: f64| {
            let (normal, gap) = (n + m * a, offset - e * a);
            let across = d.cross(normal);
            let b = -gap.cross(normal).dot(across) / across.length_squared();
            let height = (gap + d * b).dot(normal);
            let far = (height - corner.height).abs();
            (range.contains(&a) && range.contains(&b)).then_some((far, a, b))
        };
        let best = roots.into_iter().flatten().filter_map(place).min_by(|x, y| x.0.total_cmp(&y.0));
        let (_, a, b) = best?;
        let weights = |ends: [usize; 2], along: f64| {
            let mut weights = [0.0; 3];
            weights[ends[0]] = 1.0 - along;
            weights[ends[1]] = along;
            weights
        };
        Some([weights([i, j], a.clamp(0.0, 1.0)), weights([p, q], b.clamp(0.0, 1.0))])
    }

    /// Where the normal of a target corner meets a source triangle.
    fn above_corner(&self, frame: &Prism, source: u32, corner: &Clipped) -> Option<[Weights; 2]> {
        const SLACK: f64 = 1e-6;
        let k = (corner.on_target ^ 0b111).trailing_zeros() as usize;
        let [a, b, c] = self.goal.shape.corners(source as usize);
        let (origin, along) = (frame.corners[k], frame.normals[k]);
        let volume = |p: DVec3, q: DVec3| along.dot((p - origin).cross(q - origin));
        let parts = [volume(b, c), volume(c, a), volume(a, b)];
        let total: f64 = parts.iter().sum();
        let weights = parts.map(|part| part / total);
        let mut target = [0.0; 3];
        target[k] = 1.0;
        let is_inside = weights.iter().all(|weight| (-SLACK..=1.0 + SLACK).contains(weight));
        is_inside.then_some([target, weights])
    }
}

/// The space above and below a target triangle, along interpolated normals.
#[derive(Debug, Clone)]
struct Prism {
    triangle: u32,
    points: [u32; 3],
    corners: [DVec3; 3],
    normals: [DVec3; 3],
    normal: DVec3,
    kind: TriangleKind,
    /// For each corner, its weight at a point: `offset + gradient · p`, by orthogonal projection.
    weights: [(f64, DVec3); 3],
    /// What is farther outside than these weights never projects into the triangle.
    margins: Weights,
    /// Distances of the centre and of the corners from the closest compatible part of the source.
    closest: [Option<f64>; 4],
}

impl Prism {
    /// `None` for a triangle without area.
    fn new(context: &Context<'_>, triangle: u32) -> Option<Self> {
        let points = context.target.triangles[triangle as usize];
        let double_area = context.target.area_vector(triangle as usize);
        let normal = double_area.try_normalize()?;
        let corners = context.target.corners(triangle as usize);
        let kind = context.kinds[triangle as usize];
        let weights = [0, 1, 2].map(|k| {
            let [from, to] = [corners[(k + 1) % 3], corners[(k + 2) % 3]];
            let gradient = normal.cross(to - from) / double_area.length();
            (-gradient.dot(from), gradient)
        });
        let closest = seeds(corners).map(|at| {
            let reach = context.reach * 2.0;
            let partner = context.goal.partner(kind, at, normal, reach, context.visibility);
            partner.map(|partner| partner.distance)
        });
        let normals = points.map(|point| raised(context.normals[point as usize], normal));
        let flat = Self {
            triangle,
            points,
            corners,
            normals: [normal; 3],
            normal,
            kind,
            weights,
            margins: [1.0; 3],
            closest,
        };
        Some(flat.along(normals, context.reach * 2.0))
    }

    /// The same with other normals.
    fn along(self, normals: [DVec3; 3], reach: f64) -> Self {
        // How far points of the source move aside when they are projected. It must not depend on the
        // source's triangle, or neighbours would be cut at other places of their common edge.
        let slant = |at: DVec3| {
            let along = at.dot(self.normal);
            (at - self.normal * along).length() / along
        };
        let slant = normals.into_iter().map(slant).fold(0.0, f64::max);
        let farthest = self.closest.into_iter().flatten().fold(0.0, f64::max);
        let [a, b, c] = self.corners;
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let aside = slant * reach.min(2.0 * farthest + longest);
        let margins = self.weights.map(|(_, gradient)| 1.0 + aside * gradient.length());
        Self { normals, margins, ..self }
    }

    /// The same with the triangle's own normal.
    fn flat(self) -> Self {
        Self { normals: [self.normal; 3], margins: [1.0; 3], ..self }
    }

    /// The part of a source triangle that may project into the triangle. Far outside, interpolated
    /// normals cross, and a large source triangle would have no projection.
    fn near_part(&self, corners: [DVec3; 3]) -> Vec<SourceCorner> {
        let corner = |k: usize| {
            let mut weights = [0.0; 3];
            weights[k] = 1.0;
            SourceCorner { at: corners[k], weights, on_source: 0b111 ^ (1 << k) }
        };
        let mut polygon: Vec<SourceCorner> = (0..3).map(corner).collect();
        for ((offset, gradient), margin) in self.weights.into_iter().zip(self.margins) {
            let inside = |corner: &SourceCorner| offset + gradient.dot(corner.at) + margin;
            polygon = clip(&polygon, inside, |corner, next, along| SourceCorner {
                at: corner.at.lerp(next.at, along),
                weights: mix(corner.weights, next.weights, along),
                on_source: corner.on_source & next.on_source,
            });
        }
        polygon
    }

    /// The barycentric coordinates of a point's projection, and its height: Newton's method on
    /// `Σ wᵢ (Tᵢ + h nᵢ) = p`.
    fn project(&self, point: DVec3) -> Option<(Weights, f64)> {
        const STEPS: usize = 12;
        const SETTLED: f64 = 1e-12;
        let [a, b, c] = self.corners;
        let (e1, e2) = (b - a, c - a);
        let (m1, m2) = (self.normals[1] - self.normals[0], self.normals[2] - self.normals[0]);
        let (mut u, mut v, mut h) = (1.0 / 3.0, 1.0 / 3.0, 0.0);
        for _ in 0..STEPS {
            let normal = self.normals[0] + m1 * u + m2 * v;
            let miss = a + e1 * u + e2 * v + normal * h - point;
            let (x, y) = (e1 + m1 * h, e2 + m2 * h);
            let det = x.dot(y.cross(normal));
            if !det.is_normal() {
                return None;
            }
            let du = miss.dot(y.cross(normal)) / det;
            let dv = x.dot(miss.cross(normal)) / det;
            let dh = x.dot(y.cross(miss)) / det;
            (u, v, h) = (u - du, v - dv, h - dh);
            // Far outside normals may cross, and there is no answer.
            if !(u.abs() < 1e3 && v.abs() < 1e3) {
                return None;
            }
            if du.abs() + dv.abs() < SETTLED {
                return Some(([1.0 - u - v, u, v], h));
            }
        }
        None
    }
}

/// The points of a triangle whose partners decide the layer that it lies on: its centre and corners.
fn seeds([a, b, c]: [DVec3; 3]) -> [DVec3; 4] {
    [(a + b + c) / 3.0, a, b, c]
}

/// A point's normal, or the nearest direction that rises steeply enough from a triangle: across sharp
/// folds the mean normal is no direction to project along.
fn raised(at: DVec3, normal: DVec3) -> DVec3 {
    /// The sine of 17°.
    const LEAST: f64 = 0.3;
    let along = at.dot(normal);
    match (at - normal * along).try_normalize() {
        Some(aside) if along < LEAST => normal * LEAST + aside * (1.0 - LEAST * LEAST).sqrt(),
        None => normal,
        _ => at,
    }
}

/// Cuts off what of a convex polygon has a negative `inside`, which is linear.
///
/// - `between`: the corner at a share of the way from one corner to the next.
fn clip<Corner: Copy>(
    polygon: &[Corner],
    inside: impl Fn(&Corner) -> f64,
    between: impl Fn(&Corner, &Corner, f64) -> Corner,
) -> Vec<Corner> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, corner) in polygon.iter().enumerate() {
        let next = &polygon[(index + 1) % polygon.len()];
        let (here, there) = (inside(corner), inside(next));
        if here >= 0.0 {
            kept.push(*corner);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            kept.push(between(corner, next, here / (here - there)));
        }
    }
    kept
}

/// Cuts off what lies beyond the edge where the weight of target corner `k` is 0.
fn clip_to_edge(polygon: &[Clipped], k: usize) -> Vec<Clipped> {
    clip(
        polygon,
        |corner| corner.target[k],
        |corner, next, along| Clipped {
            target: mix(corner.target, next.target, along),
            source: mix(corner.source, next.source, along),
            height: corner.height + (next.height - corner.height) * along,
            on_target: (corner.on_target & next.on_target) | 1 << k,
            on_source: corner.on_source & next.on_source,
        },
    )
}

fn mix(a: Weights, b: Weights, along: f64) -> Weights {
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * along)
}

/// Weights with those of `zeros` and what is rounding set to 0, adding up to 1.
fn cleaned(weights: Weights, zeros: u8) -> Weights {
    let kept: Weights = std::array::from_fn(|k| {
        if zeros & 1 << k != 0 || weights[k] < ROUNDING { 0.0 } else { weights[k] }
    });
    let total: f64 = kept.iter().sum();
    kept.map(|weight| weight / total)
}

/// The signed area of a triangle of weights, relative to the whole.
fn area([a, b, c]: [Weights; 3]) -> f64 {
    (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1])
}

/// The signed area of a polygon of target weights, relative to the whole triangle.
fn signed_area(polygon: &[Clipped]) -> f64 {
    (2..polygon.len()).map(|k| area([0, k - 1, k].map(|at| polygon[at].target))).sum()
}

/// A piece of two triangles; whole where it spans both.
fn piece(target: u32, source: u32, corners: [[Weights; 2]; 3]) -> Piece {
    let one = |weights: Weights| weights.iter().position(|&weight| weight == 1.0);
    let ones = corners.map(|corner| corner.map(one));
    let mut whole = [3; 3];
    for [target, source] in ones {
        if let (Some(target), Some(source)) = (target, source) {
            whole[target] = source as u8;
        }
    }
    let mut sorted = whole;
    sorted.sort_unstable();
    if sorted == [0, 1, 2] {
        return Piece::whole(target, source, whole);
    }
    Piece::part(
        (target, corners.map(|corner| corner[0])),
        (source, corners.map(|corner| corner[1])),
    )
}

/// The real roots of `a x² + b x + c`.
fn quadratic(a: f64, b: f64, c: f64) -> [Option<f64>; 2] {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return [None; 2];
    }
    // The form that loses no digits where `a` is small.
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    let finite = |root: f64| root.is_finite().then_some(root);
    [finite(q / a), finite(c / q)]
}
