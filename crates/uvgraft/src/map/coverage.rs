//! Coverage of a layout: which triangle owns which texel.

use std::ops::Range;

use uvgraft_surface::bits;
use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::raster::{ScanTriangle, in_texels};
use uvgraft_surface::threads::{map_indices, map_indices_with};

use super::precedence::Precedence;
use super::rows::{BLOCK_ROWS, Draft, RowBlocks, RowLists};
use crate::texture::{Size, Texture};

/// The owner of every texel that a layout covers, as spans per row.
///
/// Where triangles overlap, the island with the lowest rank owns the texel, and within an
/// island the lowest face.
pub(crate) struct Coverage {
    rows: RowLists<Span>,
    /// Texels that more than one triangle covers.
    pub overlapping: usize,
    /// Pairs of islands that share texels, sorted: the island that owns them, then the
    /// one that lost them.
    pub clashes: Vec<(u32, u32)>,
    size: Size,
}

/// Consecutive texels of a row with one owner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Span {
    pub start: u32,
    pub end: u32,
    pub face: u32,
}

/// The triangles of a layout at one size, bucketed by the blocks of rows that they touch.
pub(crate) struct LayoutTriangles {
    pub size: Size,
    /// Their faces and UV coordinates. These are copied, since the triangles of a block may lie anywhere
    /// in the mesh: with a million of them, most would have to be fetched from main memory.
    pub blocks: RowBlocks<(u32, [[f32; 2]; 3])>,
    /// The UV coordinates of each face.
    uv: Vec<[[f32; 2]; 3]>,
}

impl LayoutTriangles {
    /// # Panics
    /// If `size` is not a valid texture size.
    pub fn new(mesh: &Mesh, size: Size) -> Self {
        let sides = 1..=Texture::MAX_SIDE;
        assert!(
            sides.contains(&size.width) && sides.contains(&size.height),
            "no texture of {size}"
        );
        let uv = map_indices(mesh.faces().len(), |face| mesh.uv_triangle(face));
        let rows = map_indices(uv.len(), |face| {
            let corners = in_texels(uv[face], size);
            ScanTriangle::rows_between(corners.map(|corner| corner[1]), size.height)
        });
        let blocks = RowBlocks::new(size.height, &rows, |face| (face, uv[face as usize]));
        Self { size, blocks, uv }
    }

    /// The corners of a face, in texels.
    pub fn corners_px(&self, face: usize) -> [[f64; 2]; 3] {
        in_texels(self.uv[face], self.size)
    }

    /// The triangles that may own texels of a block, with their faces, in ascending order of faces.
    ///
    /// - `needed`: given the column range of a triangle, in texels, decides whether to include it.
    pub fn triangles(
        &self,
        block: usize,
        needed: impl Fn(Range<f64>) -> bool,
    ) -> impl Iterator<Item = (u32, ScanTriangle)> {
        self.blocks.items(block).iter().filter_map(move |&(face, uv)| {
            let corners = in_texels(uv, self.size);
            let [a, b, c] = corners.map(|corner| corner[0]);
            if !needed(a.min(b).min(c)..a.max(b).max(c)) {
                return None;
            }
            ScanTriangle::new(corners, self.size).map(|triangle| (face, triangle))
        })
    }
}

impl Coverage {
    pub fn new(layout: &LayoutTriangles, precedence: &Precedence) -> Self {
        let size = layout.size;
        let sweep = || Sweep::new(size.width);
        let blocks = map_indices_with(layout.blocks.count(), sweep, |sweep, block| {
            sweep.cover_all(layout, precedence, block);
            (sweep.spans.block(), sweep.overlapping, sweep.take_clashes())
        });
        let overlapping = blocks.iter().map(|(_, overlapping, _)| overlapping).sum();
        let mut clashes: Vec<(u32, u32)> =
            blocks.iter().flat_map(|(_, _, clashes)| clashes).copied().collect();
        clashes.sort_unstable();
        clashes.dedup();
        let rows = RowLists::new(blocks.into_iter().map(|(block, ..)| block).collect());
        Self { rows, overlapping, clashes, size }
    }

    /// The face that owns the texel containing a point.
    pub fn owner(&self, [x, y]: [f64; 2]) -> Option<u32> {
        let inside = (0.0..f64::from(self.size.width)).contains(&x)
            && (0.0..f64::from(self.size.height)).contains(&y);
        let spans = if inside { self.row(y as u32) } else { &[] };
        let x = x as u32;
        let next = spans.partition_point(|span| span.end <= x);
        spans.get(next).filter(|span| span.start <= x).map(|span| span.face)
    }

    /// The spans of a row, from left to right.
    pub fn row(&self, row: u32) -> &[Span] {
        self.rows.row(row)
    }
}

/// Sweeps a block of rows: puts the spans of triangles in order and gives each texel one owner.
/// Nothing is sorted: a span is stored at the column where it starts, and the columns that hold one
/// are read off a bit set.
pub(crate) struct Sweep {
    width: u32,
    /// Number of words in a bit set of columns.
    words: usize,
    /// For each row, the bit set of covered columns.
    covered: Vec<u64>,
    /// For each row, the bit set of columns where spans start.
    starts: Vec<u64>,
    /// For each texel where spans start, the one stored last.
    slots: Vec<Slot>,
    /// Spans that were displaced from `slots` by later ones.
    earlier: Vec<Slot>,
    overlap: OverlapResolver,
    /// The spans of the block, disjoint and from left to right in each row.
    pub spans: Draft<Span>,
    /// Texels of the block that several triangles cover.
    pub overlapping: usize,
    clashes: Clashes,
}

/// A span; the texel where it starts follows from where it is stored.
#[derive(Clone, Copy)]
struct Slot {
    end: u32,
    face: u32,
    /// Index in [`Sweep::earlier`] of the previous span that starts at the same texel, or [`NONE`].
    before: u32,
}

const NONE: u32 = u32::MAX;

impl Sweep {
    pub fn new(width: u32) -> Self {
        let rows = BLOCK_ROWS as usize;
        Self {
            width,
            words: bits::words(width),
            covered: vec![0; bits::words(width) * rows],
            starts: vec![0; bits::words(width) * rows],
            slots: vec![Slot { end: 0, face: 0, before: 0 }; width as usize * rows],
            earlier: Vec::new(),
            overlap: OverlapResolver::default(),
            spans: Draft::new(),
            overlapping: 0,
            clashes: Clashes::default(),
        }
    }

    /// Finds the owners of the texels in a block. Faces that are not `needed` are left out
    /// of the spans, though not out of the covered columns, unless the block has overlaps,
    /// which need all faces.
    pub fn cover(
        &mut self,
        layout: &LayoutTriangles,
        precedence: &Precedence,
        block: usize,
        needed: impl Fn(u32) -> bool,
    ) {
        self.clear();
        let rows = layout.blocks.rows(block);
        for (face, triangle) in layout.triangles(block, |_| true) {
            let needed = needed(face);
            for (row, span) in triangle.spans(&rows) {
                if span.is_empty() {
                    continue;
                }
                let row = (row - rows.start) as usize;
                if bits::claim(&mut self.covered[row * self.words..][..self.words], &span) {
                    return self.cover_all(layout, precedence, block);
                }
                if needed {
                    self.store(row, &span, face);
                }
            }
        }
        self.collect(rows.len(), precedence);
    }

    /// Finds the owners of the texels in a block, with overlaps and all faces.
    pub fn cover_all(&mut self, layout: &LayoutTriangles, precedence: &Precedence, block: usize) {
        self.clear();
        let rows = layout.blocks.rows(block);
        for (face, triangle) in layout.triangles(block, |_| true) {
            for (row, span) in triangle.spans(&rows) {
                if span.is_empty() {
                    continue;
                }
                self.store((row - rows.start) as usize, &span, face);
            }
        }
        self.collect(rows.len(), precedence);
        // Once for all triangles that cover a texel, however many there are.
        for row in 0..rows.len() {
            let covered = &mut self.covered[row * self.words..][..self.words];
            for span in self.spans.row(row) {
                bits::insert_range(covered, &(span.start..span.end));
            }
        }
    }

    /// The covered columns of a row; `row` counts from the first row of the block.
    pub fn covered(&self, row: usize) -> &[u64] {
        &self.covered[row * self.words..][..self.words]
    }

    fn clear(&mut self) {
        self.covered.fill(0);
        self.starts.fill(0);
        self.earlier.clear();
        self.spans.clear();
        self.overlapping = 0;
        self.clashes.take();
    }

    /// Stores a span at the texel where it starts.
    #[inline]
    fn store(&mut self, row: usize, span: &Range<u32>, face: u32) {
        let starts = &mut self.starts[row * self.words..][..self.words];
        let slot = &mut self.slots[row * self.width as usize..][span.start as usize];
        let mut before = NONE;
        if bits::contains(starts, span.start) {
            before = self.earlier.len() as u32;
            self.earlier.push(*slot);
        }
        bits::insert(starts, span.start);
        *slot = Slot { end: span.end, face, before };
    }

    /// Moves the stored spans of all rows to `spans`.
    fn collect(&mut self, rows: usize, precedence: &Precedence) {
        for row in 0..rows {
            self.collect_row(row, precedence);
        }
    }

    /// Takes the pairs of islands that share texels of the block, sorted: the island that owns them,
    /// then the one that lost them.
    pub fn take_clashes(&mut self) -> Vec<(u32, u32)> {
        self.clashes.take()
    }

    /// Moves the stored spans of a row to `spans`, from left to right.
    fn collect_row(&mut self, row: usize, precedence: &Precedence) {
        let starts = &self.starts[row * self.words..][..self.words];
        let slots = &self.slots[row * self.width as usize..][..self.width as usize];
        let spans = &mut self.spans;
        // The end of the spans so far, and the index of the first span of the current
        // overlapping group.
        let (mut end, mut first) = (0, spans.items.len());
        for start in bits::members(starts) {
            if end <= start {
                if spans.items.len() > first + 1 {
                    self.overlapping +=
                        self.overlap.settle(&mut spans.items, first, precedence, &mut self.clashes);
                }
                first = spans.items.len();
            }
            let mut slot = slots[start as usize];
            loop {
                end = end.max(slot.end);
                spans.items.push(Span { start, end: slot.end, face: slot.face });
                if slot.before == NONE {
                    break;
                }
                slot = self.earlier[slot.before as usize];
            }
        }
        if spans.items.len() > first + 1 {
            self.overlapping +=
                self.overlap.settle(&mut spans.items, first, precedence, &mut self.clashes);
        }
        spans.end_row();
    }
}

/// Decides which of several triangles owns the texels that they cover; buffers.
#[derive(Default)]
struct OverlapResolver {
    claims: Vec<Span>,
    /// The owner of each texel.
    owners: Vec<u32>,
    /// For each texel, a texel from which on the next one without an owner is found.
    free: Vec<u32>,
    /// How many more spans cover each texel than the one before it.
    more: Vec<i32>,
    /// The islands that own texels, from left to right: where each ends, and which it is.
    islands: Vec<(u32, u32)>,
}

impl OverlapResolver {
    /// Replaces the overlapping spans from `first` on by spans of the owners: a texel goes to
    /// the claimant with the lowest rank. Returns the number of shared texels.
    ///
    /// Claims are served by rank, and each takes what is still free, so that the time grows with the
    /// number of claims and texels, not with their product.
    fn settle(
        &mut self,
        spans: &mut Vec<Span>,
        first: usize,
        precedence: &Precedence,
        clashes: &mut Clashes,
    ) -> usize {
        self.claims.clear();
        self.claims.extend(spans.drain(first..));
        let left = self.claims[0].start;
        let end = self.claims.iter().map(|span| span.end).max().unwrap_or(left);
        self.claims.sort_unstable_by_key(|span| precedence.rank(span.face));
        let texels = |span: &Span| (span.start - left) as usize..(span.end - left) as usize;
        let count = (end - left) as usize;
        self.owners.clear();
        self.owners.resize(count, NONE);
        self.free.clear();
        self.free.extend(0..=count as u32);
        self.more.clear();
        self.more.resize(count + 1, 0);
        for span in &self.claims {
            let texels = texels(span);
            self.more[texels.start] += 1;
            self.more[texels.end] -= 1;
            let mut x = next_free(&mut self.free, texels.start);
            while x < texels.end {
                self.owners[x] = span.face;
                self.free[x] = x as u32 + 1;
                x = next_free(&mut self.free, x + 1);
            }
        }
        let mut start = left;
        for owned in self.owners.chunk_by(|a, b| a == b) {
            let end = start + owned.len() as u32;
            spans.push(Span { start, end, face: owned[0] });
            start = end;
        }
        self.note_clashes(&spans[first..], precedence, clashes);
        let mut covering = 0;
        let is_shared = |more: &&i32| {
            covering += **more;
            covering > 1
        };
        self.more.iter().filter(is_shared).count()
    }

    /// Adds which islands take texels from which.
    ///
    /// - `owned`: the spans of the owners.
    fn note_clashes(&mut self, owned: &[Span], precedence: &Precedence, clashes: &mut Clashes) {
        let island = |face: u32| precedence.of_faces()[face as usize];
        // Islands own most of their texels together.
        self.islands.clear();
        for span in owned {
            let owner = island(span.face);
            match self.islands.last_mut() {
                Some((end, last)) if *last == owner => *end = span.end,
                _ => self.islands.push((span.end, owner)),
            }
        }
        for span in &self.claims {
            let beside = self.islands.partition_point(|(end, _)| *end <= span.start);
            for &(end, owner) in &self.islands[beside..] {
                clashes.add(owner, island(span.face));
                if end >= span.end || clashes.is_full() {
                    break;
                }
            }
        }
    }
}

/// The first texel from `x` on that has no owner, or the number of texels.
fn next_free(free: &mut [u32], x: usize) -> usize {
    let mut found = x;
    while free[found] as usize != found {
        found = free[found] as usize;
    }
    // Later searches from the same texels take one step.
    let mut at = x;
    while at != found {
        at = std::mem::replace(&mut free[at], found as u32) as usize;
    }
    found
}

/// Pairs of islands that share texels: the island that owns them, then the one that lost them.
///
/// Where thousands of islands lie all over each other, each clashes with most others, and a part of the
/// pairs stands for all: in each block of rows so many are looked at, and kept.
#[derive(Default)]
struct Clashes {
    /// How many pairs were added, repetitions included.
    added: usize,
    pairs: Vec<(u32, u32)>,
    /// How many pairs were left when repetitions were last removed.
    distinct: usize,
    /// The latest winner over each island, or [`NONE`]: the same pairs come row after row.
    latest: Vec<u32>,
}

impl Clashes {
    fn add(&mut self, winner: u32, loser: u32) {
        /// Pairs that are collected at least before repetitions are removed.
        const AT_ONCE: usize = 4096;
        self.added += 1;
        if winner == loser || self.is_full() {
            return;
        }
        if self.latest.len() <= loser as usize {
            self.latest.resize(loser as usize + 1, NONE);
        }
        if std::mem::replace(&mut self.latest[loser as usize], winner) == winner {
            return;
        }
        self.pairs.push((winner, loser));
        if self.pairs.len() > AT_ONCE.max(2 * self.distinct) {
            self.settle();
        }
    }

    /// Whether as many were looked at, or kept, as may be: from then on, no pairs are.
    fn is_full(&self) -> bool {
        /// A hundred layers of islands, each cut into a hundred pieces by others, in 16 rows: 160,000.
        const ADDED: usize = 1 << 18;
        /// In 256 blocks, 64 MiB at most. A hundred islands that all clash have 5,000 pairs.
        const KEPT: usize = 1 << 14;
        self.added > ADDED || self.distinct > KEPT
    }

    fn settle(&mut self) {
        self.pairs.sort_unstable();
        self.pairs.dedup();
        self.distinct = self.pairs.len();
    }

    /// The pairs, sorted; empties the list.
    fn take(&mut self) -> Vec<(u32, u32)> {
        self.settle();
        for &(_, loser) in &self.pairs {
            self.latest[loser as usize] = NONE;
        }
        self.distinct = 0;
        self.added = 0;
        std::mem::take(&mut self.pairs)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Prefer;
    use super::*;

    /// Squares of two triangles each, given by left, top, right and bottom.
    fn squares(squares: &[[f32; 4]]) -> Mesh {
        let mut uv = Vec::new();
        let mut faces = Vec::new();
        for (square, &[left, top, right, bottom]) in (0..).zip(squares) {
            uv.extend([[left, top], [right, top], [right, bottom], [left, bottom]]);
            faces.extend([[0, 1, 2], [0, 2, 3]].map(|face| face.map(|k: u32| k + square * 4)));
        }
        let positions = vec![[0.0; 3]; uv.len()];
        Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
    }

    fn coverage(mesh: &Mesh, size: Size) -> Coverage {
        Coverage::new(&LayoutTriangles::new(mesh, size), &Precedence::new(mesh, Prefer::First))
    }

    #[test]
    fn the_island_with_the_lowest_face_owns_an_overlap() {
        let mesh = squares(&[[0.5, 0.0, 1.0, 1.0], [0.0, 0.0, 0.75, 0.5]]);
        let coverage = coverage(&mesh, Size::square(40));
        let texels: usize =
            coverage.rows.items().map(|span| (span.end - span.start) as usize).sum();
        assert_eq!(texels, 20 * 40 + 20 * 20);
        assert_eq!(coverage.overlapping, 10 * 20);
        for row in 0..40 {
            let owned: u32 = coverage
                .row(row)
                .iter()
                .filter(|span| span.face < 2)
                .map(|span| span.end - span.start)
                .sum();
            assert_eq!(owned, 20, "row {row}");
        }
    }

    /// Each island of a staircase owns a column, and loses all columns to its right to others.
    #[test]
    fn of_islands_all_over_each_other_a_part_of_the_pairs_is_looked_at() {
        const STEPS: usize = 700;
        let step = |k: usize| [1.0 - (k + 1) as f32 / STEPS as f32, 0.0, 1.0, 1.0];
        let mesh = squares(&std::array::from_fn::<_, STEPS, _>(step));
        let layout = LayoutTriangles::new(&mesh, Size::new(STEPS as u32, 32));
        let precedence = Precedence::new(&mesh, Prefer::First);
        let mut sweep = Sweep::new(STEPS as u32);
        sweep.cover_all(&layout, &precedence, 0);
        // One by one, each of 16 rows has about 490,000.
        let added = sweep.clashes.added;
        assert!(added < (1 << 18) + 16 * 2 * STEPS, "{added}");
        // Their texels have one owner each all the same, and all are covered.
        assert_eq!(sweep.spans.row(3).len(), STEPS);
        assert!((0..16).all(|row| bits::gaps(sweep.covered(row), STEPS as u32).next().is_none()));
        let clashes = sweep.take_clashes();
        assert!(clashes.len() > STEPS && clashes.len() <= STEPS * STEPS / 2);
        assert!(clashes.iter().all(|&(owner, loser)| owner < loser));
    }

    #[test]
    fn spans_are_disjoint_and_sorted_whatever_the_block() {
        let mut rng = fastrand::Rng::with_seed(2);
        let mesh = squares(&std::array::from_fn::<_, 40, _>(|_| {
            let [x, y] = [rng.f32(), rng.f32()];
            [x, y, x + 0.2 * rng.f32() + 0.01, y + 0.2 * rng.f32() + 0.01]
        }));
        let coverage = coverage(&mesh, Size::new(130, 97));
        for row in 0..97 {
            let spans = coverage.row(row);
            assert!(spans.iter().all(|span| span.start < span.end && span.end <= 130));
            assert!(spans.windows(2).all(|pair| pair[0].end <= pair[1].start));
        }
    }
}
