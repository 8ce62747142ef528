//! Images of cameras, painting programs and old tools, as textures of a transfer.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::io::Cursor;

use png::{BitDepth, ColorType};
use uvgraft::{Channels, Depth, Encoding, Size, Texels, Texture};
use uvgraft_image::{self as image, Format, WriteOptions};

use super::{Case, Expected, Near, Refused, Same, case, check};
use crate::bench::Bench;

const SIDE: u32 = 16;
const COMMAND: (&str, &str) = ("transfer my.uvpair FILE --size 16 -o out.png", "out.png");
/// Half a step of 8 bits, and what the filter's weights for bytes are rounded by.
const STEP: f32 = 0.6 / 255.0;

/// The picture: 16 colours in blocks of 4 texels, without symmetries.
fn color(x: u32, y: u32) -> [u8; 3] {
    let block = x / 4 + y / 4 * 4;
    [block * 17, 255 - block * 11, (block * 53) % 256].map(|value| value as u8)
}

fn texels<const C: usize>(value: impl Fn(u32, u32) -> [u8; C]) -> Vec<u8> {
    (0..SIDE * SIDE).flat_map(|k| value(k % SIDE, k / SIDE)).collect()
}

/// A PNG of any kind.
fn png(kind: ColorType, depth: BitDepth, palette: Option<Vec<u8>>, data: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, SIDE, SIDE);
    encoder.set_color(kind);
    encoder.set_depth(depth);
    if let Some(palette) = palette {
        encoder.set_palette(palette);
    }
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    file
}

fn plain() -> Vec<u8> {
    png(ColorType::Rgb, BitDepth::Eight, None, &texels(color))
}

fn texture(value: impl Fn(u32, u32) -> [u8; 3]) -> Texture {
    let texels = Texels::U8(texels(value));
    Texture::new(Size::square(SIDE), Channels::Rgb, Encoding::Srgb, texels).unwrap()
}

fn encoded(format: Format, texture: Texture) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let options = WriteOptions::default().jpeg_quality(100);
    let written = image::encode(&texture.into(), format, &options, &mut file).unwrap();
    assert_eq!(written.losses, []);
    file.into_inner()
}

/// A JPEG that a camera held upright has turned: its rows are the picture's columns.
fn turned_jpeg() -> Vec<u8> {
    // Stored so that a quarter turn clockwise, which orientation 6 asks for, gives the picture.
    let stored = encoded(Format::JPEG, texture(|x, y| color(SIDE - 1 - y, x)));
    let tiff = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0";
    let exif = [&b"Exif\0\0"[..], tiff].concat();
    let length = (exif.len() as u16 + 2).to_be_bytes();
    [&stored[..2], &[0xff, 0xe1], &length, &exif, &stored[2..]].concat()
}

/// An uncompressed BMP, from the bottom row up.
fn bmp() -> Vec<u8> {
    let rows =
        (0..SIDE).rev().flat_map(|y| (0..SIDE).flat_map(move |x| color(x, y).into_iter().rev()));
    let data: Vec<u8> = rows.collect();
    let word = |value: usize| (value as u32).to_le_bytes();
    [
        b"BM",
        &word(54 + data.len())[..],
        &word(0),
        &word(54),
        &word(40),
        &word(16),
        &word(16),
        b"\x01\0\x18\0",
        &[0; 24],
        &data,
    ]
    .concat()
}

fn cases() -> Vec<Case> {
    let file =
        |name, file, content: Vec<u8>, expected: Expected| case(name, file, content, expected);
    let wide: Vec<u8> = texels(color).into_iter().flat_map(|value| [value, value]).collect();
    let alpha = texels(|x, y| {
        let [r, g, b] = color(x, y);
        [r, g, b, 255]
    });
    let block = |x: u32, y: u32| [(x / 4 + y / 4 * 4) as u8];
    let palette: Vec<u8> = (0..16).flat_map(|block| color(block % 4 * 4, block / 4 * 4)).collect();
    let packed: Vec<u8> = texels(block).chunks(2).map(|pair| pair[0] << 4 | pair[1]).collect();
    let wrong_end = |content: Vec<u8>, left: usize| content[..content.len() - left].to_vec();
    let tga = [&[0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 16, 0, 16, 0, 24, 0x20][..], &texels(color)]
        .concat();
    vec![
        file("8 bits", "a.png", plain(), Same),
        file("16 bits", "a.png", png(ColorType::Rgb, BitDepth::Sixteen, None, &wide), Near(STEP)),
        file("alpha of 255", "a.png", png(ColorType::Rgba, BitDepth::Eight, None, &alpha), Same),
        file(
            "palette",
            "a.png",
            png(ColorType::Indexed, BitDepth::Eight, Some(palette.clone()), &texels(block)),
            Same,
        ),
        file(
            "palette of 4 bits",
            "a.png",
            png(ColorType::Indexed, BitDepth::Four, Some(palette), &packed),
            Same,
        ),
        file("named as another format", "a.jpg", plain(), Same),
        file("no extension", "a", plain(), Same),
        file("TIFF", "a.tif", encoded(Format::TIFF, texture(color)), Same),
        file("WebP", "a.webp", encoded(Format::WEBP, texture(color)), Same),
        // Blocks of 8×8 texels of four colours lose a few percent.
        file("JPEG", "a.jpg", encoded(Format::JPEG, texture(color)), Near(0.12)),
        file("a turned JPEG", "a.jpg", turned_jpeg(), Near(0.12)),
        file(
            "CMYK",
            "a.jpg",
            include_bytes!("../../../uvgraft-image/tests/samples/cmyk.jpg").to_vec(),
            Refused("CMYK colours"),
        ),
        file("BMP", "a.bmp", bmp(), Refused("not a supported image")),
        file("TGA", "a.tga", tga, Refused("not a supported image")),
        file(
            "GIF",
            "a.gif",
            b"GIF89a\x01\0\x01\0\x80\0\0\0\0\0\xff\xff\xff,\0\0\0\0\x01\0\x01\0\0\x02\x02D\x01\0;"
                .to_vec(),
            Refused("not a supported image"),
        ),
        file("empty", "a.png", Vec::new(), Refused("empty")),
        file("a web page", "a.png", b"<!DOCTYPE html>".to_vec(), Refused("not a supported image")),
        file("cut PNG", "a.png", wrong_end(plain(), 40), Refused("a.png")),
        file(
            "cut JPEG",
            "a.jpg",
            wrong_end(encoded(Format::JPEG, texture(color)), 60),
            Refused("a.jpg"),
        ),
        file("cut header", "a.png", plain()[..20].to_vec(), Refused("a.png")),
    ]
}

#[test]
fn image_files() {
    let bench = Bench::new();
    bench.write("plain.png", plain());
    bench.succeed("transfer my.uvpair plain.png --size 16 -o wanted.png");
    let wanted = bench.texture("wanted.png").converted(Channels::Rgb, Depth::F32);
    check(&bench, cases(), COMMAND, |bench| {
        let found = bench.texture(COMMAND.1).converted(Channels::Rgb, Depth::F32);
        let [Texels::F32(found), Texels::F32(wanted)] = [found.texels(), wanted.texels()] else {
            return Err("must be floats".to_owned());
        };
        Ok(found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max))
    });
}

#[test]
fn single_texels_are_textures() {
    let bench = Bench::new();
    bench.draw("one.png", (1, 1), |_, _| [200, 100, 50]);
    bench.succeed("transfer my.uvpair one.png --size 4 -o out.png");
    let texel = crate::bench::texel_u8(&bench.texture("out.png"), 1, 1);
    assert_eq!(texel[..3], [200, 100, 50]);
}
