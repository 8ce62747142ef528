//! Visible defects of earlier implementations, each shown to be gone.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::raster::ScanTriangle;
use uvgraft::{
    Averaging, Channels, Content, Depth, Direction, Encoding, Filter, Graft, GraftBuilder,
    MapOptions, Mesh, Pair, SamplingMap, Size, Sizes, Texels, TexelsMut, Texture,
};
use uvgraft_metrics::baseline::grid;
use uvgraft_tests::{real, synthetic};

fn builder(pair: &Arc<Pair>, from: Size, to: Size, filter: Filter, gutter_px: u32) -> GraftBuilder {
    Graft::builder(Arc::clone(pair), Sizes { from, to }).filter(filter).gutter_px(gutter_px)
}

fn graft(pair: &Arc<Pair>, from: Size, to: Size, filter: Filter, gutter_px: u32) -> Graft {
    builder(pair, from, to, filter, gutter_px).build().unwrap()
}

/// A square linked to itself.
fn square_to_itself(inset: f32) -> Arc<Pair> {
    let square = synthetic::square(inset);
    Arc::new(Pair::by_vertex_map(square.clone(), square, &[0, 1, 2, 3]).unwrap())
}

fn filled(size: Size, color: [f32; 3]) -> Texture {
    Texture::filled(size, Channels::Rgb, Encoding::Srgb, Depth::U8, &color).unwrap()
}

fn bytes(texture: &Texture) -> &[u8] {
    let Texels::U8(values) = texture.texels() else { panic!("8 bits") };
    values
}

/// A texture of seeded noise in any format.
fn noise(size: Size, channels: Channels, depth: Depth) -> Texture {
    let mut rng = fastrand::Rng::with_seed(11);
    let count = size.texels() * channels.count();
    let texels = match depth {
        Depth::U8 => Texels::U8((0..count).map(|_| rng.u8(1..)).collect()),
        Depth::U16 => Texels::U16((0..count).map(|_| rng.u16(1..)).collect()),
        Depth::F32 => Texels::F32((0..count).map(|_| rng.f32() * 4.0 + 0.01).collect()),
    };
    Texture::new(size, channels, Encoding::Srgb, texels).unwrap()
}

/// An identical mesh yields an identical image: no half-texel shift, no lost alpha or bits, at any
/// size.
#[test]
fn identity_is_exact_in_every_format() {
    let pair = square_to_itself(0.0);
    for size in [Size::square(64), Size::new(100, 57), Size::new(1, 9)] {
        for channels in [Channels::Grey, Channels::GreyAlpha, Channels::Rgb, Channels::Rgba] {
            for depth in [Depth::U8, Depth::U16, Depth::F32] {
                let texture = noise(size, channels, depth);
                for filter in Filter::ALL {
                    let graft = graft(&pair, size, size, filter, 0);
                    let nothing = &[0.0; 4][..channels.count()];
                    let base =
                        Texture::filled(size, channels, Encoding::Srgb, depth, nothing).unwrap();
                    let result = graft.apply(&texture, base).unwrap();
                    if depth == Depth::F32 {
                        // Positions are rounded to 2⁻³² texels, and premultiplication rounds.
                        let (Texels::F32(a), Texels::F32(b)) = (result.texels(), texture.texels())
                        else {
                            panic!("float")
                        };
                        // Alpha is at most 1.
                        let alpha = channels.has_alpha();
                        for (k, (a, b)) in a.iter().zip(b).enumerate() {
                            let last = k % channels.count() == channels.count() - 1;
                            let wanted = if alpha && last { b.min(1.0) } else { *b };
                            if !alpha {
                                assert!((a - wanted).abs() <= 2e-6 * wanted, "{filter}: {a} {b}");
                            }
                        }
                    } else {
                        assert_eq!(result, texture, "{filter} {channels:?} {depth:?} {size}");
                    }
                }
            }
        }
    }
}

#[test]
fn identity_of_a_real_layout_changes_nothing_inside_islands() {
    let pair = synthetic::pair();
    let mesh = pair.target().clone();
    let vertex_map: Vec<i64> = (0..mesh.positions().len() as i64).collect();
    let same = Arc::new(Pair::by_vertex_map(mesh.clone(), mesh, &vertex_map).unwrap());
    let size = Size::new(700, 512);
    let texture = synthetic::detailed(size, 5);
    let graft = graft(&same, size, size, Filter::Lanczos3, 0);
    let result = graft.apply(&texture, &texture).unwrap();
    assert!(bytes(&result) == bytes(&texture));
}

/// Two eyes share a disc. It belongs to one of them, with a fringe, so that filtering never blends
/// in the other.
#[test]
fn overlapping_eyes_never_speckle() {
    let pair = synthetic::pair();
    let source_size = Size::square(512);
    // The source is blue around the second eye, red elsewhere.
    let texels = (0..source_size.texels()).flat_map(|texel| {
        let (x, y) = (texel % 512, texel / 512);
        let second = (250..400).contains(&x) && (130..260).contains(&y);
        if second { [0, 0, 255] } else { [255, 0, 0] }
    });
    let source =
        Texture::new(source_size, Channels::Rgb, Encoding::Srgb, Texels::U8(texels.collect()))
            .unwrap();
    for side in [256, 512, 1000] {
        let size = Size::square(side);
        let graft = graft(&pair, source_size, size, Filter::Bilinear, 0);
        assert!(graft.map().stats().overlapping > 0);
        let result = graft.apply(&source, filled(size, [0.0, 1.0, 0.0])).unwrap();
        let blue = bytes(&result).chunks_exact(3).filter(|texel| texel[2] > 0).count();
        assert_eq!(blue, 0, "texels of the second eye at {side}");
    }
}

/// A constant colour stays constant up to the last texel of the gutter, although the source's
/// background and the base have other colours; and no gap opens along the linked region.
fn carries_skin_alone(
    pair: &Arc<Pair>,
    direction: Direction,
    source_size: Size,
    size: Size,
    filter: Filter,
) {
    const SKIN: [u8; 3] = [200, 150, 120];
    const GREEN: [u8; 3] = [0, 255, 0];
    // Skin on the islands, magenta around them.
    let islands = islands_mask(pair.from(direction), source_size);
    let texels = islands.iter().flat_map(|&inside| if inside { SKIN } else { [255, 0, 255] });
    let source =
        Texture::new(source_size, Channels::Rgb, Encoding::Srgb, Texels::U8(texels.collect()))
            .unwrap();
    let graft = builder(pair, source_size, size, filter, 8).direction(direction).build().unwrap();
    let result = graft.apply(source, filled(size, [0.0, 1.0, 0.0])).unwrap();
    let covered = islands_mask(pair.to(direction), size);
    let mask = graft.mask();
    let linked = |texel: usize| bytes(&mask)[texel] == 255;
    let width = size.width as usize;
    for (texel, value) in bytes(&result).chunks_exact(3).enumerate() {
        if value == SKIN {
            continue;
        }
        assert_eq!(value, GREEN, "{filter} {direction:?} {size}: bleeding at {texel}");
        assert!(!linked(texel), "{filter} {direction:?} {size}: a hole at {texel}");
        // Whether a texel within a radius, along both axes, satisfies `is`.
        let near = |radius: usize, is: &dyn Fn(usize) -> bool| {
            let (x, y) = (texel % width, texel / width);
            (y.saturating_sub(radius)..=(y + radius).min(size.height as usize - 1)).any(|y| {
                (x.saturating_sub(radius)..=(x + radius).min(width - 1)).any(|x| is(y * width + x))
            })
        };
        // Next to an unlinked triangle a texel may rightly show the base.
        let foreign = near(3, &|other| covered[other] && !linked(other));
        let gap = !covered[texel] && !foreign && near(2, &linked);
        assert!(!gap, "{filter} {direction:?} {size}: a gap at {texel}");
    }
}

#[test]
fn nothing_bleeds_in_and_no_gap_opens_at_borders() {
    let pair = synthetic::pair();
    for (direction, source, target) in [
        (Direction::Forward, 300, 640),
        (Direction::Reverse, 640, 300),
        (Direction::Forward, 512, 128),
    ] {
        for filter in Filter::ALL {
            carries_skin_alone(
                &pair,
                direction,
                Size::square(source),
                Size::square(target),
                filter,
            );
        }
    }
}

#[test]
fn nothing_bleeds_in_and_no_gap_opens_on_real_meshes() {
    let Some(pair) = real::flame_to_smplx() else { return };
    assert_eq!(pair.piece_count(), 9_976);
    let (head, body) = (Size::square(2048), Size::square(4096));
    carries_skin_alone(&pair, Direction::Forward, head, body, Filter::Lanczos3);
    carries_skin_alone(&pair, Direction::Reverse, body, head, Filter::Lanczos3);
    // Eightfold minification, with the largest footprints.
    carries_skin_alone(&pair, Direction::Reverse, body, Size::square(512), Filter::Lanczos3);
}

/// The texels that a layout covers.
fn islands_mask(mesh: &Mesh, size: Size) -> Vec<bool> {
    let mut covered = vec![false; size.texels()];
    let scale = [f64::from(size.width), f64::from(size.height)];
    for face in 0..mesh.faces().len() {
        let corners = mesh.uv_triangle(face);
        let corners_px = corners.map(|uv| [0, 1].map(|axis| f64::from(uv[axis]) * scale[axis]));
        let Some(triangle) = ScanTriangle::new(corners_px, size) else { continue };
        for row in triangle.rows() {
            for x in triangle.span(row) {
                covered[row as usize * size.width as usize + x as usize] = true;
            }
        }
    }
    covered
}

/// The gutter extends the island's content by the requested width, never over texels that another
/// triangle owns.
#[test]
fn the_gutter_has_the_requested_width() {
    let pair = square_to_itself(0.25);
    let size = Size::square(64);
    for gutter in [0, 1, 5, 12] {
        let map =
            SamplingMap::new(&pair, Direction::Forward, size, &MapOptions::with_gutter(gutter));
        for row in 0..64u32 {
            let mut reached = [false; 64];
            for run in map.row(row) {
                reached[run.x as usize..(run.x + run.len) as usize].fill(true);
            }
            for x in 0..64u32 {
                let beyond =
                    |at: u32| (16.0 - (f64::from(at) + 0.5)).max(f64::from(at) + 0.5 - 48.0);
                let (dx, dy) = (beyond(x).max(0.0), beyond(row).max(0.0));
                assert_eq!(reached[x as usize], dx.hypot(dy) < f64::from(gutter) || dx + dy == 0.0);
            }
        }
    }
}

/// One-texel stripes minified eightfold turn grey, not into wider stripes.
#[test]
fn small_targets_do_not_alias() {
    let pair = square_to_itself(0.0);
    let (large, small) = (Size::square(2048), Size::square(250));
    let texels = (0..large.texels()).flat_map(|texel| {
        [if (texel % 2048 + texel / 2048).is_multiple_of(2) { 255 } else { 0 }; 3]
    });
    let checker =
        Texture::new(large, Channels::Rgb, Encoding::Srgb, Texels::U8(texels.collect())).unwrap();
    let contrast = |texture: &Texture| {
        let inner = bytes(texture).iter().map(|&value| i32::from(value));
        inner.clone().max().unwrap() - inner.min().unwrap()
    };
    for filter in [Filter::Bilinear, Filter::CatmullRom, Filter::Lanczos3] {
        let graft = graft(&pair, large, small, filter, 0);
        let result = graft.apply(&checker, filled(small, [0.0; 3])).unwrap();
        assert!(contrast(&result) <= 16, "{filter}: {}", contrast(&result));
    }
    let map = SamplingMap::new(&pair, Direction::Forward, small, &MapOptions::with_gutter(0));
    let aliased = grid::transfer(&map, &checker, filled(small, [0.0; 3]));
    assert!(contrast(&aliased) > 200, "the test must see aliasing: {}", contrast(&aliased));
}

/// Source alpha controls how much of the base shows; colour under zero alpha never leaks.
#[test]
fn alpha_is_filtered_premultiplied() {
    let pair = square_to_itself(0.0);
    let (size, target) = (Size::square(8), Size::square(64));
    // Opaque white on the left, transparent black on the right.
    let texels = (0..64).flat_map(|texel| if texel % 8 < 4 { [255; 4] } else { [0, 0, 0, 0] });
    let source =
        Texture::new(size, Channels::Rgba, Encoding::Srgb, Texels::U8(texels.collect())).unwrap();
    let graft = graft(&pair, size, target, Filter::Bilinear, 0);
    let clear = Texture::filled(target, Channels::Rgba, Encoding::Srgb, Depth::U8, &[0.0; 4]);
    let result = graft.apply(&source, clear.unwrap()).unwrap();
    assert!(bytes(&result).chunks_exact(4).all(|texel| texel[3] == 0 || texel[0] == 255));
    let over_red = graft.apply(source, filled(target, [1.0, 0.0, 0.0])).unwrap();
    assert_eq!(over_red.channels(), Channels::Rgba);
    let row: Vec<&[u8]> = bytes(&over_red)[..64 * 4].chunks_exact(4).collect();
    assert_eq!((row[0], row[63]), (&[255, 255, 255, 255][..], &[255, 0, 0, 255][..]));
    // Across the edge red stays full while white fades.
    assert!(row.iter().all(|texel| texel[0] == 255 && texel[3] == 255 && texel[1] == texel[2]));
    assert!(row.windows(2).all(|pair| pair[1][1] <= pair[0][1]));
}

/// Alpha of 1 costs no colour levels and stays 1, whatever the unread rows hold.
#[test]
fn full_alpha_changes_no_color() {
    let whole = synthetic::square(0.0);
    // The source's layout covers the upper part only.
    let half = {
        let uv = whole.uv().iter().map(|&[u, v]| [u, v * 0.4]).collect();
        let faces: Vec<[u32; 3]> = vec![[0, 1, 2], [0, 2, 3]];
        Mesh::from_triangles(whole.positions().to_vec(), uv, &faces, &faces).unwrap()
    };
    let pair = Arc::new(Pair::by_vertex_map(half, whole, &[0, 1, 2, 3]).unwrap());
    let (source_size, size) = (Size::square(96), Size::square(128));
    for (filter, depth) in Filter::ALL
        .into_iter()
        .flat_map(|filter| [Depth::U8, Depth::U16, Depth::F32].map(|depth| (filter, depth)))
    {
        let plain = noise(source_size, Channels::Rgb, depth);
        let opaque = plain.clone().converted(Channels::Rgba, depth);
        let graft = graft(&pair, source_size, size, filter, 4);
        let base = filled(size, [0.2, 0.4, 0.6]);
        let carried = |source| graft.apply(source, base.clone()).unwrap();
        let result = carried(opaque.clone());
        assert_eq!(result.channels(), Channels::Rgba, "{filter}");
        if depth != Depth::F32 {
            assert!(
                result == carried(plain).converted(Channels::Rgba, depth),
                "{filter} {depth:?}"
            );
        }
        let read = graft.texture_rows();
        assert!(read.start == 0 && read.end < 96, "{read:?}");
        let mut cut = opaque;
        let first = read.end as usize * 96 * 4;
        match cut.texels_mut() {
            TexelsMut::U8(values) => values[first..].fill(0),
            TexelsMut::U16(values) => values[first..].fill(0),
            TexelsMut::F32(values) => values[first..].fill(0.0),
        }
        assert!(result == carried(cut), "{filter} {depth:?}");
    }
}

/// Cubic filters undershoot next to an edge in alpha; this must not cause a dark halo.
#[test]
fn edges_of_alpha_have_no_halo() {
    let pair = square_to_itself(0.0);
    let (size, target) = (Size::square(16), Size::square(64));
    let texels = (0..256).flat_map(|texel| if texel % 16 < 8 { [255; 4] } else { [0; 4] });
    let source =
        Texture::new(size, Channels::Rgba, Encoding::Srgb, Texels::U8(texels.collect())).unwrap();
    for filter in Filter::ALL {
        let graft = graft(&pair, size, target, filter, 0);
        let result = graft.apply(&source, filled(target, [0.5; 3])).unwrap();
        let darkest = bytes(&result).iter().min();
        assert_eq!(darkest, Some(&128), "{filter}");
    }
}

/// In data the fourth channel is a value like the others, and the base never shows through.
#[test]
fn packed_data_is_replaced_channel_by_channel() {
    let pair = square_to_itself(0.0);
    let size = Size::square(16);
    let packed = noise(size, Channels::Rgba, Depth::U8);
    let base = noise(size, Channels::Rgba, Depth::U8);
    let data = |texture: &Texture| texture.clone().with_encoding(Encoding::Data);
    for filter in Filter::ALL {
        let plain = graft(&pair, size, size, filter, 0);
        assert_eq!(plain.apply(data(&packed), data(&base)).unwrap(), data(&packed));
        assert_ne!(plain.apply(&packed, &base).unwrap(), packed);
        // The content can be declared for the transfer as well as by the textures.
        let of_data = builder(&pair, size, size, filter, 0).content(Content::Data).build().unwrap();
        assert_eq!(of_data.apply(&packed, &base).unwrap(), data(&packed));
    }
}

/// 16-bit and float sources keep their depth over an 8-bit base, and the reverse.
#[test]
fn the_greater_depth_wins() {
    let pair = square_to_itself(0.25);
    let size = Size::square(32);
    let graft = graft(&pair, size, size, Filter::CatmullRom, 4);
    let (deep, shallow) =
        (noise(size, Channels::Rgb, Depth::U16), noise(size, Channels::Rgb, Depth::U8));
    let result = graft.apply(&deep, &shallow).unwrap();
    assert_eq!(result.depth(), Depth::U16);
    assert_eq!(result.get(16, 16, 1), deep.get(16, 16, 1));
    assert_eq!(result.get(1, 1, 1), shallow.get(1, 1, 1));
    let result = graft.apply(&shallow, &deep).unwrap();
    assert_eq!(result.get(1, 1, 1), deep.get(1, 1, 1));
    let float = graft.apply(noise(size, Channels::Rgb, Depth::F32), shallow).unwrap();
    assert_eq!(float.depth(), Depth::F32);
}

/// In linear light, the mean of black and white is the grey of half the light.
#[test]
fn linear_light_averages_light() {
    let pair = square_to_itself(0.0);
    let (size, target) = (Size::new(64, 64), Size::square(8));
    let texels =
        (0..size.texels()).flat_map(|texel| [if texel.is_multiple_of(2) { 0 } else { 255 }; 3]);
    let stripes =
        Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(texels.collect())).unwrap();
    let middle = |averaging: Averaging| {
        let graft = builder(&pair, size, target, Filter::Bilinear, 0).averaging(averaging).build();
        let result = graft.unwrap().apply(&stripes, filled(target, [0.0; 3])).unwrap();
        bytes(&result)[(4 * 8 + 4) * 3]
    };
    let encoded = middle(Averaging::Encoded);
    assert!((127..=128).contains(&encoded), "{encoded}");
    assert_eq!(middle(Averaging::Light), 188);
}
