//! The fast path: rows in parallel, kernels compiled for their filter, channels and SIMD level.
//!
//! A run is worked on in batches of texels: positions and weights of all of them first, then their
//! windows. Each window is filtered by [`window::filtered`], which does the reference's arithmetic in
//! the reference's order.

use fearless_simd::{Level, Simd, SimdInto, dispatch, f32x4};

use super::window::{self, LANES, MAX_VALUES};
use super::{Paths, Walk, load, near_texture, split, store};
use crate::filter::{Bilinear, CatmullRom, Filter, Lanczos3, MAX_TAPS, Taps};
use crate::map::SamplingMap;
use crate::texture::{Size, Value};
use crate::threads::for_each_chunk;

/// Rows of the target that one piece of work fills.
const ROWS: usize = 16;

/// Texels of a run that are worked on together: what is known about them fits the first cache.
const BATCH: usize = 64;

/// A source texture's values and size.
#[derive(Clone, Copy)]
struct Source<'a, T> {
    values: &'a [T],
    size: Size,
}

/// As [`super::reference::resample`], to the bit but for the sign of zeros, on some rows of the
/// target.
///
/// - `source`: `[height * width * C]` values of a texture of the size that `paths` are for.
/// - `rows`: the rows of the target from `first_row` on.
pub(crate) fn resample<T: Value, const C: usize, const OPACITY: bool>(
    level: Level,
    map: &SamplingMap,
    paths: &Paths,
    source: &[T],
    first_row: u32,
    rows: &mut [T],
) {
    let source = Source { values: source, size: paths.source };
    let width = map.size().width as usize * C;
    for_each_chunk(rows, width * ROWS, |chunk, rows| {
        let first_row = first_row + (chunk * ROWS) as u32;
        match paths.filter {
            Filter::Nearest => {
                for_each_run::<T, C>(map, paths, first_row, rows, |walk, texels| {
                    nearest::<T, C, OPACITY>(source, walk, texels);
                });
            }
            Filter::Bilinear => dispatch!(level, simd =>
                smooth::<_, T, C, OPACITY, Bilinear>(simd, map, paths, source, first_row, rows)),
            Filter::CatmullRom => dispatch!(level, simd =>
                smooth::<_, T, C, OPACITY, CatmullRom>(simd, map, paths, source, first_row, rows)),
            Filter::Lanczos3 => dispatch!(level, simd =>
                smooth::<_, T, C, OPACITY, Lanczos3>(simd, map, paths, source, first_row, rows)),
        }
    });
}

/// Calls `fill` with the walk and the texels of every run of some rows.
#[inline(always)]
fn for_each_run<T: Value, const C: usize>(
    map: &SamplingMap,
    paths: &Paths,
    first_row: u32,
    rows: &mut [T],
    mut fill: impl FnMut(&Walk, &mut [T]),
) {
    let width = map.size().width as usize * C;
    for (row, target) in (first_row..).zip(rows.chunks_mut(width)) {
        for &run in map.row(row) {
            let texels = &mut target[run.x as usize * C..][..run.len as usize * C];
            fill(&paths.walk(row, run), texels);
        }
    }
}

fn nearest<T: Value, const C: usize, const OPACITY: bool>(
    source: Source<'_, T>,
    walk: &Walk,
    texels: &mut [T],
) {
    let (last_x, last_y) = (source.size.width - 1, source.size.height - 1);
    let width = source.size.width as usize;
    for (k, texel) in (0..).zip(texels.chunks_exact_mut(C)) {
        // Casts saturate, which clamps below; they truncate, which is the floor above.
        let [x, y] = walk.at(k).map(|position| position as u32);
        let index = y.min(last_y) as usize * width + x.min(last_x) as usize;
        let levels = load::<T, C, OPACITY>(&source.values[index * C..][..C]);
        store::<T, C, OPACITY>(levels, texel);
    }
}

/// Where the windows of a batch of texels lie, their weights, and sums of samples.
struct Batch {
    /// Column and row of the window's first texel.
    corner: [[i32; BATCH]; 2],
    fraction: [[f32; BATCH]; 2],
    weights: [[[f32; MAX_TAPS]; BATCH]; 2],
    /// The first `C` of each count.
    sums: [[f32; 4]; BATCH],
}

/// Fills rows with a filter of several taps.
#[inline(always)]
fn smooth<S: Simd, T: Value, const C: usize, const OPACITY: bool, F: Taps>(
    simd: S,
    map: &SamplingMap,
    paths: &Paths,
    source: Source<'_, T>,
    first_row: u32,
    rows: &mut [T],
) {
    let mut batch = Batch {
        corner: [[0; BATCH]; 2],
        fraction: [[0.0; BATCH]; 2],
        weights: [[[0.0; MAX_TAPS]; BATCH]; 2],
        sums: [[0.0; 4]; BATCH],
    };
    for_each_run::<T, C>(
        map,
        paths,
        first_row,
        rows,
        #[inline(always)]
        |walk, texels| {
            // A window is read in whole vectors, which may end a few values behind it: in the
            // margin's texel to the right, or in the row below.
            let clear = source.size.width as usize * C >= LANES
                && walk.stays_inside((texels.len() / C) as u32, source.size, F::TAPS as u32);
            for (piece, texels) in (0..).zip(texels.chunks_mut(BATCH * C)) {
                let first = piece * BATCH as u32;
                batch.fill::<S, T, C, OPACITY, F>(simd, source, walk, first, clear, texels);
            }
        },
    );
}

impl Batch {
    /// Fills texels `first..` of a run.
    #[inline(always)]
    fn fill<S: Simd, T: Value, const C: usize, const OPACITY: bool, F: Taps>(
        &mut self,
        simd: S,
        source: Source<'_, T>,
        walk: &Walk,
        first: u32,
        clear: bool,
        texels: &mut [T],
    ) {
        let count = texels.len() / C;
        let [columns, rows] = walk.samples;
        self.sums[..count].fill([0.0; 4]);
        for b in 0..rows {
            for a in 0..columns {
                self.place::<F>(source.size, walk, first, (a, b), clear, count);
                for k in 0..count {
                    let value = if clear {
                        self.inside::<S, T, C, OPACITY, F>(simd, source, k)
                    } else {
                        self.anywhere::<S, T, C, OPACITY, F>(simd, source, k)
                    };
                    let sum: f32x4<S> = self.sums[k].simd_into(simd);
                    self.sums[k] = (sum + value).into();
                }
            }
        }
        let share = 1.0 / (columns * rows) as f32;
        for (sum, texel) in self.sums.iter().zip(texels.chunks_exact_mut(C)) {
            let levels = std::array::from_fn(|channel| sum[channel] * share);
            store::<T, C, OPACITY>(levels, texel);
        }
    }

    /// Finds the windows and weights of sample `(a, b)` of `count` texels from `first` on.
    #[inline(always)]
    fn place<F: Taps>(
        &mut self,
        size: Size,
        walk: &Walk,
        first: u32,
        (a, b): (u32, u32),
        clear: bool,
        count: usize,
    ) {
        let before = F::TAPS as i32 / 2 - 1;
        for k in 0..count {
            let [mut x, mut y] = walk.sample(walk.at(first + k as u32), a, b);
            if !clear {
                (x, y) = (near_texture(x, size.width), near_texture(y, size.height));
            }
            let ((x, fraction_x), (y, fraction_y)) = (split(x), split(y));
            (self.corner[0][k], self.corner[1][k]) = (x - before, y - before);
            (self.fraction[0][k], self.fraction[1][k]) = (fraction_x, fraction_y);
        }
        for axis in 0..2 {
            for k in 0..count {
                self.weights[axis][k] = F::weights(self.fraction[axis][k]);
            }
        }
    }

    /// The value of texel `k`, whose whole window lies in the texture.
    #[inline(always)]
    fn inside<S: Simd, T: Value, const C: usize, const OPACITY: bool, F: Taps>(
        &self,
        simd: S,
        source: Source<'_, T>,
        k: usize,
    ) -> f32x4<S> {
        let stride = source.size.width as usize * C;
        let [x, y] = [0, 1].map(|axis| self.corner[axis][k] as usize);
        let values = &source.values[y * stride + x * C..];
        window::filtered::<S, T, C, OPACITY, F>(simd, values, stride, self.weights_of(k))
    }

    /// The value of texel `k`, wherever it looks; beyond the texture's edge its edge is read.
    #[inline(never)]
    fn anywhere<S: Simd, T: Value, const C: usize, const OPACITY: bool, F: Taps>(
        &self,
        simd: S,
        source: Source<'_, T>,
        k: usize,
    ) -> f32x4<S> {
        const STRIDE: usize = MAX_VALUES;
        let clamped = |at: i32, count: u32| at.clamp(0, count as i32 - 1) as usize;
        let mut window = [T::default(); STRIDE * MAX_TAPS];
        for (b, row) in (0..).zip(window.chunks_exact_mut(STRIDE).take(F::TAPS)) {
            let y = clamped(self.corner[1][k] + b, source.size.height);
            for (a, texel) in (0..).zip(row.chunks_exact_mut(C).take(F::TAPS)) {
                let x = clamped(self.corner[0][k] + a, source.size.width);
                let start = (y * source.size.width as usize + x) * C;
                texel.copy_from_slice(&source.values[start..start + C]);
            }
        }
        window::filtered::<S, T, C, OPACITY, F>(simd, &window, STRIDE, self.weights_of(k))
    }

    #[inline(always)]
    fn weights_of(&self, k: usize) -> [&[f32; MAX_TAPS]; 2] {
        [&self.weights[0][k], &self.weights[1][k]]
    }
}
