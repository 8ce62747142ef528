//! The specification of resampling that every faster path is tested against. Written to be
//! read; never tuned.
//!
//! It shares with the fast paths where samples lie (`Walk`), the filters' formulas, and how levels
//! are stored. What is done with the texels there, in floats and in integers, is written out.

use super::position::{containing, fraction, near_texture, split};
use super::{Paths, Walk, load, store};
use crate::filter::{Filter, MAX_TAPS};
use crate::map::SamplingMap;
use crate::texture::{Size, Value};

/// Fills the texels of a target that a map reaches from a source.
///
/// - `source`: `[height * width * C]` values of a texture of `source_size`.
/// - `target`: `[height * width * C]` values of a texture of the map's size.
///
/// With `ALPHA` the last channel is alpha: colours are filtered premultiplied and composited over
/// the target. Without it, values replace those of the target. Taps beyond the source read its edge
/// texels. 8-bit values without alpha are filtered in integers (`WholeFilter`), which round as exact
/// arithmetic does except within 1/16 level of a tie.
///
/// # Panics
/// If a buffer is too short.
pub fn resample<T: Value, const C: usize, const ALPHA: bool>(
    map: &SamplingMap,
    source: &[T],
    source_size: Size,
    target: &mut [T],
    filter: Filter,
) {
    let width = map.size().width as usize;
    let whole = WholeFilter::new(filter);
    let paths = Paths::new(map, source_size, filter);
    for row in 0..map.size().height {
        for &run in map.row(row) {
            let walk = paths.walk(row, run);
            for k in 0..run.len {
                let levels = match T::as_bytes(source) {
                    Some(source) if !ALPHA && filter != Filter::Nearest => {
                        whole.average::<C>(&walk, k, source, source_size).map(f32::from)
                    }
                    _ => average::<T, C, ALPHA>(&walk, k, source, source_size, filter),
                };
                let texel = row as usize * width + (run.x + k) as usize;
                store::<T, C, ALPHA>(levels, &mut target[texel * C..][..C]);
            }
        }
    }
}

/// The mean of a texel's samples.
fn average<T: Value, const C: usize, const ALPHA: bool>(
    walk: &Walk<'_>,
    k: u32,
    source: &[T],
    size: Size,
    filter: Filter,
) -> [f32; C] {
    let [columns, rows] = walk.samples();
    let mut sum = [0.0; C];
    for b in 0..rows {
        for a in 0..columns {
            let value = sample::<T, C, ALPHA>(source, size, walk.sample(k, a, b), filter);
            for channel in 0..C {
                sum[channel] += value[channel];
            }
        }
    }
    let share = 1.0 / (columns * rows) as f32;
    sum.map(|total| total * share)
}

/// The value at one position: texels are filtered down each column first, then across columns.
fn sample<T: Value, const C: usize, const ALPHA: bool>(
    source: &[T],
    size: Size,
    position: [i64; 2],
    filter: Filter,
) -> [f32; C] {
    let texel = |x: i32, y: i32| -> [f32; C] {
        let x = x.clamp(0, size.width as i32 - 1) as usize;
        let y = y.clamp(0, size.height as i32 - 1) as usize;
        load::<T, C, ALPHA>(&source[(y * size.width as usize + x) * C..])
    };
    let position = [near_texture(position[0], size.width), near_texture(position[1], size.height)];
    if filter == Filter::Nearest {
        return texel(containing(position[0]), containing(position[1]));
    }
    let [(x, fraction_x), (y, fraction_y)] = position.map(split);
    let [weights_x, weights_y] =
        [fraction_x, fraction_y].map(|bits| filter.weights(fraction(bits)));
    let before = filter.taps() as i32 / 2 - 1;
    let mut value = [0.0; C];
    for a in 0..filter.taps() {
        let mut column = [0.0; C];
        for b in 0..filter.taps() {
            let texel = texel(x + a as i32 - before, y + b as i32 - before);
            for channel in 0..C {
                column[channel] += texel[channel] * weights_y[b];
            }
        }
        for channel in 0..C {
            value[channel] += column[channel] * weights_x[a];
        }
    }
    value
}

/// A filter in fixed point, for 8-bit values without alpha.
///
/// Weights have 14 fraction bits. Texels are filtered across each row first, and the row's value is
/// truncated to 6 fraction bits, so that it fits 16 bits with its sign; then rows are filtered down,
/// which leaves 20 fraction bits.
struct WholeFilter {
    filter: Filter,
    /// Of [`Filter::Lanczos3`], the weights at every 1024th of a texel, and at a whole one.
    phases: Vec<[i32; MAX_TAPS]>,
}

impl WholeFilter {
    fn new(filter: Filter) -> Self {
        let phase = |phase: u16| Self::rounded(filter, f32::from(phase) / 1024.0);
        let phases =
            if filter == Filter::Lanczos3 { (0..=1024).map(phase).collect() } else { Vec::new() };
        Self { filter, phases }
    }

    /// The weights of a filter with 14 fraction bits, ties to even.
    fn rounded(filter: Filter, fraction: f32) -> [i32; MAX_TAPS] {
        filter.weights(fraction).map(|weight| (weight * 16_384.0).round_ties_even() as i32)
    }

    /// The weights at a distance from a texel's centre, in 2⁻³² texels. Those of a bilinear filter are
    /// truncated, and add up to 1; those of Lanczos are interpolated between phases, with 15 bits.
    fn weights(&self, bits: u32) -> [i32; MAX_TAPS] {
        match self.filter {
            Filter::Bilinear => {
                let second = (bits >> 18) as i32;
                [16_384 - second, second, 0, 0, 0, 0]
            }
            Filter::Lanczos3 => {
                let (phase, between) = ((bits >> 22) as usize, (bits >> 7 & 0x7fff) as i32);
                std::array::from_fn(|tap| {
                    let [low, high] = [phase, phase + 1].map(|phase| self.phases[phase][tap]);
                    low + (((high - low) * between + 0x4000) >> 15)
                })
            }
            Filter::CatmullRom | Filter::Nearest => Self::rounded(self.filter, fraction(bits)),
        }
    }

    /// The value at one position, with 20 fraction bits. Truncating the rows lost half of their last bit
    /// on average, which is added back.
    fn sample<const C: usize>(&self, source: &[u8], size: Size, position: [i64; 2]) -> [i32; C] {
        let [(x, bits_x), (y, bits_y)] =
            [near_texture(position[0], size.width), near_texture(position[1], size.height)]
                .map(split);
        let (across, down) = (self.weights(bits_x), self.weights(bits_y));
        let taps = self.filter.taps();
        let before = taps as i32 / 2 - 1;
        std::array::from_fn(|channel| {
            let mut value = 1 << 13;
            for b in 0..taps {
                let y = (y + b as i32 - before).clamp(0, size.height as i32 - 1) as usize;
                let mut row = 0;
                for a in 0..taps {
                    let x = (x + a as i32 - before).clamp(0, size.width as i32 - 1) as usize;
                    row +=
                        i32::from(source[(y * size.width as usize + x) * C + channel]) * across[a];
                }
                value += (row >> 8) * down[b];
            }
            value
        })
    }

    /// The mean of a texel's samples, of which there may be 1024: each keeps 12 fraction bits, so that
    /// their sum fits 32 bits. A single sample is rounded with all of its bits, ties upwards.
    fn average<const C: usize>(
        &self,
        walk: &Walk<'_>,
        k: u32,
        source: &[u8],
        size: Size,
    ) -> [u8; C] {
        let [columns, rows] = walk.samples();
        if [columns, rows] == [1, 1] {
            let value = self.sample::<C>(source, size, walk.sample(k, 0, 0));
            return value.map(|value| ((value + (1 << 19)) >> 20).clamp(0, 255) as u8);
        }
        let mut sums = [0; C];
        for b in 0..rows {
            for a in 0..columns {
                let value = self.sample::<C>(source, size, walk.sample(k, a, b));
                for channel in 0..C {
                    sums[channel] += value[channel] >> 8;
                }
            }
        }
        let share = 1.0 / ((columns * rows) << 12) as f32;
        sums.map(|sum| (sum as f32 * share).round_ties_even().clamp(0.0, 255.0) as u8)
    }
}
