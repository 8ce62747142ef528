//! Taking a photograph.

use glam::DVec3;
use uvgraft::color::{linear_from_srgb, srgb_from_linear};
use uvgraft::{Channels, Encoding, Mesh, Size, Texels, Texture, threads};

use super::camera::Pinhole;
use super::subject::{Content, Subject};
use super::visible::{NOTHING, Visible, weights};
use crate::pictures::hashed;

/// Samples along each side of a pixel; odd, so that one is in its middle.
const SAMPLES: u32 = 3;

/// Light in linear space: the same from everywhere, and from one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Of each channel, from everywhere.
    pub ambient: [f64; 3],
    /// Of each channel, on what faces it.
    pub sun: [f64; 3],
    /// Towards it, in the head's space.
    pub towards: DVec3,
}

impl Light {
    /// From everywhere alike, a little dimmer than a texture and a little warm.
    pub const EVEN: Self =
        Self { ambient: [0.9, 0.86, 0.8], sun: [0.0; 3], towards: DVec3::new(0.0, 0.0, 1.0) };

    /// A window beside and above the face.
    pub const WINDOW: Self =
        Self { ambient: [0.45; 3], sun: [0.55, 0.53, 0.48], towards: DVec3::new(0.5, 0.45, 0.74) };

    /// A lamp from one side.
    pub const LAMP: Self =
        Self { ambient: [0.28; 3], sun: [0.75, 0.7, 0.6], towards: DVec3::new(0.84, 0.3, 0.45) };

    fn on(&self, normal: DVec3) -> [f64; 3] {
        let facing = normal.dot(self.towards.normalize()).max(0.0);
        [0, 1, 2].map(|k| self.ambient[k] + self.sun[k] * facing)
    }
}

/// How a photograph is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shot {
    /// Size of the picture.
    pub size: Size,
    /// Angles of the head in degrees; see [`Pinhole::facing`].
    pub angles: [f64; 3],
    /// Focal length as a share of the longer side.
    pub focal: f64,
    /// Distance of the eyes along the optical axis, in metres.
    pub distance: f64,
    /// Where the eyes are, relative to the centre, as shares of width and height.
    pub offset: [f64; 2],
    /// The light.
    pub light: Light,
    /// Seed of background and noise.
    pub seed: u32,
}

impl Shot {
    /// A portrait from the front, by a telephone at arm's length. The figure's face has as many
    /// pixels as texels in a texture of 600².
    pub const PORTRAIT: Self = Self {
        size: Size::new(810, 1080),
        angles: [0.0; 3],
        focal: 1.2,
        distance: 0.55,
        offset: [0.0, -0.06],
        light: Light::EVEN,
        seed: 1,
    };

    /// The same from another side.
    #[must_use]
    pub const fn turned(self, yaw: f64, pitch: f64, roll: f64) -> Self {
        Self { angles: [yaw, pitch, roll], ..self }
    }

    /// Shots around the head, from as far to the side as faces are found.
    pub fn nine(self) -> [Self; 9] {
        const ANGLES: [[f64; 3]; 9] = [
            [0.0, 0.0, 0.0],
            [-15.0, 0.0, 3.0],
            [15.0, 0.0, -3.0],
            [-30.0, 2.0, 0.0],
            [30.0, 2.0, 0.0],
            [-36.0, 0.0, 0.0],
            [36.0, 0.0, 0.0],
            [0.0, 14.0, 0.0],
            [0.0, -12.0, 0.0],
        ];
        let mut seed = self.seed;
        ANGLES.map(|[yaw, pitch, roll]| {
            seed += 1;
            Self { seed, ..self.turned(yaw, pitch, roll) }
        })
    }

    /// The camera that sees a point of the head where the shot asks for it.
    pub fn camera(&self, middle: DVec3) -> Pinhole {
        let [width, height] = [self.size.width, self.size.height].map(f64::from);
        let [yaw, pitch, roll] = self.angles;
        let rotation = Pinhole::facing(yaw, pitch, roll);
        let focal_px = self.focal * width.max(height);
        let [x, y] = [self.offset[0] * width, self.offset[1] * height];
        let at = DVec3::new(x / focal_px, y / focal_px, 1.0) * self.distance;
        let center_px = [width / 2.0, height / 2.0];
        Pinhole { rotation, translation: at - rotation * middle, focal_px, center_px }
    }

    /// Photographs a subject.
    pub fn take(&self, subject: &Subject) -> Photograph {
        let camera = self.camera(subject.middle.into());
        let mut layers = vec![Layer::new(&subject.head, &subject.texture, &camera)];
        let body = subject.body.iter();
        layers.extend(body.map(|(mesh, texture)| Layer::new(mesh, texture, &camera)));
        let fine = Size::new(self.size.width * SAMPLES, self.size.height * SAMPLES);
        let mut visible = Visible::new(fine);
        let mut first = 0;
        for layer in &mut layers {
            layer.first = first;
            for (face, corners) in (first..).zip(&layer.corners) {
                visible.draw(face, *corners);
            }
            first += layer.corners.len() as u32;
        }
        let pixels = threads::map_indices(self.size.texels(), |pixel| {
            let (x, y) = (pixel as u32 % self.size.width, pixel as u32 / self.size.width);
            self.pixel(&layers, &visible, x, y)
        });
        let picture = Texels::U8(pixels.into_iter().flatten().collect());
        let picture = Texture::new(self.size, Channels::Rgb, Encoding::Srgb, picture)
            .expect("as many values as pixels");
        let middle = |pixel: usize| {
            let (x, y) = (pixel as u32 % self.size.width, pixel as u32 / self.size.width);
            ((y * SAMPLES + SAMPLES / 2) * fine.width + x * SAMPLES + SAMPLES / 2) as usize
        };
        let content = |pixel: usize| {
            let face = visible.faces[middle(pixel)];
            let Some(layer) = layers.iter().rfind(|layer| face >= layer.first) else {
                return Content::Background;
            };
            match (face, layer.first) {
                (NOTHING, _) => Content::Background,
                (_, 0) => {
                    let (x, y) = (pixel as u32 % self.size.width, pixel as u32 / self.size.width);
                    let uv = layer.uv(face, x * SAMPLES + 1, y * SAMPLES + 1);
                    subject.content[texel_at(subject.texture.size(), uv)]
                }
                _ => Content::Cloth,
            }
        };
        let count = self.size.texels();
        let content = (0..count).map(content).collect();
        let depths = (0..count).map(|pixel| visible.depths[middle(pixel)]).collect();
        Photograph { picture, camera, content, depths }
    }

    fn pixel(&self, layers: &[Layer<'_>], visible: &Visible, x: u32, y: u32) -> [u8; 3] {
        let mut sum = [0.0; 3];
        for sample in 0..SAMPLES * SAMPLES {
            let (fx, fy) = (x * SAMPLES + sample % SAMPLES, y * SAMPLES + sample / SAMPLES);
            let face = visible.faces[(fy * visible.size.width + fx) as usize];
            let color = match layers.iter().rfind(|layer| face >= layer.first) {
                Some(layer) if face != NOTHING => {
                    let (albedo, normal) = layer.surface(face, fx, fy);
                    let light = self.light.on(normal);
                    [0, 1, 2].map(|k| f64::from(albedo[k]) * light[k])
                }
                _ => self.background(x, y),
            };
            (0..3).for_each(|k| sum[k] += color[k] / f64::from(SAMPLES * SAMPLES));
        }
        [0, 1, 2].map(|k| {
            let noise = hashed(x.into(), y.into(), k, self.seed) as u32 as f32 / u32::MAX as f32;
            let level = 255.0 * srgb_from_linear(sum[k as usize] as f32) + 3.0 * (noise - 0.5);
            (level + 0.5).clamp(0.0, 255.0) as u8
        })
    }

    /// Blotches of many colours, linear.
    fn background(&self, x: u32, y: u32) -> [f64; 3] {
        const CELL: i64 = 48;
        let (x, y) = (i64::from(x), i64::from(y));
        let value = |column: i64, row: i64, channel: i64| {
            f64::from(hashed(column, row, channel, self.seed + 7) as u32) / f64::from(u32::MAX)
        };
        let (s, t) = ((x % CELL) as f64 / CELL as f64, (y % CELL) as f64 / CELL as f64);
        let (column, row) = (x / CELL, y / CELL);
        [0, 1, 2].map(|k| {
            let upper = value(column, row, k) * (1.0 - s) + value(column + 1, row, k) * s;
            let lower = value(column, row + 1, k) * (1.0 - s) + value(column + 1, row + 1, k) * s;
            0.1 + 0.5 * (upper * (1.0 - t) + lower * t) + 0.1 * value(x, y, k)
        })
    }
}

/// A photograph, and what is known of it.
#[derive(Debug, Clone)]
pub struct Photograph {
    /// RGB, 8-bit sRGB.
    pub picture: Texture,
    /// Its camera.
    pub camera: Pinhole,
    /// `[pixels]`: what is in the middle of each.
    pub content: Vec<Content>,
    /// `[pixels]`: distance along the optical axis in the middle of each; infinite beside the head.
    pub depths: Vec<f32>,
}

impl Photograph {
    /// What a place in pixels shows; background outside the picture.
    pub fn content_at(&self, [x, y]: [f64; 2]) -> Content {
        self.index([x, y]).map_or(Content::Background, |pixel| self.content[pixel])
    }

    /// Whether a point of the head's surface is seen.
    pub fn sees(&self, point: DVec3, normal: DVec3) -> bool {
        /// In metres: less than lids are thick. It grows with the surface's slope.
        const TOLERANCE: f64 = 0.0007;
        let facing = (self.camera.eye() - point).normalize().dot(normal);
        let [x, y, depth] = self.camera.project(point);
        let limit = TOLERANCE / facing.max(0.1);
        facing > 0.0
            && self.index([x, y]).is_some_and(|at| depth - f64::from(self.depths[at]) < limit)
    }

    fn index(&self, [x, y]: [f64; 2]) -> Option<usize> {
        let size = self.picture.size();
        let inside = x >= 0.0 && y >= 0.0 && x < size.width.into() && y < size.height.into();
        inside.then(|| y as usize * size.width as usize + x as usize)
    }
}

/// A mesh that is photographed.
struct Layer<'a> {
    mesh: &'a Mesh,
    size: Size,
    /// Linear.
    colors: Vec<[f32; 3]>,
    normals: Vec<DVec3>,
    /// `[faces]`: corners in samples, and their distances.
    corners: Vec<[[f64; 3]; 3]>,
    /// Number of its first triangle.
    first: u32,
}

impl<'a> Layer<'a> {
    fn new(mesh: &'a Mesh, texture: &Texture, camera: &Pinhole) -> Self {
        let size = texture.size();
        let color = |texel: usize| {
            let (x, y) = (texel as u32 % size.width, texel as u32 / size.width);
            [0, 1, 2].map(|k| linear_from_srgb(texture.get(x, y, k)))
        };
        let position = |vertex: u32| DVec3::from(mesh.positions()[vertex as usize].map(f64::from));
        let corner = |vertex: u32| {
            let [x, y, depth] = camera.project(position(vertex));
            [x * f64::from(SAMPLES), y * f64::from(SAMPLES), depth]
        };
        let mut normals = vec![DVec3::ZERO; mesh.positions().len()];
        for face in mesh.faces() {
            let [a, b, c] = face.map(position);
            let normal = (b - a).cross(c - a);
            face.iter().for_each(|&vertex| normals[vertex as usize] += normal);
        }
        Self {
            mesh,
            size,
            colors: threads::map_indices(size.texels(), color),
            normals,
            corners: mesh.faces().iter().map(|face| face.map(corner)).collect(),
            first: 0,
        }
    }

    fn weights(&self, face: u32, x: u32, y: u32) -> [f64; 3] {
        let corners = self.corners[(face - self.first) as usize];
        weights(corners, f64::from(x) + 0.5, f64::from(y) + 0.5)
    }

    fn uv(&self, face: u32, x: u32, y: u32) -> [f64; 2] {
        let weights = self.weights(face, x, y);
        let corners = self.mesh.uv_triangle((face - self.first) as usize);
        [0, 1].map(|axis| (0..3).map(|k| weights[k] * f64::from(corners[k][axis])).sum())
    }

    /// Linear colour and unit normal.
    fn surface(&self, face: u32, x: u32, y: u32) -> ([f32; 3], DVec3) {
        let weights = self.weights(face, x, y);
        let vertices = self.mesh.faces()[(face - self.first) as usize];
        let normal: DVec3 = (0..3)
            .map(|k| self.normals[vertices[k] as usize].normalize_or_zero() * weights[k])
            .sum();
        (self.color(self.uv(face, x, y)), normal.normalize_or_zero())
    }

    fn color(&self, [u, v]: [f64; 2]) -> [f32; 3] {
        let [width, height] = [self.size.width, self.size.height].map(f64::from);
        let x = (u * width - 0.5).clamp(0.0, width - 1.001);
        let y = (v * height - 0.5).clamp(0.0, height - 1.001);
        let (s, t) = (x.fract() as f32, y.fract() as f32);
        let at = y as usize * self.size.width as usize + x as usize;
        let below = at + self.size.width as usize;
        let [a, b] = [self.colors[at], self.colors[at + 1]];
        let [c, d] = [self.colors[below], self.colors[below + 1]];
        [0, 1, 2]
            .map(|k| (a[k] * (1.0 - s) + b[k] * s) * (1.0 - t) + (c[k] * (1.0 - s) + d[k] * s) * t)
    }
}

fn texel_at(size: Size, [u, v]: [f64; 2]) -> usize {
    let at = |value: f64, side: u32| ((value * f64::from(side)) as u32).min(side - 1) as usize;
    at(v, size.height) * size.width as usize + at(u, size.width)
}
