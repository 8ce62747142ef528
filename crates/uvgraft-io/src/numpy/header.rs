//! The header of NPY files.
//!
//! The header is a Python dictionary with a shape that may claim anything. It is parsed here
//! without recursion, and nothing is allocated for what it claims. A general NPY reader was tried
//! and rejected: it multiplied the dimensions unchecked, so that a hostile shape overflowed, and
//! allocated the header length that a file claims.
//!
//! Source: `numpy.lib.format`, versions 1.0 to 3.0.

use super::MAGIC;
use crate::obj::shown;

/// Why the header of an NPY file was rejected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum HeaderError {
    /// An unknown version of the format.
    #[error("NPY format version must be 1.0, 2.0 or 3.0, got {major}.{minor}")]
    Version {
        /// Major version.
        major: u8,
        /// Minor version.
        minor: u8,
    },
    /// The file ends within the header.
    #[error("truncated NPY file: header must have {wanted} bytes, got {found}")]
    Truncated {
        /// Size of the header, including what precedes it.
        wanted: u64,
        /// Bytes in the file.
        found: usize,
    },
    /// The header is not a Python dictionary of the three entries that describe an array.
    #[error("NPY header: must have {wanted}, got `{found}`")]
    Header {
        /// The malformed part, shortened.
        found: String,
        /// What it must be.
        wanted: &'static str,
    },
}

fn wrong(found: &[u8], wanted: &'static str) -> HeaderError {
    HeaderError::Header { found: shown(found), wanted }
}

/// The raw entries of the dictionary, and the data after it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Header<'a> {
    pub(crate) descr: &'a [u8],
    pub(crate) fortran_order: bool,
    pub(crate) shape: &'a [u8],
    pub(crate) values: &'a [u8],
}

impl<'a> Header<'a> {
    /// Parses what follows the magic.
    pub(crate) fn parse(bytes: &'a [u8]) -> Result<Self, HeaderError> {
        let cut_short = |wanted: u64| {
            let before = MAGIC.len();
            HeaderError::Truncated { wanted: wanted + before as u64, found: bytes.len() + before }
        };
        let (start, length) = match *bytes {
            [1, 0, a, b, ..] => (4, u64::from(u16::from_le_bytes([a, b]))),
            [2 | 3, 0, a, b, c, d, ..] => (6, u64::from(u32::from_le_bytes([a, b, c, d]))),
            [1, 0, ..] | [] | [_] => return Err(cut_short(4)),
            [2 | 3, 0, ..] => return Err(cut_short(6)),
            [major, minor, ..] => return Err(HeaderError::Version { major, minor }),
        };
        let end = start + length;
        let Some((head, values)) =
            usize::try_from(end).ok().and_then(|end| bytes.split_at_checked(end))
        else {
            return Err(cut_short(end));
        };
        Self::entries(&head[start as usize..], values)
    }

    fn entries(text: &'a [u8], values: &'a [u8]) -> Result<Self, HeaderError> {
        let text = text.trim_ascii();
        let body = text.strip_prefix(b"{").and_then(|text| text.strip_suffix(b"}"));
        let mut rest = body.ok_or_else(|| wrong(text, "a dictionary in braces"))?.trim_ascii();
        let [mut descr, mut fortran_order, mut shape] = [None; 3];
        while !rest.is_empty() {
            let entry;
            (entry, rest) = split_at_comma(rest);
            let colon = entry.iter().position(|&byte| byte == b':').unwrap_or(entry.len());
            let (key, value) = entry.split_at(colon);
            let slot = match unquoted(key.trim_ascii()) {
                Some(b"descr") => &mut descr,
                Some(b"fortran_order") => &mut fortran_order,
                Some(b"shape") => &mut shape,
                _ => return Err(wrong(entry, "'descr', 'fortran_order' or 'shape'")),
            };
            *slot = Some(value.get(1..).unwrap_or_default().trim_ascii());
        }
        let entry = |slot: Option<&'a [u8]>, wanted| slot.ok_or_else(|| wrong(text, wanted));
        let descr = entry(descr, "an entry 'descr'")?;
        let fortran_order = match entry(fortran_order, "an entry 'fortran_order'")? {
            b"True" => true,
            b"False" => false,
            found => return Err(wrong(found, "True or False as 'fortran_order'")),
        };
        Ok(Self { descr, fortran_order, shape: entry(shape, "an entry 'shape'")?, values })
    }
}

/// Splits at the first comma outside quotes and brackets.
fn split_at_comma(text: &[u8]) -> (&[u8], &[u8]) {
    let mut depth = 0_usize;
    let mut quote = None;
    for (at, &byte) in text.iter().enumerate() {
        match (quote, byte) {
            (Some(open), _) if byte == open => quote = None,
            (Some(_), _) => {}
            (None, b'\'' | b'"') => quote = Some(byte),
            (None, b'(' | b'[' | b'{') => depth += 1,
            (None, b')' | b']' | b'}') => depth = depth.saturating_sub(1),
            (None, b',') if depth == 0 => {
                return (text[..at].trim_ascii(), text[at + 1..].trim_ascii());
            }
            _ => {}
        }
    }
    (text, b"")
}

/// The content of a quoted string.
pub(crate) fn unquoted(text: &[u8]) -> Option<&[u8]> {
    match text {
        [b'\'', inner @ .., b'\''] | [b'"', inner @ .., b'"'] => Some(inner),
        _ => None,
    }
}

/// The lengths of a shape's axes; `None` unless it is a tuple of integers with at most `most` axes.
pub(crate) fn axes(shape: &[u8], most: usize) -> Option<Vec<u64>> {
    let mut rest = shape.strip_prefix(b"(")?.strip_suffix(b")")?.trim_ascii();
    let mut axes = Vec::new();
    while !rest.is_empty() {
        let axis;
        (axis, rest) = split_at_comma(rest);
        // Python 2 wrote long integers as `5023L`.
        let digits = axis.strip_suffix(b"L").unwrap_or(axis);
        let length = std::str::from_utf8(digits).ok()?.parse().ok()?;
        if axes.len() == most {
            return None;
        }
        axes.push(length);
    }
    Some(axes)
}
