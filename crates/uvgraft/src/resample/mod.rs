//! Resampling a texture through a sampling map.
//!
//! [`reference()`](reference::resample) is the specification. The fast paths give the same bits:
//! 8-bit textures without alpha in integer arithmetic (`bytes`), all others in floats with the same
//! order of operations (`fast`).

pub(crate) mod adjoint;
mod bytes;
mod composite;
pub(crate) mod fast;
pub(crate) mod footprint;
mod nearest;
mod path;
pub(crate) mod position;
mod prefetch;
pub(crate) mod reads;
pub mod reference;
mod stretch;
mod window;
mod windows;

pub(crate) use self::path::{Paths, Walk};
use crate::texture::Value;

/// Target rows per work item.
const ROWS: usize = 16;

/// Reads a texel as levels; with `ALPHA` the last channel is alpha and colours are premultiplied.
#[inline(always)]
pub(crate) fn load<T: Value, const C: usize, const ALPHA: bool>(texel: &[T]) -> [f32; C] {
    let mut levels: [f32; C] = std::array::from_fn(|channel| texel[channel].to_level());
    if ALPHA {
        let opacity = levels[C - 1] / T::ONE.to_level();
        for level in &mut levels[..C - 1] {
            *level *= opacity;
        }
    }
    levels
}

/// Composites filtered, premultiplied levels `s` over the target texel `t`, which is not
/// premultiplied (Porter and Duff 1984): `a = s.a + t.a·(1 − s.a)` and
/// `c = (s.c + t.c·t.a·(1 − s.a)) / a`. Without `ALPHA` it replaces the texel.
#[inline(always)]
pub(crate) fn store<T: Value, const C: usize, const ALPHA: bool>(
    levels: [f32; C],
    texel: &mut [T],
) {
    if ALPHA {
        let one = T::ONE.to_level();
        // Cubic filters over- and undershoot at edges of alpha, and premultiplied colours
        // along with it. Alpha at or below 0 contributes nothing; above 1 the colour is
        // scaled down with it.
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
    use fearless_simd::Level;
    #[cfg(target_arch = "x86_64")]
    use fearless_simd::Simd;
    use uvgraft_surface::mesh::Mesh;
    use uvgraft_surface::pair::{Direction, Pair};
    use uvgraft_surface::piece::Piece;

    use super::position::from_texels;
    use super::*;
    use crate::filter::Filter;
    use crate::map::{MapOptions, Run, SamplingMap};
    use crate::texture::Size;

    /// Triangles scattered over both layouts: some steep, some minified, many beyond the edge.
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

    /// Every level that kernels are compiled for and this machine supports.
    fn levels() -> Vec<Level> {
        let best = Level::new();
        #[cfg(target_arch = "x86_64")]
        let levels = [
            best.as_avx512().map(Simd::level),
            best.as_avx2().map(Simd::level),
            best.as_sse2().map(Simd::level),
        ];
        #[cfg(not(target_arch = "x86_64"))]
        let levels = [Some(best)];
        levels.into_iter().flatten().collect()
    }

    fn compare<T: Value, const C: usize, const ALPHA: bool>(value: fn(&mut fastrand::Rng) -> T) {
        let mut rng = fastrand::Rng::with_seed(C as u64);
        for (seed, source_size, size) in [
            (1, Size::new(37, 61), Size::new(90, 53)),
            (2, Size::new(200, 150), Size::new(64, 40)),
            (3, Size::new(3, 2), Size::new(33, 70)),
            (4, Size::new(40, 30), Size::new(30, 30)),
            // Runs of several batches.
            (5, Size::new(64, 80), Size::new(700, 61)),
            // Hundreds of samples per texel.
            (6, Size::new(900, 700), Size::new(40, 31)),
            // A single texel, and a texture no larger than the margins of runs inside.
            (7, Size::new(1, 1), Size::new(50, 40)),
            (8, Size::new(5, 300), Size::new(64, 45)),
        ] {
            let map = map(seed, size);
            let source: Vec<T> = (0..source_size.texels() * C).map(|_| value(&mut rng)).collect();
            let base: Vec<T> = (0..size.texels() * C).map(|_| value(&mut rng)).collect();
            for filter in Filter::ALL {
                let mut wanted = base.clone();
                reference::resample::<T, C, ALPHA>(&map, &source, source_size, &mut wanted, filter);
                assert!(wanted != base);
                let paths = Paths::new(&map, source_size, filter);
                for level in levels() {
                    let mut fast = base.clone();
                    // In two bands, neither a multiple of the rows per work item.
                    let (top, rest) = fast.split_at_mut(21 * size.width as usize * C);
                    fast::resample::<T, C, ALPHA>(level, &map, &paths, &source, 0, top);
                    fast::resample::<T, C, ALPHA>(level, &map, &paths, &source, 21, rest);
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

    /// The paths share the computation of positions, so comparing them does not test it; it
    /// is pinned by hand.
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
        // A target texel is an eighth of the texture; in u the source triangle is twice as wide, so
        // the texel spans 4 source texels of 16.
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

    /// Of a map whose texels each span the whole source, they have fewer samples that spread as far.
    #[test]
    fn samples_of_noise_are_few_on_average() {
        let size = Size::square(128);
        let mut rng = fastrand::Rng::with_seed(1);
        let noise: Vec<[f32; 2]> = (0..size.texels()).map(|_| [rng.f32(), rng.f32()]).collect();
        let map = SamplingMap::from_positions(size, &noise).unwrap();
        let samples = |map: &SamplingMap, source: Size| -> u64 {
            let paths = Paths::new(map, source, Filter::Bilinear);
            let runs = (0..map.size().height).flat_map(|row| map.row(row));
            let of_run = |run: &Run| {
                let [a, b] = paths.footprint(run.patch as usize).samples.map(u64::from);
                u64::from(run.len) * a * b
            };
            runs.map(of_run).sum()
        };
        let all = samples(&map, size);
        assert!(all < 64 * 2 * size.texels() as u64, "{all}");
        let [few, wanted] = [size, Size::square(4096)].map(|source| {
            let paths = Paths::new(&map, source, Filter::Bilinear);
            paths.footprint(1000)
        });
        assert!(few.samples.into_iter().max() < wanted.samples.into_iter().max());
        // A source that shrinks to a thumbnail has all of its samples, 32 on each axis.
        let place = |texel: usize| [texel % 32, texel / 32].map(|at| (at as f32 + 0.5) / 32.0);
        let small: Vec<[f32; 2]> = (0..32 * 32).map(place).collect();
        let map = SamplingMap::from_positions(Size::square(32), &small).unwrap();
        assert_eq!(samples(&map, Size::square(1024)), 1024 * 1024);
    }

    /// Far from the origin of the map both products with slopes are out of bounds, but their sum is
    /// not.
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
    fn compositing_by_hand() {
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
