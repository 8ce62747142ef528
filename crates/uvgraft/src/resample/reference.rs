//! The specification of resampling that every faster path is tested against. Written to be
//! read; never tuned.

use super::position::{containing, fraction, near_texture, split};
use super::{Paths, Walk, bytes, load, store};
use crate::filter::Filter;
use crate::map::SamplingMap;
use crate::texture::{Size, Value};

/// Fills the texels of a target that a map reaches from a source.
///
/// - `source`: `[height * width * C]` values of a texture of `source_size`.
/// - `target`: `[height * width * C]` values of a texture of the map's size.
///
/// With `ALPHA` the last channel is alpha: colours are filtered premultiplied and composited over
/// the target. Without it, values replace those of the target. Taps beyond the source read its edge
/// texels. 8-bit values without alpha are filtered in integers, which round as exact arithmetic
/// does except within 1/16 level of a tie.
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
    let paths = Paths::new(map, source_size, filter);
    for row in 0..map.size().height {
        for &run in map.row(row) {
            let walk = paths.walk(row, run);
            for k in 0..run.len {
                let levels = match T::as_bytes(source) {
                    Some(source) if !ALPHA && filter != Filter::Nearest => {
                        bytes::texel::<C>(&walk, k, source, source_size, filter).map(f32::from)
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
