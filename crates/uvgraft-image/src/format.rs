//! Image formats, with their names, extensions and signatures.

use std::path::Path;

/// An image format that can be read and written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// 8 and 16 bits, alpha, ICC profile, lossless.
    Png,
    /// 8 bits, no alpha, ICC profile, lossy.
    Jpeg,
    /// 8 bits, alpha, ICC profile; written lossless. At most 16,383 texels a side.
    WebP,
    /// 8 and 16 bits and float, alpha, ICC profile, lossless.
    Tiff,
    /// Float in linear light, alpha, lossless; no ICC profile.
    Exr,
}

impl Format {
    /// All formats, in the order of messages.
    pub const ALL: [Self; 5] = [Self::Png, Self::Jpeg, Self::WebP, Self::Tiff, Self::Exr];

    /// Its common name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::WebP => "WebP",
            Self::Tiff => "TIFF",
            Self::Exr => "EXR",
        }
    }

    /// Its file extensions, in lower case without the dot, the usual one first.
    pub const fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Png => &["png"],
            Self::Jpeg => &["jpg", "jpeg"],
            Self::WebP => &["webp"],
            Self::Tiff => &["tif", "tiff"],
            Self::Exr => &["exr"],
        }
    }

    /// The format of an extension without its dot, case-insensitive.
    pub fn from_extension(extension: &str) -> Option<Self> {
        let is_it = |known: &&str| known.eq_ignore_ascii_case(extension);
        Self::ALL.into_iter().find(|format| format.extensions().iter().any(is_it))
    }

    /// The format of a path, by its extension.
    pub fn from_path(path: impl AsRef<Path>) -> Option<Self> {
        Self::from_extension(path.as_ref().extension()?.to_str()?)
    }

    /// The format of a file, by its first bytes; 12 are enough.
    pub fn detect(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => Some(Self::Png),
            [0xff, 0xd8, 0xff, ..] => Some(Self::Jpeg),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some(Self::WebP),
            // The second of each is BigTIFF.
            [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Some(Self::Tiff),
            [0x76, 0x2f, 0x31, 0x01, ..] => Some(Self::Exr),
            _ => None,
        }
    }

    /// "PNG, JPEG, WebP, TIFF, EXR", for messages.
    pub fn names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }

    /// ".png, .jpg, .jpeg, ...", for messages.
    pub fn extension_list() -> String {
        let dotted = Self::ALL.iter().flat_map(|format| format.extensions());
        dotted.map(|extension| format!(".{extension}")).collect::<Vec<_>>().join(", ")
    }
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_are_known_in_any_case() {
        assert_eq!(Format::from_path(Path::new("a/b.JPeG")), Some(Format::Jpeg));
        assert_eq!(Format::from_path(Path::new("a/b.tar.tif")), Some(Format::Tiff));
        assert_eq!(Format::from_path(Path::new("a.png/b")), None);
        assert_eq!(Format::from_extension("gif"), None);
        assert_eq!(Format::extension_list(), ".png, .jpg, .jpeg, .webp, .tif, .tiff, .exr");
    }
}
