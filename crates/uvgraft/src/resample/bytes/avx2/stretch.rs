//! Texels of several runs together.

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

/// Neighbouring texels of one row with as many samples each, whose windows are known. They may belong
/// to several runs, so that these need not be as long as a vector.
pub(super) struct Stretch {
    samples: [u32; 2],
    /// The first texel's column, and how many there are.
    x: u32,
    count: usize,
    /// How many there may be.
    room: usize,
    /// By sample and texel: where windows begin in the source, and fractions on both axes. For each
    /// sample there is a group more than there may be texels: positions are written in groups.
    starts: Vec<i32>,
    bits: [Vec<u32>; 2],
}

/// Samples that a stretch has room for.
const MOST_PLACES: usize = 2048;

/// The most samples of a texel that leave a stretch room for a group; texels of more are worked out
/// one by one.
pub(super) const MOST_SAMPLES: u32 = (MOST_PLACES / (2 * GROUP)) as u32;

/// The most texels of a stretch, so that what is known of them stays in the first cache.
const MOST_TEXELS: usize = 256;

impl Stretch {
    pub fn new() -> Self {
        Self {
            samples: [1, 1],
            x: 0,
            count: 0,
            room: MOST_TEXELS,
            starts: vec![0; MOST_PLACES],
            bits: [vec![0; MOST_PLACES], vec![0; MOST_PLACES]],
        }
    }

    /// Whether a run's texels are the next ones.
    #[inline(always)]
    pub fn goes_on(&self, run: Run, walk: &Walk<'_>) -> bool {
        run.x == self.x + self.count as u32 && walk.samples() == self.samples
    }

    /// - This is empty.
    #[inline(always)]
    pub fn begin(&mut self, run: Run, walk: &Walk<'_>) {
        self.x = run.x;
        if walk.samples() != self.samples {
            self.samples = walk.samples();
            let [columns, rows] = self.samples;
            let groups = MOST_PLACES / (columns * rows) as usize / GROUP - 1;
            self.room = (groups * GROUP).min(MOST_TEXELS);
        }
    }

    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.count == self.room
    }

    /// Adds some of a run's texels, as many as there is room for; says how many.
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

    /// Fills the texels in a row of the target, and is empty then; begins behind them.
    #[inline(always)]
    pub fn fill<const C: usize, F: VectorTaps>(&mut self, source: &Source<'_>, row: &mut [u8]) {
        if self.count == 0 {
            return;
        }
        let texels = &mut row[self.x as usize * C..][..self.count * C];
        if let Some(last) = self.count.checked_sub(GROUP) {
            for k in (0..self.count).step_by(GROUP) {
                // The last group begins earlier instead of being shorter.
                let first = k.min(last);
                let group = self.eight::<C, F>(source, first);
                texels[first * C..][..GROUP * C].copy_from_slice(&group[..GROUP * C]);
            }
        } else {
            // Windows beyond the last texel's may lie anywhere.
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

    /// The values of eight windows, as [`super::filtered`].
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

/// The positions of a group of texels on one axis, from where the first windows begin.
struct Line {
    /// Texels 0, 1, 4 and 5, and 2, 3, 6 and 7: halves of them shuffle into order.
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

    /// Texels and fractions of this group, as [`split`](crate::resample::position::split); then goes
    /// on to the next.
    #[inline(always)]
    fn split(&mut self, avx2: Avx2) -> (i32x8<Avx2>, u32x8<Avx2>) {
        let [bits, texels] = instructions::unzipped(avx2, self.low.bitcast(), self.high.bitcast());
        self.low += self.stride;
        self.high += self.stride;
        (texels, bits.bitcast())
    }
}
