//! The images used by a file's materials: collected first, then decoded together.

use std::borrow::Cow;

use uvgraft::{Size, Texture};
use uvgraft_io::image::{self, DeclaredSpace};

use super::accessor::Accessors;
use super::asset::Asset;
use super::check::{find, too_many};
use super::document;
use super::error::SceneError;
use super::material::{TextureUse, Wrap};
use crate::glb::KTX2_IDENTIFIER;

/// Limit of texels in all images together.
const MAX_TEXELS: u64 = 1 << 28;

/// The file's images that are in use.
#[derive(Default)]
pub(super) struct Images<'a> {
    /// Their indices in the file.
    numbers: Vec<u32>,
    encoded: Vec<Cow<'a, [u8]>>,
    texels: u64,
}

impl<'a> Images<'a> {
    /// A texture of the file; `None` if it has no image.
    ///
    /// - `place`: the referring object, for messages.
    pub fn use_of(
        &mut self,
        texture: u32,
        place: &str,
        asset: &Asset<'a>,
        accessors: &Accessors<'a>,
    ) -> Result<Option<TextureUse>, SceneError> {
        let document = &asset.document;
        let texture = find(&document.textures, texture, "texture", place)?;
        let Some(image) = source(texture)? else { return Ok(None) };
        let default = document::TextureSampler::default();
        let sampler = match texture.sampler {
            Some(index) => find(&document.samplers, index, "sampler", place)?,
            None => &default,
        };
        let wrap = |code: Option<u32>| match code {
            Some(33_071) => Wrap::Clamp,
            Some(33_648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        let index = match self.numbers.iter().position(|&number| number == image) {
            Some(index) => index,
            None => self.add(image, place, asset, accessors)?,
        };
        Ok(Some(TextureUse {
            index,
            wrap: [wrap(sampler.wrap_s), wrap(sampler.wrap_t)],
            nearest: sampler.mag_filter == Some(9728),
            coordinates: 0,
        }))
    }

    fn add(
        &mut self,
        number: u32,
        place: &str,
        asset: &Asset<'a>,
        accessors: &Accessors<'a>,
    ) -> Result<usize, SceneError> {
        let image = find(&asset.document.images, number, "image", place)?;
        let place = format!("image {number}");
        let bytes = bytes(image, asset, accessors, &place)?;
        self.texels += size(&bytes, number)?.texels() as u64;
        too_many("texels of images", self.texels, MAX_TEXELS)?;
        self.numbers.push(number);
        self.encoded.push(bytes);
        Ok(self.numbers.len() - 1)
    }

    /// Decodes all images, in the order of [`TextureUse::index`].
    pub fn decode(self) -> Result<Vec<Texture>, SceneError> {
        let each = self.numbers.into_iter().zip(self.encoded);
        each.map(|(number, bytes)| decode(&bytes, number)).collect()
    }
}

/// The preferred image of a texture: one that needs no C++ decoder, if there is a choice.
pub(super) fn source(texture: &document::Texture) -> Result<Option<u32>, SceneError> {
    let of = |source: &Option<document::Source>| source.as_ref().map(|source| source.source);
    let plain = of(&texture.extensions.webp).or(texture.source);
    if let Some(source) = plain.or(of(&texture.extensions.basisu)) {
        return Ok(Some(source));
    }
    match texture.extensions.avif {
        Some(_) => Err(SceneError::extension("EXT_texture_avif")),
        None => Ok(None),
    }
}

/// The encoded bytes of an image.
pub(super) fn bytes<'a>(
    image: &document::Image,
    asset: &Asset<'a>,
    accessors: &Accessors<'a>,
    place: &str,
) -> Result<Cow<'a, [u8]>, SceneError> {
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => asset.resource(uri).map_err(|why| SceneError::content(place, why)),
        (None, Some(view)) => Ok(Cow::Borrowed(accessors.view(view, place)?.0)),
        (None, None) => Err(SceneError::content(place, "must have a URI or a buffer view")),
    }
}

pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(&KTX2_IDENTIFIER)
}

/// The size of an encoded image; errors if it alone exceeds the limit.
pub(super) fn size(bytes: &[u8], number: u32) -> Result<Size, SceneError> {
    let size = if is_ktx2(bytes) {
        ktx2_size(bytes, number)?
    } else {
        let header = image::decode_header(bytes);
        header.map_err(|reason| SceneError::Image { index: number as usize, reason })?.size
    };
    too_many("texels of images", size.texels() as u64, MAX_TEXELS)?;
    Ok(size)
}

/// Decodes an image. The caller has limited its size.
pub(super) fn decode(bytes: &[u8], number: u32) -> Result<Texture, SceneError> {
    if is_ktx2(bytes) {
        return ktx2_texture(bytes, number);
    }
    let index = number as usize;
    // glTF 2.0, section 3.9.2: colour space information in images must be ignored.
    let image = image::decode_with(bytes, DeclaredSpace::Ignored);
    image.map(|image| image.texture).map_err(|reason| SceneError::Image { index, reason })
}

#[cfg(feature = "ktx2")]
fn ktx2_size(bytes: &[u8], number: u32) -> Result<Size, SceneError> {
    super::ktx2::size(bytes).map_err(|why| SceneError::content(format!("image {number}"), why))
}

#[cfg(feature = "ktx2")]
fn ktx2_texture(bytes: &[u8], number: u32) -> Result<Texture, SceneError> {
    super::ktx2::decode(bytes).map_err(|why| SceneError::content(format!("image {number}"), why))
}

#[cfg(not(feature = "ktx2"))]
fn ktx2_size(_: &[u8], _: u32) -> Result<Size, SceneError> {
    Err(SceneError::extension("KHR_texture_basisu"))
}

#[cfg(not(feature = "ktx2"))]
fn ktx2_texture(_: &[u8], _: u32) -> Result<Texture, SceneError> {
    Err(SceneError::extension("KHR_texture_basisu"))
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use uvgraft::{Channels, Encoding, Texels};
    use uvgraft_io::image::{Format, WriteOptions};

    use super::*;

    #[test]
    fn the_colour_space_of_an_image_is_ignored() {
        let values = Texels::U8(vec![128, 10, 200]);
        let size = Size::new(1, 1);
        let texture = Texture::new(size, Channels::Rgb, Encoding::Srgb, values).unwrap();
        let mut out = Cursor::new(Vec::new());
        let written =
            image::encode(&texture.clone().into(), Format::Png, &WriteOptions::default(), &mut out);
        let _ = written.unwrap();
        let (header, rest) = out.get_ref().split_at(33);
        // A gAMA chunk of linear light.
        let gamma = b"\0\0\0\x04gAMA\0\x01\x86\xa0\x31\xe8\x96\x5f";
        let bytes = [header, gamma, rest].concat();
        assert_eq!(decode(&bytes, 0).unwrap(), texture);
        assert_ne!(image::decode(&bytes).unwrap().texture, texture);
    }
}
