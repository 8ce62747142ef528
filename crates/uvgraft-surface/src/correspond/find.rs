//! Tries the methods that need nothing but the two meshes, the most exact first.

use super::faces::{self, FacesError, SameFaces};
use super::surface::{self, SurfaceError, SurfaceOptions, SurfaceReport};
use super::topology::{self, TopologyError, TopologyReport};
use super::vertex_map::OUTSIDE;
use crate::mesh::Mesh;
use crate::pair::{OtherLayouts, Pair};
use crate::piece::Piece;

/// Which methods to try.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum By {
    /// The same faces, then connectivity, then surfaces.
    #[default]
    Any,
    /// Only the same faces by their vertex indices or their order.
    Faces,
    /// Only connectivity.
    Topology,
    /// Only surfaces, by registration.
    Surface,
}

crate::choices!(By {
    Any => "auto", "The first of these methods that works";
    Faces => "faces", "Faces with the same vertex indices, or in the same order";
    Topology => "topology", "Connectivity: one mesh is part of the other";
    Surface => "surface", "Registration: the surfaces are laid over each other";
});

/// Settings of [`find`].
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct FindOptions {
    /// Which methods to try.
    pub by: By,
    /// Settings of the registration.
    pub surface: SurfaceOptions,
}

/// The method that linked two meshes, with what it reports.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Method {
    /// The meshes have the same faces.
    Faces(SameFaces),
    /// One mesh's connectivity was found in the other.
    Topology(TopologyReport),
    /// The target was registered to the source.
    Surface(SurfaceReport),
}

impl Method {
    /// The choice of this method alone.
    pub const fn by(&self) -> By {
        match self {
            Self::Faces(_) => By::Faces,
            Self::Topology(_) => By::Topology,
            Self::Surface(_) => By::Surface,
        }
    }

    /// What registration found, if the meshes were linked by it.
    pub const fn registered(&self) -> Option<&SurfaceReport> {
        match self {
            Self::Surface(report) => Some(report),
            _ => None,
        }
    }
}

/// Why a method did not link the meshes.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MethodFailure {
    /// [`By::Faces`].
    #[error("same faces: {0}")]
    Faces(#[from] FacesError),
    /// [`By::Topology`].
    #[error("connectivity: {0}")]
    Topology(#[from] TopologyError),
    /// [`By::Surface`].
    #[error("surfaces: {0}")]
    Surface(#[from] SurfaceError),
    /// Triangles correspond, but none of them lies in the unit square of its texture.
    #[error("{OUTSIDE}")]
    Outside,
}

/// A pair that was found, and how.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Correspondence {
    /// The linked meshes.
    pub pair: Pair,
    /// The method that linked them.
    pub method: Method,
    /// The methods before it, and why they did not.
    pub refused: Vec<MethodFailure>,
    /// Parts that the pair does not have, since they have textures of their own.
    pub other_layouts: Vec<OtherLayouts>,
}

/// No method links the meshes.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the meshes cannot be linked: {}", Refused(.0))]
pub struct FindError(pub Vec<MethodFailure>);

/// Shows refusals one after the other.
#[derive(Debug)]
pub struct Refused<'a>(pub &'a [MethodFailure]);

impl std::fmt::Display for Refused<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, refusal) in self.0.iter().enumerate() {
            let separator = if index > 0 { "; " } else { "" };
            write!(f, "{separator}{refusal}")?;
        }
        Ok(())
    }
}

/// Links two meshes by the first method that can: the same faces, then connectivity,
/// then surfaces.
///
/// Polygons may be retriangulated where the two meshes chose different diagonals. Triangles outside
/// the unit square of their layout are not linked. Parts with other textures than the linked ones are
/// left out: see [`Pair::in_one_layout`].
///
/// # Errors
/// [`FindError`] with each method's reason.
pub fn find(
    mut source: Mesh,
    mut target: Mesh,
    options: &FindOptions,
) -> Result<Correspondence, FindError> {
    let mut refused = Vec::new();
    for by in [By::Faces, By::Topology, By::Surface] {
        if options.by != By::Any && options.by != by {
            continue;
        }
        match attempt(&mut source, &mut target, by, &options.surface) {
            Err(refusal) => refused.push(refusal),
            Ok((pieces, method)) => {
                let pair = Pair::of_found(source, target, pieces)
                    .ok_or_else(|| FindError(vec![MethodFailure::Outside]))?;
                let (pair, other_layouts) = pair.in_one_layout();
                let found = Correspondence { pair, method, refused, other_layouts };
                let is_registered = by == By::Surface && !found.other_layouts.is_empty();
                return Ok(if is_registered { again(found, &options.surface) } else { found });
            }
        }
    }
    Err(FindError(refused))
}

/// Registers surfaces once more, without the parts that were left out: hair and clothes draw a
/// registration to them.
fn again(found: Correspondence, options: &SurfaceOptions) -> Correspondence {
    let [mut source, mut target] = [found.pair.source(), found.pair.target()].map(Mesh::clone);
    let registered = attempt(&mut source, &mut target, By::Surface, options).ok();
    let registered = registered
        .and_then(|(pieces, method)| Some((Pair::of_found(source, target, pieces)?, method)));
    match registered {
        Some((pair, method)) => Correspondence { pair, method, ..found },
        None => found,
    }
}

fn attempt(
    source: &mut Mesh,
    target: &mut Mesh,
    by: By,
    surface: &SurfaceOptions,
) -> Result<(Vec<Piece>, Method), MethodFailure> {
    match by {
        By::Any | By::Faces => {
            let (pieces, how) = faces::pieces(source, target)?;
            Ok((pieces, Method::Faces(how)))
        }
        By::Topology => {
            let (pieces, report) = topology::pieces(source, target)?;
            Ok((pieces, Method::Topology(report)))
        }
        By::Surface => {
            let (pieces, report) = surface::pieces(source, target, surface)?;
            Ok((pieces, Method::Surface(report)))
        }
    }
}
