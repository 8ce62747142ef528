//! The thumbnail of an avatar.

use uvgraft::{Averaging, Filter, Size, Texture};
use uvgraft_avatar::Avatar;
use uvgraft_gltf::glb::{AvatarMaterial, EmbeddedFormat, EmbeddedImage, ShadingModel};
use uvgraft_pipeline::Observer;
use uvgraft_render::thumbnail;

/// Side of the thumbnail: enough for lists, and drawn in some tenths of a second.
const SIDE: u32 = 512;
const JPEG_QUALITY: u8 = 88;

/// Textures for drawing the thumbnail, reduced to the detail that it shows.
pub(super) struct Colors(Vec<EmbeddedImage>);

impl Colors {
    /// - `textures`: the colours of each material.
    pub(super) fn new<'t>(textures: impl IntoIterator<Item = &'t Texture>) -> Self {
        const LARGEST: u32 = 2048;
        let picture = |texture: &Texture| {
            let Size { width, height } = texture.size();
            let longest = width.max(height);
            let scaled = |side: u32| {
                (side.min((u64::from(side) * u64::from(LARGEST) / u64::from(longest)) as u32))
                    .max(1)
            };
            let size = Size::new(scaled(width), scaled(height));
            let smaller =
                texture.clone().resized(size, Filter::Bilinear, Averaging::Encoded).ok()?;
            EmbeddedImage::encode(smaller, EmbeddedFormat::Jpeg, 95).ok()
        };
        Self(textures.into_iter().filter_map(picture).collect())
    }

    /// Draws the head of an avatar. A missing thumbnail is only a warning.
    ///
    /// - `looks`: the avatar's materials.
    pub(super) fn thumbnail(
        self,
        avatar: &Avatar,
        looks: &[AvatarMaterial],
        observer: &dyn Observer,
    ) -> Option<EmbeddedImage> {
        let looks: Vec<AvatarMaterial> = looks
            .iter()
            .zip(self.0)
            .map(|(looks, color)| {
                // Lighting shows the shape even where readers have none.
                let style = if looks.style == ShadingModel::Unlit {
                    ShadingModel::Unlit
                } else {
                    ShadingModel::Pbr
                };
                AvatarMaterial { style, ..AvatarMaterial::new(color) }
            })
            .collect();
        let drawn = thumbnail(avatar, &looks, SIDE).map_err(|error| error.to_string());
        let encoded = drawn.and_then(|picture| {
            EmbeddedImage::encode(picture, EmbeddedFormat::Jpeg, JPEG_QUALITY)
                .map_err(|error| error.to_string())
        });
        encoded.map_err(|error| observer.warn(format_args!("no thumbnail: {error}"))).ok()
    }
}
