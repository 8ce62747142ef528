//! The transpose of resampling: every sample distributes its value to the texels that it
//! was filtered from.
//!
//! With `target[t] = Σ w·source[s]`, it computes `source[s] += Σ w·target[t]`. Scattering target
//! rows in parallel would race on source texels. So each work item owns a band of source rows and
//! gathers from the runs that read it, in the order of the target, and sums do not depend on the
//! number of threads.

use uvgraft_surface::threads::for_each_chunk;

use super::position::{containing, fraction, near_texture, split};
use super::{Paths, Walk};
use crate::filter::{Bilinear, CatmullRom, Filter, Lanczos3, MAX_TAPS, Nearest, Taps};
use crate::map::{Run, SamplingMap};
use crate::texture::Size;

/// Source rows per band.
const BAND: u32 = 32;

/// Longer runs are split, so that each piece reads few bands.
const PIECE: u32 = 64;

/// A run or a part of one, with its row.
#[derive(Debug, Clone, Copy)]
struct Piece {
    row: u32,
    run: Run,
}

/// For each band of a source, the pieces of a map that read it.
#[derive(Debug, Clone)]
pub(crate) struct Schedule {
    bands: Vec<Vec<Piece>>,
    source: Size,
    filter: Filter,
}

impl Schedule {
    pub fn new(map: &SamplingMap, source: Size, filter: Filter) -> Self {
        let paths = Paths::new(map, source, filter);
        let mut bands = vec![Vec::new(); source.height.div_ceil(BAND) as usize];
        for row in 0..map.size().height {
            for run in map.row(row).iter().copied().flat_map(cut) {
                let [first, last] = rows_read(&paths.walk(row, run), run.len, source);
                for band in &mut bands[(first / BAND) as usize..=(last / BAND) as usize] {
                    band.push(Piece { row, run });
                }
            }
        }
        Self { bands, source, filter }
    }

    /// Adds the transpose of resampling, applied to `target`, to `source`.
    ///
    /// - `source`: `[height * width * C]` values of the schedule's source size.
    /// - `target`: `[height * width * C]` values of the map's size.
    pub fn gather<const C: usize>(&self, map: &SamplingMap, target: &[f32], source: &mut [f32]) {
        match self.filter {
            Filter::Nearest => self.gather_with::<C, Nearest>(map, target, source),
            Filter::Bilinear => self.gather_with::<C, Bilinear>(map, target, source),
            Filter::CatmullRom => self.gather_with::<C, CatmullRom>(map, target, source),
            Filter::Lanczos3 => self.gather_with::<C, Lanczos3>(map, target, source),
        }
    }

    /// [`Schedule::gather`], compiled for one filter.
    fn gather_with<const C: usize, F: Taps>(
        &self,
        map: &SamplingMap,
        target: &[f32],
        source: &mut [f32],
    ) {
        let paths = Paths::new(map, self.source, self.filter);
        let (width, target_width) = (self.source.width as usize, map.size().width as usize);
        for_each_chunk(source, width * C * BAND as usize, |index, values| {
            let first_row = index as u32 * BAND;
            // A texel may contribute to thousands of samples: 32-bit sums would lose small terms.
            let mut sums = vec![0.0; values.len()];
            let mut band =
                Band::<C> { sums: &mut sums, width: width as i32, first_row: first_row as i32 };
            for &Piece { row, run } in &self.bands[index] {
                let walk = paths.walk(row, run);
                let [columns, rows] = walk.samples();
                let share = 1.0 / (columns * rows) as f32;
                let first = (row as usize * target_width + run.x as usize) * C;
                let texels = target[first..first + run.len as usize * C].chunks_exact(C);
                for (k, texel) in (0..).zip(texels) {
                    let value: [f32; C] = std::array::from_fn(|channel| texel[channel] * share);
                    for b in 0..rows {
                        for a in 0..columns {
                            band.add::<F>(walk.sample(k, a, b), value, self.source);
                        }
                    }
                }
            }
            for (value, sum) in values.iter_mut().zip(sums) {
                *value = (f64::from(*value) + sum) as f32;
            }
        });
    }
}

/// Splits a run into parts of at most [`PIECE`] texels.
fn cut(run: Run) -> impl Iterator<Item = Run> {
    let end = run.x + run.len;
    (run.x..end).step_by(PIECE as usize).map(move |x| Run {
        x,
        len: PIECE.min(end - x),
        patch: run.patch,
    })
}

/// The first and the last row that the windows of a run may touch.
fn rows_read(walk: &Walk<'_>, len: u32, source: Size) -> [u32; 2] {
    let ends = [walk.centre(0), walk.centre(len - 1)].map(|at| near_texture(at[1], source.height));
    let reach = walk.reach()[1];
    let row = |y: i64| containing(y).clamp(0, source.height as i32 - 1) as u32;
    [row(ends[0].min(ends[1]) - reach), row(ends[0].max(ends[1]) + reach)]
}

/// A band of source rows that accumulates values.
struct Band<'a, const C: usize> {
    sums: &'a mut [f64],
    width: i32,
    first_row: i32,
}

impl<const C: usize> Band<'_, C> {
    /// Adds a weighted value to the window around a position, clipped to the band.
    #[inline(always)]
    fn add<F: Taps>(&mut self, position: [i64; 2], value: [f32; C], source: Size) {
        let before = (F::TAPS as i32 - 1) / 2;
        let (y, fraction_y) = locate::<F>(position[1], source.height);
        let band_rows = (self.sums.len() / C) as i32 / self.width;
        // Taps beyond the texture were read from its edge texels.
        let row_of = |b: i32| (y - before + b).clamp(0, source.height as i32 - 1) - self.first_row;
        if row_of(F::TAPS as i32 - 1) < 0 || row_of(0) >= band_rows {
            return;
        }
        let (x, fraction_x) = locate::<F>(position[0], source.width);
        let (weights_x, weights_y) = (F::weights(fraction_x), F::weights(fraction_y));
        let mut across = [0.0; MAX_TAPS * 4];
        let across = &mut across[..F::TAPS * C];
        for (a, weight) in weights_x[..F::TAPS].iter().enumerate() {
            for channel in 0..C {
                across[a * C + channel] = weight * value[channel];
            }
        }
        let left = x - before;
        let inside = left >= 0 && left + F::TAPS as i32 <= self.width;
        for (b, weight) in (0..).zip(&weights_y[..F::TAPS]) {
            let row = row_of(b);
            if !(0..band_rows).contains(&row) {
                continue;
            }
            let row = &mut self.sums[(row * self.width) as usize * C..][..self.width as usize * C];
            if inside {
                for (texel, across) in row[left as usize * C..].iter_mut().zip(&*across) {
                    *texel += f64::from(across * weight);
                }
            } else {
                for (a, across) in (0..).zip(across.chunks_exact(C)) {
                    let column = (left + a).clamp(0, self.width - 1) as usize;
                    for channel in 0..C {
                        row[column * C + channel] += f64::from(across[channel] * weight);
                    }
                }
            }
        }
    }
}

/// The texel before a position and the position's distance from its centre; with one tap, the texel
/// that contains the position.
#[inline(always)]
fn locate<F: Taps>(position: i64, count: u32) -> (i32, f32) {
    let near = near_texture(position, count);
    if F::TAPS == 1 {
        return (containing(near), 0.0);
    }
    let (texel, bits) = split(near);
    (texel, fraction(bits))
}
