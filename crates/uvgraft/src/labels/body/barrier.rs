//! Barriers along long colour edges, with gaps closed.

use super::super::geodesic::{parts, widened};
use super::layout::BodyLayout;

/// Lower hysteresis threshold: edges continue while their steepness is above this fraction of
/// noise. At 0.28, 31 % of the real body's skin is lost; at 1.1, 60 % of the beige shirt becomes
/// skin (the bodies of `decide`).
pub(super) const FAINT: f32 = 0.55;

/// Upper hysteresis threshold: an edge must exceed noise by this somewhere, in ΔE per texel. At
/// 0.18, 11 % of the skin in the brown shirt is lost and 5 % of the real body's; at 0.7, 99.5 % of
/// that in the beige shirt is found, not 88.8 %, and nothing else changes.
const MIN_HEIGHT: f32 = 0.35;
/// Least length of an edge and half of the gaps closed in it, both in texels. Edges have gaps where
/// cloth meets a darker area of skin of the same colour; the longer an edge, the less likely it is
/// chance. Flat from half to twice the least length of all, and either width.
const GAPS: [(usize, usize); 2] = [(40, 3), (150, 10)];
/// The same for the wide barrier, which growing skin must not leak through. At 12, 60 % of the
/// beige shirt becomes skin; at 48, 80 % of the skin in the pink shirt is found, not 90 %, and 95 %
/// of the real body's.
const WIDE_GAP: (usize, usize) = (100, 24);

/// The texels close to long edges.
#[derive(Debug, Clone)]
pub(super) struct Barrier {
    /// Within the half gap widths of [`GAPS`].
    pub narrow: Vec<bool>,
    /// The same, and within that of [`WIDE_GAP`], which closes gaps of some centimetres.
    pub wide: Vec<bool>,
}

/// Marks the texels close to edges that are too long to be noise. Edges are traced with
/// hysteresis: faint texels continue stronger ones (J. Canny, "A computational approach to
/// edge detection", PAMI 1986).
///
/// - `edges`: the steepness at each texel, in ΔE per texel.
pub(super) fn barrier(body: &BodyLayout, edges: &[f32], noise: f32) -> Barrier {
    let grid = &body.grid;
    let is_edge: Vec<bool> = edges
        .iter()
        .zip(&body.bits)
        .map(|(&edge, bits)| edge > FAINT * noise && !bits.is_feature())
        .collect();
    let mut long = parts(grid, &is_edge);
    long.retain(|part| {
        let heights = part.iter().map(|&texel| edges[texel as usize] - noise);
        part.len() >= GAPS[0].0 && heights.fold(0.0, f32::max) >= MIN_HEIGHT
    });
    let mut narrow = vec![false; edges.len()];
    let mark = |all: &mut [bool], (least, gap): (usize, usize)| {
        let part = long.iter().filter(|part| part.len() >= least).flatten().copied();
        for texel in widened(grid, part, gap) {
            all[texel as usize] = true;
        }
    };
    GAPS.into_iter().for_each(|gap| mark(&mut narrow, gap));
    let mut wide = narrow.clone();
    mark(&mut wide, WIDE_GAP);
    Barrier { narrow, wide }
}
