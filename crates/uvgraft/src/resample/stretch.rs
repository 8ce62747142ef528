//! Walks the runs of a map and collects the positions of consecutive texels, so that runs shorter
//! than a vector still fill one.

use std::ops::Range;

use fearless_simd::{Bytes, Simd, SimdBase, SimdInto, i32x16, i64x8, u32x16};

use super::path::{Paths, Walk};
use super::position::{before_window, halves};
use super::prefetch::prefetch;
use crate::filter::Taps;
use crate::map::{Run, SamplingMap};
use crate::texture::Value;

/// What all work items of a texture share.
pub(super) struct Job<'a, T> {
    pub map: &'a SamplingMap,
    pub paths: &'a Paths,
    /// `[height * width * C]` values of a texture of the size that `paths` are for.
    pub source: &'a [T],
}

/// Consecutive texels of a row with equal sample counts, whose windows lie inside the source.
pub(super) struct Stretch {
    samples: [u32; 2],
    /// Column of the first texel, and number of texels.
    x: u32,
    count: usize,
    /// Maximum number of texels.
    room: usize,
    starts: Box<[u32; MAX_WINDOWS]>,
    bits: [Box<[u32; MAX_WINDOWS]>; 2],
}

/// Texels that are located at once.
const GROUP: usize = 16;

/// Number of window positions that a stretch has room for.
const MAX_WINDOWS: usize = 4096;

/// Maximum number of samples per texel that leaves room for two groups; texels with more are
/// computed one by one.
const MAX_SAMPLES: u32 = (MAX_WINDOWS / (2 * GROUP)) as u32;

/// Maximum number of texels in a stretch, so that its data stays in the L1 cache.
pub(super) const MAX_TEXELS: usize = 256;

/// Values that must exist in a row of the source after the beginning of a window, which kernels read
/// in whole vectors.
const MAX_READ: usize = 32;

/// Fills rows of a target from `first_row` on.
///
/// - `fill`: writes the texels of a stretch, which are never none.
/// - `clamped`: writes the texels of a run whose windows may lie anywhere, or with too many samples.
#[inline(always)]
pub(super) fn fill_rows<S: Simd, T: Value, const C: usize, F: Taps>(
    simd: S,
    job: &Job<'_, T>,
    first_row: u32,
    rows: &mut [T],
    mut fill: impl FnMut(&mut Stretch, &mut [T]),
    mut clamped: impl FnMut(&Walk<'_>, &mut [T]),
) {
    let size = job.paths.source;
    let stride = size.width as usize * C;
    // Reads of a row may run past its end, but not past the next row, and window starts must fit 32
    // bits.
    let is_roomy = stride >= MAX_READ && u32::try_from(job.source.len()).is_ok();
    let mut stretch = Stretch::new();
    // One copy of the kernel for all places that call it; a call for hundreds of texels is cheap.
    let mut flush = |stretch: &mut Stretch, row: &mut [T]| {
        let texels = &mut row[stretch.x as usize * C..][..stretch.count * C];
        simd.vectorize(
            #[inline(always)]
            || fill(stretch, texels),
        );
        stretch.x += stretch.count as u32;
        stretch.count = 0;
    };
    let width = job.map.size().width as usize * C;
    for (row, target) in (first_row..).zip(rows.chunks_mut(width)) {
        let runs = job.map.row(row);
        for (index, &run) in runs.iter().enumerate() {
            job.paths.prefetch(runs, index);
            let walk = job.paths.walk(row, run);
            let [columns, rows] = walk.samples();
            if !(is_roomy && walk.stays_inside(run.len, size) && columns * rows <= MAX_SAMPLES) {
                clamped(&walk, &mut target[run.x as usize * C..][..run.len as usize * C]);
                continue;
            }
            let mut first = 0;
            while first < run.len {
                let continues = run.x + first == stretch.x + stretch.count as u32
                    && walk.samples() == stretch.samples;
                if !continues || stretch.count == stretch.room {
                    if stretch.count > 0 {
                        flush(&mut stretch, target);
                    }
                    stretch.begin(run, first, &walk);
                }
                first += stretch.add::<S, T, C, F>(simd, job.source, stride, &walk, first..run.len);
            }
        }
        if stretch.count > 0 {
            flush(&mut stretch, target);
        }
    }
}

impl Stretch {
    fn new() -> Self {
        let numbers = || Box::new([0; MAX_WINDOWS]);
        Self {
            samples: [1, 1],
            x: 0,
            count: 0,
            room: MAX_TEXELS,
            starts: numbers(),
            bits: [numbers(), numbers()],
        }
    }

    /// Starts a stretch, which must be empty, at texel `first` of a run.
    #[inline(always)]
    fn begin(&mut self, run: Run, first: u32, walk: &Walk<'_>) {
        self.x = run.x + first;
        if walk.samples() != self.samples {
            self.samples = walk.samples();
            let groups = MAX_WINDOWS / self.sample_count() / GROUP - 1;
            self.room = (groups * GROUP).min(MAX_TEXELS);
        }
    }

    /// Adds as many of a run's texels as there is room for; returns how many.
    #[inline(always)]
    fn add<S: Simd, T, const C: usize, F: Taps>(
        &mut self,
        simd: S,
        source: &[T],
        stride: usize,
        walk: &Walk<'_>,
        texels: Range<u32>,
    ) -> u32 {
        let count = texels.len().min(self.room - self.count);
        let [columns, rows] = self.samples;
        let mut first = self.count;
        let [step_x, step_y] = walk.step();
        let steps = [Steps::new(simd, step_x), Steps::new(simd, step_y)];
        let ahead = walk.ahead(stride, C, F::TAPS);
        for b in 0..rows {
            for a in 0..columns {
                let [x, y] = walk.sample_inside(texels.start, a, b);
                let mut x = steps[0].line(x.wrapping_sub(before::<F>()));
                let mut y = steps[1].line(y.wrapping_sub(before::<F>()));
                let mut done = 0;
                loop {
                    let (at, bits_x) = x.split();
                    let (row, bits_y) = y.split();
                    let starts: u32x16<S> = (row * stride as i32 + at * C as i32).bitcast();
                    let group = first + done..first + done + GROUP;
                    starts.store_slice(&mut self.starts[group.clone()]);
                    if F::TAPS > 1 {
                        bits_x.store_slice(&mut self.bits[0][group.clone()]);
                        bits_y.store_slice(&mut self.bits[1][group.clone()]);
                    }
                    if (a, b) == (0, 0) {
                        for k in [0, 5, 10, 15] {
                            let k = first + (done + k).min(count - 1);
                            let start = self.starts[k & (MAX_WINDOWS - 1)] as isize;
                            prefetch(source, start.wrapping_add(ahead));
                        }
                    }
                    done += GROUP;
                    if done >= count {
                        break;
                    }
                    x.advance(&steps[0]);
                    y.advance(&steps[1]);
                }
                first += self.stride();
            }
        }
        self.count += count;
        count as u32
    }

    /// Number of samples per texel.
    #[inline(always)]
    pub fn sample_count(&self) -> usize {
        (self.samples[0] * self.samples[1]) as usize
    }

    /// From a sample's positions to the next one's. Each sample has room for one group more than the
    /// maximum number of texels, since positions are written in whole groups.
    #[inline(always)]
    fn stride(&self) -> usize {
        self.room + GROUP
    }

    /// Where the windows of the first sample of all texels start.
    #[inline(always)]
    pub fn all_starts(&self) -> &[u32] {
        &self.starts[..self.count]
    }
}

/// What the kernels of x86-64 read.
#[cfg(target_arch = "x86_64")]
impl Stretch {
    /// Number of texels.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Number of samples per texel along the target's x and y.
    #[inline(always)]
    pub fn samples(&self) -> [u32; 2] {
        self.samples
    }

    /// For `N` texels from `first` on, where the windows of one of their samples start in the
    /// source, as indices of values.
    #[inline(always)]
    pub fn starts<const N: usize>(&self, sample: usize, first: usize) -> &[u32; N] {
        let from = &self.starts[sample * self.stride() + first..];
        from.first_chunk().expect("a group more than texels")
    }

    /// The distances of the same positions from the centres of the texels before them, along one
    /// axis of the source, in 2⁻³² texels.
    #[inline(always)]
    pub fn bits<const N: usize>(&self, axis: usize, sample: usize, first: usize) -> &[u32; N] {
        let from = &self.bits[axis][sample * self.stride() + first..];
        from.first_chunk().expect("a group more than texels")
    }

    /// Repeats the first texel's windows, so that there are `N` texels at least whose windows lie
    /// inside the source.
    #[inline(always)]
    pub fn pad<const N: usize>(&mut self) {
        const { assert!(N <= GROUP) }
        if self.count < N {
            let stride = self.stride();
            for sample in 0..self.sample_count() {
                let starts = &mut self.starts[sample * stride..][..N];
                let any = starts[0];
                starts[self.count..].fill(any);
            }
        }
    }
}

/// The offset to subtract from a position so that its integer part is the first texel of its
/// window.
#[inline(always)]
const fn before<F: Taps>() -> i64 {
    if F::TAPS == 1 { 0 } else { before_window(F::TAPS) }
}

/// Steps along a run on one axis, from its first texel to those of the first group.
struct Steps<S: Simd> {
    low: i64x8<S>,
    high: i64x8<S>,
    group: i64,
}

impl<S: Simd> Steps<S> {
    #[inline(always)]
    fn new(simd: S, step: i64) -> Self {
        // Lanes beyond the last texel of a run may hold anything, so overflow is harmless.
        let times = |k: i64| step.wrapping_mul(k);
        let mask = |lanes: [i64; 8]| -> i64x8<S> { lanes.simd_into(simd) };
        let low = (mask([0, -1, 0, -1, 0, -1, 0, -1]) & times(1))
            + (mask([0, 0, -1, -1, 0, 0, -1, -1]) & times(2))
            + (mask([0, 0, 0, 0, -1, -1, -1, -1]) & times(4));
        Self { low, high: low + times(8), group: times(GROUP as i64) }
    }

    /// The positions of the first group of a run that starts at a position.
    #[inline(always)]
    fn line(&self, start: i64) -> Line<S> {
        Line { low: self.low + start, high: self.high + start }
    }
}

/// The positions of a group of texels on one axis, relative to the first texels of their windows.
struct Line<S: Simd> {
    low: i64x8<S>,
    high: i64x8<S>,
}

impl<S: Simd> Line<S> {
    #[inline(always)]
    fn advance(&mut self, steps: &Steps<S>) {
        self.low += steps.group;
        self.high += steps.group;
    }

    /// Texels and fractions, as [`split`](super::position::split).
    #[inline(always)]
    fn split(&self) -> (i32x16<S>, u32x16<S>) {
        let [low, high]: [i32x16<S>; 2] = [self.low.bitcast(), self.high.bitcast()];
        let (texels, fractions) = halves(low.unzip_low(high), low.unzip_high(high));
        (texels, fractions.bitcast())
    }
}
