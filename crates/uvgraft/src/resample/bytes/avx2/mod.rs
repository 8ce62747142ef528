//! Filters eight texels at once, with AVX2.

mod group;
mod instructions;
mod texels;
mod weights;
mod window;

use fearless_simd::{Avx2, Level, Simd};

use self::group::Source;
use self::weights::VectorTaps;
use super::weights::WholeTaps;
use super::{Job, texel_clamped};
use crate::filter::{Bilinear, CatmullRom, Filter, Lanczos3};
use crate::resample::Walk;
use crate::resample::stretch::fill_rows;
use crate::texture::Size;

/// Fills rows from `first_row` on; see [`super::resample`]. With AVX-512 runs are walked in its
/// vectors.
pub(super) fn fill<const C: usize>(
    level: Level,
    avx2: Avx2,
    job: &Job<'_, u8>,
    first_row: u32,
    rows: &mut [u8],
) {
    match level.as_avx512() {
        Some(avx512) => fill_walking::<_, C>(avx512, avx2, job, first_row, rows),
        None => fill_walking::<_, C>(avx2, avx2, job, first_row, rows),
    }
}

fn fill_walking<S: Simd, const C: usize>(
    simd: S,
    avx2: Avx2,
    job: &Job<'_, u8>,
    first_row: u32,
    rows: &mut [u8],
) {
    match job.paths.filter {
        Filter::Nearest => unreachable!("takes texels as they are"),
        Filter::Bilinear => fill_with::<S, C, Bilinear>(simd, avx2, job, first_row, rows),
        Filter::CatmullRom => fill_with::<S, C, CatmullRom>(simd, avx2, job, first_row, rows),
        Filter::Lanczos3 => fill_with::<S, C, Lanczos3>(simd, avx2, job, first_row, rows),
    }
}

fn fill_with<S: Simd, const C: usize, F: VectorTaps>(
    simd: S,
    avx2: Avx2,
    job: &Job<'_, u8>,
    first_row: u32,
    rows: &mut [u8],
) {
    let size = job.paths.source;
    let source = Source { avx2, values: job.source, stride: size.width as usize * C };
    simd.vectorize(
        #[inline(always)]
        || {
            fill_rows::<_, u8, C, F>(
                simd,
                job,
                first_row,
                rows,
                #[inline(always)]
                |stretch, texels| texels::fill::<C, F>(&source, stretch, texels),
                |walk, texels| fill_clamped::<C, F>(walk, job.source, size, texels),
            );
        },
    );
}

/// Fills the texels of a run whose windows may lie anywhere.
fn fill_clamped<const C: usize, F: WholeTaps>(
    walk: &Walk<'_>,
    source: &[u8],
    size: Size,
    texels: &mut [u8],
) {
    for (k, values) in (0..).zip(texels.chunks_exact_mut(C)) {
        values.copy_from_slice(&texel_clamped::<C, F>(walk, k, source, size));
    }
}
