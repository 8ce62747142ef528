//! A JPEG's picture alone.

use std::io::Cursor;

use super::cleaned::matters;
use super::{ALONE, APP0, APP1, END_OF_IMAGE, START_OF_SCAN, next_marker, read_u16};

/// A JFIF header without a thumbnail, in bytes.
const JFIF_BYTES: usize = 14;

/// See [`without_metadata`](crate::without_metadata).
///
/// - `exif`: a block to write instead of the file's.
pub(super) fn stripped(bytes: &[u8], exif: Option<&[u8]>) -> Option<Vec<u8>> {
    let mut out = vec![0xff, 0xd8];
    let mut exif = exif.map(|exif| [b"Exif\0\0", exif].concat());
    let mut reader = Cursor::new(bytes);
    loop {
        let marker = next_marker(&mut reader).ok()?;
        if ALONE.contains(&marker) {
            continue;
        }
        if marker == END_OF_IMAGE {
            out.extend([0xff, marker]);
            return Some(out);
        }
        let start = reader.position() as usize;
        let end = start + usize::from(read_u16(&mut reader).ok()?);
        let content = bytes.get(start + 2..end)?;
        let mut put = |marker, content: &[u8]| {
            out.extend([0xff, marker]);
            out.extend((content.len() as u16 + 2).to_be_bytes());
            out.extend(content);
        };
        reader.set_position(end as u64);
        if marker == APP0 && content.starts_with(b"JFIF\0") && content.len() >= JFIF_BYTES {
            // It comes first where there is one. The last two bytes are the size of its thumbnail.
            put(marker, &[&content[..JFIF_BYTES - 2], &[0, 0]].concat());
            continue;
        }
        if let Some(exif) = exif.take() {
            put(APP1, &exif);
        }
        if marker == START_OF_SCAN {
            put(marker, content);
            out.extend(codes(bytes, &mut reader)?);
        } else if matters(marker, content) {
            put(marker, content);
        }
    }
}

/// The codes of a scan, with restarts; the reader then is before the marker that follows.
fn codes<'a>(bytes: &'a [u8], reader: &mut Cursor<&[u8]>) -> Option<&'a [u8]> {
    let start = reader.position() as usize;
    while ALONE.contains(&next_marker(reader).ok()?) {}
    let end = reader.position() - 2;
    reader.set_position(end);
    bytes.get(start..end as usize)
}
