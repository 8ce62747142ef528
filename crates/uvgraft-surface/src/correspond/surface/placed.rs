//! Pieces of a mesh whose vertices have known places on another mesh's surface: the overlay without
//! registration.

use glam::DVec3;

use super::kinds::TriangleKind;
use super::overlay::overlay;
use super::register::Goal;
use super::shape::Shape;
use super::{SurfaceOptions, share_of_area};
use crate::mesh::Mesh;
use crate::piece::Piece;
use crate::surface::Surface;
use crate::triangle_tree::{Bounds, Effort};

/// A mesh laid over another.
#[derive(Debug, Clone, Default)]
pub(in crate::correspond) struct Placed {
    /// Ascending by `target`, the face of the placed mesh; `source` is the face of the other one.
    pub pieces: Vec<Piece>,
    /// The share of the placed mesh's area that has a counterpart.
    pub covered: f64,
    /// Faces of the placed mesh with a corner that has no place.
    pub faces_without_place: usize,
}

/// Lays a mesh over another.
///
/// - `place`: for a vertex of `mesh`, its place on the surface of `onto`; `None` leaves its faces out.
pub(in crate::correspond) fn placed(
    onto: &Mesh,
    mesh: &Mesh,
    place: impl Fn(u32) -> Option<DVec3>,
    options: &SurfaceOptions,
) -> Placed {
    let [below, surface] = [onto, mesh].map(Surface::new);
    let extent = Bounds::of(below.positions().iter().copied());
    let (center, unit) = ((extent.min + extent.max) / 2.0, extent.size().max_element());
    if !unit.is_normal() {
        return Placed::default();
    }
    let to_unit = |point: DVec3| (point - center) / unit;
    // Vertices that are split along UV seams are one point, which is where the first of them is.
    let mut places: Vec<Option<DVec3>> = vec![None; surface.positions().len()];
    for (vertices, points) in mesh.faces().iter().zip(surface.triangles()) {
        for (&vertex, &point) in vertices.iter().zip(points) {
            let at = &mut places[point as usize];
            *at = at.or_else(|| place(vertex));
        }
    }
    let has_place = |points: &[u32; 3]| points.iter().all(|&at| places[at as usize].is_some());
    // A triangle without area is laid over nothing, and the others keep their indices.
    let triangle = |points: &[u32; 3]| if has_place(points) { *points } else { [points[0]; 3] };
    let shape = Shape {
        points: places.iter().map(|place| place.map_or(DVec3::ZERO, to_unit)).collect(),
        triangles: surface.triangles().iter().map(triangle).collect(),
    };
    let faces_without_place =
        surface.triangles().iter().filter(|points| !has_place(points)).count();
    let goal = Goal::new(Shape::new(&below, to_unit), &Effort::unlimited());
    let kinds = vec![TriangleKind::ANY; shape.triangles.len()];
    let overlay = overlay(&goal, &shape, &kinds, options.reach, options.visibility);
    let covered = share_of_area(&surface, &overlay.covered);
    Placed { pieces: overlay.pieces, covered, faces_without_place }
}
