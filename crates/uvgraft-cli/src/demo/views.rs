//! The demo's views of its figure.

use uvgraft::{Mesh, MeshPart, Size, Texture};
use uvgraft_render::{Shading, View};

/// The figure's face, slightly from the side.
pub(super) const FACE: View =
    View { azimuth: 18.0, elevation: 4.0, target: [0.0, 1.615, 0.01], height: 0.36, floor: false };

/// The figure's head and shoulders.
pub(super) const BUST: View =
    View { azimuth: 20.0, elevation: 3.0, target: [0.0, 1.51, 0.0], height: 0.66, floor: false };

/// The whole figure.
pub(super) const FULL: View =
    View { azimuth: 18.0, elevation: 5.0, target: [0.0, 0.885, 0.0], height: 1.95, floor: true };

/// Draws one of the figure's meshes, each part shaded according to its material's name.
pub(super) fn render(mesh: &Mesh, texture: &Texture, view: &View, size: Size) -> Texture {
    let shading = |part: &MeshPart| Shading::named(&part.material).unwrap_or_default();
    uvgraft_render::render(mesh, texture, shading, view, size)
}
