//! What lies just outside the islands: the gutter, and the fringe of islands that won an overlap.
//!
//! A texel of the gutter belongs to the nearest border edge. Up to [`REACH_PX`] beyond the edge its
//! source position is the triangle's map carried on. Farther out it stands still, as far inside the
//! edge: what lies beyond the edge in the source may be no part of what is carried, and would be
//! drawn out into streaks. Positions are affine within each of these zones.
//!
//! Which edge is nearest is asked tile by tile first: most edges that reach a tile are farther from
//! all of it than another, so that its texels have few left to compare.

use std::ops::Range;

use super::coverage::{Span, corners_px};
use super::rows::{BLOCK_ROWS, Draft, RowBlocks};
use super::{Affine, Run};
use crate::bits;
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

const ZONES: [Zone; 4] = [Zone::Near, Zone::Beside, Zone::First, Zone::Second];

/// More than rounding can take from or add to a distance from an edge that is not far off, in texels.
const ROUNDING_PX: f64 = 1e-3;

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
    /// The rows and columns that the gutter beside it may reach.
    rows: Range<u32>,
    columns: Range<u32>,
}

impl Edge {
    fn new(mesh: &Mesh, edge: BorderEdge, island: u32, size: Size, radius: f64) -> Option<Self> {
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
        let mut edge = Self {
            face: edge.face,
            island,
            from,
            along,
            inverse_squared_length: 1.0 / (length * length),
            outward,
            middle: [0, 1].map(|axis| (from[axis] + to[axis] + opposite[axis]) / 3.0),
            reach_px,
            fringe_reach_px: if height.abs() >= FRINGE_PX { FRINGE_PX } else { reach_px },
            rows: 0..0,
            columns: 0..0,
        };
        edge.columns = edge.reach(0, radius, size.width);
        edge.rows = edge.reach(1, radius, size.height);
        Some(edge)
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
        let [from_x, y] = [self.from[0], start[1] - self.from[1]];
        let scale = self.inverse_squared_length;
        let range = range.start as usize..range.end as usize;
        let squared_distances = nearest.squared[range.clone()].iter_mut();
        for (k, (best, edge)) in squared_distances.zip(&mut nearest.edge[range]).enumerate() {
            let x = start[0] + k as f64 - from_x;
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

    /// Whether it is so far off, or so long, that distances from it are not exact.
    fn is_far(&self) -> bool {
        const FAR_PX: f64 = 1e6;
        let near = |axis: usize| self.from[axis].abs() + self.along[axis].abs() < FAR_PX;
        !(near(0) && near(1))
    }

    /// The map of one of its zones, from that of its triangle.
    fn zone_map(&self, zone: Zone, triangle: &Affine) -> Affine {
        let inside = |end: [f64; 2]| {
            let aside = [self.middle[0] - end[0], self.middle[1] - end[1]];
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

/// The border edges of a layout at one size, bucketed by the rows that their gutter reaches.
pub(crate) struct Border {
    size: Size,
    radius: f64,
    /// Linked edges first, in the order of their patches: of edges as near as each other the first
    /// is taken, and where no linked one is near, the others need no asking.
    edges: Vec<Edge>,
    linked: usize,
    blocks: RowBlocks,
}

impl Border {
    /// - `radius_px`: how far the gutter reaches.
    /// - `is_linked`: whether a face has a map.
    pub fn new(
        mesh: &Mesh,
        islands: &Islands,
        size: Size,
        radius_px: u32,
        is_linked: impl Fn(u32) -> bool,
    ) -> Self {
        let radius = f64::from(radius_px);
        let edges = map_indices(islands.border().len(), |index| {
            let border = islands.border()[index];
            Edge::new(mesh, border, islands.of_faces()[border.face as usize], size, radius)
        });
        let (mut edges, others): (Vec<Edge>, Vec<Edge>) =
            edges.into_iter().flatten().partition(|edge| is_linked(edge.face));
        let linked = edges.len();
        edges.extend(others);
        let reached: Vec<Range<u32>> = if radius_px == 0 {
            Vec::new()
        } else {
            edges.iter().map(|edge| edge.rows.clone()).collect()
        };
        Self { size, radius, linked, blocks: RowBlocks::new(size.height, &reached), edges }
    }

    /// How many patches there are beside the linked edges.
    pub fn patches(&self) -> usize {
        self.linked * ZONES.len()
    }

    /// The face that a patch lies beside, counted from the first patch of the gutter, and its map.
    ///
    /// - `triangle`: the map of that face.
    pub fn patch<'a>(&self, patch: usize, triangle: impl Fn(u32) -> &'a Affine) -> (u32, Affine) {
        let edge = &self.edges[patch / ZONES.len()];
        (edge.face, edge.zone_map(ZONES[patch % ZONES.len()], triangle(edge.face)))
    }

    /// The edges of the islands that own what others cover too.
    ///
    /// - `clashes`: pairs of islands, sorted: the one that owns texels, the one that lost them.
    pub fn winners(&self, clashes: Vec<(u32, u32)>) -> Winners {
        let wins = |edge: &Edge| {
            let first = clashes.partition_point(|clash| clash.0 < edge.island);
            clashes.get(first).is_some_and(|clash| clash.0 == edge.island)
        };
        let edges: Vec<u32> =
            (0..).zip(&self.edges).filter(|(_, edge)| wins(edge)).map(|(index, _)| index).collect();
        let rows = |&edge: &u32| self.edges[edge as usize].reach(1, FRINGE_PX, self.size.height);
        let rows: Vec<Range<u32>> = edges.iter().map(rows).collect();
        Winners { blocks: RowBlocks::new(self.size.height, &rows), edges, clashes }
    }
}

/// Edges of islands that won an overlap, bucketed by the rows that their fringe reaches.
pub(crate) struct Winners {
    edges: Vec<u32>,
    blocks: RowBlocks,
    clashes: Vec<(u32, u32)>,
}

impl Winners {
    /// The blocks of rows in which a loser may lose more than is covered.
    pub fn concerned(&self) -> Vec<usize> {
        (0..self.blocks.count()).filter(|&block| !self.blocks.items(block).is_empty()).collect()
    }
}

const NOBODY: u32 = u32::MAX;

/// For each texel of a row, its nearest edge so far and the squared distance of it.
struct Nearest {
    squared: Vec<f64>,
    edge: Vec<u32>,
}

/// Columns of a block that are asked for their edges together; as many as rows.
const TILE: u32 = BLOCK_ROWS;

/// Edges that may be the nearest of a tile's texels.
#[derive(Default)]
struct Tile {
    /// In the order of edges, with their distances from the tile's middle.
    edges: Vec<(u32, f64)>,
    /// The least of these distances.
    least: f64,
}

/// What lies around the islands in a block of rows; buffers are kept from block to block.
pub(crate) struct Surroundings {
    nearest: Nearest,
    tiles: Vec<Tile>,
    gaps: Draft<Range<u32>>,
    /// Columns of the block that linked edges are near to: whole tiles, joined.
    reached: Vec<Range<u32>>,
    /// The runs of the latest row, from left to right. Patches count from the first of the gutter.
    pub runs: Vec<Run>,
    /// Texels of that row that islands lost to the fringe of the one they overlap with, from left to
    /// right; those that the winner has a map for are in `runs` too.
    pub stolen: Vec<u32>,
    /// Runs of the gutter that are to be merged with stolen ones.
    beside: Vec<Run>,
}

impl Surroundings {
    pub fn new(width: u32) -> Self {
        let texels = width as usize;
        Self {
            nearest: Nearest { squared: vec![f64::INFINITY; texels], edge: vec![NOBODY; texels] },
            tiles: (0..width.div_ceil(TILE)).map(|_| Tile::default()).collect(),
            gaps: Draft::new(),
            reached: Vec::new(),
            runs: Vec::new(),
            stolen: Vec::new(),
            beside: Vec::new(),
        }
    }

    /// Looks which edges are near to which tiles of a block.
    ///
    /// - `covered`: the columns that the layout covers, for each row counted from the block's first.
    pub fn enter<'a>(
        &mut self,
        border: &Border,
        block: usize,
        covered: impl Fn(usize) -> &'a [u64],
    ) {
        self.reached.clear();
        let edges = border.blocks.items(block);
        if edges.is_empty() {
            return;
        }
        let (rows, width) = (border.blocks.rows(block), border.size.width);
        self.gaps.clear();
        for row in 0..rows.len() {
            self.gaps.items.extend(bits::gaps(covered(row), width));
            self.gaps.end_row();
        }
        for tile in &mut self.tiles {
            tile.edges.clear();
            tile.least = f64::INFINITY;
        }
        // From a tile's middle to the centre of its outermost texel.
        let half_diagonal = f64::from(TILE - 1) * 0.5 * std::f64::consts::SQRT_2;
        let middle_y = f64::from(rows.start) + f64::from(TILE) * 0.5;
        for &index in edges {
            let edge = &border.edges[index as usize];
            if edge.columns.is_empty() {
                continue;
            }
            for tile in edge.columns.start / TILE..=(edge.columns.end - 1) / TILE {
                let middle = [f64::from(tile * TILE) + f64::from(TILE) * 0.5, middle_y];
                let tile = &mut self.tiles[tile as usize];
                // Distances from what is far off are not exact enough to leave any edge out.
                let away = if edge.is_far() { 0.0 } else { edge.distance(middle).0.sqrt() };
                if away <= border.radius + half_diagonal + ROUNDING_PX {
                    tile.edges.push((index, away));
                    if !edge.is_far() {
                        tile.least = tile.least.min(away);
                    }
                }
            }
        }
        for (number, tile) in (0..).zip(&mut self.tiles) {
            let limit = tile.least + 2.0 * half_diagonal + ROUNDING_PX;
            tile.edges.retain(|&(_, away)| away <= limit);
            // Linked edges come first.
            if tile.edges.first().is_some_and(|&(edge, _)| (edge as usize) < border.linked) {
                let columns = number * TILE..((number + 1) * TILE).min(width);
                match self.reached.last_mut() {
                    Some(last) if last.end == columns.start => last.end = columns.end,
                    _ => self.reached.push(columns),
                }
            }
        }
    }

    /// Finds what lies beside the islands in a row of the block that was entered.
    pub fn beside(&mut self, border: &Border, block: usize, row: u32) {
        self.runs.clear();
        self.stolen.clear();
        if self.reached.is_empty() {
            return;
        }
        let gaps = self.gaps.row((row - border.blocks.rows(block).start) as usize);
        let mut first = 0;
        for gap in gaps {
            while first < self.reached.len() && self.reached[first].end <= gap.start {
                first += 1;
            }
            for reached in self.reached[first..].iter().take_while(|range| range.start < gap.end) {
                let texels = intersection(gap, reached);
                for tile in texels.start / TILE..=(texels.end - 1) / TILE {
                    let texels = intersection(&texels, &(tile * TILE..(tile + 1) * TILE));
                    for &(index, _) in &self.tiles[tile as usize].edges {
                        let edge = &border.edges[index as usize];
                        if edge.rows.contains(&row) {
                            let texels = intersection(&texels, &edge.columns);
                            edge.offer(index, row, texels, &mut self.nearest);
                        }
                    }
                }
                let carried = |edge: &Edge| edge.reach_px;
                let nearest = &mut self.nearest;
                nearest.gather(border, row, texels, border.radius, carried, &mut self.runs, |_| {});
            }
        }
    }

    /// Takes from the losers of overlaps what lies in the fringe of the winners; after
    /// [`Surroundings::beside`].
    pub fn steal(
        &mut self,
        border: &Border,
        winners: &Winners,
        islands: &Islands,
        block: usize,
        row: u32,
        spans: &[Span],
    ) {
        let width = border.size.width;
        let mut touched = width..0;
        for &winner in winners.blocks.items(block) {
            let index = winners.edges[winner as usize];
            let edge = &border.edges[index as usize];
            let reach = edge.reach(0, FRINGE_PX, width);
            let first = spans.partition_point(|span| span.end <= reach.start);
            for span in spans[first..].iter().take_while(|span| span.start < reach.end) {
                let clash = (edge.island, islands.of_faces()[span.face as usize]);
                if winners.clashes.binary_search(&clash).is_ok() {
                    let texels = intersection(&(span.start..span.end), &reach);
                    touched = touched.start.min(texels.start)..touched.end.max(texels.end);
                    edge.offer(index, row, texels, &mut self.nearest);
                }
            }
        }
        let carried = |edge: &Edge| edge.fringe_reach_px;
        let (nearest, stolen) = (&mut self.nearest, &mut self.stolen);
        let beside = self.runs.len();
        nearest
            .gather(border, row, touched, FRINGE_PX, carried, &mut self.runs, |x| stolen.push(x));
        if beside < self.runs.len() {
            self.beside.clear();
            self.beside.extend_from_slice(&self.runs);
            self.runs.clear();
            merge(&self.beside[..beside], &self.beside[beside..], |run| self.runs.push(run));
        }
    }
}

impl Nearest {
    /// Joins neighbouring texels of one zone of one edge to runs, and forgets them. Calls
    /// `near_enough` with the texels that are near enough to some edge, whether it has a map or not.
    #[expect(clippy::too_many_arguments, reason = "what is taken and what is given, of one row")]
    fn gather(
        &mut self,
        border: &Border,
        row: u32,
        texels: Range<u32>,
        limit: f64,
        carried: impl Fn(&Edge) -> f64,
        runs: &mut Vec<Run>,
        mut near_enough: impl FnMut(u32),
    ) {
        for x in texels {
            let index = std::mem::replace(&mut self.edge[x as usize], NOBODY);
            self.squared[x as usize] = f64::INFINITY;
            if index == NOBODY {
                continue;
            }
            let edge = &border.edges[index as usize];
            let (squared, t) = edge.distance(centre(x, row));
            if squared >= limit * limit {
                continue;
            }
            near_enough(x);
            if index as usize >= border.linked {
                continue;
            }
            let zone = if squared <= carried(edge).powi(2) {
                Zone::Near
            } else if t <= 0.0 {
                Zone::First
            } else if t >= 1.0 {
                Zone::Second
            } else {
                Zone::Beside
            };
            let patch = index * ZONES.len() as u32 + zone as u32;
            match runs.last_mut() {
                Some(run) if run.patch == patch && run.x + run.len == x => run.len += 1,
                _ => runs.push(Run { x, len: 1, patch }),
            }
        }
    }
}

/// Calls `next` with the runs of two lists from left to right.
pub(super) fn merge(a: &[Run], mut b: &[Run], mut next: impl FnMut(Run)) {
    for &run in a {
        while let Some((&other, rest)) = b.split_first().filter(|(other, _)| other.x < run.x) {
            next(other);
            b = rest;
        }
        next(run);
    }
    b.iter().copied().for_each(next);
}

fn intersection(a: &Range<u32>, b: &Range<u32>) -> Range<u32> {
    let start = a.start.max(b.start);
    start..a.end.min(b.end).max(start)
}

fn centre(x: u32, y: u32) -> [f64; 2] {
    [f64::from(x) + 0.5, f64::from(y) + 0.5]
}
