//! Translucent surfaces, sample by sample: the nearest few in front of the opaque one.

use std::ops::Range;

use super::depth::{BAND, Drawing};
use super::samples::Samples;

/// Layers kept at a sample; if there are more, the farthest are dropped.
pub(crate) const MAX_LAYERS: usize = 6;

/// The layers of one band of sample rows, reused from band to band.
#[derive(Debug, Default)]
pub(crate) struct Layers {
    width: usize,
    first: u32,
    /// For each sample, the number of its layers.
    counts: Vec<u8>,
    /// For each sample, from nearest to farthest; what is beyond the number is left over.
    layers: Vec<[Layer; MAX_LAYERS]>,
    /// The columns in which anything was drawn.
    columns: Range<u32>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Layer {
    depth: f32,
    face: u32,
}

impl Layers {
    /// Draws a band of rows.
    ///
    /// - `opaque`: the same band.
    /// - `least`: smallest visible depth.
    pub fn draw(&mut self, drawing: &Drawing, band: usize, least: f32, opaque: &Samples) {
        self.counts.fill(0);
        self.columns = Range { start: u32::MAX, end: 0 };
        let mut parts = drawing.band(band).peekable();
        if parts.peek().is_none() {
            return;
        }
        let (width, height) = (drawing.size.width as usize, drawing.size.height);
        let first = band as u32 * BAND;
        let rows = first..(first + BAND).min(height);
        (self.width, self.first) = (width, first);
        self.counts.resize(width * rows.len(), 0);
        self.layers.resize(width * rows.len(), [Layer::default(); MAX_LAYERS]);
        for part in parts {
            for (row, span) in part.scan.spans(&rows) {
                if span.is_empty() {
                    continue;
                }
                let known = &self.columns;
                self.columns = known.start.min(span.start)..known.end.max(span.end);
                let ramp = part.depths(span.start, row, 1);
                for (index, column) in span.enumerate() {
                    let depth = ramp.at(index as i32);
                    if depth <= opaque.depth(column, row) || depth < least {
                        continue;
                    }
                    let sample = (row - first) as usize * width + column as usize;
                    let (layers, count) = (&mut self.layers[sample], &mut self.counts[sample]);
                    let known = usize::from(*count);
                    // At equal depth, the triangle that was drawn first is in front.
                    let slot = layers[..known].partition_point(|layer| layer.depth >= depth);
                    if slot < MAX_LAYERS {
                        let known = (known + 1).min(MAX_LAYERS);
                        layers[slot..known].rotate_right(1);
                        layers[slot] = Layer { depth, face: part.face };
                        *count = known as u8;
                    }
                }
            }
        }
    }

    /// The columns in which anything was drawn.
    pub fn columns(&self) -> Range<u32> {
        self.columns.clone()
    }

    /// Whether consecutive samples in a row of the picture have any layers.
    pub fn any(&self, x: u32, y: u32, count: u32) -> bool {
        let sample = (y - self.first) as usize * self.width + x as usize;
        self.counts[sample..][..count as usize].iter().any(|&count| count > 0)
    }

    /// Whether two samples have the same faces in the same order.
    pub fn same(&self, a: (u32, u32), b: (u32, u32)) -> bool {
        self.over(a.0, a.1).eq(self.over(b.0, b.1))
    }

    /// The faces at a sample, from farthest to nearest.
    pub fn over(&self, x: u32, y: u32) -> impl Iterator<Item = u32> {
        let sample = (y - self.first) as usize * self.width + x as usize;
        let known = usize::from(self.counts[sample]);
        self.layers[sample][..known].iter().rev().map(|layer| layer.face)
    }
}
