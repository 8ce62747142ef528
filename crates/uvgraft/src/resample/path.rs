//! Where the runs of a map read in a source: shared by all kernels, which may differ in how they read
//! texels, never in which ones.

use uvgraft_surface::threads::map_indices;

use super::footprint::PlannedFootprint;
use super::position::{TEXEL, containing, from_texels};
use super::prefetch::{self, prefetch};
use crate::filter::Filter;
use crate::map::{Patch, Run, SamplingMap};
use crate::texture::Size;

/// Maximum number of samples per texel and axis under minification, and maximum number of source
/// texels that they spread over. Texels that span more belong to slivers or to thumbnails.
const MAX_SAMPLES: f64 = 32.0;

/// Samples that texels may take on average, for each texel of both textures: a source that a target shows
/// once takes at most as many as it has texels (0.25 and 0.75 between FLAME, SMPL-X and HiFi3D++). Noise could
/// take 512, and 512² texels of it took 45 seconds.
const MEAN_SAMPLES: u64 = 64;

/// Rows whose samples are counted at once.
const BLOCK_ROWS: u32 = 64;

/// Positions of patches that stay below this everywhere on the target need no care with overflow:
/// 2³⁰ texels.
const FAR: f64 = (1_u64 << 62) as f64;

/// Source positions of all patches of a map, for one source size and filter.
#[derive(Debug, Clone)]
pub(crate) struct Paths {
    pub source: Size,
    pub filter: Filter,
    patches: Vec<Path>,
    footprints: Vec<Footprint>,
}

/// A patch's map in the source: what every run needs, in one cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Path {
    /// Source position of the centre of the target's first texel, modulo 2⁶⁴: sums that stay within
    /// 64 bits are right even if their terms do not.
    origin: [i64; 2],
    /// Derivatives, indexed by source axis, then target axis.
    slope: [[i64; 2]; 2],
    /// [`Footprint::reach`] in whole texels, rounded up.
    margin: [u16; 2],
    samples: [u8; 2],
    /// Whether positions may overflow somewhere on the target, so that they have to saturate.
    is_far: bool,
}

/// The samples of a patch's texels, and what only patches far off need.
#[derive(Debug, Clone, Copy)]
struct Footprint {
    samples: [u32; 2],
    first_sample: [i64; 2],
    sample_steps: [[i64; 2]; 2],
    /// Maximum distance from a texel's position to the outer edge of its samples' windows, along
    /// the source's x and y.
    reach: [i64; 2],
    /// The target texel that contains the origin of the patch's map.
    px: [i32; 2],
}

impl Footprint {
    /// - `most`: samples on each axis.
    fn new(patch: &Patch, source: Size, filter: Filter, most: u32) -> Self {
        let scale = [f64::from(source.width), f64::from(source.height)];
        let (samples, steps) = footprint(patch, scale, filter, most);
        let offset = |k: usize| 0.5 * f64::from(samples[k] - 1);
        let by_axis = |value: &dyn Fn(usize) -> f64| [0, 1].map(|axis| from_texels(value(axis)));
        Self {
            samples,
            first_sample: by_axis(&|axis| -offset(0) * steps[0][axis] - offset(1) * steps[1][axis]),
            sample_steps: steps.map(|step| step.map(from_texels)),
            // Half a window, and a texel more, which exceeds any rounding error.
            reach: by_axis(&|axis| {
                let spread = offset(0) * steps[0][axis].abs() + offset(1) * steps[1][axis].abs();
                spread + filter.taps() as f64 * 0.5 + 1.0
            }),
            // Casts saturate; patches so far off own no texel.
            px: patch.src_uv_from_tgt_px.origin_px.map(|px| px.floor() as i32),
        }
    }
}

impl Path {
    fn new(patch: &Patch, footprint: &Footprint, source: Size, target: Size) -> Self {
        let scale = [f64::from(source.width), f64::from(source.height)];
        let affine = &patch.src_uv_from_tgt_px;
        let px = footprint.px;
        let centre = affine.at(px.map(|px| f64::from(px) + 0.5));
        let centre = [0, 1].map(|axis| from_texels(centre[axis] * scale[axis]));
        let slope =
            [0, 1].map(|axis| affine.jacobian[axis].map(|slope| from_texels(slope * scale[axis])));
        let is_near = (0..2).all(|axis| {
            let sides = [target.width, target.height];
            let terms = (0..2).map(|k| {
                let distance = f64::from(px[k]).abs() + f64::from(sides[k]);
                (slope[axis][k] as f64).abs() * distance
            });
            (centre[axis] as f64).abs() + terms.sum::<f64>() < FAR
        });
        Self {
            origin: [0, 1].map(|axis| {
                let [by_x, by_y] = slope[axis];
                let [x, y] = px.map(i64::from);
                centre[axis].wrapping_sub(by_x.wrapping_mul(x)).wrapping_sub(by_y.wrapping_mul(y))
            }),
            slope,
            // Casts saturate, and few texels are that far from all edges.
            margin: footprint.reach.map(|reach| (reach as u64).div_ceil(TEXEL as u64) as u16),
            samples: footprint.samples.map(|count| count as u8),
            is_far: !is_near,
        }
    }
}

impl Paths {
    pub fn new(map: &SamplingMap, source: Size, filter: Filter) -> Self {
        let patches = map.patches();
        let most = most_samples(map, source, filter);
        let footprint = |patch: usize| Footprint::new(&patches[patch], source, filter, most);
        let footprints = map_indices(patches.len(), footprint);
        let path =
            |patch: usize| Path::new(&patches[patch], &footprints[patch], source, map.size());
        Self { source, filter, patches: map_indices(patches.len(), path), footprints }
    }

    /// The source's size.
    pub fn source(&self) -> Size {
        self.source
    }

    /// Derivatives of a patch, indexed by source axis, then target axis.
    pub fn slope(&self, patch: usize) -> [[i64; 2]; 2] {
        self.patches[patch].slope
    }

    /// Maximum distance from a texel's position to the outer edge of its samples' windows, along
    /// the source's x and y.
    pub fn reach(&self, patch: usize) -> [i64; 2] {
        self.footprints[patch].reach
    }

    /// The samples of a patch's texels.
    pub fn footprint(&self, patch: usize) -> PlannedFootprint {
        let Footprint { samples, first_sample: first, sample_steps: steps, .. } =
            self.footprints[patch];
        PlannedFootprint { samples, first, steps }
    }

    /// Prefetches the path of the run after the next.
    #[inline(always)]
    pub(super) fn prefetch(&self, runs: &[Run], index: usize) {
        if let Some(run) = runs.get(index + 2) {
            prefetch(&self.patches, run.patch as isize);
        }
    }

    /// The sample positions of one run.
    #[inline(always)]
    pub fn walk(&self, row: u32, run: Run) -> Walk<'_> {
        let path = &self.patches[run.patch as usize];
        let start = if path.is_far {
            self.far_start(row, run)
        } else {
            let at = |axis: usize| {
                let [by_x, by_y] = path.slope[axis];
                let start = path.origin[axis].wrapping_add(by_x.wrapping_mul(run.x.into()));
                start.wrapping_add(by_y.wrapping_mul(row.into()))
            };
            [at(0), at(1)]
        };
        Walk { start, path, footprints: &self.footprints, patch: run.patch }
    }

    /// The first position of a run that may lie far off.
    #[cold]
    fn far_start(&self, row: u32, run: Run) -> [i64; 2] {
        let path = &self.patches[run.patch as usize];
        let px = self.footprints[run.patch as usize].px.map(i64::from);
        let [x, y] = [i64::from(run.x) - px[0], i64::from(row) - px[1]];
        [0, 1].map(|axis| {
            let [by_x, by_y] = path.slope[axis];
            // The position of texel `px` itself fits 64 bits.
            let origin = path.origin[axis].wrapping_add(by_x.wrapping_mul(px[0]));
            let origin = origin.wrapping_add(by_y.wrapping_mul(px[1]));
            // On thin triangles both products may lie far outside the texture although
            // their sum does not.
            let start = i128::from(origin)
                + i128::from(by_x) * i128::from(x)
                + i128::from(by_y) * i128::from(y);
            start.clamp(i64::MIN.into(), i64::MAX.into()) as i64
        })
    }
}

/// Source positions of the samples of one run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Walk<'a> {
    start: [i64; 2],
    path: &'a Path,
    footprints: &'a [Footprint],
    patch: u32,
}

impl Walk<'_> {
    /// Number of samples per texel along the target's x and y.
    #[inline(always)]
    pub fn samples(&self) -> [u32; 2] {
        [self.path.samples[0].into(), self.path.samples[1].into()]
    }

    /// Whether positions may be so far off that they saturate.
    pub fn is_far(&self) -> bool {
        self.path.is_far
    }

    /// Step in source position from one texel to the next.
    #[inline(always)]
    pub fn step(&self) -> [i64; 2] {
        [self.path.slope[0][0], self.path.slope[1][0]]
    }

    /// Offset, in values of the source, from a value of a window to the values that the windows a
    /// few target rows later are the first to read; for [`prefetch()`].
    ///
    /// - `stride`: values per source row, with `channels` values per texel.
    #[inline(always)]
    pub(super) fn ahead(&self, stride: usize, channels: usize, taps: usize) -> isize {
        let by_row = |axis: usize| self.path.slope[axis][1].wrapping_mul(prefetch::ROWS_AHEAD);
        let (x, y) = (containing(by_row(0)) as isize, containing(by_row(1)) as isize);
        // Windows that move down reach new rows at their lower end, others at their upper end.
        let below = if y > 0 { taps as isize - 1 } else { 0 };
        let rows = y.wrapping_add(below).wrapping_mul(stride as isize);
        rows.wrapping_add(x.wrapping_mul(channels as isize))
    }

    /// Source position of the centre of the run's texel `k`.
    #[inline(always)]
    pub fn centre(&self, k: u32) -> [i64; 2] {
        let [x, y] = self.step();
        let at = |axis: usize, step: i64| {
            self.start[axis].saturating_add(step.saturating_mul(i64::from(k)))
        };
        [at(0, x), at(1, y)]
    }

    /// Source position of sample `(a, b)` of the run's texel `k`.
    #[inline(always)]
    pub fn sample(&self, k: u32, a: u32, b: u32) -> [i64; 2] {
        let [x, y] = self.centre(k);
        let [by_x, by_y] = self.offset(a, b);
        // Steps are no larger than textures, so only the centre may overflow the sum.
        [x.saturating_add(by_x), y.saturating_add(by_y)]
    }

    /// Offset of sample `(a, b)` from a texel's position.
    #[inline(always)]
    fn offset(&self, a: u32, b: u32) -> [i64; 2] {
        if self.path.samples == [1, 1] {
            return [0, 0];
        }
        let Footprint { first_sample, sample_steps: [by_a, by_b], .. } =
            &self.footprints[self.patch as usize];
        let of = |axis: usize| {
            first_sample[axis] + i64::from(a) * by_a[axis] + i64::from(b) * by_b[axis]
        };
        [of(0), of(1)]
    }

    /// As [`Walk::sample`], for a run that [stays inside](Walk::stays_inside) the source.
    #[inline(always)]
    pub(super) fn sample_inside(&self, k: u32, a: u32, b: u32) -> [i64; 2] {
        let ([x, y], [by_x, by_y]) = (self.centre_near(k), self.offset(a, b));
        [x.wrapping_add(by_x), y.wrapping_add(by_y)]
    }

    /// As [`Walk::centre`], for patches that are not far.
    #[inline(always)]
    fn centre_near(&self, k: u32) -> [i64; 2] {
        let [x, y] = self.step();
        let at =
            |axis: usize, step: i64| self.start[axis].wrapping_add(step.wrapping_mul(k.into()));
        [at(0, x), at(1, y)]
    }

    /// Maximum distance from a texel's position to the outer edge of its samples' windows, along
    /// the source's x and y.
    pub fn reach(&self) -> [i64; 2] {
        self.footprints[self.patch as usize].reach
    }

    /// Whether the windows of all samples of the run's first `count` texels certainly lie inside the
    /// source. Positions along a run are collinear, so checking both ends suffices.
    #[inline(always)]
    pub fn stays_inside(&self, count: u32, source: Size) -> bool {
        let (first, last) = (self.start, self.centre_near(count - 1));
        let is_inside = |axis: usize, side: u32| {
            let least = i64::from(self.path.margin[axis]) << 32;
            // Negative for textures smaller than the margins.
            let room = (i64::from(side) << 32) - 2 * least;
            // Not evaluated one by one: together they cost less than a branch each.
            let [first, last] = [first, last].map(|end| end[axis].wrapping_sub(least) as u64);
            (room > 0) & (first < room as u64) & (last < room as u64)
        };
        !self.path.is_far & is_inside(0, source.width) & is_inside(1, source.height)
    }
}

/// The number of samples per texel on each target axis, and the source offsets between them. With
/// `length` source texels spanned along an axis, there are `round(length)` samples: a source about
/// as dense as the target stays sharp, a denser one is averaged instead of aliasing.
pub(super) fn footprint(
    patch: &Patch,
    scale: [f64; 2],
    filter: Filter,
    most: u32,
) -> ([u32; 2], [[f64; 2]; 2]) {
    if filter == Filter::Nearest {
        return ([1, 1], [[0.0; 2]; 2]);
    }
    let (mut samples, mut steps) = ([1, 1], [[0.0; 2]; 2]);
    for axis in 0..2 {
        let span = [0, 1].map(|k| patch.jacobian[k][axis] * scale[k]);
        let length = span[0].hypot(span[1]);
        let wanted = length.round().clamp(1.0, MAX_SAMPLES);
        samples[axis] = (wanted as u32).min(most);
        // Fewer samples than wanted spread over as much.
        let spread = wanted / f64::from(samples[axis]);
        steps[axis] = span.map(|component| component / wanted.max(length / MAX_SAMPLES) * spread);
    }
    (samples, steps)
}

/// How many samples a texel may have on each axis, so that all together have no more than
/// [`MEAN_SAMPLES`] on average: [`MAX_SAMPLES`], unless most texels span more of the source than their
/// share, as those of noise do.
fn most_samples(map: &SamplingMap, source: Size, filter: Filter) -> u32 {
    let scale = [f64::from(source.width), f64::from(source.height)];
    let budget = MEAN_SAMPLES * (source.texels() + map.size().texels()) as u64;
    let of_patch = |patch: usize| footprint(&map.patches()[patch], scale, filter, u32::MAX).0;
    let wanted = map_indices(map.patches().len(), of_patch);
    let all = |most: u32| -> u64 {
        let samples = |run: &Run| {
            let [a, b] = wanted[run.patch as usize].map(|count| u64::from(count.min(most)));
            u64::from(run.len) * a * b
        };
        let height = map.size().height;
        let of_block = |block: usize| -> u64 {
            let first = block as u32 * BLOCK_ROWS;
            let rows = first..(first + BLOCK_ROWS).min(height);
            rows.flat_map(|row| map.row(row)).map(samples).sum()
        };
        map_indices(height.div_ceil(BLOCK_ROWS) as usize, of_block).into_iter().sum()
    };
    let mut most = MAX_SAMPLES as u32;
    while most > 1 && all(most) > budget {
        most /= 2;
    }
    most
}
