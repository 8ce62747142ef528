//! Depth maps: how near the nearest surface is, at every sample or at a grid of them.

use std::iter;

use uvgraft::{Size, threads};

use super::projection::Projected;

/// Rows of samples per task.
pub(crate) const BAND: u32 = 32;

/// Bands of most triangles. Those that touch more are listed once: a million that cover the screen would have
/// half a gigabyte of lists.
const FEW: u32 = 8;

/// Triangles on the screen, sorted into bands of rows.
#[derive(Debug)]
pub(crate) struct Drawing {
    parts: Vec<Projected>,
    /// Indices of the triangles that touch each band, in ascending order, without those that touch many.
    bands: Vec<Vec<u32>>,
    /// Indices of the triangles that touch more bands than [`FEW`], in ascending order.
    tall: Vec<u32>,
    pub size: Size,
}

impl Drawing {
    /// - `size`: the one that the triangles were projected to.
    pub fn new(parts: Vec<Projected>, size: Size) -> Self {
        let mut bands = vec![Vec::new(); size.height.div_ceil(BAND) as usize];
        let mut tall = Vec::new();
        for (index, part) in (0_u32..).zip(&parts) {
            let (first, last) = touched(part);
            if last - first < FEW {
                bands[first as usize..=last as usize].iter_mut().for_each(|band| band.push(index));
            } else {
                tall.push(index);
            }
        }
        Self { parts, bands, tall, size }
    }

    /// The triangles that touch a band, in the order in which they are drawn.
    pub fn band(&self, band: usize) -> impl Iterator<Item = &Projected> {
        let touches = move |&index: &u32| {
            let (first, last) = touched(&self.parts[index as usize]);
            (first as usize..=last as usize).contains(&band)
        };
        let own = self.bands.get(band).map_or(&[][..], Vec::as_slice).iter().copied();
        let tall = self.tall.iter().copied().filter(touches);
        in_order(own, tall).map(|index| &self.parts[index as usize])
    }
}

/// The first and the last band that a triangle touches.
fn touched(part: &Projected) -> (u32, u32) {
    let rows = part.scan.rows();
    (rows.start / BAND, (rows.end - 1) / BAND)
}

/// Merges two ascending sequences.
fn in_order(
    a: impl Iterator<Item = u32>,
    b: impl Iterator<Item = u32>,
) -> impl Iterator<Item = u32> {
    let (mut a, mut b) = (a.peekable(), b.peekable());
    iter::from_fn(move || match (a.peek(), b.peek()) {
        (Some(x), Some(y)) if y < x => b.next(),
        (Some(_), _) => a.next(),
        (None, _) => b.next(),
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tall_triangles_are_drawn_in_their_order() {
        let merged = |a: &[u32], b: &[u32]| -> Vec<u32> {
            in_order(a.iter().copied(), b.iter().copied()).collect()
        };
        assert_eq!(merged(&[1, 4, 5], &[0, 2, 6, 7]), [0, 1, 2, 4, 5, 6, 7]);
        assert_eq!((merged(&[], &[3]), merged(&[3], &[])), (vec![3], vec![3]));
    }
}
