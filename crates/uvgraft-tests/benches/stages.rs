//! Benchmarks of each stage at 2048² and 4096²: on the real pair if `UVGRAFT_DATA` names the data
//! folder, else on a synthetic one.

use std::io::Cursor;
use std::sync::Arc;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use uvgraft::blend::{Blend, BlendDomain, BlendOptions, Tone};
use uvgraft::{
    Channels, Depth, Direction, Encoding, Filter, Graft, MapOptions, NormalFrames, NormalOptions,
    Pair, SamplingMap, Size, Sizes, Texels, TexelsMut, Texture, resample,
};
use uvgraft_image::{self as image, Format, Image, WriteOptions};
use uvgraft_metrics::lpips::Lpips;
use uvgraft_metrics::lpips_weights::sdist;
use uvgraft_metrics::{self as metrics, Colors, Mask, MetricError};
use uvgraft_tests::{downloads, real, synthetic};

const SOURCE: Size = Size::square(2048);
const TARGET: Size = Size::square(4096);

fn sizes(direction: Direction) -> (Size, Size) {
    match direction {
        Direction::Forward => (SOURCE, TARGET),
        Direction::Reverse => (TARGET, SOURCE),
    }
}

fn maps(criterion: &mut Criterion, pair: &Pair) {
    let mut group = criterion.benchmark_group("map");
    for direction in [Direction::Forward, Direction::Reverse] {
        let (_, target) = sizes(direction);
        for gutter_px in [0, 16] {
            let options = MapOptions::with_gutter(gutter_px);
            group.bench_function(format!("{direction:?} {target} gutter {gutter_px}"), |bencher| {
                bencher.iter(|| SamplingMap::new(pair, direction, target, &options));
            });
        }
    }
    group.finish();
}

/// Formats other than opaque 8 bit, beside that one.
fn formats(criterion: &mut Criterion, pair: &Arc<Pair>) {
    let mut group = criterion.benchmark_group("format");
    let detailed = synthetic::detailed(SOURCE, 1);
    // Opacity that varies from texel to texel, so that nothing is replaced as a whole.
    let mut translucent = detailed.clone().converted(Channels::Rgba, Depth::U8);
    if let TexelsMut::U8(values) = translucent.texels_mut() {
        for (k, texel) in values.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            texel[3] = 100 + (k % 100) as u8;
        }
    }
    for (name, source) in [
        ("8 bit", detailed.clone()),
        ("8 bit with opacity", translucent),
        ("16 bit", detailed.clone().converted(Channels::Rgb, Depth::U16)),
        ("float", detailed.converted(Channels::Rgb, Depth::F32)),
    ] {
        let (channels, depth) = (source.channels(), source.depth());
        let base =
            Texture::filled(TARGET, channels, Encoding::Srgb, depth, &[0.5; 4][..channels.count()])
                .expect("a sound size");
        for filter in Filter::ALL {
            let sizes = Sizes { from: SOURCE, to: TARGET };
            let graft = Graft::builder(Arc::clone(pair), sizes).filter(filter).build();
            let graft = graft.expect("sound sizes");
            group.bench_function(format!("{name} {filter}"), |bencher| {
                bencher.iter_batched(
                    || (source.clone(), base.clone()),
                    |(source, base)| graft.apply(source, base),
                    BatchSize::PerIteration,
                );
            });
        }
    }
    group.finish();
}

fn transfers(criterion: &mut Criterion, pair: &Arc<Pair>) {
    let mut group = criterion.benchmark_group("transfer");
    for direction in [Direction::Forward, Direction::Reverse] {
        let (source_size, target_size) = sizes(direction);
        let source = synthetic::detailed(source_size, 1);
        let base =
            Texture::filled(target_size, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.5; 3])
                .expect("a sound size");
        for filter in Filter::ALL {
            let sizes = Sizes { from: source_size, to: target_size };
            let graft = Graft::builder(Arc::clone(pair), sizes).direction(direction);
            let graft = graft.filter(filter).build().expect("sound sizes");
            // The textures are cloned outside the measured part.
            group.bench_function(format!("{direction:?} {filter}"), |bencher| {
                bencher.iter_batched(
                    || (source.clone(), base.clone()),
                    |(source, base)| graft.apply(source, base),
                    BatchSize::LargeInput,
                );
            });
        }
        // The scalar reference, for comparison.
        let (Texels::U8(values), Texels::U8(base)) = (source.texels(), base.texels()) else {
            unreachable!("8-bit textures")
        };
        let map = SamplingMap::new(pair, direction, target_size, &MapOptions::default());
        group.bench_function(format!("{direction:?} bilinear reference"), |bencher| {
            bencher.iter_batched(
                || base.clone(),
                |mut base| {
                    let filter = Filter::Bilinear;
                    resample::reference::resample::<u8, 3, false>(
                        &map,
                        values,
                        source_size,
                        &mut base,
                        filter,
                    );
                    base
                },
                BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

/// `H` and `Hᵀ` on float textures; a fit applies each once per step.
fn operators(criterion: &mut Criterion, pair: &Arc<Pair>) {
    let mut group = criterion.benchmark_group("operator");
    for filter in [Filter::Bilinear, Filter::Lanczos3] {
        let graft = Graft::builder(Arc::clone(pair), Sizes { from: SOURCE, to: TARGET });
        let graft = graft.filter(filter).gutter_px(0).build().expect("sound sizes");
        let operator = graft.operator();
        let (source, target) = (vec![0.5; SOURCE.texels() * 3], vec![0.5; TARGET.texels() * 3]);
        group.bench_function(format!("H {filter}"), |bencher| {
            bencher.iter(|| operator.apply(3, &source));
        });
        group.bench_function(format!("H transposed {filter}"), |bencher| {
            bencher.iter(|| operator.apply_transposed(3, &target));
        });
    }
    group.finish();
}

/// The cost that blending adds to a transfer, and of its preparation, once per pair and region.
fn blends(criterion: &mut Criterion, pair: &Arc<Pair>) {
    let mut group = criterion.benchmark_group("blend");
    let source = synthetic::detailed(SOURCE, 1);
    let base = Texture::filled(TARGET, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.4, 0.3, 0.2])
        .expect("a sound size");
    let domain = BlendDomain::new(Arc::clone(pair), Direction::Forward);
    let builder = Graft::builder(Arc::clone(pair), Sizes { from: SOURCE, to: TARGET })
        .filter(Filter::Bilinear);
    let whole = domain.linked();
    // A hundredth of the mesh's extent: about 2 cm on a body.
    let feather = domain.extent() * 0.01;
    let plain = BlendOptions::default();
    let membrane = plain.feather(feather).membrane();
    for (name, options) in [
        ("hard", plain),
        ("feather", plain.feather(feather)),
        ("membrane", membrane),
        ("membrane, tone of the source", membrane.tone(Tone::Source)),
    ] {
        group.bench_function(format!("prepare {name}"), |bencher| {
            bencher.iter(|| Blend::new(&whole, options).map(drop));
        });
        let white =
            Texture::filled(Size::square(1), Channels::Grey, Encoding::Data, Depth::U8, &[1.0]);
        let white = white.expect("a sound size");
        let graft = builder.clone().region(whole.clone()).blend(options).skin(white);
        let graft = graft.build().expect("a region");
        group.bench_function(format!("transfer {name}"), |bencher| {
            bencher.iter_batched(
                || (source.clone(), base.clone()),
                |(source, base)| {
                    let toning = graft.toning(&source, &base, base.format()).ok().flatten();
                    let overlay = graft.overlay(source, base.format()).expect("its size");
                    match &toning {
                        Some(toning) => {
                            overlay.with_tone(toning).expect("found for it").lay(0, base)
                        }
                        None => overlay.lay(0, base),
                    }
                },
                BatchSize::LargeInput,
            );
        });
    }
    // Finding the tone, which needs textures that show skin.
    let skin = |size: Size| {
        let mut rng = fastrand::Rng::with_seed(5);
        let texel = |_| [200_u8, 150, 120].map(|level| level + rng.u8(..8));
        let texels = Texels::U8((0..size.texels()).flat_map(texel).collect());
        Texture::new(size, Channels::Rgb, Encoding::Srgb, texels).expect("a sound size")
    };
    let (face, body) = (skin(SOURCE), skin(TARGET));
    if domain.labels(&face).is_ok() {
        for tone in [Tone::Base, Tone::Source] {
            let blend = plain.membrane().tone(tone);
            let graft = builder.clone().region(whole.clone()).blend(blend).build();
            let graft = graft.expect("a region");
            group.bench_function(format!("find the tone, {tone:?}"), |bencher| {
                bencher.iter(|| graft.toning(&face, &body, body.format()).map(drop));
            });
        }
    }
    let graft = builder.build().expect("sound sizes");
    group.bench_function("transfer without blend", |bencher| {
        bencher.iter_batched(
            || (source.clone(), base.clone()),
            |(source, base)| graft.apply(source, base),
            BatchSize::LargeInput,
        );
    });
    group.finish();
}

/// Rotating the normals of a filtered target.
fn normals(criterion: &mut Criterion, pair: &Pair) {
    let mut group = criterion.benchmark_group("normals");
    for direction in [Direction::Forward, Direction::Reverse] {
        let (_, target) = sizes(direction);
        group.bench_function(format!("frames {direction:?}"), |bencher| {
            bencher.iter(|| NormalFrames::new(pair, direction));
        });
        let frames = NormalFrames::new(pair, direction);
        let map = SamplingMap::new(pair, direction, target, &MapOptions::default());
        let mut values = vec![0.6; target.texels() * 3];
        group.bench_function(format!("turn {direction:?} {target}"), |bencher| {
            let options = NormalOptions::default();
            bencher.iter(|| frames.turn(&map, options, 0, &mut values, Channels::Rgb));
        });
    }
    group.finish();
}

fn metrics(criterion: &mut Criterion) {
    type Metric = fn(&Colors, &Colors, Option<&Mask>) -> Result<f64, MetricError>;
    let mut group = criterion.benchmark_group("metric");
    let [a, b] = [1, 2]
        .map(|seed| Colors::new(synthetic::detailed(SOURCE, seed)).expect("a texture of integers"));
    let metrics: [(&str, Metric); 4] = [
        ("psnr", metrics::psnr),
        ("ssim", metrics::ssim),
        ("ssim uniform", metrics::ssim_uniform),
        ("ssimulacra2", metrics::ssimulacra2),
    ];
    for (name, metric) in metrics {
        group.bench_function(format!("{name} {SOURCE}"), |bencher| {
            bencher.iter(|| metric(&a, &b, None));
        });
    }
    if let Some(sdist) = downloads::lpips_sdist() {
        let alex = Lpips::new(sdist::read(&sdist).expect("the sdist").alex);
        group.bench_function(format!("lpips alex {SOURCE}"), |bencher| {
            bencher.iter(|| alex.compare(&a, &b));
        });
    }
    group.finish();
}

fn files(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("file");
    for size in [SOURCE, TARGET] {
        let image = Image::from(synthetic::detailed(size, 1));
        for &format in Format::ALL {
            let encode = || {
                let mut out = Cursor::new(Vec::new());
                let options = WriteOptions::default();
                let _ = image::encode(&image, format, &options, &mut out).expect("an image");
                out.into_inner()
            };
            let bytes = encode();
            group.bench_function(format!("decode {format} {size}"), |bencher| {
                bencher.iter(|| image::decode(&bytes));
            });
            group.bench_function(format!("encode {format} {size}"), |bencher| {
                bencher.iter(encode);
            });
        }
    }
    group.finish();
}

fn stages(criterion: &mut Criterion) {
    let pair = real::flame_to_smplx().unwrap_or_else(synthetic::pair);
    maps(criterion, &pair);
    transfers(criterion, &pair);
    formats(criterion, &pair);
    operators(criterion, &pair);
    blends(criterion, &pair);
    normals(criterion, &pair);
    metrics(criterion);
    files(criterion);
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = stages
}
criterion_main!(benches);
