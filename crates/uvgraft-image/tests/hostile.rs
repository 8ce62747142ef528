//! Truncated, damaged or malicious files: always an immediate error, never a panic.

#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

use std::io::Cursor;
use std::path::Path;
use std::time::{Duration, Instant};

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Depth, Size, Texels, Texture};
use uvgraft_image::{
    Format, Image, ImageError, MAX_BYTES, WriteOptions, decode, decode_header, encode,
};

/// Small files of every format, our own and others'.
fn seeds() -> Vec<(String, Vec<u8>)> {
    let mut random = fastrand::Rng::with_seed(11);
    let size = Size::new(23, 17);
    let mut seeds = Vec::new();
    for &format in Format::ALL {
        for (channels, deep) in
            [(Channels::Grey, false), (Channels::Rgb, true), (Channels::Rgba, false)]
        {
            if format == Format::JPEG && channels.has_alpha() {
                continue;
            }
            let len = size.texels() * channels.count();
            let texels = if deep {
                Texels::U16((0..len).map(|_| random.u16(..)).collect())
            } else {
                Texels::U8((0..len).map(|i| (i / 3 % 256) as u8).collect())
            };
            let texture = Texture::new(size, channels, Encoding::Srgb, texels).unwrap();
            let image = Image { texture, icc: Some(vec![9; 50]) };
            for compress in [false, true] {
                let options = WriteOptions::default().compress(compress);
                let mut out = Cursor::new(Vec::new());
                let _ = encode(&image, format, &options, &mut out).unwrap();
                seeds.push((format!("own {format} {channels:?} {compress}"), out.into_inner()));
            }
        }
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/samples");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let bytes = std::fs::read(path).unwrap();
        if decode(&bytes).is_ok() {
            seeds.push((name, bytes));
        }
    }
    seeds.extend(crate::tiff_file::kinds());
    seeds.sort();
    assert!(seeds.len() > 50);
    seeds
}

#[test]
fn no_cut_passes_for_a_whole_image() {
    for (name, bytes) in seeds() {
        let whole = decode(&bytes).unwrap();
        for cut in 0..bytes.len() {
            if let Ok(image) = decode(&bytes[..cut]) {
                // The tags of a TIFF may follow its texels and be padded; then nothing is missing.
                assert!(
                    name.ends_with("tif") && image == whole,
                    "{name} cut to {cut} of {}",
                    bytes.len()
                );
            }
        }
    }
}

#[test]
fn a_cut_is_called_a_cut() {
    for (name, bytes) in seeds() {
        let cut = &bytes[..bytes.len() * 2 / 3];
        match decode(cut) {
            Err(ImageError::Truncated { .. }) => {}
            other => panic!("{name}: {:?}", other.map(|_| "an image")),
        }
    }
}

#[test]
fn damage_never_panics_or_stalls() {
    let seeds = seeds();
    let mut random = fastrand::Rng::with_seed(5);
    let start = Instant::now();
    let mut refused = 0;
    let rounds = std::env::var("UVGRAFT_FUZZ_ROUNDS").map_or(60, |rounds| rounds.parse().unwrap());
    for (name, seed) in &seeds {
        for round in 0..rounds {
            let mut bytes = seed.clone();
            for _ in 0..random.usize(1..6) {
                // Half of the damage hits the header, where it does most harm.
                let end = if random.bool() { bytes.len() } else { bytes.len().min(128) };
                let at = random.usize(..end);
                match random.u8(..4) {
                    0 => bytes[at] ^= 1 << random.u8(..8),
                    1 => bytes[at] = random.choice([0, 1, 0x7f, 0x80, 0xff]).unwrap(),
                    2 => bytes.truncate(at.max(20).min(bytes.len())),
                    _ => bytes[at] = random.u8(..),
                }
            }
            let outcome = std::panic::catch_unwind(|| {
                let decoded = [decode_header(&bytes).map(drop), decode(&bytes).map(drop)];
                // A caught panic is one all the same.
                let gave_up = |it: &Result<(), _>| matches!(it, Err(ImageError::GaveUp { .. }));
                assert!(!decoded.iter().any(gave_up), "{decoded:?}");
                decoded[1].is_ok()
            });
            match outcome {
                Ok(true) => {}
                Ok(false) => refused += 1,
                Err(_) => {
                    let path = std::env::temp_dir().join("uvgraft-panicking-image");
                    std::fs::write(&path, &bytes).unwrap();
                    panic!("{name}, round {round}: see {}", path.display());
                }
            }
        }
    }
    assert!(refused > seeds.len() * rounds / 3, "only {refused} were refused");
    assert!(start.elapsed() < Duration::from_secs(120));
}

/// Replaces the size in the header of a small file.
fn with_size(format: Format, side: u32) -> Vec<u8> {
    let texture =
        Texture::filled(Size::square(4), Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.5; 3]);
    let mut out = Cursor::new(Vec::new());
    let _ = encode(&texture.unwrap().into(), format, &WriteOptions::default(), &mut out).unwrap();
    let mut bytes = out.into_inner();
    let find =
        |bytes: &[u8], what: &[u8]| bytes.windows(what.len()).position(|w| w == what).unwrap();
    match format.name() {
        "PNG" => {
            bytes[16..20].copy_from_slice(&side.to_be_bytes());
            bytes[20..24].copy_from_slice(&side.to_be_bytes());
        }
        "JPEG" => {
            let at = find(&bytes, &[0xff, 0xc0]) + 5;
            bytes[at..at + 2].copy_from_slice(&(side.min(65_535) as u16).to_be_bytes());
            bytes[at + 2..at + 4].copy_from_slice(&(side.min(65_535) as u16).to_be_bytes());
        }
        "WebP" => {
            // An extended header before the image; sides are stored minus 1, in 24 bits.
            let side = (side - 1).to_le_bytes();
            let mut chunk = b"VP8X\x0a\0\0\0\0\0\0\0".to_vec();
            chunk.extend(&side[..3]);
            chunk.extend(&side[..3]);
            bytes.splice(12..12, chunk);
            let length = (bytes.len() as u32 - 8).to_le_bytes();
            bytes[4..8].copy_from_slice(&length);
        }
        "TIFF" => {
            // Width, height and rows per strip, all three.
            for tag in [256u16, 257, 278] {
                let mut entry = tag.to_le_bytes().to_vec();
                entry.extend([4, 0, 1, 0, 0, 0]);
                let at = find(&bytes, &entry) + 8;
                bytes[at..at + 4].copy_from_slice(&side.to_le_bytes());
            }
        }
        "EXR" => {
            let chunks = b"chunkCount\0int\0\x04\0\0\0";
            let at = find(&bytes, chunks) + chunks.len();
            bytes[at..at + 4].copy_from_slice(&side.to_le_bytes());
            let largest = (side - 1).to_le_bytes();
            for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
                let at = find(&bytes, name) + name.len() + 4 + 8;
                bytes[at..at + 4].copy_from_slice(&largest);
                bytes[at + 4..at + 8].copy_from_slice(&largest);
            }
        }
        other => panic!("no hostile {other} is known"),
    }
    bytes
}

#[test]
fn lies_about_the_size_are_found_out_at_once() {
    for &format in Format::ALL {
        let bytes = with_size(format, 100_000);
        let start = Instant::now();
        for error in [decode(&bytes).unwrap_err(), decode_header(&bytes).unwrap_err()] {
            let side = if format == Format::JPEG { 65_535 } else { 100_000 };
            let wanted =
                format!("{format} must have at most 32768 texels a side, got {side}×{side}");
            assert_eq!(error.to_string(), wanted);
        }
        // The sides are allowed; memory is allocated lazily or not at all.
        let bytes = with_size(format, 30_000);
        assert!(decode(&bytes).is_err(), "{format}");
        assert!(start.elapsed() < Duration::from_secs(2), "{format}: {:?}", start.elapsed());
        assert!(decode(&with_size(format, 4)).is_ok(), "{format}");
    }
    let error = decode(&with_size(Format::EXR, 30_000)).unwrap_err().to_string();
    let wanted = format!(
        "EXR of 30000×30000 texels must take at most {MAX_BYTES} bytes in memory, got 10800000000"
    );
    assert_eq!(error, wanted);
}

/// Channels beside those of the texture are decoded, too, and take 21 bytes of a header each.
#[test]
fn unused_channels_of_exr_count() {
    let attribute = |name: &str, kind: &str, value: &[u8]| {
        let length = (value.len() as u32).to_le_bytes();
        [name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &length, value].concat()
    };
    let channel = |name: String| {
        [name.as_bytes(), b"\0", [2, 0, 1, 1].map(i32::to_le_bytes).as_flattened()].concat()
    };
    let names = ["Y".to_owned()].into_iter().chain((0..300).map(|at| format!("Z{at:03}")));
    let channels: Vec<u8> = names.flat_map(channel).chain([0]).collect();
    let window = [0, 0, 1023, 1023].map(i32::to_le_bytes);
    let one = 1_f32.to_le_bytes();
    let file = [
        b"\x76\x2f\x31\x01\x02\0\0\0".to_vec(),
        attribute("channels", "chlist", &channels),
        attribute("compression", "compression", &[0]),
        attribute("dataWindow", "box2i", window.as_flattened()),
        attribute("displayWindow", "box2i", window.as_flattened()),
        attribute("lineOrder", "lineOrder", &[0]),
        attribute("pixelAspectRatio", "float", &one),
        attribute("screenWindowCenter", "v2f", &[0; 8]),
        attribute("screenWindowWidth", "float", &one),
        vec![0],
    ]
    .concat();
    let stored = 301 << 22;
    assert!(decode_header(&file).unwrap().decoding_bytes > stored);
    let refused = decode(&file).unwrap_err();
    assert!(
        matches!(refused, ImageError::Unbacked { least, .. } if least == stored / 200),
        "{refused}"
    );
}

/// A canvas of one texel may not hide a frame of 16,383 × 16,383, which takes 400 MB.
#[test]
fn lossy_frames_of_webp_fit_their_canvas() {
    let chunk = |name: &[u8; 4], content: &[u8]| {
        [name, &(content.len() as u32).to_le_bytes()[..], content].concat()
    };
    let frame = [&[0x10, 2, 0, 0x9d, 1, 0x2a, 0xff, 0x3f, 0xff, 0x3f][..], &[0; 64]].concat();
    let frame = chunk(b"VP8 ", &frame);
    let still = [chunk(b"VP8X", &[0; 10]), frame.clone()].concat();
    let moving = [
        chunk(b"VP8X", &[2, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
        chunk(b"ANIM", &[0; 6]),
        chunk(b"ANMF", &[&[0; 16], &frame[..]].concat()),
    ]
    .concat();
    for chunks in [still, moving] {
        let file = chunk(b"RIFF", &[b"WEBP", &chunks[..]].concat());
        let refused = decode(&file).unwrap_err().to_string();
        assert!(refused.contains("a frame of 16383×16383 texels"), "{refused}");
    }
}
