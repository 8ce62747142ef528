//! Measurements of a face, each a linear function of the vertex positions.

use glam::Vec3;

use super::Face;
use super::features::Opening;
use super::surface::Spot;

/// Measurements of a face, in the mesh's unit. Heights and depths are along the head's up and
/// forward axes, from the point between the eyes at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measures {
    /// Distance between the lids of the left and the right eye, averaged over the eye's
    /// width; negative where they overlap.
    pub lid_gap: [f32; 2],
    /// Mean distance between the lips, from the line where they visibly touch at rest.
    pub lip_opening: f32,
    /// From corner to corner of the mouth.
    pub mouth_width: f32,
    /// Position of the lips along the forward axis.
    pub lip_depth: f32,
    /// Heights of the left and right corners of the mouth.
    pub corner_height: [f32; 2],
    /// Heights of the brows' inner ends.
    pub inner_brow_height: [f32; 2],
    /// Heights of the brows' outer ends.
    pub outer_brow_height: [f32; 2],
    /// Distance between the brows' inner ends.
    pub brow_distance: f32,
}

/// One of the [`Measures`]. Sides are 0 for left, 1 for right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    LidGap(usize),
    LipOpening,
    MouthWidth,
    LipDepth,
    CornerHeight(usize),
    InnerBrow(usize),
    OuterBrow(usize),
    BrowDistance,
}

impl Quantity {
    pub(super) const ALL: [Self; 12] = [
        Self::LidGap(0),
        Self::LidGap(1),
        Self::LipOpening,
        Self::MouthWidth,
        Self::LipDepth,
        Self::CornerHeight(0),
        Self::CornerHeight(1),
        Self::InnerBrow(0),
        Self::InnerBrow(1),
        Self::OuterBrow(0),
        Self::OuterBrow(1),
        Self::BrowDistance,
    ];
}

/// A linear form: vertices, and the vectors whose dot products with their positions add
/// up to a quantity.
pub(super) type Row = Vec<(u32, Vec3)>;

/// The head's axes in the mesh's space: to the left, up, forward.
fn axes(face: &Face) -> [Vec3; 3] {
    face.frame.axes.map(|axis| Vec3::from(axis.map(|value| value as f32)))
}

fn add(row: &mut Row, spot: &Spot, axis: Vec3) {
    row.extend(spot.parts().iter().map(|&(vertex, part)| (vertex, axis * part)));
}

fn gaps(openings: &[Opening], up: Vec3) -> Row {
    let mut row = Row::new();
    for opening in openings {
        add(&mut row, &opening.upper, up / openings.len() as f32);
        add(&mut row, &opening.lower, -up / openings.len() as f32);
    }
    row
}

/// A quantity as a linear form of the vertex positions.
pub(super) fn row(face: &Face, quantity: Quantity) -> Row {
    let [left, up, forward] = axes(face);
    let mut row = Row::new();
    match quantity {
        Quantity::LidGap(side) => return gaps(&face.eyes[side].lids, up),
        Quantity::LipOpening => return gaps(&face.lips, up),
        Quantity::MouthWidth => {
            add(&mut row, &face.corners[0], left);
            add(&mut row, &face.corners[1], -left);
        }
        Quantity::LipDepth => {
            let share = forward / (2 * face.lips.len()) as f32;
            for opening in &face.lips {
                add(&mut row, &opening.upper, share);
                add(&mut row, &opening.lower, share);
            }
        }
        Quantity::CornerHeight(side) => add(&mut row, &face.corners[side], up),
        Quantity::InnerBrow(side) => add(&mut row, &face.inner_brows[side], up),
        Quantity::OuterBrow(side) => add(&mut row, &face.outer_brows[side], up),
        Quantity::BrowDistance => {
            add(&mut row, &face.inner_brows[0], left);
            add(&mut row, &face.inner_brows[1], -left);
        }
    }
    row
}

/// Evaluates a linear form for values at the vertices.
pub(super) fn value(row: &Row, values: &[[f32; 3]]) -> f32 {
    let part = |&(vertex, axis): &(u32, Vec3)| axis.dot(Vec3::from(values[vertex as usize]));
    row.iter().map(|entry| f64::from(part(entry))).sum::<f64>() as f32
}

impl Face {
    /// Measures the face with its vertices at `positions`, `[vertices]` of the mesh that it was
    /// located on. The head must not have rotated since.
    ///
    /// # Panics
    /// If there are fewer positions than vertices.
    pub fn measure(&self, positions: &[[f32; 3]]) -> Measures {
        assert!(positions.len() >= self.vertices, "a position for each vertex");
        let [_, up, forward] = axes(self);
        let origin = Vec3::from(self.frame.origin.map(|value| value as f32));
        let of = |quantity| value(&row(self, quantity), positions);
        let height = |quantity| of(quantity) - up.dot(origin);
        let sides = |quantity: fn(usize) -> Quantity| [quantity(0), quantity(1)];
        Measures {
            lid_gap: sides(Quantity::LidGap).map(of),
            lip_opening: of(Quantity::LipOpening),
            mouth_width: of(Quantity::MouthWidth),
            lip_depth: of(Quantity::LipDepth) - forward.dot(origin),
            corner_height: sides(Quantity::CornerHeight).map(height),
            inner_brow_height: sides(Quantity::InnerBrow).map(height),
            outer_brow_height: sides(Quantity::OuterBrow).map(height),
            brow_distance: of(Quantity::BrowDistance),
        }
    }
}
