//! Images read and written in bands of rows equal those processed as a whole.

#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

use std::io::Cursor;
use std::path::Path;

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Depth, Size, Texels, Texture};
use uvgraft_image::{
    BandDecoder, BandEncoder, BandReader, BandWriter, EncodeError, Format, Image, Segments,
    TextureSpec, WriteOptions, decode, encode, read,
};

const CHANNELS: [Channels; 4] =
    [Channels::Grey, Channels::GreyAlpha, Channels::Rgb, Channels::Rgba];
const DEPTHS: [Depth; 3] = [Depth::U8, Depth::U16, Depth::F32];
const BANDS: [u32; 4] = [1, 3, 7, 1000];

/// Noise, flat areas and gradients.
fn texture(size: Size, channels: Channels, depth: Depth, encoding: Encoding) -> Texture {
    let mut random = fastrand::Rng::with_seed(u64::from(size.width) << 32 | u64::from(size.height));
    let unit: Vec<f32> = (0..size.texels() * channels.count())
        .map(|index| match index / 500 % 3 {
            0 => random.f32() * 1.2 - 0.1,
            1 => 0.25,
            _ => index as f32 % 300.0 / 300.0,
        })
        .collect();
    let texels = match depth {
        Depth::U8 => Texels::U8(unit.iter().map(|unit| (unit * 255.0) as u8).collect()),
        Depth::U16 => Texels::U16(unit.iter().map(|unit| (unit * 65_535.0) as u16).collect()),
        Depth::F32 => Texels::F32(unit),
    };
    Texture::new(size, channels, encoding, texels).unwrap()
}

fn rows(texture: &Texture, from: u32, count: u32) -> Texture {
    let values = texture.size().width as usize * texture.channels().count();
    let range = from as usize * values..(from + count) as usize * values;
    let texels = match texture.texels() {
        Texels::U8(all) => Texels::U8(all[range].to_vec()),
        Texels::U16(all) => Texels::U16(all[range].to_vec()),
        Texels::F32(all) => Texels::F32(all[range].to_vec()),
    };
    let size = Size::new(texture.size().width, count);
    Texture::new(size, texture.channels(), texture.encoding(), texels).unwrap()
}

fn encode_in_bands(image: &Image, format: Format, options: &WriteOptions, band: u32) -> Encoded {
    let spec = TextureSpec::from(&image.texture);
    let out = Cursor::new(Vec::new());
    let mut encoder = BandEncoder::new(out, format, spec, image.icc.as_deref(), options)?;
    for from in (0..spec.size.height).step_by(band as usize) {
        encoder.push(&rows(&image.texture, from, band.min(spec.size.height - from)))?;
    }
    let (written, out) = encoder.finish()?;
    Ok((out.into_inner(), written.losses))
}

type Encoded = Result<(Vec<u8>, Vec<uvgraft_image::Loss>), EncodeError>;

fn encode_whole(image: &Image, format: Format, options: &WriteOptions) -> Encoded {
    let mut out = Cursor::new(Vec::new());
    let written = encode(image, format, options, &mut out)?;
    Ok((out.into_inner(), written.losses))
}

/// Reads all bands, recycling each, and compares them with the whole image.
fn check_bands(name: &str, bytes: &[u8], whole: &Image) {
    for band in BANDS {
        let mut decoder = BandDecoder::new(bytes).unwrap();
        assert_eq!(decoder.spec(), TextureSpec::from(&whole.texture), "{name}");
        assert_eq!(decoder.icc(), whole.icc.as_deref(), "{name}");
        let height = whole.texture.size().height;
        for from in (0..height).step_by(band as usize) {
            assert_eq!(decoder.next_row(), from);
            let found = decoder.next_band(band).unwrap().unwrap();
            let wanted = rows(&whole.texture, from, band.min(height - from));
            assert!(found == wanted, "{name}: rows from {from}, {band} at once");
            decoder.recycle(found);
        }
        assert_eq!(decoder.next_band(band).unwrap(), None, "{name}");
        let mut decoder = BandDecoder::new(bytes).unwrap();
        decoder.skip(band).unwrap();
        match decoder.next_band(2).unwrap() {
            Some(found) => {
                assert!(found == rows(&whole.texture, band, found.size().height), "{name}");
            }
            None => assert!(band >= height, "{name}"),
        }
    }
}

#[test]
fn bands_of_any_size_make_the_same_file() {
    for size in [Size::new(67, 35), Size::new(1, 1), Size::new(300, 1), Size::new(1, 300)] {
        for &format in Format::ALL {
            for (channels, depth) in CHANNELS.iter().flat_map(|c| DEPTHS.map(|d| (*c, d))) {
                for encoding in [Encoding::Srgb, Encoding::Linear, Encoding::Data] {
                    let texture = texture(size, channels, depth, encoding);
                    let image = Image { texture, icc: Some(vec![42; 3000]) };
                    for compress in [false, true] {
                        let options = WriteOptions::default().compress(compress);
                        let Ok((bytes, losses)) = encode_whole(&image, format, &options) else {
                            assert!(encode_in_bands(&image, format, &options, 7).is_err());
                            continue;
                        };
                        let name = format!("{format} {channels:?} {depth:?} {encoding:?} {size}");
                        for band in BANDS {
                            let found = encode_in_bands(&image, format, &options, band).unwrap();
                            assert_eq!(found.1, losses, "{name}");
                            assert!(found.0 == bytes, "{name}: {band} rows at once");
                        }
                        check_bands(&name, &bytes, &decode(&bytes).unwrap());
                    }
                }
            }
        }
    }
}

/// Segments that were encoded on their own, in any order, mixed with rows.
#[test]
fn segments_make_the_same_file() {
    let mut random = fastrand::Rng::with_seed(8);
    for size in [Size::new(30_011, 41), Size::new(1, 1), Size::new(32_768, 5), Size::new(65, 5)] {
        for (channels, depth) in CHANNELS.iter().flat_map(|c| DEPTHS.map(|d| (*c, d))) {
            for encoding in [Encoding::Srgb, Encoding::Linear] {
                let texture = texture(size, channels, depth, encoding);
                let image = Image { texture, icc: Some(vec![42; 3000]) };
                let spec = TextureSpec::from(&image.texture);
                let options = WriteOptions::default();
                for &format in Format::ALL {
                    let Some(segments) = Segments::new(format, spec, &options) else { continue };
                    let name = format!("{format} {channels:?} {depth:?} {encoding:?} {size}");
                    let wanted = encode_whole(&image, format, &options).unwrap();
                    let of = |index: u32| {
                        let from = index * segments.rows();
                        rows(&image.texture, from, segments.rows().min(size.height - from))
                    };
                    let count = size.height.div_ceil(segments.rows());
                    let mut encoded: Vec<_> = (0..count)
                        .rev()
                        .map(|index| segments.encode(index, &of(index)).unwrap())
                        .collect();
                    encoded.reverse();
                    for _ in 0..3 {
                        let out = Cursor::new(Vec::new());
                        let mut encoder =
                            BandEncoder::new(out, format, spec, image.icc.as_deref(), &options)
                                .unwrap();
                        assert_eq!(encoder.segments(), Some(segments));
                        for index in 0..count {
                            if random.bool() {
                                encoder.push_segment(&encoded[index as usize]).unwrap();
                            } else {
                                let all = of(index);
                                let cut = random.u32(1..=all.size().height);
                                encoder.push(&rows(&all, 0, cut)).unwrap();
                                if cut < all.size().height {
                                    encoder
                                        .push(&rows(&all, cut, all.size().height - cut))
                                        .unwrap();
                                }
                            }
                        }
                        let (written, out) = encoder.finish().unwrap();
                        assert_eq!(written.losses, wanted.1, "{name}");
                        assert!(out.into_inner() == wanted.0, "{name}");
                    }
                }
            }
        }
    }
}

#[test]
fn segments_of_elsewhere_are_refused() {
    let whole = texture(Size::new(32_768, 7), Channels::Rgba, Depth::U16, Encoding::Srgb);
    let spec = TextureSpec::from(&whole);
    let options = WriteOptions::default();
    let segments = Segments::new(Format::PNG, spec, &options).unwrap();
    assert_eq!(segments.rows(), 2);
    let begin = |spec, options: &WriteOptions| {
        BandEncoder::new(Cursor::new(Vec::new()), Format::PNG, spec, None, options).unwrap()
    };
    let second = segments.encode(1, &rows(&whole, 2, 2)).unwrap();
    let mut encoder = begin(spec, &options);
    let error = encoder.push_segment(&second).unwrap_err();
    assert!(matches!(error, EncodeError::Segment { found: 2, wanted: 0 }), "{error}");
    encoder.push(&rows(&whole, 0, 2)).unwrap();
    encoder.push_segment(&second).unwrap();
    assert!(encoder.push_segment(&second).is_err());
    // Of an image with another encoding, and of one that has no segments.
    let other = TextureSpec { encoding: Encoding::Data, ..spec };
    let first = segments.encode(0, &rows(&whole, 0, 2)).unwrap();
    assert!(begin(other, &options).push_segment(&first).is_err());
    assert!(begin(spec, &options.compress(true)).push_segment(&first).is_err());
    // Rows that are not those of a segment.
    for (index, rows) in
        [(4, rows(&whole, 6, 1)), (u32::MAX, rows(&whole, 3, 1)), (0, rows(&whole, 0, 1))]
    {
        assert!(matches!(segments.encode(index, &rows), Err(EncodeError::Band { .. })));
    }
    let wrong = rows(&whole, 0, 2).with_encoding(Encoding::Data);
    assert!(segments.encode(0, &wrong).is_err());
}

#[test]
fn files_of_others_come_in_bands_too() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/samples");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let bytes = std::fs::read(&path).unwrap();
        let name = path.display().to_string();
        match read(&path) {
            Ok(whole) => {
                check_bands(&name, &bytes, &whole);
                let mut reader = BandReader::open(&path).unwrap();
                assert_eq!(reader.spec(), TextureSpec::from(&whole.texture));
                let band = reader.next_band(u32::MAX).unwrap().unwrap();
                assert!(band == whole.texture, "{name}");
            }
            Err(error) => {
                let found = BandReader::open(&path).and_then(|mut reader| reader.next_band(9999));
                assert_eq!(found.unwrap_err().to_string(), error.to_string());
            }
        }
    }
}

#[test]
fn rows_that_do_not_belong_are_refused() {
    let whole = texture(Size::new(8, 6), Channels::Rgb, Depth::U8, Encoding::Srgb);
    let spec = TextureSpec::from(&whole);
    for &format in Format::ALL {
        let begin = || {
            let out = Cursor::new(Vec::new());
            BandEncoder::new(out, format, spec, None, &WriteOptions::default()).unwrap()
        };
        for other in [
            texture(Size::new(9, 1), Channels::Rgb, Depth::U8, Encoding::Srgb),
            texture(Size::new(8, 1), Channels::Grey, Depth::U8, Encoding::Srgb),
            texture(Size::new(8, 1), Channels::Rgb, Depth::U16, Encoding::Srgb),
            texture(Size::new(8, 1), Channels::Rgb, Depth::U8, Encoding::Data),
        ] {
            assert!(matches!(begin().push(&other), Err(EncodeError::Band { .. })), "{format}");
        }
        let mut encoder = begin();
        encoder.push(&rows(&whole, 0, 5)).unwrap();
        let error = encoder.push(&rows(&whole, 0, 2)).unwrap_err();
        assert!(matches!(error, EncodeError::Rows { found: 7, wanted: 6 }), "{format}");
        let error = encoder.finish().map(|_| ()).unwrap_err();
        assert!(matches!(error, EncodeError::Rows { found: 5, wanted: 6 }), "{format}");
    }
}

#[test]
fn a_file_appears_when_it_is_finished() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.png", "a.tif"] {
        let path = folder.path().join(name);
        let whole = texture(Size::new(8, 6), Channels::Rgb, Depth::U8, Encoding::Srgb);
        let spec = TextureSpec::from(&whole);
        let mut writer = BandWriter::create(&path, spec, None, &WriteOptions::default()).unwrap();
        writer.push(&rows(&whole, 0, 5)).unwrap();
        assert!(!path.exists());
        let error = writer.finish().unwrap_err();
        let wanted = format!(
            "cannot write {}: an image of 6 rows must be written in full, got 5",
            path.display()
        );
        assert_eq!(error.to_string(), wanted);
        assert!(!path.exists());
        let mut writer = BandWriter::create(&path, spec, None, &WriteOptions::default()).unwrap();
        writer.push(&whole).unwrap();
        let _ = writer.finish().unwrap();
        assert!(read(&path).unwrap().texture == whole);
        std::fs::remove_file(path).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

/// Large enough for several pieces compressed at the same time, and with bands that straddle their
/// boundaries.
#[test]
fn threads_and_bands_do_not_show() {
    for (channels, depth) in [(Channels::Rgb, Depth::U8), (Channels::Rgba, Depth::U16)] {
        let texture = texture(Size::new(1501, 700), channels, depth, Encoding::Srgb);
        let image = Image::from(texture);
        let options = WriteOptions::default();
        let wanted = encode_whole(&image, Format::PNG, &options).unwrap().0;
        assert!(decode(&wanted).unwrap() == image);
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            for band in [1, 97, 350, 700] {
                let encode = || encode_in_bands(&image, Format::PNG, &options, band).unwrap().0;
                assert!(pool.install(encode) == wanted, "{threads} threads, {band} rows at once");
            }
        }
    }
}

/// Sizes around multiples of eight bytes, of the sampling step and of pieces.
#[test]
fn every_width_comes_back() {
    for width in (1..40).chain([341, 683, 2047, 2048, 2049, 32_768]) {
        for (channels, depth) in CHANNELS.iter().flat_map(|c| [(*c, Depth::U8), (*c, Depth::U16)]) {
            let texture = texture(Size::new(width, 5), channels, depth, Encoding::Srgb);
            let image = Image::from(texture);
            let bytes = encode_whole(&image, Format::PNG, &WriteOptions::default()).unwrap().0;
            assert!(decode(&bytes).unwrap() == image, "{width} {channels:?} {depth:?}");
        }
    }
}

#[test]
fn a_cut_is_found_out_before_any_row() {
    let image = Image::from(texture(Size::new(31, 50), Channels::Rgb, Depth::U8, Encoding::Srgb));
    let bytes = encode_whole(&image, Format::PNG, &WriteOptions::default()).unwrap().0;
    for cut in 0..bytes.len() {
        assert!(BandDecoder::new(&bytes[..cut]).is_err(), "{cut} of {}", bytes.len());
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.png");
    std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    let error = BandReader::open(&path).err().unwrap().to_string();
    assert!(error.contains("cut.png: truncated PNG"), "{error}");
}

/// Reading a damaged file in bands gives the same errors as reading it as a whole.
#[test]
fn damage_is_found_out_by_the_last_row() {
    let mut random = fastrand::Rng::with_seed(8);
    let mut seeds = Vec::new();
    for (channels, depth) in [(Channels::Rgb, Depth::U8), (Channels::GreyAlpha, Depth::U16)] {
        for compress in [false, true] {
            let image = Image::from(texture(Size::new(40, 30), channels, depth, Encoding::Srgb));
            let options = WriteOptions::default().compress(compress);
            seeds.push(encode_whole(&image, Format::PNG, &options).unwrap().0);
        }
    }
    for name in ["interlaced16.png", "palette.png", "oriented.png"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/samples").join(name);
        seeds.push(std::fs::read(path).unwrap());
    }
    let mut refused = 0;
    for round in 0..2000 {
        let mut bytes = random.choice(&seeds).unwrap().clone();
        for _ in 0..random.usize(1..4) {
            let at = random.usize(..bytes.len());
            bytes[at] ^= 1 << random.u8(..8);
        }
        let in_bands = || {
            let mut decoder = BandDecoder::new(&bytes)?;
            let height = decoder.header().size.height;
            let mut found = Vec::new();
            while let Some(band) = decoder.next_band(random_rows(round))? {
                found.push(band);
            }
            assert_eq!(found.iter().map(|band| band.size().height).sum::<u32>(), height);
            Ok::<_, uvgraft_image::ImageError>(found)
        };
        match (decode(&bytes), in_bands()) {
            (Ok(whole), Ok(bands)) => {
                let mut from = 0;
                for band in bands {
                    assert!(band == rows(&whole.texture, from, band.size().height));
                    from += band.size().height;
                }
            }
            (Err(_), Err(_)) => refused += 1,
            (whole, bands) => panic!("whole: {:?}, bands: {:?}", whole.err(), bands.err()),
        }
    }
    assert!(refused > 1500, "only {refused} were refused");
}

fn random_rows(round: u32) -> u32 {
    [1, 4, 7, 100][round as usize % 4]
}
