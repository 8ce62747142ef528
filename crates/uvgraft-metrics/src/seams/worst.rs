//! The worst places at seams.

use super::SeamEdge;
use super::edge_class::distance;

/// The worst places are apart by this share of what is measured across.
const APART: f64 = 0.02;

/// The edges with the largest mean steps, `count` of UV seams and of the rim each, the worst first;
/// each away from those of its kind before it. The mean, because a single large step is often a detail
/// of the texture, or the rim met near the end of a UV seam.
pub(super) fn worst(edges: &[SeamEdge], count: usize) -> Vec<usize> {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for position in edges.iter().flat_map(|edge| edge.ends) {
        for k in 0..3 {
            low[k] = low[k].min(f64::from(position[k]));
            high[k] = high[k].max(f64::from(position[k]));
        }
    }
    let across = [0, 1, 2].map(|k| (high[k] - low[k]).powi(2)).iter().sum::<f64>().sqrt();
    let middle = |edge: &SeamEdge| {
        let [a, b] = edge.ends;
        [0, 1, 2].map(|k| a[k] * 0.5 + b[k] * 0.5)
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
