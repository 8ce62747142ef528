//! Files read back as they were written, in every format, depth and set of channels.

#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

use std::io::Cursor;

use uvgraft::color::{Encoding, linear_from_srgb};
use uvgraft::texture::{Channels, Depth, Size, Texels, TexelsMut, Texture};
use uvgraft_image::{
    EncodeError, Format, Image, Loss, WriteError, WriteOptions, decode, decode_header, encode,
    read, read_header, write,
};

const CHANNELS: [Channels; 4] =
    [Channels::Grey, Channels::GreyAlpha, Channels::Rgb, Channels::Rgba];
const DEPTHS: [Depth; 3] = [Depth::U8, Depth::U16, Depth::F32];

fn random_texture(size: Size, channels: Channels, depth: Depth, encoding: Encoding) -> Texture {
    let mut random = fastrand::Rng::with_seed(7);
    let len = size.texels() * channels.count();
    let texels = match depth {
        Depth::U8 => Texels::U8((0..len).map(|_| random.u8(..)).collect()),
        Depth::U16 => Texels::U16((0..len).map(|_| random.u16(..)).collect()),
        Depth::F32 => Texels::F32((0..len).map(|_| random.f32() * 3.0 - 1.0).collect()),
    };
    Texture::new(size, channels, encoding, texels).unwrap()
}

fn encoded(image: &Image, format: Format, compress: bool) -> (Vec<u8>, Vec<Loss>) {
    let mut out = Cursor::new(Vec::new());
    let options = WriteOptions::default().compress(compress);
    let written = encode(image, format, &options, &mut out).unwrap();
    (out.into_inner(), written.losses)
}

/// The encoding of a format at a depth, or `None` if it does not support that depth.
fn native(format: Format, depth: Depth) -> Option<Encoding> {
    match (format.name(), depth) {
        ("JPEG", _) => None,
        ("EXR" | "TIFF", Depth::F32) => Some(Encoding::Linear),
        ("EXR", _) | ("PNG", Depth::F32) => None,
        ("WebP", depth) if depth != Depth::U8 => None,
        _ => Some(Encoding::Srgb),
    }
}

#[test]
fn lossless_formats_give_back_every_value_and_the_profile() {
    // Odd and larger than a block of any of the formats; one texel; one row; one column.
    for size in [Size::new(67, 35), Size::new(1, 1), Size::new(300, 1), Size::new(1, 300)] {
        for &format in Format::ALL {
            for (channels, depth) in CHANNELS.iter().flat_map(|c| DEPTHS.map(|d| (*c, d))) {
                let Some(encoding) = native(format, depth) else { continue };
                let mut texture = random_texture(size, channels, depth, encoding);
                if format == Format::EXR && channels.has_alpha() {
                    // Premultiplied in the file: exact where alpha is a power of two.
                    let TexelsMut::F32(values) = texture.texels_mut() else { unreachable!() };
                    for (index, texel) in values.chunks_exact_mut(channels.count()).enumerate() {
                        texel[channels.count() - 1] = [1.0, 0.5, 0.125][index % 3];
                    }
                }
                let icc = (format != Format::EXR).then(|| vec![42; 3000]);
                let image = Image { texture, icc };
                for compress in [false, true] {
                    let (bytes, losses) = encoded(&image, format, compress);
                    let name = format!("{format} {channels:?} {depth:?} {size}");
                    assert_eq!(losses, [], "{name}");
                    assert_eq!(Format::detect(&bytes), Some(format));
                    let found = decode(&bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
                    assert_eq!(found.icc, image.icc, "{name}");
                    let wanted = if format == Format::WEBP {
                        in_color(&image.texture)
                    } else {
                        image.texture.clone()
                    };
                    assert!(found.texture == wanted, "{name}");
                    let header = decode_header(&bytes).unwrap();
                    let channels = wanted.channels();
                    let found = (header.format, header.size, header.channels, header.depth);
                    assert_eq!(found, (format, size, channels, depth));
                }
            }
        }
    }
}

/// WebP has no grey.
fn in_color(texture: &Texture) -> Texture {
    let Texels::U8(values) = texture.texels() else { unreachable!() };
    let channels = Channels::Rgb.union(texture.channels());
    let values = match texture.channels() {
        Channels::Grey => values.iter().flat_map(|&v| [v; 3]).collect(),
        Channels::GreyAlpha => {
            values.chunks_exact(2).flat_map(|v| [v[0], v[0], v[0], v[1]]).collect()
        }
        _ => values.clone(),
    };
    Texture::new(texture.size(), channels, texture.encoding(), Texels::U8(values)).unwrap()
}

#[test]
fn jpeg_comes_close_and_keeps_the_profile() {
    for channels in [Channels::Grey, Channels::Rgb] {
        let size = Size::new(67, 35);
        let levels =
            (0..size.texels() * channels.count()).map(|i| (i / channels.count() % 67 * 3) as u8);
        let texels = Texels::U8(levels.collect());
        let texture = Texture::new(size, channels, Encoding::Srgb, texels).unwrap();
        // Larger than one segment of a JPEG.
        let icc: Vec<u8> = (0..100_000).map(|i| (i % 251) as u8).collect();
        let image = Image { texture, icc: Some(icc) };
        let (bytes, losses) = encoded(&image, Format::JPEG, false);
        assert_eq!(losses, []);
        let found = decode(&bytes).unwrap();
        assert_eq!(found.icc, image.icc);
        assert_eq!(found.texture.channels(), channels);
        for (x, y) in [(0, 0), (33, 17), (66, 34)] {
            assert!((found.texture.get(x, y, 0) - image.texture.get(x, y, 0)).abs() < 4.0 / 255.0);
        }
        let header = decode_header(&bytes).unwrap();
        let found = (header.format, header.size, header.channels, header.depth);
        assert_eq!(found, (Format::JPEG, size, channels, Depth::U8));
    }
}

#[test]
fn losses_are_named() {
    let size = Size::square(2);
    let icc = Some(vec![1, 2, 3]);
    let deep = random_texture(size, Channels::Rgb, Depth::U16, Encoding::Srgb);
    let image = Image { texture: deep, icc: icc.clone() };
    let rounded = |from, to| Loss::Precision { from, to };
    for format in [Format::JPEG, Format::WEBP] {
        assert_eq!(encoded(&image, format, false).1, [rounded(Depth::U16, Depth::U8)]);
    }
    assert_eq!(encoded(&image, Format::EXR, false).1, [Loss::IccProfile { format: Format::EXR }]);
    let float = random_texture(size, Channels::Rgba, Depth::F32, Encoding::Linear);
    let image = Image { texture: float, icc };
    assert_eq!(
        encoded(&image, Format::PNG, false).1,
        [rounded(Depth::F32, Depth::U16), Loss::IccOutdated, Loss::Range]
    );
    assert_eq!(encoded(&image, Format::TIFF, false).1, []);
    let hidden = Loss::HiddenColor { format: Format::EXR };
    let clear =
        Texture::filled(size, Channels::Rgba, Encoding::Linear, Depth::F32, &[1.0, 1.0, 1.0, 0.0]);
    assert_eq!(encoded(&clear.unwrap().into(), Format::EXR, false).1, [hidden]);
    assert!(hidden.to_string().contains("premultiplied"));
}

#[test]
fn encodings_are_converted_unless_it_is_data() {
    let fill = |encoding, value| {
        Texture::filled(
            Size::square(2),
            Channels::Rgba,
            encoding,
            Depth::U8,
            &[value, value, value, 1.0],
        )
    };
    let through = |texture: Texture, format| {
        let texture = decode(&encoded(&texture.into(), format, false).0).unwrap().texture;
        (texture.get(1, 1, 0), texture.get(1, 1, 3), texture.encoding())
    };
    let (value, alpha, encoding) = through(fill(Encoding::Srgb, 0.6).unwrap(), Format::EXR);
    assert_eq!((value, alpha, encoding), (linear_from_srgb(0.6), 1.0, Encoding::Linear));
    let (value, _, encoding) = through(fill(Encoding::Linear, 0.2).unwrap(), Format::PNG);
    assert!((value - 0.484_53).abs() < 0.5 / 255.0, "{value}");
    assert_eq!(encoding, Encoding::Srgb);
    for format in [Format::PNG, Format::TIFF, Format::EXR, Format::WEBP] {
        assert_eq!(through(fill(Encoding::Data, 0.6).unwrap(), format).0, 0.6);
    }
    let float =
        Texture::filled(Size::square(1), Channels::Grey, Encoding::Srgb, Depth::F32, &[0.5]);
    let found = decode(&encoded(&float.unwrap().into(), Format::TIFF, false).0).unwrap().texture;
    assert_eq!((found.get(0, 0, 0), found.encoding()), (linear_from_srgb(0.5), Encoding::Linear));
}

#[test]
fn data_with_opacity_is_not_premultiplied() {
    let values = [0.75, 0.5, 0.25, 0.5];
    let texture =
        Texture::filled(Size::square(1), Channels::Rgba, Encoding::Data, Depth::F32, &values);
    let (bytes, losses) = encoded(&texture.unwrap().into(), Format::EXR, false);
    assert_eq!(losses, []);
    // The reader cannot know, and divides.
    assert_eq!(decode(&bytes).unwrap().texture.get(0, 0, 0), 1.5);
}

#[test]
fn what_a_format_cannot_hold_is_refused() {
    let options = WriteOptions::default();
    let alpha = random_texture(Size::square(2), Channels::Rgba, Depth::U8, Encoding::Srgb);
    let refused = encode(&alpha.into(), Format::JPEG, &options, &mut Cursor::new(Vec::new()));
    let error = refused.unwrap_err();
    assert!(matches!(error, EncodeError::Alpha { .. }));
    assert!(error.to_string().starts_with("JPEG does not support transparency; use PNG"));
    let long = random_texture(Size::new(16_384, 1), Channels::Grey, Depth::U8, Encoding::Srgb);
    let refused = encode(&long.into(), Format::WEBP, &options, &mut Cursor::new(Vec::new()));
    let message = "WebP supports at most 16383 texels a side, got 16384×1";
    assert_eq!(refused.unwrap_err().to_string(), message);
    let edge = random_texture(Size::new(16_383, 1), Channels::Rgb, Depth::U8, Encoding::Srgb);
    let image = Image::from(edge);
    assert!(decode(&encoded(&image, Format::WEBP, false).0).unwrap() == image);
}

#[test]
fn paths_decide_what_is_written_and_content_what_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let options = WriteOptions::default();
    let texture = random_texture(Size::new(5, 3), Channels::Rgb, Depth::U8, Encoding::Srgb);
    let image = Image::from(texture);
    for name in ["a.png", "a.TIFF", "a.webp"] {
        let path = folder.path().join(name);
        assert_eq!(write(&image, &path, &options).unwrap().losses, []);
        assert!(read(&path).unwrap() == image);
        assert_eq!(read_header(&path).unwrap().size, Size::new(5, 3));
    }
    let misnamed = folder.path().join("b.jpg");
    std::fs::copy(folder.path().join("a.png"), &misnamed).unwrap();
    assert!(read(&misnamed).unwrap() == image);
    assert_eq!(read_header(&misnamed).unwrap().format, Format::PNG);
    for (name, part) in [
        ("c", ": cannot infer an image format from a name without an extension"),
        ("c.gif", ": cannot infer an image format from the extension .gif"),
    ] {
        let error = write(&image, folder.path().join(name), &options).unwrap_err();
        assert!(matches!(error, WriteError::Extension { .. }));
        let message = error.to_string();
        assert!(
            message.contains(part)
                && message.ends_with(".png, .jpg, .jpeg, .webp, .tif, .tiff, .exr")
        );
    }
    let error = read(folder.path().join("none.png")).unwrap_err().to_string();
    assert!(error.contains("none.png: "), "{error}");
}
