//! The material with its textures, and the extensions that their formats need.

use super::buffer::Buffer;
use super::json::{
    CLAMP_TO_EDGE, Image, LINEAR, LINEAR_MIPMAP_LINEAR, Material, Pbr, REPEAT, Sampler, Texture,
    TextureExtensions, TextureInfo, TextureSource,
};
use super::looks::{Looks, Picture, PictureFormat};
use super::vertices::Vertices;

pub(super) struct Written {
    pub material: Material,
    pub textures: Vec<Texture>,
    pub images: Vec<Image>,
    pub samplers: Vec<Sampler>,
    pub image_bytes: usize,
    /// Their names, and whether readers must know them.
    pub extensions: Vec<(&'static str, bool)>,
}

struct Writer<'a> {
    buffer: &'a mut Buffer,
    textures: Vec<Texture>,
    images: Vec<Image>,
    image_bytes: usize,
    extensions: Vec<(&'static str, bool)>,
}

/// Appends the images, and makes a material of them.
pub(super) fn write(looks: &Looks, vertices: &Vertices, buffer: &mut Buffer) -> Written {
    let mut writer = Writer {
        buffer,
        textures: Vec::new(),
        images: Vec::new(),
        image_bytes: 0,
        extensions: Vec::new(),
    };
    let base_color_texture = writer.texture("color", &looks.color);
    let normal_texture = looks.normal.as_ref().map(|picture| writer.texture("normal", picture));
    let roughness = looks.roughness.as_ref().map(|picture| writer.texture("roughness", picture));
    // Beyond its edges a texture only goes on where the layout does.
    let inside = vertices.uv.as_flattened().iter().all(|value| (0.0..=1.0).contains(value));
    let wrap = if inside { CLAMP_TO_EDGE } else { REPEAT };
    let (mag_filter, min_filter) = (LINEAR, LINEAR_MIPMAP_LINEAR);
    Written {
        material: Material {
            name: looks.name.clone(),
            pbr_metallic_roughness: Pbr {
                base_color_texture,
                metallic_factor: looks.metallic_factor,
                roughness_factor: looks.roughness_factor,
                metallic_roughness_texture: roughness,
            },
            normal_texture,
            double_sided: looks.double_sided,
        },
        textures: writer.textures,
        images: writer.images,
        samplers: vec![Sampler { mag_filter, min_filter, wrap_s: wrap, wrap_t: wrap }],
        image_bytes: writer.image_bytes,
        extensions: writer.extensions,
    }
}

impl Writer<'_> {
    fn texture(&mut self, name: &str, picture: &Picture) -> TextureInfo {
        let own = self.image(name, picture);
        let fallback = picture.fallback().map(|fallback| self.image(name, fallback));
        let source = TextureSource { source: own };
        let is_required = fallback.is_none();
        let (source, extensions) = match picture.format() {
            PictureFormat::Png | PictureFormat::Jpeg => (Some(own), None),
            PictureFormat::WebP => {
                self.extension("EXT_texture_webp", is_required);
                (fallback, Some(TextureExtensions::WebP(source)))
            }
            PictureFormat::Ktx2 => {
                self.extension("KHR_texture_basisu", is_required);
                (fallback, Some(TextureExtensions::Ktx2(source)))
            }
        };
        self.textures.push(Texture { sampler: 0, source, extensions });
        TextureInfo { index: self.textures.len() - 1 }
    }

    fn image(&mut self, name: &str, picture: &Picture) -> usize {
        let buffer_view = self.buffer.view(picture.bytes(), None);
        let mime_type = picture.format().mime_type();
        self.images.push(Image { name: name.to_owned(), mime_type, buffer_view });
        self.image_bytes += picture.bytes().len();
        self.images.len() - 1
    }

    fn extension(&mut self, name: &'static str, is_required: bool) {
        match self.extensions.iter_mut().find(|(known, _)| *known == name) {
            Some((_, required)) => *required |= is_required,
            None => self.extensions.push((name, is_required)),
        }
    }
}
