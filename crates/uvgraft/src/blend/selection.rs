//! Which part of the surface is meant: by vertices, by a painted mask, and what is made of these.

use crate::mesh::Mesh;
use crate::pair::{Counterpart, Direction, Pair};
use crate::surface::Surface;
use crate::texture::Texture;

use super::geodesic;
use super::painted;

/// One of a pair's two meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The pair's source, [`Pair::source`].
    Source,
    /// The pair's target, [`Pair::target`].
    Target,
}

/// Why a region is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RegionError {
    /// A vertex that the mesh does not have.
    #[error("vertex {found} is not there: the mesh has vertices 0 to {}", .vertices.saturating_sub(1))]
    Vertex {
        /// What was found.
        found: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// Nothing is left to be transferred.
    #[error("the region is empty: {0}")]
    Empty(&'static str),
}

/// What selections of one pair and direction are made on.
#[derive(Debug, Clone)]
pub struct Ground<'a> {
    pair: &'a Pair,
    direction: Direction,
    pub(super) surface: Surface,
    /// For each triangle of the target, its counterpart in the source.
    pub(super) from_face: Vec<Option<Counterpart>>,
}

/// A part of the target's surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Selection(pub(super) Shape);

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    /// Whole triangles.
    Faces(Vec<bool>),
    /// Where a value at the points, linear between them, is greater than 0. Near there it is a
    /// distance in the mesh's unit. Triangles all of whose corners are at 0 are in it if they are
    /// listed: in the corners of regions of whole triangles, whose rim all their points are part of.
    Level(Vec<f64>, Vec<bool>),
}

/// How far a selection is widened, or narrowed where it is negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Growth {
    /// Along the surface, in the target mesh's unit.
    Length(f64),
    /// Rings of triangles.
    Rings(i32),
}

impl<'a> Ground<'a> {
    /// The ground for textures that are carried in a direction.
    pub fn new(pair: &'a Pair, direction: Direction) -> Self {
        let oriented = pair.oriented(direction);
        Self { pair, direction, surface: Surface::new(oriented.to), from_face: oriented.from_face }
    }

    /// The pair.
    pub fn pair(&self) -> &'a Pair {
        self.pair
    }

    /// Which way textures are carried.
    pub fn direction(&self) -> Direction {
        self.direction
    }

    /// The mesh whose layout textures are carried to.
    pub(super) fn mesh(&self) -> &'a Mesh {
        self.pair.to(self.direction)
    }

    /// Everything that is linked.
    pub fn linked(&self) -> Selection {
        Selection(Shape::Faces(self.from_face.iter().map(Option::is_some).collect()))
    }

    /// The triangles all of whose vertices are listed.
    ///
    /// # Errors
    /// [`RegionError::Vertex`] for a vertex that the mesh of that side does not have;
    /// [`RegionError::Empty`] if they are the corners of no triangle that is in the target.
    pub fn vertices(&self, side: Side, vertices: &[u32]) -> Result<Selection, RegionError> {
        let mesh = match side {
            Side::Source => self.pair.source(),
            Side::Target => self.pair.target(),
        };
        let mut is_listed = vec![false; mesh.positions().len()];
        for &found in vertices {
            let vertices = is_listed.len();
            *is_listed.get_mut(found as usize).ok_or(RegionError::Vertex { found, vertices })? =
                true;
        }
        let is_in =
            |face: usize| mesh.faces()[face].iter().all(|&corner| is_listed[corner as usize]);
        let faces: Vec<bool> = self.faces_of(side).map(|face| face.is_some_and(is_in)).collect();
        if faces.contains(&true) {
            Ok(Selection(Shape::Faces(faces)))
        } else {
            Err(RegionError::Empty("the vertices are the corners of no linked triangle"))
        }
    }

    /// What a mask says that is painted in the layout of a side: where its brightness times its
    /// opacity is at least a half. Its outline is followed from edge to edge of the triangles.
    ///
    /// # Errors
    /// [`RegionError::Empty`] if it is dark everywhere.
    pub fn painted(&self, side: Side, mask: &Texture) -> Result<Selection, RegionError> {
        let mesh = match side {
            Side::Source => self.pair.source(),
            Side::Target => self.pair.target(),
        };
        let is_target = self.is_target(side);
        let uv: Vec<Option<[[f32; 2]; 3]>> = (0..self.from_face.len())
            .map(|face| {
                if is_target {
                    return Some(mesh.uv_triangle(face));
                }
                let counterpart = self.from_face[face]?;
                let uv = mesh.uv_triangle(counterpart.face as usize);
                Some(counterpart.corners.map(|corner| uv[corner as usize]))
            })
            .collect();
        let level = painted::level(&self.surface, &uv, mask);
        if level.iter().any(|&level| level > 0.0) {
            Ok(self.above(level))
        } else {
            Err(RegionError::Empty("the mask is dark at every vertex"))
        }
    }

    /// The selection, widened or narrowed.
    #[must_use]
    pub fn grown(&self, selection: &Selection, by: Growth) -> Selection {
        match by {
            Growth::Length(0.0) | Growth::Rings(0) => selection.clone(),
            Growth::Length(by) => {
                // Finite, so that what is endlessly far outside stays there; what is no number is 0.
                let by = if by.is_nan() { 0.0 } else { by.clamp(-f64::MAX, f64::MAX) };
                let inside = self.signed_distances(selection, by.abs() + self.longest_edge());
                self.above(inside.into_iter().map(|inside| inside + by).collect())
            }
            Growth::Rings(rings) => {
                let mut faces = self.touched(selection);
                if let Shape::Level(level, _) = &selection.0 {
                    // Only those that are in it wholly.
                    for (face, corners) in faces.iter_mut().zip(self.surface.triangles()) {
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
                Selection(Shape::Faces(faces))
            }
        }
    }

    /// The signed distance of each point from a selection's rim, positive inside; infinite where the
    /// rim is farther away than `limit`.
    pub(super) fn signed_distances(&self, selection: &Selection, limit: f64) -> Vec<f64> {
        let level = self.level(selection);
        let seeds = self.surface.triangles().iter().flat_map(|corners| {
            let levels = corners.map(|point| level[point as usize]);
            let positions = corners.map(|point| self.surface.positions()[point as usize]);
            painted::distances_to_contour(positions, levels)
                .into_iter()
                .zip(*corners)
                .filter_map(|(distance, point)| distance.map(|distance| (point, distance)))
        });
        let distances = geodesic::distances(&self.surface, seeds, limit);
        level
            .into_iter()
            .zip(distances)
            .map(|(level, distance)| if level == 0.0 { 0.0 } else { distance.copysign(level) })
            .collect()
    }

    /// The longest side of the box around the target's mesh, in its unit.
    pub fn extent(&self) -> f64 {
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for position in self.surface.positions() {
            for axis in 0..3 {
                bounds[0][axis] = bounds[0][axis].min(position[axis]);
                bounds[1][axis] = bounds[1][axis].max(position[axis]);
            }
        }
        (0..3).map(|axis| bounds[1][axis] - bounds[0][axis]).fold(0.0, f64::max)
    }

    pub(super) fn longest_edge(&self) -> f64 {
        let lengths = self.surface.triangles().iter().flat_map(|&[a, b, c]| {
            [(a, b), (b, c), (c, a)].map(|(a, b)| self.surface.length(a, b))
        });
        lengths.fold(0.0, f64::max)
    }

    /// A value at the points that is positive inside and 0 at the rim of whole triangles.
    pub(super) fn level(&self, selection: &Selection) -> Vec<f64> {
        let faces = match &selection.0 {
            Shape::Level(level, _) => return level.clone(),
            Shape::Faces(faces) => faces,
        };
        (0..self.surface.positions().len() as u32)
            .map(|point| {
                let around = self.surface.around(point);
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
        match &selection.0 {
            Shape::Faces(faces) => faces.clone(),
            Shape::Level(level, flat) => {
                let above = self.faces_above(level);
                let is_flat =
                    |corners: &[u32; 3]| corners.iter().all(|&k| level[k as usize] == 0.0);
                let faces = self.surface.triangles().iter().zip(flat).zip(above);
                faces.map(|((corners, &flat), above)| above || (flat && is_flat(corners))).collect()
            }
        }
    }

    /// The triangles at any corner of which a level is above 0.
    fn faces_above(&self, level: &[f64]) -> Vec<bool> {
        let is_above =
            |corners: &[u32; 3]| corners.iter().any(|&point| level[point as usize] > 0.0);
        self.surface.triangles().iter().map(is_above).collect()
    }

    fn above(&self, level: Vec<f64>) -> Selection {
        let faces = self.faces_above(&level);
        Selection(Shape::Level(level, faces))
    }

    fn next_ring(&self, faces: &[bool], wider: bool) -> Vec<bool> {
        // Wider: whatever shares a point with the selection; narrower: what shares none with the rest.
        let is_met = |point: u32| {
            self.surface.around(point).iter().any(|&face| faces[face as usize] == wider)
        };
        self.surface
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
            (side, self.direction),
            (Side::Target, Direction::Forward) | (Side::Source, Direction::Reverse)
        )
    }

    /// For each triangle that textures are carried to, the one of a side.
    fn faces_of(&self, side: Side) -> impl Iterator<Item = Option<usize>> {
        let is_target = self.is_target(side);
        self.from_face.iter().enumerate().map(move |(face, counterpart)| {
            if is_target {
                Some(face)
            } else {
                counterpart.map(|counterpart| counterpart.face as usize)
            }
        })
    }
}

impl Selection {
    /// What is in either.
    #[must_use]
    pub fn and(&self, other: &Self, ground: &Ground<'_>) -> Self {
        self.combined(other, ground, |a, b| a || b, f64::max)
    }

    /// What is in this and not in the other.
    #[must_use]
    pub fn without(&self, other: &Self, ground: &Ground<'_>) -> Self {
        self.combined(other, ground, |a, b| a && !b, |a, b| a.min(-b))
    }

    /// What is in both.
    #[must_use]
    pub fn within(&self, other: &Self, ground: &Ground<'_>) -> Self {
        self.combined(other, ground, |a, b| a && b, f64::min)
    }

    fn combined(
        &self,
        other: &Self,
        ground: &Ground<'_>,
        of_faces: impl Fn(bool, bool) -> bool,
        of_levels: impl Fn(f64, f64) -> f64,
    ) -> Self {
        if let (Shape::Faces(a), Shape::Faces(b)) = (&self.0, &other.0) {
            return Self(Shape::Faces(a.iter().zip(b).map(|(&a, &b)| of_faces(a, b)).collect()));
        }
        let faces = ground.touched(self).into_iter().zip(ground.touched(other));
        let faces = faces.map(|(a, b)| of_faces(a, b)).collect();
        let (a, b) = (ground.level(self), ground.level(other));
        let level = a.into_iter().zip(b).map(|(a, b)| of_levels(a, b)).collect();
        Self(Shape::Level(level, faces))
    }
}
