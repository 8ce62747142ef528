//! Image files in formats that every browser supports.

/// The bytes of an image file that browsers show as it is; only its signature is read.
#[derive(Debug, Clone, Copy)]
pub struct WebImage<'a> {
    bytes: &'a [u8],
    media_type: &'static str,
}

impl<'a> WebImage<'a> {
    /// File extensions of the supported formats, for messages.
    pub const EXTENSIONS: &'static str = ".png, .jpg or .webp";

    /// Accepts PNG, JPEG and WebP, else `None`. Only the signature is checked.
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

    /// Media type, such as `image/png`.
    pub fn media_type(&self) -> &'static str {
        self.media_type
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_detected_from_signatures() {
        let kind = |bytes| WebImage::new(bytes).map(|picture| picture.media_type());
        assert_eq!(kind(b"\x89PNG\r\n\x1a\n..."), Some("image/png"));
        assert_eq!(kind(b"\xff\xd8\xff\xe0"), Some("image/jpeg"));
        assert_eq!(kind(b"RIFF\x10\0\0\0WEBPVP8 "), Some("image/webp"));
        for other in [&b"RIFF\x10\0\0\0WAVEfmt "[..], b"RIFF", b"II*\0", b"<svg>", b""] {
            assert_eq!(kind(other), None, "{other:?}");
        }
    }
}
