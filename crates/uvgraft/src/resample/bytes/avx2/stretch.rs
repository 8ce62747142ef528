//! Batches of texels from several runs.

use std::ops::Range;

use fearless_simd::{Avx2, Bytes, SimdBase, SimdFrom, SimdInt, f32x8, i32x8, i64x4, u32x8};

use super::super::{LOST, SUM_BITS, VALUE_BITS, share};
use super::group::{GROUP, GROUP_VALUES, Source};
use super::instructions;
use super::weights::{VectorTaps, Weights};
use super::window::{packed, windows};
use crate::filter::Taps;
use crate::map::Run;
use crate::resample::Walk;
use crate::resample::position::before_window;
use crate::resample::prefetch::prefetch;

/// Consecutive texels of a row with equal sample counts, whose window positions are computed. They
/// may come from several runs, so that runs shorter than a vector still fill one.
pub(super) struct Stretch {
    samples: [u32; 2],
    /// Column of the first texel, and number of texels.
    x: u32,
    count: usize,
    /// Maximum number of texels.
    room: usize,
    /// Starts of windows in the source, and fractions on both axes, indexed by sample and texel.
    /// Each sample has room for one group more than the maximum number of texels, since positions
    /// are written in whole groups.
    starts: Vec<i32>,
    bits: [Vec<u32>; 2],
}

/// Number of window positions that a stretch has room for.
const MAX_WINDOWS: usize = 2048;

/// Maximum number of samples per texel that leaves room for a group; texels with more are
/// computed one by one.
pub(super) const MAX_SAMPLES: u32 = (MAX_WINDOWS / (2 * GROUP)) as u32;

/// Maximum number of texels in a stretch, so that its data stays in the L1 cache.
const MAX_TEXELS: usize = 256;

impl Stretch {
    pub fn new() -> Self {
        Self {
            samples: [1, 1],
            x: 0,
            count: 0,
            room: MAX_TEXELS,
            starts: vec![0; MAX_WINDOWS],
            bits: [vec![0; MAX_WINDOWS], vec![0; MAX_WINDOWS]],
        }
    }

    /// Whether a run continues the stretch: it is adjacent, with the same sample counts.
    #[inline(always)]
    pub fn continues(&self, run: Run, walk: &Walk<'_>) -> bool {
        run.x == self.x + self.count as u32 && walk.samples() == self.samples
    }

    /// Starts a stretch, which must be empty, at a run.
    #[inline(always)]
    pub fn begin(&mut self, run: Run, walk: &Walk<'_>) {
        self.x = run.x;
        if walk.samples() != self.samples {
            self.samples = walk.samples();
            let [columns, rows] = self.samples;
            let groups = MAX_WINDOWS / (columns * rows) as usize / GROUP - 1;
            self.room = (groups * GROUP).min(MAX_TEXELS);
        }
    }

    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.count == self.room
    }

    /// Adds as many of a run's texels as there is room for; returns how many.
    #[inline(always)]
    pub fn add<const C: usize, F: VectorTaps>(
        &mut self,
        source: &Source<'_>,
        walk: &Walk<'_>,
        texels: Range<u32>,
    ) -> u32 {
        let count = texels.len().min(self.room - self.count);
        let [columns, rows] = self.samples;
        let ahead = walk.ahead(source.stride, C, F::TAPS);
        let mut first = self.count;
        for b in 0..rows {
            for a in 0..columns {
                let at = walk.sample(texels.start, a, b);
                let mut x = Line::new::<F>(source.avx2, at[0], walk.step()[0]);
                let mut y = Line::new::<F>(source.avx2, at[1], walk.step()[1]);
                for k in (first..first + count).step_by(GROUP) {
                    let (x, bits_x) = x.split(source.avx2);
                    let (y, bits_y) = y.split(source.avx2);
                    let starts = y * source.stride as i32 + x * C as i32;
                    starts.store_slice(&mut self.starts[k..][..GROUP]);
                    bits_x.store_slice(&mut self.bits[0][k..][..GROUP]);
                    bits_y.store_slice(&mut self.bits[1][k..][..GROUP]);
                    if (a, b) == (0, 0) {
                        let starts: [i32; GROUP] = starts.into();
                        for start in [starts[0], starts[GROUP - 1]] {
                            prefetch(source.values, (start as u32 as isize).wrapping_add(ahead));
                        }
                    }
                }
                first += self.room + GROUP;
            }
        }
        self.count += count;
        count as u32
    }

    /// Writes the texels to a row of the target. The stretch is then empty and begins after them.
    #[inline(always)]
    pub fn fill<const C: usize, F: VectorTaps>(&mut self, source: &Source<'_>, row: &mut [u8]) {
        if self.count == 0 {
            return;
        }
        let texels = &mut row[self.x as usize * C..][..self.count * C];
        if let Some(last) = self.count.checked_sub(GROUP) {
            for k in (0..self.count).step_by(GROUP) {
                // The last group starts earlier, so that it is full, and recomputes some texels.
                let first = k.min(last);
                let group = self.eight::<C, F>(source, first);
                texels[first * C..][..GROUP * C].copy_from_slice(&group[..GROUP * C]);
            }
        } else {
            // Windows beyond the last texel may lie outside the source; use the first one instead.
            let stride = self.room + GROUP;
            for starts in self.starts.chunks_exact_mut(stride) {
                let any = starts[0];
                starts[self.count..GROUP].fill(any);
            }
            let group = self.eight::<C, F>(source, 0);
            for (values, group) in texels.chunks_exact_mut(C).zip(group.chunks_exact(C)) {
                values.copy_from_slice(group);
            }
        }
        self.x += self.count as u32;
        self.count = 0;
    }

    /// The values of eight texels.
    #[inline(always)]
    fn eight<const C: usize, F: VectorTaps>(
        &self,
        source: &Source<'_>,
        first: usize,
    ) -> [u8; GROUP_VALUES] {
        let avx2 = source.avx2;
        let [columns, rows] = self.samples;
        if [columns, rows] == [1, 1] {
            const HALF: i32 = (1 << (VALUE_BITS - 1)) + LOST;
            let mut values = self.windows::<C, F>(source, first);
            for value in &mut values {
                *value = (*value + HALF) >> VALUE_BITS;
            }
            return packed::<C>(avx2, values);
        }
        let mut sums = [i32x8::splat(avx2, 0); 4];
        for sample in 0..(columns * rows) as usize {
            let values = self.windows::<C, F>(source, sample * (self.room + GROUP) + first);
            for j in 0..4 {
                sums[j] += (values[j] + LOST) >> (VALUE_BITS - SUM_BITS);
            }
        }
        let share = share([columns, rows]);
        for sum in &mut sums {
            *sum = instructions::rounded(avx2, sum.to_float::<f32x8<Avx2>>() * share);
        }
        packed::<C>(avx2, sums)
    }

    /// The values of eight windows, as [`super::super::filtered`].
    #[inline(always)]
    fn windows<const C: usize, F: VectorTaps>(
        &self,
        source: &Source<'_>,
        first: usize,
    ) -> [i32x8<Avx2>; 4] {
        let avx2 = source.avx2;
        let [bits_x, bits_y] = &self.bits;
        let across = F::Weights::new(avx2, u32x8::from_slice(avx2, &bits_x[first..][..GROUP]));
        let down = F::Weights::new(avx2, u32x8::from_slice(avx2, &bits_y[first..][..GROUP]));
        let starts = self.starts[first..].first_chunk().expect("a group more than texels");
        windows::<C, F>(source, starts, &across, &down)
    }
}

/// The positions of a group of texels on one axis, relative to the first texels of their windows.
struct Line {
    /// Texels 0, 1, 4 and 5 in `low`, and 2, 3, 6 and 7 in `high`: shuffles within halves
    /// put them in order.
    low: i64x4<Avx2>,
    high: i64x4<Avx2>,
    stride: i64,
}

impl Line {
    #[inline(always)]
    fn new<F: Taps>(avx2: Avx2, at: i64, step: i64) -> Self {
        let times = |k: i64| step.wrapping_mul(k);
        let low =
            i64x4::simd_from(avx2, [0, step, times(4), times(5)]) + (at - before_window(F::TAPS));
        Self { low, high: low + times(2), stride: times(GROUP as i64) }
    }

    /// Texels and fractions of this group, as [`split`](crate::resample::position::split); then
    /// advances to the next group.
    #[inline(always)]
    fn split(&mut self, avx2: Avx2) -> (i32x8<Avx2>, u32x8<Avx2>) {
        let [bits, texels] = instructions::unzipped(avx2, self.low.bitcast(), self.high.bitcast());
        self.low += self.stride;
        self.high += self.stride;
        (texels, bits.bitcast())
    }
}
