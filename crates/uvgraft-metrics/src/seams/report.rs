//! What is found at seams.

use super::Steps;

/// Steps between colours at the edges of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct SeamReport {
    /// Edges at which islands end: one side has another UV coordinate than the other.
    pub uv_seams: EdgeGroup,
    /// Those of them that have the region on both sides.
    pub uv_seams_inside: EdgeGroup,
    /// Edges at which the region ends, whether or not an island does.
    pub rim: EdgeGroup,
    /// Ordinary edges that have a vertex in common with a UV seam, to compare [`Self::uv_seams`] with.
    pub beside_uv_seams: EdgeGroup,
    /// Ordinary edges inside the region that have a vertex in common with one of
    /// [`Self::uv_seams_inside`].
    pub beside_uv_seams_inside: EdgeGroup,
    /// Ordinary edges that have a vertex in common with the rim, to compare [`Self::rim`] with.
    pub beside_rim: EdgeGroup,
    /// Edges that are neither, everywhere. Points of this and the other groups to compare with lie where
    /// neither a seam nor the rim is seen.
    pub ordinary: EdgeGroup,
    /// UV seams and rim, edge by edge, in the order of their triangles.
    pub edges: Vec<SeamEdge>,
    /// The worst places: indices into [`Self::edges`], those with the largest mean first. Those at UV
    /// seams are apart from each other by a fiftieth of what is measured across, and so are those at
    /// the rim, which a UV seam at the rim counts to.
    pub worst: Vec<usize>,
    /// What could not be measured as it should.
    pub notes: SeamNotes,
}

/// Edges of one kind.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct EdgeGroup {
    /// How many edges there are.
    pub edges: usize,
    /// Their length on the surface, in the mesh's unit.
    pub length: f64,
    /// How many points were measured along them.
    pub points: usize,
    /// How large the steps are; `None` if no point could be measured.
    pub delta_e: Option<Steps>,
}

/// An edge of the surface, and the steps along it.
#[derive(Debug, Clone, PartialEq)]
pub struct SeamEdge {
    /// Its two triangles, that of the region first where only one is.
    pub sides: [Side; 2],
    /// Its ends on the surface.
    pub ends: [[f32; 3]; 2],
    /// Its length on the surface, in the mesh's unit.
    pub length: f64,
    /// Whether the triangles' UV coordinates differ.
    pub is_uv_seam: bool,
    /// Whether the region has the first triangle but not the second.
    pub is_rim: bool,
    /// The mean of the steps along it; `None` if no point could be measured.
    pub mean: Option<f64>,
    /// The largest of the steps along it.
    pub worst: Option<Step>,
}

/// One side of an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// The triangle.
    pub face: u32,
    /// The edge runs from this corner (0, 1 or 2) of the triangle to the next, or back.
    pub corner: u8,
    /// Where the ends are in the texture's unit square, origin at the top left; in the same order on
    /// both sides.
    pub uv: [[f32; 2]; 2],
}

/// A step between two colours. Arrays have the two sides in the order of [`SeamEdge::sides`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// How large it is.
    pub delta_e: f64,
    /// Where along the edge: 0 at its first end, 1 at its second.
    pub along: f64,
    /// The place on the edge, in the texture's unit square.
    pub uv: [[f64; 2]; 2],
    /// The places that colours were taken at.
    pub sampled: [[f64; 2]; 2],
    /// The colours: sRGB, 1.0 for full.
    pub colors: [[f32; 3]; 2],
}

/// What could not be measured as it should. Points are those at UV seams and at the rim.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SeamNotes {
    /// Edges of triangles that have no triangle on the other side: borders of the mesh, and what is
    /// left where three meet.
    pub single_edges: usize,
    /// Triangles left out because two of their corners are in one place.
    pub collapsed_triangles: usize,
    /// Points left out because a triangle has no area to walk into.
    pub no_area: usize,
    /// Points left out because one side has no opacity.
    pub clear: usize,
    /// Points left out because a colour is no number, or infinite.
    pub not_finite: usize,
    /// Points that were measured closer to the edge because the surface, or in texels the island,
    /// ended before.
    pub shortened: usize,
    /// Points with a side outside the unit square, where the texture's edge is read.
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
