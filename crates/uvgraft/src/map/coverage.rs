//! Which triangle of a layout owns which texel.

use std::ops::Range;

use super::region::push_gaps;
use crate::islands::Islands;
use crate::mesh::Mesh;
use crate::raster::ScanTriangle;
use crate::texture::{Size, Texture};
use crate::threads::map_indices;

/// Rows that are worked on together: enough to share the bucketing of triangles, few enough to
/// share the work among threads.
const BLOCK_ROWS: u32 = 32;

/// The owner of every texel that a layout covers, as spans.
///
/// Where triangles overlap, the island with the lowest face owns the texel, and within an island
/// the lowest face.
pub(crate) struct Coverage {
    size: Size,
    row_starts: Vec<u32>,
    spans: Vec<Span>,
    /// Texels that more than one triangle covers.
    pub overlapping: usize,
    /// Pairs of islands that share texels, sorted: the one that owns them, the one that lost them.
    pub clashes: Vec<(u32, u32)>,
}

/// Consecutive texels of a row with one owner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Span {
    pub start: u32,
    pub end: u32,
    pub face: u32,
}

impl Span {
    pub fn texels(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// Things that concern each block of [`BLOCK_ROWS`] rows, bucketed by counting.
pub(crate) struct RowBlocks {
    starts: Vec<u32>,
    items: Vec<u32>,
    height: u32,
}

impl RowBlocks {
    /// Buckets the items `0..rows.len()` by the rows that each touches.
    pub fn new(height: u32, rows: &[Range<u32>]) -> Self {
        let blocks = |rows: &Range<u32>| {
            let last = rows.end.min(height).saturating_sub(1) / BLOCK_ROWS;
            if rows.start < rows.end.min(height) { rows.start / BLOCK_ROWS..last + 1 } else { 0..0 }
        };
        let mut starts = vec![0; height.div_ceil(BLOCK_ROWS) as usize + 1];
        for block in rows.iter().flat_map(blocks) {
            starts[block as usize + 1] += 1;
        }
        for block in 1..starts.len() {
            starts[block] += starts[block - 1];
        }
        let mut next = starts.clone();
        let mut items = vec![0; starts.last().copied().unwrap_or(0) as usize];
        for (item, rows) in rows.iter().enumerate() {
            for block in blocks(rows) {
                items[next[block as usize] as usize] = item as u32;
                next[block as usize] += 1;
            }
        }
        Self { starts, items, height }
    }

    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// The rows of a block.
    pub fn rows(&self, block: usize) -> Range<u32> {
        let first = block as u32 * BLOCK_ROWS;
        first..(first + BLOCK_ROWS).min(self.height)
    }

    /// The items of a block, in their order.
    pub fn items(&self, block: usize) -> &[u32] {
        &self.items[self.starts[block] as usize..self.starts[block + 1] as usize]
    }
}

/// Where the corners of a face lie in a texture of `size`, in texels.
pub(crate) fn corners_px(mesh: &Mesh, face: usize, size: Size) -> [[f64; 2]; 3] {
    let scale = [f64::from(size.width), f64::from(size.height)];
    mesh.uv_triangle(face).map(|[u, v]| [f64::from(u) * scale[0], f64::from(v) * scale[1]])
}

impl Coverage {
    pub fn new(mesh: &Mesh, islands: &Islands, size: Size) -> Self {
        let sides = 1..=Texture::MAX_SIDE;
        assert!(
            sides.contains(&size.width) && sides.contains(&size.height),
            "no texture of {size}"
        );
        let triangles: Vec<Option<ScanTriangle>> = (0..mesh.faces().len())
            .map(|face| ScanTriangle::new(corners_px(mesh, face, size), size))
            .collect();
        let rows: Vec<Range<u32>> = triangles
            .iter()
            .map(|triangle| triangle.as_ref().map_or(0..0, ScanTriangle::rows))
            .collect();
        let blocks = RowBlocks::new(size.height, &rows);
        let parts = map_indices(blocks.count(), |block| {
            cover_block(&triangles, blocks.items(block), blocks.rows(block), islands, size.width)
        });

        let mut coverage = Self {
            size,
            row_starts: Vec::with_capacity(size.height as usize + 1),
            spans: Vec::with_capacity(parts.iter().map(|part| part.spans.len()).sum()),
            overlapping: 0,
            clashes: Vec::new(),
        };
        for part in parts {
            let base = coverage.spans.len() as u32;
            coverage.row_starts.extend(part.row_starts.iter().map(|start| base + start));
            coverage.spans.extend(part.spans);
            coverage.overlapping += part.overlapping;
            coverage.clashes.extend(part.clashes);
        }
        coverage.row_starts.push(coverage.spans.len() as u32);
        coverage.clashes.sort_unstable();
        coverage.clashes.dedup();
        coverage
    }

    pub fn size(&self) -> Size {
        self.size
    }

    /// The spans of a row, from left to right.
    pub fn row(&self, row: u32) -> &[Span] {
        let row = row as usize;
        &self.spans[self.row_starts[row] as usize..self.row_starts[row + 1] as usize]
    }

    /// The texels of a row that nothing covers, from left to right, added to `gaps`.
    pub fn gaps(&self, row: u32, gaps: &mut Vec<Range<u32>>) {
        let spans = self.row(row).iter().map(|span| span.start..span.end);
        push_gaps(spans, self.size.width, gaps);
    }

    /// How many texels are covered.
    pub fn texels(&self) -> usize {
        self.spans.iter().map(|span| span.texels().len()).sum()
    }
}

struct BlockCoverage {
    /// One start for each row of the block, counted from the block's first span.
    row_starts: Vec<u32>,
    spans: Vec<Span>,
    overlapping: usize,
    clashes: Vec<(u32, u32)>,
}

fn cover_block(
    triangles: &[Option<ScanTriangle>],
    faces: &[u32],
    rows: Range<u32>,
    islands: &Islands,
    width: u32,
) -> BlockCoverage {
    // Spans come triangle by triangle and are bucketed by row, by counting.
    let mut found = Vec::with_capacity(faces.len() * 16);
    let mut starts = vec![0; rows.len() + 1];
    for &face in faces {
        let Some(triangle) = &triangles[face as usize] else { continue };
        let touched = triangle.rows();
        for row in touched.start.max(rows.start)..touched.end.min(rows.end) {
            let Range { start, end } = triangle.span(row);
            if start < end {
                starts[(row - rows.start) as usize + 1] += 1;
                found.push((row - rows.start, Span { start, end, face }));
            }
        }
    }
    for row in 0..rows.len() {
        starts[row + 1] += starts[row];
    }
    let mut next = starts.clone();
    let mut by_row = vec![Span { start: 0, end: 0, face: 0 }; found.len()];
    for (row, span) in found {
        by_row[next[row as usize]] = span;
        next[row as usize] += 1;
    }
    let mut part = BlockCoverage {
        row_starts: Vec::with_capacity(rows.len()),
        spans: Vec::with_capacity(by_row.len()),
        overlapping: 0,
        clashes: Vec::new(),
    };
    for bounds in starts.windows(2) {
        part.row_starts.push(part.spans.len() as u32);
        let spans = &mut by_row[bounds[0]..bounds[1]];
        spans.sort_unstable_by_key(|span| span.start);
        if spans.windows(2).any(|pair| pair[0].end > pair[1].start) {
            resolve_overlaps(spans, islands, width, &mut part);
        } else {
            part.spans.extend_from_slice(spans);
        }
    }
    part
}

/// Gives every texel of a row to its first claimant in the order of islands, then faces.
fn resolve_overlaps(spans: &mut [Span], islands: &Islands, width: u32, part: &mut BlockCoverage) {
    const NOBODY: u32 = u32::MAX;
    let island = |face: u32| islands.of_faces()[face as usize];
    spans.sort_unstable_by_key(|span| (island(span.face), span.face, span.start));
    let mut owners = vec![NOBODY; width as usize];
    let mut shared = vec![false; width as usize];
    for &span in spans.iter() {
        for x in span.texels() {
            if owners[x] == NOBODY {
                owners[x] = span.face;
                continue;
            }
            part.overlapping += usize::from(!shared[x]);
            shared[x] = true;
            let clash = (island(owners[x]), island(span.face));
            if clash.0 != clash.1 && part.clashes.last() != Some(&clash) {
                part.clashes.push(clash);
            }
        }
    }
    let mut start = 0;
    for owned in owners.chunk_by(|a, b| a == b) {
        let end = start + owned.len() as u32;
        if owned[0] != NOBODY {
            part.spans.push(Span { start, end, face: owned[0] });
        }
        start = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares of two triangles each, given by their left, top, right and bottom.
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

    #[test]
    fn the_island_with_the_lowest_face_owns_an_overlap() {
        let mesh = squares(&[[0.5, 0.0, 1.0, 1.0], [0.0, 0.0, 0.75, 0.5]]);
        let coverage = Coverage::new(&mesh, &Islands::new(&mesh), Size::square(40));
        assert_eq!(coverage.texels(), 20 * 40 + 20 * 20);
        assert_eq!(coverage.overlapping, 10 * 20);
        assert_eq!(coverage.clashes, [(0, 1)]);
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

    #[test]
    fn spans_are_disjoint_and_sorted_whatever_the_block() {
        let mut rng = fastrand::Rng::with_seed(2);
        let mesh = squares(&std::array::from_fn::<_, 40, _>(|_| {
            let [x, y] = [rng.f32(), rng.f32()];
            [x, y, x + 0.2 * rng.f32() + 0.01, y + 0.2 * rng.f32() + 0.01]
        }));
        let coverage = Coverage::new(&mesh, &Islands::new(&mesh), Size::new(130, 97));
        for row in 0..97 {
            let spans = coverage.row(row);
            assert!(spans.iter().all(|span| span.start < span.end && span.end <= 130));
            assert!(spans.windows(2).all(|pair| pair[0].end <= pair[1].start));
        }
    }
}
