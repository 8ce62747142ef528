//! Removes from a JPEG what its decoder trips over although no image needs it.

use std::io::Cursor;

use super::{ALONE, START_OF_SCAN, next_marker, read_u16};

const APP2: u8 = 0xe2;
const APP14: u8 = 0xee;

/// A file whose header has the segments that matter alone: no stray bytes between them, comments and
/// metadata, sound or not. `None` if nothing can be left out.
///
/// The decoder is strict, since a truncated scan would be filled with grey otherwise; but strict
/// about these, too.
pub(super) fn cleaned(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut clean = vec![0xff, 0xd8];
    let mut reader = Cursor::new(bytes);
    loop {
        let marker = next_marker(&mut reader).ok()?;
        if ALONE.contains(&marker) {
            continue;
        }
        let start = reader.position() as usize;
        let length = usize::from(read_u16(&mut reader).ok()?);
        if marker == START_OF_SCAN {
            clean.extend([0xff, marker]);
            clean.extend(&bytes[start..]);
            return (clean.len() < bytes.len()).then_some(clean);
        }
        let segment = bytes.get(start..start + length)?;
        if matters(marker, segment.get(2..)?) {
            clean.extend([0xff, marker]);
            clean.extend(segment);
        }
        reader.set_position((start + length) as u64);
    }
}

/// Whether a segment says how to decode the picture, or in which colours.
pub(super) fn matters(marker: u8, content: &[u8]) -> bool {
    match marker {
        // Frames, tables and restart intervals.
        0xc0..=0xcf | 0xdb | 0xdd => true,
        APP2 => content.starts_with(b"ICC_PROFILE\0"),
        // A shorter one says nothing about colours.
        APP14 => content.starts_with(b"Adobe") && content.len() >= 12,
        _ => false,
    }
}
