//! Filling a texture through a sampling map.
//!
//! [`reference()`](reference::resample) is the specification. The fast path does the same arithmetic
//! in the same order, so that both give the same bits.

pub(crate) mod adjoint;
pub(crate) mod fast;
mod places;
pub(crate) mod reads;
pub mod reference;
mod window;

use crate::filter::Filter;
use crate::map::{Patch, Run, SamplingMap};
use crate::texture::{Size, Value};
use crate::threads::map_indices;

/// The most samples per texel and axis under minification, and the most source texels that they
/// spread over. A texel that spans more belongs to a sliver or to a thumbnail.
const MAX_SAMPLES: f64 = 32.0;

/// Where a source of one size is read for each patch of a map, with one filter. Shared by all
/// kernels: they may differ in how they read, never in where.
#[derive(Debug, Clone)]
pub(crate) struct Paths {
    source: Size,
    filter: Filter,
    patches: Vec<Path>,
}

/// A patch's map and footprint in source texels.
#[derive(Debug, Clone, Copy)]
struct Path {
    origin_px: [f64; 2],
    origin: [f64; 2],
    slope: [[f64; 2]; 2],
    samples: [u32; 2],
    sample_steps: [[f64; 2]; 2],
    /// How far from a texel's centre its samples lie at most, along the source's x and y.
    spread: [f64; 2],
}

impl Paths {
    pub fn new(map: &SamplingMap, source: Size, filter: Filter) -> Self {
        let scale = [f64::from(source.width), f64::from(source.height)];
        let path = |patch: &Patch| {
            let affine = &patch.src_uv_from_tgt_px;
            let (samples, sample_steps) = footprint(patch, scale, filter);
            let spread = [0, 1].map(|axis| {
                let reach =
                    |k: usize| 0.5 * f64::from(samples[k] - 1) * sample_steps[k][axis].abs();
                reach(0) + reach(1)
            });
            Path {
                origin_px: affine.origin_px,
                origin: [0, 1].map(|axis| affine.origin_uv[axis] * scale[axis]),
                slope: [0, 1].map(|axis| affine.jacobian[axis].map(|value| value * scale[axis])),
                samples,
                sample_steps,
                spread,
            }
        };
        let patches = map_indices(map.patches().len(), |patch| path(&map.patches()[patch]));
        Self { source, filter, patches }
    }

    /// The source's size.
    pub fn source(&self) -> Size {
        self.source
    }

    /// The samples of one run.
    #[inline(always)]
    pub fn walk(&self, row: u32, run: Run) -> Walk {
        let path = &self.patches[run.patch as usize];
        let x = f64::from(run.x) + 0.5 - path.origin_px[0];
        let y = f64::from(row) + 0.5 - path.origin_px[1];
        let start =
            |axis: usize| path.origin[axis] + path.slope[axis][0] * x + path.slope[axis][1] * y;
        Walk {
            start: [start(0), start(1)],
            step: [path.slope[0][0], path.slope[1][0]],
            samples: path.samples,
            sample_steps: path.sample_steps,
            spread: path.spread,
        }
    }
}

/// Where the samples of one run lie in the source, in texels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Walk {
    start: [f64; 2],
    step: [f64; 2],
    /// How many samples a texel averages along the target's x and y.
    pub samples: [u32; 2],
    /// Source offset from one sample to the next along the target's x and y.
    sample_steps: [[f64; 2]; 2],
    spread: [f64; 2],
}

impl Walk {
    /// Source position of the centre of the run's texel `k`, in texels from the top left corner.
    #[inline(always)]
    pub fn at(&self, k: u32) -> [f64; 2] {
        let k = f64::from(k);
        [self.start[0] + k * self.step[0], self.start[1] + k * self.step[1]]
    }

    /// Whether the windows of all samples of the run's first `count` texels lie in the source: a run
    /// is straight, so it is enough to look at its ends.
    pub fn stays_inside(&self, count: u32, source: Size, taps: u32) -> bool {
        let ends = [self.at(0), self.at(count - 1)];
        [source.width, source.height].into_iter().enumerate().all(|(axis, size)| {
            // Half a window, and one texel more than rounding can be off.
            let margin = self.spread[axis] + f64::from(taps) * 0.5 + 1.0;
            ends.iter().all(|end| (margin..f64::from(size) - margin).contains(&end[axis]))
        })
    }

    /// Source position of sample `(a, b)` of the texel whose centre is at `centre`.
    #[inline(always)]
    pub fn sample(&self, centre: [f64; 2], a: u32, b: u32) -> [f64; 2] {
        let [a, b] = self.offsets(a, b);
        [0, 1].map(|i| centre[i] + a * self.sample_steps[0][i] + b * self.sample_steps[1][i])
    }

    /// The same on one axis, for texels `k`: the sum of `start`, `k · step`, and sample `(a, b)`'s two
    /// offsets, in this order.
    #[inline(always)]
    fn line(&self, axis: usize, a: u32, b: u32) -> [f64; 4] {
        let [a, b] = self.offsets(a, b);
        let steps = [0, 1].map(|k| self.sample_steps[k][axis]);
        [self.start[axis], self.step[axis], a * steps[0], b * steps[1]]
    }

    /// How many steps sample `(a, b)` lies from the centre.
    #[inline(always)]
    fn offsets(&self, a: u32, b: u32) -> [f64; 2] {
        [(a, 0), (b, 1)].map(|(n, k)| f64::from(n) - f64::from(self.samples[k] - 1) * 0.5)
    }
}

/// How many samples a texel takes on each axis, and the source offsets between them: one for each
/// source texel that the target texel spans along that axis, rounded, so that what is about as
/// dense stays sharp and what is denser is averaged.
fn footprint(patch: &Patch, scale: [f64; 2], filter: Filter) -> ([u32; 2], [[f64; 2]; 2]) {
    if filter == Filter::Nearest {
        return ([1, 1], [[0.0; 2]; 2]);
    }
    let (mut samples, mut steps) = ([1, 1], [[0.0; 2]; 2]);
    for axis in 0..2 {
        let span = [0, 1].map(|k| patch.jacobian[k][axis] * scale[k]);
        let length = span[0].hypot(span[1]);
        samples[axis] = length.round().clamp(1.0, MAX_SAMPLES) as u32;
        steps[axis] =
            span.map(|component| component / f64::from(samples[axis]).max(length / MAX_SAMPLES));
    }
    (samples, steps)
}

/// A position on one axis, moved close to the texture where it is far off, as UV coordinates may be:
/// beyond a window's width nothing changes any more, and [`split`] needs numbers of a sane size.
#[inline(always)]
pub(crate) fn near_texture(position: f64, count: u32) -> f64 {
    position.clamp(-NEAR, f64::from(count) + NEAR)
}

/// How far beyond the texture's edge positions may be, in texels: more than any window is wide.
const NEAR: f64 = 8.0;

/// Adding 1.5 · 2⁵² leaves no bits for a fraction, so the sum is rounded to a whole number, whose
/// two's complement is in its low bits.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// The texel before a position on one axis, and how far the position lies beyond its centre: 0 to 1,
/// both included. The position is in or near a texture, see [`near_texture`].
#[inline(always)]
pub(crate) fn split(position: f64) -> (i32, f32) {
    // Half a texel down for the centre, and half for rounding instead of flooring. `floor` would be a
    // call where the baseline has no instruction for it.
    let sum = position - 1.0 + WHOLE;
    let whole = sum - WHOLE;
    (sum.to_bits() as i32, (position - 0.5 - whole) as f32)
}

/// Reads a texel as levels, colour multiplied by opacity if the last channel is that.
#[inline(always)]
pub(crate) fn load<T: Value, const C: usize, const OPACITY: bool>(texel: &[T]) -> [f32; C] {
    let mut levels: [f32; C] = std::array::from_fn(|channel| texel[channel].to_level());
    if OPACITY {
        let opacity = levels[C - 1] / T::ONE.to_level();
        for level in &mut levels[..C - 1] {
            *level *= opacity;
        }
    }
    levels
}

/// Lays filtered levels over what is there; replaces it if no channel is opacity.
#[inline(always)]
pub(crate) fn store<T: Value, const C: usize, const OPACITY: bool>(
    levels: [f32; C],
    texel: &mut [T],
) {
    if OPACITY {
        let one = T::ONE.to_level();
        // Cubic filters over- and undershoot at edges of opacity, and premultiplied colours with
        // it. Below none nothing is laid over; beyond full the colour is scaled back too.
        if levels[C - 1] <= 0.0 {
            return;
        }
        let alpha = levels[C - 1].min(one);
        let scale = alpha / levels[C - 1] * one;
        let below = (one - alpha) / one * texel[C - 1].to_level();
        let total = alpha + below;
        for channel in 0..C - 1 {
            let level = levels[channel] * scale + texel[channel].to_level() * below;
            texel[channel] = T::from_level(level / total);
        }
        texel[C - 1] = T::from_level(total);
    } else {
        for (channel, level) in levels.into_iter().enumerate() {
            texel[channel] = T::from_level(level);
        }
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, Simd};

    use super::*;
    use crate::map::MapOptions;
    use crate::mesh::Mesh;
    use crate::pair::{Direction, Pair};

    /// Triangles strewn over both layouts: some steep, some shrunk, many beyond the border.
    fn map(seed: u64, size: Size) -> SamplingMap {
        let mut rng = fastrand::Rng::with_seed(seed);
        // The fourth reads far outside the source.
        let far = if seed == 4 { 1e9 } else { 1.0 };
        let mut mesh = |far: f32| {
            let uv: Vec<[f32; 2]> = (0..20)
                .flat_map(|_| {
                    let at = [rng.f32(), rng.f32()];
                    let side = rng.f32() * rng.f32() * 0.7;
                    [(); 3].map(|()| at.map(|value| value * far + (rng.f32() - 0.5) * side))
                })
                .collect();
            let faces: Vec<[u32; 3]> =
                (0..20).map(|face| [0, 1, 2].map(|k| face * 3 + k)).collect();
            Mesh::from_triangles(vec![[0.0; 3]; 60], uv, &faces, &faces).unwrap()
        };
        let vertex_map: Vec<i64> = (0..60).collect();
        let pair = Pair::by_vertex_map(mesh(far), mesh(1.0), &vertex_map).unwrap();
        SamplingMap::new(&pair, Direction::Forward, size, &MapOptions { gutter_px: 3 })
    }

    /// Every level that kernels are compiled for, as far as this machine has it.
    fn levels() -> Vec<Level> {
        let best = Level::new();
        #[cfg(target_arch = "x86_64")]
        let levels = [best.as_avx2().map(Simd::level), best.as_sse2().map(Simd::level)];
        #[cfg(not(target_arch = "x86_64"))]
        let levels = [Some(best)];
        levels.into_iter().flatten().collect()
    }

    fn compare<T: Value, const C: usize, const OPACITY: bool>(value: fn(&mut fastrand::Rng) -> T) {
        let mut rng = fastrand::Rng::with_seed(C as u64);
        for (seed, source_size, size) in [
            (1, Size::new(37, 61), Size::new(90, 53)),
            (2, Size::new(200, 150), Size::new(64, 40)),
            (3, Size::new(3, 2), Size::new(33, 70)),
            (4, Size::new(40, 30), Size::new(30, 30)),
            // Runs of several batches.
            (5, Size::new(64, 80), Size::new(700, 61)),
        ] {
            let map = map(seed, size);
            let source: Vec<T> = (0..source_size.texels() * C).map(|_| value(&mut rng)).collect();
            let base: Vec<T> = (0..size.texels() * C).map(|_| value(&mut rng)).collect();
            for filter in Filter::ALL {
                let mut wanted = base.clone();
                reference::resample::<T, C, OPACITY>(
                    &map,
                    &source,
                    source_size,
                    &mut wanted,
                    filter,
                );
                assert!(wanted != base);
                let paths = Paths::new(&map, source_size, filter);
                for level in levels() {
                    let mut fast = base.clone();
                    // In two bands, neither of whole pieces.
                    let (top, rest) = fast.split_at_mut(21 * size.width as usize * C);
                    fast::resample::<T, C, OPACITY>(level, &map, &paths, &source, 0, top);
                    fast::resample::<T, C, OPACITY>(level, &map, &paths, &source, 21, rest);
                    assert!(fast == wanted, "{filter}, {C} channels, seed {seed}, {level:?}");
                }
            }
        }
    }

    #[test]
    fn every_level_equals_the_reference_to_the_bit() {
        compare::<u8, 1, false>(|rng| rng.u8(..));
        compare::<u8, 2, true>(|rng| rng.u8(..));
        compare::<u8, 3, false>(|rng| rng.u8(..));
        compare::<u8, 4, true>(|rng| rng.u8(..));
        compare::<u8, 4, false>(|rng| rng.u8(..));
        compare::<u16, 2, false>(|rng| rng.u16(..));
        compare::<u16, 3, false>(|rng| rng.u16(..));
        compare::<u16, 4, true>(|rng| rng.u16(..));
        compare::<f32, 1, false>(fastrand::Rng::f32);
        compare::<f32, 3, false>(fastrand::Rng::f32);
        compare::<f32, 4, true>(fastrand::Rng::f32);
    }

    /// What both paths share they cannot check in each other, so it is pinned by hand.
    #[test]
    fn positions_and_samples_by_hand() {
        let uv = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let mesh = |scale: f32| {
            let uv: Vec<[f32; 2]> = uv.iter().map(|&[u, v]| [u * scale, v]).collect();
            Mesh::from_triangles(vec![[0.0; 3]; 3], uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap()
        };
        let pair = Pair::by_vertex_map(mesh(1.0), mesh(0.5), &[0, 1, 2]).unwrap();
        let map = SamplingMap::new(
            &pair,
            Direction::Forward,
            Size::square(8),
            &MapOptions { gutter_px: 0 },
        );
        // A target texel is an eighth; in u the source spans twice as much, so 4 source texels of 16.
        let run = map.row(1)[0];
        let walk = Paths::new(&map, Size::square(16), Filter::Bilinear).walk(1, run);
        assert_eq!(walk.samples, [4, 2]);
        assert_eq!(walk.at(0), [2.0, 3.0]);
        assert_eq!(walk.at(1), [6.0, 3.0]);
        assert_eq!(walk.sample([2.0, 3.0], 0, 0), [0.5, 2.5]);
        assert_eq!(walk.sample([2.0, 3.0], 3, 1), [3.5, 3.5]);
        assert_eq!(split(0.25), (-1, 0.75));
        assert_eq!(split(2.5), (2, 0.0));
        assert_eq!(near_texture(1e30, 64), 72.0);
        assert_eq!(near_texture(-1e30, 64), -8.0);
    }

    #[test]
    fn laying_over_by_hand() {
        let mut opaque = [10u8, 20, 30, 255];
        // Half of level 200, premultiplied, over the base.
        store::<u8, 4, true>([100.0, 100.0, 100.0, 127.5], &mut opaque);
        assert_eq!(opaque, [105, 110, 115, 255]);
        let mut clear = [9u8, 9, 9, 0];
        store::<u8, 4, true>([100.0, 50.0, 0.0, 127.5], &mut clear);
        assert_eq!(clear, [200, 100, 0, 128]);
        store::<u8, 4, true>([0.0, 0.0, 0.0, 0.0], &mut clear);
        assert_eq!(clear, [200, 100, 0, 128]);
        // Undershoot leaves the base alone; overshoot scales colour and opacity back together.
        store::<u8, 4, true>([-20.0, -20.0, -20.0, -20.0], &mut clear);
        assert_eq!(clear, [200, 100, 0, 128]);
        store::<u8, 4, true>([204.0, 102.0, 51.0, 306.0], &mut clear);
        assert_eq!(clear, [170, 85, 43, 255]);
        let mut grey = [0u8];
        store::<u8, 1, false>([99.5], &mut grey);
        assert_eq!(grey, [100]);
        assert_eq!(load::<u8, 2, true>(&[200, 51]), [40.0, 51.0]);
        assert_eq!(load::<u8, 2, false>(&[200, 51]), [200.0, 51.0]);
    }
}
