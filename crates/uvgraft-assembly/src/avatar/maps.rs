//! Maps other than the colours, transferred onto a body and added to its materials.

use uvgraft::{
    Averaging, Channels, Content, Depth, Encoding, Filter, NormalOptions, NormalY, Size, Texels,
    TexelsMut, Texture,
};
use uvgraft_files::input::Input;
use uvgraft_gltf::glb::{AvatarMaterial, EmbedError, EmbeddedFormat, EmbeddedImage, ShadingModel};
use uvgraft_image as image;
use uvgraft_pipeline::{BaseSource, Blame, Failure, Result};

use super::map_transfer::{MapTransfer, TransferredMap};
use super::materials::{MapRequest, MapRole, ROUGHNESS};
use super::request::MaterialOptions;

/// The maps of one material.
#[derive(Default)]
struct Set {
    normal: Option<Texture>,
    emissive: Option<Texture>,
    occlusion: Option<Texture>,
    roughness: Option<Texture>,
    metallic: Option<Texture>,
    orm: Option<Texture>,
}

/// The maps in the body's layout, and in the head's own if it keeps that.
#[derive(Default)]
pub(super) struct TransferredMaps {
    body: Set,
    head: Set,
}

impl MaterialOptions {
    /// Transfers all maps.
    ///
    /// - `size`: of maps whose base is a constant.
    pub(super) fn transfer(
        &self,
        map_transfer: &MapTransfer<'_>,
        size: Size,
    ) -> Result<TransferredMaps> {
        let mut maps = TransferredMaps { body: Set::default(), head: Set::default() };
        for map in self.requested() {
            let TransferredMap { body, head } = self.transfer_map(&map, map_transfer, size)?;
            maps.body.put(map.role, body);
            if let Some(head) = head {
                maps.head.put(map.role, head);
            }
        }
        Ok(maps)
    }

    fn transfer_map(
        &self,
        map: &MapRequest<'_>,
        map_transfer: &MapTransfer<'_>,
        size: Size,
    ) -> Result<TransferredMap> {
        let is_color = map.role == MapRole::Emissive;
        let encoding = if is_color { Encoding::Srgb } else { Encoding::Data };
        let read = |input: &Input| -> Result<Texture> {
            let texture = image::read_with(input, encoding.into()).or_input()?.texture;
            if map.role == MapRole::Normal && !texture.channels().has_color() {
                return Err(Failure::input(format!(
                    "{input}: a normal map must have three channels, got a greyscale image"
                )));
            }
            let channels = texture.channels().without_alpha();
            let depth = texture.depth();
            let texture = texture.converted(channels, depth);
            Ok(if is_color { texture } else { texture.with_encoding(Encoding::Data) })
        };
        let filled = |color: &[f32]| {
            Texture::filled(map_transfer.limited(size), Channels::Rgb, encoding, Depth::U8, color)
        };
        let base = match map.onto {
            Some(BaseSource::Image(image)) => {
                let base = read(image)?;
                let size = map_transfer.limited(base.size());
                let base = base.resized(size, Filter::Bilinear, Averaging::Encoded).or_input()?;
                if map.role == MapRole::Normal { self.upward(base) } else { base }
            }
            Some(BaseSource::Color(color)) => filled(&color[..3]).or_input()?,
            None => filled(&map.role.nothing()).or_input()?,
        };
        let content = match map.role {
            MapRole::Normal => Content::Normals(NormalOptions::new(self.normal_y, NormalY::OpenGl)),
            MapRole::Emissive => Content::Color,
            _ => Content::Data,
        };
        let face = map.face.map(read).transpose()?;
        map_transfer.transfer(face, base, content)
    }

    /// A normal map of the body, converted to green up.
    fn upward(&self, mut texture: Texture) -> Texture {
        if self.normal_y == NormalY::OpenGl {
            return texture;
        }
        let channels = texture.channels().count();
        match texture.texels_mut() {
            TexelsMut::U8(values) => {
                values.chunks_exact_mut(channels).for_each(|texel| texel[1] = u8::MAX - texel[1]);
            }
            TexelsMut::U16(values) => {
                values.chunks_exact_mut(channels).for_each(|texel| texel[1] = u16::MAX - texel[1]);
            }
            TexelsMut::F32(values) => {
                values.chunks_exact_mut(channels).for_each(|texel| texel[1] = 1.0 - texel[1]);
            }
        }
        texture
    }
}

impl Set {
    fn put(&mut self, role: MapRole, texture: Texture) {
        let place = match role {
            MapRole::Normal => &mut self.normal,
            MapRole::Roughness => &mut self.roughness,
            MapRole::Metallic => &mut self.metallic,
            MapRole::Occlusion => &mut self.occlusion,
            MapRole::Orm => &mut self.orm,
            MapRole::Emissive => &mut self.emissive,
        };
        *place = Some(texture);
    }

    /// Puts the maps into a material.
    fn add_to(
        self,
        looks: &mut AvatarMaterial,
        how: &Encoder,
    ) -> std::result::Result<(), EmbedError> {
        looks.normal = self.normal.map(|map| how.data(rgb(map))).transpose()?;
        looks.emissive = self.emissive.map(|map| how.color(rgb(map))).transpose()?;
        let has_occlusion = self.occlusion.is_some() || self.orm.is_some();
        let is_packed = self.roughness.is_some() || self.metallic.is_some() || self.orm.is_some();
        if is_packed {
            let packed = match self.orm {
                Some(orm) => rgb(orm),
                None => packed([
                    (self.occlusion, 1.0),
                    (self.roughness, ROUGHNESS),
                    (self.metallic, 0.0),
                ])?,
            };
            let picture = how.data(packed)?;
            // Factors are multiplied with the texture.
            (looks.roughness_factor, looks.metallic_factor) = (1.0, 1.0);
            looks.occlusion = has_occlusion.then(|| picture.clone());
            looks.roughness = Some(picture);
        } else {
            looks.occlusion = self.occlusion.map(|map| how.data(grey(map))).transpose()?;
        }
        Ok(())
    }
}

impl TransferredMaps {
    /// Builds the materials: the body's, then the head's own, if it has one.
    pub(super) fn looks(
        self,
        colors: (Texture, Option<Texture>),
        how: &Encoder,
    ) -> std::result::Result<Vec<AvatarMaterial>, EmbedError> {
        let style = how.style;
        let mut body = AvatarMaterial { style, ..AvatarMaterial::new(how.color(colors.0)?) };
        self.body.add_to(&mut body, how)?;
        let mut all = vec![body];
        if let Some(color) = colors.1 {
            let color = how.color(color)?;
            let mut head = AvatarMaterial {
                style,
                is_head: true,
                name: "head".to_owned(),
                ..AvatarMaterial::new(color)
            };
            self.head.add_to(&mut head, how)?;
            all.push(head);
        }
        Ok(all)
    }
}

/// How textures are encoded.
pub(super) struct Encoder {
    pub(super) format: EmbeddedFormat,
    pub(super) quality: u8,
    pub(super) style: ShadingModel,
}

impl Encoder {
    fn color(&self, texture: Texture) -> std::result::Result<EmbeddedImage, EmbedError> {
        EmbeddedImage::encode(texture, self.format, self.quality)
    }

    /// The blocks of a JPEG would show in highlights, so data maps are stored as PNG instead.
    fn data(&self, texture: Texture) -> std::result::Result<EmbeddedImage, EmbedError> {
        let format = match self.format {
            EmbeddedFormat::Jpeg => EmbeddedFormat::Png,
            other => other,
        };
        EmbeddedImage::encode(texture.with_encoding(Encoding::Data), format, self.quality)
    }
}

fn rgb(texture: Texture) -> Texture {
    texture.converted(Channels::Rgb, Depth::U8)
}

fn grey(texture: Texture) -> Texture {
    texture.converted(Channels::Grey, Depth::U8)
}

/// Packs three maps into the channels of one, at the size of the largest.
///
/// - `maps`: each with its default value.
fn packed(maps: [(Option<Texture>, f32); 3]) -> std::result::Result<Texture, EmbedError> {
    let sizes = maps.iter().filter_map(|(map, _)| Some(map.as_ref()?.size()));
    let size = sizes.max_by_key(|size| size.texels()).unwrap_or(Size::square(1));
    let mut values = vec![0_u8; 3 * size.texels()];
    for (channel, (map, missing)) in maps.into_iter().enumerate() {
        let map = match map {
            Some(map) => grey(map).resized(size, Filter::Bilinear, Averaging::Encoded)?,
            None => Texture::filled(size, Channels::Grey, Encoding::Data, Depth::U8, &[missing])?,
        };
        let Texels::U8(levels) = map.texels() else { continue };
        for (texel, &level) in values.chunks_exact_mut(3).zip(levels) {
            texel[channel] = level;
        }
    }
    Ok(Texture::new(size, Channels::Rgb, Encoding::Data, Texels::U8(values))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_packed_into_the_largest() {
        let filled = |side, level: f32| {
            let size = Size::square(side);
            Texture::filled(size, Channels::Grey, Encoding::Data, Depth::U8, &[level]).unwrap()
        };
        let both = packed([(None, 1.0), (Some(filled(4, 0.6)), 0.7), (Some(filled(8, 0.2)), 0.0)]);
        let both = both.unwrap();
        assert_eq!((both.size(), both.encoding()), (Size::square(8), Encoding::Data));
        let texel = [0, 1, 2].map(|channel| (255.0 * both.get(3, 5, channel)).round());
        assert_eq!(texel, [255.0, 153.0, 51.0]);
    }
}
