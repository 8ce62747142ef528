//! A surface under construction: positions, and polygon corners with chart parameters and a part.

use glam::Vec3;

use crate::symmetry::Symmetry as _;

/// The part that a polygon belongs to. Polygons of the finished meshes are in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum PartKind {
    /// Face, cranium and neck: the largest part.
    Face,
    Eye,
    Ear,
    Hair,
    /// Skin from the neck to below the edge of the shirt.
    Chest,
    Shirt,
    Sleeve,
    /// From the upper arm to the knuckles.
    Arm,
    /// The thumb is 0, the little finger 4.
    Finger(u8),
    Leg,
    Shoe,
}

/// One of a pair; the figure's own left is `+x`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Side {
    Both,
    Left,
    Right,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct BodyPart {
    pub kind: PartKind,
    pub side: Side,
}

/// A corner: its vertex, and its position on the unit square of the part or, for
/// [`PartKind::Face`], on the head grid; see `head`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Knot {
    pub vertex: u32,
    pub at: [f32; 2],
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Polygon {
    pub part: BodyPart,
    /// Three or four, counterclockwise seen from outside.
    pub knots: Vec<Knot>,
}

/// Positions are in centimetres, Y up, facing +Z, the ground at 0.
#[derive(Debug, Clone, Default)]
pub(crate) struct Surface {
    pub positions: Vec<Vec3>,
    pub polygons: Vec<Polygon>,
}

impl Surface {
    pub fn vertex(&mut self, position: Vec3) -> u32 {
        self.positions.push(position);
        self.positions.len() as u32 - 1
    }

    pub fn knot(&mut self, position: Vec3, at: [f32; 2]) -> Knot {
        Knot { vertex: self.vertex(position), at }
    }

    pub fn polygon(&mut self, part: BodyPart, knots: &[Knot]) {
        self.polygons.push(Polygon { part, knots: knots.to_vec() });
    }

    /// Quads between two open rows with equally many knots. Seen from outside, both run to the
    /// right and `lower` is below `upper`.
    pub fn strip(&mut self, part: BodyPart, upper: &[Knot], lower: &[Knot]) {
        for (top, bottom) in upper.windows(2).zip(lower.windows(2)) {
            self.polygon(part, &[top[0], bottom[0], bottom[1], top[1]]);
        }
    }

    /// Triangles from the steps of an open row to one vertex above it. Each triangle has its own
    /// corner there on the chart, centred over its step.
    pub fn cap_above(&mut self, part: BodyPart, tip: Knot, row: &[Knot]) {
        for step in row.windows(2) {
            let middle = 0.5 * (step[0].at[0] + step[1].at[0]);
            self.polygon(part, &[Knot { at: [middle, tip.at[1]], ..tip }, step[0], step[1]]);
        }
    }

    /// Like [`Self::cap_above`], below the row.
    pub fn cap_below(&mut self, part: BodyPart, row: &[Knot], tip: Knot) {
        for step in row.windows(2) {
            let middle = 0.5 * (step[0].at[0] + step[1].at[0]);
            self.polygon(part, &[step[0], Knot { at: [middle, tip.at[1]], ..tip }, step[1]]);
        }
    }

    /// Appends another surface; its vertices come after the existing ones.
    pub fn append(&mut self, other: Self) {
        let offset = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.polygons.extend(other.polygons.into_iter().map(|mut polygon| {
            for knot in &mut polygon.knots {
                knot.vertex += offset;
            }
            polygon
        }));
    }

    /// The left-right mirror image. Chart parameters are unchanged, so its charts are mirrored too.
    pub fn mirrored(&self) -> Self {
        let positions = self.positions.iter().map(|position| position.mirrored()).collect();
        let polygons = self
            .polygons
            .iter()
            .map(|polygon| {
                let side = match polygon.part.side {
                    Side::Left => Side::Right,
                    Side::Right => Side::Left,
                    Side::Both => Side::Both,
                };
                let part = BodyPart { side, ..polygon.part };
                Polygon { part, knots: polygon.knots.iter().rev().copied().collect() }
            })
            .collect();
        Self { positions, polygons }
    }
}
