//! Results of measuring seams.

use super::StepStatistics;

/// Colour differences at the edges of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct SeamReport {
    /// Edges at which UV islands end: the two sides have different UV coordinates.
    pub uv_seams: EdgeGroup,
    /// UV seams with the region on both sides.
    pub uv_seams_inside: EdgeGroup,
    /// Edges at which the region ends, on a UV seam or not.
    pub rim: EdgeGroup,
    /// Ordinary edges that share a vertex with a UV seam, to compare with [`Self::uv_seams`].
    pub beside_uv_seams: EdgeGroup,
    /// Ordinary edges inside the region that share a vertex with one of [`Self::uv_seams_inside`].
    pub beside_uv_seams_inside: EdgeGroup,
    /// Ordinary edges that share a vertex with the region boundary, to compare with [`Self::rim`].
    pub beside_rim: EdgeGroup,
    /// All ordinary edges, which are neither. Points of this and the other comparison groups lie
    /// where neither a seam nor the region boundary affects the samples.
    pub ordinary: EdgeGroup,
    /// UV seams and the region boundary, edge by edge, in the order of their triangles.
    pub edges: Vec<SeamEdge>,
    /// The worst edges: indices into [`Self::edges`], in descending order of their mean. Those at
    /// UV seams keep a distance of a fiftieth of the measured extent from each other, and so do
    /// those at the region boundary, which include UV seams there.
    pub worst: Vec<usize>,
    /// Problems during the measurement.
    pub notes: SeamNotes,
}

/// Edges of one class.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct EdgeGroup {
    /// Number of edges.
    pub edges: usize,
    /// Their length on the surface, in mesh units.
    pub length: f64,
    /// Number of points measured along them.
    pub points: usize,
    /// Statistics of the steps; `None` if no point could be measured.
    pub delta_e: Option<StepStatistics>,
}

/// An edge of the surface, and the steps along it.
#[derive(Debug, Clone, PartialEq)]
pub struct SeamEdge {
    /// Its two triangles. If only one belongs to the region, it is the first.
    pub sides: [SeamSide; 2],
    /// Its ends on the surface.
    pub ends: [[f32; 3]; 2],
    /// Its length on the surface, in mesh units.
    pub length: f64,
    /// Whether the UV coordinates of the two triangles differ.
    pub is_uv_seam: bool,
    /// Whether the first triangle belongs to the region and the second does not.
    pub is_rim: bool,
    /// Whether both triangles belong to the region.
    pub is_inside: bool,
    /// The mean of the steps along it; `None` if no point could be measured.
    pub mean: Option<f64>,
    /// The largest of the steps along it.
    pub worst: Option<Step>,
}

/// One side of an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeamSide {
    /// The triangle.
    pub face: u32,
    /// The edge runs from this corner (0, 1 or 2) of the triangle to the next, or in the
    /// opposite direction.
    pub corner: u8,
    /// The ends in the texture's unit square, origin at the top left, in the same order on both
    /// sides.
    pub uv: [[f32; 2]; 2],
}

/// The difference between two colours. Arrays have the two sides in the order of
/// [`SeamEdge::sides`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The difference in ΔE₀₀.
    pub delta_e: f64,
    /// Position along the edge: 0 at its first end, 1 at its second.
    pub along: f64,
    /// The point on the edge, in the texture's unit square.
    pub uv: [[f64; 2]; 2],
    /// The points at which colours were sampled.
    pub sampled: [[f64; 2]; 2],
    /// The colours: sRGB, 1.0 at full intensity.
    pub colors: [[f32; 3]; 2],
}

/// Problems during the measurement. Points are those at UV seams and at the region boundary.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SeamNotes {
    /// Half-edges without a triangle on the other side: boundaries of the mesh, and what remains
    /// where three triangles meet.
    pub single_edges: usize,
    /// Triangles skipped because two of their corners coincide.
    pub collapsed_triangles: usize,
    /// Points skipped because a triangle has no area to walk into.
    pub no_area: usize,
    /// Points skipped because one side is transparent.
    pub clear: usize,
    /// Points skipped because a colour is NaN or infinite.
    pub not_finite: usize,
    /// Points measured closer to the edge than requested, because the surface or, for an offset in
    /// texels, the island ended earlier.
    pub shortened: usize,
    /// Points with a side outside the unit square, where the texture's edge is repeated.
    pub outside: usize,
}

impl SeamNotes {
    pub(super) fn add(&mut self, points: &Self) {
        self.no_area += points.no_area;
        self.clear += points.clear;
        self.not_finite += points.not_finite;
        self.shortened += points.shortened;
        self.outside += points.outside;
    }
}
