//! The images used by a file's materials: collected first, then decoded together.

use std::collections::{HashMap, HashSet};

use uvgraft::{Size, Texture};
use uvgraft_image::{self as image, DeclaredSpace};

use super::accessor::Accessors;
use super::asset::{Asset, Bytes};
use super::budget::{Demand, MAX_TEXELS, Purpose};
use super::check::{find, too_many};
use super::document;
use super::error::SceneError;
use super::material::{TextureUse, Wrap};
use crate::glb::KTX2_IDENTIFIER;

/// Bytes of a texel while KTX2 is decoded, apart from those of its values.
const DECODING: u64 = 4;
/// Bytes of a texel as it is drawn, with all smaller copies of it.
const DRAWN: u64 = 6;

/// The file's images that are in use.
#[derive(Default)]
pub(super) struct Images<'a> {
    /// Their indices in the file.
    numbers: Vec<u32>,
    encoded: Vec<Bytes<'a>>,
    sizes: Vec<Size>,
    texels: u64,
    index_of: HashMap<u32, usize>,
    /// Images that are in the same place are one: some exporters write one for each material.
    index_at: HashMap<Place, usize>,
    /// The images that are drawn, as colours or as data.
    drawn: HashSet<(usize, bool)>,
    demand: Demand,
}

/// Where an image is: in a file or in a buffer view.
#[derive(PartialEq, Eq, Hash)]
enum Place {
    File(String),
    View(u32),
}

impl Place {
    fn of(image: &document::Image) -> Option<Self> {
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => Some(Self::File(uri.clone())).filter(|_| !uri.starts_with("data:")),
            (None, view) => view.map(Self::View),
        }
    }
}

impl<'a> Images<'a> {
    /// - `demand`: what the file asks for without its images.
    pub fn new(demand: Demand) -> Self {
        Self { demand, ..Self::default() }
    }

    /// A texture of the file; `None` if it has no image.
    ///
    /// - `is_data`: whether it has numbers instead of colours.
    /// - `place`: the referring object, for messages.
    pub fn use_of(
        &mut self,
        (texture, is_data): (u32, bool),
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
        let index = match self.index_of.get(&image) {
            Some(&index) => index,
            None => self.add(image, place, asset, accessors)?,
        };
        self.index_of.insert(image, index);
        if self.drawn.insert((index, is_data)) {
            self.demand.add(Purpose::Images, self.sizes[index].texels() as u64, DRAWN);
        }
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
        let index = self.numbers.len();
        if let Some(place) = Place::of(image) {
            let known = *self.index_at.entry(place).or_insert(index);
            if known < index {
                return Ok(known);
            }
        }
        let bytes = bytes(image, asset, accessors, &format!("image {number}"))?;
        let Extent { size, bytes_each, decoding } = extent(&bytes, number)?;
        let texels = size.texels() as u64;
        self.texels += texels;
        too_many("texels of images", self.texels, MAX_TEXELS)?;
        self.demand.add(Purpose::Images, texels, bytes_each);
        self.demand.pass(Purpose::Images, texels * (bytes_each + decoding));
        self.numbers.push(number);
        self.encoded.push(bytes);
        self.sizes.push(size);
        Ok(index)
    }

    /// What the file asks for.
    pub fn demand(&self) -> &Demand {
        &self.demand
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
) -> Result<Bytes<'a>, SceneError> {
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => asset.resource(uri).map_err(|why| SceneError::content(place, why)),
        (None, Some(view)) => Ok(Bytes::Part(accessors.view(view, place)?.0)),
        (None, None) => Err(SceneError::content(place, "must have a URI or a buffer view")),
    }
}

pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(&KTX2_IDENTIFIER)
}

/// The size of an image, and the bytes of a texel.
pub(super) struct Extent {
    pub size: Size,
    pub bytes_each: u64,
    /// Bytes of a texel while it is decoded, apart from those of its values.
    pub decoding: u64,
}

/// The extent of an encoded image.
pub(super) fn extent(bytes: &[u8], number: u32) -> Result<Extent, SceneError> {
    if is_ktx2(bytes) {
        return Ok(Extent { size: ktx2_size(bytes, number)?, bytes_each: 4, decoding: DECODING });
    }
    let header = image::decode_header(bytes);
    let image::Header { size, channels, depth, decoding_bytes, .. } =
        header.map_err(|reason| SceneError::Image { index: number as usize, reason })?;
    let bytes_each = (channels.count() * depth.bytes()) as u64;
    let decoding = decoding_bytes.div_ceil(size.texels() as u64).saturating_sub(bytes_each);
    Ok(Extent { size, bytes_each, decoding })
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
    use uvgraft_image::{Format, WriteOptions};

    use super::*;

    #[test]
    fn the_colour_space_of_an_image_is_ignored() {
        let values = Texels::U8(vec![128, 10, 200]);
        let size = Size::new(1, 1);
        let texture = Texture::new(size, Channels::Rgb, Encoding::Srgb, values).unwrap();
        let mut out = Cursor::new(Vec::new());
        let written =
            image::encode(&texture.clone().into(), Format::PNG, &WriteOptions::default(), &mut out);
        let _ = written.unwrap();
        let (header, rest) = out.get_ref().split_at(33);
        // A gAMA chunk of linear light.
        let gamma = b"\0\0\0\x04gAMA\0\x01\x86\xa0\x31\xe8\x96\x5f";
        let bytes = [header, gamma, rest].concat();
        assert_eq!(decode(&bytes, 0).unwrap(), texture);
        assert_ne!(image::decode(&bytes).unwrap().texture, texture);
    }
}
