//! How long images take. Run by hand: `cargo test --release -p uvgraft-io --test image_speed --
//! --ignored --nocapture`.

#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

use std::io::Cursor;
use std::time::Instant;

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Size, Texels, Texture};
use uvgraft_io::image::{Format, Image, WriteOptions, decode, encode};

/// A texture of slow waves; `noise` adds that many levels of detail that no filter predicts.
fn texture(side: u32, noise: i32, deep: bool) -> Texture {
    let mut random = fastrand::Rng::with_seed(1);
    let mut values = Vec::with_capacity(side as usize * side as usize * 3);
    for y in 0..side {
        for x in 0..side {
            let wave = (x as f32 * 0.003).sin() * 60.0 + (y as f32 * 0.005).cos() * 50.0;
            let pores = (x as f32 * 0.31).sin() * (y as f32 * 0.27).sin() * noise as f32;
            let grain = if noise > 0 { random.i32(-noise..=noise) } else { 0 };
            for offset in [0.0, -20.0, 15.0] {
                let level = (128.0 + wave + pores + offset) as i32 + grain;
                values.push(level.clamp(0, 255) as u8);
            }
        }
    }
    let texels = if deep {
        let low = |v: u8| u16::from(v) * 256 + random.u16(0..if noise > 0 { 200 } else { 1 });
        Texels::U16(values.into_iter().map(low).collect())
    } else {
        Texels::U8(values)
    };
    Texture::new(Size::square(side), Channels::Rgb, Encoding::Srgb, texels).unwrap()
}

#[test]
#[ignore = "prints timings of 4096² textures, checks nothing"]
fn timings() {
    for (name, noise, deep) in [
        ("smooth", 0, false),
        ("detailed", 6, false),
        ("smooth 16", 0, true),
        ("detailed 16", 6, true),
    ] {
        let image = Image { texture: texture(4096, noise, deep), icc: None };
        for format in Format::ALL {
            for compress in [false, true] {
                if compress && matches!(format, Format::Jpeg | Format::WebP) {
                    continue;
                }
                let options = WriteOptions { compress, ..WriteOptions::default() };
                let mut out = Cursor::new(Vec::with_capacity(1 << 28));
                let start = Instant::now();
                let _ = encode(&image, format, &options, &mut out).unwrap();
                let encoded = start.elapsed();
                let bytes = out.into_inner();
                let start = Instant::now();
                decode(&bytes).unwrap();
                let decoded = start.elapsed();
                println!(
                    "{name:11} {format:4} compress {compress:5}: encode {encoded:7.3?} decode \
                     {decoded:7.3?} {:6.1} MB",
                    bytes.len() as f64 / 1e6
                );
            }
        }
    }
}

#[test]
#[ignore = "prints timings of 4096² textures, checks nothing"]
fn timings_of_turning_and_of_the_transfer_function() {
    let image = Image { texture: texture(4096, 0, false), icc: None };
    let mut out = Cursor::new(Vec::new());
    let _ = encode(&image, Format::Jpeg, &WriteOptions::default(), &mut out).unwrap();
    for tag in [1, 2, 3, 4, 5, 6, 7, 8] {
        let mut bytes = out.get_ref().clone();
        let mut exif =
            b"\xff\xe1\0\x22Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01".to_vec();
        exif.extend([0, tag, 0, 0, 0, 0, 0, 0]);
        bytes.splice(2..2, exif);
        let start = Instant::now();
        decode(&bytes).unwrap();
        println!("JPEG with orientation {tag}: decode {:7.3?}", start.elapsed());
    }
    let Texels::U8(values) = image.texture.texels() else { unreachable!() };
    let values = values.iter().map(|&value| f32::from(value) / 255.0).collect();
    let size = Size::square(4096);
    let float = Texture::new(size, Channels::Rgb, Encoding::Linear, Texels::F32(values)).unwrap();
    let float = Image::from(float);
    for format in [Format::Png, Format::Exr, Format::Tiff] {
        let mut out = Cursor::new(Vec::with_capacity(1 << 28));
        let start = Instant::now();
        let _ = encode(&float, format, &WriteOptions::default(), &mut out).unwrap();
        println!("linear float to {format}: encode {:7.3?}", start.elapsed());
    }
}
