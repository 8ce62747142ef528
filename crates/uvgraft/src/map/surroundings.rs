//! What lies beside the islands in a row: which border edge is nearest to each texel.
//!
//! Tiles are asked first: most edges that reach a tile are farther from all of it than another, so
//! that its texels have few left to compare.

use std::ops::Range;

use super::Run;
use super::coverage::Span;
use super::gutter::{Border, Edge, FRINGE_PX, Winners, ZONES, Zone};
use super::rows::Draft;
use super::tiles::{TILE, tiles};
use crate::bits;
use crate::islands::Islands;

/// More than rounding can take from or add to a distance from an edge that is not far off, in texels.
const ROUNDING_PX: f64 = 1e-3;

const NOBODY: u64 = u64::MAX;

/// For each texel of a row, its nearest edge so far and the squared distance of it.
struct Nearest {
    squared: Vec<f64>,
    /// As wide as a distance, so that the compiler can choose among several of both at once.
    edge: Vec<u64>,
}

/// Edges that may be the nearest of a tile's texels.
#[derive(Default)]
struct Tile {
    /// In the order of edges, with their distances from the tile's middle.
    edges: Vec<(u32, f64)>,
    /// The least of these distances.
    least: f64,
}

/// What lies around the islands in a block of rows; buffers are kept from block to block.
pub(super) struct Surroundings {
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
            for tile in tiles(&edge.columns) {
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
                for tile in tiles(&texels) {
                    let texels = intersection(&texels, &(tile * TILE..(tile + 1) * TILE));
                    for &(index, _) in &self.tiles[tile as usize].edges {
                        let edge = &border.edges[index as usize];
                        if edge.rows.contains(&row) {
                            let texels = intersection(&texels, &edge.columns);
                            self.nearest.offer(edge, index, row, texels);
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
                    self.nearest.offer(edge, index, row, texels);
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
    /// Lowers what is held for the texels `range` of a row to an edge's distance.
    fn offer(&mut self, edge: &Edge, index: u32, row: u32, range: Range<u32>) {
        // As [`Edge::distance`], written so that the compiler can do several texels at once. Edges may be
        // long and far off, so 32 bits would not do.
        let [along_x, along_y] = edge.along;
        let start = centre(range.start, row);
        let [from_x, y] = [edge.from[0], start[1] - edge.from[1]];
        let scale = edge.inverse_squared_length;
        let [first, last] = edge.stretch;
        let range = range.start as usize..range.end as usize;
        let squared_distances = self.squared[range.clone()].iter_mut();
        for (k, (best, nearest)) in squared_distances.zip(&mut self.edge[range]).enumerate() {
            let x = start[0] + k as f64 - from_x;
            let t = ((x * along_x + y * along_y) * scale).clamp(first, last);
            let (away_x, away_y) = (x - t * along_x, y - t * along_y);
            let squared = away_x * away_x + away_y * away_y;
            let closer = squared < *best;
            *best = if closer { squared } else { *best };
            *nearest = if closer { u64::from(index) } else { *nearest };
        }
    }

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
            let patch = (index as usize * ZONES.len()) as u32 + zone as u32;
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
