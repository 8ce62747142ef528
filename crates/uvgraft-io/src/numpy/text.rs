//! NumPy arrays of strings, of which only single strings are read.

use std::borrow::Cow;

use super::length;

/// The stored type of strings in an array: fixed width, padded with zeros.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TextDtype {
    /// Whether characters have four bytes rather than one.
    pub(crate) unicode: bool,
    /// Number of characters.
    pub(crate) length: usize,
    /// Whether characters are big-endian.
    pub(crate) big_endian: bool,
}

impl TextDtype {
    /// Parses NumPy's notation, such as `<U6` or `S4`; `None` unless it is a string type.
    pub(crate) fn from_text(text: &[u8]) -> Option<Self> {
        let (big_endian, text) = match text {
            [order @ (b'<' | b'>' | b'|' | b'='), rest @ ..] => (*order == b'>', rest),
            rest => (false, rest),
        };
        let (unicode, digits) = match text {
            [b'U', digits @ ..] => (true, digits),
            [b'S', digits @ ..] => (false, digits),
            _ => return None,
        };
        let digits = std::str::from_utf8(digits).ok()?;
        let declared: u64 = digits.parse().ok().filter(|_| !digits.starts_with('+'))?;
        Some(Self { unicode, length: length(declared), big_endian })
    }

    /// Bytes of one string, unless it overflows.
    pub(crate) fn width(self) -> Option<usize> {
        self.length.checked_mul(if self.unicode { 4 } else { 1 })
    }

    /// Decodes one string; `None` for invalid characters.
    pub(crate) fn read(self, bytes: &[u8]) -> Option<String> {
        if !self.unicode {
            let end = bytes.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
            return Some(lenient(&bytes[..end]).into_owned());
        }
        let read = if self.big_endian { u32::from_be_bytes } else { u32::from_le_bytes };
        let words = bytes.as_chunks::<4>().0;
        let text: Option<String> = words.iter().map(|&word| char::from_u32(read(word))).collect();
        text.map(|text| text.trim_end_matches('\0').to_owned())
    }
}

/// Decodes a byte string: UTF-8, or else Latin-1, in which every byte is a character.
pub(crate) fn lenient(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_both_kinds() {
        let read = |dtype: &[u8], bytes: &[u8]| TextDtype::from_text(dtype).unwrap().read(bytes);
        assert_eq!(read(b"|S4", b"ab\0\0").as_deref(), Some("ab"));
        assert_eq!(read(b"S2", b"\xe4\0").as_deref(), Some("ä"));
        assert_eq!(read(b"<U2", b"a\0\0\0\0\0\0\0").as_deref(), Some("a"));
        assert_eq!(read(b">U1", b"\0\x01\xf6\0").as_deref(), Some("😀"));
        assert_eq!(read(b"<U1", b"\0\0\0\x80"), None);
        for dtype in [&b"U"[..], b"<U-1", b"S+1", b"V4", b"O", b"<f4", b""] {
            assert_eq!(TextDtype::from_text(dtype), None, "{dtype:?}");
        }
        // It is a length on all machines, even where addresses have 32 bits.
        let long = TextDtype::from_text(b"U9223372036854775807").unwrap();
        assert_eq!(long.width(), None);
    }
}
