//! The worst places at seams.

use glam::Vec3;

use super::SeamEdge;
use super::edge_class::distance;

/// The worst places are apart by this share of what is measured across.
const APART: f64 = 0.02;

/// The edges with the largest mean steps, `count` of UV seams and of the rim each, the worst first;
/// each away from those of its kind before it. The mean, because a single large step is often a detail
/// of the texture, or the rim met near the end of a UV seam.
pub(super) fn worst(edges: &[SeamEdge], count: usize) -> Vec<usize> {
    let ends = edges.iter().flat_map(|edge| edge.ends).map(Vec3::from);
    let (low, high) = ends.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), end| {
        (low.min(end), high.max(end))
    });
    let across = high.as_dvec3().distance(low.as_dvec3());
    let middle = |edge: &SeamEdge| {
        let [a, b] = edge.ends.map(Vec3::from);
        // Halved first: the sum of two great coordinates may be infinite.
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
        let is_apart = |&other: &usize| distance(here, middle(&edges[other])) >= across * APART;
        if alike.len() < count && alike.iter().all(is_apart) {
            worst.push(index);
        }
    }
    worst
}
