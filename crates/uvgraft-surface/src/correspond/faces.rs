//! Corresponding triangles of meshes that are the same: one topology, two layouts.
//!
//! Two ways are tried: faces with the same vertex indices, in any order, and faces in the same
//! order, whichever indices they use, since exporters split vertices along UV seams. Positions are
//! not compared as lengths: published versions of one mesh differ in shape.

use std::collections::HashSet;

use super::vertex_map::link_faces;
use crate::mesh::Mesh;
use crate::piece::Piece;
use crate::surface::Surface;

/// Least share of the smaller mesh's triangles that must correspond. Origin not recorded.
const ENOUGH: f64 = 0.9;

/// How faces correspond.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum SameFaces {
    /// They have the same vertex indices.
    Vertices,
    /// They come in the same order.
    Order,
}

/// Why the meshes are not versions of one mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FacesError {
    /// Neither indices nor order agree.
    #[error(
        "the meshes must have the same faces; {same} of {of} have the same vertex indices, and \
         {}", if *.in_order { "those in the same order are not connected alike" }
        else { "the numbers of faces differ" }
    )]
    Different {
        /// Triangles of both meshes with the same vertex indices.
        same: usize,
        /// Triangles of the smaller mesh.
        of: usize,
        /// Whether both have the same number of triangles.
        in_order: bool,
    },
}

/// Links equal faces. Polygons of either mesh may be retriangulated as in
/// [`Pair::by_vertex_map`](crate::Pair::by_vertex_map).
pub(super) fn pieces(
    source: &mut Mesh,
    target: &mut Mesh,
) -> Result<(Vec<Piece>, SameFaces), FacesError> {
    let of = source.faces().len().min(target.faces().len());
    let (mut fanned_source, mut fanned_target) = (source.clone(), target.clone());
    let found =
        link_faces(&mut fanned_source, &mut fanned_target, |vertex| vertex, |vertex| vertex);
    let same = distinct(&found);
    if same as f64 >= ENOUGH * of as f64 {
        (*source, *target) = (fanned_source, fanned_target);
        return Ok((found, SameFaces::Vertices));
    }
    let in_order = source.faces().len() == target.faces().len();
    if in_order && is_connected_alike(source, target) {
        let whole = |face| Piece::whole(face, face, [0, 1, 2]);
        return Ok(((0..of as u32).map(whole).collect(), SameFaces::Order));
    }
    Err(FacesError::Different { same, of, in_order })
}

/// The target faces among pieces in ascending order of them.
fn distinct(pieces: &[Piece]) -> usize {
    pieces.chunk_by(|one, other| one.target == other.target).count()
}

/// Whether faces in the same order have common corners in the same places. Vertices are welded,
/// and a few may be welded in one mesh only, such as lips that touch.
fn is_connected_alike(source: &Mesh, target: &Mesh) -> bool {
    const SLACK: f64 = 1.02;
    let [source, target] = [source, target].map(Surface::new);
    let corners = |surface: &Surface| surface.triangles().as_flattened().to_vec();
    let [source, target] = [corners(&source), corners(&target)];
    let count = |points: &[u32]| points.iter().collect::<HashSet<_>>().len();
    let pairs = source.iter().zip(&target).collect::<HashSet<_>>().len();
    // Points on a sheet have several corners each; loose triangles say nothing about connections.
    let fewest = count(&source).min(count(&target));
    let is_connected = fewest * 2 < source.len() || source.len() <= 6;
    is_connected && pairs as f64 <= SLACK * fewest as f64
}
