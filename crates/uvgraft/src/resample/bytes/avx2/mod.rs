//! Filters eight texels at once, with AVX2.

mod group;
mod instructions;
mod stretch;
mod weights;
mod window;

use fearless_simd::{Avx2, Simd};

use self::group::{MAX_READ, Source};
use self::stretch::{MAX_SAMPLES, Stretch};
use self::weights::VectorTaps;
use super::{Job, texel_clamped};
use crate::filter::{Bilinear, CatmullRom, Filter, Lanczos3};

/// Fills rows from `first_row` on; see [`super::resample`].
pub(super) fn fill<const C: usize>(avx2: Avx2, job: &Job<'_>, first_row: u32, rows: &mut [u8]) {
    match job.paths.filter {
        Filter::Nearest => unreachable!("takes texels as they are"),
        Filter::Bilinear => fill_with::<C, Bilinear>(avx2, job, first_row, rows),
        Filter::CatmullRom => fill_with::<C, CatmullRom>(avx2, job, first_row, rows),
        Filter::Lanczos3 => fill_with::<C, Lanczos3>(avx2, job, first_row, rows),
    }
}

/// Fills rows run by run. Texels of adjacent runs are collected in a [`Stretch`], which is filled
/// in groups of eight, so that short runs do not waste lanes. Runs whose windows may leave the
/// source, or with too many samples, take the scalar path.
fn fill_with<const C: usize, F: VectorTaps>(
    avx2: Avx2,
    job: &Job<'_>,
    first_row: u32,
    rows: &mut [u8],
) {
    let size = job.paths.source;
    let stride = size.width as usize * C;
    let source = Source { avx2, values: job.source, stride };
    // Reads of a row may run past its end, but not past the next row, and window starts must fit 32
    // bits.
    let is_roomy = stride >= MAX_READ && u32::try_from(job.source.len()).is_ok();
    let mut stretch = Stretch::new();
    avx2.vectorize(
        #[inline(always)]
        || {
            let width = job.map.size().width as usize * C;
            for (row, target) in (first_row..).zip(rows.chunks_mut(width)) {
                let runs = job.map.row(row);
                for (index, &run) in runs.iter().enumerate() {
                    job.paths.prefetch(runs, index);
                    let walk = job.paths.walk(row, run);
                    if is_roomy
                        && walk.stays_inside(run.len, size)
                        && walk.samples().iter().product::<u32>() <= MAX_SAMPLES
                    {
                        if !stretch.continues(run, &walk) {
                            stretch.fill::<C, F>(&source, target);
                            stretch.begin(run, &walk);
                        }
                        let mut first = 0;
                        while first < run.len {
                            if stretch.is_full() {
                                stretch.fill::<C, F>(&source, target);
                            }
                            first += stretch.add::<C, F>(&source, &walk, first..run.len);
                        }
                    } else {
                        let texels = &mut target[run.x as usize * C..][..run.len as usize * C];
                        for (k, values) in (0..).zip(texels.chunks_exact_mut(C)) {
                            values.copy_from_slice(&texel_clamped::<C, F>(
                                &walk, k, job.source, size,
                            ));
                        }
                    }
                }
                stretch.fill::<C, F>(&source, target);
            }
        },
    );
}
