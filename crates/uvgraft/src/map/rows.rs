//! Per-row lists for a texture, in blocks of rows that are built and stored independently.

use std::ops::Range;

/// Rows per block: enough to amortise the work that several rows share, few enough to distribute
/// blocks among threads.
pub(crate) const BLOCK_ROWS: u32 = 16;

/// The items of each row. They are not in one list, which would mean copying megabytes.
#[derive(Debug, Clone)]
pub(crate) struct RowLists<T> {
    blocks: Vec<Block<T>>,
}

/// The items of the rows of a block.
#[derive(Debug, Clone)]
pub(crate) struct Block<T> {
    /// End of each row's items.
    ends: [u32; BLOCK_ROWS as usize],
    items: Box<[T]>,
}

impl<T> RowLists<T> {
    /// Assembles the blocks of a texture, from top to bottom.
    pub fn new(blocks: Vec<Block<T>>) -> Self {
        Self { blocks }
    }

    /// The items of a row.
    pub fn row(&self, row: u32) -> &[T] {
        let block = &self.blocks[(row / BLOCK_ROWS) as usize];
        let row = (row % BLOCK_ROWS) as usize;
        let start = if row == 0 { 0 } else { block.ends[row - 1] };
        &block.items[start as usize..block.ends[row] as usize]
    }

    /// All items.
    pub fn items(&self) -> impl Iterator<Item = &T> {
        self.blocks.iter().flat_map(Block::items)
    }
}

impl<T> Block<T> {
    /// All items.
    pub fn items(&self) -> &[T] {
        &self.items
    }
}

/// A block under construction; reused from block to block.
pub(crate) struct Draft<T> {
    ends: [u32; BLOCK_ROWS as usize],
    rows: usize,
    /// The items of the current row come last.
    pub items: Vec<T>,
}

impl<T: Clone> Draft<T> {
    pub fn new() -> Self {
        Self { ends: [0; BLOCK_ROWS as usize], rows: 0, items: Vec::new() }
    }

    /// Empties the draft.
    pub fn clear(&mut self) {
        self.rows = 0;
        self.items.clear();
    }

    /// Ends the current row.
    pub fn end_row(&mut self) {
        self.ends[self.rows] = self.items.len() as u32;
        self.rows += 1;
    }

    /// The items of a finished row; `row` counts from the first row of the block.
    pub fn row(&self, row: usize) -> &[T] {
        let start = if row == 0 { 0 } else { self.ends[row - 1] };
        &self.items[start as usize..self.ends[row] as usize]
    }

    /// Copies the draft into a block.
    pub fn block(&self) -> Block<T> {
        Block { ends: self.ends, items: self.items.as_slice().into() }
    }
}

/// Items bucketed by the blocks of rows that they touch, with a counting sort.
pub(crate) struct RowBlocks<T> {
    starts: Vec<u32>,
    items: Vec<T>,
    height: u32,
}

impl<T: Copy + Default> RowBlocks<T> {
    /// Buckets items by the rows that each touches.
    ///
    /// - `item`: the item with an index of `rows`.
    pub fn new(height: u32, rows: &[Range<u32>], item: impl Fn(u32) -> T) -> Self {
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
        let mut items = vec![T::default(); starts.last().copied().unwrap_or(0) as usize];
        for (index, rows) in (0..).zip(rows) {
            for block in blocks(rows) {
                items[next[block as usize] as usize] = item(index);
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
    pub fn items(&self, block: usize) -> &[T] {
        &self.items[self.starts[block] as usize..self.starts[block + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_from_their_blocks() {
        let mut draft = Draft::new();
        let blocks: Vec<Block<u32>> = [0..BLOCK_ROWS, BLOCK_ROWS..BLOCK_ROWS + 3]
            .into_iter()
            .map(|rows| {
                draft.clear();
                for row in rows {
                    draft.items.extend(0..row % 4);
                    draft.end_row();
                }
                assert_eq!(draft.row(2).len(), 2);
                draft.block()
            })
            .collect();
        let rows = RowLists::new(blocks);
        for row in 0..BLOCK_ROWS + 3 {
            assert_eq!(rows.row(row), (0..row % 4).collect::<Vec<_>>());
        }
        assert_eq!(rows.items().count() as u32, BLOCK_ROWS / 4 * 6 + 3);
    }

    #[test]
    fn items_are_in_each_block_that_they_touch() {
        let rows = [0..1, 15..17, 5..5, 20..99, 16..32, 33..40];
        let blocks = RowBlocks::new(40, &rows, |index| index);
        assert_eq!(blocks.count(), 3);
        assert_eq!(blocks.items(0), [0, 1]);
        assert_eq!(blocks.items(1), [1, 3, 4]);
        assert_eq!(blocks.items(2), [3, 5]);
        assert_eq!(blocks.rows(2), 32..40);
    }
}
