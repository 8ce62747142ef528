//! Long edges of colour, without gaps.

use super::super::geodesic::{parts, widened};
use super::layout::BodyLayout;

/// An edge goes on where it is as steep as this share of noise.
pub(super) const FAINT: f32 = 0.55;

/// The least height that an edge has somewhere, in ΔE from a texel to the next beyond noise.
const LEAST_HEIGHT: f32 = 0.35;
/// The least numbers of texels of edges, and the half of gaps in them that are closed: where cloth's colour meets
/// that of a darker place of the skin, an edge has gaps, and the longer it is the less is it chance.
const GAPS: [(usize, usize); 2] = [(40, 3), (150, 10)];
/// The same for the way that skin takes, which must not slip through.
const WIDE_GAP: (usize, usize) = (100, 24);

/// What is close to edges.
#[derive(Debug, Clone)]
pub(super) struct Barrier {
    /// As close as edges are sure to be.
    pub narrow: Vec<bool>,
    /// So close that gaps of some centimetres are closed.
    pub wide: Vec<bool>,
}

/// What is close to edges that are long enough not to be noise. Faint texels continue higher ones (J. Canny, "A
/// computational approach to edge detection", PAMI 1986).
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
        part.len() >= GAPS[0].0 && heights.fold(0.0, f32::max) >= LEAST_HEIGHT
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
