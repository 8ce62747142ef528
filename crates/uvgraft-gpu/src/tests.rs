//! Comparisons with the CPU on random triangles. They need a driver, which may be one that runs on the CPU.

use uvgraft::{
    Channels, Content, Depth, Direction, Encoding, Filter, Graft, Mesh, Pair, Size, Sizes, Texels,
    Texture,
};

use crate::{Adapters, Gpu, GpuError};

/// A device; `None` without a driver, where tests skip, unless `UVGRAFT_GPU_REQUIRED` is set.
fn gpu() -> Option<Gpu> {
    match Gpu::new(Adapters::Any) {
        Ok(gpu) => Some(gpu),
        Err(error)
            if std::env::var_os("UVGRAFT_GPU_REQUIRED").is_none_or(|value| value.is_empty()) =>
        {
            eprintln!("skipped: {error}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// Triangles scattered over both layouts: some steep, some minified, many beyond the edge.
fn pair(seed: u64) -> Pair {
    let mut rng = fastrand::Rng::with_seed(seed);
    // Triangles of the fourth reach far outside the source.
    let far = if seed == 4 { 1e9 } else { 1.0 };
    let mut mesh = |far: f32| {
        let mut uv = vec![[0.2, 0.2], [0.8, 0.3], [0.4, 0.8]];
        for _ in 1..20 {
            let at = [rng.f32(), rng.f32()];
            let side = rng.f32() * rng.f32() * 0.7;
            let mut corner = |far: f32| at.map(|value| value * far + (rng.f32() - 0.5) * side);
            uv.extend([corner(1.0), corner(1.0), corner(far)]);
        }
        let faces: Vec<[u32; 3]> = (0..20).map(|face| [0, 1, 2].map(|k| face * 3 + k)).collect();
        Mesh::from_triangles(vec![[0.0; 3]; 60], uv, &faces, &faces).unwrap()
    };
    let vertices: Vec<i64> = (0..60).collect();
    Pair::by_vertex_map(mesh(far), mesh(1.0), &vertices).unwrap()
}

fn random(size: Size, channels: Channels, encoding: Encoding, depth: Depth, seed: u64) -> Texture {
    let mut rng = fastrand::Rng::with_seed(seed);
    let count = size.texels() * channels.count();
    let texels = match depth {
        Depth::U8 => Texels::U8((0..count).map(|_| rng.u8(..)).collect()),
        Depth::U16 => Texels::U16((0..count).map(|_| rng.u16(..)).collect()),
        Depth::F32 => Texels::F32((0..count).map(|_| rng.f32()).collect()),
    };
    Texture::new(size, channels, encoding, texels).unwrap()
}

/// Greatest difference in levels; floats count as 16-bit levels. Colours are weighted by their
/// alpha, since those of transparent texels may be any.
pub(crate) fn difference(found: &Texture, wanted: &Texture) -> f32 {
    assert_eq!((found.size(), found.format()), (wanted.size(), wanted.format()));
    let one = if found.depth() == Depth::U8 { 255.0 } else { 65_535.0 };
    let count = found.channels().count();
    let has_alpha = found.channels().has_alpha() && found.encoding() != Encoding::Data;
    let mut worst = 0.0_f32;
    for y in 0..found.size().height {
        for x in 0..found.size().width {
            let weight = if has_alpha { found.get(x, y, count - 1).clamp(0.0, 1.0) } else { 1.0 };
            for channel in 0..count {
                let off = (found.get(x, y, channel) - wanted.get(x, y, channel)).abs() * one;
                let weight = if has_alpha && channel + 1 < count { weight } else { 1.0 };
                worst = worst.max(off * weight);
            }
        }
    }
    worst
}

fn compare(
    gpu: &Gpu,
    seed: u64,
    sizes: Sizes,
    format: (Channels, Encoding, Depth),
    content: Content,
) {
    let (channels, encoding, depth) = format;
    let face = random(sizes.from, channels, encoding, depth, seed);
    let base = random(sizes.to, channels, encoding, depth, seed + 100);
    for filter in Filter::ALL {
        let graft = Graft::builder(pair(seed), sizes)
            .direction(if seed.is_multiple_of(2) { Direction::Forward } else { Direction::Reverse })
            .content(content)
            .filter(filter)
            .build()
            .unwrap();
        let wanted = graft.apply(&face, &base).unwrap();
        let found = gpu.transfer(&graft).unwrap().apply_texture(&face, &base).unwrap();
        let worst = difference(&found, &wanted);
        let is_exact = filter == Filter::Nearest && !channels.has_alpha();
        // The hundredth is for the rounding of `Texture::get`.
        let most = if is_exact { 0.0 } else { 1.01 };
        assert!(worst <= most, "{filter} {channels:?} {depth:?} seed {seed} {sizes:?}: {worst}");
        if depth == Depth::U8 && !channels.has_alpha() && filter != Filter::CatmullRom {
            assert_eq!(found, wanted, "{filter} {channels:?} seed {seed} {sizes:?}");
        }
        assert_ne!(wanted, base);
    }
}

const SIZES: [(u64, Size, Size); 6] = [
    (1, Size::new(37, 61), Size::new(90, 53)),
    (2, Size::new(200, 150), Size::new(64, 40)),
    (3, Size::new(3, 2), Size::new(33, 70)),
    (4, Size::new(40, 30), Size::new(30, 30)),
    (5, Size::new(64, 80), Size::new(700, 61)),
    (6, Size::new(900, 700), Size::new(40, 31)),
];

#[test]
fn results_are_those_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    for (seed, from, to) in SIZES {
        let sizes = Sizes { from, to };
        for format in [
            (Channels::Grey, Encoding::Srgb, Depth::U8),
            (Channels::GreyAlpha, Encoding::Srgb, Depth::U8),
            (Channels::Rgb, Encoding::Srgb, Depth::U8),
            (Channels::Rgba, Encoding::Srgb, Depth::U8),
            (Channels::Rgb, Encoding::Linear, Depth::U16),
            (Channels::Rgba, Encoding::Srgb, Depth::U16),
            (Channels::Rgb, Encoding::Linear, Depth::F32),
            (Channels::Rgba, Encoding::Linear, Depth::F32),
        ] {
            compare(&gpu, seed, sizes, format, Content::Color);
        }
        compare(&gpu, seed, sizes, (Channels::Rgba, Encoding::Data, Depth::U8), Content::Data);
    }
}

/// Sizes of real textures, which differ in each direction.
#[test]
fn large_results_are_those_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    for seed in [1, 2] {
        for depth in [Depth::U8, Depth::U16] {
            let sizes = Sizes { from: Size::new(2047, 2048), to: Size::square(4096) };
            compare(&gpu, seed, sizes, (Channels::Rgb, Encoding::Srgb, depth), Content::Color);
        }
    }
}

/// Many tiles, bands and rows of workgroups, as on textures and maps of hundreds of megabytes.
#[test]
fn limits_of_the_device_make_no_difference() {
    let Some(mut gpu) = gpu() else { return };
    gpu.limits.tile_bits = 5;
    gpu.limits.binding = 2048;
    gpu.limits.groups = 3;
    for (seed, from, to) in SIZES {
        // Layers are counted, too.
        let from = Size::new(from.width.min(300), from.height.min(300));
        let format = (Channels::Rgb, Encoding::Srgb, Depth::U8);
        compare(&gpu, seed, Sizes { from, to }, format, Content::Color);
        let format = (Channels::Rgba, Encoding::Srgb, Depth::U16);
        compare(&gpu, seed, Sizes { from, to }, format, Content::Color);
    }
}

#[test]
fn textures_stay_on_the_device() {
    let Some(gpu) = gpu() else { return };
    let sizes = Sizes { from: Size::new(70, 90), to: Size::new(120, 80) };
    let back = Sizes { from: sizes.to, to: sizes.from };
    let format = (Channels::Rgb, Encoding::Srgb, Depth::U8);
    let texture = |size, seed| random(size, format.0, format.1, format.2, seed);
    let (faces, base) = ([0, 1, 2].map(|seed| texture(sizes.from, seed)), texture(sizes.to, 9));
    let build = |direction, sizes| {
        Graft::builder(pair(1), sizes)
            .direction(direction)
            .filter(Filter::Lanczos3)
            .build()
            .unwrap()
    };
    let [there, back] = [build(Direction::Forward, sizes), build(Direction::Reverse, back)];
    let on_device = |graft: &Graft| gpu.transfer(graft).unwrap();
    let (forward, backward) = (on_device(&there), on_device(&back));
    let uploaded = faces.each_ref().map(|face| gpu.upload(face).unwrap());
    let base_there = gpu.upload(&base).unwrap();
    let transferred = forward.apply_all(&uploaded.each_ref(), &base_there).unwrap();
    let transferred: Vec<&crate::DeviceTexture> = transferred.iter().collect();
    let returned = backward.apply_all(&transferred, &uploaded[0]).unwrap();
    for ((face, transferred), returned) in faces.iter().zip(transferred).zip(&returned) {
        let wanted = there.apply(face, &base).unwrap();
        assert_eq!(gpu.download(transferred).unwrap(), wanted);
        assert_eq!(gpu.download(returned).unwrap(), back.apply(&wanted, &faces[0]).unwrap());
    }
    // The inputs are as they were.
    assert_eq!(gpu.download(&base_there).unwrap(), base);
    assert_eq!(gpu.download(&uploaded[2]).unwrap(), faces[2]);
}

#[test]
fn textures_that_do_not_fit_are_refused() {
    let Some(mut gpu) = gpu() else { return };
    let size = Size::new(20, 30);
    let graft = Graft::builder(pair(1), Sizes { from: size, to: size }).build().unwrap();
    let transfer = gpu.transfer(&graft).unwrap();
    let upload =
        |size, channels| gpu.upload(&random(size, channels, Encoding::Srgb, Depth::U8, 1)).unwrap();
    let (small, grey) = (upload(Size::new(20, 29), Channels::Rgb), upload(size, Channels::Grey));
    let base = upload(size, Channels::Rgb);
    let error = transfer.apply(&small, &base).unwrap_err();
    assert_eq!(error.to_string(), "the texture must be 20×30, got 20×29");
    assert!(matches!(transfer.apply(&base, &small), Err(GpuError::Size { what: "base", .. })));
    assert!(matches!(transfer.apply(&grey, &base), Err(GpuError::Formats { .. })));
    let blended = Graft::builder(pair(1), Sizes { from: size, to: size })
        .blend(uvgraft::BlendOptions::default())
        .build()
        .unwrap();
    assert!(matches!(gpu.transfer(&blended), Err(GpuError::Plan(_))));
    gpu.limits.tile_bits = 1;
    gpu.limits.tiles = 149;
    let texture = random(size, Channels::Rgb, Encoding::Srgb, Depth::U8, 1);
    let error = gpu.upload(&texture).unwrap_err();
    assert_eq!(error, GpuError::TooLarge { what: "a texture", size });
}
