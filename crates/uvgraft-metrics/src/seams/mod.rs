//! Visibility of seams: colour differences across edges.
//!
//! A texture is continuous on the surface only within a UV island. Where an island ends, the
//! surface continues in another one, whose texels were painted, filtered or transferred separately;
//! and where a transferred region ends, two textures meet. [`measure`] walks along those edges,
//! samples the colours on both sides and computes their perceptual difference
//! ([`delta_e`](uvgraft::color::delta_e)). Ordinary edges, at which neither an island nor the
//! region ends, show how much neighbouring colours of the texture differ anyway.
//!
//! A blend may hide the boundary of a face whose skin tone differs from the body's.
//! [`measure_tone`] compares cheeks with the chest, and a transferred face with its original.

mod along;
mod edge_class;
mod pasted;
mod probe;
mod report;
mod sample;
mod statistics;
mod tone;
mod unfold;
mod walk;
mod worst;

use uvgraft::color::Encoding;
use uvgraft::edges::{Edges, NO_HALF_EDGE, SharedEdge};
use uvgraft::mesh::Mesh;
use uvgraft::texture::{Size, Texture};
use uvgraft::threads;

use along::{Walked, along, step};
use edge_class::{EdgeClass, kinds_by_half, point_count};
pub use pasted::TransferredFace;
pub use probe::Offset;
use probe::Probe;
pub use report::{EdgeGroup, SeamEdge, SeamNotes, SeamReport, SeamSide, Step};
pub use statistics::StepStatistics;
pub use tone::{SkinColors, ToneMatch, ToneReferences, measure_tone};
pub use unfold::Unfolded;
use worst::worst;

/// Options for measuring seams.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SeamOptions {
    /// Distance from the edge at which colours are sampled, on each side.
    pub offset: Offset,
    /// Maximum number of worst edges to report, for UV seams and for the region boundary each.
    pub worst: usize,
}

impl SeamOptions {
    /// Sets the sampling distance from the edge.
    #[must_use]
    pub const fn offset(self, offset: Offset) -> Self {
        Self { offset, ..self }
    }

    /// Sets the maximum number of worst edges to report.
    #[must_use]
    pub const fn worst(self, worst: usize) -> Self {
        Self { worst, ..self }
    }
}

impl Default for SeamOptions {
    /// One texel, five edges of each kind.
    fn default() -> Self {
        Self { offset: Offset::Texels(1.0), worst: 5 }
    }
}

/// Why seams could not be measured.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SeamError {
    /// The texture holds data such as normals, roughness or a mask.
    #[error("the texture must hold colours, got data")]
    NotColor,
    /// The region belongs to another mesh.
    #[error("the region must cover the mesh's {wanted} triangles, got {found}")]
    Region {
        /// Number of triangles in the region's array.
        found: usize,
        /// Number of triangles of the mesh.
        wanted: usize,
    },
    /// The offset is negative or not finite.
    #[error("the offset from the edge must be finite and at least 0, got {0}")]
    Offset(f64),
    /// A reference texture differs in size from the texture.
    #[error("the {what} must have the size of the texture, {wanted}, got {found}")]
    Size {
        /// `"base"` or `"face"`.
        what: &'static str,
        /// Its size.
        found: Size,
        /// The size of the texture.
        wanted: Size,
    },
}

/// Maximum number of points at which a control group is measured, evenly spaced along all its
/// edges.
const MAX_CONTROLS: usize = 1 << 13;
/// Distance in texels that points of control groups keep from vertices of seams, because filtering
/// reads one texel beyond a point in either direction.
const CONTROL_MARGIN: f64 = 1.5;
/// Edges or points per task.
const CHUNK: usize = 64;

/// Measures the colour differences at UV seams and at the boundary of a region.
///
/// - `mesh`: its surface determines which triangles are adjacent, its layout where they are in the
///   texture. Vertices at the same position are one vertex; see [`SeamNotes`] for edges that more
///   than two triangles share.
/// - `texture`: sRGB or linear, compared by [`delta_e`](uvgraft::color::delta_e). Texels are
///   filtered bilinearly; outside the unit square the texture's edge is repeated.
/// - `inside`: `[triangles]`, whether each belongs to the region.
///
/// Points lie along each edge about one texel apart, on the side that has more texels. On each side
/// the colour is sampled at [`SeamOptions::offset`] from there. Every point is weighted by the
/// length on the surface that it represents. The result does not depend on the number of threads.
///
/// # Errors
/// [`SeamError`] for a texture of data, a region that does not match the mesh, or an
/// invalid offset.
pub fn measure(
    mesh: &Mesh,
    texture: &Texture,
    inside: &[bool],
    options: &SeamOptions,
) -> Result<SeamReport, SeamError> {
    if texture.encoding() == Encoding::Data {
        return Err(SeamError::NotColor);
    }
    check_region(mesh, inside)?;
    options.offset.check()?;
    let edges = Edges::new(mesh);
    let kinds: Vec<EdgeClass> =
        edges.shared.iter().map(|edge| EdgeClass::of(mesh, edge, inside)).collect();
    let by_half = kinds_by_half(&edges, &kinds);
    let probe = Probe::new(mesh, &edges, &by_half, texture, options.offset);
    let survey = Survey { mesh, edges: &edges, kinds: &kinds, probe };
    let measured = survey.measured(inside);
    let mut notes = SeamNotes {
        single_edges: edges.single,
        collapsed_triangles: edges.collapsed,
        ..SeamNotes::default()
    };
    measured.iter().for_each(|edge| notes.add(&edge.notes));
    let of_kind = |wanted: &dyn Fn(EdgeClass) -> bool| {
        EdgeGroup::of(measured.iter().filter(|edge| wanted(edge.kind)))
    };
    let mut report = SeamReport {
        uv_seams: of_kind(&|kind| kind.is_uv_seam),
        uv_seams_inside: of_kind(&|kind| kind.is_uv_seam && kind.is_inside),
        rim: of_kind(&|kind| kind.is_rim),
        beside_uv_seams: survey.ordinary(|_| true, Some(&|kind| kind.is_uv_seam)),
        beside_uv_seams_inside: survey
            .ordinary(|kind| kind.is_inside, Some(&|kind| kind.is_uv_seam && kind.is_inside)),
        beside_rim: survey.ordinary(|_| true, Some(&|kind| kind.is_rim)),
        ordinary: survey.ordinary(|_| true, None),
        edges: Vec::new(),
        worst: Vec::new(),
        notes,
    };
    report.edges = measured.into_iter().map(|edge| edge.seam).collect();
    report.worst = worst(&report.edges, options.worst);
    Ok(report)
}

fn check_region(mesh: &Mesh, inside: &[bool]) -> Result<(), SeamError> {
    let (found, wanted) = (inside.len(), mesh.faces().len());
    if found == wanted { Ok(()) } else { Err(SeamError::Region { found, wanted }) }
}

/// The inputs of a measurement.
struct Survey<'a> {
    mesh: &'a Mesh,
    edges: &'a Edges,
    /// `[shared edges]`
    kinds: &'a [EdgeClass],
    probe: Probe<'a>,
}

impl Survey<'_> {
    /// Steps at UV seams and at the region boundary, edge by edge.
    fn measured(&self, inside: &[bool]) -> Vec<Walked> {
        let oriented = |edge: &SharedEdge| {
            let [a, b] = edge.halves.map(|half| inside[half as usize / 3]);
            if b && !a { edge.swapped() } else { *edge }
        };
        let members: Vec<(SharedEdge, EdgeClass)> = self
            .with_kinds()
            .filter(|(_, kind)| kind.is_uv_seam || kind.is_rim)
            .map(|(edge, kind)| (oriented(edge), kind))
            .collect();
        let chunks = threads::map_indices(members.len().div_ceil(CHUNK), |chunk| {
            let part = &members[chunk * CHUNK..members.len().min((chunk + 1) * CHUNK)];
            let measure =
                |(edge, kind): &(SharedEdge, EdgeClass)| along(self.mesh, &self.probe, edge, *kind);
            part.iter().map(measure).collect::<Vec<_>>()
        });
        chunks.into_iter().flatten().collect()
    }

    /// Steps at ordinary edges, for comparison: those that `is_wanted` accepts and that
    /// share a vertex with an edge accepted by `beside`, if it is given.
    fn ordinary(
        &self,
        is_wanted: impl Fn(EdgeClass) -> bool,
        beside: Option<&dyn Fn(EdgeClass) -> bool>,
    ) -> EdgeGroup {
        let is_near = beside.map(|wanted| {
            let mut is_near = vec![false; self.edges.vertex_count];
            for (edge, _) in self.with_kinds().filter(|(_, kind)| wanted(*kind)) {
                for vertex in self.edges.ends(edge.halves[0]) {
                    is_near[vertex as usize] = true;
                }
            }
            is_near
        });
        let is_beside = |edge: &SharedEdge| {
            let ends = self.edges.ends(edge.halves[0]);
            is_near.as_ref().is_none_or(|near| ends.iter().any(|&vertex| near[vertex as usize]))
        };
        let members: Vec<SharedEdge> = self
            .with_kinds()
            .filter(|(_, kind)| !kind.is_uv_seam && !kind.is_rim)
            .filter(|(edge, kind)| is_wanted(*kind) && is_beside(edge))
            .map(|(edge, _)| *edge)
            .collect();
        self.control(&members)
    }

    /// Steps at points spaced evenly along edges, as if these were one long edge. Points
    /// whose samples a seam or the region boundary would disturb are left out, or the group would
    /// measure the seams that it is to be compared with.
    fn control(&self, members: &[SharedEdge]) -> EdgeGroup {
        let (mesh, texture) = (self.mesh, self.probe.texture());
        let mut length = 0.0;
        let mut wanted = 0;
        let mut starts = Vec::with_capacity(members.len());
        for edge in members {
            starts.push(length);
            length += edge.length(mesh);
            wanted += point_count(edge, mesh, texture);
        }
        let is_disturbed = self.disturbed_vertices();
        let count = wanted.min(MAX_CONTROLS);
        let step_at = |point: usize| {
            let at = (point as f64 + 0.5) / count as f64 * length;
            let index = starts.partition_point(|&start| start <= at).checked_sub(1)?;
            let edge = &members[index];
            let along = ((at - starts[index]) / edge.length(mesh)).clamp(0.0, 1.0);
            let texels = edge.texels(mesh, texture.size());
            let [from, to] = self.edges.ends(edge.halves[0]);
            let ends = [(from, along), (to, 1.0 - along)];
            let is_near = |(vertex, away): (u32, f64)| {
                is_disturbed[vertex as usize] && away * texels < CONTROL_MARGIN
            };
            let texel = edge.length(mesh) / texels;
            if ends.into_iter().any(is_near)
                || !edge
                    .at(along)
                    .iter()
                    .all(|&(half, at)| self.probe.is_undisturbed(half, at, texel))
            {
                return None;
            }
            let step = step(mesh, &self.probe, edge, along, &mut SeamNotes::default())?;
            // All points have equal weight.
            Some((step.delta_e, 1.0))
        };
        let chunks = threads::map_indices(count.div_ceil(CHUNK), |chunk| {
            let points = chunk * CHUNK..count.min((chunk + 1) * CHUNK);
            points.filter_map(step_at).collect::<Vec<_>>()
        });
        let steps: Vec<(f64, f64)> = chunks.into_iter().flatten().collect();
        let points = steps.len();
        EdgeGroup { edges: members.len(), length, points, delta_e: StepStatistics::of(steps) }
    }

    /// The vertices on UV seams, on the region boundary and on the boundary of the surface.
    fn disturbed_vertices(&self) -> Vec<bool> {
        let mut is_disturbed = vec![false; self.edges.vertex_count];
        let seams = self.with_kinds().filter(|(_, kind)| kind.is_uv_seam || kind.is_rim);
        let ends = self.edges.opposite.iter().zip(0..).filter(|(other, _)| **other == NO_HALF_EDGE);
        let halves = seams.map(|(edge, _)| edge.halves[0]).chain(ends.map(|(_, half)| half));
        for vertex in halves.flat_map(|half| self.edges.ends(half)) {
            is_disturbed[vertex as usize] = true;
        }
        is_disturbed
    }

    fn with_kinds(&self) -> impl Iterator<Item = (&SharedEdge, EdgeClass)> {
        self.edges.shared.iter().zip(self.kinds.iter().copied())
    }
}

impl EdgeGroup {
    fn of<'a>(members: impl Iterator<Item = &'a Walked>) -> Self {
        let (mut edges, mut length, mut steps) = (0, 0.0, Vec::new());
        for edge in members {
            edges += 1;
            length += edge.seam.length;
            let weight = edge.seam.length / edge.points as f64;
            steps.extend(edge.steps.iter().map(|&step| (step, weight)));
        }
        Self { edges, length, points: steps.len(), delta_e: StepStatistics::of(steps) }
    }
}

#[cfg(test)]
mod tests;
