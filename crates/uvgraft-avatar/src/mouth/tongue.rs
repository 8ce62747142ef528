//! A tongue lying on the floor of the mouth, inside the lower teeth.

use std::f32::consts::PI;

use glam::Vec3;
use uvgraft::easing::smoothstep;

use super::cavity::Fit;
use super::piece::{Chart, Knot, Piece, Point};

const ACROSS: usize = 8;
const ALONG: usize = 7;

/// Distance of the tip behind the front of the upper teeth, and length of the tongue from there.
const TIP_MM: f32 = 9.0;
const LENGTH_MM: f32 = 38.0;

/// The surface of the tongue, as a grid from side to side and from the tip to the back.
/// Each row is an arch over the floor of the mouth, whose height rises behind the tip
/// and descends towards the throat.
pub(super) fn piece(fit: &Fit) -> Piece {
    let mut piece = Piece::new(Chart::Tongue);
    let half_width = fit.half_width - 10.5;
    let base_y = fit.floor_y - 2.0;
    let mut rows: Vec<Vec<(Knot, [f32; 2])>> = Vec::new();
    for row in 0..=ALONG {
        let along = row as f32 / ALONG as f32;
        // Round at the tip, highest in the middle, descending towards the throat.
        let round = (1.0 - (1.0 - (along / 0.45).min(1.0)).powi(2)).sqrt();
        let top = -2.2 + 4.0 * smoothstep(0.05, 0.4, along)
            - 4.0 * (1.0 - round)
            - 6.0 * smoothstep(0.5, 1.0, along);
        let width = half_width * (0.12 + 0.88 * round);
        let z = fit.front_z - TIP_MM - LENGTH_MM * along;
        let knots = (0..=ACROSS).map(|column| {
            let across = column as f32 / ACROSS as f32;
            let (sin, cos) = (PI * across).sin_cos();
            let sin = sin.max(0.0);
            // A shallow groove along the middle.
            let groove = 1.3 * round * (-(cos / 0.25).powi(2)).exp();
            let y = base_y + (top - base_y) * sin.powf(0.55) - groove;
            // The tip curls down to the floor.
            let z = z + if row == 0 { -1.5 * (1.0 - sin) } else { 0.0 };
            let position = Vec3::new(-width * cos, y, z);
            (piece.point(Point { position, lower: 1.0, rim: None }), [across, along])
        });
        let knots = knots.collect();
        rows.push(knots);
    }
    // The front goes down to the floor under the tip.
    let tip: Vec<(Knot, [f32; 2])> = (0..=ACROSS)
        .map(|column| {
            let across = column as f32 / ACROSS as f32;
            let cos = (PI * across).cos();
            let position = Vec3::new(-0.1 * half_width * cos, base_y, fit.front_z - TIP_MM - 1.0);
            (piece.point(Point { position, lower: 1.0, rim: None }), [across, 0.0])
        })
        .collect();
    rows.insert(0, tip);
    // The front gets its share of the chart, too.
    let count = rows.len() - 1;
    for (row, knots) in rows.iter_mut().enumerate() {
        knots.iter_mut().for_each(|(_, at)| at[1] = row as f32 / count as f32);
    }
    piece.grid(&rows, false);
    piece
}
