//! Parts of a mouth under construction: points, and triangles with coordinates in a chart.

use glam::Vec3;

/// The UV island of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Chart {
    Cavity,
    Upper,
    Lower,
    Tongue,
}

impl Chart {
    /// Name for messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cavity => "cavity",
            Self::Upper => "upper teeth",
            Self::Lower => "lower teeth",
            Self::Tongue => "tongue",
        }
    }

    /// Its width divided by its height.
    pub const fn aspect(self) -> f32 {
        match self {
            Self::Cavity => 2.5,
            Self::Upper | Self::Lower => 3.5,
            Self::Tongue => 0.9,
        }
    }

    /// Width for full detail, in UV units: about 1.4 texels for each millimetre of teeth at 1024
    /// texels.
    pub const fn widest(self) -> f32 {
        match self {
            Self::Cavity => 0.06,
            Self::Upper | Self::Lower => 0.12,
            Self::Tongue => 0.035,
        }
    }

    /// Minimum width that is still useful.
    pub const fn narrowest(self) -> f32 {
        self.widest() / 4.0
    }
}

/// A point of a part.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    /// In mouth coordinates.
    pub position: Vec3,
    /// Weight of the jaw against the skull.
    pub lower: f32,
    /// The rim vertex that it follows, by its index in the rim, and the weight.
    pub rim: Option<(usize, f32)>,
}

/// The vertex of a corner.
#[derive(Debug, Clone, Copy)]
pub(super) enum Knot {
    /// A vertex of the rim, by its index in the rim.
    Rim(usize),
    /// A point of the part.
    Own(usize),
}

/// A part of a mouth.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    pub chart: Chart,
    pub points: Vec<Point>,
    /// Vertices with their coordinates in the chart.
    pub corners: Vec<(Knot, [f32; 2])>,
    /// Indices into `corners`, counterclockwise as seen from the visible side.
    pub faces: Vec<[u32; 3]>,
}

impl Piece {
    pub const fn new(chart: Chart) -> Self {
        Self { chart, points: Vec::new(), corners: Vec::new(), faces: Vec::new() }
    }

    /// Adds a point.
    pub fn point(&mut self, point: Point) -> Knot {
        self.points.push(point);
        Knot::Own(self.points.len() - 1)
    }

    /// Adds a grid of quads: `rows` with equal numbers of corners. The visible side is that from
    /// which columns run to the right and rows upwards, or downwards with `is_down`.
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
