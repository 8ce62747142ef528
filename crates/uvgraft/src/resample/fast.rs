//! The fast path: rows in parallel, texels read as whole windows, no bounds to check inside.

use super::{Walk, load, split, store};
use crate::filter::Filter;
use crate::map::SamplingMap;
use crate::texture::{Size, Value};
use crate::threads::for_each_chunk;

/// Rows of the target that one piece of work fills.
const ROWS: usize = 16;

/// A source texture's values and size.
#[derive(Clone, Copy)]
struct Source<'a, T> {
    values: &'a [T],
    size: Size,
}

/// As [`super::reference::resample`], to the bit.
pub(crate) fn resample<T: Value, const C: usize>(
    map: &SamplingMap,
    source: &[T],
    source_size: Size,
    target: &mut [T],
    filter: Filter,
) {
    let source = Source { values: source, size: source_size };
    let width = map.size().width as usize;
    for_each_chunk(target, width * C * ROWS, |chunk, rows| {
        for (offset, target_row) in rows.chunks_mut(width * C).enumerate() {
            let row = (chunk * ROWS + offset) as u32;
            // One instance for each number of taps, with window sizes known to the compiler.
            match (filter, C) {
                (Filter::Nearest, _) => nearest_row::<T, C>(map, row, source, target_row),
                (Filter::Bilinear, 1) => {
                    fill_row::<T, C, 2, 2>(map, row, source, target_row, filter)
                }
                (Filter::Bilinear, 2) => {
                    fill_row::<T, C, 2, 4>(map, row, source, target_row, filter)
                }
                (Filter::Bilinear, 3) => {
                    fill_row::<T, C, 2, 6>(map, row, source, target_row, filter)
                }
                (Filter::Bilinear, _) => {
                    fill_row::<T, C, 2, 8>(map, row, source, target_row, filter)
                }
                (Filter::CatmullRom, 1) => {
                    fill_row::<T, C, 4, 4>(map, row, source, target_row, filter)
                }
                (Filter::CatmullRom, 2) => {
                    fill_row::<T, C, 4, 8>(map, row, source, target_row, filter)
                }
                (Filter::CatmullRom, 3) => {
                    fill_row::<T, C, 4, 12>(map, row, source, target_row, filter)
                }
                (Filter::CatmullRom, _) => {
                    fill_row::<T, C, 4, 16>(map, row, source, target_row, filter)
                }
                (Filter::Lanczos3, 1) => {
                    fill_row::<T, C, 6, 6>(map, row, source, target_row, filter)
                }
                (Filter::Lanczos3, 2) => {
                    fill_row::<T, C, 6, 12>(map, row, source, target_row, filter)
                }
                (Filter::Lanczos3, 3) => {
                    fill_row::<T, C, 6, 18>(map, row, source, target_row, filter)
                }
                (Filter::Lanczos3, _) => {
                    fill_row::<T, C, 6, 24>(map, row, source, target_row, filter)
                }
            }
        }
    });
}

fn nearest_row<T: Value, const C: usize>(
    map: &SamplingMap,
    row: u32,
    source: Source<'_, T>,
    target: &mut [T],
) {
    let (last_x, last_y) = (source.size.width - 1, source.size.height - 1);
    for &run in map.row(row) {
        let walk = Walk::new(map, row, run, source.size, Filter::Nearest);
        for k in 0..run.len {
            // Casts saturate, which clamps below; they truncate, which is the floor above.
            let [x, y] = walk.at(k).map(|position| position as u32);
            let texel =
                y.min(last_y) as usize * source.size.width as usize + x.min(last_x) as usize;
            let levels = load::<T, C>(&source.values[texel * C..][..C]);
            store(levels, &mut target[(run.x + k) as usize * C..][..C]);
        }
    }
}

/// Fills a row with a filter of `N` taps; `W` is `N * C`, the values in a window's row.
fn fill_row<T: Value, const C: usize, const N: usize, const W: usize>(
    map: &SamplingMap,
    row: u32,
    source: Source<'_, T>,
    target: &mut [T],
    filter: Filter,
) {
    for &run in map.row(row) {
        let walk = Walk::new(map, row, run, source.size, filter);
        let texels = &mut target[run.x as usize * C..][..run.len as usize * C];
        if walk.samples == [1, 1] {
            for (k, texel) in (0..run.len).zip(texels.chunks_exact_mut(C)) {
                // One sample lies on the centre, and the mean of one is itself.
                store(sample::<T, C, N, W>(source, walk.at(k), filter), texel);
            }
            continue;
        }
        let [columns, rows] = walk.samples;
        let share = 1.0 / (columns * rows) as f32;
        for (k, texel) in (0..run.len).zip(texels.chunks_exact_mut(C)) {
            let centre = walk.at(k);
            let mut sum = [0.0; C];
            for b in 0..rows {
                for a in 0..columns {
                    let value = sample::<T, C, N, W>(source, walk.sample(centre, a, b), filter);
                    for channel in 0..C {
                        sum[channel] += value[channel];
                    }
                }
            }
            store(sum.map(|total| total * share), texel);
        }
    }
}

#[inline(always)]
fn sample<T: Value, const C: usize, const N: usize, const W: usize>(
    source: Source<'_, T>,
    position: [f64; 2],
    filter: Filter,
) -> [f32; C] {
    let (width, height) = (source.size.width as i64, source.size.height as i64);
    let ((x, fraction_x), (y, fraction_y)) = (split(position[0]), split(position[1]));
    let (weights_x, weights_y) = (filter.weights(fraction_x), filter.weights(fraction_y));
    let before = N as i64 / 2 - 1;
    let (left, top) = (x - before, y - before);
    let inside_x = left >= 0 && left + N as i64 <= width;
    let inside_y = top >= 0 && top + N as i64 <= height;

    // A window of N columns: each is filtered downwards, then the N results across.
    let mut columns = [0.0f32; W];
    if inside_x && inside_y {
        let mut start = (top as usize * width as usize + left as usize) * C;
        for weight in &weights_y[..N] {
            let window = &source.values[start..start + W];
            add_window::<T, C, W>(window, *weight, &mut columns);
            start += width as usize * C;
        }
    } else {
        let mut window = [T::default(); W];
        for (b, weight) in weights_y[..N].iter().enumerate() {
            let row = (top + b as i64).clamp(0, height - 1) * width;
            for (a, texel) in window.chunks_exact_mut(C).enumerate() {
                let start = (row + (left + a as i64).clamp(0, width - 1)) as usize * C;
                texel.copy_from_slice(&source.values[start..start + C]);
            }
            add_window::<T, C, W>(&window, *weight, &mut columns);
        }
    }
    let mut value = [0.0; C];
    for (column, weight) in columns.chunks_exact(C).zip(&weights_x[..N]) {
        for channel in 0..C {
            value[channel] += column[channel] * weight;
        }
    }
    value
}

#[inline(always)]
fn add_window<T: Value, const C: usize, const W: usize>(
    window: &[T],
    weight: f32,
    columns: &mut [f32; W],
) {
    if C == 2 || C == 4 {
        for (texel, column) in window.chunks_exact(C).zip(columns.chunks_exact_mut(C)) {
            let levels = load::<T, C>(texel);
            for channel in 0..C {
                column[channel] += levels[channel] * weight;
            }
        }
    } else {
        for (value, column) in window.iter().zip(columns) {
            *column += value.to_level() * weight;
        }
    }
}
