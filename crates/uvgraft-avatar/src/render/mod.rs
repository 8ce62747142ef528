//! A small offline renderer: a textured mesh in soft studio light, seen orthographically.
//!
//! Visibility is a depth buffer with 2 × 2 samples a pixel. Light comes from a key with a shadow
//! map, a fill, a rim light and the sky, with occlusion estimated from the depth buffer.

mod depth;
mod mipmap;
mod shade;

use rayon::prelude::*;
use uvgraft::color::{linear_from_srgb, srgb_from_linear};
use uvgraft::{Channels, Encoding, Mesh, Size, Texels, Texture, Value};

use self::depth::{Camera, DepthBuffer, EMPTY};
use self::mipmap::Mipmap;
use self::shade::{Lights, Material, background};
use crate::normals::vertex_normals;
use crate::vector::{Vec3, vec3};

/// From where a mesh is seen. Angles are in degrees, lengths in the mesh's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// How far the camera has gone around the mesh: 0 in front (on +Z), 90 on +X.
    pub azimuth: f32,
    /// How far the camera is above the horizon, from -89 to 89; more is clamped.
    pub elevation: f32,
    /// The point in the middle of the picture.
    pub target: [f32; 3],
    /// Height of the region that fills the picture.
    pub height: f32,
    /// Whether the mesh stands on a floor that takes its shadow; seen from above only.
    pub floor: bool,
}

impl View {
    /// The figure's face, from slightly beside.
    pub const fn face() -> Self {
        Self {
            azimuth: 18.0,
            elevation: 4.0,
            target: [0.0, 1.615, 0.01],
            height: 0.36,
            floor: false,
        }
    }

    /// The figure's head and shoulders.
    pub const fn bust() -> Self {
        Self { azimuth: 20.0, elevation: 3.0, target: [0.0, 1.51, 0.0], height: 0.66, floor: false }
    }

    /// All of the figure.
    pub const fn full() -> Self {
        Self { azimuth: 18.0, elevation: 5.0, target: [0.0, 0.885, 0.0], height: 1.95, floor: true }
    }
}

const SAMPLES: u32 = 2;

/// Renders a mesh with its texture: 8-bit sRGB. A mesh that names its parts' materials (`skin`,
/// `eye`, `hair`, `leather`) has them shaded accordingly; everything else is matt.
///
/// # Panics
/// If `size` has no texels or a side longer than [`Texture::MAX_SIDE`].
pub fn render(mesh: &Mesh, texture: &Texture, view: &View, size: Size) -> Texture {
    let fine = Size::new(size.width * SAMPLES, size.height * SAMPLES);
    let camera = Camera::new(view, fine);
    let positions: Vec<Vec3> = mesh.positions().iter().map(|&p| Vec3::from(p)).collect();
    let depth = DepthBuffer::new(&camera, &positions, mesh.faces(), fine);
    let lights = Lights::new(&camera, &positions, mesh.faces());
    let scene = Scene {
        mesh,
        normals: vertex_normals(mesh.positions(), mesh.faces()),
        materials: materials(mesh),
        mipmap: Mipmap::new(texture),
        occlusion: depth.occlusion(camera.unit_per_px, size),
        positions,
        camera,
        depth,
        lights,
        floor: view.floor,
    };
    let width = size.width as usize;
    let mut texels = vec![0_u8; size.texels() * 3];
    texels.par_chunks_mut(width * 3).enumerate().for_each(|(y, row)| {
        for (x, texel) in row.chunks_exact_mut(3).enumerate() {
            let color = scene.pixel(x as u32, y as u32, size);
            for (value, linear) in texel.iter_mut().zip(color) {
                *value = u8::from_unit(srgb_from_linear(linear));
            }
        }
    });
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(texels))
        .expect("the buffer was made for this size")
}

/// The material of every triangle.
fn materials(mesh: &Mesh) -> Vec<Material> {
    let mut materials = vec![Material::Matt; mesh.faces().len()];
    for part in mesh.parts() {
        let material = Material::named(&part.material);
        for polygon in part.polygons.clone() {
            materials[mesh.polygon(polygon as usize)].fill(material);
        }
    }
    materials
}

struct Scene<'a> {
    mesh: &'a Mesh,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    materials: Vec<Material>,
    mipmap: Mipmap,
    camera: Camera,
    depth: DepthBuffer,
    /// A pixel's share of the sky.
    occlusion: Vec<f32>,
    lights: Lights,
    floor: bool,
}

impl Scene<'_> {
    /// The mean of a pixel's samples, in linear light.
    fn pixel(&self, x: u32, y: u32, size: Size) -> [f32; 3] {
        let open = self.occlusion[(y * size.width + x) as usize];
        let behind =
            background((x as f32 + 0.5) / size.width as f32, (y as f32 + 0.5) / size.height as f32)
                .map(linear_from_srgb);
        let on_sight = self
            .camera
            .unproject((x as f32 + 0.5) * SAMPLES as f32, (y as f32 + 0.5) * SAMPLES as f32);
        let mut floor = None;
        let mut sum = [0.0; 3];
        for sample in 0..SAMPLES * SAMPLES {
            let (sx, sy) = (x * SAMPLES + sample % SAMPLES, y * SAMPLES + sample / SAMPLES);
            let face = self.depth.face(sx, sy);
            let color = if face == EMPTY {
                let floor = *floor.get_or_insert_with(|| {
                    if self.floor { self.lights.floor(on_sight) } else { 1.0 }
                });
                behind.map(|value| value * floor)
            } else {
                self.sample(face, sx, sy, open)
            };
            for (sum, value) in sum.iter_mut().zip(color) {
                *sum += value / (SAMPLES * SAMPLES) as f32;
            }
        }
        sum
    }

    fn sample(&self, face: u32, sx: u32, sy: u32, open: f32) -> [f32; 3] {
        let face = face as usize;
        let vertices = self.mesh.faces()[face].map(|vertex| vertex as usize);
        let corners = vertices.map(|vertex| self.camera.project(self.positions[vertex]));
        let [a, b, c] = corners;
        let (ab, ac) = (b - a, c - a);
        let area = ab.x * ac.y - ab.y * ac.x;
        let (dx, dy) = (sx as f32 + 0.5 - a.x, sy as f32 + 0.5 - a.y);
        let wb = (dx * ac.y - dy * ac.x) / area;
        let wc = (dy * ab.x - dx * ab.y) / area;
        let weights = [1.0 - wb - wc, wb, wc];
        let mut normal = vec3(0.0, 0.0, 0.0);
        let mut position = vec3(0.0, 0.0, 0.0);
        let mut uv = [0.0; 2];
        let uv_corners = self.mesh.uv_triangle(face);
        for k in 0..3 {
            normal = normal + self.normals[vertices[k]] * weights[k];
            position = position + self.positions[vertices[k]] * weights[k];
            uv[0] += uv_corners[k][0] * weights[k];
            uv[1] += uv_corners[k][1] * weights[k];
        }
        let mut normal = normal.normalized();
        if normal.dot(self.camera.towards) < 0.0 {
            normal = normal - self.camera.towards * (1.02 * normal.dot(self.camera.towards));
            normal = normal.normalized();
        }
        let uv_area = {
            let [p, q, r] = uv_corners;
            ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])).abs()
        };
        let albedo = self.mipmap.sample(uv, uv_area / area.abs());
        self.lights.shade(self.materials[face], albedo, position, normal, open)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Figure, paint_body, paint_head};

    #[test]
    fn shows_a_face_where_the_mannequin_has_none() {
        let figure = Figure::new();
        let (width, height) = (60_u32, 80_u32);
        let size = Size::new(width, height);
        let head = paint_head(&figure, Size::square(512));
        let body = paint_body(&figure, Size::square(512));
        let painted = render(&figure.head, &head, &View::face(), size);
        let plain = render(&figure.body, &body, &View::face(), size);
        assert_eq!(painted, render(&figure.head, &head, &View::face(), size));
        let differing = |a: &Texture, b: &Texture| {
            (0..size.texels() as u32)
                .filter(|k| {
                    let (x, y) = (k % width, k / width);
                    (0..3).any(|c| (a.get(x, y, c) - b.get(x, y, c)).abs() > 0.05)
                })
                .count()
        };
        assert!(differing(&painted, &plain) > size.texels() / 8);
        let away = View { target: [9.0, 9.0, 9.0], ..View::face() };
        let empty = render(&figure.head, &head, &away, size);
        assert!(differing(&plain, &empty) > size.texels() / 3);
    }
}
