//! One picture: visibility first, then colours, pixel by pixel.

use glam::Vec3;
use uvgraft::color::{linear_from_srgb, srgb_from_linear};
use uvgraft::{Channels, Encoding, Size, Texels, Texture, Value, threads};
use uvgraft_gltf::scene::AlphaMode;

use super::camera::{Camera, Homogeneous};
use super::floor::Floor;
use super::geometry::Geometry;
use super::layers::Layers;
use super::lights::{Lights, backdrop};
use super::mipmap::{Footprint, Mipmap};
use super::options::{Background, RenderOptions};
use super::projection::{Projected, project, weights};
use super::shading::Paint;
use super::surface::{Lookup, Surface};
use super::tangents::{Tangent, bumped, tangents};
use super::visibility::{BAND, DepthBuffer, EMPTY, bands};

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
    opaque: DepthBuffer,
    /// Blended triangles, and the indices of those that touch each band of rows.
    translucent: Vec<Projected>,
    bands: Vec<Vec<u32>>,
    light: Option<Lighting>,
}

/// State that only lit pictures need.
struct Lighting {
    lights: Lights,
    /// For each pixel, the visible fraction of the sky (ambient occlusion).
    occlusion: Vec<f32>,
    floor: Option<Floor>,
}

/// A colour in linear light multiplied by its alpha, and the alpha.
type Premultiplied = [f32; 4];

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
        let homogeneous = threads::map_indices(geometry.positions.len(), |vertex| {
            camera.homogeneous(geometry.positions[vertex])
        });
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
            project(&camera, &geometry.positions, &geometry.faces, fine, keep)
        };
        let (solid, translucent) = (visible(false), visible(true));
        let least = camera.limits().1;
        let is_there = |face: u32, x: u32, y: u32| {
            let surface = &surfaces[geometry.faces[face as usize].surface as usize];
            let AlphaMode::Mask(cutoff) = surface.material.alpha else { return true };
            let at = [x as f32 + 0.5, y as f32 + 0.5];
            let Some(point) = Point::new(&geometry, &homogeneous, face, at, 1.0) else {
                return false;
            };
            point.color(&geometry, surface, mipmaps)[3] >= cutoff
        };
        let opaque = DepthBuffer::new(&solid, fine, least, is_there);
        let light = options.lit.then(|| {
            let casts = |face: usize| !is_blended(face);
            Lighting::new(&camera, &geometry, casts, &opaque, options.floor, size)
        });
        let bands = bands(&translucent, fine.height);
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
            bands,
            light,
        }
    }

    pub fn picture(&self) -> Texture {
        let transparent = self.options.background == Background::Transparent;
        let channels = if transparent { Channels::Rgba } else { Channels::Rgb };
        let width = self.size.width as usize;
        let mut texels = vec![0_u8; self.size.texels() * channels.count()];
        // One chunk has as many rows as a band of samples, so that each chunk needs
        // one set of layers.
        let rows = (BAND / self.options.samples) as usize;
        threads::for_each_chunk(&mut texels, width * channels.count() * rows, |band, texels| {
            let layers = self.layers(band);
            let mut shades = Vec::new();
            for (index, texel) in texels.chunks_exact_mut(channels.count()).enumerate() {
                let (x, y) = (index % width, band * rows + index / width);
                let color = self.pixel(x as u32, y as u32, layers.as_ref(), &mut shades);
                let alpha = color[3].clamp(0.0, 1.0);
                for (value, premultiplied) in texel.iter_mut().zip(&color[..3]) {
                    let linear = if alpha > 0.0 { premultiplied / alpha } else { 0.0 };
                    *value = u8::from_unit(srgb_from_linear(linear));
                }
                if let Some(opacity) = texel.get_mut(3) {
                    *opacity = u8::from_unit(alpha);
                }
            }
        });
        Texture::new(self.size, channels, Encoding::Srgb, Texels::U8(texels))
            .expect("the buffer was made for this size")
    }

    /// The translucent layers of a band of rows; `None` if nothing translucent touches it.
    fn layers(&self, band: usize) -> Option<Layers> {
        let indices = self.bands.get(band).filter(|indices| !indices.is_empty())?;
        let height = self.size.height * self.options.samples;
        let first = band as u32 * BAND;
        let width = self.size.width as usize * self.options.samples as usize;
        let rows = first..(first + BAND).min(height);
        let least = self.camera.limits().1;
        Some(Layers::new(&self.translucent, indices.iter(), &self.opaque, least, rows, width))
    }

    /// The mean of a pixel's samples: the opaque surface or background, with translucent layers
    /// composited over it from back to front (premultiplied "over", Porter and Duff 1984).
    ///
    /// Each quarter of a pixel is shaded once for each face that shows in it, not once for each
    /// sample: edges are antialiased by visibility, textures by their footprint.
    fn pixel(
        &self,
        x: u32,
        y: u32,
        layers: Option<&Layers>,
        shades: &mut Vec<Shade>,
    ) -> Premultiplied {
        let samples = self.options.samples;
        let half = samples / 2;
        let mut behind = None;
        let mut sum = [0.0; 4];
        for quarter in 0..4 {
            let left = x * samples + quarter % 2 * half;
            let top = y * samples + quarter / 2 * half;
            let inside = (0..half * half).map(|k| (left + k % half, top + k / half));
            self.shade(inside.clone(), layers, (x, y), shades);
            for (sx, sy) in inside {
                let find = |face: u32| shades.iter().find(|shade| shade.face == face);
                let face = self.opaque.face(sx, sy);
                let mut color = match find(face) {
                    Some(shade) => shade.color,
                    None => *behind.get_or_insert_with(|| self.behind(x, y)),
                };
                for face in layers.into_iter().flat_map(|layers| layers.over(sx, sy)) {
                    let Some(shade) = find(face) else { continue };
                    let rest = 1.0 - shade.color[3];
                    color = [0, 1, 2, 3].map(|k| shade.color[k] + color[k] * rest);
                }
                for (sum, value) in sum.iter_mut().zip(color) {
                    *sum += value / (samples * samples) as f32;
                }
            }
        }
        sum
    }

    /// Shades every face that shows in these samples, once each, at the centroid of the samples
    /// that show it.
    fn shade(
        &self,
        samples: impl Iterator<Item = (u32, u32)>,
        layers: Option<&Layers>,
        pixel: (u32, u32),
        shades: &mut Vec<Shade>,
    ) {
        shades.clear();
        for (x, y) in samples {
            let mut show = |face: u32| {
                let at = [x as f32 + 0.5, y as f32 + 0.5];
                match shades.iter_mut().find(|shade| shade.face == face) {
                    Some(shade) => {
                        shade.at = [shade.at[0] + at[0], shade.at[1] + at[1]];
                        shade.count += 1.0;
                    }
                    None => shades.push(Shade { face, at, count: 1.0, color: [0.0; 4] }),
                }
            };
            let face = self.opaque.face(x, y);
            if face != EMPTY {
                show(face);
            }
            if let Some(layers) = layers {
                layers.over(x, y).for_each(show);
            }
        }
        for shade in shades {
            let at = shade.at.map(|sum| sum / shade.count);
            shade.color = self.surface_color(shade.face, at, pixel);
        }
    }

    fn surface_color(&self, face: u32, at: [f32; 2], (x, y): (u32, u32)) -> Premultiplied {
        let corners = self.geometry.faces[face as usize];
        let surface = &self.surfaces[corners.surface as usize];
        // The texture footprint is a quarter of a pixel.
        let step = f64::from(self.options.samples / 2);
        let Some(point) = Point::new(&self.geometry, &self.homogeneous, face, at, step) else {
            return [0.0; 4];
        };
        let [r, g, b, a] = point.color(&self.geometry, surface, self.mipmaps);
        let albedo = [r, g, b];
        let footprint = |coordinates| point.footprint(&self.geometry, coordinates);
        let lookup = Lookup { mipmaps: self.mipmaps, footprint: &footprint };
        let alpha =
            if surface.material.alpha == AlphaMode::Blend { a.clamp(0.0, 1.0) } else { 1.0 };
        let [r, g, b] = match &self.light {
            Some(light) if !surface.material.unlit => {
                let position = point.mixed(corners.vertices, &self.geometry.positions);
                let towards = self.camera.towards_from(position);
                let mut normal = point.mixed(corners.vertices, &self.geometry.normals);
                if let Some(bump) = surface.bump(&lookup) {
                    let tangent = point.tangent(corners.vertices, &self.tangents);
                    normal = bumped(bump, normal.normalize_or_zero(), tangent);
                }
                // Vertex normals point out of the front of a face. Seen from the back,
                // they are flipped.
                if self.geometry.normal_of(face as usize).dot(towards) < 0.0 {
                    normal = -normal;
                }
                let mut normal = normal.normalize_or_zero();
                // Interpolated normals may still face away from the camera near silhouettes: bend
                // them back.
                if normal.dot(towards) < 0.0 {
                    normal = (normal - towards * (1.02 * normal.dot(towards))).normalize_or_zero();
                }
                let open = light.occlusion[(y * self.size.width + x) as usize];
                let open = open * surface.openness(&lookup);
                let glint = surface.glint(&lookup);
                let paint = Paint { shading: surface.shading, albedo, glint };
                let shaded = light.lights.shade(&paint, position, normal, towards, open);
                let glow = surface.glow(&lookup);
                [0, 1, 2].map(|k| shaded[k] + glow[k])
            }
            _ => albedo,
        };
        [r * alpha, g * alpha, b * alpha, alpha]
    }

    /// The background and the floor's shadow on it.
    fn behind(&self, x: u32, y: u32) -> Premultiplied {
        let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
        let samples = self.options.samples as f32;
        let floor = self.light.as_ref().and_then(|light| light.floor.as_ref());
        let brightness = floor
            .map_or(1.0, |floor| floor.brightness(&self.camera.ray(px * samples, py * samples)));
        let (width, height) = (self.size.width as f32, self.size.height as f32);
        let color = match self.options.background {
            Background::Studio => backdrop(px / width, py / height),
            Background::Plain(color) => color.map(Value::to_unit),
            Background::Transparent => return [0.0, 0.0, 0.0, 1.0 - brightness],
        };
        let [r, g, b] = color.map(|value| linear_from_srgb(value) * brightness);
        [r, g, b, 1.0]
    }
}

/// The colour of a face within a quarter of a pixel.
struct Shade {
    face: u32,
    /// Sum of the positions of the samples that show it, and their number.
    at: [f32; 2],
    count: f32,
    color: Premultiplied,
}

impl Lighting {
    fn new(
        camera: &Camera,
        geometry: &Geometry,
        casts: impl Fn(usize) -> bool + Sync,
        opaque: &DepthBuffer,
        floor: Option<f32>,
        size: Size,
    ) -> Self {
        let (low, high) = geometry.bounds();
        let (centre, radius) = (low.lerp_monotonic(high, 0.5), 0.5 * (high - low).length());
        // Files are in metres. If the radius is not that of a person (0.1 to 4 m), the scene is
        // taken for a scale model of one, and its radius for a metre.
        let metre = if (0.1..4.0).contains(&radius) { 1.0 } else { radius.max(1e-6) };
        let (seen, extent) = camera.seen_around(centre);
        // Margin for shadow casters outside the picture, and for scenes deeper than wide.
        let extent = 1.6 * extent;
        let seen = if extent < radius { (seen, extent) } else { (centre, radius) };
        let lights = Lights::new(camera, geometry, &casts, seen, metre);
        let floor = floor.map(|height| {
            // The floor needs the whole shadow, whatever part of the scene is in the picture.
            let up = Vec3 { x: 0.0, y: 1.0, z: 0.0 };
            let whole = if seen.1 < radius {
                Some(Lights::new(camera, geometry, &casts, (centre, radius), metre))
            } else {
                None
            };
            let lights = whole.as_ref().unwrap_or(&lights);
            Floor::new(geometry, height, metre, |p| lights.lit(p, up))
        });
        Self { lights, occlusion: opaque.occlusion(camera, metre, size), floor }
    }
}

/// A visible point of a face, with its barycentric weights.
struct Point {
    face: u32,
    weights: [f32; 3],
    /// Weights one step to the right, and one step down.
    shifted: [[f32; 3]; 2],
}

impl Point {
    /// - `step`: width of the texture footprint, in samples.
    fn new(
        geometry: &Geometry,
        homogeneous: &[Homogeneous],
        face: u32,
        at: [f32; 2],
        step: f64,
    ) -> Option<Self> {
        let corners =
            geometry.faces[face as usize].vertices.map(|vertex| homogeneous[vertex as usize]);
        let [x, y] = at.map(f64::from);
        let here = weights(corners, x, y)?;
        let shifted = [(step, 0.0), (0.0, step)];
        // Beyond the face's horizon the weights belong to a point behind the camera. Exactly on it
        // they are not finite: the footprint then has no extent in that direction.
        let shifted = shifted.map(|(dx, dy)| weights(corners, x + dx, y + dy).unwrap_or(here));
        Some(Self { face, weights: here, shifted })
    }

    fn mixed(&self, vertices: [u32; 3], values: &[Vec3]) -> Vec3 {
        let [a, b, c] = vertices.map(|vertex| values[vertex as usize]);
        a * self.weights[0] + b * self.weights[1] + c * self.weights[2]
    }

    fn tangent(&self, vertices: [u32; 3], tangents: &[Tangent]) -> Tangent {
        let [a, b, c] = vertices.map(|vertex| tangents[vertex as usize]);
        let weights = self.weights;
        // Handedness is not interpolated: where corners differ, the first one's is used.
        (a.0 * weights[0] + b.0 * weights[1] + c.0 * weights[2], a.1)
    }

    /// The footprint in the texture.
    fn footprint(&self, geometry: &Geometry, coordinates: usize) -> Footprint {
        let corners = geometry.corner_uv(self.face as usize, coordinates);
        let uv = |weights: [f32; 3]| {
            [0, 1].map(|k| (0..3).map(|corner| weights[corner] * corners[corner][k]).sum::<f32>())
        };
        let here = uv(self.weights);
        let along = self.shifted.map(|weights| {
            let there = uv(weights);
            [there[0] - here[0], there[1] - here[1]]
        });
        Footprint { uv: here, along_x: along[0], along_y: along[1] }
    }

    /// Linear colour and alpha of a surface.
    fn color(&self, geometry: &Geometry, surface: &Surface, mipmaps: &[Mipmap]) -> [f32; 4] {
        let footprint = |coordinates| self.footprint(geometry, coordinates);
        let mut color = surface.albedo(&Lookup { mipmaps, footprint: &footprint });
        if !geometry.colors.is_empty() {
            let face = geometry.faces[self.face as usize];
            let corners = face.vertices.map(|vertex| geometry.colors[vertex as usize]);
            for (k, value) in color.iter_mut().enumerate() {
                *value *= (0..3).map(|at| self.weights[at] * corners[at][k]).sum::<f32>();
            }
        }
        color
    }
}
