//! The list of image formats, and what it says about files.

use std::hash::{Hash, Hasher};
use std::path::Path;

use super::codec::Codec;

/// An image format that can be read and written.
#[derive(Clone, Copy)]
pub struct Format(&'static Codec);

impl Format {
    /// All formats that are built in, in the order of messages.
    pub const ALL: &'static [Self] = &[
        Self::PNG,
        Self::JPEG,
        Self::WEBP,
        #[cfg(feature = "tiff")]
        Self::TIFF,
        #[cfg(feature = "exr")]
        Self::EXR,
    ];

    /// A format of another program, too: its own is the codec at this very place.
    pub const fn new(codec: &'static Codec) -> Self {
        Self(codec)
    }

    /// What it stores, and how.
    pub const fn codec(self) -> &'static Codec {
        self.0
    }

    /// Its common name.
    pub const fn name(self) -> &'static str {
        self.0.name
    }

    /// Its file extensions, in lower case without the dot, the usual one first.
    pub const fn extensions(self) -> &'static [&'static str] {
        self.0.extensions
    }

    /// The format of an extension without its dot, case-insensitive.
    pub fn from_extension(extension: &str) -> Option<Self> {
        let is_it = |known: &&str| known.eq_ignore_ascii_case(extension);
        Self::first(|format| format.extensions.iter().any(is_it))
    }

    /// The format of a path, by its extension.
    pub fn from_path(path: impl AsRef<Path>) -> Option<Self> {
        Self::from_extension(path.as_ref().extension()?.to_str()?)
    }

    /// The format of a media type, such as `image/png`.
    pub fn from_media_type(name: &str) -> Option<Self> {
        Self::first(|format| format.media_type == name)
    }

    /// The format of a file, by its first bytes; 12 are enough.
    pub fn detect(bytes: &[u8]) -> Option<Self> {
        Self::first(|format| (format.is_start)(bytes))
    }

    fn first(is_it: impl Fn(&Codec) -> bool) -> Option<Self> {
        Self::ALL.iter().copied().find(|format| is_it(format.0))
    }

    /// "PNG, JPEG, WebP, TIFF, EXR", for messages.
    pub fn names() -> String {
        joined(Self::ALL.iter().map(|format| format.name()), ", ")
    }

    /// "PNG, WebP, TIFF or EXR": those for which something holds, for messages.
    ///
    /// - `conjunction`: before the last one.
    pub fn names_of(is_one: impl Fn(&Codec) -> bool, conjunction: &str) -> String {
        let names = Self::ALL.iter().filter(|format| is_one(format.0)).map(|format| format.name());
        let names: Vec<_> = names.collect();
        match &names[..] {
            [first @ .., last] if !first.is_empty() => {
                format!("{} {conjunction} {last}", first.join(", "))
            }
            names => names.concat(),
        }
    }

    /// ".png, .jpg, .jpeg, ...", for messages.
    pub fn extension_list() -> String {
        let extensions = Self::ALL.iter().flat_map(|format| format.extensions());
        joined(extensions.map(|extension| format!(".{extension}")), ", ")
    }
}

fn joined(items: impl Iterator<Item = impl Into<String>>, separator: &str) -> String {
    items.map(Into::into).collect::<Vec<String>>().join(separator)
}

impl PartialEq for Format {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

impl Eq for Format {}

impl Hash for Format {
    fn hash<H: Hasher>(&self, state: &mut H) {
        std::ptr::hash(self.0, state);
    }
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::fmt::Debug for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_are_known_in_any_case() {
        assert_eq!(Format::from_path(Path::new("a/b.JPeG")), Some(Format::JPEG));
        assert_eq!(Format::from_path(Path::new("a.png/b")), None);
        assert_eq!(Format::from_extension("gif"), None);
        assert!(Format::extension_list().starts_with(".png, .jpg, .jpeg, .webp"));
    }

    #[test]
    #[cfg(all(feature = "exr", feature = "tiff"))]
    fn messages_name_the_formats_of_the_list() {
        assert_eq!(Format::from_path(Path::new("a/b.tar.tif")), Some(Format::TIFF));
        assert_eq!(Format::extension_list(), ".png, .jpg, .jpeg, .webp, .tif, .tiff, .exr");
        assert_eq!(Format::names(), "PNG, JPEG, WebP, TIFF, EXR");
        assert_eq!(Format::names_of(|format| format.has_alpha, "or"), "PNG, WebP, TIFF or EXR");
        assert_eq!(Format::names_of(|format| format.is_lossy, "and"), "JPEG");
    }
}
