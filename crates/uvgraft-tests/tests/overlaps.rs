//! Target islands that lie on top of each other: one is shown, whole, and it can be chosen.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::islands::Islands;
use uvgraft::{
    Channels, Depth, Direction, Encoding, Filter, Graft, MapOptions, Mesh, Pair, Prefer,
    SamplingMap, Size, Sizes, Texels, Texture,
};
use uvgraft_tests::{real, synthetic};

const GUTTER: u32 = 8;

fn map_options(prefer: Prefer) -> MapOptions {
    MapOptions::with_gutter(GUTTER).prefer(prefer)
}

fn transferred(pair: &Arc<Pair>, prefer: Prefer, source: &Texture, size: Size) -> Texture {
    let graft = Graft::builder(Arc::clone(pair), Sizes { from: source.size(), to: size })
        .filter(Filter::Bilinear)
        .map_options(map_options(prefer))
        .build()
        .unwrap();
    let base = Texture::filled(size, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.5; 3]);
    graft.apply(source, base.unwrap()).unwrap()
}

fn texels(texture: &Texture) -> &[[u8; 3]] {
    let Texels::U8(values) = texture.texels() else { panic!("8 bits") };
    values.as_chunks().0
}

/// Whether the centre of a texel is within `radius` texels of a box in UV.
fn near_box([low, high]: [[f32; 2]; 2], size: Size, radius: u32) -> impl Fn(usize) -> bool {
    let [width, height] = [size.width, size.height].map(|side| side as f32);
    move |texel| {
        let [x, y] = [texel % size.width as usize, texel / size.width as usize];
        let radius = radius as f32;
        let within = |at: usize, low: f32, high: f32| {
            (low - radius..high + radius).contains(&(at as f32 + 0.5))
        };
        within(x, low[0] * width, high[0] * width) && within(y, low[1] * height, high[1] * height)
    }
}

#[test]
fn either_eye_can_be_seen_whole() {
    let pair = synthetic::pair();
    let source_size = Size::square(512);
    // The source is green around the first eye, blue around the second, red elsewhere.
    let (first, second) = ([0, 255, 0], [0, 0, 255]);
    let colors = (0..source_size.texels()).flat_map(|texel| {
        let (x, y) = (texel % 512, texel / 512);
        match ((250..400).contains(&x), y) {
            (true, 10..130) => first,
            (true, 130..260) => second,
            _ => [255, 0, 0],
        }
    });
    let source =
        Texture::new(source_size, Channels::Rgb, Encoding::Srgb, Texels::U8(colors.collect()))
            .unwrap();
    for side in [256, 512, 1000] {
        let size = Size::square(side);
        let [by_face, left, right] = [Prefer::First, Prefer::Left, Prefer::Right]
            .map(|prefer| transferred(&pair, prefer, &source, size));
        // The disc has a radius of 0.1.
        let disc = std::f32::consts::PI * (0.1 * side as f32).powi(2);
        let shows = |result: &Texture, color: [u8; 3], other: [u8; 3]| {
            let count = |color| texels(result).iter().filter(|&&texel| texel == color).count();
            count(color) as f32 > disc && count(other) == 0
        };
        // Without a preference the first eye has the disc.
        assert!(
            texels(&by_face).iter().filter(|&&texel| texel == first).count() as f32 > 0.98 * disc
        );
        let [of_left, of_right] = eyes_by_x(&pair).map(|eye| [first, second][eye]);
        assert!(shows(&left, of_left, of_right), "left at {side}");
        assert!(shows(&right, of_right, of_left), "right at {side}");
        let in_disc = near_box([[0.6995, 0.0995], [0.9005, 0.3005]], size, GUTTER + 1);
        for (texel, (a, b)) in texels(&left).iter().zip(texels(&right)).enumerate() {
            assert!(a == b || in_disc(texel), "{texel} at {side}");
        }
    }
}

/// Indices of the synthetic target's left and right eye.
fn eyes_by_x(pair: &Pair) -> [usize; 2] {
    let target = pair.target();
    // Their triangles are those in the disc, the first eye's first.
    let faces: Vec<usize> = (0..target.faces().len())
        .filter(|&face| {
            target.uv_triangle(face).iter().all(|&[u, v]| (u - 0.8).hypot(v - 0.2) < 0.11)
        })
        .collect();
    let (first, second) = faces.split_at(faces.len() / 2);
    assert_eq!(first.len(), 24);
    let [a, b] = [first, second].map(|faces| sum_of_x(target, faces.iter().copied()));
    if a > b { [0, 1] } else { [1, 0] }
}

fn sum_of_x(mesh: &Mesh, faces: impl Iterator<Item = usize>) -> f64 {
    let corners = faces.flat_map(|face| mesh.faces()[face]);
    corners.map(|vertex| f64::from(mesh.positions()[vertex as usize][0])).sum()
}

/// SMPL-X's eyeballs share one disc, and nothing else in its layout overlaps.
#[test]
fn either_eye_of_a_real_body_can_be_seen() {
    let Some(pair) = real::flame_to_smplx() else { return };
    let target = pair.target();
    let islands = Islands::new(target);
    let faces_of = |island: u32| {
        let faces = islands.of_faces().iter().enumerate();
        faces.filter(move |&(_, &of_face)| of_face == island).map(|(face, _)| face)
    };
    // The only two islands of 1,088 triangles.
    let eyes: Vec<u32> =
        (0..islands.count() as u32).filter(|&island| faces_of(island).count() == 1088).collect();
    let [left, right] = match eyes[..] {
        [a, b] if sum_of_x(target, faces_of(a)) > sum_of_x(target, faces_of(b)) => [a, b],
        [a, b] => [b, a],
        _ => panic!("{eyes:?}"),
    };
    let mut disc = [[f32::MAX; 2], [f32::MIN; 2]];
    for uv in [left, right].into_iter().flat_map(faces_of).flat_map(|face| target.uv_triangle(face))
    {
        for axis in 0..2 {
            disc[0][axis] = disc[0][axis].min(uv[axis]);
            disc[1][axis] = disc[1][axis].max(uv[axis]);
        }
    }
    let size = Size::square(2048);
    let in_disc = near_box(disc, size, GUTTER);
    // The hidden eye has no texel at all, the gutter included.
    for (prefer, hidden) in [(Prefer::Left, right), (Prefer::Right, left)] {
        let map = SamplingMap::new(&pair, Direction::Forward, size, &map_options(prefer));
        let island = |patch: u32| islands.of_faces()[map.patches()[patch as usize].face as usize];
        assert!(
            (0..size.height).flat_map(|row| map.row(row)).all(|run| island(run.patch) != hidden)
        );
    }
    let source = synthetic::detailed(Size::square(1024), 3);
    let [by_face, left, right] = [Prefer::First, Prefer::Left, Prefer::Right]
        .map(|prefer| transferred(&pair, prefer, &source, size));
    let mut differing = 0;
    for (texel, (a, b)) in texels(&left).iter().zip(texels(&right)).enumerate() {
        assert!(a == b || in_disc(texel), "{texel}");
        differing += usize::from(a != b);
    }
    // The disc has 54,730 texels at 4096², a quarter of them here, and noise seldom agrees.
    assert!(differing > 13_000, "{differing}");
    // The left eye's faces come first, so it is shown by default; but along the two edges where the
    // discs differ, the default gutter belongs to the right eye.
    let map = SamplingMap::new(&pair, Direction::Forward, size, &map_options(Prefer::Left));
    let mask = map.mask();
    let Texels::U8(mask) = mask.texels() else { panic!("8 bits") };
    let mut changed = 0;
    for (texel, (a, b)) in texels(&by_face).iter().zip(texels(&left)).enumerate() {
        assert!(a == b || in_disc(texel) && mask[texel] == 0, "{texel}");
        changed += usize::from(a != b);
    }
    assert!(changed < 300, "{changed}");
}

/// Beneath lies the other eye, and nothing beyond the disc with its gutter.
#[test]
fn the_other_eye_lies_beneath() {
    let Some(pair) = real::flame_to_smplx() else { return };
    let size = Size::square(1024);
    let options = map_options(Prefer::Right);
    let map = SamplingMap::new(&pair, Direction::Forward, size, &options);
    let left = SamplingMap::new(&pair, Direction::Forward, size, &map_options(Prefer::Left));
    let beneath = map.beneath(&pair, &options).unwrap();
    let islands = Islands::new(pair.target());
    let found: Vec<_> = (0..size.height)
        .flat_map(|row| beneath.row(row))
        .map(|run| islands.of_faces()[beneath.patches()[run.patch as usize].face as usize])
        .collect();
    assert!(found.iter().all(|island| *island == found[0]));
    // The two orders differ in nothing else, so the left eye is read as in its own map.
    for row in 0..size.height {
        for run in beneath.row(row) {
            let at = [f64::from(run.x) + 0.5, f64::from(row) + 0.5];
            let over =
                left.row(row).iter().find(|over| (over.x..over.x + over.len).contains(&run.x));
            let [a, b] = [(&beneath, run), (&left, over.unwrap())]
                .map(|(map, run)| map.patches()[run.patch as usize].src_uv_from_tgt_px.at(at));
            assert_eq!(a, b);
        }
    }
    assert_eq!(beneath.stats().overlapping, map.stats().overlapping);
    assert!(beneath.stats().linked > 3_300, "{:?}", beneath.stats());
}
