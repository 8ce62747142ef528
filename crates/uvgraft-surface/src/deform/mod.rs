//! Deformation transfer: how one mesh moves, transferred to another one that is paired with it.
//!
//! Based on R. Sumner and J. Popović, "Deformation transfer for triangle meshes" (2004), in the form
//! of M. Botsch, R. Sumner, M. Pauly and M. Gross, "Deformation transfer for detail-preserving surface
//! editing" (2006): every triangle of the target should deform as the source does where its pieces
//! lie, and the displacements `d` that come closest are the solution of one Poisson equation,
//! `min Σ w |dᵢ - dⱼ - D (xᵢ - xⱼ)|²` over the edges of all triangles, where `D + 1` is the source's
//! deformation gradient and `w` half the cotangent of the angle opposite to the edge.
//!
//! Gradients determine detail well and large movements badly: where proportions differ they add up
//! to others. So the displacement of the source itself, rotated and scaled, counts too, weakly:
//! `Σ A |d - s R u|² / ℓ²` lets gradients decide below the length ℓ, and displacements above it.
//! Triangles without a counterpart, such as the inside of lips, follow their neighbours.
//!
//! The equations are the same for all deformations, so they are factorised once.

mod equations;
mod gradients;
mod handles;
mod reach;
mod samples;

use glam::{DMat3, DVec3, Vec3};

use self::equations::{Equations, Screen};
use self::gradients::Gradients;
pub use self::handles::{Handles, Row};
use self::reach::Reach;
use self::samples::Samples;
use crate::correspond::similarity::Similarity;
use crate::mesh::Mesh;
use crate::pair::Pair;
use crate::surface::Surface;

/// Above this length the source's displacements decide, as a share of the size of what moves
/// (the square root of its area): about 25 mm in a face.
const SCREEN: f64 = 0.15;
/// The same for corrections, which should stay where they are needed: about 5 mm.
const CORRECTION: f64 = 0.03;
/// How far from what moves the unpaired surface is still free, as a share of the same size: the depth
/// of a mouth.
const REACH: f64 = 0.5;

/// Why deformations cannot be transferred.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DeformError {
    /// A list for the vertices of a mesh has another length.
    #[error("{what} must be given for each of the {wanted} source vertices, got {found}")]
    Count {
        /// What is listed.
        what: &'static str,
        /// Length of the list.
        found: usize,
        /// Number of vertices.
        wanted: usize,
    },
    /// An offset is NaN or infinite.
    #[error("offset of vertex {vertex} must be finite, got {found:?}")]
    NotFinite {
        /// The vertex.
        vertex: usize,
        /// Its offset.
        found: [f32; 3],
    },
    /// No part of the source that moves has a counterpart that has an area.
    #[error("no part of the source that moves corresponds to any part of the target")]
    Nothing,
}

/// The transfer of deformations from one mesh to another, prepared for any number of them.
#[derive(Debug, Clone)]
pub struct DeformationTransfer {
    alignment: Similarity,
    /// The point of each target vertex in the surface; `None` for vertices without a triangle.
    point_of_vertex: Vec<Option<u32>>,
    source_vertices: usize,
    faces: Vec<[u32; 3]>,
    size: f64,
    samples: Samples,
    gradients: Gradients,
    reach: Reach,
    equations: Equations,
    correction: Equations,
}

impl DeformationTransfer {
    /// Prepares the transfer from a pair's source to its target, both at rest.
    ///
    /// - `moves`: `[source vertices]`, whether any deformation moves the vertex. The target's surface
    ///   elsewhere stays exactly where it is.
    ///
    /// Units and orientations may differ: see [`DeformationTransfer::alignment`].
    ///
    /// # Errors
    /// [`DeformError`] if `moves` has another length, or nothing that moves has a counterpart.
    pub fn new(pair: &Pair, moves: &[bool]) -> Result<Self, DeformError> {
        let (source, target) = (pair.source(), pair.target());
        let source_vertices = source.positions().len();
        check_count("movement", moves.len(), source_vertices)?;
        let surface = Surface::new(target);
        let samples = Samples::new(target.faces().len(), pair.pieces());
        let is_moving =
            |face: u32| source.faces()[face as usize].iter().any(|&vertex| moves[vertex as usize]);
        let alignment = alignment(source, &surface, &samples, is_moving);
        let alignment = alignment.ok_or(DeformError::Nothing)?;
        let moving = |triangle: u32| samples.of(triangle).iter().any(|s| is_moving(s.source));
        let triangles = 0..surface.triangles().len() as u32;
        let area: f64 = triangles.filter(|&t| moving(t)).map(|t| surface.area(t)).sum();
        let size = area.sqrt();
        let reach = Reach::new(&surface, &samples, moving, REACH * size);
        let screen = Screen { length: SCREEN * size, samples: Some(&samples) };
        let equations = Equations::new(&surface, &reach, &screen);
        let screen = Screen { length: CORRECTION * size, samples: None };
        let correction = Equations::new(&surface, &reach, &screen);
        if !equations.is_sound() {
            return Err(DeformError::Nothing);
        }
        let gradients = Gradients::new(source, &samples, is_moving);
        let mut point_of_vertex = vec![None; target.positions().len()];
        for (face, points) in target.faces().iter().zip(surface.triangles()) {
            for (&vertex, &point) in face.iter().zip(points) {
                point_of_vertex[vertex as usize] = Some(point);
            }
        }
        let faces = source.faces().to_vec();
        Ok(Self {
            alignment,
            point_of_vertex,
            source_vertices,
            faces,
            size,
            samples,
            gradients,
            reach,
            equations,
            correction,
        })
    }

    /// The rotation, scale and translation that bring the source's moving part closest to its
    /// counterpart. Directions of movements are rotated by it, and lengths scaled.
    pub const fn alignment(&self) -> &Similarity {
        &self.alignment
    }

    /// The square root of the area of the target that may move, in its unit: what lengths of a face
    /// are compared with.
    pub const fn size(&self) -> f64 {
        self.size
    }

    /// For each target vertex, whether any of its triangles has a counterpart.
    pub fn has_counterpart(&self) -> Vec<bool> {
        let is_paired = |point: &Option<u32>| point.is_some_and(|at| self.reach.is_paired(at));
        self.point_of_vertex.iter().map(is_paired).collect()
    }

    /// Transfers one deformation.
    ///
    /// - `offsets`: `[source vertices]`, from rest, in the source's space and unit.
    ///
    /// Returns the offsets of the target's vertices, in the target's space and unit: exactly zero
    /// where the source does not move.
    ///
    /// # Errors
    /// [`DeformError`] if the offsets are not one for each source vertex or not finite.
    pub fn transfer(&self, offsets: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, DeformError> {
        check_count("an offset", offsets.len(), self.source_vertices)?;
        let is_finite = |offset: &[f32; 3]| offset.iter().all(|value| value.is_finite());
        if let Some(vertex) = offsets.iter().position(|offset| !is_finite(offset)) {
            return Err(DeformError::NotFinite { vertex, found: offsets[vertex] });
        }
        let corners = |face: u32| {
            self.faces[face as usize].map(|vertex| Vec3::from(offsets[vertex as usize]).as_dvec3())
        };
        let moves = |face: u32| corners(face).iter().any(|&offset| offset != DVec3::ZERO);
        let rotation = self.alignment.rotation;
        let gradients = self.gradients.of(corners, moves, rotation);
        let linear = rotation * self.alignment.scale;
        let displacement = |face: u32, weights: [f64; 3]| {
            let corners = corners(face);
            linear * (0..3).map(|k| corners[k] * weights[k]).sum::<DVec3>()
        };
        let mut points = self.equations.solve(&self.samples, &gradients, displacement);
        self.still(&mut points, moves);
        Ok(self.to_vertices(&points))
    }

    /// Prepares corrections by some quantities: linear forms of the target vertices' offsets.
    pub fn handles(&self, rows: &[Row]) -> Handles {
        Handles::new(&self.correction, rows, &self.point_of_vertex)
    }

    /// The smoothest offsets that change quantities by given amounts.
    ///
    /// - `changes`: of each of the handles' quantities; `None` leaves it free, 0 keeps it. Changes that
    ///   contradict each other are met as well as possible.
    ///
    /// They fade out within a few hundredths of the size of what moves, and the surface that the source
    /// never moves stays.
    pub fn correction(&self, handles: &Handles, changes: &[Option<f32>]) -> Vec<[f32; 3]> {
        /// Offsets shorter than the first share of the longest become zero, those longer than the
        /// second remain. Origin not recorded.
        const STILL: [f64; 2] = [0.01, 0.05];
        let rows = handles.solve(self.correction.rows(), changes);
        let mut points = self.correction.to_points(&rows);
        let most = points.iter().map(|point| point.length()).fold(0.0, f64::max);
        points.iter_mut().for_each(|point| *point *= fade(point.length(), STILL.map(|s| s * most)));
        self.to_vertices(&points)
    }

    /// Lets movements fade to exactly zero where the source does not move in one deformation.
    fn still(&self, points: &mut [DVec3], moves: impl Fn(u32) -> bool) {
        /// Movements that are too small to be seen, as a share of the size: those shorter than the
        /// first become zero, those longer than the second remain. In a face, 0.02 and 0.1 mm.
        const STILL: [f64; 2] = [1e-4, 6e-4];
        /// Rounding of the solution, at the edge of what moves.
        const NOTHING: f64 = 1e-7;
        let mut stirred = vec![false; points.len()];
        for (triangle, corners) in (0..).zip(self.equations.triangles()) {
            if self.samples.of(triangle).iter().any(|sample| moves(sample.source)) {
                corners.iter().for_each(|&point| stirred[point as usize] = true);
            }
        }
        for (point, stirred) in points.iter_mut().zip(stirred) {
            if point.length() < NOTHING * self.size {
                *point = DVec3::ZERO;
            } else if !stirred {
                *point *= fade(point.length(), STILL.map(|share| share * self.size));
            }
        }
    }

    fn to_vertices(&self, points: &[DVec3]) -> Vec<[f32; 3]> {
        let of = |point: &Option<u32>| {
            point.map_or([0.0; 3], |at| points[at as usize].as_vec3().to_array())
        };
        self.point_of_vertex.iter().map(of).collect()
    }
}

/// Rises smoothly from 0 at the first length to 1 at the second.
fn fade(length: f64, [from, to]: [f64; 2]) -> f64 {
    if length >= to {
        return 1.0;
    }
    let share = ((length - from) / (to - from)).max(0.0);
    share * share * (3.0 - 2.0 * share)
}

const fn check_count(what: &'static str, found: usize, wanted: usize) -> Result<(), DeformError> {
    if found == wanted { Ok(()) } else { Err(DeformError::Count { what, found, wanted }) }
}

/// The transform of the source's moving part to its counterpart, by area.
fn alignment(
    source: &Mesh,
    surface: &Surface,
    samples: &Samples,
    is_moving: impl Fn(u32) -> bool,
) -> Option<Similarity> {
    let (mut pairs, mut weights) = (Vec::new(), Vec::new());
    for triangle in 0..surface.triangles().len() as u32 {
        let (corners, area) = (surface.corners(triangle), surface.area(triangle));
        for sample in samples.of(triangle).iter().filter(|sample| is_moving(sample.source)) {
            let from = source.faces()[sample.source as usize]
                .map(|vertex| Vec3::from(source.positions()[vertex as usize]).as_dvec3());
            let mean = |corners: [DVec3; 3], weights: [f64; 3]| {
                (0..3).map(|k| corners[k] * weights[k]).sum::<DVec3>()
            };
            pairs.push([mean(from, sample.from), mean(corners, sample.at)]);
            weights.push(area * sample.share);
        }
    }
    let found = Similarity::between(&pairs, &weights, true)?;
    (found.rotation != DMat3::ZERO).then_some(found)
}

#[cfg(test)]
mod tests;
