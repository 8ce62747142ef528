//! Colour differences along an edge.

use uvgraft::color::delta_e;
use uvgraft::edges::SharedEdge;
use uvgraft::mesh::Mesh;

use super::edge_class::{EdgeClass, point_count};
use super::probe::{Outcome, Probe};
use super::{SeamEdge, SeamNotes, SeamSide, Step};

/// A measured edge.
pub(super) struct Walked {
    pub seam: SeamEdge,
    pub kind: EdgeClass,
    /// Number of points along it, whether measured or not.
    pub points: usize,
    pub steps: Vec<f64>,
    pub notes: SeamNotes,
}

/// Measures an edge at points about one texel apart.
pub(super) fn along(mesh: &Mesh, probe: &Probe<'_>, edge: &SharedEdge, kind: EdgeClass) -> Walked {
    let points = point_count(edge, mesh, probe.texture());
    let mut notes = SeamNotes::default();
    let mut steps = Vec::with_capacity(points);
    let mut worst: Option<Step> = None;
    for point in 0..points {
        let at = (point as f64 + 0.5) / points as f64;
        if let Some(step) = step(mesh, probe, edge, at, &mut notes) {
            steps.push(step.delta_e);
            if worst.is_none_or(|worst| step.delta_e > worst.delta_e) {
                worst = Some(step);
            }
        }
    }
    let uv = edge.uv(mesh);
    let side = |k: usize| {
        let half = edge.halves[k];
        SeamSide { face: half / 3, corner: (half % 3) as u8, uv: uv[k] }
    };
    let seam = SeamEdge {
        sides: [side(0), side(1)],
        ends: edge.positions(mesh),
        length: edge.length(mesh),
        is_uv_seam: kind.is_uv_seam,
        is_rim: kind.is_rim,
        is_inside: kind.is_inside,
        mean: worst.map(|_| steps.iter().sum::<f64>() / steps.len() as f64),
        worst,
    };
    Walked { seam, kind, points, steps, notes }
}

/// The step at one point of an edge, if it can be measured; problems are counted in `notes`.
pub(super) fn step(
    mesh: &Mesh,
    probe: &Probe<'_>,
    edge: &SharedEdge,
    at: f64,
    notes: &mut SeamNotes,
) -> Option<Step> {
    let [a, b] = edge.at(at).map(|(half, at)| probe.color_at(half, at));
    let seen = match (a, b) {
        (Outcome::Color(a), Outcome::Color(b)) => [a, b],
        (Outcome::NoArea, _) | (_, Outcome::NoArea) => {
            notes.no_area += 1;
            return None;
        }
        (Outcome::Clear, _) | (_, Outcome::Clear) => {
            notes.clear += 1;
            return None;
        }
        (Outcome::NotFinite, _) | (_, Outcome::NotFinite) => {
            notes.not_finite += 1;
            return None;
        }
    };
    notes.shortened += usize::from(seen.iter().any(|side| !side.complete));
    let is_outside = |uv: [f64; 2]| uv.iter().any(|value| !(0.0..=1.0).contains(value));
    notes.outside += usize::from(seen.iter().any(|side| is_outside(side.uv)));
    let place = |[start, end]: [[f32; 2]; 2]| {
        [0, 1].map(|k| {
            let [start, end] = [start, end].map(|corner| f64::from(corner[k]));
            start + (end - start) * at
        })
    };
    let colors = [seen[0].color, seen[1].color];
    Some(Step {
        delta_e: delta_e(colors[0], colors[1]),
        along: at,
        uv: edge.uv(mesh).map(place),
        sampled: [seen[0].uv, seen[1].uv],
        colors,
    })
}
