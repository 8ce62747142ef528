//! EXIF data of photos: the focal length is read, and none of it is written.

#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

use std::io::Cursor;

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Depth, Size, Texels, Texture};
use uvgraft_files::input::Input;
use uvgraft_image::{
    BandEncoder, BandReader, Format, Image, OpenImage, TextureSpec, WriteOptions, decode,
    decode_focal_length_px, decode_header, encode, open, read, write,
};

/// What stands in the metadata and in file names, and nowhere else.
const MARKS: [&str; 8] = [
    "SECRET-CAMERA",
    "SECRET-XMP",
    "SECRET-COMMENT",
    "SECRET-IPTC",
    "SECRET-NAME",
    "Exif\0\0",
    "ns.adobe.com",
    "GPS-PROCESSING-SECRET",
];

/// 52°30'15.77" in EXIF's rationals.
const LATITUDE: [u32; 6] = [52, 1, 30, 1, 1577, 100];

fn photo(channels: Channels) -> Image {
    let size = Size::new(40, 30);
    let values = (0..size.texels() * channels.count()).map(|index| (index / 7 % 200) as u8);
    let texels = Texels::U8(values.collect());
    Texture::new(size, channels, Encoding::Srgb, texels).unwrap().into()
}

fn encoded(image: &Image, format: Format) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let _ = encode(image, format, &WriteOptions::default(), &mut out).unwrap();
    out.into_inner()
}

/// A TIFF file of directories alone, in little-endian order, which is what an EXIF block is: model
/// of the camera, orientation, 35 mm equivalent of 26 mm, and a place.
fn exif_block() -> Vec<u8> {
    let entry = |tag: u16, kind: u16, count: u32, value: u32| {
        [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()]
            .concat()
    };
    let directory = |entries: &[Vec<u8>]| {
        [&(entries.len() as u16).to_le_bytes()[..], &entries.concat(), &[0; 4]].concat()
    };
    let (model, method) = (b"SECRET-CAMERA\0\0\0", b"ASCII\0\0\0GPS-PROCESSING-SECRET\0\0\0");
    // Directories of 4, 1 and 3 entries follow each other, and then their values.
    let exif = 8 + 2 + 4 * 12 + 4;
    let gps = exif + 2 + 12 + 4;
    let values = gps + 2 + 3 * 12 + 4;
    let latitude = values + model.len() as u32;
    [
        b"II*\0\x08\0\0\0".to_vec(),
        directory(&[
            entry(272, 2, 14, values),
            // Stored rotated by a quarter turn.
            entry(274, 3, 1, 6),
            entry(34_665, 4, 1, exif),
            entry(34_853, 4, 1, gps),
        ]),
        directory(&[entry(41_989, 3, 1, 26)]),
        directory(&[
            entry(1, 2, 2, u32::from(b'N')),
            entry(2, 5, 3, latitude),
            entry(27, 7, method.len() as u32, latitude + 24),
        ]),
        model.to_vec(),
        LATITUDE.map(u32::to_le_bytes).concat(),
        method.to_vec(),
    ]
    .concat()
}

/// A JPEG with every kind of metadata that cameras and editors write.
fn jpeg() -> Vec<u8> {
    let plain = encoded(&photo(Channels::Rgb), Format::JPEG);
    let segment = |marker: u8, content: &[u8]| {
        [&[0xff, marker][..], &(content.len() as u16 + 2).to_be_bytes(), content].concat()
    };
    let exif = [b"Exif\0\0", &exif_block()[..]].concat();
    let xmp = b"http://ns.adobe.com/xap/1.0/\0<x:xmpmeta>SECRET-XMP</x:xmpmeta>";
    let iptc = b"Photoshop 3.0\08BIM\x04\x04\0\0\0\0\0\x10\x1c\x02\x78\0\x0bSECRET-IPTC";
    [
        &plain[..2],
        &segment(0xe1, &exif),
        &segment(0xe1, xmp),
        &segment(0xed, iptc),
        &segment(0xfe, b"SECRET-COMMENT SECRET-NAME.jpg"),
        &plain[2..],
    ]
    .concat()
}

fn png_chunk(kind: &[u8; 4], content: &[u8]) -> Vec<u8> {
    let body = [kind, content].concat();
    let length = content.len() as u32;
    [&length.to_be_bytes()[..], &body, &crc32fast::hash(&body).to_be_bytes()].concat()
}

fn png() -> Vec<u8> {
    let plain = encoded(&photo(Channels::Rgb), Format::PNG);
    let header = 8 + 25;
    [
        &plain[..header],
        &png_chunk(b"eXIf", &exif_block()),
        &png_chunk(b"tEXt", b"Comment\0SECRET-COMMENT"),
        &png_chunk(b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0ns.adobe.com SECRET-XMP"),
        &plain[header..],
    ]
    .concat()
}

fn webp() -> Vec<u8> {
    let plain = encoded(&photo(Channels::Rgb), Format::WEBP);
    let chunk = |kind: &[u8; 4], content: &[u8]| {
        let padding = &[0][..content.len() % 2];
        [&kind[..], &(content.len() as u32).to_le_bytes(), content, padding].concat()
    };
    // Flags of EXIF and XMP, and the size minus 1.
    let extended = [0x0c, 0, 0, 0, 39, 0, 0, 29, 0, 0];
    let chunks = [
        chunk(b"VP8X", &extended),
        plain[12..].to_vec(),
        chunk(b"EXIF", &exif_block()),
        chunk(b"XMP ", b"ns.adobe.com SECRET-XMP"),
    ]
    .concat();
    [&b"RIFF"[..], &(chunks.len() as u32 + 4).to_le_bytes(), b"WEBP", &chunks].concat()
}

/// A TIFF of 40 × 30 grey texels with the directories of [`exif_block`].
fn tiff() -> Vec<u8> {
    let block = exif_block();
    // The first directory again, at the end, with the entries of an image in between.
    let at = |index: usize| &block[10 + index * 12..][..12];
    let texels = block.len() as u32;
    let short = |tag: u16, value: u16| [tag, 3, 1, 0, value, 0].map(u16::to_le_bytes).concat();
    let long = |tag: u16, value: u32| {
        [&[tag, 4, 1, 0].map(u16::to_le_bytes).concat()[..], &value.to_le_bytes()].concat()
    };
    let entries = [
        short(256, 40),
        short(257, 30),
        short(258, 8),
        short(259, 1),
        short(262, 1),
        at(0).to_vec(),
        long(273, texels),
        at(1).to_vec(),
        short(277, 1),
        short(278, 30),
        long(279, 1200),
        at(2).to_vec(),
        at(3).to_vec(),
    ];
    [
        b"II*\0",
        &(texels + 1200).to_le_bytes()[..],
        &block[8..],
        &[90; 1200],
        &(entries.len() as u16).to_le_bytes(),
        &entries.concat(),
        &[0; 4],
    ]
    .concat()
}

fn sources() -> [(Format, Vec<u8>); 4] {
    [(Format::JPEG, jpeg()), (Format::PNG, png()), (Format::WEBP, webp()), (Format::TIFF, tiff())]
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|window| window == part)
}

#[track_caller]
fn assert_clean(bytes: &[u8], of: &str) {
    for mark in MARKS {
        assert!(!contains(bytes, mark.as_bytes()), "{of} holds {mark:?}");
    }
    for order in [u32::to_le_bytes, u32::to_be_bytes] {
        assert!(!contains(bytes, &LATITUDE.map(order).concat()), "{of} holds the latitude");
    }
    for chunk in [b"eXIf", b"EXIF", b"XMP ", b"tEXt", b"iTXt", b"zTXt", b"tIME"] {
        assert!(!contains(bytes, chunk), "{of} holds a chunk {}", chunk.escape_ascii());
    }
    assert_eq!(decode_focal_length_px(bytes).unwrap(), None, "{of}");
}

#[test]
fn focal_lengths_of_every_format() {
    // 50 texels along the diagonal of 43.27 mm.
    let wanted = 26.0 * 50.0 / 43.266_615;
    let folder = tempfile::tempdir().unwrap();
    for (format, bytes) in sources() {
        let path = folder.path().join(format!("photo.{}", format.extensions()[0]));
        std::fs::write(&path, &bytes).unwrap();
        let image = decode(&bytes).unwrap();
        let from_bytes = open(Input::bytes("photo", bytes.clone())).unwrap();
        let from_file = open(&path).unwrap();
        for found in [
            decode_focal_length_px(&bytes).unwrap(),
            from_bytes.focal_length_px(),
            from_file.focal_length_px(),
        ] {
            let found = found.unwrap();
            assert!((found - wanted).abs() < 1e-6, "{format}: {found}");
        }
        // The orientation too: these images are turned upright.
        assert_eq!(image.size(), Size::new(30, 40), "{format}");
        assert_eq!(from_file.header(), decode_header(&bytes).unwrap());
        // Another file takes its place, and what was opened is read.
        std::fs::write(folder.path().join("other"), "other").unwrap();
        if cfg!(unix) {
            std::fs::rename(folder.path().join("other"), &path).unwrap();
        }
        for opened in [from_bytes, from_file] {
            assert_eq!(opened.decode().unwrap(), image, "{format}");
        }
    }
    let error = open(folder.path().join("none.jpg")).err().unwrap().to_string();
    assert!(error.contains("none.jpg"), "{error}");
    let cut = &sources()[0].1[..200];
    let error = open(Input::bytes("cut", cut)).and_then(OpenImage::decode).unwrap_err();
    assert!(error.to_string().starts_with("cut: "), "{error}");
    assert!(decode_focal_length_px(b"GIF89a").is_err());
    for &format in Format::ALL {
        let plain = encoded(&photo(Channels::Rgb), format);
        assert_eq!(decode_focal_length_px(&plain).unwrap(), None, "{format}");
    }
}

#[test]
fn damaged_directories_are_ignored() {
    for (format, bytes) in sources() {
        let start = bytes.windows(4).position(|window| window == b"II*\0").unwrap();
        let end = bytes.len().min(start + exif_block().len());
        for at in start + 8..end {
            for value in [0, 0x7f, 0xff] {
                let mut changed = bytes.clone();
                changed[at] = value;
                // An error or a number, but no panic.
                if let Ok(Some(found)) = decode_focal_length_px(&changed) {
                    assert!(found.is_finite() && found > 0.0, "{format}, byte {at}: {found}");
                }
            }
        }
    }
}

#[test]
fn nothing_of_a_photo_but_its_texels_is_written() {
    let folder = tempfile::tempdir().unwrap();
    for (from, bytes) in sources() {
        let is_marked = contains(&bytes, b"SECRET-CAMERA");
        assert!(is_marked, "the source of {from} must have metadata");
        let source = folder.path().join(format!("SECRET-NAME.{}", from.extensions()[0]));
        std::fs::write(&source, &bytes).unwrap();
        let image = read(&source).unwrap();
        for &to in Format::ALL {
            let of = format!("{to} of {from}");
            let target = folder.path().join(format!("out.{}", to.extensions()[0]));
            let _ = write(&image, &target, &WriteOptions::default()).unwrap();
            assert_clean(&std::fs::read(&target).unwrap(), &of);

            // In bands, as transfers do.
            let mut reader = BandReader::open(&source).unwrap();
            let texture = reader.next_band(100).unwrap().unwrap();
            let mut out = Cursor::new(Vec::new());
            let options = WriteOptions::default().compress(true);
            let spec = TextureSpec::from(&texture);
            let mut encoder = BandEncoder::new(&mut out, to, spec, None, &options).unwrap();
            encoder.push(&texture).unwrap();
            let _ = encoder.finish().unwrap();
            assert_clean(&out.into_inner(), &of);
        }
        assert_eq!(image.texture.depth(), Depth::U8);
    }
}

/// An XMP packet that says that the image is stored rotated by a quarter turn.
const ROTATED: &[u8] = br#"<rdf:Description tiff:Orientation="6"/>"#;

#[test]
fn orientation_is_read_from_xmp_too() {
    let photo = photo(Channels::Rgb);
    let png = encoded(&photo, Format::PNG);
    let international = png_chunk(b"iTXt", &[b"XML:com.adobe.xmp\0\0\0\0\0", ROTATED].concat());
    let (start, end) = png.split_at(png.len() - 12);
    let jpeg = encoded(&photo, Format::JPEG);
    let content = [b"http://ns.adobe.com/xap/1.0/\0", ROTATED].concat();
    let app1 = [&[0xff, 0xe1][..], &(content.len() as u16 + 2).to_be_bytes(), &content].concat();
    for bytes in [
        [&png[..33], &international, &png[33..]].concat(),
        [start, &international, end].concat(),
        [&jpeg[..2], &app1, &jpeg[2..]].concat(),
    ] {
        assert_eq!(decode_header(&bytes).unwrap().size, Size::new(30, 40));
        assert_eq!(decode(&bytes).unwrap().size(), Size::new(30, 40));
    }
}

#[test]
fn exif_counts_more_than_xmp() {
    let plain = encoded(&photo(Channels::Rgb), Format::PNG);
    let upright = ROTATED.to_vec().into_iter().map(|byte| if byte == b'6' { b'1' } else { byte });
    let upright: Vec<u8> = upright.collect();
    let text = png_chunk(b"iTXt", &[b"XML:com.adobe.xmp\0\0\0\0\0", &upright[..]].concat());
    let exif = png_chunk(b"eXIf", &exif_block());
    let bytes = [&plain[..33], &text, &exif, &plain[33..]].concat();
    assert_eq!(decode_header(&bytes).unwrap().size, Size::new(30, 40));
}
