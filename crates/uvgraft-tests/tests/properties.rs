//! What must hold for any pair, any map and any texture, and for what writers write.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::io::Cursor;
use std::sync::Arc;

use proptest::prelude::*;
use uvgraft::{
    Channels, Depth, Direction, Encoding, Filter, Graft, MapOptions, Mesh, Pair, SamplingMap, Size,
    Sizes, Texels, Texture,
};
use uvgraft_image::{Format, Image, WriteOptions, decode, encode};
use uvgraft_io::arrays::{self, NamedArrays, NumericArray};
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_io::{obj, sampling_map, vertex_map};

const FILTERS: [Filter; 4] =
    [Filter::Nearest, Filter::Bilinear, Filter::CatmullRom, Filter::Lanczos3];

/// Quads along the sides of a sheet.
const QUADS: usize = 3;
const VERTICES: usize = (QUADS + 1) * (QUADS + 1);

/// A layout: where the vertices of the sheet are, jittered by less than half a quad, so that no
/// triangle turns over; in a rectangle, turned by quarters, and mirrored.
#[derive(Debug, Clone)]
struct Layout {
    jitter: Vec<[f32; 2]>,
    low: [f32; 2],
    high: [f32; 2],
    quarters: u8,
    is_mirrored: bool,
}

impl Layout {
    fn uv(&self) -> Vec<[f32; 2]> {
        let place = |index: usize| {
            let at = [index % (QUADS + 1), index / (QUADS + 1)];
            let mut at: [f32; 2] = [0, 1].map(|k| {
                let is_inside = at[k] > 0 && at[k] < QUADS;
                let jitter = if is_inside { self.jitter[index][k] } else { 0.0 };
                (at[k] as f32 + jitter) / QUADS as f32
            });
            for _ in 0..self.quarters {
                at = [1.0 - at[1], at[0]];
            }
            if self.is_mirrored {
                at[0] = 1.0 - at[0];
            }
            [0, 1].map(|k| self.low[k] + (self.high[k] - self.low[k]) * at[k])
        };
        (0..VERTICES).map(place).collect()
    }

    fn mesh(&self) -> Mesh {
        let positions =
            (0..VERTICES).map(|k| [(k % 4) as f32, (k / 4) as f32, 0.1 * (k % 3) as f32]);
        let mut faces = Vec::new();
        for (row, column) in (0..QUADS).flat_map(|row| (0..QUADS).map(move |column| (row, column)))
        {
            let first = (row * (QUADS + 1) + column) as u32;
            let next = first + QUADS as u32 + 1;
            faces.extend([[first, first + 1, next + 1], [first, next + 1, next]]);
        }
        Mesh::from_triangles(positions.collect(), self.uv(), &faces, &faces).unwrap()
    }
}

fn layout() -> impl Strategy<Value = Layout> {
    let jitter = proptest::collection::vec([-0.3f32..0.3, -0.3f32..0.3], VERTICES);
    let low = [0.02f32..0.3, 0.02f32..0.3];
    let high = [0.6f32..0.98, 0.6f32..0.98];
    (jitter, low, high, 0u8..4, any::<bool>()).prop_map(
        |(jitter, low, high, quarters, is_mirrored)| Layout {
            jitter,
            low,
            high,
            quarters,
            is_mirrored,
        },
    )
}

fn pair_of(source: &Layout, target: &Layout) -> Arc<Pair> {
    let ids: Vec<i64> = (0..VERTICES as i64).collect();
    Arc::new(Pair::by_vertex_map(source.mesh(), target.mesh(), &ids).unwrap())
}

fn size() -> impl Strategy<Value = Size> {
    (17u32..90, 17u32..90).prop_map(|(width, height)| Size::new(width, height))
}

fn texture(size: Size, channels: Channels, depth: Depth, seed: u64) -> Texture {
    let mut random = fastrand::Rng::with_seed(seed);
    let count = size.texels() * channels.count();
    let texels = match depth {
        Depth::U8 => Texels::U8((0..count).map(|_| random.u8(..)).collect()),
        Depth::U16 => Texels::U16((0..count).map(|_| random.u16(..)).collect()),
        Depth::F32 => Texels::F32((0..count).map(|_| random.f32()).collect()),
    };
    let encoding = if depth == Depth::F32 { Encoding::Linear } else { Encoding::Srgb };
    Texture::new(size, channels, encoding, texels).unwrap()
}

fn grey(size: Size) -> Texture {
    Texture::filled(size, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.5; 3]).unwrap()
}

fn graft(pair: &Arc<Pair>, sizes: Sizes, filter: Filter) -> Graft {
    Graft::builder(Arc::clone(pair), sizes).filter(filter).gutter_px(0).build().unwrap()
}

fn bytes(texture: &Texture) -> &[u8] {
    let Texels::U8(values) = texture.texels() else { unreachable!("textures of 8 bits") };
    values
}

proptest! {
    // Failures are reported with what makes them; a file of old ones would be of no use to others.
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_layout_onto_itself_changes_nothing(layout in layout(), size in size(), seed: u64) {
        let pair = pair_of(&layout, &layout);
        let source = texture(size, Channels::Rgb, Depth::U8, seed);
        for filter in FILTERS {
            let graft = graft(&pair, Sizes { from: size, to: size }, filter);
            let result = graft.apply(&source, grey(size)).unwrap();
            let covered = graft.map().mask();
            for (texel, &is_covered) in bytes(&covered).iter().enumerate() {
                for at in 3 * texel..3 * texel + 3 {
                    let wanted = if is_covered > 0 { bytes(&source)[at] } else { 128 };
                    // Positions are rounded, which may change a filtered value by a level.
                    let difference = bytes(&result)[at].abs_diff(wanted);
                    prop_assert!(difference <= u8::from(filter != Filter::Nearest), "{filter:?}");
                }
            }
        }
    }

    #[test]
    fn constants_stay_constant(
        (source, target) in (layout(), layout()), (from, to) in (size(), size()), color: [u8; 3],
    ) {
        let pair = pair_of(&source, &target);
        let texels = Texels::U8(color.repeat(from.texels()));
        let flat = Texture::new(from, Channels::Rgb, Encoding::Srgb, texels).unwrap();
        for filter in FILTERS {
            let graft = graft(&pair, Sizes { from, to }, filter);
            let result = graft.apply(&flat, grey(to)).unwrap();
            for (texel, &is_covered) in bytes(&graft.map().mask()).iter().enumerate() {
                let wanted = if is_covered > 0 { color } else { [128; 3] };
                prop_assert_eq!(&bytes(&result)[3 * texel..3 * texel + 3], &wanted, "{:?}", filter);
            }
        }
    }

    #[test]
    fn transfers_are_linear_and_have_an_adjoint(
        (source, target) in (layout(), layout()), (from, to) in (size(), size()), seed: u64,
    ) {
        let pair = pair_of(&source, &target);
        let mut random = fastrand::Rng::with_seed(seed);
        let mut noise = |count: usize| -> Vec<f32> { (0..count).map(|_| random.f32() - 0.5).collect() };
        for filter in FILTERS {
            let operator = graft(&pair, Sizes { from, to }, filter).operator();
            let (a, b) = (noise(from.texels()), noise(from.texels()));
            let sum: Vec<f32> = a.iter().zip(&b).map(|(a, b)| a + 2.0 * b).collect();
            let [of_a, of_b, of_sum] = [&a, &b, &sum].map(|values| operator.apply(1, values));
            for ((a, b), sum) in of_a.iter().zip(&of_b).zip(&of_sum) {
                prop_assert!((a + 2.0 * b - sum).abs() < 1e-5, "{filter:?}: {a} {b} {sum}");
            }
            let y = noise(to.texels());
            let back = operator.apply_transposed(1, &y);
            let dot = |a: &[f32], b: &[f32]| -> f64 {
                a.iter().zip(b).map(|(&a, &b)| f64::from(a) * f64::from(b)).sum()
            };
            let scale = (to.texels() as f64).sqrt();
            prop_assert!((dot(&of_a, &y) - dot(&a, &back)).abs() < 1e-4 * scale, "{filter:?}");
        }
    }

    /// A texel of a map reads where the mean of its four texels in a map of twice the size does.
    #[test]
    fn maps_of_different_sizes_agree((source, target) in (layout(), layout()), size in size()) {
        let pair = pair_of(&source, &target);
        let options = MapOptions::with_gutter(0);
        let [coarse, fine] = [size, Size::new(2 * size.width, 2 * size.height)].map(|size| {
            SamplingMap::new(&pair, Direction::Forward, size, &options)
        });
        let read = |map: &SamplingMap, x: u32, y: u32| {
            let run = map.row(y).iter().find(|run| (run.x..run.x + run.len).contains(&x))?;
            let patch = &map.patches()[run.patch as usize];
            Some((patch.face, patch.src_uv_from_tgt_px.at([f64::from(x) + 0.5, f64::from(y) + 0.5])))
        };
        let mut compared = 0;
        for (x, y) in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))) {
            let Some((face, at)) = read(&coarse, x, y) else { continue };
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| read(&fine, 2 * x + dx, 2 * y + dy));
            if four.iter().all(|found| found.is_some_and(|(other, _)| other == face)) {
                let sum = four.iter().flatten().fold([0.0; 2], |sum, (_, uv)| [sum[0] + uv[0], sum[1] + uv[1]]);
                for k in 0..2 {
                    prop_assert!((sum[k] / 4.0 - at[k]).abs() < 1e-6, "texel {x}, {y}");
                }
                compared += 1;
            }
        }
        prop_assert!(compared > 0);
    }

    /// A target that is mirrored, or a source and its texture that are, changes nothing but that.
    #[test]
    fn mirrored_layouts_give_mirrored_results(
        (source, target) in (layout(), layout()), (from, to) in (size(), size()), seed: u64,
    ) {
        let flipped = |layout: &Layout| Layout {
            is_mirrored: !layout.is_mirrored,
            low: [1.0 - layout.high[0], layout.low[1]],
            high: [1.0 - layout.low[0], layout.high[1]],
            ..layout.clone()
        };
        let mirrored = |texture: &Texture| {
            let width = texture.size().width as usize;
            let rows = bytes(texture).chunks_exact(3 * width);
            let values = rows.flat_map(|row| row.chunks_exact(3).rev().flatten().copied());
            let texels = Texels::U8(values.collect());
            Texture::new(texture.size(), Channels::Rgb, Encoding::Srgb, texels).unwrap()
        };
        let texture = texture(from, Channels::Rgb, Depth::U8, seed);
        let sizes = Sizes { from, to };
        let plain = graft(&pair_of(&source, &target), sizes, Filter::Bilinear);
        let wanted = plain.apply(&texture, grey(to)).unwrap();
        let [of_target, of_source] = [
            graft(&pair_of(&source, &flipped(&target)), sizes, Filter::Bilinear),
            graft(&pair_of(&flipped(&source), &target), sizes, Filter::Bilinear),
        ];
        let results = [
            mirrored(&of_target.apply(&texture, grey(to)).unwrap()),
            of_source.apply(mirrored(&texture), grey(to)).unwrap(),
        ];
        for result in results {
            let differing = bytes(&result).iter().zip(bytes(&wanted)).filter(|(a, b)| a.abs_diff(**b) > 2);
            // Where a texel's centre lies on an edge, its owner may be the other triangle, or the base;
            // noise at a fold then differs.
            let texels = to.texels() as f64;
            prop_assert!((differing.count() as f64) < 0.03 * 3.0 * texels);
        }
    }

    #[test]
    fn meshes_and_pairs_are_read_as_written((source, target) in (layout(), layout())) {
        let mesh = source.mesh();
        let mut text = Vec::new();
        obj::write(&mesh, &mut text).unwrap();
        let read = obj::parse(&text).unwrap();
        prop_assert_eq!(read.positions(), mesh.positions());
        prop_assert_eq!(read.faces(), mesh.faces());
        for (read, wanted) in read.uv().iter().zip(mesh.uv()) {
            // V is turned over in the file, and again when it is read.
            prop_assert!(read.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6));
        }
        let file = PairFile {
            pair: pair_of(&source, &target),
            source_name: "a".to_owned(),
            target_name: "b\n\u{1b}".to_owned(),
            note: String::new(),
        };
        prop_assert_eq!(pair_file::decode(&pair_file::encode(&file).unwrap()).unwrap(), file);
    }

    #[test]
    fn arrays_and_ids_are_read_as_written(
        floats in proptest::collection::vec(any::<f32>(), 1..40),
        integers in proptest::collection::vec(any::<i64>(), 1..40),
        ids in proptest::collection::vec(any::<u32>(), 1..40),
        name in "[a-z_]{1,12}",
    ) {
        let mut written = NamedArrays::new();
        written.insert(name.clone(), NumericArray::new_f32(vec![floats.len()], floats.clone()).unwrap());
        written.insert("integers", NumericArray::new_i64(vec![1, integers.len()], integers.clone()).unwrap());
        let [mut plain, mut packed] = [Cursor::new(Vec::new()), Cursor::new(Vec::new())];
        arrays::write_npz(&written, &mut plain).unwrap();
        arrays::write_npz_compressed(&written, &mut packed).unwrap();
        for file in [plain, packed] {
            let read = arrays::parse(file.get_ref()).unwrap();
            if name != "integers" {
                let found = read.get(&name).unwrap().f32s();
                prop_assert!(found.iter().map(|it| it.to_bits()).eq(floats.iter().map(|it| it.to_bits())));
            }
            prop_assert_eq!(read.get("integers").unwrap().integers().unwrap(), &integers[..]);
        }
        let mut file = Vec::new();
        vertex_map::write_npy(&ids, &mut file).unwrap();
        let wanted: Vec<i64> = ids.into_iter().map(i64::from).collect();
        prop_assert_eq!(vertex_map::parse(&file).unwrap(), wanted);
    }

    #[test]
    fn images_and_maps_are_read_as_written(
        layout in layout(), size in size(), kind in 0usize..4, deep in 0usize..3, seed: u64, compress: bool,
    ) {
        let channels = [Channels::Grey, Channels::GreyAlpha, Channels::Rgb, Channels::Rgba][kind];
        let depth = [Depth::U8, Depth::U16, Depth::F32][deep];
        let texture = texture(size, channels, depth, seed);
        let formats: &[Format] = match depth {
            // EXR multiplies colours by opacity, which rounds.
            Depth::F32 if channels.has_alpha() => &[Format::TIFF],
            Depth::F32 => &[Format::TIFF, Format::EXR],
            _ => &[Format::PNG, Format::TIFF],
        };
        for &format in formats {
            let mut file = Cursor::new(Vec::new());
            let image = Image { texture: texture.clone(), icc: None };
            let options = WriteOptions::default().compress(compress);
            let written = encode(&image, format, &options, &mut file).unwrap();
            prop_assert_eq!(&written.losses, &[]);
            prop_assert_eq!(&decode(file.get_ref()).unwrap(), &image, "{}", format);
        }
        let map = SamplingMap::of_layout(&layout.mesh(), size, &MapOptions::with_gutter(0));
        let mut file = Vec::new();
        sampling_map::write_npy(&map, &mut file).unwrap();
        let read = sampling_map::parse(&file).unwrap();
        prop_assert_eq!(read.mask(), map.mask());
    }
}
