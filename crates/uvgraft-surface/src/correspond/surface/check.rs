//! Whether a registration that was found is plausible: heads may be taken for what they are not, such as
//! hair for a face, or a face for its own upside down.

use glam::{DMat3, DVec3};

use super::align::{Heads, STEADY};
use super::equations::Anchor;
use super::overlay::Overlay;
use super::shape::Shape;
use super::{Placement, SurfaceError, anchors};
use crate::anatomy::{Anatomy, Area};
use crate::mesh::Mesh;
use crate::statistics::median;

/// How far landmarks of both heads may be apart after registration, in distances between the eyes.
/// Where heads were right they were apart by up to 0.23, where they were turned by half at least 1.3.
const FARTHEST: f64 = 0.5;

/// How much registration may turn what lies on the face, by the median. Faces of different persons and
/// makers were turned by up to 9 degrees, others that were laid over the face by at least 27.
const MOST_TURNED: f64 = 20.0;

/// What lies on the face of the source must be little bent, and landmarks of both sides together.
///
/// - `rest`, `registered`: the aligned target, before and after registration.
/// - `overlay`: what corresponds.
pub(super) fn check(
    source: &Mesh,
    placement: &Placement,
    rest: &Shape,
    registered: &Shape,
    overlay: &Overlay,
    to_unit: impl Fn(DVec3) -> DVec3,
) -> Result<(), SurfaceError> {
    let Some(heads) = &placement.heads else { return Ok(()) };
    if let Some(degrees) = turned(&on_face(source, &heads.source, overlay), rest, registered)
        && degrees > MOST_TURNED
    {
        return Err(SurfaceError::Turned { degrees, most: MOST_TURNED });
    }
    if placement.are_heads_certain {
        apart(heads, placement, rest, registered, to_unit)?;
    }
    Ok(())
}

/// The angle between both faces after an alignment that they did not decide, in degrees.
pub(super) fn heads_turned(placement: &Placement) -> Option<f64> {
    let heads = placement.heads.as_ref().filter(|_| placement.aligned_by != "heads")?;
    let axes = |head: &Anatomy| DMat3::from_cols_array_2d(&head.frame().axes);
    let aligned = placement.transform.rotation * axes(&heads.target);
    let turn = axes(&heads.source).transpose() * aligned;
    let cosine = (turn.x_axis.x + turn.y_axis.y + turn.z_axis.z - 1.0) / 2.0;
    Some(cosine.clamp(-1.0, 1.0).acos().to_degrees())
}

/// The target's triangles that lie on the face of the source.
fn on_face(source: &Mesh, head: &Anatomy, overlay: &Overlay) -> Vec<usize> {
    const FACE: [Area; 5] = [Area::Cheeks, Area::Forehead, Area::Nose, Area::Lips, Area::Jaw];
    let is_face = |face: u32| {
        let corners = source.faces()[face as usize];
        FACE.iter().any(|&area| corners.iter().all(|&at| head.area(area)[at as usize] > 0.5))
    };
    let lies = overlay.pieces.iter().filter(|piece| is_face(piece.source));
    let mut found: Vec<usize> = lies.map(|piece| piece.target as usize).collect();
    found.dedup();
    found
}

/// The median angle between triangles before and after registration, in degrees; `None` without any.
fn turned(triangles: &[usize], rest: &Shape, registered: &Shape) -> Option<f64> {
    let angles = triangles
        .iter()
        .map(|&triangle| rest.area_vector(triangle).angle_between(registered.area_vector(triangle)))
        .filter(|angle| angle.is_finite());
    median(angles).map(f64::to_degrees)
}

/// Refuses landmarks of both heads that lie apart.
fn apart(
    heads: &Heads,
    placement: &Placement,
    rest: &Shape,
    registered: &Shape,
    to_unit: impl Fn(DVec3) -> DVec3,
) -> Result<(), SurfaceError> {
    let eyes = heads.source.frame().unit / placement.unit;
    for landmark in STEADY {
        let places = heads.common(&[landmark]);
        for Anchor { points, weights, displacement } in
            anchors(&places, rest, &to_unit, &placement.transform)
        {
            let moved = |k: usize| {
                let point = points[k] as usize;
                (registered.points[point] - rest.points[point]) * weights[k]
            };
            // A landmark off the surface, such as the centre of an eye, keeps its way to the surface.
            let apart = displacement.distance((0..3).map(moved).sum()) / eyes;
            if apart > FARTHEST {
                return Err(SurfaceError::Apart { landmark, apart, most: FARTHEST });
            }
        }
    }
    Ok(())
}
