//! Text chunks that hold metadata: XMP, and the EXIF blocks that ImageMagick wrote before there was
//! eXIf.

use std::io::Read;

use flate2::read::ZlibDecoder;

use crate::{exif, xmp};

/// Text beyond this is not read: XMP has kilobytes, and a chunk may inflate to gigabytes.
pub(super) const MAX_BYTES: u64 = 1 << 20;

const XMP: &[u8] = b"XML:com.adobe.xmp";
const RAW_EXIF: [&[u8]; 2] = [b"Raw profile type exif", b"Raw profile type APP1"];

/// The orientation in a text chunk, as of the TIFF tag. Malformed chunks are ignored, as malformed
/// EXIF blocks are.
///
/// - `kind`: `tEXt`, `zTXt` or `iTXt`.
/// - `content`: the chunk's, at most [`MAX_BYTES`] of it.
pub(super) fn orientation(kind: [u8; 4], content: &[u8]) -> Option<u64> {
    let (keyword, rest) = split_at_nul(content)?;
    if keyword != XMP && !RAW_EXIF.contains(&keyword) {
        return None;
    }
    let text = text(kind, rest)?;
    if keyword == XMP { xmp::orientation(&text) } else { exif::orientation(&raw_profile(&text)?) }
}

/// The text after the keyword.
fn text(kind: [u8; 4], rest: &[u8]) -> Option<Vec<u8>> {
    match (&kind, rest) {
        (b"tEXt", text) => Some(text.to_vec()),
        (b"zTXt", [0, packed @ ..]) => Some(inflated(packed)),
        (b"iTXt", [is_packed, 0, rest @ ..]) => {
            let (_language, rest) = split_at_nul(rest)?;
            let (_translated, text) = split_at_nul(rest)?;
            Some(if *is_packed == 1 { inflated(text) } else { text.to_vec() })
        }
        _ => None,
    }
}

/// As much as is sound, up to the limit.
fn inflated(packed: &[u8]) -> Vec<u8> {
    let mut text = Vec::new();
    // What precedes damage may hold the orientation.
    let _ = ZlibDecoder::new(packed).take(MAX_BYTES).read_to_end(&mut text);
    text
}

/// The bytes of `\nexif\n      38\n4578…`: name, length and hexadecimal digits.
fn raw_profile(text: &[u8]) -> Option<Vec<u8>> {
    let mut lines = text.trim_ascii_start().splitn(3, |&byte| byte == b'\n');
    let (_name, _length, digits) = (lines.next()?, lines.next()?, lines.next()?);
    let digits: Option<Vec<u8>> = digits
        .iter()
        .filter(|digit| !digit.is_ascii_whitespace())
        .map(|&digit| char::from(digit).to_digit(16).map(|digit| digit as u8))
        .collect();
    Some(digits?.as_chunks().0.iter().map(|[high, low]| high << 4 | low).collect())
}

fn split_at_nul(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let at = bytes.iter().position(|&byte| byte == 0)?;
    Some((&bytes[..at], &bytes[at + 1..]))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::ZlibEncoder;

    use super::*;

    const PACKET: &[u8] = br#"<x:xmpmeta><rdf:Description tiff:Orientation="6"/></x:xmpmeta>"#;
    /// Big-endian, one entry: orientation 6.
    const RAW: &[u8] = b"\nexif\n      32\n457869660000\n4d4d002a00000008\
        0001011200030000000100060000\n00000000\n";

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn every_kind_of_text_is_read() {
        let international = |flag: u8, text: &[u8]| {
            orientation(*b"iTXt", &[XMP, &[0, flag, 0], b"en\0XMP\0", text].concat())
        };
        assert_eq!(international(0, PACKET), Some(6));
        assert_eq!(international(1, &packed(PACKET)), Some(6));
        let keyword = [RAW_EXIF[0], &[0]].concat();
        assert_eq!(orientation(*b"tEXt", &[&keyword, RAW].concat()), Some(6));
        assert_eq!(orientation(*b"zTXt", &[&keyword, &[0][..], &packed(RAW)].concat()), Some(6));
    }

    #[test]
    fn other_texts_say_nothing() {
        assert_eq!(orientation(*b"tEXt", &[b"Comment\0", PACKET].concat()), None);
        assert_eq!(orientation(*b"iTXt", XMP), None);
        assert_eq!(orientation(*b"iTXt", &[XMP, &[0, 0, 0]].concat()), None);
        assert_eq!(orientation(*b"tEXt", &[RAW_EXIF[0], b"\0\nexif\n 2\nzz"].concat()), None);
    }

    #[test]
    fn bombs_inflate_to_the_limit_only() {
        let bomb = packed(&vec![b' '; 50 << 20]);
        assert_eq!(inflated(&bomb).len() as u64, MAX_BYTES);
    }
}
