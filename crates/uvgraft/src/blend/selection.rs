//! Selections of a part of the surface: from vertices, from painted masks, and by combining others.

use std::sync::{Arc, OnceLock};

use glam::DVec3;
use uvgraft_surface::anatomy::Anatomy;
use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::pair::{Direction, Pair, Side};
use uvgraft_surface::piece::{FacePieces, Weights, mixed, wide};
use uvgraft_surface::surface::Surface;
use uvgraft_surface::threads::join;

use super::geodesic;
use super::painted::{self, MaskUv};
use crate::labels::{BodyLayout, HeadLayout, LabelError, Labels};
use crate::texture::Texture;

/// Why a region was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RegionError {
    /// A vertex index that the mesh does not have.
    #[error("vertex {found} does not exist: the mesh has vertices 0 to {}", .vertices.saturating_sub(1))]
    Vertex {
        /// The index.
        found: u32,
        /// Number of vertices in the mesh.
        vertices: usize,
    },
    /// The selections to combine belong to different pairs or directions.
    #[error("the selections belong to different pairs or directions")]
    Domain,
    /// Nothing is left to transfer.
    #[error("the region is empty: {0}")]
    Empty(&'static str),
}

/// The surface that selections of one pair and direction are made on. Clones share it.
#[derive(Debug, Clone)]
pub struct BlendDomain(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    pair: Arc<Pair>,
    direction: Direction,
    surface: Surface,
    /// The pieces of each triangle of the target.
    pieces: FacePieces,
    /// The head of the mesh that textures are read from, computed on first use.
    head: OnceLock<Result<HeadLayout, LabelError>>,
    /// The anatomy of the mesh that they are transferred to, computed on first use.
    anatomy: OnceLock<Option<Anatomy>>,
    /// That mesh's whole layout, for skin detection, computed on first use.
    body: OnceLock<Option<BodyLayout>>,
}

/// A part of the target's surface, on a [`BlendDomain`]: independent of the sizes of textures, unlike
/// sets of texels such as a metric's mask.
#[derive(Debug, Clone)]
pub struct Selection {
    domain: BlendDomain,
    shape: Shape,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    /// Whole triangles.
    Faces(Vec<bool>),
    /// Where a value at the points, linear in between, is positive. Near there it is a
    /// distance in the mesh's unit. Triangles all of whose corners are at 0 are included if
    /// they are listed: at the corners of regions of whole triangles, where all of a
    /// triangle's points lie on the boundary.
    Level(Vec<f64>, Vec<bool>),
}

/// How far a selection is grown, or shrunk if negative. A selection without a boundary, such as a
/// whole eyeball, stays unchanged, and so does everything if the length is NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Growth {
    /// A length along the surface, in the target mesh's unit.
    Length(f64),
    /// A number of triangle rings.
    Rings(i32),
}

/// The value of a cell, computed first if it is empty.
///
/// It is not computed inside `get_or_init`: a thread that waits for parallel parts of that work may
/// steal a task that needs the same cell, and would wait for ever.
fn cached<T>(cell: &OnceLock<T>, find: impl FnOnce() -> T) -> &T {
    if let Some(found) = cell.get() {
        return found;
    }
    let found = find();
    cell.get_or_init(|| found)
}

impl BlendDomain {
    /// The domain for textures that are transferred in a direction.
    pub fn new(pair: impl Into<Arc<Pair>>, direction: Direction) -> Self {
        let pair = pair.into();
        let surface = Surface::new(pair.to(direction));
        let pieces = pair.face_pieces(direction);
        let (head, anatomy, body) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        Self(Arc::new(Inner { pair, direction, surface, pieces, head, anatomy, body }))
    }

    /// Whether selections made on one domain fit the other.
    pub(crate) fn is_compatible(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.is_of(other.pair(), other.direction())
    }

    /// Whether both targets are the same surface, triangle by triangle, whatever their layouts.
    pub(super) fn is_same_surface(&self, other: &Self) -> bool {
        self.direction() == other.direction()
            && self.surface().triangles() == other.surface().triangles()
            && self.surface().positions() == other.surface().positions()
    }

    /// Whether it is the domain for textures of a pair that are transferred in a direction.
    pub(crate) fn is_of(&self, pair: &Arc<Pair>, direction: Direction) -> bool {
        direction == self.direction() && (Arc::ptr_eq(self.pair(), pair) || self.pair() == pair)
    }

    /// The pair.
    pub fn pair(&self) -> &Arc<Pair> {
        &self.0.pair
    }

    /// The direction in which textures are transferred.
    pub fn direction(&self) -> Direction {
        self.0.direction
    }

    /// The mesh whose layout textures are transferred to.
    pub(super) fn mesh(&self) -> &Mesh {
        self.pair().to(self.direction())
    }

    pub(super) fn surface(&self) -> &Surface {
        &self.0.surface
    }

    pub(super) fn pieces(&self) -> &FacePieces {
        &self.0.pieces
    }

    /// Labels of what a transferred texture shows.
    ///
    /// # Errors
    /// [`LabelError`] if no head is transferred, or if its cheeks do not share a colour.
    pub fn labels(&self, texture: &Texture) -> Result<Labels, LabelError> {
        Labels::find(self.try_head().as_ref().map_err(Clone::clone)?, texture)
    }

    /// The head whose texture is transferred, if the mesh has one and it is linked.
    pub(super) fn head(&self) -> Option<&HeadLayout> {
        self.try_head().as_ref().ok()
    }

    fn try_head(&self) -> &Result<HeadLayout, LabelError> {
        let find = || {
            let mesh = self.pair().from(self.direction());
            let mut is_transferred = vec![false; mesh.faces().len()];
            for piece in self.pieces().all() {
                is_transferred[piece.from as usize] = true;
            }
            let head = HeadLayout::new(mesh, &is_transferred)?;
            if head.has_cheeks(mesh, &is_transferred) { Ok(head) } else { Err(LabelError::Cheeks) }
        };
        cached(&self.0.head, find)
    }

    /// The anatomy of the mesh that textures are transferred to, if it has a head.
    pub(super) fn anatomy(&self) -> Option<&Anatomy> {
        cached(&self.0.anatomy, || Anatomy::find(self.mesh()).ok()).as_ref()
    }

    /// The layout of the mesh that textures are transferred to, for skin detection, if it has a
    /// head.
    pub(super) fn body(&self) -> Option<&BodyLayout> {
        let find = || Some(BodyLayout::with_anatomy(self.mesh(), self.anatomy()?));
        cached(&self.0.body, find).as_ref()
    }

    /// The distance between the eyes on the target, in its unit; `None` if no head is transferred.
    pub(super) fn eye_distance(&self) -> Option<f64> {
        let (head, anatomy) = join(|| self.head(), || self.anatomy());
        let head = head?;
        if let Some(anatomy) = anatomy {
            return Some(anatomy.frame().unit);
        }
        // Scaled by the size of the linked part on the target relative to the source.
        let read = self.pair().from(self.direction());
        let from = Surface::new(read);
        let areas = self.pieces().all().iter().map(|piece| {
            let to = self.surface().area(piece.to) * self.pieces().share(*piece);
            [from.area(piece.from), to]
        });
        let sums = areas.fold([0.0, 0.0], |sum, area| [sum[0] + area[0], sum[1] + area[1]]);
        (sums[0] > 0.0).then(|| head.anatomy.frame().unit * (sums[1] / sums[0]).sqrt())
    }

    /// The UV coordinate of a point of a triangle in the layout that textures are read from;
    /// `None` if it is not linked.
    pub(super) fn source_uv(&self, face: usize, weights: Weights) -> Option<[f64; 2]> {
        let piece = self.pieces().at(face, weights)?;
        let read = self.pair().from(self.direction()).uv_triangle(piece.from as usize);
        Some(mixed(&self.pieces().at_corners(piece, wide(read)), weights))
    }

    fn with_shape(&self, shape: Shape) -> Selection {
        Selection { domain: self.clone(), shape }
    }

    /// Everything that is linked: the triangles that pieces fill, to within a hundredth of their
    /// area. In partly filled triangles the boundary would be the outline of the pieces, which no
    /// point of the mesh lies on.
    pub fn linked(&self) -> Selection {
        let faces = 0..self.pieces().faces();
        self.with_shape(Shape::Faces(faces.map(|face| self.pieces().is_filled(face)).collect()))
    }

    /// The triangles all of whose vertices are listed.
    ///
    /// # Errors
    /// [`RegionError::Vertex`] for a vertex that the mesh of that side does not have;
    /// [`RegionError::Empty`] if they span no linked triangle.
    pub fn vertices(&self, side: Side, vertices: &[u32]) -> Result<Selection, RegionError> {
        let mesh = self.mesh_of(side);
        let mut is_listed = vec![false; mesh.positions().len()];
        for &found in vertices {
            let vertices = is_listed.len();
            *is_listed.get_mut(found as usize).ok_or(RegionError::Vertex { found, vertices })? =
                true;
        }
        let is_in =
            |face: usize| mesh.faces()[face].iter().all(|&corner| is_listed[corner as usize]);
        let is_target = self.is_target(side);
        let is_selected = |face: usize| {
            if is_target {
                return is_in(face);
            }
            let pieces = self.pieces().of_face(face);
            !pieces.is_empty() && pieces.iter().all(|piece| is_in(piece.from as usize))
        };
        let faces: Vec<bool> = (0..self.pieces().faces()).map(is_selected).collect();
        if faces.contains(&true) {
            Ok(self.with_shape(Shape::Faces(faces)))
        } else {
            Err(RegionError::Empty("the vertices span no linked triangle"))
        }
    }

    /// The part of the surface that is painted in a mask in one side's layout: where the
    /// mask's brightness times its alpha is at least a half. Its outline is traced from
    /// edge to edge of the triangles.
    ///
    /// # Errors
    /// [`RegionError::Empty`] if the mask is dark everywhere.
    pub fn painted(&self, side: Side, mask: &Texture) -> Result<Selection, RegionError> {
        let mesh = self.mesh_of(side);
        let is_target = self.is_target(side);
        let mask_uv: Vec<MaskUv> = (0..self.pieces().faces())
            .map(|face| {
                if is_target {
                    return MaskUv::Triangle(mesh.uv_triangle(face));
                }
                match self.pieces().of_face(face) {
                    [] => MaskUv::Unmapped,
                    &[piece] if self.pieces().part(piece).is_none() => {
                        let uv = wide(mesh.uv_triangle(piece.from as usize));
                        let uv = self.pieces().at_corners(piece, uv);
                        MaskUv::Triangle(uv.map(|at| at.map(|value| value as f32)))
                    }
                    _ => MaskUv::Pieces,
                }
            })
            .collect();
        let uv = |face: usize, weights: Weights| self.source_uv(face, weights);
        let level = painted::level(self.surface(), &mask_uv, uv, mask);
        if level.iter().any(|&level| level > 0.0) {
            Ok(self.above(level))
        } else {
            Err(RegionError::Empty("the mask is black at every vertex"))
        }
    }

    fn grown(&self, selection: &Selection, by: Growth) -> Selection {
        match by {
            Growth::Length(0.0) | Growth::Rings(0) => selection.clone(),
            Growth::Length(by) => {
                // Finite, so that points at infinity stay outside; NaN means 0.
                let by = if by.is_nan() { 0.0 } else { by.clamp(-f64::MAX, f64::MAX) };
                let inside = self.signed_distances(selection, by.abs() + self.longest_edge());
                self.above(inside.into_iter().map(|inside| inside + by).collect())
            }
            Growth::Rings(rings) => {
                let mut faces = self.touched(selection);
                if let Shape::Level(level, _) = &selection.shape {
                    // Only triangles that are in it wholly.
                    for (face, corners) in faces.iter_mut().zip(self.surface().triangles()) {
                        *face &= corners.iter().all(|&point| level[point as usize] >= 0.0);
                    }
                }
                for _ in 0..rings.unsigned_abs() {
                    let next = self.next_ring(&faces, rings > 0);
                    if next == faces {
                        break;
                    }
                    faces = next;
                }
                self.with_shape(Shape::Faces(faces))
            }
        }
    }

    /// The signed distance of each point from a selection's boundary, positive inside; infinite
    /// where the boundary is farther away than `limit`.
    pub(super) fn signed_distances(&self, selection: &Selection, limit: f64) -> Vec<f64> {
        let level = self.level(selection);
        let seeds = self.surface().triangles().iter().flat_map(|corners| {
            let levels = corners.map(|point| level[point as usize]);
            let positions = corners.map(|point| self.surface().positions()[point as usize]);
            painted::distances_to_contour(positions, levels)
                .into_iter()
                .zip(*corners)
                .filter_map(|(distance, point)| distance.map(|distance| (point, distance)))
        });
        let distances = geodesic::distances(self.surface(), seeds, limit);
        level
            .into_iter()
            .zip(distances)
            .map(|(level, distance)| if level == 0.0 { 0.0 } else { distance.copysign(level) })
            .collect()
    }

    /// The longest side of the target mesh's bounding box, in its unit.
    pub fn extent(&self) -> f64 {
        let positions = self.surface().positions().iter();
        let (low, high) = positions
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &position| {
                (low.min(position), high.max(position))
            });
        (high - low).max_element().max(0.0)
    }

    pub(super) fn longest_edge(&self) -> f64 {
        let lengths = self.surface().triangles().iter().flat_map(|&[a, b, c]| {
            [(a, b), (b, c), (c, a)].map(|(a, b)| self.surface().length(a, b))
        });
        lengths.fold(0.0, f64::max)
    }

    /// A value at the points, positive inside and negative outside: for whole triangles infinite,
    /// and 0 at points on the boundary.
    pub(super) fn level(&self, selection: &Selection) -> Vec<f64> {
        let faces = match &selection.shape {
            Shape::Level(level, _) => return level.clone(),
            Shape::Faces(faces) => faces,
        };
        (0..self.surface().positions().len() as u32)
            .map(|point| {
                let around = self.surface().around(point);
                let count = around.iter().filter(|&&face| faces[face as usize]).count();
                match count {
                    0 => f64::NEG_INFINITY,
                    _ if count < around.len() => 0.0,
                    _ => f64::INFINITY,
                }
            })
            .collect()
    }

    /// The triangles that are selected wholly or in part.
    pub(super) fn touched(&self, selection: &Selection) -> Vec<bool> {
        match &selection.shape {
            Shape::Faces(faces) => faces.clone(),
            Shape::Level(level, flat) => {
                let above = self.faces_above(level);
                let is_flat =
                    |corners: &[u32; 3]| corners.iter().all(|&k| level[k as usize] == 0.0);
                let faces = self.surface().triangles().iter().zip(flat).zip(above);
                faces.map(|((corners, &flat), above)| above || (flat && is_flat(corners))).collect()
            }
        }
    }

    /// The triangles with a level above 0 at any corner.
    fn faces_above(&self, level: &[f64]) -> Vec<bool> {
        let is_above =
            |corners: &[u32; 3]| corners.iter().any(|&point| level[point as usize] > 0.0);
        self.surface().triangles().iter().map(is_above).collect()
    }

    fn above(&self, level: Vec<f64>) -> Selection {
        let faces = self.faces_above(&level);
        self.with_shape(Shape::Level(level, faces))
    }

    fn next_ring(&self, faces: &[bool], wider: bool) -> Vec<bool> {
        // Growing adds what shares a point with the selection; shrinking removes what shares one
        // with the rest.
        let is_met = |point: u32| {
            self.surface().around(point).iter().any(|&face| faces[face as usize] == wider)
        };
        self.surface()
            .triangles()
            .iter()
            .zip(faces)
            .map(|(corners, &is_in)| {
                let meets = corners.iter().any(|&point| is_met(point));
                if wider { is_in || meets } else { is_in && !meets }
            })
            .collect()
    }

    fn is_target(&self, side: Side) -> bool {
        matches!(
            (side, self.direction()),
            (Side::Target, Direction::Forward) | (Side::Source, Direction::Reverse)
        )
    }

    /// One of the pair's meshes.
    pub fn mesh_of(&self, side: Side) -> &Mesh {
        match side {
            Side::Source => self.pair().source(),
            Side::Target => self.pair().target(),
        }
    }
}

impl Selection {
    /// The same part of the same surface, on a domain with another layout.
    pub(super) fn with_layout(&self, domain: &BlendDomain) -> Self {
        domain.with_shape(self.shape.clone())
    }

    /// The domain that it is a part of.
    pub fn domain(&self) -> &BlendDomain {
        &self.domain
    }

    /// The union of both selections.
    ///
    /// # Errors
    /// [`RegionError::Domain`] if they were made for different pairs or directions.
    pub fn union(&self, other: &Self) -> Result<Self, RegionError> {
        self.combined(other, |a, b| a || b, f64::max)
    }

    /// The part of this selection that is not in the other.
    ///
    /// # Errors
    /// As [`Selection::union`].
    pub fn difference(&self, other: &Self) -> Result<Self, RegionError> {
        self.combined(other, |a, b| a && !b, |a, b| a.min(-b))
    }

    /// The intersection of both selections.
    ///
    /// # Errors
    /// As [`Selection::union`].
    pub fn intersection(&self, other: &Self) -> Result<Self, RegionError> {
        self.combined(other, |a, b| a && b, f64::min)
    }

    /// Whether no triangle is in it, wholly or in part.
    pub fn is_empty(&self) -> bool {
        !self.domain.touched(self).contains(&true)
    }

    /// The selection, grown or shrunk.
    #[must_use]
    pub fn grown(&self, by: Growth) -> Self {
        self.domain.grown(self, by)
    }

    fn combined(
        &self,
        other: &Self,
        of_faces: impl Fn(bool, bool) -> bool,
        of_levels: impl Fn(f64, f64) -> f64,
    ) -> Result<Self, RegionError> {
        let domain = &self.domain;
        if !domain.is_compatible(&other.domain) {
            return Err(RegionError::Domain);
        }
        if let (Shape::Faces(a), Shape::Faces(b)) = (&self.shape, &other.shape) {
            let faces = a.iter().zip(b).map(|(&a, &b)| of_faces(a, b));
            return Ok(domain.with_shape(Shape::Faces(faces.collect())));
        }
        let faces = domain.touched(self).into_iter().zip(domain.touched(other));
        let faces = faces.map(|(a, b)| of_faces(a, b)).collect();
        let (a, b) = (domain.level(self), domain.level(other));
        let level = a.into_iter().zip(b).map(|(a, b)| of_levels(a, b)).collect();
        Ok(domain.with_shape(Shape::Level(level, faces)))
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;

    use super::*;

    #[test]
    fn equal_pairs_have_one_domain_and_others_another() {
        let pair = |side: f32| {
            let corners = [[0.0, 0.0], [side, 0.0], [0.0, side], [side, side]];
            let positions = corners.map(|[x, y]| [x, y, 0.0]).to_vec();
            let faces = [[0, 1, 2], [1, 3, 2]];
            let mesh = Mesh::from_triangles(positions, corners.to_vec(), &faces, &faces).unwrap();
            Arc::new(Pair::by_vertex_map(mesh.clone(), mesh, &[0, 1, 2, 3]).unwrap())
        };
        let own = pair(1.0);
        let domain = BlendDomain::new(Arc::clone(&own), Direction::Forward);
        assert!(domain.is_of(&own, Direction::Forward));
        assert!(domain.is_of(&pair(1.0), Direction::Forward));
        assert!(!domain.is_of(&own, Direction::Reverse));
        assert!(!domain.is_of(&pair(0.5), Direction::Forward));
        let again = BlendDomain::new(pair(1.0), Direction::Forward);
        let other = BlendDomain::new(pair(0.5), Direction::Forward);
        assert!(domain.is_compatible(&again) && !domain.is_compatible(&other));
        assert!(domain.is_same_surface(&again) && !domain.is_same_surface(&other));
    }
}
