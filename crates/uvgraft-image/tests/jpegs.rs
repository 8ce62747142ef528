//! JPEGs that are out of the ordinary, but shown by all viewers; and those that nobody should guess at.

#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

use std::io::Cursor;
use std::path::Path;

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Size, Texels, Texture};
use uvgraft_image::{Format, Image, ImageError, WriteOptions, decode, decode_header, encode};

/// A JPEG of our own: start of image, JFIF, and so on.
fn jpeg() -> Vec<u8> {
    let size = Size::new(20, 12);
    let values = (0..size.texels() * 3).map(|index| (index / 3 % 20 * 12) as u8).collect();
    let texture = Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values)).unwrap();
    let image = Image { texture, icc: Some(vec![5; 30]) };
    let mut out = Cursor::new(Vec::new());
    let _ = encode(&image, Format::JPEG, &WriteOptions::default(), &mut out).unwrap();
    out.into_inner()
}

fn segment(marker: u8, content: &[u8]) -> Vec<u8> {
    [&[0xff, marker][..], &(content.len() as u16 + 2).to_be_bytes(), content].concat()
}

/// With bytes before the frame header.
fn with(inserted: &[u8]) -> Vec<u8> {
    let plain = jpeg();
    let (start, rest) = plain.split_at(frame(&plain));
    [start, inserted, rest].concat()
}

/// Where a frame header's marker is.
fn frame(bytes: &[u8]) -> usize {
    bytes.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap()
}

#[test]
fn clutter_is_skipped() {
    let plain = decode(&jpeg()).unwrap();
    let cyclic = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x69\x87\x04\0\x01\0\0\0\x08\0\0\0\x08\0\0\0";
    for (what, inserted) in [
        ("stray bytes", b"stray bytes between segments".to_vec()),
        ("zeros", vec![0; 100]),
        ("short Adobe segment", segment(0xee, b"Adobe")),
        ("shorter Adobe segment", segment(0xee, b"")),
        ("Adobe segment without a transform", segment(0xee, b"Adobe\0\x64\0\0\0\0")),
        ("EXIF without content", segment(0xe1, b"Exif\0\0")),
        ("EXIF that is cut", segment(0xe1, b"Exif\0\0II*\0\x08\0\0\0\xff\xff")),
        ("cyclic EXIF", segment(0xe1, cyclic)),
        ("empty segments", [0xe0, 0xe1, 0xe2, 0xed, 0xee, 0xfe].map(|m| segment(m, b"")).concat()),
        ("wrong profile segment", segment(0xe2, b"ICC_PROFILE\0")),
        ("short JFIF segment", segment(0xe0, b"JFIF\0")),
        ("multi-picture index", segment(0xe2, b"MPF\0II*\0\x08\0\0\0\xff\xff")),
        ("fill bytes", vec![0xff; 9]),
    ] {
        let image = decode(&with(&inserted)).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(image.texture, plain.texture, "{what}");
    }
    // A second image after the first, and anything else.
    assert_eq!(decode(&[jpeg(), jpeg(), vec![3; 100]].concat()).unwrap(), plain);
}

#[test]
fn a_cut_scan_is_refused_in_spite_of_clutter() {
    let bytes = with(b"stray bytes between segments");
    for cut in [bytes.len() / 2, bytes.len() - 20, bytes.len() - 2] {
        assert!(decode(&bytes[..cut]).is_err());
        // With a forged end: the scan lacks blocks.
        let forged = [&bytes[..cut - 100], &[0xff, 0xd9]].concat();
        assert!(decode(&forged).is_err(), "{cut}");
    }
}

#[test]
fn narrow_images_are_read_as_by_libjpeg() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/samples/narrow.jpg");
    let Texels::U8(found) = decode(&std::fs::read(path).unwrap()).unwrap().texture.into_texels()
    else {
        unreachable!("JPEGs have 8 bits")
    };
    #[rustfmt::skip]
    let wanted = [
        218, 58, 24, 222, 62, 28, 21, 69, 213, 26, 74, 218,
        218, 58, 24, 222, 62, 28, 21, 69, 213, 25, 73, 217,
        223, 92, 12, 227, 96, 16, 24, 102, 200, 28, 106, 204,
        223, 92, 12, 226, 95, 15, 23, 101, 199, 26, 104, 202,
        232, 121, 5, 235, 124, 8, 32, 131, 190, 34, 133, 192u8,
    ];
    assert_eq!(found.len(), wanted.len());
    let differences = found.iter().zip(wanted).map(|(found, wanted)| found.abs_diff(wanted));
    assert!(differences.max() <= Some(4), "{found:?}");
}

#[test]
fn what_cannot_be_read_is_named() {
    let refused = |at: usize, value: &[u8]| {
        let mut bytes = jpeg();
        let start = frame(&bytes) + at;
        bytes[start..start + value.len()].copy_from_slice(value);
        let of_header = decode_header(&bytes).unwrap_err().to_string();
        let error = decode(&bytes).unwrap_err();
        assert!(matches!(error, ImageError::Unsupported { .. }), "{error}");
        assert_eq!(error.to_string(), of_header);
        of_header
    };
    for (marker, name) in [
        (0xc3, "lossless coding"),
        (0xc5, "hierarchical coding"),
        (0xc9, "arithmetic coding"),
        (0xca, "arithmetic coding"),
        (0xcb, "lossless arithmetic coding"),
    ] {
        assert!(refused(1, &[marker]).contains(name));
    }
    assert!(refused(4, &[12]).contains("12 bits"));
    assert!(refused(5, &[0, 0]).contains("DNL"));
    assert!(refused(9, &[4]).contains("CMYK"));
}

#[test]
fn jfif_counts_more_than_other_signs_of_rgb() {
    let plain = jpeg();
    let wanted = decode(&plain).unwrap();
    let jfif = segment(0xe0, b"JFIF\0\x01\x01\0\0\x01\0\x01\0\0");
    let adobe = segment(0xee, b"Adobe\0\x64\0\0\0\0\0");
    let named = |bytes: &[u8]| {
        let mut bytes = bytes.to_vec();
        let frame = frame(&bytes);
        let scan = bytes.windows(2).rposition(|pair| pair == [0xff, 0xda]).unwrap();
        for (index, id) in b"RGB".iter().enumerate() {
            bytes[frame + 10 + 3 * index] = *id;
            bytes[scan + 5 + 2 * index] = *id;
        }
        bytes
    };
    // Without the segment that comes first, which is JFIF's.
    assert_eq!(plain[2..4], [0xff, 0xe0]);
    let first = 4 + usize::from(u16::from_be_bytes([plain[4], plain[5]]));
    let bare = [&plain[..2], &plain[first..]].concat();
    let begun = |segments: &[u8], rest: &[u8]| [&bare[..2], segments, &rest[2..]].concat();
    for (signs, is_rgb) in [
        (begun(&jfif, &bare), false),
        (begun(&[&jfif[..], &adobe].concat(), &bare), false),
        (begun(&jfif, &named(&bare)), false),
        (begun(&adobe, &bare), true),
        (named(&bare), true),
        (bare.clone(), false),
    ] {
        let found = decode(&signs).unwrap();
        let (Texels::U8(found), Texels::U8(wanted)) =
            (found.texture.texels(), wanted.texture.texels())
        else {
            unreachable!("JPEGs have 8 bits")
        };
        let difference = found.iter().zip(wanted).map(|(a, b)| a.abs_diff(*b)).max();
        assert_eq!(difference > Some(3), is_rgb);
    }
}
