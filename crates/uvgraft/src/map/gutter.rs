//! What lies just outside the islands: the gutter, and the fringe of islands that won an overlap.
//!
//! A texel of the gutter belongs to the nearest border edge. Its source position is the edge's
//! triangle carried on beyond the edge for up to [`REACH_PX`], and stays there farther out, so that
//! it is still affine within each zone of an edge while never running away on a steep triangle.

use std::ops::Range;

use super::coverage::{Coverage, RowBlocks, Span, corners_px};
use super::{Affine, Run};
use crate::islands::Islands;
use crate::mesh::Mesh;
use crate::texture::Size;
use crate::threads::map_indices;

/// How far beyond an edge the source position still moves, in target texels. Bilinear filtering of
/// the result reads up to one texel beyond the edge.
const REACH_PX: f64 = 1.0;

/// How far an island that won an overlap keeps the loser away, in target texels: what bilinear
/// filtering at the winner's edge can read, with its diagonal.
const FRINGE_PX: f64 = 1.5;

/// Where a texel lies relative to its nearest edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Zone {
    /// Within reach: the triangle's own map, carried on.
    Near = 0,
    /// Beyond reach, beside the edge.
    Beside = 1,
    /// Beyond reach, around the edge's first end.
    First = 2,
    /// Beyond reach, around the edge's second end.
    Second = 3,
}

/// A border edge in texels.
pub(crate) struct Edge {
    pub face: u32,
    island: u32,
    from: [f64; 2],
    along: [f64; 2],
    inverse_squared_length: f64,
    /// Unit normal that points away from the triangle.
    outward: [f64; 2],
}

impl Edge {
    fn new(mesh: &Mesh, face: u32, corner: u8, island: u32, size: Size) -> Option<Self> {
        let corners = corners_px(mesh, face as usize, size);
        let [from, to, opposite] = [0, 1, 2].map(|k| corners[(usize::from(corner) + k) % 3]);
        let along = [to[0] - from[0], to[1] - from[1]];
        let length = along[0].hypot(along[1]);
        if length == 0.0 {
            return None;
        }
        let mut outward = [-along[1] / length, along[0] / length];
        let inside = [opposite[0] - from[0], opposite[1] - from[1]];
        if outward[0] * inside[0] + outward[1] * inside[1] > 0.0 {
            outward = outward.map(|component| -component);
        }
        let inverse_squared_length = 1.0 / (length * length);
        Some(Self { face, island, from, along, inverse_squared_length, outward })
    }

    /// Squared distance of a point, and how far along the edge its nearest point lies (0 to 1).
    fn distance(&self, point: [f64; 2]) -> (f64, f64) {
        let offset = [point[0] - self.from[0], point[1] - self.from[1]];
        let t =
            (offset[0] * self.along[0] + offset[1] * self.along[1]) * self.inverse_squared_length;
        let t = t.clamp(0.0, 1.0);
        let away = [offset[0] - t * self.along[0], offset[1] - t * self.along[1]];
        (away[0] * away[0] + away[1] * away[1], t)
    }

    /// The range of texels, on one axis, whose centre may be within `radius`.
    fn reach(&self, axis: usize, radius: f64, count: u32) -> Range<u32> {
        let (a, b) = (self.from[axis], self.from[axis] + self.along[axis]);
        let index = |edge: f64| (edge.ceil() as u32).min(count);
        index(a.min(b) - radius - 0.5)..index(a.max(b) + radius + 0.5)
    }

    /// The edge's four maps, in the order of [`Zone`], from that of its triangle.
    fn zone_maps(&self, triangle: &Affine) -> [Affine; 4] {
        let shift = self.outward.map(|component| component * REACH_PX);
        let second = [self.from[0] + self.along[0], self.from[1] + self.along[1]];
        [
            triangle.clone(),
            triangle.projected(self.from, self.along, self.inverse_squared_length, shift),
            triangle.constant(self.from),
            triangle.constant(second),
        ]
    }
}

/// The gutter of a map: its runs, row by row, and the maps that they use.
pub(crate) struct Gutter {
    pub rows: Vec<GutterRow>,
    /// Four affine maps for each edge that runs use, with the face they belong to.
    pub patches: Vec<(u32, Affine)>,
}

/// What the gutter does to one row.
#[derive(Default, Clone)]
pub(crate) struct GutterRow {
    /// From left to right. Patches count from the first patch of the gutter.
    pub runs: Vec<Run>,
    /// Texels that islands lost to the fringe of the one they overlap with, from left to right;
    /// those that the winner has a map for are in `runs` too.
    pub stolen: Vec<u32>,
}

impl Gutter {
    /// - `radius_px`: how far the gutter reaches.
    /// - `map_of_face`: the map of each face that is linked.
    pub fn new<'a>(
        mesh: &Mesh,
        islands: &Islands,
        coverage: &Coverage,
        radius_px: f64,
        map_of_face: impl Fn(u32) -> Option<&'a Affine> + Sync,
    ) -> Self {
        let size = coverage.size();
        let edges: Vec<Edge> = islands
            .border()
            .iter()
            .filter_map(|edge| {
                let island = islands.of_faces()[edge.face as usize];
                Edge::new(mesh, edge.face, edge.corner, island, size)
            })
            .collect();
        let mut first_patch = vec![None; edges.len()];
        let mut patches = Vec::new();
        for (edge, first) in edges.iter().zip(&mut first_patch) {
            if let Some(triangle) = map_of_face(edge.face) {
                *first = Some(patches.len() as u32);
                patches.extend(edge.zone_maps(triangle).map(|map| (edge.face, map)));
            }
        }
        let radius = radius_px.max(if coverage.clashes.is_empty() { 0.0 } else { FRINGE_PX });
        let rows: Vec<Range<u32>> =
            edges.iter().map(|edge| edge.reach(1, radius, size.height)).collect();
        let blocks = RowBlocks::new(size.height, &rows);
        let rows = map_indices(blocks.count(), |block| {
            let mut scratch = Scratch::new(size.width);
            blocks
                .rows(block)
                .map(|row| {
                    let near = blocks
                        .items(block)
                        .iter()
                        .filter(|&&edge| rows[edge as usize].contains(&row))
                        .copied();
                    scratch.row(row, coverage, islands, &edges, near, radius_px, &first_patch)
                })
                .collect::<Vec<_>>()
        });
        Self { rows: rows.into_iter().flatten().collect(), patches }
    }
}

const NOBODY: u32 = u32::MAX;

/// Buffers of one row, kept from row to row.
struct Scratch {
    /// Owner of each texel, or [`NOBODY`].
    owner: Vec<u32>,
    /// Nearest edge of each texel and its squared distance.
    nearest: Vec<(f64, u32)>,
}

impl Scratch {
    fn new(width: u32) -> Self {
        let width = width as usize;
        Self { owner: vec![NOBODY; width], nearest: vec![(f64::INFINITY, NOBODY); width] }
    }

    #[expect(clippy::too_many_arguments, reason = "the row's whole surroundings, used once")]
    fn row(
        &mut self,
        row: u32,
        coverage: &Coverage,
        islands: &Islands,
        edges: &[Edge],
        near: impl Iterator<Item = u32>,
        radius_px: f64,
        first_patch: &[Option<u32>],
    ) -> GutterRow {
        let spans = coverage.row(row);
        let mut touched: Option<Range<u32>> = None;
        for index in near {
            if touched.is_none() {
                self.claim(spans);
            }
            let edge = &edges[index as usize];
            let reach = edge.reach(0, radius_px.max(FRINGE_PX), self.owner.len() as u32);
            let wins = coverage.clashes.iter().any(|&(winner, _)| winner == edge.island);
            for x in reach.clone() {
                let owner = self.owner[x as usize];
                let limit = if owner == NOBODY {
                    radius_px
                } else if wins
                    && coverage
                        .clashes
                        .binary_search(&(edge.island, islands.of_faces()[owner as usize]))
                        .is_ok()
                {
                    FRINGE_PX
                } else {
                    continue;
                };
                let (squared, _) = edge.distance(centre(x, row));
                let nearest = &mut self.nearest[x as usize];
                if squared < limit * limit && squared < nearest.0 {
                    *nearest = (squared, index);
                }
            }
            let so_far = touched.unwrap_or(reach.clone());
            touched = Some(so_far.start.min(reach.start)..so_far.end.max(reach.end));
        }
        let Some(touched) = touched else { return GutterRow::default() };
        let result = self.gather(row, touched.clone(), edges, first_patch);
        for x in touched {
            self.nearest[x as usize] = (f64::INFINITY, NOBODY);
        }
        for span in spans {
            self.owner[span.texels()].fill(NOBODY);
        }
        result
    }

    fn claim(&mut self, spans: &[Span]) {
        for span in spans {
            self.owner[span.texels()].fill(span.face);
        }
    }

    /// Joins neighbouring texels of one zone of one edge to runs.
    fn gather(
        &self,
        row: u32,
        touched: Range<u32>,
        edges: &[Edge],
        first_patch: &[Option<u32>],
    ) -> GutterRow {
        let mut result = GutterRow::default();
        for x in touched {
            let (squared, index) = self.nearest[x as usize];
            if index == NOBODY {
                continue;
            }
            if self.owner[x as usize] != NOBODY {
                result.stolen.push(x);
            }
            let Some(first) = first_patch[index as usize] else { continue };
            let (_, t) = edges[index as usize].distance(centre(x, row));
            let zone = if squared <= REACH_PX * REACH_PX {
                Zone::Near
            } else if t <= 0.0 {
                Zone::First
            } else if t >= 1.0 {
                Zone::Second
            } else {
                Zone::Beside
            };
            let patch = first + zone as u32;
            match result.runs.last_mut() {
                Some(run) if run.patch == patch && run.x + run.len == x => run.len += 1,
                _ => result.runs.push(Run { x, len: 1, patch }),
            }
        }
        result
    }
}

fn centre(x: u32, y: u32) -> [f64; 2] {
    [f64::from(x) + 0.5, f64::from(y) + 0.5]
}
