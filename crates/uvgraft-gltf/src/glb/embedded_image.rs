//! Encoded images to embed in GLB files.

use std::io::Cursor;

use uvgraft::{Depth, Encoding, Size, Texels, Texture};
use uvgraft_image::{self as image, Format, WriteOptions};

use super::embed_error::{EmbedError, EmbeddedFormat};
use super::ktx2_header;

/// An encoded image as GLB files embed it, with its size and format, where a
/// [`Texture`] has decoded texels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EmbeddedImage {
    bytes: Vec<u8>,
    format: EmbeddedFormat,
    size: Size,
}

impl EmbeddedImage {
    /// Wraps an encoded image unchanged; only its header is read.
    ///
    /// # Errors
    /// [`EmbedError`] if its format is not one of the four, or its header is damaged.
    pub fn new(bytes: Vec<u8>) -> Result<Self, EmbedError> {
        if bytes.starts_with(&ktx2_header::KTX2_IDENTIFIER) {
            let size = ktx2_header::size(&bytes)?;
            return Ok(Self { bytes, format: EmbeddedFormat::Ktx2, size });
        }
        let header = image::decode_header(&bytes)?;
        let format = EmbeddedFormat::of(header.format)
            .ok_or_else(|| EmbedError::Format { found: header.format.name() })?;
        Ok(Self { bytes, format, size: header.size })
    }

    /// Encodes a texture with 8 bits for each value; PNG is optimised for speed, not size.
    ///
    /// - Linear colours become sRGB. Alpha is dropped if it is 1 everywhere, and for JPEG.
    /// - `quality`: JPEG quality, in `1..=100`.
    /// - KTX2 files hold UASTC blocks and all mip levels; the texture's encoding decides whether
    ///   it is colour or data. Sides that are not multiples of 4 are stretched to the next one.
    ///
    /// # Errors
    /// [`EmbedError`] if the format cannot hold a texture of this size, or is KTX2
    /// and the feature `ktx2` is off.
    pub fn encode(
        texture: Texture,
        format: EmbeddedFormat,
        quality: u8,
    ) -> Result<Self, EmbedError> {
        let encoding = match texture.encoding() {
            Encoding::Linear => Encoding::Srgb,
            other => other,
        };
        let Some(file_format) = Format::from_media_type(format.mime_type()) else {
            return Self::encode_ktx2(texture.encoded_as(encoding));
        };
        let texture = texture.encoded_as(encoding);
        let channels = texture.channels();
        let texture = texture.converted(channels, Depth::U8);
        let alpha = channels.has_alpha() && file_format.codec().has_alpha && !is_opaque(&texture);
        let channels = if alpha { channels.with_alpha() } else { channels.without_alpha() };
        let texture = texture.converted(channels, Depth::U8);
        let size = texture.size();
        let mut out = Cursor::new(Vec::new());
        let options = WriteOptions::default().jpeg_quality(quality);
        // The reported losses can only be alpha and bit depth, dropped above on purpose.
        let _ = image::encode(&texture.into(), file_format, &options, &mut out)?;
        Ok(Self { bytes: out.into_inner(), format, size })
    }

    #[cfg(feature = "ktx2")]
    fn encode_ktx2(texture: Texture) -> Result<Self, EmbedError> {
        let channels = texture.channels();
        let texture = texture.converted(channels, Depth::U8);
        let has_alpha = channels.has_alpha() && !is_opaque(&texture);
        let (bytes, size) = super::ktx2::encode(texture, has_alpha)?;
        Ok(Self { bytes, format: EmbeddedFormat::Ktx2, size })
    }

    #[cfg(not(feature = "ktx2"))]
    fn encode_ktx2(_: Texture) -> Result<Self, EmbedError> {
        Err(EmbedError::NoKtx2)
    }

    /// The encoded bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The image format.
    pub const fn format(&self) -> EmbeddedFormat {
        self.format
    }

    /// Size in texels.
    pub const fn size(&self) -> Size {
        self.size
    }
}

fn is_opaque(texture: &Texture) -> bool {
    let count = texture.channels().count();
    match texture.texels() {
        Texels::U8(values) => values.chunks_exact(count).all(|texel| texel[count - 1] == u8::MAX),
        _ => false,
    }
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
            (EmbeddedFormat::Png, 1.0, Channels::Rgb),
            (EmbeddedFormat::Png, 0.5, Channels::Rgba),
            (EmbeddedFormat::Jpeg, 0.5, Channels::Rgb),
            (EmbeddedFormat::WebP, 1.0, Channels::Rgb),
        ] {
            let picture = EmbeddedImage::encode(texture(alpha), format, 90).unwrap();
            assert_eq!(EmbeddedImage::new(picture.bytes().to_vec()).unwrap(), picture);
            let decoded = image::decode(picture.bytes()).unwrap().texture;
            assert_eq!((decoded.size(), decoded.depth()), (Size::new(4, 2), Depth::U8));
            assert_eq!(decoded.channels(), channels);
            // Level 51 of 255; JPEG may be slightly off.
            assert!((decoded.get(1, 1, 0) - 0.2).abs() < 2.0 / 255.0);
        }
    }

    #[test]
    fn formats_unknown_to_gltf_are_rejected() {
        EmbeddedImage::new(b"hello, not an image".to_vec()).unwrap_err();
        let mut tiff = Cursor::new(Vec::new());
        let options = WriteOptions::default();
        let _ = image::encode(&texture(1.0).into(), Format::TIFF, &options, &mut tiff).unwrap();
        let error = EmbeddedImage::new(tiff.into_inner()).unwrap_err();
        assert!(matches!(error, EmbedError::Format { found: "TIFF" }), "{error}");
    }

    #[test]
    #[cfg(not(feature = "ktx2"))]
    fn builds_without_the_encoder_say_which_have_it() {
        let error = EmbeddedImage::encode(texture(1.0), EmbeddedFormat::Ktx2, 90).unwrap_err();
        assert!(matches!(error, EmbedError::NoKtx2));
        assert!(error.to_string().contains("feature `ktx2`"), "{error}");
    }

    #[test]
    fn ktx2_headers_are_validated() {
        let file = |words: &[u32]| {
            let words = words.iter().chain(&[0; 9]).flat_map(|word| word.to_le_bytes());
            ktx2_header::KTX2_IDENTIFIER.into_iter().chain(words).collect::<Vec<u8>>()
        };
        let picture = EmbeddedImage::new(file(&[0, 1, 64, 32, 0, 0, 1, 7])).unwrap();
        assert_eq!((picture.format(), picture.size()), (EmbeddedFormat::Ktx2, Size::new(64, 32)));
        for wrong in [
            &[0, 1, 64][..],
            &[37, 1, 64, 32, 0, 0, 1, 7],
            &[0, 1, 62, 32, 0, 0, 1, 7],
            &[0, 1, 0, 32, 0, 0, 1, 7],
            &[0, 1, 64, 32, 0, 0, 6, 7],
        ] {
            assert!(matches!(EmbeddedImage::new(file(wrong)), Err(EmbedError::Ktx2 { .. })));
        }
    }
}
