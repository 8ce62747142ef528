//! Parts of a mouth while they are built: points, and triangles with coordinates in a chart of their own.

use glam::Vec3;

/// A part's own island in the texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Chart {
    Cavity,
    Upper,
    Lower,
    Tongue,
}

impl Chart {
    /// For people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cavity => "cavity",
            Self::Upper => "upper teeth",
            Self::Lower => "lower teeth",
            Self::Tongue => "tongue",
        }
    }

    /// Its width by its height.
    pub const fn aspect(self) -> f32 {
        match self {
            Self::Cavity => 2.5,
            Self::Upper | Self::Lower => 3.5,
            Self::Tongue => 0.9,
        }
    }

    /// The width that does it justice, in UV units: teeth at a millimetre and a half a texel of 1024.
    pub const fn widest(self) -> f32 {
        match self {
            Self::Cavity => 0.06,
            Self::Upper | Self::Lower => 0.12,
            Self::Tongue => 0.035,
        }
    }

    /// The width below which it is not worth having.
    pub const fn narrowest(self) -> f32 {
        self.widest() / 4.0
    }
}

/// A point of a part.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    /// In the mouth's coordinates.
    pub place: Vec3,
    /// How far it follows the jaw rather than the skull.
    pub lower: f32,
    /// The vertex of the rim that it follows, by its place along the rim, and how far.
    pub rim: Option<(usize, f32)>,
}

/// A corner's point.
#[derive(Debug, Clone, Copy)]
pub(super) enum Knot {
    /// A vertex of the rim, by its place along the rim.
    Rim(usize),
    /// One of the part's own points.
    Own(usize),
}

/// A part of a mouth.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    pub chart: Chart,
    pub points: Vec<Point>,
    /// Points with their coordinates in the chart.
    pub corners: Vec<(Knot, [f32; 2])>,
    /// Numbers in `corners`, counterclockwise where they are seen from.
    pub faces: Vec<[u32; 3]>,
}

impl Piece {
    pub const fn new(chart: Chart) -> Self {
        Self { chart, points: Vec::new(), corners: Vec::new(), faces: Vec::new() }
    }

    /// Adds a point of its own.
    pub fn point(&mut self, point: Point) -> Knot {
        self.points.push(point);
        Knot::Own(self.points.len() - 1)
    }

    /// Adds a grid of squares: `rows` of as many corners each. Squares are seen from where columns grow to the
    /// right and rows upwards, or downwards where `is_down`.
    pub fn grid(&mut self, rows: &[Vec<(Knot, [f32; 2])>], is_down: bool) {
        let first = self.corners.len() as u32;
        let columns = rows.first().map_or(0, Vec::len) as u32;
        rows.iter().for_each(|row| self.corners.extend_from_slice(row));
        for row in 1..rows.len() as u32 {
            for column in 1..columns {
                let at = |row: u32, column: u32| first + row * columns + column;
                let [a, b] = [at(row - 1, column - 1), at(row - 1, column)];
                let [c, d] = [at(row, column), at(row, column - 1)];
                self.faces.extend(if is_down {
                    [[a, d, c], [a, c, b]]
                } else {
                    [[a, b, c], [a, c, d]]
                });
            }
        }
    }
}
