//! Images from other programs: every supported variant, and clear errors for the others.

#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

use std::path::Path;

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Depth, Size, Texture};
use uvgraft_image::{decode, decode_header, read, read_header};

const SIZE: Size = Size::new(13, 9);

fn bytes(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/samples");
    std::fs::read(folder.join(name)).unwrap()
}

/// Reads a sample, and checks that the header agrees with the texture.
fn sample(name: &str) -> Texture {
    let bytes = bytes(name);
    let image = decode(&bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
    let header = decode_header(&bytes).unwrap();
    let texture = image.texture;
    assert_eq!(
        (header.size, header.channels, header.depth),
        (texture.size(), texture.channels(), texture.depth()),
        "{name}"
    );
    texture
}

fn color(x: u32, y: u32, channel: usize) -> f32 {
    [19 * x, 28 * y, 12 * (x + y)][channel] as f32 / 255.0
}

fn alpha(x: u32, y: u32) -> f32 {
    (255 - 10 * x - 3 * y) as f32 / 255.0
}

/// Compares every value with the result of `wanted` for `(x, y, channel)`.
fn check(name: &str, texture: &Texture, tolerance: f32, wanted: impl Fn(u32, u32, usize) -> f32) {
    assert_eq!(texture.size(), SIZE, "{name}");
    for (x, y) in (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y))) {
        for channel in 0..texture.channels().count() {
            let (found, wanted) = (texture.get(x, y, channel), wanted(x, y, channel));
            let difference = (found - wanted).abs();
            assert!(difference <= tolerance, "{name} ({x}, {y}) {channel}: {found}, not {wanted}");
        }
    }
}

#[test]
fn exact_samples_are_read_exactly() {
    for (name, channels, depth) in [
        ("oriented.png", Channels::Rgb, Depth::U8),
        ("exif_behind.png", Channels::Rgb, Depth::U8),
        ("oriented.tif", Channels::Rgb, Depth::U8),
        ("oriented.webp", Channels::Rgb, Depth::U8),
    ] {
        // Tag 6: the stored image lies on its left side.
        let texture = sample(name);
        assert_eq!(
            (texture.size(), texture.channels(), texture.depth()),
            (Size::new(9, 13), channels, depth)
        );
        for (x, y) in (0..9).flat_map(|x| (0..13).map(move |y| (x, y))) {
            for channel in 0..3 {
                assert_eq!(texture.get(x, y, channel), color(y, 8 - x, channel), "{name}");
            }
        }
    }
    for name in ["lzw_tiled.tif", "bigtiff.tif", "animated.webp"] {
        let texture = sample(name);
        assert_eq!((texture.channels(), texture.depth()), (Channels::Rgb, Depth::U8));
        check(name, &texture, 0.0, color);
    }
    for name in ["planar16.tif", "interlaced16.png"] {
        let texture = sample(name);
        assert_eq!((texture.channels(), texture.depth()), (Channels::Rgb, Depth::U16));
        let wanted =
            |x, y, channel| ((color(x, y, channel) * 255.0).round() * 200.0 + 7.0) / 65_535.0;
        check(name, &texture, 0.0, wanted);
    }
    for (name, tolerance) in [
        ("zip_float.exr", 1e-7),
        ("piz_half.exr", 5e-4),
        ("half.tif", 5e-4),
        ("predictor3.tif", 1e-7),
    ] {
        let texture = sample(name);
        assert_eq!((texture.channels(), texture.depth()), (Channels::Rgb, Depth::F32));
        assert_eq!(texture.encoding(), Encoding::Linear);
        check(name, &texture, tolerance, color);
    }
}

#[test]
fn grey_palettes_and_colour_keys_become_channels() {
    for (bits, name) in [(1, "grey1.png"), (2, "grey2.png"), (4, "grey4.png")] {
        let texture = sample(name);
        assert_eq!((texture.channels(), texture.depth()), (Channels::Grey, Depth::U8));
        let levels = 1 << bits;
        check(name, &texture, 1e-6, |x, y, _| ((x + y) % levels) as f32 / (levels - 1) as f32);
    }
    let index = |x: u32, y: u32| (x / 4 + y / 3 * 4) % 16;
    let entry = |x, y, channel: usize| match channel {
        0 => (index(x, y) * 16) as f32 / 255.0,
        1 => (255 - index(x, y) * 16) as f32 / 255.0,
        2 => (index(x, y) * 5) as f32 / 255.0,
        _ if index(x, y) < 8 => (index(x, y) * 10) as f32 / 255.0,
        _ => 1.0,
    };
    let texture = sample("palette.png");
    assert_eq!(texture.channels(), Channels::Rgb);
    check("palette.png", &texture, 0.0, entry);
    let texture = sample("palette_alpha.png");
    assert_eq!(texture.channels(), Channels::Rgba);
    check("palette_alpha.png", &texture, 0.0, entry);
    let texture = sample("key.png");
    assert_eq!(texture.channels(), Channels::Rgba);
    check("key.png", &texture, 0.0, |x, y, channel| match channel {
        3 => f32::from((x, y) != (1, 1)),
        _ => color(x, y, channel),
    });
    for name in ["white_is_zero.tif", "y.exr", "height.exr"] {
        let texture = sample(name);
        assert_eq!(texture.channels(), Channels::Grey);
        check(name, &texture, 1e-7, color);
    }
    // Reduced to 16 colours by Pillow, which reads these.
    let texture = sample("palette.tif");
    assert_eq!((texture.channels(), texture.depth()), (Channels::Rgb, Depth::U8));
    let level = |x, y, channel| (texture.get(x, y, channel) * 255.0).round();
    assert_eq!([0, 1, 2].map(|channel| level(0, 0, channel)), [48.0, 0.0, 30.0]);
    assert_eq!([0, 1, 2].map(|channel| level(5, 2, channel)), [133.0, 56.0, 108.0]);
    let texture = sample("double.tif");
    assert_eq!((texture.channels(), texture.depth()), (Channels::Grey, Depth::F32));
    check("double.tif", &texture, 0.0, |x, _, _| (19 * x) as f32);
    let texture = sample("bilevel.tif");
    assert_eq!((texture.get(0, 0, 0), texture.get(12, 8, 0)), (0.0, 1.0));
}

#[test]
fn opacity_is_not_premultiplied_in_a_texture() {
    let texture = sample("grey_alpha.tif");
    assert_eq!(texture.channels(), Channels::GreyAlpha);
    let wanted = |x, y, channel| if channel == 1 { alpha(x, y) } else { color(x, y, 0) };
    check("grey_alpha.tif", &texture, 0.0, wanted);
    for (name, tolerance) in [("associated.tif", 1.01 / 255.0), ("rgba.exr", 1e-6)] {
        let texture = sample(name);
        assert_eq!(texture.channels(), Channels::Rgba);
        let wanted = |x, y, channel| if channel == 3 { alpha(x, y) } else { color(x, y, channel) };
        check(name, &texture, tolerance, wanted);
    }
}

#[test]
fn lossy_samples_come_close() {
    for (name, tolerance) in [
        ("baseline.jpg", 5.0),
        ("progressive.jpg", 5.0),
        ("restarts.jpg", 5.0),
        ("rgb.jpg", 5.0),
        ("subsampled.jpg", 20.0),
        ("lossy.webp", 20.0),
        ("lossy_alpha.webp", 20.0),
    ] {
        let texture = sample(name);
        let wanted = |x, y, channel| if channel == 3 { alpha(x, y) } else { color(x, y, channel) };
        check(name, &texture, tolerance / 255.0, wanted);
    }
    let texture = sample("oriented.jpg");
    assert_eq!(texture.size(), Size::new(9, 13));
    assert!((texture.get(8, 12, 0) - color(12, 0, 0)).abs() < 5.0 / 255.0);
}

#[test]
fn a_data_window_is_put_where_it_belongs() {
    let name = "window.exr";
    let texture = sample(name);
    assert_eq!(texture.size(), Size::new(10, 20));
    for (x, y) in (0..20).flat_map(|y| (0..10).map(move |x| (x, y))) {
        let wanted = if x >= 3 && (2..=10).contains(&y) { color(x - 3, y - 2, 1) } else { 0.0 };
        assert!((texture.get(x, y, 1) - wanted).abs() < 1e-7, "({x}, {y})");
    }
}

#[test]
fn what_makes_no_texture_is_refused_with_a_reason() {
    for (name, part) in [
        ("cmyk.jpg", "unsupported JPEG: CMYK colours"),
        ("cmyk.tif", "unsupported TIFF: CMYK colours"),
        ("int32.tif", "unsupported TIFF: 32-bit signed integers"),
        ("two.exr", "unsupported EXR: channels U, V"),
        ("ids.exr", "unsupported EXR: integer channel R"),
    ] {
        for error in [decode(&bytes(name)).unwrap_err(), decode_header(&bytes(name)).unwrap_err()] {
            assert!(error.to_string().contains(part), "{name}: {error}");
        }
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    for error in [read(&path).unwrap_err(), read_header(&path).unwrap_err()] {
        let message = error.to_string();
        let wanted = "Cargo.toml: not a supported image (PNG, JPEG, WebP, TIFF, EXR): starts with \"[package\"";
        assert!(message.ends_with(wanted), "{message}");
    }
    assert!(decode(b"").unwrap_err().to_string().ends_with("the file is empty"));
}
