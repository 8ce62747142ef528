//! Filling a texture through a sampling map.
//!
//! [`reference()`](reference::resample) is the specification. The fast paths give the same bits: for
//! 8 bits without opacity in whole numbers (`bytes`), else in floats and the same order (`fast`).

pub(crate) mod adjoint;
mod bytes;
pub(crate) mod fast;
mod places;
pub(crate) mod position;
mod prefetch;
pub(crate) mod reads;
pub mod reference;
mod window;

use self::position::{TEXEL, containing, from_texels};
use self::prefetch::prefetch;
use crate::filter::Filter;
use crate::map::{Patch, Run, SamplingMap};
use crate::texture::{Size, Value};
use crate::threads::map_indices;

/// The most samples per texel and axis under minification, and the most source texels that they
/// spread over. A texel that spans more belongs to a sliver or to a thumbnail.
const MAX_SAMPLES: f64 = 32.0;

/// Rows of the target that one piece of work fills.
const ROWS: usize = 16;

/// Where a source of one size is read for each patch of a map, with one filter. Shared by all
/// kernels: they may differ in how they read, never in where.
#[derive(Debug, Clone)]
pub(crate) struct Paths {
    source: Size,
    filter: Filter,
    patches: Vec<Path>,
}

/// A patch's map and footprint in the source, in positions as [`position`] has them.
#[derive(Debug, Clone, Copy)]
#[repr(align(128))]
struct Path {
    /// The texel of the target that the patch's map begins at.
    px: [i32; 2],
    /// What its centre maps to.
    origin: [i64; 2],
    /// By axis of the source and of the target.
    slope: [[i64; 2]; 2],
    samples: [u32; 2],
    first_sample: [i64; 2],
    sample_steps: [[i64; 2]; 2],
    /// How far from a texel's centre its samples' windows reach at most, along the source's x and y.
    reach: [i64; 2],
}

impl Path {
    fn new(patch: &Patch, source: Size, filter: Filter) -> Self {
        let scale = [f64::from(source.width), f64::from(source.height)];
        let affine = &patch.src_uv_from_tgt_px;
        // Casts saturate: such patches belong to no texel.
        let px = affine.origin_px.map(|px| px.floor() as i32);
        let centre = affine.at(px.map(|px| f64::from(px) + 0.5));
        let (samples, steps) = footprint(patch, scale, filter);
        let offset = |k: usize| 0.5 * f64::from(samples[k] - 1);
        let by_axis = |value: &dyn Fn(usize) -> f64| [0, 1].map(|axis| from_texels(value(axis)));
        Self {
            px,
            origin: by_axis(&|axis| centre[axis] * scale[axis]),
            slope: [0, 1]
                .map(|axis| affine.jacobian[axis].map(|slope| from_texels(slope * scale[axis]))),
            samples,
            first_sample: by_axis(&|axis| -offset(0) * steps[0][axis] - offset(1) * steps[1][axis]),
            sample_steps: steps.map(|step| step.map(from_texels)),
            // Half a window, and one texel more than rounding can be off.
            reach: by_axis(&|axis| {
                let spread = offset(0) * steps[0][axis].abs() + offset(1) * steps[1][axis].abs();
                spread + filter.taps() as f64 * 0.5 + 1.0
            }),
        }
    }
}

impl Paths {
    pub fn new(map: &SamplingMap, source: Size, filter: Filter) -> Self {
        let path = |patch: usize| Path::new(&map.patches()[patch], source, filter);
        Self { source, filter, patches: map_indices(map.patches().len(), path) }
    }

    /// The source's size.
    pub fn source(&self) -> Size {
        self.source
    }

    /// Asks for what the walk along the run after the next needs.
    #[inline(always)]
    fn prefetch(&self, runs: &[Run], index: usize) {
        if let Some(run) = runs.get(index + 2) {
            prefetch(&self.patches, run.patch as isize);
        }
    }

    /// The samples of one run.
    #[inline(always)]
    pub fn walk(&self, row: u32, run: Run) -> Walk<'_> {
        let path = &self.patches[run.patch as usize];
        let x = i64::from(run.x) - i64::from(path.px[0]);
        let y = i64::from(row) - i64::from(path.px[1]);
        let start = [0, 1].map(|axis| {
            let [by_x, by_y] = path.slope[axis].map(i128::from);
            // On thin triangles both products are far beyond the texture, and their sum is not.
            let start = i128::from(path.origin[axis]) + by_x * i128::from(x) + by_y * i128::from(y);
            start.clamp(i64::MIN.into(), i64::MAX.into()) as i64
        });
        Walk { start, path }
    }
}

/// Where the samples of one run lie in the source.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Walk<'a> {
    start: [i64; 2],
    path: &'a Path,
}

impl Walk<'_> {
    /// How many samples a texel averages along the target's x and y.
    #[inline(always)]
    pub fn samples(&self) -> [u32; 2] {
        self.path.samples
    }

    /// From one texel's samples to the next one's.
    #[inline(always)]
    pub fn step(&self) -> [i64; 2] {
        self.path.slope.map(|[by_x, _]| by_x)
    }

    /// From a value of a window to what is new in the windows that a later row of the target has
    /// there, in values of the source; for [`prefetch()`].
    ///
    /// - `stride`: values in a row of the source, of `channels` a texel.
    #[inline(always)]
    fn ahead(&self, stride: usize, channels: usize, taps: usize) -> isize {
        let [x, y] = self
            .path
            .slope
            .map(|[_, by_y]| containing(by_y.wrapping_mul(prefetch::ROWS_AHEAD)) as isize);
        // Windows that move down meet new rows below, others above.
        let below = if y > 0 { taps as isize - 1 } else { 0 };
        let rows = y.wrapping_add(below).wrapping_mul(stride as isize);
        rows.wrapping_add(x.wrapping_mul(channels as isize))
    }

    /// Position of the centre of the run's texel `k`.
    #[inline(always)]
    pub fn centre(&self, k: u32) -> [i64; 2] {
        [0, 1].map(|axis| {
            self.start[axis].saturating_add(self.step()[axis].saturating_mul(i64::from(k)))
        })
    }

    /// Position of sample `(a, b)` of the run's texel `k`.
    #[inline(always)]
    pub fn sample(&self, k: u32, a: u32, b: u32) -> [i64; 2] {
        let Path { first_sample, sample_steps: [by_a, by_b], .. } = self.path;
        let centre = self.centre(k);
        // Steps are of the size of textures, so only the centre may be too far for sums.
        [0, 1].map(|axis| {
            let offset = first_sample[axis] + i64::from(a) * by_a[axis] + i64::from(b) * by_b[axis];
            centre[axis].saturating_add(offset)
        })
    }

    /// How far the samples' windows reach from texels' centres at most, along the source's x and y.
    pub fn reach(&self) -> [i64; 2] {
        self.path.reach
    }

    /// Whether the windows of all samples of the run's first `count` texels lie in the source: a run
    /// is straight, so it is enough to look at its ends.
    #[inline(always)]
    pub fn stays_inside(&self, count: u32, source: Size) -> bool {
        let ends = [self.start, self.centre(count - 1)];
        let size = [source.width, source.height];
        (0..2).all(|axis| {
            let least = self.path.reach[axis];
            let most = i64::from(size[axis]) * TEXEL - least;
            ends.iter().all(|end| (least..most).contains(&end[axis]))
        })
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
    use crate::piece::Piece;

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
        let itself = (0..20).map(|face| Piece::whole(face, face, [0, 1, 2]));
        let pair = Pair::with_all(mesh(far), mesh(1.0), itself);
        SamplingMap::new(&pair, Direction::Forward, size, &MapOptions::with_gutter(3))
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
            // Hundreds of samples a texel.
            (6, Size::new(900, 700), Size::new(40, 31)),
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
            &MapOptions::with_gutter(0),
        );
        // A target texel is an eighth; in u the source spans twice as much, so 4 source texels of 16.
        let run = map.row(1)[0];
        let paths = Paths::new(&map, Size::square(16), Filter::Bilinear);
        let walk = paths.walk(1, run);
        let at = |x: f64, y: f64| [x, y].map(from_texels);
        assert_eq!(walk.samples(), [4, 2]);
        assert_eq!(walk.centre(0), at(2.0, 3.0));
        assert_eq!(walk.centre(1), at(6.0, 3.0));
        assert_eq!(walk.sample(0, 0, 0), at(0.5, 2.5));
        assert_eq!(walk.sample(0, 3, 1), at(3.5, 3.5));
        assert_eq!(walk.sample(1, 3, 1), at(7.5, 3.5));
    }

    /// Far from where their map begins slopes take two products out of all bounds, whose sum is not.
    #[test]
    fn thin_triangles_keep_their_positions() {
        let mesh = |uv: [[f32; 2]; 3]| {
            let faces = [[0, 1, 2]];
            Mesh::from_triangles(vec![[0.0; 3]; 3], uv.to_vec(), &faces, &faces).unwrap()
        };
        let source = mesh([[0.1, 0.1], [0.9, 0.2], [0.3, 0.8]]);
        for width in [1e-3, 1e-6, 2e-7] {
            let target = mesh([[0.0, 0.0], [1.0, 1.0 - width], [1.0 - width, 1.0]]);
            let pair = Pair::by_vertex_map(source.clone(), target, &[0, 1, 2]).unwrap();
            let options = MapOptions::with_gutter(0);
            let map = SamplingMap::new(&pair, Direction::Forward, Size::square(4096), &options);
            let paths = Paths::new(&map, Size::square(2048), Filter::Bilinear);
            let mut texels = 0;
            for row in 0..4096 {
                for &run in map.row(row) {
                    let px = [run.x, row].map(|px| f64::from(px) + 0.5);
                    let uv = map.patches()[run.patch as usize].src_uv_from_tgt_px.at(px);
                    let found = paths.walk(row, run).centre(0).map(position::in_texels);
                    for axis in 0..2 {
                        assert!(
                            (found[axis] - uv[axis] * 2048.0).abs() < 1e-3,
                            "{px:?}: {found:?}"
                        );
                    }
                    texels += run.len;
                }
            }
            assert!(texels > 4000, "{width}: {texels}");
        }
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
