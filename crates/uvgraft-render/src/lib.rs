//! A small offline renderer: textured meshes, unlit or in soft studio light.
//!
//! Visibility is a depth buffer with 2 × 2 or 4 × 4 samples a pixel, one band of rows at a time. Each
//! smooth surface is shaded once in a pixel, its textures in each quarter. Lighting is a key light with a shadow map, a fill light, a rim light
//! and the sky, with ambient occlusion estimated from the depth buffer.

#![forbid(unsafe_code)]

mod camera;
mod cutouts;
mod depth;
mod encode;
mod floor;
mod frame;
mod geometry;
mod layers;
mod lights;
#[cfg(test)]
mod material_tests;
mod mipmap;
mod occlusion;
mod options;
mod patches;
mod point;
mod projection;
mod samples;
mod shader;
mod shading;
mod shadow;
#[cfg(test)]
mod shadow_tests;
mod surface;
mod tangents;
#[cfg(test)]
mod tests;
mod thumbnail;

use uvgraft::{Mesh, MeshPart, Size, Texture};
use uvgraft_gltf::scene::{Material, PosedPrimitive, Scene};

use self::camera::Camera;
pub use self::camera::{Bounds, Perspective, View};
use self::frame::Frame;
use self::geometry::Geometry;
use self::mipmap::Mipmap;
pub use self::options::{Background, RenderOptions};
pub use self::shading::Shading;
use self::surface::{NeededMipmaps, Role, Surface};
pub use self::thumbnail::{ThumbnailError, thumbnail};

/// Renders a mesh with its texture, as 8-bit sRGB.
///
/// - `shading`: shading of each part of the mesh; triangles in no part are matt.
///
/// # Panics
/// If `size` has no texels or a side longer than [`Texture::MAX_SIDE`].
pub fn render(
    mesh: &Mesh,
    texture: &Texture,
    shading: impl Fn(&MeshPart) -> Shading,
    view: &View,
    size: Size,
) -> Texture {
    const SAMPLES: u32 = 2;
    let mut surfaces = vec![Surface::of_part(Shading::Matt)];
    let mut of_faces = vec![0; mesh.faces().len()];
    for part in mesh.parts() {
        let surface = surfaces.len() as u32;
        surfaces.push(Surface::of_part(shading(part)));
        for polygon in part.polygons.clone() {
            of_faces[mesh.polygon(polygon as usize)].fill(surface);
        }
    }
    let mipmaps = [Mipmap::new(texture)];
    let geometry = Geometry::of_mesh(mesh, &of_faces);
    let fine = Size::new(size.width * SAMPLES, size.height * SAMPLES);
    let camera = Camera::orthographic(view, fine);
    let floor = view.floor.then(|| geometry.bounds().0.y);
    let options = RenderOptions { floor, samples: SAMPLES, ..RenderOptions::default() };
    Frame::new(&surfaces, &mipmaps, geometry, camera, options, size).picture()
}

/// Renders scenes that share materials and textures.
#[derive(Debug)]
pub struct Renderer {
    surfaces: Vec<Surface>,
    mipmaps: Vec<Mipmap>,
}

impl Renderer {
    /// Prepares textures for sampling.
    ///
    /// - `materials`: refer to `textures` by index.
    pub fn new(materials: &[Material], textures: &[Texture]) -> Self {
        Self::of(materials, &textures.iter().collect::<Vec<_>>())
    }

    fn of(materials: &[Material], textures: &[&Texture]) -> Self {
        let mut needed = NeededMipmaps::default();
        let surface = |material| Surface::new(material, textures.len(), &mut needed);
        let surfaces = materials.iter().map(surface).collect();
        let mipmap = |(texture, role): (usize, Role)| match role {
            Role::Color => Mipmap::new(textures[texture]),
            Role::Data => Mipmap::of_data(textures[texture]),
        };
        Self { surfaces, mipmaps: needed.0.into_iter().map(mipmap).collect() }
    }

    /// A renderer for the materials and textures of a scene.
    pub fn for_scene(scene: &Scene) -> Self {
        Self::new(scene.materials(), scene.textures())
    }

    /// The same with another texture, 8-bit sRGB, in place of one of the scene's.
    ///
    /// # Panics
    /// If the scene has no texture of that index.
    pub fn with_texture(scene: &Scene, index: usize, texture: &Texture) -> Self {
        let mut textures: Vec<&Texture> = scene.textures().iter().collect();
        textures[index] = texture;
        Self::of(scene.materials(), &textures)
    }

    /// Renders a picture as 8-bit sRGB, with an alpha channel if the background is transparent.
    ///
    /// Triangles with non-finite positions, without a material or without area are not drawn.
    ///
    /// # Panics
    /// If `size` has no texels or a side longer than a quarter of [`Texture::MAX_SIDE`].
    pub fn render(
        &self,
        drawn: &[PosedPrimitive],
        camera: &Perspective,
        options: &RenderOptions,
        size: Size,
    ) -> Texture {
        assert!(
            size.texels() > 0 && size.width.max(size.height) <= Texture::MAX_SIDE / 4,
            "{size}"
        );
        let samples = if options.samples >= 4 { 4 } else { 2 };
        let options = RenderOptions { samples, ..*options };
        let geometry = Geometry::of_primitives(drawn, &self.surfaces);
        let fine = Size::new(size.width * samples, size.height * samples);
        let camera = Camera::perspective(camera, fine);
        Frame::new(&self.surfaces, &self.mipmaps, geometry, camera, options, size).picture()
    }
}
