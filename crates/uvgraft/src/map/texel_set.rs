//! Sets of texels of a texture, such as those that a layout covers.

use std::ops::Range;

use uvgraft_surface::bits;
use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::threads::map_indices_with;

use super::FAR_PX;
use super::coverage::LayoutTriangles;
use super::rows::{BLOCK_ROWS, Draft, RowLists};
use super::tiles::{TILE, Tiles};
use super::{Patch, SamplingMap};
use crate::texture::Size;

/// A set of texels of a texture of one size, whereas a [`Selection`](crate::blend::Selection) is a part
/// of a surface: for each row sorted ranges of columns that do not touch.
#[derive(Debug, Clone)]
pub(crate) struct TexelSet {
    size: Size,
    rows: RowLists<Range<u32>>,
}

impl TexelSet {
    /// The texels that a layout covers. Outside the `needed` tiles some may be missing.
    pub fn covered(mesh: &Mesh, size: Size, needed: &Tiles) -> Self {
        let layout = LayoutTriangles::new(mesh, size);
        let words = bits::words(size.width);
        let buffers = || (vec![0; words * BLOCK_ROWS as usize], Draft::new());
        let blocks = map_indices_with(layout.blocks.count(), buffers, |(covered, draft), block| {
            draft.clear();
            let (rows, needed) = (layout.blocks.rows(block), needed.row(block));
            // One more tile on each side for rounding. Where that may not suffice, the
            // triangle is included.
            let near = |columns: Range<f64>| {
                if columns.end - columns.start > FAR_PX {
                    return true;
                }
                let last = size.width.div_ceil(TILE);
                let [first, end] = [columns.start, columns.end].map(|x| x as u32 / TILE);
                bits::meets(needed, &(first.saturating_sub(1)..end.saturating_add(2).min(last)))
            };
            if needed.iter().any(|&word| word != 0) {
                for (_, triangle) in layout.triangles(block, near) {
                    for (row, span) in triangle.spans(&rows) {
                        let row = (row - rows.start) as usize;
                        bits::insert_range(&mut covered[row * words..][..words], &span);
                    }
                }
            }
            for row in covered.chunks_exact_mut(words).take(rows.len()) {
                draft.items.extend(bits::ranges(row));
                row.fill(0);
                draft.end_row();
            }
            draft.block()
        });
        Self { size, rows: RowLists::new(blocks) }
    }

    /// The texels owned by pieces whose patches are `needed`.
    pub fn linked(map: &SamplingMap, needed: impl Fn(&Patch) -> bool + Send + Sync) -> Self {
        let size = map.size();
        let count = size.height.div_ceil(BLOCK_ROWS) as usize;
        let blocks = map_indices_with(count, Draft::<Range<u32>>::new, |draft, block| {
            draft.clear();
            let first = block as u32 * BLOCK_ROWS;
            for row in first..(first + BLOCK_ROWS).min(size.height) {
                let runs = map.row(row).iter().filter(|run| !map.is_gutter(**run));
                let runs = runs.filter(|run| needed(&map.patches()[run.patch as usize]));
                let row_start = draft.items.len();
                for run in runs {
                    let range = run.x..run.x + run.len;
                    match draft.items[row_start..].last_mut() {
                        Some(last) if last.end == range.start => last.end = range.end,
                        _ => draft.items.push(range),
                    }
                }
                draft.end_row();
            }
            draft.block()
        });
        Self { size, rows: RowLists::new(blocks) }
    }

    pub fn size(&self) -> Size {
        self.size
    }

    /// The ranges of a row, from left to right.
    pub fn row(&self, row: usize) -> &[Range<u32>] {
        self.rows.row(row as u32)
    }

    /// Number of texels.
    pub fn texels(&self) -> usize {
        self.rows.items().map(ExactSizeIterator::len).sum()
    }

    /// Appends the ranges of columns of a row that are not in the region.
    pub fn gaps(&self, row: usize, gaps: &mut Vec<Range<u32>>) {
        push_gaps(self.row(row).iter().cloned(), self.size.width, gaps);
    }
}

/// Appends the gaps that sorted ranges leave in `0..width`.
pub(super) fn push_gaps(
    ranges: impl Iterator<Item = Range<u32>>,
    width: u32,
    gaps: &mut Vec<Range<u32>>,
) {
    let mut end = 0;
    for range in ranges {
        if end < range.start {
            gaps.push(end..range.start);
        }
        end = range.end;
    }
    if end < width {
        gaps.push(end..width);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_what_ranges_leave() {
        let gaps = |ranges: &[(u32, u32)]| -> Vec<(u32, u32)> {
            let mut gaps = Vec::new();
            push_gaps(ranges.iter().map(|&(start, end)| start..end), 9, &mut gaps);
            gaps.into_iter().map(|gap| (gap.start, gap.end)).collect()
        };
        assert_eq!(gaps(&[]), [(0, 9)]);
        assert_eq!(gaps(&[(0, 2), (2, 4), (6, 9)]), [(4, 6)]);
        assert_eq!(gaps(&[(1, 9)]), [(0, 1)]);
        assert_eq!(gaps(&[(0, 8)]), [(8, 9)]);
        assert_eq!(gaps(&[(0, 9)]), []);
    }
}
