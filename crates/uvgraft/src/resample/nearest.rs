//! Takes the texel that contains each position as it is.

use fearless_simd::Simd;

use super::path::Walk;
use super::position::containing;
use super::stretch::{Job, Stretch, fill_rows};
use super::{composite, load, store};
use crate::filter::Nearest;
use crate::texture::{Size, Value};

/// Fills rows of a target from `first_row` on.
#[inline(always)]
pub(super) fn fill<S: Simd, T: Value, const C: usize, const ALPHA: bool>(
    simd: S,
    job: &Job<'_, T>,
    first_row: u32,
    rows: &mut [T],
) {
    fill_rows::<S, T, C, Nearest>(
        simd,
        job,
        first_row,
        rows,
        #[inline(always)]
        |stretch, texels| {
            if ALPHA {
                blend::<S, T, C>(simd, job.source, stretch, texels);
            } else {
                copy::<T, C>(job.source, stretch, texels);
            }
        },
        |walk, texels| clamped::<T, C, ALPHA>(walk, job.source, job.paths.source, texels),
    );
}

/// Composites texels of the source, the last channel of which is alpha.
#[inline(always)]
fn blend<S: Simd, T: Value, const C: usize>(
    simd: S,
    source: &[T],
    stretch: &Stretch,
    texels: &mut [T],
) {
    let groups = stretch.all_starts().chunks(composite::GROUP);
    for (starts, texels) in groups.zip(texels.chunks_mut(composite::GROUP * C)) {
        let mut levels = [[0.0; 4]; composite::GROUP];
        let mut opacities = [0.0; composite::GROUP];
        for (k, &start) in starts.iter().enumerate() {
            let texel = &source[start as usize..][..C];
            for channel in 0..C {
                levels[k][channel] = texel[channel].to_level();
            }
            opacities[k] = levels[k][C - 1];
        }
        for opacity in &mut opacities {
            *opacity /= T::ONE.to_level();
        }
        for k in 0..composite::GROUP {
            for channel in 0..C - 1 {
                levels[k][channel] *= opacities[k];
            }
        }
        composite::store_all::<S, T, C>(simd, &levels[..starts.len()], texels);
    }
}

/// Copies texels from the source, four values each: of those that are not its own, the next texel
/// overwrites some, and the others are left out for the last one.
#[inline(always)]
fn copy<T: Value, const C: usize>(source: &[T], stretch: &Stretch, texels: &mut [T]) {
    let starts = stretch.all_starts();
    let (&last, starts) = starts.split_last().expect("some texels");
    if C == 3 {
        for (k, &start) in starts.iter().enumerate() {
            let texel: &[T; 4] = source[start as usize..].first_chunk().expect("a window's room");
            texels[k * C..][..4].copy_from_slice(texel);
        }
    } else {
        for (start, texel) in starts.iter().zip(texels.chunks_exact_mut(C)) {
            texel.copy_from_slice(&source[*start as usize..][..C]);
        }
    }
    texels[starts.len() * C..].copy_from_slice(&source[last as usize..][..C]);
}

/// Fills the texels of a run whose positions may lie anywhere.
fn clamped<T: Value, const C: usize, const ALPHA: bool>(
    walk: &Walk<'_>,
    source: &[T],
    size: Size,
    texels: &mut [T],
) {
    for (k, texel) in (0..).zip(texels.chunks_exact_mut(C)) {
        let [x, y] = walk.centre(k);
        let column = containing(x).clamp(0, size.width as i32 - 1) as usize;
        let row = containing(y).clamp(0, size.height as i32 - 1) as usize;
        let start = (row * size.width as usize + column) * C;
        store::<T, C, ALPHA>(load::<T, C, ALPHA>(&source[start..][..C]), texel);
    }
}
