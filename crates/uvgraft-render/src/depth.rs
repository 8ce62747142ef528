//! Depth maps: how near the nearest surface is, at every sample or at a grid of them.

use uvgraft::{Size, threads};

use super::projection::Projected;

/// Rows of samples per task.
pub(crate) const BAND: u32 = 32;

/// Triangles on the screen, sorted into bands of rows.
#[derive(Debug)]
pub(crate) struct Drawing {
    parts: Vec<Projected>,
    /// Indices of the triangles that touch each band, in ascending order.
    bands: Vec<Vec<u32>>,
    pub size: Size,
}

impl Drawing {
    /// - `size`: the one that the triangles were projected to.
    pub fn new(parts: Vec<Projected>, size: Size) -> Self {
        let mut bands = vec![Vec::new(); size.height.div_ceil(BAND) as usize];
        for (index, part) in parts.iter().enumerate() {
            let rows = part.scan.rows();
            for band in rows.start / BAND..=(rows.end - 1) / BAND {
                bands[band as usize].push(index as u32);
            }
        }
        Self { parts, bands, size }
    }

    /// The triangles that touch a band, in the order in which they are drawn.
    pub fn band(&self, band: usize) -> impl ExactSizeIterator<Item = &Projected> {
        let indices = self.bands.get(band).map_or(&[][..], Vec::as_slice);
        indices.iter().map(|&index| &self.parts[index as usize])
    }
}

/// Where triangles have holes.
pub(crate) trait Holes: Sync {
    /// Whether a face may have holes.
    fn may_pierce(&self, face: u32) -> bool;

    /// Whether a face is solid at a sample.
    fn is_there(&self, face: u32, x: u32, y: u32) -> bool;
}

/// No holes.
#[derive(Debug)]
pub(crate) struct Whole;

impl Holes for Whole {
    fn may_pierce(&self, _: u32) -> bool {
        false
    }

    fn is_there(&self, _: u32, _: u32, _: u32) -> bool {
        true
    }
}

/// The depth of the nearest surface. Where there is none it is infinitely far away.
#[derive(Debug)]
pub(crate) struct DepthMap {
    pub size: Size,
    depths: Vec<f32>,
}

impl DepthMap {
    /// - `step`: distance between samples of the map, in samples of the drawing; divides [`BAND`].
    /// - `least`: smallest visible depth.
    pub fn new(drawing: &Drawing, step: u32, least: f32, holes: &impl Holes) -> Self {
        let Size { width, height } = drawing.size;
        let size = Size::new(width.div_ceil(step), height.div_ceil(step));
        let width = size.width as usize;
        let mut depths = vec![f32::NEG_INFINITY; size.texels()];
        threads::for_each_chunk(&mut depths, width * (BAND / step) as usize, |band, depths| {
            let first = band as u32 * BAND;
            let rows = first..(first + BAND).min(height);
            for part in drawing.band(band) {
                for (row, span) in part.scan.spans(&rows).filter(|(row, _)| row % step == 0) {
                    let (from, to) = (span.start.div_ceil(step), span.end.div_ceil(step));
                    let ramp = part.depths(from * step, row, step);
                    let line = ((row - first) / step) as usize * width;
                    let depths = &mut depths[line + from as usize..line + to as usize];
                    if holes.may_pierce(part.face) {
                        for (index, known) in depths.iter_mut().enumerate() {
                            let depth = ramp.at(index as i32);
                            let x = (from + index as u32) * step;
                            if depth > *known && depth >= least && holes.is_there(part.face, x, row)
                            {
                                *known = depth;
                            }
                        }
                    } else {
                        for (index, known) in depths.iter_mut().enumerate() {
                            let depth = ramp.at(index as i32);
                            *known = if depth > *known && depth >= least { depth } else { *known };
                        }
                    }
                }
            }
        });
        Self { size, depths }
    }

    /// Coordinates are clamped to the edge.
    #[inline]
    pub fn depth(&self, x: i32, y: i32) -> f32 {
        let x = x.clamp(0, self.size.width as i32 - 1) as usize;
        let y = y.clamp(0, self.size.height as i32 - 1) as usize;
        self.depths[y * self.size.width as usize + x]
    }

    pub fn row(&self, y: u32) -> &[f32] {
        let width = self.size.width as usize;
        &self.depths[y as usize * width..][..width]
    }
}
