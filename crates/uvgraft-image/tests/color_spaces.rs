//! Colour spaces that files declare: chunks of PNG and attributes of EXR.

#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, FlatSamples, Image as ExrImage, ImageAttributes, Layer, Vec2,
    WritableImage as _, attribute,
};
use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Size, Texels, Texture};
use uvgraft_image::{
    BandDecoder, DeclaredSpace, Format, Image, ImageError, WriteOptions, decode, decode_with,
    encode,
};

/// sRGB, in the order of a cHRM chunk.
const SRGB: [u32; 8] = [31_270, 32_900, 64_000, 33_000, 30_000, 60_000, 15_000, 6_000];
const DISPLAY_P3: [u32; 8] = [31_270, 32_900, 68_000, 32_000, 26_500, 69_000, 15_000, 6_000];

fn chunk(kind: &[u8; 4], content: &[u8]) -> Vec<u8> {
    let body = [kind, content].concat();
    let length = content.len() as u32;
    [&length.to_be_bytes()[..], &body, &crc32fast::hash(&body).to_be_bytes()].concat()
}

fn gamma(value: u32) -> Vec<u8> {
    chunk(b"gAMA", &value.to_be_bytes())
}

fn primaries(values: [u32; 8]) -> Vec<u8> {
    chunk(b"cHRM", &values.map(u32::to_be_bytes).concat())
}

fn code_points(primaries: u8, transfer: u8, is_full: u8) -> Vec<u8> {
    chunk(b"cICP", &[primaries, transfer, 0, is_full])
}

/// A PNG that declares a colour space.
fn png(texels: Texels, channels: Channels, chunks: &[Vec<u8>]) -> Vec<u8> {
    let size = Size::new((texels.len() / channels.count()) as u32, 1);
    let texture = Texture::new(size, channels, Encoding::Srgb, texels).unwrap();
    let mut out = Cursor::new(Vec::new());
    let _ = encode(&texture.into(), Format::PNG, &WriteOptions::default(), &mut out).unwrap();
    let plain = out.into_inner();
    let header = 8 + 25;
    [&plain[..header], &chunks.concat(), &plain[header..]].concat()
}

fn read(bytes: &[u8]) -> Texels {
    decode(bytes).unwrap().texture.into_texels()
}

/// What an RGB texel of 8 bits becomes.
fn rgb(texel: [u8; 3], chunks: &[Vec<u8>]) -> [u8; 3] {
    let Texels::U8(values) = read(&png(Texels::U8(texel.to_vec()), Channels::Rgb, chunks)) else {
        unreachable!("of 8 bits")
    };
    values.try_into().unwrap()
}

#[test]
fn values_of_srgb_stay_whatever_way_it_is_declared() {
    let srgb = chunk(b"sRGB", &[0]);
    for chunks in [
        vec![srgb.clone()],
        vec![gamma(45_455)],
        vec![gamma(45_454), primaries(SRGB)],
        vec![gamma(45_000)],
        vec![primaries(SRGB)],
        vec![code_points(1, 13, 1)],
        // sRGB counts more than gAMA and cHRM, and so does cICP.
        vec![gamma(100_000), primaries(DISPLAY_P3), srgb.clone()],
        vec![code_points(1, 13, 1), gamma(100_000), srgb],
        // Nonsense.
        vec![gamma(0)],
        vec![gamma(1)],
        vec![primaries([0; 8])],
        vec![primaries([31_270, 32_900, 64_000, 33_000, 64_000, 33_000, 15_000, 6_000])],
        vec![code_points(2, 2, 1)],
        vec![chunk(b"gAMA", &[1])],
    ] {
        assert_eq!(rgb([1, 100, 200], &chunks), [1, 100, 200], "{chunks:?}");
    }
}

#[test]
fn gamma_and_primaries_are_converted() {
    // Half the light is 188 in sRGB; 1.8 was the gamma of older Macs.
    assert_eq!(rgb([128, 0, 255], &[gamma(100_000)]), [188, 0, 255]);
    assert_eq!(rgb([128, 0, 255], &[gamma(55_556)]), [146, 0, 255]);
    // White and greys stay; the most saturated colours are clipped.
    assert_eq!(rgb([255, 255, 255], &[primaries(DISPLAY_P3)]), [255, 255, 255]);
    assert_eq!(rgb([255, 0, 0], &[gamma(45_455), primaries(DISPLAY_P3)]), [255, 0, 0]);
    let muted = rgb([200, 120, 100], &[code_points(12, 13, 1)]);
    assert_eq!(muted, [213, 115, 95]);
}

#[test]
fn cicp_counts_most_and_is_converted() {
    let linear = code_points(1, 8, 1);
    assert_eq!(rgb([128, 0, 255], &[linear, gamma(45_455)]), [188, 0, 255]);
    // 203 cd/m² is white, in PQ and in HLG; brighter light is clipped.
    assert_eq!(rgb([148, 148, 255], &[code_points(1, 16, 1)]), [255, 255, 255]);
    let white = rgb([191; 3], &[code_points(9, 18, 1)]);
    assert!(white.iter().all(|&value| value >= 254), "{white:?}");
    // In the narrow range, black is 16 and white is 235.
    assert_eq!(rgb([16, 126, 235], &[code_points(1, 13, 0)]), [0, 128, 255]);
}

#[test]
fn unknown_code_points_are_refused() {
    for invalid in [[1, 13, 1, 1], [9, 16, 9, 1], [1, 13, 0, 2]] {
        let bytes = png(Texels::U8(vec![1, 2, 3]), Channels::Rgb, &[chunk(b"cICP", &invalid)]);
        let error = decode(&bytes).unwrap_err();
        assert!(matches!(error, ImageError::Unsupported { .. }), "{error}");
    }
    for chunk in [code_points(1, 200, 1), code_points(77, 13, 1)] {
        let bytes = png(Texels::U8(vec![1, 2, 3]), Channels::Rgb, &[chunk]);
        let error = decode(&bytes).unwrap_err();
        assert!(matches!(error, ImageError::Unsupported { .. }), "{error}");
        decode_with(&bytes, DeclaredSpace::Ignored).unwrap();
    }
}

#[test]
fn all_channels_and_depths_are_converted_but_alpha() {
    let linear = [gamma(100_000)];
    let read = |texels, channels| read(&png(texels, channels, &linear));
    assert_eq!(read(Texels::U8(vec![128]), Channels::Grey), Texels::U8(vec![188]));
    let grey_alpha = read(Texels::U8(vec![128, 128]), Channels::GreyAlpha);
    assert_eq!(grey_alpha, Texels::U8(vec![188, 128]));
    let deep = read(Texels::U16(vec![32_768, 0, 65_535, 32_768]), Channels::Rgba);
    assert_eq!(deep, Texels::U16(vec![48_192, 0, 65_535, 32_768]));
}

#[test]
fn palettes_and_interlaced_images_are_converted() {
    for (color, bits) in [(3u8, 8u8), (0, 4)] {
        let header = [0, 0, 0, 1, 0, 0, 0, 1, bits, color, 0, 0, 1];
        let palette = if color == 3 { chunk(b"PLTE", &[128, 0, 255]) } else { Vec::new() };
        // Index 0, or 8 of 15; a stored block of two bytes, and its checksum.
        let value = if color == 3 { 0 } else { 0x80 };
        let adler = 1u32 + u32::from(value);
        let sum = ((2 + u32::from(value)) << 16) | adler;
        let data = [&[0x78, 0x01, 1, 2, 0, 0xfd, 0xff, 0, value][..], &sum.to_be_bytes()].concat();
        let bytes = [
            b"\x89PNG\r\n\x1a\n".to_vec(),
            chunk(b"IHDR", &header),
            gamma(100_000),
            palette,
            chunk(b"IDAT", &data),
            chunk(b"IEND", &[]),
        ]
        .concat();
        let wanted = if color == 3 { vec![188, 0, 255] } else { vec![193] };
        assert_eq!(read(&bytes), Texels::U8(wanted));
    }
}

#[test]
fn bands_are_converted_once() {
    let values: Vec<u8> = (0..=255).collect();
    let linear = png(Texels::U8(values), Channels::Grey, &[gamma(100_000)]);
    let whole = decode(&linear).unwrap().texture;
    let mut bands = BandDecoder::new(&linear).unwrap();
    assert_eq!(bands.next_band(1).unwrap(), Some(whole.clone()));
    let (read, _) = BandDecoder::new(&linear).unwrap().read_while(|_| true).unwrap();
    assert_eq!(read, whole);
}

#[test]
fn a_declared_space_can_be_ignored() {
    let bytes = png(Texels::U8(vec![128, 0, 255]), Channels::Rgb, &[code_points(9, 16, 1)]);
    let stored = decode_with(&bytes, DeclaredSpace::Ignored).unwrap().texture;
    assert_eq!(*stored.texels(), Texels::U8(vec![128, 0, 255]));
    assert_eq!(stored.encoding(), Encoding::Srgb);
}

#[test]
fn written_files_declare_nothing() {
    let linear = png(Texels::U8(vec![128, 0, 255]), Channels::Rgb, &[gamma(100_000)]);
    let mut out = Cursor::new(Vec::new());
    let image = decode(&linear).unwrap();
    let _ = encode(&image, Format::PNG, &WriteOptions::default(), &mut out).unwrap();
    assert_eq!(decode(out.get_ref()).unwrap(), image);
    assert!(!out.get_ref().windows(4).any(|bytes| bytes == b"gAMA"));
}

#[test]
fn a_profile_counts_more_than_gamma_and_less_than_cicp() {
    let texture =
        Texture::new(Size::new(1, 1), Channels::Rgb, Encoding::Srgb, Texels::U8(vec![128, 0, 255]));
    let image = Image { texture: texture.unwrap(), icc: Some(vec![7; 40]) };
    let mut out = Cursor::new(Vec::new());
    let _ = encode(&image, Format::PNG, &WriteOptions::default(), &mut out).unwrap();
    let with = |chunk: &[u8]| {
        let plain = out.get_ref();
        decode(&[&plain[..33], chunk, &plain[33..]].concat()).unwrap()
    };
    assert_eq!(with(&gamma(100_000)), image);
    let converted = with(&code_points(1, 8, 1));
    assert_eq!(converted.icc, None);
    assert_eq!(*converted.texture.texels(), Texels::U8(vec![188, 0, 255]));
}

/// An EXR of one texel.
fn exr(channels: &[(&str, f32)], space: Option<[[f32; 2]; 4]>) -> Vec<u8> {
    let list =
        channels.iter().map(|&(name, value)| AnyChannel::new(name, FlatSamples::F32(vec![value])));
    let layer = Layer::new(
        (1, 1),
        Default::default(),
        exr::prelude::Encoding::UNCOMPRESSED,
        AnyChannels::sort(list.collect()),
    );
    let mut attributes = ImageAttributes::with_size((1, 1));
    attributes.chromaticities = space.map(|space| {
        let [red, green, blue, white] = space.map(|[x, y]| Vec2(x, y));
        attribute::Chromaticities { red, green, blue, white }
    });
    let mut out = Cursor::new(Vec::new());
    ExrImage::empty(attributes).with_layer(layer).write().to_buffered(&mut out).unwrap();
    out.into_inner()
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    let Texels::F32(values) = read(bytes) else { unreachable!("floats") };
    values
}

fn near(found: &[f32], wanted: &[f32]) -> bool {
    found.len() == wanted.len()
        && found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-3)
}

/// Red, green, blue and white.
const REC_709: [[f32; 2]; 4] = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]];
const REC_2020: [[f32; 2]; 4] = [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], [0.3127, 0.329]];
const AP0: [[f32; 2]; 4] = [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], [0.32168, 0.33767]];

#[test]
fn chromaticities_of_exr_are_converted() {
    let color = [("R", 0.5), ("G", 0.25), ("B", 2.0)];
    let stored = [0.5, 0.25, 2.0];
    assert!(near(&floats(&exr(&color, None)), &stored));
    assert_eq!(floats(&exr(&color, Some(REC_709))), stored);
    // The matrix of ITU-R BT.2087.
    assert!(near(&floats(&exr(&color, Some(REC_2020))), &[0.5376, 0.2043, 2.2032]));
    // White stays white, although that of ACES is not D65; ACES' green is outside of sRGB.
    let white = [("R", 1.0), ("G", 1.0), ("B", 1.0)];
    assert!(near(&floats(&exr(&white, Some(AP0))), &[1.0; 3]));
    let green = floats(&exr(&[("R", 0.0), ("G", 1.0), ("B", 0.0)], Some(AP0)));
    assert!(near(&green, &[-1.1341, 1.3727, -0.1530]), "{green:?}");
    // Nonsense is ignored.
    assert_eq!(floats(&exr(&color, Some([[0.0; 2]; 4]))), stored);
    assert_eq!(floats(&exr(&color, Some([[f32::NAN; 2]; 4]))), stored);
    // Greys have no primaries.
    assert_eq!(floats(&exr(&[("Y", 0.5)], Some(REC_2020))), [0.5]);
    let bytes = exr(&color, Some(REC_2020));
    let ignored = decode_with(&bytes, DeclaredSpace::Ignored).unwrap().texture;
    assert_eq!(*ignored.texels(), Texels::F32(stored.to_vec()));
}

#[test]
fn light_without_coverage_is_kept() {
    // A flame adds light to what is behind it, which it does not cover.
    let flame = exr(&[("R", 3.0), ("G", 0.5), ("B", 0.0), ("A", 0.0)], None);
    assert_eq!(floats(&flame), [3.0, 0.5, 0.0, 0.0]);
    let smoke = exr(&[("R", 3.0), ("G", 0.5), ("B", 0.0), ("A", 0.5)], Some(REC_709));
    assert_eq!(floats(&smoke), [6.0, 1.0, 0.0, 0.5]);
}

#[test]
fn luminance_and_chroma_are_read_as_colours() {
    let (r, g, b) = (0.8f32, 0.4, 0.1);
    let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let chroma = exr(&[("Y", y), ("RY", (r - y) / y), ("BY", (b - y) / y)], None);
    assert!(near(&floats(&chroma), &[r, g, b]));
}
