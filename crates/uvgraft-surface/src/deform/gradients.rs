//! Displacement gradients of the source's faces.

use glam::{DMat3, DVec3, Vec3};

use super::samples::Samples;
use crate::mesh::Mesh;

/// Faces whose sine of an angle is below this have no reliable gradient.
const THINNEST: f64 = 1e-3;
/// Limit of a gradient's norm. Corners of a mouth reach 30.
const STEEPEST: f64 = 100.0;

/// The faces at rest, inverted.
#[derive(Debug, Clone)]
pub(super) struct Gradients {
    /// `[source faces]`: the two edges and the normal at rest, scaled as in Sumner and Popović's paper,
    /// and the inverse of the matrix of these; `None` for faces that no sample reads, that never move,
    /// or without an area.
    rest: Vec<Option<(DMat3, DMat3)>>,
}

/// What a face does to vectors in the target's space, besides keeping them.
pub(super) type OfFaces = Vec<Option<DMat3>>;

impl Gradients {
    pub fn new(source: &Mesh, samples: &Samples, is_moving: impl Fn(u32) -> bool) -> Self {
        let mut rest = vec![None; source.faces().len()];
        for sample in samples.all() {
            let known = &mut rest[sample.source as usize];
            if known.is_some() || !is_moving(sample.source) {
                continue;
            }
            let corners = source.faces()[sample.source as usize]
                .map(|vertex| Vec3::from(source.positions()[vertex as usize]).as_dvec3());
            *known = frame(corners).map(|frame| (frame, frame.inverse()));
        }
        Self { rest }
    }

    /// The gradient of each face's displacement, in the target's space; `None` where it is unknown or
    /// zero.
    ///
    /// - `offsets`: of a face's corners.
    pub fn of(
        &self,
        offsets: impl Fn(u32) -> [DVec3; 3],
        moves: impl Fn(u32) -> bool,
        rotation: DMat3,
    ) -> OfFaces {
        let gradient = |(face, rest): (u32, &Option<(DMat3, DMat3)>)| {
            let (frame, inverse) = rest.as_ref().filter(|_| moves(face))?;
            let [a, b, c] = offsets(face);
            let edges = [frame.x_axis + b - a, frame.y_axis + c - a];
            let moved = DMat3::from_cols(edges[0], edges[1], normal(edges[0], edges[1]));
            let gradient = moved * *inverse - DMat3::IDENTITY;
            let norm = gradient.to_cols_array().iter().map(|v| v * v).sum::<f64>().sqrt();
            let gradient = gradient * (STEEPEST / norm.max(STEEPEST));
            Some(rotation * gradient * rotation.transpose())
        };
        (0..).zip(&self.rest).map(gradient).collect()
    }
}

/// Perpendicular to two edges, and as long as the square root of their area.
fn normal(a: DVec3, b: DVec3) -> DVec3 {
    let normal = a.cross(b);
    let length = normal.length();
    if length > 0.0 { normal / length.sqrt() } else { DVec3::ZERO }
}

/// Two edges and the normal; `None` for a degenerate face.
fn frame([a, b, c]: [DVec3; 3]) -> Option<DMat3> {
    let (first, second) = (b - a, c - a);
    let longest = first.length_squared().max(second.length_squared());
    let area = first.cross(second).length();
    (area > THINNEST * longest && area.is_normal())
        .then(|| DMat3::from_cols(first, second, normal(first, second)))
}
