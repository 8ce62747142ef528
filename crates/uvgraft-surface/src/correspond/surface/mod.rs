//! Corresponding parts of triangles from surfaces alone: meshes of other topology and shape.
//!
//! The target is brought into the source's place, its points are moved onto the source's
//! surface, and the two surfaces are laid over each other exactly.

mod align;
mod check;
pub(crate) mod equations;
mod kinds;
mod overlay;
mod placed;
mod register;
pub(crate) mod shape;
mod worn;

use std::sync::Arc;

use glam::DVec3;

use self::align::Heads;
use self::equations::Anchor;
use self::kinds::{TriangleKind, TriangleKinds};
pub(super) use self::placed::placed;
use self::register::{Anchors, Goal};
use self::shape::Shape;
use self::worn::component_count;
use super::similarity::Similarity;
use crate::anatomy::{self, AnatomyError, Landmark};
use crate::mesh::Mesh;
use crate::piece::Piece;
use crate::sparse::Filled;
use crate::statistics::median;
use crate::surface::Surface;
use crate::triangle_tree::{Bounds, Effort};

/// How the target is brought into the source's place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Align {
    /// Not at all: the meshes lie over each other as they are.
    None,
    /// Rotated and moved.
    Rigid,
    /// Rotated, moved and scaled.
    #[default]
    Similarity,
}

crate::choices!(Align {
    None => "none", "Leave it where it is";
    Rigid => "rigid", "Rotate and move it";
    Similarity => "similarity", "Rotate, move and scale it";
});
#[cfg(feature = "serde")]
crate::serialize_by_name!(Align);

/// Settings of the registration.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SurfaceOptions {
    /// How the target is brought into the source's place.
    pub align: Align,
    /// Source vertex and target vertex at the same place of the surface, by index. Without any,
    /// heads are found by their shape.
    pub landmarks: Vec<[u32; 2]>,
    /// The same by positions, for places between vertices: on the source and on the target.
    pub places: Vec<[[f32; 3]; 2]>,
    /// Farthest that a partner may be from a registered point, as a share of the height of a head
    /// (of the whole mesh, if it has no head).
    pub reach: f64,
    /// Least cosine of the angle between the normals of corresponding triangles.
    pub visibility: f64,
}

impl Default for SurfaceOptions {
    fn default() -> Self {
        let (landmarks, places) = (Vec::new(), Vec::new());
        Self { align: Align::default(), landmarks, places, reach: 0.02, visibility: 0.3 }
    }
}

/// Why surfaces cannot be registered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// There is nothing that says which part of one mesh is which of the other.
    #[error(
        "the meshes must lie over each other, both have a head, or be given landmarks; {side} mesh: \
         {reason}"
    )]
    NoAlignment {
        /// `"source"` or `"target"`.
        side: &'static str,
        /// Why no head was found.
        reason: AnatomyError,
    },
    /// Landmarks that determine no transform.
    #[error("landmarks must be at least 3 pairs of vertices that are not on a line, got {count}")]
    Landmarks {
        /// How many pairs there are.
        count: usize,
    },
    /// A landmark that is not a vertex.
    #[error("landmark {index}: {side} vertex must be less than {vertices}, got {found}")]
    Landmark {
        /// Which pair, from 0.
        index: usize,
        /// `"source"` or `"target"`.
        side: &'static str,
        /// The vertex.
        found: u32,
        /// How many vertices the mesh has.
        vertices: usize,
    },
    /// A mesh without area.
    #[error("the {side} mesh must have an area")]
    NoArea {
        /// `"source"` or `"target"`.
        side: &'static str,
    },
    /// What lies on the face of the source was turned too much to be a face.
    #[error(
        "the target does not fit the source: what lies on the source's face is turned by {degrees:.0}° in \
         the median, must be at most {most:.0}°; check the landmarks or give some, or use meshes without \
         hair and clothes"
    )]
    Turned {
        /// The median angle.
        degrees: f64,
        /// The largest accepted.
        most: f64,
    },
    /// Landmarks of both heads that lie apart.
    #[error(
        "the target does not fit the source: the {} of its head lies {apart:.1} distances between the \
         eyes from that of the source, must be at most {most:.1}", landmark.name()
    )]
    Apart {
        /// The landmark.
        landmark: Landmark,
        /// The distance, in distances between the source's eyes.
        apart: f64,
        /// The largest accepted.
        most: f64,
    },
    /// Nothing of the registered target is near the source.
    #[error("no part of the target lies on the source after registration")]
    Nothing,
    /// Triangles that lie over each other everywhere, such as random ones.
    #[error(
        "the triangles of a mesh must make up a surface, these lie over each other: closest points were \
         not found within {steps} steps, the most for meshes of this size"
    )]
    Overlaid {
        /// The limit.
        steps: u64,
    },
    /// Vertices that are connected with others all over the mesh.
    #[error(
        "the target's triangles must make up a surface, these connect points with too many others: its \
         equations would take more memory than those of any surface"
    )]
    Connected,
}

/// What registration found. Lengths are in the source's unit.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct SurfaceReport {
    /// How the target was aligned: `"positions"`, `"heads"` or `"landmarks"`.
    pub aligned_by: &'static str,
    /// The matrix, in rows, that takes the target's vertices into the source's place before they are
    /// moved onto its surface.
    pub alignment: [[f64; 4]; 4],
    /// Median distance of registered points from the source, where linked.
    pub distance_median: f64,
    /// Its 95th percentile.
    pub distance_p95: f64,
    /// Triangles that are seen from outside, are near the source and were turned over by registration.
    /// They are not linked.
    pub flipped: usize,
    /// Triangles of components over the skin of the target's head, such as hair, glasses and clothes,
    /// where the source wears nothing. They are not linked.
    pub worn: usize,
    /// Angle between the faces of both heads, in degrees, where landmarks or positions aligned the meshes
    /// and both heads were found.
    pub heads_turned: Option<f64>,
    /// Share of the target's area with a counterpart.
    pub covered: f64,
    /// The registered target: its vertices' positions in the source's space.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub registered: Vec<[f32; 3]>,
}

impl SurfaceReport {
    /// A warning, if the alignment lays the face of one head over another side of the other.
    pub fn warning(&self) -> Option<String> {
        /// Right landmarks between FLAME, SMPL-X and HiFi3D++ turn faces by up to 5 degrees, those of a face
        /// on a nape or upside down by 180.
        const MOST: f64 = 60.0;
        let degrees = self.heads_turned.filter(|&degrees| degrees > MOST)?;
        Some(format!(
            "the {} lay the target's head over the source's turned by {degrees:.0} degrees, as both faces \
             were found; if what is linked is not the same place, {}",
            self.aligned_by,
            match self.aligned_by {
                "landmarks" => "check their order, and left and right",
                _ => "turn one of the meshes, or let them be aligned",
            }
        ))
    }
}

/// Registers the target to the source and lays one over the other.
pub(super) fn pieces(
    source: &Mesh,
    target: &Mesh,
    options: &SurfaceOptions,
) -> Result<(Vec<Piece>, SurfaceReport), SurfaceError> {
    let surfaces = [source, target].map(Surface::new);
    for (surface, side) in surfaces.iter().zip(["source", "target"]) {
        let area: f64 = (0..surface.triangles().len() as u32).map(|t| surface.area(t)).sum();
        if !(area.is_normal()) {
            return Err(SurfaceError::NoArea { side });
        }
    }
    let effort = Effort::new(most_steps(&surfaces));
    let spent = || match effort.is_spent() {
        true => Err(SurfaceError::Overlaid { steps: effort.most() }),
        false => Ok(()),
    };
    let placement = place(source, target, &surfaces, options, &effort);
    spent()?;
    let placement = placement?;
    let unit = placement.unit;
    // Centred and scaled, so that constants and rounding mean the same in any unit.
    let to_unit = |point: DVec3| (point - placement.center) / unit;
    let mut goal = Goal::new(Shape::new(&surfaces[0], to_unit), &effort);
    let aligned = placement.transform;
    let mut rest = Shape::new(&surfaces[1], |point| to_unit(aligned.apply(point)));
    let balls = [source, target].map(anatomy::balls);
    let worn = &placement.worn;
    let mut kinds =
        TriangleKinds::new([&goal.shape, &rest], balls, worn, to_unit, &aligned, unit, &effort);
    spent()?;
    goal.kinds = kinds.source;
    if !placement.is_exact {
        kinds.moves.iter().for_each(|ball| ball.apply(&mut rest));
    }
    let places = anchors(&placement.landmarks, &rest, to_unit, &aligned);
    let are_given = placement.aligned_by == "landmarks";
    let stages = if are_given { Anchors::GIVEN } else { Anchors::FOUND };
    let anchors = Anchors { places, stages };
    let registered = if placement.is_exact {
        rest.clone()
    } else {
        let points = register::register(&rest, &kinds.target, &goal, &anchors);
        spent()?;
        Shape { points: points.map_err(|Filled| SurfaceError::Connected)?, ..rest.clone() }
    };
    let flipped =
        leave_out_turned_over(&mut kinds.target, [&rest, &registered], &goal, options.reach);
    let overlay =
        overlay::overlay(&goal, &registered, &kinds.target, options.reach, options.visibility);
    spent()?;
    if overlay.pieces.is_empty() {
        return Err(SurfaceError::Nothing);
    }
    if !placement.is_exact {
        check::check(source, &placement, &rest, &registered, &overlay, to_unit)?;
    }
    let report = report(&placement, &registered, &overlay, flipped, target, &surfaces[1]);
    Ok((overlay.pieces, report))
}

/// Leaves the triangles unlinked that the registration turned over, and counts those that would be
/// linked otherwise.
fn leave_out_turned_over(
    kinds: &mut [TriangleKind],
    [rest, registered]: [&Shape; 2],
    goal: &Goal,
    reach: f64,
) -> usize {
    let mut flipped = 0;
    for triangle in register::turned_over(rest, registered) {
        let kind = &mut kinds[triangle];
        let center = registered.corners(triangle).into_iter().sum::<DVec3>() / 3.0;
        let nearest = goal.tree.nearest(center, reach, |_| true);
        flipped += usize::from(!kind.is_hidden() && nearest.is_some());
        *kind = kind.alone();
    }
    flipped
}

/// How many boxes and triangles may be looked at to find closest points.
fn most_steps(surfaces: &[Surface; 2]) -> u64 {
    /// FLAME, SMPL-X and HiFi3D++ take 1,700 to 6,600 for each triangle, 500 random triangles 10,000, and
    /// twice as many twice as much.
    const PER_TRIANGLE: u64 = 40_000;
    const LEAST: u64 = 5_000_000;
    let triangles: usize = surfaces.iter().map(|surface| surface.triangles().len()).sum();
    LEAST + PER_TRIANGLE * triangles as u64
}

/// Heads are about this many distances between the eyes high.
const HEAD_PER_EYES: f64 = 4.5;

/// Where the target goes.
struct Placement {
    aligned_by: &'static str,
    transform: Similarity,
    center: DVec3,
    /// About the height of a head, in the source's unit.
    unit: f64,
    /// Places on the aligned target's skin (in the target's space) and on the source's.
    landmarks: Vec<[DVec3; 2]>,
    /// Whether the surfaces are the same already.
    is_exact: bool,
    /// The heads, if they were looked for.
    heads: Option<Heads>,
    /// Whether the heads aligned the meshes.
    are_heads_certain: bool,
    /// The target's triangles over the skin of its head, where the source has none over its; of all or
    /// of none.
    worn: Vec<bool>,
}

/// The two surfaces as they are, before the target is placed.
struct Placing<'a> {
    source: &'a Mesh,
    target: &'a Mesh,
    goal: Goal,
    shape: Shape,
    align: Align,
    /// The extent of the source.
    extent: Bounds,
}

/// Places the target by given landmarks, by its positions if it lies on the source already, or by
/// the heads.
fn place(
    source: &Mesh,
    target: &Mesh,
    surfaces: &[Surface; 2],
    options: &SurfaceOptions,
    effort: &Arc<Effort>,
) -> Result<Placement, SurfaceError> {
    let goal = Goal::new(Shape::new(&surfaces[0], |point| point), effort);
    let extent = Bounds::of(goal.shape.points.iter().copied());
    let shape = Shape::new(&surfaces[1], |point| point);
    let placing = Placing { source, target, goal, shape, align: options.align, extent };
    let mut given = landmarks(source, target, &options.landmarks)?;
    let position = |at: [f32; 3]| glam::Vec3::from(at).as_dvec3();
    given.extend(options.places.iter().map(|&[from, to]| [position(to), position(from)]));
    if !given.is_empty() {
        return placing.by_landmarks(given);
    }
    match placing.by_positions() {
        Some(placement) => Ok(placement),
        None => placing.by_heads(),
    }
}

impl Placing<'_> {
    fn size(&self) -> f64 {
        self.extent.size().max_element()
    }

    fn center(&self) -> DVec3 {
        (self.extent.min + self.extent.max) / 2.0
    }

    fn scales(&self) -> bool {
        self.align == Align::Similarity
    }

    fn worn(&self, heads: Option<&Heads>) -> Vec<bool> {
        let of =
            |heads: &Heads| heads.worn([self.source, self.target], [&self.goal.shape, &self.shape]);
        heads.map_or_else(Vec::new, of)
    }

    fn by_landmarks(&self, given: Vec<[DVec3; 2]>) -> Result<Placement, SurfaceError> {
        let weights = vec![1.0; given.len()];
        let transform = match self.align {
            Align::None => Similarity::IDENTITY,
            _ => Similarity::between(&given, &weights, self.scales())
                .ok_or(SurfaceError::Landmarks { count: given.len() })?,
        };
        let heads = Heads::find(self.source, self.target).ok();
        let of_head = |it: &Heads| it.source.frame().unit * HEAD_PER_EYES;
        Ok(Placement {
            aligned_by: "landmarks",
            transform,
            center: self.center(),
            unit: heads.as_ref().map_or(self.size(), of_head),
            landmarks: given,
            is_exact: false,
            worn: self.worn(heads.as_ref()),
            heads,
            are_heads_certain: false,
        })
    }

    /// `None` if the target has to be moved.
    fn by_positions(&self) -> Option<Placement> {
        /// Median distance, as a share of the size, of surfaces that are the same.
        const SAME: f64 = 0.004;
        let closeness = closeness(&self.shape, &self.goal, self.size());
        let is_in_place = self.align == Align::None || closeness < SAME;
        if !is_in_place {
            return None;
        }
        let may_wear = component_count(&self.shape) > component_count(&self.goal.shape);
        let are_needed = may_wear || closeness >= SAME;
        let heads = if are_needed { Heads::find(self.source, self.target).ok() } else { None };
        Some(Placement {
            aligned_by: "positions",
            transform: Similarity::IDENTITY,
            center: self.center(),
            unit: self.size(),
            landmarks: Vec::new(),
            is_exact: closeness < SAME / 4.0,
            worn: self.worn(heads.as_ref()),
            heads,
            are_heads_certain: false,
        })
    }

    fn by_heads(self) -> Result<Placement, SurfaceError> {
        let (source, target) = (self.source, self.target);
        let heads = Heads::find(source, target)
            .map_err(|(side, reason)| SurfaceError::NoAlignment { side, reason })?;
        let unit = heads.source.frame().unit * HEAD_PER_EYES;
        let center = DVec3::from(heads.source.frame().origin);
        let (worn, scales) = (self.worn(Some(&heads)), self.scales());
        let skin = if worn.is_empty() { self.shape } else { self.shape.without(&worn) };
        let goal = self.goal;
        let start = heads.alignment(scales).ok_or(SurfaceError::Landmarks { count: 0 })?;
        let found = align::refine(start, &skin, &goal, unit, scales);
        // Eyeballs tell which way is up.
        let is_certain = [source, target].into_iter().all(|mesh| !anatomy::balls(mesh).is_empty());
        let opposite = if is_certain {
            None
        } else {
            align::opposite(found, &skin, &goal, heads.source.frame(), scales)
        };
        // Those of a face that was found upside down are wrong.
        let landmarks = if opposite.is_some() { Vec::new() } else { heads.on_skin() };
        Ok(Placement {
            aligned_by: "heads",
            transform: opposite.unwrap_or(found),
            center,
            unit,
            landmarks,
            is_exact: false,
            heads: Some(heads),
            are_heads_certain: opposite.is_none(),
            worn,
        })
    }
}

/// The median distance of the target's points from the source as they are, relative to its size.
fn closeness(target: &Shape, goal: &Goal, size: f64) -> f64 {
    let distance = |&point: &DVec3| {
        goal.tree.nearest(point, f64::INFINITY, |_| true).map_or(f64::INFINITY, |at| at.distance)
    };
    let step = (target.points.len() / 2000).max(1);
    median(target.points.iter().step_by(step).map(distance)).unwrap_or(0.0) / size
}

/// The positions of given landmarks, target first.
fn landmarks(
    source: &Mesh,
    target: &Mesh,
    pairs: &[[u32; 2]],
) -> Result<Vec<[DVec3; 2]>, SurfaceError> {
    let at = |mesh: &Mesh, index: usize, side: &'static str, vertex: u32| {
        let vertices = mesh.positions().len();
        let position = mesh.positions().get(vertex as usize);
        let position = position.map(|&position| glam::Vec3::from(position).as_dvec3());
        position.ok_or(SurfaceError::Landmark { index, side, found: vertex, vertices })
    };
    let pair = |(index, &[from, to]): (usize, &[u32; 2])| {
        Ok([at(target, index, "target", to)?, at(source, index, "source", from)?])
    };
    pairs.iter().enumerate().map(pair).collect()
}

/// Landmarks as anchors: the nearest place of the target's surface, and its way to the source's.
fn anchors(
    landmarks: &[[DVec3; 2]],
    rest: &Shape,
    to_unit: impl Fn(DVec3) -> DVec3,
    aligned: &Similarity,
) -> Vec<Anchor> {
    let tree = rest.tree(&Effort::unlimited());
    let anchor = |[target, source]: &[DVec3; 2]| {
        let at = to_unit(aligned.apply(*target));
        let nearest = tree.nearest(at, f64::INFINITY, |_| true)?;
        let points = rest.triangles[nearest.triangle as usize];
        let displacement = to_unit(*source) - nearest.point;
        Some(Anchor { points, weights: nearest.weights, displacement })
    };
    landmarks.iter().filter_map(anchor).collect()
}

fn report(
    placement: &Placement,
    registered: &Shape,
    overlay: &overlay::Overlay,
    flipped: usize,
    target: &Mesh,
    surface: &Surface,
) -> SurfaceReport {
    let mut distances = overlay.distances.clone();
    distances.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| {
        let last = distances.len().saturating_sub(1) as f64;
        distances.get((share * last).round() as usize).copied().unwrap_or(0.0) * placement.unit
    };
    let mut points = vec![[0.0; 3]; target.positions().len()];
    for (face, corners) in target.faces().iter().zip(surface.triangles()) {
        for k in 0..3 {
            let at = registered.points[corners[k] as usize] * placement.unit + placement.center;
            points[face[k] as usize] = at.as_vec3().to_array();
        }
    }
    SurfaceReport {
        aligned_by: placement.aligned_by,
        alignment: placement.transform.rows(),
        distance_median: at(0.5),
        distance_p95: at(0.95),
        flipped,
        worn: placement.worn.iter().filter(|is_worn| **is_worn).count(),
        heads_turned: check::heads_turned(placement),
        covered: share_of_area(surface, &overlay.covered),
        registered: points,
    }
}

/// The share of a surface's area of which a share of each triangle is covered.
pub(super) fn share_of_area(surface: &Surface, covered: &[f64]) -> f64 {
    let areas = || (0..surface.triangles().len() as u32).map(|face| surface.area(face));
    let total: f64 = areas().sum();
    let covered: f64 = areas().zip(covered).map(|(area, share)| area * share).sum();
    if total > 0.0 { covered / total } else { 0.0 }
}
