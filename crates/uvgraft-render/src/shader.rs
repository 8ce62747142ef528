//! The colour of a patch of a pixel.
//!
//! Position, shadow and occlusion are evaluated once for a patch, and so is light, unless the surface
//! bends within the pixel so much that a highlight could fall between. Textures are sampled in each
//! quarter of the pixel, unless they are magnified.

use glam::Vec3;
use uvgraft_gltf::scene::AlphaMode;

use super::camera::{Camera, Homogeneous};
use super::geometry::Geometry;
use super::lights::Lights;
use super::mipmap::Mipmap;
use super::patches::{Patch, Tap, taps};
use super::point::Point;
use super::shading::{Glint, Paint};
use super::shadow::Shadow;
use super::surface::{Lookup, Surface};
use super::tangents::{Tangent, bumped};

/// What a patch's colour depends on.
pub(crate) struct Shader<'a> {
    pub surfaces: &'a [Surface],
    pub mipmaps: &'a [Mipmap],
    pub geometry: &'a Geometry,
    pub homogeneous: &'a [Homogeneous],
    /// Empty if no surface has a normal map.
    pub tangents: &'a [Tangent],
    pub camera: &'a Camera,
    /// Samples along each side of a pixel.
    pub samples: u32,
    /// `None` in unlit pictures.
    pub light: Option<(&'a Lights, &'a Shadow)>,
}

/// How often a patch is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Effort {
    /// Textures and light are as good as constant.
    Once,
    /// Textures in each quarter of the pixel, light once for their mean.
    Textures,
    /// Light in each quarter, too.
    Light,
}

impl Effort {
    /// - `lookup`: over all of the pixel.
    /// - `lit`: whether light plays a part.
    fn needed(surface: &Surface, lookup: &Lookup<'_>, lit: bool) -> Self {
        // A lobe `cos^n` falls by half over an angle of `1.2 / √n`.
        let bends = lit && lookup.point.bend() * surface.sharpness() > 1.0;
        let bumps = lit && surface.material.normal.is_some();
        if !bends && surface.is_smooth(lookup) {
            Self::Once
        } else if bends || bumps {
            Self::Light
        } else {
            Self::Textures
        }
    }
}

/// Values of a surface's textures.
#[derive(Debug, Clone, Copy, Default)]
struct Sampled {
    /// Multiplied by alpha if it is blended.
    color: [f32; 3],
    alpha: f32,
    glow: [f32; 3],
    open: f32,
    /// Specular colour and glossiness.
    gloss: [f32; 4],
}

impl Sampled {
    fn add(&mut self, other: &Self, share: f32) {
        let add = |sum: &mut [f32], values: &[f32]| {
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value * share);
        };
        add(&mut self.color, &other.color);
        add(&mut self.glow, &other.glow);
        add(&mut self.gloss, &other.gloss);
        self.alpha += other.alpha * share;
        self.open += other.open * share;
    }
}

impl Shader<'_> {
    /// A patch's colour in linear light multiplied by its alpha, and the alpha.
    ///
    /// - `pixel`: the pixel's column and row.
    /// - `open`: the fraction of the sky that nearby geometry leaves visible.
    pub fn color(&self, patch: &Patch, pixel: (u32, u32), open: f32) -> [f32; 4] {
        let surface = &self.surfaces[self.geometry.faces[patch.face as usize].surface as usize];
        let (centre, taps, count) = taps(patch.mask, self.samples);
        let corner = [pixel.0, pixel.1].map(|at| f64::from(at * self.samples));
        let at = [0, 1].map(|k| corner[k] + centre[k]);
        // The texture footprint is a quarter of a pixel.
        let step = f64::from(self.samples / 2);
        let point = Point::new(self.geometry, self.homogeneous, patch.face, at, step);
        let Some((point, around)) = point else { return [0.0; 4] };
        let whole = point.scaled(2.0);
        let lit = self.light.filter(|_| !surface.material.unlit);
        let effort = Effort::needed(surface, &self.lookup(&whole), lit.is_some());
        let only = [Tap { offset: [0.0; 2], share: 1.0 }];
        let taps = if effort == Effort::Once { &only[..] } else { &taps[..count] };
        let points = taps
            .iter()
            .map(|tap| (point.moved(around.at(tap.offset).unwrap_or_default()), tap.share));
        let Some((lights, shadow)) = lit else {
            let mut sum = [0.0; 4];
            for (point, share) in points {
                let Sampled { color: [r, g, b], alpha, .. } =
                    self.unlit(surface, &self.lookup(&point));
                let color = [r, g, b, alpha];
                sum = [0, 1, 2, 3].map(|k| sum[k] + color[k] * share);
            }
            return sum;
        };
        let scene = Lit::new(self, lights, shadow, &point, open);
        let mut result = [0.0; 4];
        if effort == Effort::Light {
            for (point, share) in points {
                let color = scene.color(surface, &point, &self.sampled(surface, &point));
                result = [0, 1, 2, 3].map(|k| result[k] + color[k] * share);
            }
        } else {
            let mut mean = Sampled::default();
            for (point, share) in points {
                mean.add(&self.sampled(surface, &point), share);
            }
            result = scene.color(surface, &point, &mean);
        }
        result
    }

    /// The values that unlit surfaces need.
    fn unlit(&self, surface: &Surface, lookup: &Lookup<'_>) -> Sampled {
        let [r, g, b, a] = surface.color(lookup);
        if surface.material.alpha == AlphaMode::Blend {
            let alpha = a.clamp(0.0, 1.0);
            return Sampled { color: [r, g, b].map(|v| v * alpha), alpha, ..Sampled::default() };
        }
        Sampled { color: [r, g, b], alpha: 1.0, ..Sampled::default() }
    }

    fn sampled(&self, surface: &Surface, point: &Point<'_>) -> Sampled {
        let lookup = self.lookup(point);
        Sampled {
            glow: surface.glow(&lookup),
            open: surface.openness(&lookup),
            gloss: surface.gloss(&lookup).unwrap_or_default(),
            ..self.unlit(surface, &lookup)
        }
    }

    fn lookup<'a>(&'a self, point: &'a Point<'a>) -> Lookup<'a> {
        Lookup { mipmaps: self.mipmaps, point }
    }
}

/// Light on a patch.
struct Lit<'a> {
    shader: &'a Shader<'a>,
    lights: &'a Lights,
    towards: Vec3,
    /// The fraction of the key light that reaches it.
    lit: f32,
    open: f32,
    is_back: bool,
}

impl<'a> Lit<'a> {
    fn new(
        shader: &'a Shader<'a>,
        lights: &'a Lights,
        shadow: &Shadow,
        point: &Point<'_>,
        open: f32,
    ) -> Self {
        let (camera, position) = (shader.camera, point.position());
        let towards = camera.towards_from(position);
        let is_back = shader.geometry.normal_of(point.face as usize).dot(towards) < 0.0;
        let normal = facing(point.normal().normalize_or_zero(), is_back, towards);
        let width = camera.unit_per_px_at(position) * shader.samples as f32;
        let lit = shadow.lit(position, normal, width);
        Self { shader, lights, towards, lit, open, is_back }
    }

    fn color(&self, surface: &Surface, point: &Point<'_>, sampled: &Sampled) -> [f32; 4] {
        let Self { shader, towards, .. } = *self;
        let mut normal = point.normal().normalize_or_zero();
        if let Some(bump) = surface.bump(&shader.lookup(point)) {
            normal = bumped(bump, normal, point.tangent(shader.tangents));
        }
        let normal = facing(normal, self.is_back, towards);
        let Sampled { color, alpha, glow, gloss: [r, g, b, glossiness], .. } = *sampled;
        let albedo = if alpha > 0.0 { color.map(|value| value / alpha) } else { color };
        let glint = surface.material.gloss.map(|_| Glint::new([r, g, b], glossiness));
        let paint = Paint { shading: surface.shading, albedo, glint };
        let open = self.open * sampled.open;
        let shaded = self.lights.shade(&paint, self.lit, normal, towards, open);
        let [r, g, b] = [0, 1, 2].map(|k| (shaded[k] + glow[k]) * alpha);
        [r, g, b, alpha]
    }
}

/// The normal of the side that is seen.
fn facing(normal: Vec3, is_back: bool, towards: Vec3) -> Vec3 {
    // Vertex normals point out of the front of a face. Seen from the back, they are flipped.
    let normal = if is_back { -normal } else { normal };
    // Interpolated normals may still face away from the camera near silhouettes: bend them back.
    let away = normal.dot(towards);
    if away < 0.0 { (normal - towards * (1.02 * away)).normalize_or_zero() } else { normal }
}

#[cfg(test)]
mod tests {
    use glam::vec3;
    use uvgraft::{Channels, Encoding, Size, Texels, Texture};
    use uvgraft_gltf::scene::{
        Material, PosedPrimitive, ScaledTexture, SpecularGloss, TextureUse, Wrap,
    };

    use super::*;
    use crate::Renderer;
    use crate::surface::NeededMipmaps;
    use crate::tests::{ahead, square};

    const TEXTURE: TextureUse =
        TextureUse { index: 0, wrap: [Wrap::Clamp; 2], nearest: false, coordinates: 0 };

    fn effort(material: &Material, piece: &PosedPrimitive, side: u32, lit: bool) -> Effort {
        let surface = Surface::new(material, 1, &mut NeededMipmaps::default());
        let surfaces = [surface];
        let texels = Texels::U8(vec![7; (side * side) as usize]);
        let texture =
            Texture::new(Size::square(side), Channels::Grey, Encoding::Srgb, texels).unwrap();
        // One for colours, one for data.
        let mipmaps = [Mipmap::new(&texture), Mipmap::new(&texture)];
        let geometry = Geometry::of_primitives(std::slice::from_ref(piece), &surfaces);
        let camera = Camera::perspective(&ahead(), Size::square(400));
        let homogeneous = camera.all_homogeneous(&geometry.positions);
        let (point, _) = Point::new(&geometry, &homogeneous, 0, [250.0, 210.0], 4.0).unwrap();
        Effort::needed(&surfaces[0], &Lookup { mipmaps: &mipmaps, point: &point }, lit)
    }

    /// The square of 3600 samples a side, with texture coordinates, and normals that turn by about
    /// twice `turn` from left to right.
    fn bent(turn: f32) -> PosedPrimitive {
        let uv = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        let normals = [-turn, turn, turn, -turn].map(|x| vec3(x, 0.0, 1.0).into()).to_vec();
        PosedPrimitive { uv: uv.into(), normals, ..square(0.0, 0) }
    }

    #[test]
    fn what_varies_within_a_pixel_is_evaluated_in_its_quarters() {
        use Effort::{Light, Once, Textures};
        let plain = Material { texture: Some(TEXTURE), ..Material::default() };
        let normal = Some(ScaledTexture { texture: TEXTURE, scale: 1.0 });
        let bumpy = Material { normal, ..plain.clone() };
        let nearest = Some(TextureUse { nearest: true, ..TEXTURE });
        let blocky = Material { texture: nearest, ..plain.clone() };
        let gloss = SpecularGloss { specular: [0.5; 3], glossiness: 0.8, texture: None };
        let glossy = Material { gloss: Some(gloss), ..plain.clone() };
        // A pixel is 4 samples wide: a 900th of the square.
        for (name, material, turn, side, lit, wanted) in [
            ("flat and magnified", &plain, 0.0, 800, true, Once),
            ("minified", &plain, 0.0, 1000, true, Textures),
            ("minified and unlit", &plain, 0.0, 1000, false, Textures),
            ("with texels as squares", &blocky, 0.0, 8, true, Textures),
            ("a magnified normal map", &bumpy, 0.0, 800, true, Once),
            ("a minified normal map", &bumpy, 0.0, 1000, true, Light),
            ("an unlit normal map", &bumpy, 0.0, 1000, false, Textures),
            // The exponent is 8: the normal has to change by 0.35, which is 2 / 900 of the turn.
            ("hardly bent", &plain, 150.0, 800, true, Once),
            ("bent", &plain, 170.0, 800, true, Light),
            ("bent, but unlit", &plain, 170.0, 800, false, Once),
            // The exponent is 1248: 0.028.
            ("glossy and hardly bent", &glossy, 12.0, 800, true, Once),
            ("glossy and bent", &glossy, 13.5, 800, true, Light),
        ] {
            assert_eq!(effort(material, &bent(turn), side, lit), wanted, "{name}");
        }
    }

    #[test]
    fn highlights_between_the_centres_of_pixels_are_seen() {
        let gloss = SpecularGloss { specular: [0.9; 3], glossiness: 0.6, texture: None };
        let material =
            Material { color: [0.1, 0.1, 0.1, 1.0], gloss: Some(gloss), ..Material::default() };
        let renderer = Renderer::new(&[material], &[]);
        let light = |size: Size| {
            let options = crate::RenderOptions::default();
            let picture = renderer.render(&[bent(4.0)], &ahead(), &options, size);
            let texels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
            let light = texels.map(|(x, y)| uvgraft::color::linear_from_srgb(picture.get(x, y, 1)));
            light.sum::<f32>() / size.texels() as f32
        };
        // Few pixels, across which the normal turns by a right angle, against many.
        let (coarse, fine) = (light(Size::square(2)), light(Size::square(128)));
        assert!((coarse / fine - 1.0).abs() < 0.12, "{coarse} {fine}");
    }
}
