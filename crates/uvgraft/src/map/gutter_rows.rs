//! The gutter and fringe texels of a row: which boundary edge is nearest to each of them.
//!
//! Edges are culled per tile first: an edge that is farther from the whole tile than another edge
//! cannot be the nearest of any of its texels. That removes most edges that reach a tile, so few
//! are left to compare per texel.

use std::ops::Range;

use uvgraft_surface::bits;
use uvgraft_surface::islands::Islands;

use super::Run;
use super::coverage::Span;
use super::gutter::{Border, Edge, FRINGE_PX, Winners, ZONES, Zone};
use super::rows::Draft;
use super::tiles::{TILE, tiles};

/// Upper bound of the rounding error in distances from edges that are not far away, in texels.
const ROUNDING_PX: f64 = 1e-3;

const NO_EDGE: u64 = u64::MAX;

/// For each texel of a row, the nearest edge so far and its squared distance.
struct Nearest {
    squared: Vec<f64>,
    /// As wide as a distance, so that the compiler can vectorise the selection of both.
    edge: Vec<u64>,
}

/// Edges that may be the nearest of some texel in a tile.
#[derive(Default)]
struct Tile {
    /// In the order of edges, with their distances from the centre of the tile.
    edges: Vec<(u32, f64)>,
    /// The smallest of these distances.
    least: f64,
}

/// Finds the texels around islands in a block of rows; buffers are reused from block to block.
pub(super) struct GutterRows {
    nearest: Nearest,
    tiles: Vec<Tile>,
    gaps: Draft<Range<u32>>,
    /// Columns of the block with linked edges nearby: whole tiles, merged into ranges.
    reached: Vec<Range<u32>>,
    /// The runs of the latest row, from left to right. Patch indices count from the
    /// first gutter patch.
    pub runs: Vec<Run>,
    /// Texels of that row that islands lost to the fringe of an overlapping winner, from left to
    /// right; those for which the winner has a map are in `runs` too.
    pub stolen: Vec<u32>,
    /// Gutter runs, to be merged with runs of stolen texels.
    unmerged: Vec<Run>,
}

impl GutterRows {
    pub fn new(width: u32) -> Self {
        let texels = width as usize;
        Self {
            nearest: Nearest { squared: vec![f64::INFINITY; texels], edge: vec![NO_EDGE; texels] },
            tiles: (0..width.div_ceil(TILE)).map(|_| Tile::default()).collect(),
            gaps: Draft::new(),
            reached: Vec::new(),
            runs: Vec::new(),
            stolen: Vec::new(),
            unmerged: Vec::new(),
        }
    }

    /// Starts a block: finds its gaps between islands, and the edges near each tile.
    ///
    /// Let `d` be the distance of an edge from the tile's centre, `least` the smallest such
    /// distance, and `r` the distance from the tile's centre to its outermost texel. The edge's
    /// distance from any texel is then within `d ± r`, so an edge with `d > least + 2r` is
    /// never the nearest one.
    ///
    /// - `covered`: the columns that the layout covers in a row, counted from the block's first
    ///   row.
    pub fn begin_block<'a>(
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
        // From a tile's centre to the centre of its outermost texel.
        let half_diagonal = f64::from(TILE - 1) * 0.5 * std::f64::consts::SQRT_2;
        let middle_y = f64::from(rows.start) + f64::from(TILE) * 0.5;
        let limit = border.radius + half_diagonal + ROUNDING_PX;
        for &index in edges {
            let edge = &border.edges[index as usize];
            // Of a long edge, only the tiles that it passes.
            let near = edge.columns_near([middle_y; 2], limit + f64::from(TILE) * 0.5, width);
            for tile in intersection(&tiles(&edge.columns), &tiles(&near)) {
                let middle = [f64::from(tile * TILE) + f64::from(TILE) * 0.5, middle_y];
                let tile = &mut self.tiles[tile as usize];
                // Distances from far edges are too inexact to exclude any.
                let away = if edge.is_far() { 0.0 } else { edge.distance(middle).0.sqrt() };
                if away <= limit {
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

    /// Finds the gutter runs of a row of the current block.
    pub fn find_gutter(&mut self, border: &Border, block: usize, row: u32) {
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
                let reach = |edge: &Edge| edge.reach_px;
                let nearest = &mut self.nearest;
                nearest.gather(border, row, texels, border.radius, reach, &mut self.runs, |_| {});
            }
        }
    }

    /// Takes the texels in the fringes of winners away from the losers of overlaps; call after
    /// [`GutterRows::find_gutter`].
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
            let (index, losers) = winners.edge(winner);
            let edge = &border.edges[index as usize];
            let height = f64::from(row) + 0.5;
            let reach = edge.columns_near([height; 2], FRINGE_PX, width);
            let first = spans.partition_point(|span| span.end <= reach.start);
            for span in spans[first..].iter().take_while(|span| span.start < reach.end) {
                let island = islands.of_faces()[span.face as usize];
                if losers.binary_search_by_key(&island, |&(_, loser)| loser).is_ok() {
                    let texels = intersection(&(span.start..span.end), &reach);
                    touched = touched.start.min(texels.start)..touched.end.max(texels.end);
                    self.nearest.offer(edge, index, row, texels);
                }
            }
        }
        let reach = |edge: &Edge| edge.fringe_reach_px;
        let (nearest, stolen) = (&mut self.nearest, &mut self.stolen);
        let split = self.runs.len();
        nearest.gather(border, row, touched, FRINGE_PX, reach, &mut self.runs, |x| stolen.push(x));
        if split < self.runs.len() {
            self.unmerged.clear();
            self.unmerged.extend_from_slice(&self.runs);
            self.runs.clear();
            merge(&self.unmerged[..split], &self.unmerged[split..], |run| self.runs.push(run));
        }
    }
}

impl Nearest {
    /// Offers an edge to the texels `range` of a row: keeps it where it is nearer than the best so
    /// far.
    fn offer(&mut self, edge: &Edge, index: u32, row: u32, range: Range<u32>) {
        // As [`Edge::distance`], in a form that the compiler can vectorise. Edges may be long and
        // far away, so 32-bit floats are not enough.
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

    /// Joins neighbouring texels with the same edge and zone into runs, and resets their
    /// state. Calls `in_range` for every texel within `limit` of an edge, whether that edge
    /// has a patch or not.
    ///
    /// - `reach`: distance up to which an edge's map is extrapolated.
    #[expect(clippy::too_many_arguments, reason = "what is taken and what is given, of one row")]
    fn gather(
        &mut self,
        border: &Border,
        row: u32,
        texels: Range<u32>,
        limit: f64,
        reach: impl Fn(&Edge) -> f64,
        runs: &mut Vec<Run>,
        mut in_range: impl FnMut(u32),
    ) {
        for x in texels {
            let index = std::mem::replace(&mut self.edge[x as usize], NO_EDGE);
            self.squared[x as usize] = f64::INFINITY;
            if index == NO_EDGE {
                continue;
            }
            let edge = &border.edges[index as usize];
            let (squared, t) = edge.distance(centre(x, row));
            if squared >= limit * limit {
                continue;
            }
            in_range(x);
            if index as usize >= border.linked {
                continue;
            }
            let zone = if squared <= reach(edge).powi(2) {
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

/// Merges two sorted lists of runs: calls `next` with each run, from left to right.
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
