//! Textures fitted by solving rather than sampled.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::{
    Channels, Depth, Direction, Encoding, Filter, FitOptions, FitProgress, Graft, GraftError, Mesh,
    Pair, Size, Sizes, Texels, TexelsMut, Texture,
};
use uvgraft_tests::{real, synthetic};

const SOURCE: Size = Size::square(512);
const TARGET: Size = Size::square(256);

fn base(channels: Channels, depth: Depth) -> Texture {
    let unit = &[0.3, 0.5, 0.7, 1.0][4 - channels.count()..];
    Texture::filled(TARGET, channels, Encoding::Srgb, depth, unit).unwrap()
}

/// A graft from the target's layout to the source's.
fn reverse(pair: &Arc<Pair>, filter: Filter) -> Graft {
    Graft::builder(Arc::clone(pair), Sizes { from: SOURCE, to: TARGET })
        .direction(Direction::Reverse)
        .filter(filter)
        .build()
        .unwrap()
}

fn forward(pair: &Arc<Pair>, from: Size, to: Size, filter: Filter) -> Graft {
    Graft::builder(Arc::clone(pair), Sizes { from, to }).filter(filter).build().unwrap()
}

/// A fitted texture laid over a base.
fn fitted(
    graft: &Graft,
    texture: &Texture,
    base: Texture,
    options: FitOptions,
    progress: &mut dyn FnMut(FitProgress),
) -> Texture {
    let fitted = graft.fit(texture, base.format(), &options, progress).unwrap();
    fitted.overlay.lay(0, base).unwrap()
}

fn ignore(_: FitProgress) {}

/// Root mean square difference over the texels transferred back; 1.0 from black to white.
fn rms_back(pair: &Arc<Pair>, filter: Filter, carried: &Texture, original: &Texture) -> f64 {
    let back = Graft::builder(Arc::clone(pair), Sizes { from: TARGET, to: SOURCE })
        .filter(filter)
        .gutter_px(0)
        .build()
        .unwrap();
    let result = back.apply(carried, original).unwrap();
    let count = original.channels().count();
    let mut squares = 0.0;
    for y in 0..SOURCE.height {
        for x in 0..SOURCE.width {
            for channel in 0..count {
                let difference = result.get(x, y, channel) - original.get(x, y, channel);
                squares += f64::from(difference).powi(2);
            }
        }
    }
    (squares / (back.map().stats().linked * count) as f64).sqrt()
}

#[test]
fn reads_back_better_with_every_filter_and_says_how_well() {
    let pair = synthetic::pair();
    let texture = synthetic::detailed(SOURCE, 3);
    // A sharper filter leaves less to gain, and half of this texture's detail is too fine for any.
    for (filter, most) in
        [(Filter::Bilinear, 0.9), (Filter::CatmullRom, 0.97), (Filter::Lanczos3, 0.98)]
    {
        let graft = reverse(&pair, filter);
        let base = base(Channels::Rgb, Depth::U8);
        let sampled = graft.apply(&texture, &base).unwrap();
        let mut course = Vec::new();
        let found = graft.fit(&texture, base.format(), &FitOptions::default(), &mut |step| {
            course.push(step);
        });
        let found = found.unwrap();
        let fitted = found.overlay.lay(0, base).unwrap();
        let before = rms_back(&pair, filter, &sampled, &texture);
        let after = rms_back(&pair, filter, &fitted, &texture);
        assert!(after < most * before, "{filter}: {after} against {before}");
        let (first, last) = (course[0], course[course.len() - 1]);
        assert_eq!((first.step, last.step as usize), (0, course.len() - 1));
        let summary = found.summary;
        assert_eq!((summary.sampled_rms, summary.fitted_rms), (first.rms, last.rms));
        assert_eq!(summary.steps, last.step);
        // The reported values precede rounding to 8 bits and clamping.
        assert!((first.rms - before).abs() < 0.02 * before, "{} and {before}", first.rms);
        assert!((last.rms - after).abs() < 0.05 * after, "{} and {after}", last.rms);
    }
}

#[test]
fn unmapped_texels_keep_the_base() {
    let pair = synthetic::pair();
    let graft = reverse(&pair, Filter::default());
    let base = synthetic::detailed(TARGET, 8);
    let texture = synthetic::detailed(SOURCE, 3);
    let fitted = fitted(&graft, &texture, base.clone(), FitOptions::default(), &mut ignore);
    let map = graft.map();
    let mut beside = 0;
    for row in 0..TARGET.height {
        let mut reached = vec![false; TARGET.width as usize];
        for run in map.row(row) {
            reached[run.x as usize..(run.x + run.len) as usize].fill(true);
        }
        for x in (0..TARGET.width).filter(|&x| !reached[x as usize]) {
            beside += 1;
            for channel in 0..3 {
                assert_eq!(fitted.get(x, row, channel), base.get(x, row, channel));
            }
        }
    }
    assert!(beside > 1000, "{beside}");
}

/// A square of two triangles; the source has one of them.
fn half_linked() -> Arc<Pair> {
    let uv = vec![[0.1, 0.1], [0.9, 0.12], [0.88, 0.9], [0.1, 0.9]];
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let (one, both) = ([[0, 1, 2]], [[0, 1, 2], [0, 2, 3]]);
    let source = Mesh::from_triangles(
        positions[..3].to_vec(),
        vec![[0.05, 0.1], [0.95, 0.2], [0.6, 0.9]],
        &one,
        &one,
    );
    let target = Mesh::from_triangles(positions, uv, &both, &both);
    Arc::new(Pair::by_vertex_map(source.unwrap(), target.unwrap(), &[0, 1, 2]).unwrap())
}

/// The boundary of the linked area may lie inside an island; the fit must not compensate for texels
/// beyond it.
#[test]
fn a_constant_colour_ignores_the_base() {
    let pair = half_linked();
    let texture = |size, value: f32| {
        Texture::filled(size, Channels::Grey, Encoding::Srgb, Depth::F32, &[value]).unwrap()
    };
    for (from, to) in [(230, 128), (100, 300), (64, 64)] {
        let (from, to) = (Size::square(from), Size::square(to));
        for filter in [Filter::Bilinear, Filter::CatmullRom, Filter::Lanczos3] {
            let graft = forward(&pair, from, to, filter);
            let mut last = None;
            let mut progress = |step| last = Some(step);
            let (texture, base) = (texture(from, 0.8), texture(to, 0.1));
            let fitted = fitted(&graft, &texture, base, FitOptions::default(), &mut progress);
            assert!(last.unwrap().rms < 1e-6, "{filter}: {last:?}");
            let off = (0..to.texels() as u32)
                .map(|k| fitted.get(k % to.width, k / to.width, 0))
                .map(|value| (value - 0.8).abs().min((value - 0.1).abs()))
                .fold(0.0, f32::max);
            assert!(off < 1e-5, "{filter} {from} {to}: {off}");
        }
    }
}

/// Where two target islands overlap, the one that owns the texels determines the fit.
#[test]
fn hidden_islands_do_not_affect_the_fit() {
    let separate = [[0.0, 0.0], [0.4, 0.0], [0.4, 0.4], [0.6, 0.6], [1.0, 0.6], [1.0, 1.0]];
    let stacked = [[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.1], [0.9, 0.1], [0.9, 0.9]];
    let faces = [[0, 1, 2], [3, 4, 5]];
    let mesh = |uv: [[f32; 2]; 6]| {
        Mesh::from_triangles(vec![[0.0; 3]; 6], uv.to_vec(), &faces, &faces).unwrap()
    };
    let ids = [0, 1, 2, 3, 4, 5];
    let pair = Arc::new(Pair::by_vertex_map(mesh(separate), mesh(stacked), &ids).unwrap());
    let size = Size::square(100);
    // White on the first island, black on the second.
    let values = (0..size.texels()).map(|k| if k / 100 < 50 { 255 } else { 0 }).collect();
    let source = Texture::new(size, Channels::Grey, Encoding::Srgb, Texels::U8(values)).unwrap();
    let base = Texture::filled(size, Channels::Grey, Encoding::Srgb, Depth::U8, &[1.0]).unwrap();
    let graft = forward(&pair, size, size, Filter::default());
    let fitted = fitted(&graft, &source, base, FitOptions::default(), &mut ignore);
    let Texels::U8(values) = fitted.texels() else { panic!("8 bits") };
    assert!(values.iter().all(|&value| value == 255), "{:?}", values.iter().min());
}

#[test]
fn non_finite_values_are_refused() {
    let pair = half_linked();
    let size = Size::square(40);
    let mut values = vec![0.5; size.texels()];
    values[7 * 40 + 3] = f32::NAN;
    let source = Texture::new(size, Channels::Grey, Encoding::Linear, Texels::F32(values)).unwrap();
    let graft = forward(&pair, size, size, Filter::default());
    let refused = graft.fit(&source, source.format(), &FitOptions::default(), &mut ignore);
    assert_eq!(refused.unwrap_err(), GraftError::NotFinite { x: 3, y: 7 });
}

#[test]
fn zero_steps_equal_sampling() {
    let pair = synthetic::pair();
    let graft = reverse(&pair, Filter::default());
    let no_steps = FitOptions::default().max_steps(0);
    for (channels, depth) in [
        (Channels::Rgb, Depth::U8),
        (Channels::Rgba, Depth::U8),
        (Channels::GreyAlpha, Depth::U16),
        (Channels::Grey, Depth::F32),
    ] {
        let mut texture = synthetic::detailed(SOURCE, 3).converted(channels, depth);
        if let (TexelsMut::U8(values), Channels::Rgba) = (texture.texels_mut(), channels) {
            values.iter_mut().skip(3).step_by(4).enumerate().for_each(|(k, a)| *a = (k / 9) as u8);
        }
        let base = base(channels, depth);
        let sampled = graft.apply(&texture, &base).unwrap();
        let fitted = fitted(&graft, &texture, base, no_steps, &mut ignore);
        let off = (0..TARGET.texels())
            .flat_map(|k| (0..channels.count()).map(move |channel| (k as u32, channel)))
            .map(|(k, channel)| {
                let (x, y) = (k % TARGET.width, k / TARGET.width);
                (fitted.get(x, y, channel) - sampled.get(x, y, channel)).abs()
            })
            .fold(0.0, f32::max);
        let one_level = if depth == Depth::U8 { 1.0 / 255.0 } else { 1.0 / 65_535.0 };
        assert!(off <= one_level * 1.001, "{channels:?} {depth:?}: {off}");
    }
}

#[test]
fn the_bytes_do_not_depend_on_threads() {
    let pair = synthetic::pair();
    let texture = synthetic::detailed(SOURCE, 3);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let graft = reverse(&pair, Filter::default());
            let base = base(Channels::Rgb, Depth::U16);
            fitted(&graft, &texture, base, FitOptions::default().max_steps(4), &mut ignore)
        })
    };
    let one = run(1);
    assert_eq!(run(2), one);
    assert_eq!(run(5), one);
}

#[test]
fn opaque_and_clear_parts_stay_so() {
    let pair = synthetic::pair();
    let mut texture = synthetic::detailed(SOURCE, 3).converted(Channels::Rgba, Depth::U8);
    let TexelsMut::U8(values) = texture.texels_mut() else { panic!("8 bits") };
    // Opaque on the left, transparent on the right, where the colours are garbage.
    for (k, texel) in values.chunks_exact_mut(4).enumerate() {
        if k % SOURCE.width as usize > 256 {
            texel.copy_from_slice(&[255, 0, 255, 0]);
        }
    }
    let graft = reverse(&pair, Filter::default());
    let clear =
        Texture::filled(TARGET, Channels::Rgba, Encoding::Srgb, Depth::U8, &[0.0; 4]).unwrap();
    let fitted = fitted(&graft, &texture, clear, FitOptions::default(), &mut ignore);
    let Texels::U8(values) = fitted.texels() else { panic!("8 bits") };
    let opaque = values.chunks_exact(4).filter(|texel| texel[3] > 250).count();
    let magenta = values
        .chunks_exact(4)
        .filter(|texel| texel[3] > 128 && texel[0] > 250 && texel[1] < 5 && texel[2] > 250)
        .count();
    assert!(opaque > 1000 && magenta == 0, "{opaque} opaque, {magenta} with a clear part's colour");
}

#[test]
fn the_transpose_is_the_adjoint_on_real_meshes() {
    let Some(pair) = real::flame_to_smplx() else { return };
    let (via, size) = (Size::square(1024), Size::square(2048));
    for direction in [Direction::Forward, Direction::Reverse] {
        for filter in Filter::ALL {
            let graft = Graft::builder(Arc::clone(&pair), Sizes { from: via, to: size })
                .direction(direction)
                .filter(filter)
                .build();
            let operator = graft.unwrap().operator();
            let mut rng = fastrand::Rng::with_seed(1);
            let mut values =
                |size: Size| (0..size.texels() * 3).map(|_| rng.f32()).collect::<Vec<f32>>();
            let (x, y) = (values(via), values(size));
            let dot = |a: &[f32], b: &[f32]| {
                a.iter().zip(b).map(|(&a, &b)| f64::from(a) * f64::from(b)).sum::<f64>()
            };
            let there = dot(&operator.apply(3, &x), &y);
            let back = dot(&x, &operator.apply_transposed(3, &y));
            let error = (there - back).abs() / there;
            assert!(error < 1e-6, "{direction:?} {filter}: {there} and {back}");
        }
    }
}

/// Where both sides have about the same texel density, a bilinear filter sees fine stripes at some
/// positions and misses them at others. A fit must not invent what the filter misses: that would
/// take it away from the texture that its source was made from.
#[test]
fn a_bilinear_fit_does_not_ring() {
    let pair = synthetic::pair();
    let truth = synthetic::detailed(TARGET, 5);
    for side in [200, 256, 330, 512] {
        let size = Size::square(side);
        let grey = Texture::filled(size, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.5; 3]);
        let there = forward(&pair, TARGET, size, Filter::default());
        let source = there.apply(&truth, grey.unwrap()).unwrap();
        for filter in [Filter::Bilinear, Filter::CatmullRom, Filter::Lanczos3] {
            let graft = Graft::builder(Arc::clone(&pair), Sizes { from: size, to: TARGET })
                .direction(Direction::Reverse)
                .filter(filter)
                .gutter_px(0)
                .build()
                .unwrap();
            let error = |texture: Texture| {
                let inside = graft.mask();
                let mut squares = 0.0;
                for (x, y) in (0..TARGET.texels() as u32).map(|k| (k % 256, k / 256)) {
                    if inside.get(x, y, 0) > 0.0 {
                        for channel in 0..3 {
                            let off = texture.get(x, y, channel) - truth.get(x, y, channel);
                            squares += f64::from(off).powi(2);
                        }
                    }
                }
                (squares / (3 * graft.map().stats().linked) as f64).sqrt() * 255.0
            };
            let sampled = error(graft.apply(&source, &truth).unwrap());
            let of = |options| error(fitted(&graft, &source, truth.clone(), options, &mut ignore));
            let held = of(FitOptions::default());
            assert!(held < sampled, "{side} {filter}: {held} against {sampled}");
            if filter == Filter::Bilinear {
                let loose = of(FitOptions::default().smoothness(0.0));
                assert!(held < 0.99 * loose, "{side}: {held} against {loose}");
            }
        }
    }
}
