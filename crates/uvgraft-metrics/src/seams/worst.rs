//! Selects the worst edges.

use glam::Vec3;

use super::SeamEdge;
use super::edge_class::distance;

/// Minimum distance between selected edges, as a fraction of the measured extent.
const SPACING: f64 = 0.02;

/// The edges with the largest mean steps, in descending order: up to `count` at UV seams and
/// `count` at the region boundary, each at some distance from earlier ones of its kind. The mean is
/// used because a single large step is often a detail of the texture, or the boundary met near the
/// end of a UV seam.
pub(super) fn worst(edges: &[SeamEdge], count: usize) -> Vec<usize> {
    let ends = edges.iter().flat_map(|edge| edge.ends).map(Vec3::from);
    let (low, high) = ends.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), end| {
        (low.min(end), high.max(end))
    });
    let across = high.as_dvec3().distance(low.as_dvec3());
    let middle = |edge: &SeamEdge| {
        let [a, b] = edge.ends.map(Vec3::from);
        // Halved first: the sum of two large coordinates may overflow.
        (a * 0.5 + b * 0.5).to_array()
    };
    let mut ranked: Vec<(f64, usize)> = edges
        .iter()
        .enumerate()
        .filter_map(|(index, edge)| Some((edge.mean?, index)))
        .filter(|(step, _)| *step > 0.0)
        .collect();
    ranked.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut worst: Vec<usize> = Vec::new();
    for (_, index) in ranked {
        if worst.len() == count.saturating_mul(2) {
            break;
        }
        let alike: Vec<usize> = worst
            .iter()
            .copied()
            .filter(|&other| edges[other].is_rim == edges[index].is_rim)
            .collect();
        let here = middle(&edges[index]);
        let is_apart = |&other: &usize| distance(here, middle(&edges[other])) >= across * SPACING;
        if alike.len() < count && alike.iter().all(is_apart) {
            worst.push(index);
        }
    }
    worst
}
