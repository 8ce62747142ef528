//! The visible triangle at every sample of a band of rows.

use std::ops::Range;

use super::depth::{BAND, Drawing, Holes};

/// No triangle.
pub(crate) const EMPTY: u32 = u32::MAX;

/// Depths and faces of the samples in one band: small enough to stay in a processor's cache, and
/// reused from band to band.
#[derive(Debug, Default)]
pub(crate) struct Samples {
    width: usize,
    first: u32,
    depths: Vec<f32>,
    faces: Vec<u32>,
    /// The columns in which anything was drawn.
    columns: Range<u32>,
}

impl Samples {
    /// Draws a band of rows.
    ///
    /// - `least`: smallest visible depth.
    pub fn draw(&mut self, drawing: &Drawing, band: usize, least: f32, holes: &impl Holes) {
        let (width, height) = (drawing.size.width as usize, drawing.size.height);
        let first = band as u32 * BAND;
        let rows = first..(first + BAND).min(height);
        self.clear(width, rows.len());
        self.first = first;
        for part in drawing.band(band) {
            for (row, span) in part.scan.spans(&rows) {
                if span.is_empty() {
                    continue;
                }
                let known = &self.columns;
                self.columns = known.start.min(span.start)..known.end.max(span.end);
                let ramp = part.depths(span.start, row, 1);
                let line = (row - first) as usize * width;
                let samples = line + span.start as usize..line + span.end as usize;
                let depths = &mut self.depths[samples.clone()];
                let faces = &mut self.faces[samples];
                let known = depths.iter_mut().zip(faces).enumerate();
                if holes.may_pierce(part.face) {
                    for (index, (known, face)) in known {
                        let depth = ramp.at(index as i32);
                        if depth > *known
                            && depth >= least
                            && holes.is_there(part.face, span.start + index as u32, row)
                        {
                            (*known, *face) = (depth, part.face);
                        }
                    }
                } else {
                    for (index, (known, face)) in known {
                        let depth = ramp.at(index as i32);
                        let nearer = depth > *known && depth >= least;
                        *known = if nearer { depth } else { *known };
                        *face = if nearer { part.face } else { *face };
                    }
                }
            }
        }
    }

    /// Removes what was drawn before, which is all within `columns`.
    fn clear(&mut self, width: usize, rows: usize) {
        let columns = self.columns.start as usize..self.columns.end as usize;
        if self.width != width || self.depths.len() != width * rows {
            (self.depths, self.faces) = (Vec::new(), Vec::new());
            self.depths.resize(width * rows, f32::NEG_INFINITY);
            self.faces.resize(width * rows, EMPTY);
            self.width = width;
        } else if !columns.is_empty() {
            for (depths, faces) in
                self.depths.chunks_exact_mut(width).zip(self.faces.chunks_exact_mut(width))
            {
                depths[columns.clone()].fill(f32::NEG_INFINITY);
                faces[columns.clone()].fill(EMPTY);
            }
        }
        self.columns = Range { start: u32::MAX, end: 0 };
    }

    /// The columns in which anything was drawn.
    pub fn columns(&self) -> Range<u32> {
        self.columns.clone()
    }

    /// Faces of consecutive samples in a row of the picture.
    #[inline]
    pub fn faces(&self, x: u32, y: u32, count: u32) -> &[u32] {
        &self.faces[(y - self.first) as usize * self.width + x as usize..][..count as usize]
    }

    #[inline]
    pub fn depth(&self, x: u32, y: u32) -> f32 {
        self.depths[(y - self.first) as usize * self.width + x as usize]
    }
}
