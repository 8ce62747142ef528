//! Sampling a texture next to an edge.

use uvgraft::edges::{Edges, HalfEdge};
use uvgraft::mesh::Mesh;
use uvgraft::texture::Texture;

use super::SeamError;
use super::sample::{Sample, sample};
use super::walk::{DistanceSpace, HalfKind, Heading, Walker};

/// Distance from an edge at which colours are sampled, perpendicular to it. Where the edge's own
/// triangle is too narrow, both variants continue into neighbouring triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Offset {
    /// Texels in the texture, within the same island: where that is narrower, its far
    /// edge is sampled.
    Texels(f64),
    /// Distance on the surface, in mesh units, across UV seams. Where the surface ends earlier, its
    /// end is sampled.
    Distance(f64),
}

impl Offset {
    pub(super) fn check(self) -> Result<(), SeamError> {
        let (Self::Texels(value) | Self::Distance(value)) = self;
        if value.is_finite() && value >= 0.0 { Ok(()) } else { Err(SeamError::Offset(value)) }
    }
}

/// A mesh and the texture to sample.
pub(super) struct Probe<'a> {
    walker: Walker<'a>,
    texture: &'a Texture,
    space: DistanceSpace,
    distance: f64,
}

/// The result of sampling one side of an edge.
pub(super) enum Outcome {
    /// A colour.
    Color(Color),
    /// The triangle has no area.
    NoArea,
    /// All texels there are transparent.
    Clear,
    /// The colour is NaN or infinite.
    NotFinite,
}

/// A colour next to an edge.
pub(super) struct Color {
    /// The sampled point, in the texture's unit square.
    pub uv: [f64; 2],
    pub color: [f32; 3],
    /// Whether it lies at the full distance from the edge.
    pub complete: bool,
}

impl<'a> Probe<'a> {
    pub fn new(
        mesh: &'a Mesh,
        edges: &'a Edges,
        kinds: &'a [HalfKind],
        texture: &'a Texture,
        offset: Offset,
    ) -> Self {
        let (space, distance) = match offset {
            Offset::Texels(texels) => (DistanceSpace::Texels(texture.size()), texels),
            Offset::Distance(distance) => (DistanceSpace::Surface, distance),
        };
        Self { walker: Walker::new(mesh, edges, kinds), texture, space, distance }
    }

    pub fn texture(&self) -> &Texture {
        self.texture
    }

    /// Whether a walk from a point on an edge to its sample, and one texel beyond, which filtering
    /// reads, crosses no UV seam, no region boundary and no boundary of the surface.
    ///
    /// - `texel`: approximate size of a texel on the surface.
    pub fn is_undisturbed(&self, half: HalfEdge, at: f64, texel: f64) -> bool {
        let more = if self.space == DistanceSpace::Surface { texel } else { 1.0 };
        let heading = Heading { along: 0.0, across: 1.0, distance: self.distance + more };
        let arrival = self.walker.walk(self.space, half, at, heading);
        arrival.is_some_and(|arrival| arrival.complete && !arrival.crossed)
    }

    /// The colour next to a point on a half-edge (0 at its start, 1 at its end), on its
    /// triangle's side.
    pub fn color_at(&self, half: HalfEdge, at: f64) -> Outcome {
        let heading = Heading { along: 0.0, across: 1.0, distance: self.distance };
        let Some(arrival) = self.walker.walk(self.space, half, at, heading) else {
            return Outcome::NoArea;
        };
        match sample(self.texture, arrival.uv) {
            Sample::Color(color) => {
                Outcome::Color(Color { uv: arrival.uv, color, complete: arrival.complete })
            }
            Sample::Clear => Outcome::Clear,
            Sample::NotFinite => Outcome::NotFinite,
        }
    }
}
