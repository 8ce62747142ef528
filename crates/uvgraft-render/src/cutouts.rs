//! Where surfaces with transparent textures are solid, for the picture and for shadows.

use uvgraft_gltf::scene::AlphaMode;

use super::camera::Homogeneous;
use super::depth::Holes;
use super::geometry::Geometry;
use super::mipmap::Mipmap;
use super::point::Point;
use super::surface::{Lookup, Surface};

/// Blended surfaces cast a shadow, as if they were opaque, where their alpha is at least this: hair
/// does, and glasses and tears do not. A shadow map has nothing between.
const CASTS: f32 = 0.5;

/// Holes where a surface's alpha is below its limit.
pub(crate) struct Cutouts<'a> {
    pub surfaces: &'a [Surface],
    pub mipmaps: &'a [Mipmap],
    pub geometry: &'a Geometry,
    pub homogeneous: &'a [Homogeneous],
    /// The limit of blended surfaces, if they have one.
    pub blended: Option<f32>,
}

impl Cutouts<'_> {
    fn surface(&self, face: u32) -> &Surface {
        &self.surfaces[self.geometry.faces[face as usize].surface as usize]
    }

    /// The least alpha with which a face is solid; `None` if it is so everywhere.
    fn cutoff(&self, face: u32) -> Option<f32> {
        match self.surface(face).material.alpha {
            AlphaMode::Opaque => None,
            AlphaMode::Mask(cutoff) => Some(cutoff),
            AlphaMode::Blend => self.blended,
        }
    }
}

impl Holes for Cutouts<'_> {
    fn may_pierce(&self, face: u32) -> bool {
        self.cutoff(face).is_some()
    }

    fn is_there(&self, face: u32, x: u32, y: u32) -> bool {
        let Some(cutoff) = self.cutoff(face) else { return true };
        let at = [x, y].map(|at| f64::from(at) + 0.5);
        let point = Point::new(self.geometry, self.homogeneous, face, at, 1.0);
        point.is_some_and(|(point, _)| {
            let lookup = Lookup { mipmaps: self.mipmaps, point: &point };
            self.surface(face).color(&lookup)[3] >= cutoff
        })
    }
}

/// The surfaces that cast shadows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShadowCasters<'a> {
    pub surfaces: &'a [Surface],
    pub mipmaps: &'a [Mipmap],
    pub geometry: &'a Geometry,
}

impl<'a> ShadowCasters<'a> {
    /// Whether all surfaces are opaque, so that their shadows have no holes.
    pub fn are_whole(&self) -> bool {
        self.surfaces.iter().all(|surface| surface.material.alpha == AlphaMode::Opaque)
    }

    /// Whether any of a face can cast a shadow. Textures and the colours of vertices only lower its
    /// alpha.
    pub fn casts(&self, face: usize) -> bool {
        let surface = &self.surfaces[self.geometry.faces[face].surface as usize];
        surface.material.alpha != AlphaMode::Blend || surface.material.color[3] >= CASTS
    }

    /// The holes in shadows.
    ///
    /// - `homogeneous`: all positions as the light sees them.
    pub fn holes(&self, homogeneous: &'a [Homogeneous]) -> Cutouts<'a> {
        let Self { surfaces, mipmaps, geometry } = *self;
        Cutouts { surfaces, mipmaps, geometry, homogeneous, blended: Some(CASTS) }
    }
}
