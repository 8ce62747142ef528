//! Materials with their textures and images, and the extensions they need.

use super::buffer::Buffer;
use super::embed_error::EmbeddedFormat;
use super::embedded_image::EmbeddedImage;
use super::json::{
    CLAMP_TO_EDGE, Image, LINEAR, LINEAR_MIPMAP_LINEAR, Material, MaterialExtensions, Pbr, REPEAT,
    Sampler, Texture, TextureExtensions, TextureInfo, TextureSource, Unlit,
};
use super::material::{AvatarMaterial, ShadingModel};
use super::mtoon;

const UNLIT: &str = "KHR_materials_unlit";

#[derive(Default)]
pub(super) struct Written {
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub images: Vec<Image>,
    pub samplers: Vec<Sampler>,
    /// Index of the thumbnail in `images`.
    pub thumbnail: Option<usize>,
    pub image_bytes: usize,
    /// Names of extensions, and whether they are required.
    pub extensions: Vec<(&'static str, bool)>,
}

struct Writer<'a> {
    buffer: &'a mut Buffer,
    written: Written,
}

/// Appends the images and builds the materials.
///
/// - `is_inside`: whether all UV coordinates are within the unit square.
pub(super) fn write(
    materials: &[AvatarMaterial],
    is_inside: bool,
    thumbnail: Option<&EmbeddedImage>,
    buffer: &mut Buffer,
) -> Written {
    let mut writer = Writer { buffer, written: Written::default() };
    let materials = materials.iter().map(|material| writer.material(material)).collect();
    // Textures repeat only if the layout leaves the unit square.
    let wrap = if is_inside { CLAMP_TO_EDGE } else { REPEAT };
    let (mag_filter, min_filter) = (LINEAR, LINEAR_MIPMAP_LINEAR);
    Written {
        materials,
        thumbnail: thumbnail.map(|picture| writer.image("thumbnail", picture)),
        samplers: vec![Sampler { mag_filter, min_filter, wrap_s: wrap, wrap_t: wrap }],
        ..writer.written
    }
}

impl Writer<'_> {
    /// Converts a material, and adds its textures, images and extensions.
    fn material(&mut self, material: &AvatarMaterial) -> Material {
        let base_color_texture = self.texture("color", &material.color);
        let mut texture = |name, picture: &Option<EmbeddedImage>| {
            picture.as_ref().map(|picture| self.texture(name, picture))
        };
        let normal_texture = texture("normal", &material.normal);
        let metallic_roughness_texture = texture("roughness", &material.roughness);
        let occlusion_texture = match metallic_roughness_texture {
            Some(both) if material.occlusion == material.roughness => Some(both),
            _ => texture("occlusion", &material.occlusion),
        };
        let emissive_texture = texture("emissive", &material.emissive);
        // One extension at most: the validator warns about materials with two, and lit
        // materials are an equally good fallback.
        let extensions = match material.style {
            ShadingModel::Pbr => None,
            ShadingModel::Unlit => {
                self.extension(UNLIT, false);
                Some(MaterialExtensions { unlit: Some(Unlit {}), mtoon: None })
            }
            ShadingModel::MToon => {
                self.extension(mtoon::EXTENSION, false);
                let mtoon = Some(mtoon::material(base_color_texture));
                Some(MaterialExtensions { unlit: None, mtoon })
            }
        };
        Material {
            name: material.name.clone(),
            pbr_metallic_roughness: Pbr {
                base_color_texture,
                metallic_factor: material.metallic_factor,
                roughness_factor: material.roughness_factor,
                metallic_roughness_texture,
            },
            normal_texture,
            occlusion_texture,
            emissive_texture,
            emissive_factor: emissive_texture.map(|_| [1.0; 3]),
            double_sided: material.double_sided,
            extensions,
        }
    }

    fn texture(&mut self, name: &str, picture: &EmbeddedImage) -> TextureInfo {
        let own = self.image(name, picture);
        let source = TextureSource { source: own };
        let (source, extensions) = match picture.format() {
            EmbeddedFormat::Png | EmbeddedFormat::Jpeg => (Some(own), None),
            EmbeddedFormat::WebP => {
                self.extension("EXT_texture_webp", true);
                (None, Some(TextureExtensions::WebP(source)))
            }
            EmbeddedFormat::Ktx2 => {
                self.extension("KHR_texture_basisu", true);
                (None, Some(TextureExtensions::Ktx2(source)))
            }
        };
        let textures = &mut self.written.textures;
        textures.push(Texture { sampler: 0, source, extensions });
        TextureInfo { index: textures.len() - 1 }
    }

    fn image(&mut self, name: &str, picture: &EmbeddedImage) -> usize {
        let buffer_view = self.buffer.view(picture.bytes(), None);
        let mime_type = picture.format().mime_type();
        self.written.image_bytes += picture.bytes().len();
        let images = &mut self.written.images;
        images.push(Image { name: name.to_owned(), mime_type, buffer_view });
        images.len() - 1
    }

    fn extension(&mut self, name: &'static str, is_required: bool) {
        let extensions = &mut self.written.extensions;
        match extensions.iter_mut().find(|(known, _)| *known == name) {
            Some((_, required)) => *required |= is_required,
            None => extensions.push((name, is_required)),
        }
    }
}
