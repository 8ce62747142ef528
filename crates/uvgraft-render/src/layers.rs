//! Translucent surfaces, sample by sample: the nearest few in front of the opaque one.

use std::ops::Range;

use super::projection::Projected;
use super::visibility::{DepthBuffer, EMPTY};

/// Layers kept at a sample; if there are more, the farthest are dropped.
pub(crate) const MAX_LAYERS: usize = 6;

/// The layers of a range of sample rows.
#[derive(Debug)]
pub(crate) struct Layers {
    rows: Range<u32>,
    width: usize,
    /// For each sample, from nearest to farthest.
    layers: Vec<[Layer; MAX_LAYERS]>,
}

#[derive(Debug, Clone, Copy)]
struct Layer {
    depth: f32,
    face: u32,
}

const NONE: Layer = Layer { depth: f32::NEG_INFINITY, face: EMPTY };

impl Layers {
    /// - `indices`: triangles that touch the rows.
    /// - `least`: smallest visible depth.
    pub fn new<'a>(
        projected: &[Projected],
        indices: impl Iterator<Item = &'a u32>,
        opaque: &DepthBuffer,
        least: f32,
        rows: Range<u32>,
        width: usize,
    ) -> Self {
        let mut layers = vec![[NONE; MAX_LAYERS]; rows.len() * width];
        for &index in indices {
            let part = &projected[index as usize];
            for (row, span) in part.scan.spans(&rows) {
                for column in span {
                    let depth = part.depth(column, row);
                    if depth <= opaque.depth(column as i32, row as i32) || depth < least {
                        continue;
                    }
                    let sample = (row - rows.start) as usize * width + column as usize;
                    let layers = &mut layers[sample];
                    // At equal depth, the triangle that was drawn first is in front.
                    let slot = layers.partition_point(|layer| layer.depth >= depth);
                    if slot < MAX_LAYERS {
                        layers[slot..].rotate_right(1);
                        layers[slot] = Layer { depth, face: part.face };
                    }
                }
            }
        }
        Self { rows, width, layers }
    }

    /// The faces at a sample, from farthest to nearest.
    pub fn over(&self, x: u32, y: u32) -> impl Iterator<Item = u32> {
        let sample = (y - self.rows.start) as usize * self.width + x as usize;
        self.layers[sample].iter().rev().map(|layer| layer.face).filter(|&face| face != EMPTY)
    }
}
