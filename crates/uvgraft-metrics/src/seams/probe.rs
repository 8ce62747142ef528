//! Looking at a texture beside an edge.

use uvgraft::edges::{Edges, HalfEdge};
use uvgraft::mesh::Mesh;
use uvgraft::texture::Texture;

use super::SeamError;
use super::sample::{Sample, sample};
use super::walk::{DistanceSpace, HalfKind, Heading, Walker};

/// How far from an edge colours are taken, at right angles to it. Both go on into neighbouring
/// triangles where the edge's own is too narrow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Offset {
    /// Texels in the texture. The island is not left: where it is narrower, its far edge is read.
    Texels(f64),
    /// Distance on the surface, in the mesh's unit, over UV seams too. Where the surface ends before
    /// that, its end is read.
    Distance(f64),
}

impl Offset {
    pub(super) fn check(self) -> Result<(), SeamError> {
        let (Self::Texels(value) | Self::Distance(value)) = self;
        if value.is_finite() && value >= 0.0 { Ok(()) } else { Err(SeamError::Offset(value)) }
    }
}

/// A mesh and a texture, to look at.
pub(super) struct Probe<'a> {
    walker: Walker<'a>,
    texture: &'a Texture,
    ground: DistanceSpace,
    distance: f64,
}

/// What a look at one side of an edge gave.
pub(super) enum Fate {
    /// A colour.
    Observation(Observation),
    /// The triangle has no area.
    NoArea,
    /// Nothing there is opaque.
    Clear,
    /// The colour is no number.
    NotFinite,
}

/// A colour beside an edge.
pub(super) struct Observation {
    /// Where, in the texture's unit square.
    pub uv: [f64; 2],
    pub color: [f32; 3],
    /// Whether it is as far from the edge as it should be.
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
        let (ground, distance) = match offset {
            Offset::Texels(texels) => (DistanceSpace::Texels(texture.size()), texels),
            Offset::Distance(distance) => (DistanceSpace::Surface, distance),
        };
        Self { walker: Walker::new(mesh, edges, kinds), texture, ground, distance }
    }

    pub fn texture(&self) -> &Texture {
        self.texture
    }

    /// Whether a walk from a place on an edge to where its colour is taken, and a texel on, which is
    /// what filtering reads, meets no UV seam, no rim and no end of the surface.
    ///
    /// - `texel`: how long a texel is on the surface, about.
    pub fn is_undisturbed(&self, half: HalfEdge, at: f64, texel: f64) -> bool {
        let more = if self.ground == DistanceSpace::Surface { texel } else { 1.0 };
        let heading = Heading { along: 0.0, across: 1.0, distance: self.distance + more };
        let arrival = self.walker.walk(self.ground, half, at, heading);
        arrival.is_some_and(|arrival| arrival.complete && !arrival.crossed)
    }

    /// The colour beside a place on an edge, 0 at its start and 1 at its end, on its triangle's side.
    pub fn look(&self, half: HalfEdge, at: f64) -> Fate {
        let heading = Heading { along: 0.0, across: 1.0, distance: self.distance };
        let Some(arrival) = self.walker.walk(self.ground, half, at, heading) else {
            return Fate::NoArea;
        };
        match sample(self.texture, arrival.uv) {
            Sample::Color(color) => {
                Fate::Observation(Observation { uv: arrival.uv, color, complete: arrival.complete })
            }
            Sample::Clear => Fate::Clear,
            Sample::NotFinite => Fate::NotFinite,
        }
    }
}
