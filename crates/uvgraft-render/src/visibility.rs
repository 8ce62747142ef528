//! The visible triangle at every sample, and screen-space ambient occlusion.

use std::f32::consts::TAU;

use uvgraft::easing::smoothstep;
use uvgraft::{Size, threads};
use uvgraft_avatar::paint::noise::random;

use super::camera::Camera;
use super::projection::Projected;

/// No triangle.
pub(crate) const EMPTY: u32 = u32::MAX;

#[derive(Debug)]
pub(crate) struct DepthBuffer {
    size: Size,
    depths: Vec<f32>,
    faces: Vec<u32>,
}

/// Rows per task.
pub(crate) const BAND: u32 = 32;

/// The triangles that touch each band of rows, in ascending index order.
pub(crate) fn bands(projected: &[Projected], height: u32) -> Vec<Vec<u32>> {
    let mut bands = vec![Vec::new(); height.div_ceil(BAND) as usize];
    for (index, part) in projected.iter().enumerate() {
        let rows = part.scan.rows();
        for band in rows.start / BAND..=(rows.end - 1) / BAND {
            bands[band as usize].push(index as u32);
        }
    }
    bands
}

impl DepthBuffer {
    /// - `least`: smallest visible depth.
    /// - `is_there`: whether a face is solid at a sample, for alpha masks.
    pub fn new(
        projected: &[Projected],
        size: Size,
        least: f32,
        is_there: impl Fn(u32, u32, u32) -> bool + Sync,
    ) -> Self {
        let bands = bands(projected, size.height);
        let width = size.width as usize;
        let mut depths = vec![f32::NEG_INFINITY; size.texels()];
        let mut owners = vec![EMPTY; size.texels()];
        let samples = width * BAND as usize;
        let pieces = depths.chunks_mut(samples).zip(owners.chunks_mut(samples)).zip(&bands);
        threads::for_each(pieces, |band, ((depths, owners), indices)| {
            let first = band as u32 * BAND;
            let rows = first..(first + BAND).min(size.height);
            for &index in indices {
                let part = &projected[index as usize];
                for (row, span) in part.scan.spans(&rows) {
                    for column in span {
                        let depth = part.depth(column, row);
                        let sample = (row - first) as usize * width + column as usize;
                        if depth > depths[sample]
                            && depth >= least
                            && is_there(part.face, column, row)
                        {
                            depths[sample] = depth;
                            owners[sample] = part.face;
                        }
                    }
                }
            }
        });
        Self { size, depths, faces: owners }
    }

    pub fn face(&self, x: u32, y: u32) -> u32 {
        self.faces[(y * self.size.width + x) as usize]
    }

    /// Depth at a sample; empty samples are infinitely far away. Coordinates are clamped to the
    /// edge.
    pub fn depth(&self, x: i32, y: i32) -> f32 {
        let x = x.clamp(0, self.size.width as i32 - 1) as usize;
        let y = y.clamp(0, self.size.height as i32 - 1) as usize;
        self.depths[y * self.size.width as usize + x]
    }

    /// Screen-space ambient occlusion for each pixel of a coarser picture of the same view: 1 where
    /// nothing is in front, towards 0 in folds.
    ///
    /// Each pixel compares its depth with 14 taps on a spiral around it (golden-angle steps of 2.4
    /// radians), out to about 5 cm. The fraction it loses grows with the slope from pixel to tap.
    /// Each pixel of a 4 × 4 tile rotates the spiral by another random angle, and a blur over the
    /// tile then averages the pattern away.
    ///
    /// - `metre`: length of one metre in mesh units.
    pub fn occlusion(&self, camera: &Camera, metre: f32, size: Size) -> Vec<f32> {
        const TAPS: usize = 14;
        let scale = (self.size.width / size.width) as i32;
        let mut open = vec![1.0; size.texels()];
        threads::for_each_chunk(&mut open, size.width as usize, |y, row| {
            for (x, open) in row.iter_mut().enumerate() {
                let (cx, cy) = (x as i32 * scale, y as i32 * scale);
                let depth = self.depth(cx, cy);
                if depth == f32::NEG_INFINITY {
                    continue;
                }
                let here = camera.height_of(depth);
                let unit_per_px = camera.unit_per_px(depth);
                let turn = random((x % 4) as i32, (y % 4) as i32, 0, 101) * TAU;
                let mut hidden = 0.0;
                for tap in 0..TAPS {
                    let angle = turn + tap as f32 * 2.4;
                    // Radii from a few millimetres to a few centimetres.
                    let reach = metre * (0.004 + 0.05 * ((tap as f32 + 0.5) / TAPS as f32).powi(2));
                    let steps = reach / unit_per_px;
                    let there = camera.height_of(self.depth(
                        cx + (angle.cos() * steps) as i32,
                        cy + (angle.sin() * steps) as i32,
                    ));
                    let rise = (there - here) / reach;
                    // Surfaces far in front do not occlude.
                    hidden += smoothstep(0.15, 1.3, rise) * smoothstep(4.0, 2.0, rise);
                }
                *open = 1.0 - hidden / TAPS as f32;
            }
        });
        self.smoothed(&open, camera, 0.008 * metre, scale, size)
    }

    /// Averages over the 4 × 4 pixels in which the tap rotation repeats, skipping pixels at another
    /// depth (by `near` or more) so that silhouettes do not bleed.
    fn smoothed(
        &self,
        open: &[f32],
        camera: &Camera,
        near: f32,
        scale: i32,
        size: Size,
    ) -> Vec<f32> {
        let height = |x: i32, y: i32| camera.height_of(self.depth(x * scale, y * scale));
        let mut result = vec![1.0; size.texels()];
        threads::for_each_chunk(&mut result, size.width as usize, |y, row| {
            for (x, result) in row.iter_mut().enumerate() {
                let here = height(x as i32, y as i32);
                if here == f32::NEG_INFINITY {
                    continue;
                }
                let (mut sum, mut count) = (0.0, 0.0);
                for py in (y as i32 - 2).max(0)..(y as i32 + 2).min(size.height as i32) {
                    for px in (x as i32 - 2).max(0)..(x as i32 + 2).min(size.width as i32) {
                        if (height(px, py) - here).abs() < near {
                            sum += open[py as usize * size.width as usize + px as usize];
                            count += 1.0;
                        }
                    }
                }
                *result = sum / f32::max(count, 1.0);
            }
        });
        result
    }
}
