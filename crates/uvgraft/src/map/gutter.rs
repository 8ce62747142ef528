//! What lies just outside the islands: the gutter, and the fringe of islands that won an overlap.
//!
//! A texel of the gutter belongs to the nearest border edge. Up to [`REACH_PX`] beyond the edge its
//! source position is the triangle's map carried on. Farther out it stands still, as far inside the
//! edge: what lies beyond the edge in the source may be no part of what is carried, and would be
//! drawn out into streaks. Positions are affine within each of these zones.

use std::ops::Range;

use super::coverage::{Coverage, RowBlocks, corners_px};
use super::{Affine, Run};
use crate::islands::{BorderEdge, Islands};
use crate::mesh::Mesh;
use crate::texture::Size;
use crate::threads::map_indices;

/// How far beyond an edge the source position still moves, in target texels, and never farther than
/// a third of the triangle's height. Bilinear filtering of the result at the edge weighs what lies up to half a
/// texel beyond most.
pub(crate) const REACH_PX: f64 = 0.5;

/// How far an island that won an overlap keeps the loser away, in target texels: what bilinear
/// filtering at the winner's edge can read, with its diagonal.
pub(crate) const FRINGE_PX: f64 = 1.5;

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
struct Edge {
    face: u32,
    island: u32,
    from: [f64; 2],
    along: [f64; 2],
    inverse_squared_length: f64,
    /// Unit normal that points away from the triangle.
    outward: [f64; 2],
    /// The triangle's middle.
    middle: [f64; 2],
    /// How far the triangle's map is carried on in the gutter.
    reach_px: f64,
    /// How far it is carried on in the fringe: all through, so that what the loser had there looks
    /// like a continuation; but thin triangles are steep, and run away.
    fringe_reach_px: f64,
    /// The first of its four maps, if its face is linked.
    first_patch: Option<u32>,
    /// Whether its island took texels from another.
    wins: bool,
}

impl Edge {
    fn new(mesh: &Mesh, edge: BorderEdge, island: u32, size: Size) -> Option<Self> {
        let corners = corners_px(mesh, edge.face as usize, size);
        let [from, to, opposite] = [0, 1, 2].map(|k| corners[(usize::from(edge.corner) + k) % 3]);
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
        Some(Self {
            face: edge.face,
            island,
            from,
            along,
            inverse_squared_length: 1.0 / (length * length),
            outward,
            middle: [0, 1].map(|axis| (from[axis] + to[axis] + opposite[axis]) / 3.0),
            reach_px,
            fringe_reach_px: if height.abs() >= FRINGE_PX { FRINGE_PX } else { reach_px },
            first_patch: None,
            wins: false,
        })
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

    /// Lowers what `nearest` holds for the texels `range` of a row to this edge's distance.
    fn offer(&self, index: u32, row: u32, range: Range<u32>, nearest: &mut Nearest) {
        // As `distance`, written so that the compiler can do several texels at once. Edges may be
        // long and far off, so 32 bits would not do.
        let [along_x, along_y] = self.along;
        let start = centre(range.start, row);
        let [start_x, y] = [0, 1].map(|axis| start[axis] - self.from[axis]);
        let scale = self.inverse_squared_length;
        let range = range.start as usize..range.end as usize;
        let squared_distances = nearest.squared[range.clone()].iter_mut();
        for (k, (best, edge)) in squared_distances.zip(&mut nearest.edge[range]).enumerate() {
            let x = start_x + k as f64;
            let t = ((x * along_x + y * along_y) * scale).clamp(0.0, 1.0);
            let (away_x, away_y) = (x - t * along_x, y - t * along_y);
            let squared = away_x * away_x + away_y * away_y;
            let closer = squared < *best;
            *best = if closer { squared } else { *best };
            *edge = if closer { index } else { *edge };
        }
    }

    /// The range of texels, on one axis, whose centre may be within `radius`.
    fn reach(&self, axis: usize, radius: f64, count: u32) -> Range<u32> {
        let (a, b) = (self.from[axis], self.from[axis] + self.along[axis]);
        let index = |edge: f64| (edge.ceil() as u32).min(count);
        index(a.min(b) - radius - 0.5)..index(a.max(b) + radius + 0.5)
    }

    /// The edge's four maps, in the order of [`Zone`], from that of its triangle.
    fn zone_maps(&self, triangle: &Affine) -> [Affine; 4] {
        let inward = self.outward.map(|component| -component * self.reach_px);
        let inside = |end: [f64; 2]| {
            let aside = [self.middle[0] - end[0], self.middle[1] - end[1]];
            let share = (self.reach_px / aside[0].hypot(aside[1])).min(1.0);
            triangle.constant([end[0] + aside[0] * share, end[1] + aside[1] * share])
        };
        [
            triangle.clone(),
            triangle.projected(self.from, self.along, self.inverse_squared_length, inward),
            inside(self.from),
            inside([self.from[0] + self.along[0], self.from[1] + self.along[1]]),
        ]
    }
}

/// The gutter of a map: its runs, row by row, and the maps that they use.
pub(crate) struct Gutter {
    pub rows: Vec<GutterRow>,
    /// Four affine maps for each linked border edge, with the face they belong to.
    pub patches: Vec<(u32, Affine)>,
}

/// What the gutter does to one row.
#[derive(Default)]
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
        radius_px: u32,
        map_of_face: impl Fn(u32) -> Option<&'a Affine>,
    ) -> Self {
        let size = coverage.size();
        let mut edges = Vec::with_capacity(islands.border().len());
        let mut patches = Vec::new();
        for border in islands.border() {
            let island = islands.of_faces()[border.face as usize];
            let Some(mut edge) = Edge::new(mesh, *border, island, size) else { continue };
            // Sorted by winner.
            edge.wins = coverage.clashes.binary_search_by_key(&island, |clash| clash.0).is_ok();
            if let Some(triangle) = map_of_face(edge.face) {
                edge.first_patch = Some(patches.len() as u32);
                patches.extend(edge.zone_maps(triangle).map(|map| (edge.face, map)));
            }
            edges.push(edge);
        }
        // Linked edges first: where none of them is near, the others need no asking.
        edges.sort_by_key(|edge| edge.first_patch.is_none());
        let radius = f64::from(radius_px);
        let reach = |edge: &Edge| if edge.wins { radius.max(FRINGE_PX) } else { radius };
        let rows: Vec<Range<u32>> =
            edges.iter().map(|edge| edge.reach(1, reach(edge), size.height)).collect();
        let blocks = RowBlocks::new(size.height, &rows);
        let rows = map_indices(blocks.count(), |block| {
            let mut around = Surroundings {
                coverage,
                islands,
                edges: &edges,
                radius,
                gaps: Vec::new(),
                nearest: Nearest::new(size.width),
            };
            let near = |row: u32| {
                let items = blocks.items(block).iter().copied();
                items.filter(|&edge| rows[edge as usize].contains(&row)).collect::<Vec<_>>()
            };
            blocks.rows(block).map(|row| around.row(row, &near(row))).collect::<Vec<_>>()
        });
        Self { rows: rows.into_iter().flatten().collect(), patches }
    }
}

const NOBODY: u32 = u32::MAX;

/// For each texel of a row, its nearest edge so far and the squared distance of it.
struct Nearest {
    squared: Vec<f64>,
    edge: Vec<u32>,
}

impl Nearest {
    fn new(width: u32) -> Self {
        let width = width as usize;
        Self { squared: vec![f64::INFINITY; width], edge: vec![NOBODY; width] }
    }
}

/// What a row's gutter depends on, and buffers kept from row to row.
struct Surroundings<'a> {
    coverage: &'a Coverage,
    islands: &'a Islands,
    edges: &'a [Edge],
    radius: f64,
    gaps: Vec<Range<u32>>,
    nearest: Nearest,
}

impl Surroundings<'_> {
    /// - `near`: the edges that may reach this row, linked ones first.
    fn row(&mut self, row: u32, near: &[u32]) -> GutterRow {
        let mut result = GutterRow::default();
        let width = self.nearest.edge.len() as u32;
        let linked = near.partition_point(|&edge| self.edges[edge as usize].first_patch.is_some());
        // Where linked edges reach; the others matter only there.
        let mut reached: Vec<Range<u32>> = near[..linked]
            .iter()
            .map(|&edge| self.edges[edge as usize].reach(0, self.radius, width))
            .collect();
        join(&mut reached);
        if !reached.is_empty() {
            self.gaps.clear();
            self.coverage.gaps(row, &mut self.gaps);
            let reached = common(&reached, &self.gaps);
            for &index in near {
                let edge = &self.edges[index as usize];
                let reach = edge.reach(0, self.radius, width);
                let first = reached.partition_point(|range| range.end <= reach.start);
                for range in reached[first..].iter().take_while(|range| range.start < reach.end) {
                    edge.offer(index, row, intersection(range, &reach), &mut self.nearest);
                }
            }
            for range in reached {
                self.gather(row, range, self.radius, |edge| edge.reach_px, &mut result.runs);
            }
        }
        if near.iter().any(|&edge| self.edges[edge as usize].wins) {
            self.steal(row, near, &mut result);
        }
        result
    }

    /// Takes from the losers of overlaps what lies in the fringe of the winners.
    fn steal(&mut self, row: u32, near: &[u32], result: &mut GutterRow) {
        let width = self.nearest.edge.len() as u32;
        for &index in near {
            let edge = &self.edges[index as usize];
            if !edge.wins {
                continue;
            }
            let reach = edge.reach(0, FRINGE_PX, width);
            for span in self.coverage.row(row) {
                let clash = (edge.island, self.islands.of_faces()[span.face as usize]);
                let texels = intersection(&(span.start..span.end), &reach);
                if !texels.is_empty() && self.coverage.clashes.binary_search(&clash).is_ok() {
                    edge.offer(index, row, texels, &mut self.nearest);
                }
            }
        }
        let carried = |edge: &Edge| edge.fringe_reach_px;
        result.stolen = self.gather(row, 0..width, FRINGE_PX, carried, &mut result.runs);
        result.runs.sort_unstable_by_key(|run| run.x);
    }

    /// Joins neighbouring texels of one zone of one edge to runs, and forgets them. Gives the texels
    /// that are near enough to some edge, whether it has a map or not.
    fn gather(
        &mut self,
        row: u32,
        texels: Range<u32>,
        limit: f64,
        carried: impl Fn(&Edge) -> f64,
        runs: &mut Vec<Run>,
    ) -> Vec<u32> {
        let mut near_enough = Vec::new();
        for x in texels {
            let index = std::mem::replace(&mut self.nearest.edge[x as usize], NOBODY);
            self.nearest.squared[x as usize] = f64::INFINITY;
            if index == NOBODY {
                continue;
            }
            let edge = &self.edges[index as usize];
            let (squared, t) = edge.distance(centre(x, row));
            if squared >= limit * limit {
                continue;
            }
            near_enough.push(x);
            let Some(first) = edge.first_patch else { continue };
            let zone = if squared <= carried(edge).powi(2) {
                Zone::Near
            } else if t <= 0.0 {
                Zone::First
            } else if t >= 1.0 {
                Zone::Second
            } else {
                Zone::Beside
            };
            let patch = first + zone as u32;
            match runs.last_mut() {
                Some(run) if run.patch == patch && run.x + run.len == x => run.len += 1,
                _ => runs.push(Run { x, len: 1, patch }),
            }
        }
        near_enough
    }
}

fn intersection(a: &Range<u32>, b: &Range<u32>) -> Range<u32> {
    let start = a.start.max(b.start);
    start..a.end.min(b.end).max(start)
}

/// Sorts ranges and joins those that touch.
fn join(ranges: &mut Vec<Range<u32>>) {
    ranges.sort_unstable_by_key(|range| range.start);
    ranges.dedup_by(|next, last| {
        let touches = next.start <= last.end;
        if touches {
            last.end = last.end.max(next.end);
        }
        touches
    });
}

/// The parts that two lists of ranges share; both sorted and each without overlaps.
fn common(a: &[Range<u32>], b: &[Range<u32>]) -> Vec<Range<u32>> {
    let mut shared = Vec::new();
    let mut first = 0;
    for range in a {
        while first < b.len() && b[first].end <= range.start {
            first += 1;
        }
        let touching = b[first..].iter().take_while(|other| other.start < range.end);
        shared.extend(touching.map(|other| intersection(range, other)));
    }
    shared
}

fn centre(x: u32, y: u32) -> [f64; 2] {
    [f64::from(x) + 0.5, f64::from(y) + 0.5]
}
