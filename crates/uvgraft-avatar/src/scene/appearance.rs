//! Materials and their textures: what a surface looks like.

use std::borrow::Cow;

use uvgraft::Texture;
use uvgraft_io::image;

use super::accessor::{Accessors, find};
use super::container::{Container, too_many};
use super::document;
use super::error::SceneError;

/// Texels of all images together.
const MAX_TEXELS: u64 = 1 << 28;

/// How a surface looks: the part of glTF's materials that is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Its name. `skin`, `eye`, `hair` and `leather` are lit as such.
    pub name: String,
    /// Linear colour and opacity; multiplies the texture.
    pub color: [f32; 4],
    /// What is spread over the surface.
    pub texture: Option<TextureUse>,
    /// What opacity means.
    pub alpha: Alpha,
    /// Whether it is seen from behind too.
    pub double_sided: bool,
    /// Whether it has its colour whatever the light.
    pub unlit: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            color: [1.0; 4],
            texture: None,
            alpha: Alpha::Opaque,
            double_sided: false,
            unlit: false,
        }
    }
}

/// A texture and how it goes on beyond its edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextureUse {
    /// Its number among the scene's textures.
    pub index: usize,
    /// To the sides, and up and down.
    pub wrap: [Wrap; 2],
    /// Whether enlarged texels are squares.
    pub nearest: bool,
}

/// How a texture goes on beyond its edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// From its start again.
    #[default]
    Repeat,
    /// Back and forth.
    Mirror,
    /// With the colour at the edge.
    Clamp,
}

/// What opacity means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Alpha {
    /// Nothing.
    Opaque,
    /// There is no surface where it is below this.
    Mask(f32),
    /// The share of what is seen.
    Blend,
}

/// Where a material has its texture coordinates.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct UvSource {
    pub set: u32,
    transform: Option<document::TextureTransform>,
}

impl UvSource {
    /// # Source
    /// Khronos, "KHR_texture_transform": scaled, then turned, then moved.
    pub fn transform(&self, uv: &mut [[f32; 2]]) {
        let Some(transform) = self.transform else { return };
        let (sin, cos) = transform.rotation.sin_cos();
        let ([sx, sy], [dx, dy]) = (transform.scale.unwrap_or([1.0; 2]), transform.offset);
        for uv in uv {
            let (u, v) = (uv[0] * sx, uv[1] * sy);
            *uv = [cos * u + sin * v + dx, cos * v - sin * u + dy];
        }
    }
}

/// Materials, one more than the file has: the last is for what has none.
pub(super) struct Appearance {
    pub materials: Vec<Material>,
    pub uv_sources: Vec<UvSource>,
    pub textures: Vec<Texture>,
}

pub(super) fn appearance(
    container: &Container<'_>,
    accessors: &Accessors<'_>,
) -> Result<Appearance, SceneError> {
    let document = &container.document;
    let mut images = Images { numbers: Vec::new(), encoded: Vec::new(), texels: 0 };
    let (mut materials, mut uv_sources) = (Vec::new(), Vec::new());
    for (index, material) in document.materials.iter().enumerate() {
        let place = format!("material {index}");
        let pbr = &material.pbr_metallic_roughness;
        let color = pbr.base_color_factor.unwrap_or([1.0; 4]);
        let cutoff = material.alpha_cutoff.unwrap_or(0.5);
        if !color.iter().chain([&cutoff]).all(|value| value.is_finite()) {
            return Err(SceneError::content(place, "a number is infinite, wanted finite ones"));
        }
        let mut uv_source = UvSource::default();
        let mut texture = None;
        if let Some(info) = &pbr.base_color_texture {
            uv_source.set = info.tex_coord;
            uv_source.transform = info.extensions.transform;
            if let Some(transform) = info.extensions.transform {
                uv_source.set = transform.tex_coord.unwrap_or(info.tex_coord);
                let [a, b] = transform.offset;
                let [c, d] = transform.scale.unwrap_or([1.0; 2]);
                if ![a, b, c, d, transform.rotation].iter().all(|value| value.is_finite()) {
                    let reason = "its texture's transform is infinite, wanted finite numbers";
                    return Err(SceneError::content(place, reason));
                }
            }
            texture = images.use_of(info.index, &place, container, accessors)?;
        }
        let alpha = match material.alpha_mode.as_deref() {
            None | Some("OPAQUE") => Alpha::Opaque,
            Some("MASK") => Alpha::Mask(cutoff),
            Some("BLEND") => Alpha::Blend,
            Some(other) => {
                let reason =
                    format!("found the alpha mode {other:?}, wanted OPAQUE, MASK or BLEND");
                return Err(SceneError::content(place, reason));
            }
        };
        materials.push(Material {
            name: material.name.clone().unwrap_or_default(),
            color,
            texture,
            alpha,
            double_sided: material.double_sided,
            unlit: material.extensions.unlit.is_some(),
        });
        uv_sources.push(uv_source);
    }
    materials.push(Material::default());
    uv_sources.push(UvSource::default());
    Ok(Appearance { materials, uv_sources, textures: images.decode()? })
}

/// Those of the file's images that are seen.
struct Images<'a> {
    /// Their numbers in the file.
    numbers: Vec<u32>,
    encoded: Vec<Cow<'a, [u8]>>,
    texels: u64,
}

impl<'a> Images<'a> {
    fn use_of(
        &mut self,
        texture: u32,
        place: &str,
        container: &Container<'a>,
        accessors: &Accessors<'a>,
    ) -> Result<Option<TextureUse>, SceneError> {
        let document = &container.document;
        let texture = find(&document.textures, texture, "texture", place)?;
        let webp = texture.extensions.webp.as_ref().map(|webp| webp.source);
        let Some(image) = webp.or(texture.source) else {
            if texture.extensions.basisu.is_some() {
                return Err(SceneError::Extension("KHR_texture_basisu".to_owned()));
            }
            return Ok(None);
        };
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
            None => self.add(image, place, container, accessors)?,
        };
        Ok(Some(TextureUse {
            index,
            wrap: [wrap(sampler.wrap_s), wrap(sampler.wrap_t)],
            nearest: sampler.mag_filter == Some(9728),
        }))
    }

    fn add(
        &mut self,
        number: u32,
        place: &str,
        container: &Container<'a>,
        accessors: &Accessors<'a>,
    ) -> Result<usize, SceneError> {
        let image = find(&container.document.images, number, "image", place)?;
        let place = format!("image {number}");
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => {
                container.resource(uri).map_err(|why| SceneError::content(place, why))?
            }
            (None, Some(view)) => Cow::Borrowed(accessors.view(view, &place)?.0),
            (None, None) => {
                return Err(SceneError::content(place, "it has neither a URI nor a buffer view"));
            }
        };
        let index = number as usize;
        let header =
            image::decode_header(&bytes).map_err(|reason| SceneError::Image { index, reason })?;
        self.texels += header.size.texels() as u64;
        too_many("texels of images", self.texels, MAX_TEXELS)?;
        self.numbers.push(number);
        self.encoded.push(bytes);
        Ok(self.numbers.len() - 1)
    }

    fn decode(self) -> Result<Vec<Texture>, SceneError> {
        let each = self.numbers.into_iter().zip(self.encoded);
        each.map(|(number, bytes)| {
            let index = number as usize;
            let image = image::decode(&bytes);
            image.map(|image| image.texture).map_err(|reason| SceneError::Image { index, reason })
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texture_is_scaled_then_turned_then_moved() {
        let transform = document::TextureTransform {
            offset: [0.1, 0.2],
            rotation: std::f32::consts::FRAC_PI_2,
            scale: Some([2.0, 3.0]),
            tex_coord: None,
        };
        let mut uv = [[0.25, 0.5]];
        UvSource { set: 0, transform: Some(transform) }.transform(&mut uv);
        // (0.5, 1.5) turned by a quarter is (1.5, -0.5).
        assert!((uv[0][0] - 1.6).abs() < 1e-6 && (uv[0][1] + 0.3).abs() < 1e-6, "{uv:?}");
    }
}
