//! The texels just outside islands: the gutter, and the fringe of islands that won an overlap.
//!
//! A gutter texel belongs to the nearest boundary edge. Up to [`REACH_PX`] beyond the edge, its
//! source position extrapolates the affine map of the triangle. Farther out the position is clamped
//! to a line just as far inside the edge: source texels beyond the edge may not belong to the
//! transferred surface, and extrapolating into them would smear them into streaks. Source positions
//! are affine within each of these zones.
//!
//! This module holds the edges; `gutter_rows` finds the nearest edge of each texel.

use std::collections::HashSet;
use std::ops::Range;

use uvgraft_surface::islands::{BoundaryEdge, Islands};
use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::raster::corners_px;
use uvgraft_surface::threads::map_indices;

use super::cut::{FacePatch, FacePatches};
use super::rows::RowBlocks;
use super::{Affine, FAR_PX};
use crate::texture::Size;

/// Distance beyond an edge up to which source positions are extrapolated, in target texels, and
/// never more than a third of the triangle's height. When the result is filtered bilinearly at the
/// edge, texels up to half a texel beyond it have the largest weights.
pub(crate) const REACH_PX: f64 = 0.5;

/// Width of the fringe that an island that won an overlap claims from those that it hides, in target
/// texels: what bilinear filtering at the winner's edge can read, diagonally too.
pub(crate) const FRINGE_PX: f64 = 1.5;

/// Position of a texel relative to its nearest edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Zone {
    /// Within reach: the triangle's map, extrapolated.
    Near = 0,
    /// Beyond reach, along the edge.
    Beside = 1,
    /// Beyond reach, around the edge's first end.
    First = 2,
    /// Beyond reach, around the edge's second end.
    Second = 3,
}

pub(super) const ZONES: [Zone; 4] = [Zone::Near, Zone::Beside, Zone::First, Zone::Second];

/// A boundary edge, or the part of one that a piece bounds, in texels.
pub(super) struct Edge {
    /// The patch of the piece that it bounds; `None` where nothing is linked.
    patch: Option<u32>,
    pub island: u32,
    pub from: [f64; 2],
    pub along: [f64; 2],
    /// The part of the edge that the patch bounds, as parameters from 0 to 1: the whole edge unless
    /// several pieces meet on it. Parameters refer to the whole edge, so a joint between pieces is
    /// not treated like an end of the edge and does not show.
    pub stretch: [f64; 2],
    pub inverse_squared_length: f64,
    /// Unit normal that points away from the triangle.
    outward: [f64; 2],
    /// The triangle's centroid.
    centroid: [f64; 2],
    /// Distance up to which the triangle's map is extrapolated in the gutter.
    pub reach_px: f64,
    /// The same in the fringe: all of it, so that what the loser had there looks like a
    /// continuation of the winner. Thin triangles are an exception: their maps are steep
    /// and would run away.
    pub fringe_reach_px: f64,
    /// The rows and columns that the gutter along the edge may reach.
    pub rows: Range<u32>,
    pub columns: Range<u32>,
}

impl Edge {
    /// - `corners`: the edge's ends, then the triangle's third corner.
    /// - `stretch`, `patch`: the part of the edge, and the patch of the piece that it bounds.
    fn new(
        [from, to, opposite]: [[f64; 2]; 3],
        (stretch, patch): ([f64; 2], Option<u32>),
        island: u32,
        size: Size,
        radius: f64,
    ) -> Option<Self> {
        let along = [to[0] - from[0], to[1] - from[1]];
        let length = along[0].hypot(along[1]);
        if length == 0.0 {
            return None;
        }
        let mut outward = [-along[1] / length, along[0] / length];
        let inside = [opposite[0] - from[0], opposite[1] - from[1]];
        let height = outward[0] * inside[0] + outward[1] * inside[1];
        if height > 0.0 {
            outward = outward.map(|component| -component);
        }
        let reach_px = REACH_PX.min(height.abs() / 3.0);
        let mut edge = Self {
            patch,
            island,
            from,
            along,
            stretch,
            inverse_squared_length: 1.0 / (length * length),
            outward,
            centroid: [0, 1].map(|axis| (from[axis] + to[axis] + opposite[axis]) / 3.0),
            reach_px,
            fringe_reach_px: if height.abs() >= FRINGE_PX { FRINGE_PX } else { reach_px },
            rows: 0..0,
            columns: 0..0,
        };
        edge.columns = edge.reach(0, radius, size.width);
        edge.rows = edge.reach(1, radius, size.height);
        Some(edge)
    }

    /// Squared distance of a point, and the edge parameter (0 to 1) of the nearest point on the
    /// edge.
    pub fn distance(&self, point: [f64; 2]) -> (f64, f64) {
        let offset = [point[0] - self.from[0], point[1] - self.from[1]];
        let t =
            (offset[0] * self.along[0] + offset[1] * self.along[1]) * self.inverse_squared_length;
        let t = t.clamp(self.stretch[0], self.stretch[1]);
        let away = [offset[0] - t * self.along[0], offset[1] - t * self.along[1]];
        (away[0] * away[0] + away[1] * away[1], t)
    }

    /// The range of texels on one axis whose centres may be within `radius`.
    pub fn reach(&self, axis: usize, radius: f64, count: u32) -> Range<u32> {
        let (a, b) = (self.from[axis], self.from[axis] + self.along[axis]);
        let index = |edge: f64| (edge.ceil() as u32).min(count);
        index(a.min(b) - radius - 0.5)..index(a.max(b) + radius + 0.5)
    }

    /// The range of columns whose centres may be within `radius`, in rows whose centres lie between two
    /// heights: of a long edge it is the part that is near these rows.
    pub fn columns_near(&self, [top, bottom]: [f64; 2], radius: f64, width: u32) -> Range<u32> {
        if self.is_far() {
            return self.reach(0, radius, width);
        }
        /// More than rounding moves what is not far away.
        const SLACK: f64 = 0.01;
        let radius = radius + SLACK;
        let (top, bottom) = (top - radius, bottom + radius);
        let ends = [self.from[1], self.from[1] + self.along[1]];
        if ends.iter().all(|&end| end < top) || ends.iter().all(|&end| end > bottom) {
            return 0..0;
        }
        let at = |height: f64| ((height - self.from[1]) / self.along[1]).clamp(0.0, 1.0);
        let [first, last] = if self.along[1] == 0.0 { [0.0, 1.0] } else { [at(top), at(bottom)] };
        let [a, b] = [first, last].map(|t| self.from[0] + t * self.along[0]);
        let index = |edge: f64| (edge.ceil() as u32).min(width);
        index(a.min(b) - radius - 0.5)..index(a.max(b) + radius + 0.5)
    }

    /// Whether the edge is so far away, or so long, that distances from it are inexact.
    pub fn is_far(&self) -> bool {
        let near = |axis: usize| self.from[axis].abs() + self.along[axis].abs() < FAR_PX;
        !(near(0) && near(1))
    }

    /// The affine map of one of the edge's zones, derived from that of its triangle.
    fn zone_map(&self, zone: Zone, triangle: &Affine) -> Affine {
        let inside = |end: [f64; 2]| {
            let aside = [self.centroid[0] - end[0], self.centroid[1] - end[1]];
            let share = (self.reach_px / aside[0].hypot(aside[1])).min(1.0);
            triangle.constant([end[0] + aside[0] * share, end[1] + aside[1] * share])
        };
        match zone {
            Zone::Near => triangle.clone(),
            Zone::Beside => {
                let inward = self.outward.map(|component| -component * self.reach_px);
                triangle.projected(self.from, self.along, self.inverse_squared_length, inward)
            }
            Zone::First => inside(self.from),
            Zone::Second => inside([self.from[0] + self.along[0], self.from[1] + self.along[1]]),
        }
    }
}

/// The boundary edges of a layout at one size, bucketed by the rows that their gutter reaches.
pub(super) struct Border {
    pub size: Size,
    pub radius: f64,
    /// Linked edges first, in the order of their patches: the first of equally near edges wins, and
    /// where no linked edge is near, the others need not be checked.
    pub edges: Vec<Edge>,
    pub linked: usize,
    pub blocks: RowBlocks<u32>,
}

impl Border {
    /// - `lost`: for each boundary edge, whether another island owns the texels on its inner side.
    /// - `radius_px`: width of the gutter.
    /// - `of_faces`: the patches of each face.
    pub fn new(
        mesh: &Mesh,
        islands: &Islands,
        lost: &[bool],
        size: Size,
        radius_px: u32,
        of_faces: &FacePatches,
    ) -> Self {
        let radius = f64::from(radius_px);
        let corners = |border: BoundaryEdge| {
            let corners = corners_px(mesh, border.face as usize, size);
            [0, 1, 2].map(|k| corners[(usize::from(border.corner) + k) % 3])
        };
        let island = |border: BoundaryEdge| islands.of_faces()[border.face as usize];
        let edge = |border: BoundaryEdge, stretch: ([f64; 2], Option<u32>)| {
            Edge::new(corners(border), stretch, island(border), size, radius)
        };
        let whole = map_indices(islands.boundary_edges().len(), |index| {
            let border = islands.boundary_edges()[index];
            let patch = match of_faces.of(border.face) {
                FacePatch::None => None,
                FacePatch::One(patch) => Some(patch),
                FacePatch::Cut(_) => return None,
            };
            if lost[index] { None } else { edge(border, ([0.0, 1.0], patch)) }
        });
        let mut edges = Vec::with_capacity(whole.len());
        for ((&border, whole), lost) in islands.boundary_edges().iter().zip(whole).zip(lost) {
            edges.extend(whole);
            if let (FacePatch::Cut(face), false) = (of_faces.of(border.face), lost) {
                let stretches = face.along(usize::from(border.corner));
                edges.extend(stretches.filter_map(|stretch| edge(border, stretch)));
            }
        }
        let (mut edges, others): (Vec<Edge>, Vec<Edge>) =
            edges.into_iter().partition(|edge| edge.patch.is_some());
        let linked = edges.len();
        edges.extend(others);
        // Of edges in the same place, the first is the nearest. Cards have hundreds of them.
        let reached: Vec<Range<u32>> = if radius_px == 0 {
            Vec::new()
        } else {
            let mut places = HashSet::with_capacity(edges.len());
            let mut is_new = |edge: &Edge| {
                edge.stretch != [0.0, 1.0]
                    || places.insert([edge.from, edge.along].map(|at| at.map(f64::to_bits)))
            };
            edges.iter().map(|edge| if is_new(edge) { edge.rows.clone() } else { 0..0 }).collect()
        };
        Self {
            size,
            radius,
            linked,
            blocks: RowBlocks::new(size.height, &reached, |index| index),
            edges,
        }
    }

    /// Number of gutter patches: one for each zone of each linked edge.
    pub fn patches(&self) -> usize {
        self.linked * ZONES.len()
    }

    /// The patch that a gutter patch extends, and how its map is derived from that one's.
    ///
    /// - `patch`: index of the gutter patch, counted from the first one.
    pub fn patch(&self, patch: usize) -> (u32, impl Fn(&Affine) -> Affine) {
        let edge = &self.edges[patch / ZONES.len()];
        let zone = ZONES[patch % ZONES.len()];
        let beside = edge.patch.expect("edges with a patch come first");
        (beside, move |triangle: &Affine| edge.zone_map(zone, triangle))
    }

    /// The linked edges of islands that own texels which other islands cover too.
    ///
    /// - `clashes`: sorted pairs of islands: the one that owns texels, then the one that lost them.
    pub fn winners(&self, clashes: Vec<(u32, u32)>) -> Winners {
        let losers = |edge: &Edge| {
            let first = clashes.partition_point(|clash| clash.0 < edge.island);
            let len = clashes[first..].partition_point(|clash| clash.0 == edge.island);
            first..first + len
        };
        let linked = (0..).zip(&self.edges[..self.linked]);
        let edges: Vec<(u32, Range<usize>)> = linked
            .map(|(index, edge)| (index, losers(edge)))
            .filter(|(_, losers)| !losers.is_empty())
            .collect();
        let rows = |(edge, _): &(u32, Range<usize>)| {
            self.edges[*edge as usize].reach(1, FRINGE_PX, self.size.height)
        };
        let rows: Vec<Range<u32>> = edges.iter().map(rows).collect();
        Winners { blocks: RowBlocks::new(self.size.height, &rows, |index| index), edges, clashes }
    }
}

/// Edges of islands that won an overlap, bucketed by the rows that their fringes reach.
pub(super) struct Winners {
    /// With the part of `clashes` that their island won.
    edges: Vec<(u32, Range<usize>)>,
    pub blocks: RowBlocks<u32>,
    clashes: Vec<(u32, u32)>,
}

impl Winners {
    /// An edge, and the islands that lost texels to its own, in ascending order: the second of each pair.
    pub fn edge(&self, winner: u32) -> (u32, &[(u32, u32)]) {
        let (edge, losers) = &self.edges[winner as usize];
        (*edge, &self.clashes[losers.clone()])
    }

    /// The blocks of rows in which a loser may lose more texels than the winner covers.
    pub fn affected(&self) -> Vec<usize> {
        (0..self.blocks.count()).filter(|&block| !self.blocks.items(block).is_empty()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size::new(10, 12);

    fn edge(corners: [[f64; 2]; 3]) -> Edge {
        Edge::new(corners, ([0.0, 1.0], Some(0)), 0, SIZE, 2.0).unwrap()
    }

    #[test]
    fn distances_and_reach_by_hand() {
        let edge = edge([[2.0, 3.0], [6.0, 3.0], [2.0, 9.0]]);
        assert_eq!(edge.distance([4.0, 1.0]), (4.0, 0.5));
        assert_eq!(edge.distance([8.0, 3.0]), (4.0, 1.0));
        assert_eq!(edge.distance([-1.0, 7.0]), (25.0, 0.0));
        assert_eq!((edge.columns.clone(), edge.rows.clone()), (0..9, 1..6));
        assert_eq!((edge.outward, edge.reach_px), ([0.0, -1.0], REACH_PX));
        assert!(Edge::new([[1.0; 2]; 3], ([0.0, 1.0], None), 0, SIZE, 2.0).is_none());
    }

    #[test]
    fn long_edges_are_near_few_columns_of_a_row() {
        let mut rng = fastrand::Rng::with_seed(1);
        let size = Size::new(400, 400);
        let mut all = 0;
        for round in 0..400 {
            let mut at = || [420.0 * rng.f64() - 10.0, 420.0 * rng.f64() - 10.0];
            let (from, mut to) = (at(), at());
            if round % 9 == 0 {
                to[1] = from[1];
            }
            let stretch = ([0.0, 1.0], Some(0));
            let edge = Edge::new([from, to, [1.0, 2.0]], stretch, 0, size, 2.0).unwrap();
            for row in [0, 17, 200, 399] {
                let height = f64::from(row) + 0.5;
                let near = edge.columns_near([height; 2], FRINGE_PX, size.width);
                let is_near = |x: &u32| {
                    edge.distance([f64::from(*x) + 0.5, height]).0 < FRINGE_PX * FRINGE_PX
                };
                assert!((0..size.width).filter(is_near).all(|x| near.contains(&x)), "{round}");
                all += near.len();
            }
        }
        // Where bounds decided, they would be 60 on average.
        assert!(all < 8 * 1600, "{all}");
    }

    #[test]
    fn edges_are_far_on_any_axis_and_however_they_get_there() {
        const FAR: f64 = FAR_PX + 1.0;
        let is_far = |from: [f64; 2], to: [f64; 2]| edge([from, to, [4.0, 9.0]]).is_far();
        assert!(!is_far([2.0, 3.0], [6.0, -3.0]));
        for far in [[FAR, 3.0], [3.0, FAR], [-FAR, 3.0], [3.0, -FAR], [FAR; 2]] {
            assert!(is_far(far, [far[0] + 1.0, far[1] + 2.0]), "{far:?}");
            assert!(is_far([2.0, 3.0], far) && is_far(far, [2.0, 3.0]), "{far:?}");
        }
    }

    #[test]
    fn zones_beyond_reach_read_from_as_far_inside() {
        let edge = edge([[2.0, 3.0], [6.0, 3.0], [2.0, 9.0]]);
        let triangle =
            Affine { origin_px: [0.0; 2], origin_uv: [0.0; 2], jacobian: [[1.0, 0.0], [0.0, 1.0]] };
        let reads = |zone: Zone, px: [f64; 2]| edge.zone_map(zone, &triangle).at(px);
        let close = |found: [f64; 2], wanted: [f64; 2]| {
            (0..2).all(|axis| (found[axis] - wanted[axis]).abs() < 1e-12)
        };
        assert!(close(reads(Zone::Near, [3.0, 2.75]), [3.0, 2.75]));
        assert!(close(reads(Zone::Beside, [3.0, 1.0]), [3.0, 3.5]));
        assert!(close(reads(Zone::Beside, [5.0, 2.0]), [5.0, 3.5]));
        // Around an end it is one point, towards the centroid.
        for (zone, end) in [(Zone::First, [2.0, 3.0]), (Zone::Second, [6.0, 3.0])] {
            let aside: [f64; 2] = [10.0 / 3.0 - end[0], 5.0 - end[1]];
            let share = REACH_PX / aside[0].hypot(aside[1]);
            let wanted = [end[0] + share * aside[0], end[1] + share * aside[1]];
            assert!(close(reads(zone, [0.0, 1.0]), wanted) && close(reads(zone, [9.0; 2]), wanted));
        }
    }
}
