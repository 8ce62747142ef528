//! One picture: visibility first, then colours, pixel by pixel.

use glam::Vec3;
use uvgraft::{Channels, Encoding, Size, Texels, Texture, Value, threads};
use uvgraft_gltf::scene::AlphaMode;

use super::camera::{Camera, Homogeneous};
use super::cutouts::{Cutouts, ShadowCasters};
use super::depth::{BAND, DepthMap, Drawing};
use super::encode::{Encoder, decode};
use super::floor::Floor;
use super::geometry::Geometry;
use super::layers::Layers;
use super::lights::{Lights, backdrop};
use super::mipmap::Mipmap;
use super::occlusion::occlusion;
use super::options::{Background, RenderOptions};
use super::patches::{Patches, full};
use super::projection::project;
use super::samples::Samples;
use super::shader::Shader;
use super::shadow::Shadow;
use super::surface::Surface;
use super::tangents::{Tangent, tangents};

/// Everything that determines a pixel's colour.
pub(super) struct Frame<'a> {
    surfaces: &'a [Surface],
    mipmaps: &'a [Mipmap],
    geometry: Geometry,
    homogeneous: Vec<Homogeneous>,
    /// Empty if no surface has a normal map.
    tangents: Vec<Tangent>,
    camera: Camera,
    options: RenderOptions,
    size: Size,
    opaque: Drawing,
    translucent: Drawing,
    light: Option<Lighting>,
}

/// State that only lit pictures need.
struct Lighting {
    lights: Lights,
    shadow: Shadow,
    /// For each pixel, the visible fraction of the sky (ambient occlusion).
    occlusion: Vec<f32>,
    floor: Option<Floor>,
}

/// A colour in linear light multiplied by its alpha, and the alpha.
type Premultiplied = [f32; 4];

/// Memory for one band of rows.
#[derive(Default)]
struct Buffers {
    opaque: Samples,
    layers: Layers,
    patches: Patches,
}

impl<'a> Frame<'a> {
    /// - `camera`: for the supersampled picture, `options.samples` samples along each
    ///   side of a pixel.
    pub fn new(
        surfaces: &'a [Surface],
        mipmaps: &'a [Mipmap],
        geometry: Geometry,
        camera: Camera,
        options: RenderOptions,
        size: Size,
    ) -> Self {
        let fine = Size::new(size.width * options.samples, size.height * options.samples);
        let homogeneous = camera.all_homogeneous(&geometry.positions);
        let faces_us = |face: usize| {
            let surface = &surfaces[geometry.faces[face].surface as usize];
            surface.material.double_sided || {
                let [a, ..] = geometry.corners(face);
                geometry.normal_of(face).dot(camera.towards_from(a)) > 0.0
            }
        };
        let is_blended = |face: usize| {
            surfaces[geometry.faces[face].surface as usize].material.alpha == AlphaMode::Blend
        };
        let visible = |blended: bool| {
            let keep = |face: usize| is_blended(face) == blended && faces_us(face);
            Drawing::new(project(&camera, &geometry, &homogeneous, fine, keep), fine)
        };
        let (opaque, translucent) = (visible(false), visible(true));
        let light = options.lit.then(|| {
            let casters = ShadowCasters { surfaces, mipmaps, geometry: &geometry };
            let holes = Cutouts {
                surfaces,
                mipmaps,
                geometry: &geometry,
                homogeneous: &homogeneous,
                blended: None,
            };
            // For occlusion, two samples along each side of a pixel are enough.
            let step = options.samples / 2;
            let depths = DepthMap::new(&opaque, step, camera.limits().1, &holes);
            Lighting::new(&camera, step, &casters, &depths, options.floor, size)
        });
        let tangents = if options.lit { tangents(&geometry, surfaces) } else { Vec::new() };
        Self {
            surfaces,
            mipmaps,
            geometry,
            homogeneous,
            tangents,
            camera,
            options,
            size,
            opaque,
            translucent,
            light,
        }
    }

    pub fn picture(&self) -> Texture {
        let transparent = self.options.background == Background::Transparent;
        let channels = if transparent { Channels::Rgba } else { Channels::Rgb };
        let width = self.size.width as usize;
        let mut texels = vec![0_u8; self.size.texels() * channels.count()];
        let row = width * channels.count();
        // A band of samples at a time: all that is known of them fits into a processor's cache.
        let rows = (BAND / self.options.samples) as usize;
        let bands = texels.chunks_mut(row * rows);
        threads::for_each_with(bands, Buffers::default, |buffers, band, texels| {
            self.draw(band, buffers);
            for (y, texels) in texels.chunks_exact_mut(row).enumerate() {
                let y = (band * rows + y) as u32;
                self.row(y, texels, channels, buffers);
            }
        });
        Texture::new(self.size, channels, Encoding::Srgb, Texels::U8(texels))
            .expect("the buffer was made for this size")
    }

    fn draw(&self, band: usize, buffers: &mut Buffers) {
        let Self { surfaces, mipmaps, geometry, homogeneous, .. } = self;
        let holes = Cutouts { surfaces, mipmaps, geometry, homogeneous, blended: None };
        let least = self.camera.limits().1;
        buffers.opaque.draw(&self.opaque, band, least, &holes);
        buffers.layers.draw(&self.translucent, band, least, &buffers.opaque);
    }

    fn row(&self, y: u32, texels: &mut [u8], channels: Channels, buffers: &mut Buffers) {
        let Buffers { opaque, layers, patches } = buffers;
        let (samples, encoder) = (self.options.samples, Encoder::new());
        let shader = self.shader();
        let pixels =
            |columns: std::ops::Range<u32>| columns.start / samples..columns.end.div_ceil(samples);
        let (solid, layered) = (pixels(opaque.columns()), pixels(layers.columns()));
        for (x, texel) in (0..).zip(texels.chunks_exact_mut(channels.count())) {
            let (left, top) = (x * samples, y * samples);
            let mut rows = top..top + samples;
            let has_layers = layered.contains(&x) && rows.any(|row| layers.any(left, row, samples));
            let over = has_layers.then_some(&*layers);
            if solid.contains(&x) || has_layers {
                patches.find(&self.geometry, opaque, over, (left, top), samples);
                if !patches.patches.is_empty() {
                    let pixel = (y * self.size.width + x) as usize;
                    let open = self.light.as_ref().map_or(1.0, |light| light.occlusion[pixel]);
                    for patch in &mut patches.patches {
                        patch.color = shader.color(patch, (x, y), open);
                    }
                    let color = self.pixel((x, y), over, patches);
                    put(texel, color, encoder);
                    continue;
                }
            }
            self.put_background(texel, (x, y), encoder);
        }
    }

    fn shader(&self) -> Shader<'_> {
        let Self { surfaces, mipmaps, geometry, homogeneous, tangents, camera, .. } = self;
        let light = self.light.as_ref().map(|light| (&light.lights, &light.shadow));
        let samples = self.options.samples;
        Shader { surfaces, mipmaps, geometry, homogeneous, tangents, camera, samples, light }
    }

    /// The mean of a pixel's samples: the opaque surface or background, with translucent layers
    /// composited over it from back to front (premultiplied "over", Porter and Duff 1984).
    fn pixel(
        &self,
        (x, y): (u32, u32),
        layers: Option<&Layers>,
        patches: &Patches,
    ) -> Premultiplied {
        let samples = self.options.samples;
        let mut sum = [0.0; 4];
        let mut add = |color: Premultiplied, count: u32| {
            let share = count as f32 / (samples * samples) as f32;
            sum = [0, 1, 2, 3].map(|k| sum[k] + color[k] * share);
        };
        let Some(layers) = layers else {
            let mut covered = 0;
            for patch in &patches.patches {
                add(patch.color, patch.mask.count_ones());
                covered |= patch.mask;
            }
            let rest = (full(samples) & !covered).count_ones();
            if rest > 0 {
                add(self.behind((x, y)), rest);
            }
            return sum;
        };
        let mut behind = None;
        for stack in &patches.stacks {
            let mut color = patches
                .color_of(stack.last)
                .unwrap_or_else(|| *behind.get_or_insert_with(|| self.behind((x, y))));
            for face in layers.over(stack.at.0, stack.at.1) {
                let Some(over) = patches.color_of(face) else { continue };
                color = [0, 1, 2, 3].map(|k| over[k] + color[k] * (1.0 - over[3]));
            }
            add(color, stack.mask.count_ones());
        }
        sum
    }

    /// The background, sRGB, and the brightness that the floor's shadow leaves it.
    fn background(&self, (x, y): (u32, u32)) -> ([f32; 3], f32) {
        let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
        let samples = self.options.samples as f32;
        let floor = self.light.as_ref().and_then(|light| light.floor.as_ref());
        let brightness = floor
            .map_or(1.0, |floor| floor.brightness(&self.camera.ray(px * samples, py * samples)));
        let (width, height) = (self.size.width as f32, self.size.height as f32);
        let color = match self.options.background {
            Background::Studio => backdrop(px / width, py / height),
            Background::Plain(color) => color.map(Value::to_unit),
            Background::Transparent => [0.0; 3],
        };
        (color, brightness)
    }

    fn behind(&self, pixel: (u32, u32)) -> Premultiplied {
        let (color, brightness) = self.background(pixel);
        if self.options.background == Background::Transparent {
            return [0.0, 0.0, 0.0, 1.0 - brightness];
        }
        let [r, g, b] = color.map(|value| decode(value) * brightness);
        [r, g, b, 1.0]
    }

    fn put_background(&self, texel: &mut [u8], pixel: (u32, u32), encoder: Encoder) {
        let (color, brightness) = self.background(pixel);
        if brightness == 1.0 && texel.len() == 3 {
            // Without a detour through linear light.
            texel.copy_from_slice(&color.map(u8::from_unit));
        } else {
            put(texel, self.behind(pixel), encoder);
        }
    }
}

fn put(texel: &mut [u8], color: Premultiplied, encoder: Encoder) {
    let alpha = color[3].clamp(0.0, 1.0);
    let factor = if alpha > 0.0 { 1.0 / alpha } else { 0.0 };
    for (value, premultiplied) in texel.iter_mut().zip(&color[..3]) {
        *value = encoder.encode(premultiplied * factor);
    }
    if let Some(opacity) = texel.get_mut(3) {
        *opacity = u8::from_unit(alpha);
    }
}

impl Lighting {
    /// - `step`: distance between the samples in `depths`, in samples of the camera.
    fn new(
        camera: &Camera,
        step: u32,
        casters: &ShadowCasters<'_>,
        depths: &DepthMap,
        floor: Option<f32>,
        size: Size,
    ) -> Self {
        let geometry = casters.geometry;
        let (low, high) = geometry.bounds();
        let (centre, radius) = (low.lerp_monotonic(high, 0.5), 0.5 * (high - low).length());
        // Files are in metres. If the radius is not that of a person (0.1 to 4 m), the scene is
        // taken for a scale model of one, and its radius for a metre.
        let metre = if (0.1..4.0).contains(&radius) { 1.0 } else { radius.max(1e-6) };
        let (seen, extent) = camera.seen_around(centre);
        let pixel = 2.0 * extent / size.width.max(size.height) as f32;
        // Margin for shadow casters outside the picture, and for scenes deeper than wide.
        let extent = 1.6 * extent;
        let seen = if extent < radius { (seen, extent) } else { (centre, radius) };
        let lights = Lights::new(camera);
        let shadow = Shadow::new(casters, lights.key, seen, pixel, metre);
        let floor = floor.map(|height| {
            // The floor needs the whole shadow, whatever part of the scene is in the picture.
            let up = Vec3 { x: 0.0, y: 1.0, z: 0.0 };
            let whole = (seen.1 < radius).then(|| {
                let (all, cell) = ((centre, radius), Floor::cell((low, high)));
                Shadow::new(casters, lights.key, all, cell, metre)
            });
            let shadow = whole.as_ref().unwrap_or(&shadow);
            Floor::new(geometry, height, metre, |p| shadow.lit(p, up, 0.0))
        });
        Self { lights, shadow, occlusion: occlusion(depths, camera, step, metre, size), floor }
    }
}
