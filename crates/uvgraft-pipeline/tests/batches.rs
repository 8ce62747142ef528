//! A batch writes the files that its textures make one at a time, although it encodes what they
//! have in common only once.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::path::PathBuf;
use std::sync::Mutex;

use uvgraft::{
    Averaging, Channels, Depth, Encoding, FitOptions, Mesh, Overlap, Pair, Size, Texels, Texture,
};
use uvgraft_figure::{Figure, paint_body_in_tone, paint_head};
use uvgraft_image::{self as image, Format, WriteOptions};
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_pipeline::{BaseSource, Blending, Event, Inputs, Length, Observer, Transfer, Values};

/// Rows of three to twelve segments, depending on the format, the last of them incomplete.
const BASE: Size = Size::new(613, 857);

struct Desk(tempfile::TempDir);

/// The warnings of textures, in order.
#[derive(Default)]
struct Warnings(Mutex<Vec<String>>);

impl Observer for Warnings {
    fn event(&self, event: Event<'_>) {
        if let Event::TextureReport { warnings, .. } = event {
            self.0.lock().unwrap().extend_from_slice(warnings);
        }
    }
}

impl Desk {
    /// With a pair whose target is a band across the middle, with an island that overlaps it.
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        let square = |x: f32, y: f32| {
            [[x, y, 0.0], [x + 1.0, y, 0.0], [x + 1.0, y + 1.0, 0.0], [x, y + 1.0, 0.0]]
        };
        let positions: Vec<[f32; 3]> = [square(0.0, 0.0), square(5.0, 0.0)].concat();
        let faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let from = vec![
            [0.1, 0.1],
            [0.9, 0.1],
            [0.9, 0.5],
            [0.1, 0.5],
            [0.1, 0.6],
            [0.4, 0.6],
            [0.4, 0.9],
            [0.1, 0.9],
        ];
        let to = vec![
            [0.2, 0.4],
            [0.8, 0.42],
            [0.8, 0.6],
            [0.2, 0.6],
            [0.5, 0.5],
            [0.9, 0.5],
            [0.9, 0.62],
            [0.5, 0.62],
        ];
        let mesh = |uv| Mesh::from_triangles(positions.clone(), uv, &faces, &faces).unwrap();
        let pair = Pair::by_vertex_map(mesh(from), mesh(to), &[0, 1, 2, 3, 4, 5, 6, 7]).unwrap();
        desk.write_pair(pair);
        desk
    }

    fn write_pair(&self, pair: Pair) {
        let name = String::new;
        let file =
            PairFile { pair: pair.into(), source_name: name(), target_name: name(), note: name() };
        pair_file::write(&file, self.path("my.uvpair")).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn save(&self, name: &str, texture: Texture) {
        image::write(&texture.into(), self.path(name), &WriteOptions::default()).map(drop).unwrap();
    }

    /// Compares batches on one and on several threads, and a prepared transfer used twice, with one
    /// transfer for each texture.
    fn compare(&self, name: &str, transfer: &Transfer, sources: &[&str]) {
        let of = |sources: &[&str], output: &str| {
            let mut transfer = transfer.clone();
            let Inputs::Textures { sources: all, .. } = &mut transfer.inputs else {
                unreachable!()
            };
            *all = sources.iter().map(|source| self.path(source).into()).collect();
            transfer.output = self.path(output);
            transfer
        };
        let format = transfer.format.as_deref().unwrap();
        let output =
            |source: &str| self.path("out").join(PathBuf::from(source).with_extension(format));
        let (mut wanted, mut warned) = (Vec::new(), Vec::new());
        for source in sources {
            let name = format!("alone.{format}");
            let alone = self.path(&name);
            let warnings = Warnings::default();
            let done = of(&[source], &name).run(&warnings).unwrap();
            // Some name the output.
            let [from, to] = [&alone, &output(source)].map(|path| path.display().to_string());
            let warnings = warnings.0.into_inner().unwrap().into_iter();
            warned.extend(warnings.map(|warning| warning.replace(&from, &to)));
            wanted.push(done.failures.is_empty().then(|| std::fs::read(&alone).unwrap()));
            let _ = std::fs::remove_file(alone);
        }
        assert!(wanted.iter().any(Option::is_some), "{name}");
        for jobs in [1, 3] {
            let mut batch = of(sources, "out");
            batch.jobs = Some(jobs);
            let warnings = Warnings::default();
            let done = batch.run(&warnings).unwrap();
            assert_eq!(done.written, wanted.iter().flatten().count(), "{name}");
            assert_eq!(warnings.0.into_inner().unwrap(), warned, "{name}");
            for (source, wanted) in sources.iter().zip(&wanted) {
                if let Some(wanted) = wanted {
                    let found = std::fs::read(output(source)).unwrap();
                    assert!(found == *wanted, "{name}: {source}, {jobs} jobs");
                }
            }
            std::fs::remove_dir_all(self.path("out")).unwrap();
        }
        let prepared = of(&[], "").prepare(&()).unwrap();
        let format = Format::from_extension(format).unwrap();
        for _ in 0..2 {
            for (source, wanted) in sources.iter().zip(&wanted) {
                let bytes = std::fs::read(self.path(source)).unwrap();
                let found = prepared.transfer_bytes(&bytes, source, format).ok();
                let found = found.map(|(bytes, _)| bytes);
                assert!(found == *wanted, "{name}: {source}, prepared");
            }
        }
    }

    fn onto(&self, base: BaseSource, format: &str) -> Transfer {
        let is_color = matches!(base, BaseSource::Color(_));
        let inputs = Inputs::Textures { sources: vec![], onto: Some(base), values: Values::Albedo };
        let mut transfer = Transfer::new(self.path("my.uvpair"), inputs, "");
        transfer.size = is_color.then_some(BASE);
        transfer.format = Some(format.to_owned());
        transfer
    }
}

/// Smooth areas and grain, from -0.1 to 1.1 for floats.
fn texture(size: Size, channels: Channels, depth: Depth, seed: u64) -> Texture {
    let count = channels.count();
    let mut state = seed;
    let values = (0..size.texels() * count).map(|index| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let grain = (state >> 40) as f32 / (1 << 24) as f32;
        let (texel, row) = (index / count, index / count / size.width as usize);
        let smooth = (texel % size.width as usize) as f32 / size.width as f32;
        if row / 40 % 2 == 0 { smooth } else { smooth * 0.5 + grain * 0.7 - 0.1 }
    });
    let texels = match depth {
        Depth::U8 => Texels::U8(values.map(|value| (value * 255.0) as u8).collect()),
        Depth::U16 => Texels::U16(values.map(|value| (value * 65_535.0) as u16).collect()),
        Depth::F32 => Texels::F32(values.collect()),
    };
    let encoding = if depth == Depth::F32 { Encoding::Linear } else { Encoding::Srgb };
    Texture::new(size, channels, encoding, texels).unwrap()
}

const SOURCES: [(&str, Channels, Depth); 7] = [
    ("rgb.png", Channels::Rgb, Depth::U8),
    ("rgba.png", Channels::Rgba, Depth::U8),
    ("grey.png", Channels::Grey, Depth::U8),
    ("deep.png", Channels::GreyAlpha, Depth::U16),
    ("again.png", Channels::Rgb, Depth::U8),
    ("deeprgb.tif", Channels::Rgb, Depth::U16),
    ("float.exr", Channels::Rgb, Depth::F32),
];

fn with_sources() -> (Desk, Vec<&'static str>) {
    let desk = Desk::new();
    for (seed, (name, channels, depth)) in (7..).zip(SOURCES) {
        let side = if seed % 2 == 0 { 64 } else { 91 };
        desk.save(name, texture(Size::square(side), channels, depth, seed));
    }
    (desk, SOURCES.map(|(name, ..)| name).to_vec())
}

#[test]
fn of_any_format_onto_images_of_any_format() {
    let (desk, sources) = with_sources();
    for (base, channels, depth) in [
        ("base.png", Channels::Rgb, Depth::U8),
        ("base.png", Channels::Grey, Depth::U8),
        ("base.png", Channels::GreyAlpha, Depth::U16),
        ("base.tif", Channels::Rgba, Depth::U8),
        ("base.exr", Channels::Rgb, Depth::F32),
    ] {
        desk.save(base, texture(BASE, channels, depth, 3));
        let base = BaseSource::image(desk.path(base));
        for format in ["png", "jpg", "tif"] {
            // JPEG has no alpha, and TIFF no segments.
            if format == "jpg" && channels.has_alpha() || format == "tif" && depth != Depth::F32 {
                continue;
            }
            let name = format!("{channels:?} {depth:?} {format}");
            desk.compare(&name, &desk.onto(base.clone(), format), &sources);
        }
    }
}

#[test]
fn onto_colors() {
    let (desk, sources) = with_sources();
    for color in ["#80a0c0", "#808080", "#80808040"] {
        let base = BaseSource::parse(color).unwrap();
        desk.compare(color, &desk.onto(base, "png"), &sources);
    }
}

#[test]
fn with_any_options() {
    let (desk, sources) = with_sources();
    desk.save("base.png", texture(BASE, Channels::Rgb, Depth::U8, 4));
    type Change = fn(&mut Transfer);
    let changes: [(&str, Change); 8] = [
        ("compressed", |it| it.write = it.write.compress(true)),
        ("light", |it| it.averaging = Averaging::Light),
        ("average", |it| it.overlap = Overlap::Average),
        ("resized", |it| it.size = Some(Size::new(1201, 601))),
        ("no gutter", |it| it.map = uvgraft::MapOptions::with_gutter(0)),
        ("fit", |it| it.fit = Some(FitOptions::default().max_steps(2))),
        ("data", |it| {
            let Inputs::Textures { values, .. } = &mut it.inputs else { unreachable!() };
            *values = Values::Data;
        }),
        ("feather", |it| {
            let mut blending = Blending::default();
            blending.feather = Length::millimeters(100.0);
            it.blending = Some(blending);
        }),
    ];
    for (name, change) in changes {
        let mut transfer = desk.onto(BaseSource::image(desk.path("base.png")), "png");
        change(&mut transfer);
        let sources = if name == "fit" { &sources[..2] } else { &sources };
        desk.compare(name, &transfer, sources);
    }
    // Known in part only: results get an alpha channel from the mask.
    let mask = texture(Size::square(64), Channels::Grey, Depth::U8, 9);
    desk.save("mask.png", mask);
    let mut transfer = desk.onto(BaseSource::image(desk.path("base.png")), "png");
    transfer.source_mask = Some(desk.path("mask.png").into());
    desk.compare("mask", &transfer, &sources[..3]);
}

/// Tone that adapts the texture, and tone that adapts the base, which then changes almost
/// everywhere.
#[test]
fn with_tone() {
    let desk = Desk(tempfile::tempdir().unwrap());
    let figure = Figure::new();
    let ids: Vec<i64> = figure.vertex_map.iter().map(|&id| i64::from(id)).collect();
    let pair = Pair::by_vertex_map(figure.head.clone(), figure.body.clone(), &ids).unwrap();
    desk.write_pair(pair);
    desk.save("base.png", paint_body_in_tone(&figure, Size::square(640), [0.7, 0.65, 0.6]));
    for (name, side) in [("a.png", 128), ("b.png", 160), ("c.png", 128)] {
        desk.save(name, paint_head(&figure, Size::square(side)));
    }
    for tone in [uvgraft::Tone::Base, uvgraft::Tone::Source, uvgraft::Tone::Both] {
        let mut transfer = desk.onto(BaseSource::image(desk.path("base.png")), "png");
        let mut blending = Blending::default();
        blending.options.membrane = true;
        blending.options.match_skin = true;
        blending.options.tone = tone;
        blending.feather = Length::millimeters(15.0);
        transfer.blending = Some(blending);
        desk.compare(&format!("{tone:?}"), &transfer, &["a.png", "b.png", "c.png"]);
    }
}
