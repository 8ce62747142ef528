//! The fast path: rows in parallel, kernels compiled for their taps and channels, windows of texels
//! read whole, and no edges to mind in runs that stay clear of them.

use super::{Paths, Walk, load, near_texture, split, store};
use crate::filter::{Bilinear, CatmullRom, Filter, Lanczos3, Taps};
use crate::map::{Run, SamplingMap};
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
pub(crate) fn resample<T: Value, const C: usize, const OPACITY: bool>(
    map: &SamplingMap,
    source: &[T],
    source_size: Size,
    target: &mut [T],
    filter: Filter,
) {
    // The last number is the values in a row of the filter's window: taps times channels.
    let kernel: Kernel<T> = match (filter, C) {
        (Filter::Nearest, _) => nearest::<T, C, OPACITY>,
        (Filter::Bilinear, 1) => smooth::<T, C, OPACITY, Bilinear, 2, 2>,
        (Filter::Bilinear, 2) => smooth::<T, C, OPACITY, Bilinear, 2, 4>,
        (Filter::Bilinear, 3) => smooth::<T, C, OPACITY, Bilinear, 2, 6>,
        (Filter::Bilinear, _) => smooth::<T, C, OPACITY, Bilinear, 2, 8>,
        (Filter::CatmullRom, 1) => smooth::<T, C, OPACITY, CatmullRom, 4, 4>,
        (Filter::CatmullRom, 2) => smooth::<T, C, OPACITY, CatmullRom, 4, 8>,
        (Filter::CatmullRom, 3) => smooth::<T, C, OPACITY, CatmullRom, 4, 12>,
        (Filter::CatmullRom, _) => smooth::<T, C, OPACITY, CatmullRom, 4, 16>,
        (Filter::Lanczos3, 1) => smooth::<T, C, OPACITY, Lanczos3, 6, 6>,
        (Filter::Lanczos3, 2) => smooth::<T, C, OPACITY, Lanczos3, 6, 12>,
        (Filter::Lanczos3, 3) => smooth::<T, C, OPACITY, Lanczos3, 6, 18>,
        (Filter::Lanczos3, _) => smooth::<T, C, OPACITY, Lanczos3, 6, 24>,
    };
    kernel(map, Source { values: source, size: source_size }, target, filter);
}

/// Fills a target through a map with one filter.
type Kernel<T> = fn(&SamplingMap, Source<'_, T>, &mut [T], Filter);

/// Calls `fill_run` with every run and its texels.
fn fill<T: Value, const C: usize>(
    map: &SamplingMap,
    source: Source<'_, T>,
    target: &mut [T],
    filter: Filter,
    fill_run: impl Fn(Source<'_, T>, &Walk, &mut [T]) + Send + Sync,
) {
    let width = map.size().width as usize;
    let paths = Paths::new(map, source.size, filter);
    for_each_chunk(target, width * C * ROWS, |chunk, rows| {
        for (offset, target_row) in rows.chunks_mut(width * C).enumerate() {
            let row = (chunk * ROWS + offset) as u32;
            for &run in map.row(row) {
                let walk = paths.walk(row, run);
                let Run { x, len, .. } = run;
                fill_run(source, &walk, &mut target_row[x as usize * C..][..len as usize * C]);
            }
        }
    });
}

fn nearest<T: Value, const C: usize, const OPACITY: bool>(
    map: &SamplingMap,
    source: Source<'_, T>,
    target: &mut [T],
    filter: Filter,
) {
    fill::<T, C>(map, source, target, filter, |source, walk, texels| {
        let (last_x, last_y) = (source.size.width - 1, source.size.height - 1);
        let width = source.size.width as usize;
        for (k, texel) in (0..).zip(texels.chunks_exact_mut(C)) {
            // Casts saturate, which clamps below; they truncate, which is the floor above.
            let [x, y] = walk.at(k).map(|position| position as u32);
            let index = y.min(last_y) as usize * width + x.min(last_x) as usize;
            let levels = load::<T, C, OPACITY>(&source.values[index * C..][..C]);
            store::<T, C, OPACITY>(levels, texel);
        }
    });
}

/// Fills with a filter of `N` taps whose windows have `W` values in a row.
fn smooth<
    T: Value,
    const C: usize,
    const OPACITY: bool,
    F: Taps<N>,
    const N: usize,
    const W: usize,
>(
    map: &SamplingMap,
    source: Source<'_, T>,
    target: &mut [T],
    filter: Filter,
) {
    fill::<T, C>(map, source, target, filter, |source, walk, texels| {
        let count = (texels.len() / C) as u32;
        let clear = walk.stays_inside(count, source.size, N as u32);
        match (walk.samples == [1, 1], clear) {
            // One sample lies on the centre, and the mean of one is itself.
            (true, true) => {
                for (k, texel) in (0..count).zip(texels.chunks_exact_mut(C)) {
                    store::<T, C, OPACITY>(
                        inside::<T, C, OPACITY, F, N, W>(source, walk.at(k)),
                        texel,
                    );
                }
            }
            (true, false) => {
                for (k, texel) in (0..count).zip(texels.chunks_exact_mut(C)) {
                    store::<T, C, OPACITY>(
                        anywhere::<T, C, OPACITY, F, N, W>(source, walk.at(k)),
                        texel,
                    );
                }
            }
            (false, true) => average::<T, C, OPACITY>(walk, texels, |at| {
                inside::<T, C, OPACITY, F, N, W>(source, at)
            }),
            (false, false) => average::<T, C, OPACITY>(walk, texels, |at| {
                anywhere::<T, C, OPACITY, F, N, W>(source, at)
            }),
        }
    });
}

/// Fills texels with the mean of their samples.
fn average<T: Value, const C: usize, const OPACITY: bool>(
    walk: &Walk,
    texels: &mut [T],
    sample: impl Fn([f64; 2]) -> [f32; C],
) {
    let [columns, rows] = walk.samples;
    let share = 1.0 / (columns * rows) as f32;
    for (k, texel) in (0..).zip(texels.chunks_exact_mut(C)) {
        let centre = walk.at(k);
        let mut sum = [0.0; C];
        for b in 0..rows {
            for a in 0..columns {
                let value = sample(walk.sample(centre, a, b));
                for channel in 0..C {
                    sum[channel] += value[channel];
                }
            }
        }
        store::<T, C, OPACITY>(sum.map(|total| total * share), texel);
    }
}

/// The value at a position whose whole window lies in the texture.
#[inline(always)]
fn inside<
    T: Value,
    const C: usize,
    const OPACITY: bool,
    F: Taps<N>,
    const N: usize,
    const W: usize,
>(
    source: Source<'_, T>,
    position: [f64; 2],
) -> [f32; C] {
    let ((x, fraction_x), (y, fraction_y)) = (split(position[0]), split(position[1]));
    let before = N as i32 / 2 - 1;
    let stride = source.size.width as usize * C;
    let start = (y - before) as usize * stride + (x - before) as usize * C;
    filtered::<T, C, OPACITY, F, N, W>(fraction_x, fraction_y, |row| {
        let values = source.values[start + row * stride..].first_chunk();
        *values.expect("the window lies in the texture")
    })
}

/// The value at any position; beyond the texture's edge its edge is read.
fn anywhere<
    T: Value,
    const C: usize,
    const OPACITY: bool,
    F: Taps<N>,
    const N: usize,
    const W: usize,
>(
    source: Source<'_, T>,
    position: [f64; 2],
) -> [f32; C] {
    let (x, fraction_x) = split(near_texture(position[0], source.size.width));
    let (y, fraction_y) = split(near_texture(position[1], source.size.height));
    let before = N as i32 / 2 - 1;
    let clamped = |at: i32, count: u32| at.clamp(0, count as i32 - 1) as usize;
    filtered::<T, C, OPACITY, F, N, W>(fraction_x, fraction_y, |row| {
        let row = clamped(y - before + row as i32, source.size.height);
        let mut window = [T::default(); W];
        for (column, texel) in (0..).zip(window.chunks_exact_mut(C)) {
            let column = clamped(x - before + column, source.size.width);
            let start = (row * source.size.width as usize + column) * C;
            texel.copy_from_slice(&source.values[start..start + C]);
        }
        window
    })
}

/// Filters a window given row by row: each column downwards, then the results across.
#[inline(always)]
fn filtered<
    T: Value,
    const C: usize,
    const OPACITY: bool,
    F: Taps<N>,
    const N: usize,
    const W: usize,
>(
    fraction_x: f32,
    fraction_y: f32,
    row: impl Fn(usize) -> [T; W],
) -> [f32; C] {
    let (weights_x, weights_y) = (F::weights(fraction_x), F::weights(fraction_y));
    let mut columns = [0.0f32; W];
    for (b, weight) in weights_y.into_iter().enumerate() {
        let levels = levels::<T, C, OPACITY, W>(&row(b));
        for k in 0..W {
            columns[k] += levels[k] * weight;
        }
    }
    let mut value = [0.0; C];
    for (a, weight) in weights_x.into_iter().enumerate() {
        for channel in 0..C {
            value[channel] += columns[a * C + channel] * weight;
        }
    }
    value
}

/// A row of a window as levels, premultiplied; as [`load`] for each texel.
#[inline(always)]
fn levels<T: Value, const C: usize, const OPACITY: bool, const W: usize>(
    window: &[T; W],
) -> [f32; W] {
    let mut levels: [f32; W] = std::array::from_fn(|k| window[k].to_level());
    if OPACITY {
        for texel in levels.chunks_exact_mut(C) {
            let opacity = texel[C - 1] / T::ONE.to_level();
            for level in &mut texel[..C - 1] {
                *level *= opacity;
            }
        }
    }
    levels
}
