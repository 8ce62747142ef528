//! Images without what is told beside the picture: where and when a photograph was taken, with which
//! camera, by whom, thumbnails, and whatever follows the end, such as the film of a phone's "live" photograph.
//!
//! The picture is not encoded anew. What remains is listed, so that metadata of tomorrow goes too.

use std::io::Cursor;

use super::orientation::Orientation;
use super::{Format, stored_header_of};

/// A file, such as a PNG, JPEG or WebP file, with nothing but its picture: texels, colour space, animation and, as the one
/// tag of an EXIF block, which side is up.
///
/// `None` for other formats, and for files whose parts don't follow each other as they must.
pub fn without_metadata(bytes: &[u8]) -> Option<Vec<u8>> {
    let strip = Format::detect(bytes)?.codec().without_metadata?;
    // What browsers can show though this program can't is taken to be upright.
    let orientation = stored_header_of(Format::ALL, &mut Cursor::new(bytes))
        .map_or_else(|_| Orientation::default(), |(_, stored)| stored.orientation);
    let exif = orientation.exif();
    strip(bytes, exif.as_deref())
}

#[cfg(test)]
mod tests {
    use uvgraft::color::Encoding;
    use uvgraft::texture::{Channels, Size, Texels, Texture};

    use super::*;
    use crate::{Image, WriteOptions, decode, encode};

    const SECRET: &[u8] = b"Canon 0815, 48.137 N 11.575 E, Anna";

    fn picture(format: Format) -> Vec<u8> {
        let texels = (0..48u32 * 16 * 3).map(|value| (value * 5) as u8).collect();
        let texture =
            Texture::new(Size::new(48, 16), Channels::Rgb, Encoding::Srgb, Texels::U8(texels))
                .unwrap();
        let mut bytes = Cursor::new(Vec::new());
        let image = Image { texture, icc: Some(b"a profile".to_vec()) };
        let _ = encode(&image, format, &WriteOptions::default(), &mut bytes).unwrap();
        bytes.into_inner()
    }

    /// A block with the orientation 6, a quarter turn, and a secret behind it.
    fn exif() -> Vec<u8> {
        let mut exif = Orientation::from_tag(6).exif().unwrap();
        exif.extend(SECRET);
        exif
    }

    fn segment(marker: u8, content: &[u8]) -> Vec<u8> {
        [&[0xff, marker][..], &(content.len() as u16 + 2).to_be_bytes(), content].concat()
    }

    fn png_chunk(kind: &[u8; 4], content: &[u8]) -> Vec<u8> {
        let body = [kind, content].concat();
        let length = (content.len() as u32).to_be_bytes();
        [&length[..], &body, &crc32fast::hash(&body).to_be_bytes()].concat()
    }

    fn webp_chunk(kind: &[u8; 4], content: &[u8]) -> Vec<u8> {
        let padding = &[0][..content.len() % 2];
        [&kind[..], &(content.len() as u32).to_le_bytes(), content, padding].concat()
    }

    /// Files in which every place that takes metadata has some.
    fn talkative() -> [(Format, Vec<u8>); 3] {
        let jpeg = picture(Format::JPEG);
        let of = |marker, start: &[u8]| segment(marker, &[start, SECRET].concat());
        let mut jpeg = [
            &jpeg[..2],
            &of(0xe1, &[b"Exif\0\0", &exif()[..]].concat()),
            &of(0xe1, b"http://ns.adobe.com/xap/1.0/\0"),
            &of(0xe2, b"MPF\0"),
            &of(0xed, b"Photoshop 3.0\0"),
            &of(0xfe, b""),
            &of(0xe0, b"JFXX\0"),
            &jpeg[2..],
        ]
        .concat();
        // Between scans, a comment is as good as anywhere.
        let end = jpeg.len() - 2;
        jpeg.splice(end..end, of(0xfe, b""));
        jpeg.extend(SECRET);

        let png = picture(Format::PNG);
        let header = 8 + 25;
        let png = [
            &png[..header],
            &png_chunk(b"eXIf", &exif()),
            &png_chunk(b"tEXt", &[b"Author\0", SECRET].concat()),
            &png_chunk(b"tIME", &[7; 7]),
            &png_chunk(b"prIv", SECRET),
            &png[header..png.len() - 12],
            &png_chunk(b"iTXt", &[b"XML:com.adobe.xmp\0\0\0\0\0", SECRET].concat()),
            &png[png.len() - 12..],
            SECRET,
        ]
        .concat();

        let webp = picture(Format::WEBP);
        let chunks = [
            b"WEBP",
            &webp[12..],
            &webp_chunk(b"EXIF", &exif()),
            &webp_chunk(b"XMP ", SECRET),
            &webp_chunk(b"MINE", SECRET),
        ]
        .concat();
        let mut webp = webp_chunk(b"RIFF", &chunks);
        // The flags of the extended header: EXIF and XMP exist.
        assert_eq!(&webp[12..16], b"VP8X");
        webp[20] |= 0b1100;
        webp.extend(SECRET);
        [(Format::JPEG, jpeg), (Format::PNG, png), (Format::WEBP, webp)]
    }

    fn tells(bytes: &[u8]) -> bool {
        // What is compressed is found by its keyword.
        bytes.windows(4).any(|window| window == &SECRET[..4] || window == b"http")
    }

    #[test]
    fn nothing_is_told_and_the_picture_is_the_same() {
        for (format, bytes) in talkative() {
            assert!(tells(&bytes), "{format}");
            let stripped = without_metadata(&bytes).unwrap();
            assert!(!tells(&stripped), "{format}");
            let [before, after] = [&bytes, &stripped].map(|bytes| decode(bytes).unwrap());
            assert_eq!(before, after, "{format}");
            assert_eq!(after.size(), Size::new(16, 48), "{format}");
            assert_eq!(without_metadata(&stripped).unwrap(), stripped, "{format}");
            // Nothing to leave out, nothing changed.
            let plain = picture(format);
            assert_eq!(without_metadata(&plain).unwrap(), plain, "{format}");
        }
    }

    #[test]
    fn files_that_end_early_are_refused_and_none_panics() {
        for (format, bytes) in talkative() {
            let whole = without_metadata(&bytes).unwrap();
            for cut in 0..whole.len() {
                assert_eq!(without_metadata(&whole[..cut]), None, "{format}, {cut} bytes");
            }
            for at in 0..bytes.len() {
                let mut changed = bytes.clone();
                changed[at] ^= 0x55;
                let _ = without_metadata(&changed);
            }
        }
        for other in [&b""[..], b"II*\0\x08\0\0\0", b"no image"] {
            assert_eq!(without_metadata(other), None);
        }
    }
}
