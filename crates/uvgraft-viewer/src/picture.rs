//! Pictures that every browser shows.

/// A picture file's bytes, known by how they begin.
#[derive(Debug, Clone, Copy)]
pub struct Picture<'a> {
    bytes: &'a [u8],
    media_type: &'static str,
}

impl<'a> Picture<'a> {
    /// The file extensions of what is taken, for messages.
    pub const KINDS: &'static str = ".png, .jpg or .webp";

    /// Takes PNG, JPEG and WebP; nothing for other files. What follows the beginning is not looked at.
    pub fn new(bytes: &'a [u8]) -> Option<Self> {
        let media_type = if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
            "image/png"
        } else if bytes.starts_with(b"\xff\xd8\xff") {
            "image/jpeg"
        } else if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
            "image/webp"
        } else {
            return None;
        };
        Some(Self { bytes, media_type })
    }

    /// The whole file.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// Such as `image/png`.
    pub fn media_type(&self) -> &'static str {
        self.media_type
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_told_by_their_beginnings() {
        let kind = |bytes| Picture::new(bytes).map(|picture| picture.media_type());
        assert_eq!(kind(b"\x89PNG\r\n\x1a\n..."), Some("image/png"));
        assert_eq!(kind(b"\xff\xd8\xff\xe0"), Some("image/jpeg"));
        assert_eq!(kind(b"RIFF\x10\0\0\0WEBPVP8 "), Some("image/webp"));
        for other in [&b"RIFF\x10\0\0\0WAVEfmt "[..], b"RIFF", b"II*\0", b"<svg>", b""] {
            assert_eq!(kind(other), None, "{other:?}");
        }
    }
}
