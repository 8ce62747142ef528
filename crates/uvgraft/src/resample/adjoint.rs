//! The transpose of resampling: every sample gives its value back to the texels that it was made of.
//!
//! Bands of the source are worked on one by one or at once; each looks at the runs that read it, in
//! the target's order, so sums do not depend on threads.

use super::position::{containing, fraction, near_texture, split};
use super::{Paths, Walk};
use crate::filter::{Bilinear, CatmullRom, Filter, Lanczos3, MAX_TAPS, Nearest, Taps};
use crate::map::{Run, SamplingMap};
use crate::texture::Size;
use crate::threads::for_each_chunk;

/// Rows of the source in a band.
const BAND: u32 = 32;

/// Longer runs are cut, so that a piece reads few bands.
const PIECE: u32 = 64;

/// A run, or a part of one, and its row.
#[derive(Debug, Clone, Copy)]
struct Piece {
    row: u32,
    run: Run,
}

/// Which pieces of a map read which band of a source.
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

    /// Adds to every texel of `source` what the target's values give back to it.
    ///
    /// - `source`: `[height * width * C]` values of the size that this was made for.
    /// - `target`: `[height * width * C]` values of the map's size.
    pub fn gather<const C: usize>(&self, map: &SamplingMap, target: &[f32], source: &mut [f32]) {
        match self.filter {
            Filter::Nearest => self.gather_with::<C, Nearest>(map, target, source),
            Filter::Bilinear => self.gather_with::<C, Bilinear>(map, target, source),
            Filter::CatmullRom => self.gather_with::<C, CatmullRom>(map, target, source),
            Filter::Lanczos3 => self.gather_with::<C, Lanczos3>(map, target, source),
        }
    }

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
            // A texel may be part of thousands of samples: 32 bits would lose what each adds.
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

/// The parts of a run that are worked on by themselves.
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

/// Rows of the source that are added to.
struct Band<'a, const C: usize> {
    sums: &'a mut [f64],
    width: i32,
    first_row: i32,
}

impl<const C: usize> Band<'_, C> {
    /// Adds a value to the window around a position, as far as it lies in the band.
    #[inline(always)]
    fn add<F: Taps>(&mut self, position: [i64; 2], value: [f32; C], source: Size) {
        let before = (F::TAPS as i32 - 1) / 2;
        let (y, fraction_y) = place::<F>(position[1], source.height);
        let band_rows = (self.sums.len() / C) as i32 / self.width;
        // Beyond the texture's edge its edge was read.
        let row_of = |b: i32| (y - before + b).clamp(0, source.height as i32 - 1) - self.first_row;
        if row_of(F::TAPS as i32 - 1) < 0 || row_of(0) >= band_rows {
            return;
        }
        let (x, fraction_x) = place::<F>(position[0], source.width);
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

/// The texel before a position and how far beyond it the position lies; for one tap the texel that
/// contains it.
#[inline(always)]
fn place<F: Taps>(position: i64, count: u32) -> (i32, f32) {
    let near = near_texture(position, count);
    if F::TAPS == 1 {
        return (containing(near), 0.0);
    }
    let (texel, bits) = split(near);
    (texel, fraction(bits))
}
