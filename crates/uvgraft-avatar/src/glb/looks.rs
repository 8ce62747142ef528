//! The material of an avatar, and its images as the files they will be.

use std::io::Cursor;

use uvgraft::{Depth, Encoding, Size, Texels, Texture, TextureError};
use uvgraft_io::image::{self, EncodeError, Format, ImageError, WriteOptions};

/// How surfaces are lit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Style {
    /// By glTF's physically based model, which all readers have.
    #[default]
    Pbr,
    /// As drawings are, by `VRMC_materials_mtoon` 1.0; for readers without it as [`Style::Pbr`].
    MToon,
    /// Not at all: plain colours, by `KHR_materials_unlit`.
    Unlit,
}

/// A material. Each one costs a draw call, and platforms rank avatars by how many they have.
#[derive(Debug, Clone)]
pub struct Looks {
    /// What the material is called.
    pub name: String,
    /// Base colour, sRGB. Its opacity is not shown.
    pub color: Picture,
    /// Normal map in tangent space with green up ("OpenGL"); with it the file has tangents.
    pub normal: Option<Picture>,
    /// Roughness in green and metalness in blue, as glTF has it; the factors are multiplied in.
    pub roughness: Option<Picture>,
    /// Ambient occlusion in red; it may be the same picture as `roughness`, which is then stored once.
    pub occlusion: Option<Picture>,
    /// What shines by itself, sRGB.
    pub emissive: Option<Picture>,
    /// `0.0..=1.0`, 1 for what does not shine.
    pub roughness_factor: f32,
    /// `0.0..=1.0`, 0 for what is no metal.
    pub metallic_factor: f32,
    /// Show the backs of triangles too.
    pub double_sided: bool,
    /// How it is lit.
    pub style: Style,
    /// Its triangles are in the way of who looks out of the avatar's eyes: VRM files hide them then.
    pub is_head: bool,
}

impl Looks {
    /// Skin and cloth under a texture: no metal, rather rough.
    pub fn new(color: Picture) -> Self {
        Self {
            name: "body".to_owned(),
            color,
            normal: None,
            roughness: None,
            occlusion: None,
            emissive: None,
            roughness_factor: 0.7,
            metallic_factor: 0.0,
            double_sided: false,
            style: Style::default(),
            is_head: false,
        }
    }

    /// Whether its vertices have tangents: where there is a normal map. Shaders of MToon refuse them (three-vrm 3), and
    /// readers of such files make their own, as glTF has it.
    pub(super) fn has_tangents(&self) -> bool {
        self.normal.is_some() && self.style != Style::MToon
    }

    /// All images, each once, in the order in which they are stored.
    pub fn pictures(&self) -> impl Iterator<Item = &Picture> {
        let occlusion = self.occlusion.as_ref().filter(|_| self.occlusion != self.roughness);
        let data = [self.normal.as_ref(), self.roughness.as_ref(), occlusion];
        [Some(&self.color), self.emissive.as_ref()].into_iter().chain(data).flatten()
    }
}

impl AsRef<[Self]> for Looks {
    fn as_ref(&self) -> &[Self] {
        std::slice::from_ref(self)
    }
}

/// A format of images in GLB files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PictureFormat {
    /// Lossless; read by everything.
    Png,
    /// Lossy and without opacity; read by everything.
    Jpeg,
    /// Written lossless, smaller than PNG; needs `EXT_texture_webp`, which browsers have.
    WebP,
    /// Compressed for graphics processors, which keep it so; needs `KHR_texture_basisu`.
    Ktx2,
}

impl PictureFormat {
    /// The media type.
    pub const fn mime_type(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
            Self::WebP => "image/webp",
            Self::Ktx2 => "image/ktx2",
        }
    }
}

/// An encoded image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    bytes: Vec<u8>,
    format: PictureFormat,
    size: Size,
    fallback: Option<Box<Self>>,
}

/// Why an image cannot be part of a GLB file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The image is damaged, or in no format that is known.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A format that glTF does not have.
    #[error("a GLB file must hold PNG, JPEG, WebP or KTX2 images, got {found}; convert it first")]
    Format {
        /// What it is.
        found: &'static str,
    },
    /// A KTX2 file that `KHR_texture_basisu` does not allow.
    #[error("a KTX2 image {problem}")]
    Ktx2 {
        /// What is wrong.
        problem: &'static str,
    },
    /// What stands in for an image where its format is unknown must be PNG or JPEG.
    #[error("a fallback image must be PNG or JPEG, got {found:?}")]
    Fallback {
        /// What it is.
        found: PictureFormat,
    },
    /// The encoder refused.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// There is not enough memory to resize the texture.
    #[error(transparent)]
    Texture(#[from] TextureError),
    /// This build has no encoder for it.
    #[error("KTX2 encoding needs a build with the feature `ktx2`")]
    NoKtx2,
}

impl Picture {
    /// Takes over an image as it is, after a look at its header.
    ///
    /// # Errors
    /// [`PictureError`] if it is none of the four formats, or damaged where that shows.
    pub fn new(bytes: Vec<u8>) -> Result<Self, PictureError> {
        if bytes.starts_with(&KTX2_IDENTIFIER) {
            let size = ktx2_size(&bytes)?;
            return Ok(Self { bytes, format: PictureFormat::Ktx2, size, fallback: None });
        }
        let header = image::decode_header(&bytes)?;
        let format = match header.format {
            Format::Png => PictureFormat::Png,
            Format::Jpeg => PictureFormat::Jpeg,
            Format::WebP => PictureFormat::WebP,
            other => return Err(PictureError::Format { found: other.name() }),
        };
        Ok(Self { bytes, format, size: header.size, fallback: None })
    }

    /// Encodes a texture with 8 bits a value; PNG fast rather than small.
    ///
    /// - Linear colours become sRGB. Opacity is dropped where it is full, and for JPEG.
    /// - `quality`: of a JPEG, in `1..=100`.
    /// - KTX2 holds UASTC blocks and all mip levels, and tells colours from data by the texture's
    ///   encoding. Sides that are no multiples of 4 are stretched to the next one.
    ///
    /// # Errors
    /// [`PictureError`] if the format cannot hold a texture of this size, or is KTX2 and the feature
    /// `ktx2` is off.
    pub fn encode(
        texture: Texture,
        format: PictureFormat,
        quality: u8,
    ) -> Result<Self, PictureError> {
        let encoding = match texture.encoding() {
            Encoding::Linear => Encoding::Srgb,
            other => other,
        };
        let file_format = match format {
            PictureFormat::Png => Format::Png,
            PictureFormat::Jpeg => Format::Jpeg,
            PictureFormat::WebP => Format::WebP,
            PictureFormat::Ktx2 => return Self::encode_ktx2(texture.encoded_as(encoding)),
        };
        let texture = texture.encoded_as(encoding);
        let channels = texture.channels();
        let texture = texture.converted(channels, Depth::U8);
        let alpha = channels.has_alpha() && format != PictureFormat::Jpeg && !is_opaque(&texture);
        let channels = if alpha { channels.with_alpha() } else { channels.without_alpha() };
        let texture = texture.converted(channels, Depth::U8);
        let size = texture.size();
        let mut out = Cursor::new(Vec::new());
        let options = WriteOptions::default().jpeg_quality(quality);
        // Losses can only be opacity and bits, which are gone already.
        let _ = image::encode(&texture.into(), file_format, &options, &mut out)?;
        Ok(Self { bytes: out.into_inner(), format, size, fallback: None })
    }

    #[cfg(feature = "ktx2")]
    fn encode_ktx2(texture: Texture) -> Result<Self, PictureError> {
        let channels = texture.channels();
        let texture = texture.converted(channels, Depth::U8);
        let has_alpha = channels.has_alpha() && !is_opaque(&texture);
        let (bytes, size) = super::ktx2::encode(texture, has_alpha)?;
        Ok(Self { bytes, format: PictureFormat::Ktx2, size, fallback: None })
    }

    #[cfg(not(feature = "ktx2"))]
    fn encode_ktx2(_: Texture) -> Result<Self, PictureError> {
        Err(PictureError::NoKtx2)
    }

    /// With another image for readers that do not know this one's format. Without it a WebP or KTX2
    /// image makes its extension one that readers must know.
    ///
    /// # Errors
    /// [`PictureError::Fallback`] unless it is PNG or JPEG.
    pub fn with_fallback(mut self, fallback: Self) -> Result<Self, PictureError> {
        if !matches!(fallback.format, PictureFormat::Png | PictureFormat::Jpeg) {
            return Err(PictureError::Fallback { found: fallback.format });
        }
        self.fallback = Some(Box::new(fallback));
        Ok(self)
    }

    /// The file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// What kind of file it is.
    pub const fn format(&self) -> PictureFormat {
        self.format
    }

    /// In texels.
    pub const fn size(&self) -> Size {
        self.size
    }

    /// What stands in for it.
    pub fn fallback(&self) -> Option<&Self> {
        self.fallback.as_deref()
    }
}

fn is_opaque(texture: &Texture) -> bool {
    let count = texture.channels().count();
    match texture.texels() {
        Texels::U8(values) => values.chunks_exact(count).all(|texel| texel[count - 1] == u8::MAX),
        _ => false,
    }
}

pub(crate) const KTX2_IDENTIFIER: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";

/// Source: Khronos Group, "KTX File Format Specification", version 2.0, and `KHR_texture_basisu`.
fn ktx2_size(bytes: &[u8]) -> Result<Size, PictureError> {
    let wrong = |problem| Err(PictureError::Ktx2 { problem });
    let word = |index: usize| {
        let at = KTX2_IDENTIFIER.len() + 4 * index;
        bytes.get(at..at + 4)?.first_chunk().map(|&word| u32::from_le_bytes(word))
    };
    // vkFormat, typeSize, width, height, depth, layers, faces, levels.
    let words: Option<Vec<u32>> = (0..8).map(word).collect();
    let Some(&[format, _, width, height, depth, layers, faces, _]) = words.as_deref() else {
        return wrong("is truncated");
    };
    if format != 0 {
        return wrong("must be in a Basis Universal format (ETC1S or UASTC)");
    }
    if depth != 0 || layers != 0 || faces != 1 {
        return wrong("must be a single 2D image");
    }
    if width == 0 || height == 0 || !width.is_multiple_of(4) || !height.is_multiple_of(4) {
        return wrong("must have sides that are multiples of 4");
    }
    Ok(Size::new(width, height))
}

#[cfg(test)]
mod tests {
    use uvgraft::Channels;

    use super::*;

    fn texture(alpha: f32) -> Texture {
        let texel = [0.2, 0.4, 0.6, alpha];
        Texture::filled(Size::new(4, 2), Channels::Rgba, Encoding::Srgb, Depth::F32, &texel)
            .unwrap()
    }

    #[test]
    fn textures_become_files_of_8_bits() {
        for (format, alpha, channels) in [
            (PictureFormat::Png, 1.0, Channels::Rgb),
            (PictureFormat::Png, 0.5, Channels::Rgba),
            (PictureFormat::Jpeg, 0.5, Channels::Rgb),
            (PictureFormat::WebP, 1.0, Channels::Rgb),
        ] {
            let picture = Picture::encode(texture(alpha), format, 90).unwrap();
            assert_eq!(Picture::new(picture.bytes().to_vec()).unwrap(), picture);
            let decoded = image::decode(picture.bytes()).unwrap().texture;
            assert_eq!((decoded.size(), decoded.depth()), (Size::new(4, 2), Depth::U8));
            assert_eq!(decoded.channels(), channels);
            // Level 51 of 255; a JPEG may be off by a little.
            assert!((decoded.get(1, 1, 0) - 0.2).abs() < 2.0 / 255.0);
        }
    }

    #[test]
    fn what_gltf_does_not_know_is_refused() {
        Picture::new(b"hello, this is no image".to_vec()).unwrap_err();
        let mut tiff = Cursor::new(Vec::new());
        let options = WriteOptions::default();
        let _ = image::encode(&texture(1.0).into(), Format::Tiff, &options, &mut tiff).unwrap();
        let error = Picture::new(tiff.into_inner()).unwrap_err();
        assert!(matches!(error, PictureError::Format { found: "TIFF" }), "{error}");
        let webp = Picture::encode(texture(1.0), PictureFormat::WebP, 90).unwrap();
        assert!(matches!(webp.clone().with_fallback(webp), Err(PictureError::Fallback { .. })));
    }

    #[test]
    #[cfg(not(feature = "ktx2"))]
    fn builds_without_the_encoder_say_which_have_it() {
        let error = Picture::encode(texture(1.0), PictureFormat::Ktx2, 90).unwrap_err();
        assert!(matches!(error, PictureError::NoKtx2));
        assert!(error.to_string().contains("feature `ktx2`"), "{error}");
    }

    #[test]
    fn headers_of_ktx2_are_looked_at() {
        let file = |words: &[u32]| {
            let words = words.iter().flat_map(|word| word.to_le_bytes());
            KTX2_IDENTIFIER.into_iter().chain(words).collect::<Vec<u8>>()
        };
        let picture = Picture::new(file(&[0, 1, 64, 32, 0, 0, 1, 7])).unwrap();
        assert_eq!((picture.format(), picture.size()), (PictureFormat::Ktx2, Size::new(64, 32)));
        for wrong in [
            &[0, 1, 64][..],
            &[37, 1, 64, 32, 0, 0, 1, 7],
            &[0, 1, 62, 32, 0, 0, 1, 7],
            &[0, 1, 0, 32, 0, 0, 1, 7],
            &[0, 1, 64, 32, 0, 0, 6, 7],
        ] {
            assert!(matches!(Picture::new(file(wrong)), Err(PictureError::Ktx2 { .. })));
        }
    }
}
