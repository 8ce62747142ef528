//! A small offline renderer: textured meshes in soft studio light, or in none.
//!
//! Visibility is a depth buffer with 2 × 2 or 4 × 4 samples a pixel; colours are computed for each
//! triangle in each quarter of a pixel. Light comes from a key with a shadow map, a fill, a rim light
//! and the sky, with occlusion estimated from the depth buffer.

mod camera;
mod floor;
mod frame;
mod geometry;
mod layers;
#[cfg(test)]
mod material_tests;
mod mipmap;
mod projection;
mod shade;
mod surface;
mod tangents;
#[cfg(test)]
mod tests;
mod visibility;

use uvgraft::{Mesh, Size, Texture};

use self::camera::Camera;
pub use self::camera::{Bounds, Perspective};
use self::frame::Frame;
use self::geometry::Geometry;
use self::mipmap::Mipmap;
use self::surface::{Needed, Role, Surface};
use crate::scene::{Drawn, Material, Scene};

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

/// Renders a mesh with its texture: 8-bit sRGB. A mesh that names its parts' materials (`skin`,
/// `eye`, `hair`, `leather`) has them shaded accordingly; everything else is matt.
///
/// # Panics
/// If `size` has no texels or a side longer than [`Texture::MAX_SIDE`].
pub fn render(mesh: &Mesh, texture: &Texture, view: &View, size: Size) -> Texture {
    const SAMPLES: u32 = 2;
    let mut surfaces = vec![Surface::of_part("")];
    let mut of_faces = vec![0; mesh.faces().len()];
    for part in mesh.parts() {
        let surface = surfaces.len() as u32;
        surfaces.push(Surface::of_part(&part.material));
        for polygon in part.polygons.clone() {
            of_faces[mesh.polygon(polygon as usize)].fill(surface);
        }
    }
    let mipmaps = [Mipmap::new(texture)];
    let geometry = Geometry::of_mesh(mesh, &of_faces);
    let fine = Size::new(size.width * SAMPLES, size.height * SAMPLES);
    let camera = Camera::orthographic(view, fine);
    let floor = view.floor.then(|| geometry.bounds().0.y);
    let look = Look { floor, samples: SAMPLES, ..Look::default() };
    Frame::new(&surfaces, &mipmaps, geometry, camera, look, size).picture()
}

/// How a picture is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Whether there is light at all. Without it every surface has the plain colour of its texture,
    /// and there are no shadows.
    pub lit: bool,
    /// What is behind everything.
    pub background: Background,
    /// Height of a floor that takes shadows, if there is one; seen from above only.
    pub floor: Option<f32>,
    /// Samples along each side of a pixel: 2, or 4 for smoother edges.
    pub samples: u32,
}

impl Default for Look {
    fn default() -> Self {
        Self { lit: true, background: Background::Studio, floor: None, samples: 4 }
    }
}

/// What is behind everything.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Background {
    /// A neutral backdrop that is brighter in the middle.
    Studio,
    /// One colour, sRGB.
    Plain([u8; 3]),
    /// Nothing: the picture has opacity. A floor's shadow is black that one sees through.
    Transparent,
}

/// Draws scenes that share materials and textures.
#[derive(Debug)]
pub struct Renderer {
    surfaces: Vec<Surface>,
    mipmaps: Vec<Mipmap>,
}

impl Renderer {
    /// Prepares textures for lookups.
    ///
    /// - `materials`: refer to `textures` by their numbers.
    pub fn new(materials: &[Material], textures: &[Texture]) -> Self {
        let mut needed = Needed::default();
        let surface = |material| Surface::new(material, textures.len(), &mut needed);
        let surfaces = materials.iter().map(surface).collect();
        let mipmap = |(texture, role): (usize, Role)| match role {
            Role::Color => Mipmap::new(&textures[texture]),
            Role::Data => Mipmap::of_data(&textures[texture]),
        };
        Self { surfaces, mipmaps: needed.0.into_iter().map(mipmap).collect() }
    }

    /// For everything in a scene.
    pub fn of(scene: &Scene) -> Self {
        Self::new(scene.materials(), scene.textures())
    }

    /// Draws a picture: 8-bit sRGB, with opacity where the background is transparent.
    ///
    /// What has no place, no material or no area is not seen.
    ///
    /// # Panics
    /// If `size` has no texels or a side longer than a quarter of [`Texture::MAX_SIDE`].
    pub fn render(
        &self,
        drawn: &[Drawn],
        camera: &Perspective,
        look: &Look,
        size: Size,
    ) -> Texture {
        assert!(
            size.texels() > 0 && size.width.max(size.height) <= Texture::MAX_SIDE / 4,
            "{size}"
        );
        let samples = if look.samples >= 4 { 4 } else { 2 };
        let look = Look { samples, ..*look };
        let geometry = Geometry::of_drawn(drawn, &self.surfaces);
        let fine = Size::new(size.width * samples, size.height * samples);
        let camera = Camera::perspective(camera, fine);
        Frame::new(&self.surfaces, &self.mipmaps, geometry, camera, look, size).picture()
    }
}
