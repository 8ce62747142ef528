//! Surfaces that one sees through, sample by sample: the nearest few in front of what is opaque.

use std::ops::Range;

use super::projection::Projected;
use super::visibility::{DepthBuffer, EMPTY};

/// Surfaces over each other that are kept; of more, the farthest are left out.
pub(crate) const MOST: usize = 6;

/// The layers of some rows of samples.
#[derive(Debug)]
pub(crate) struct Layers {
    rows: Range<u32>,
    width: usize,
    /// From the nearest to the farthest.
    layers: Vec<[Layer; MOST]>,
}

#[derive(Debug, Clone, Copy)]
struct Layer {
    depth: f32,
    face: u32,
}

const NONE: Layer = Layer { depth: f32::NEG_INFINITY, face: EMPTY };

impl Layers {
    /// - `indices`: of the triangles that touch the rows.
    /// - `least`: depth from which on something is seen.
    pub fn new<'a>(
        projected: &[Projected],
        indices: impl Iterator<Item = &'a u32>,
        opaque: &DepthBuffer,
        least: f32,
        rows: Range<u32>,
        width: usize,
    ) -> Self {
        let mut layers = vec![[NONE; MOST]; rows.len() * width];
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
                    // Of two at the same depth, what came first lies above.
                    let place = layers.partition_point(|layer| layer.depth >= depth);
                    if place < MOST {
                        layers[place..].rotate_right(1);
                        layers[place] = Layer { depth, face: part.face };
                    }
                }
            }
        }
        Self { rows, width, layers }
    }

    /// The faces over a sample, from the farthest to the nearest.
    pub fn over(&self, x: u32, y: u32) -> impl Iterator<Item = u32> {
        let sample = (y - self.rows.start) as usize * self.width + x as usize;
        self.layers[sample].iter().rev().map(|layer| layer.face).filter(|&face| face != EMPTY)
    }
}
