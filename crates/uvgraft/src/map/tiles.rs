//! Sets of square tiles of a texture: blocks of its texels, unrelated to UDIM tiles.

use std::ops::Range;

use uvgraft_surface::bits;

use super::rows::BLOCK_ROWS;
use crate::texture::Size;

/// Side of a tile in texels; a row of tiles is a block of rows.
pub(crate) const TILE: u32 = BLOCK_ROWS;

/// A set of a texture's tiles.
#[derive(Debug, Clone)]
pub(crate) struct Tiles {
    columns: u32,
    /// For each row of tiles, the bit set of its columns.
    rows: Vec<u64>,
}

/// The range of tiles, on one axis, that a range of texels touches.
pub(crate) fn tiles(texels: &Range<u32>) -> Range<u32> {
    if texels.is_empty() { 0..0 } else { texels.start / TILE..(texels.end - 1) / TILE + 1 }
}

impl Tiles {
    /// The empty set for a texture of `size`.
    pub fn none(size: Size) -> Self {
        let columns = size.width.div_ceil(TILE);
        let rows = size.height.div_ceil(TILE) as usize;
        Self { columns, rows: vec![0; bits::words(columns) * rows] }
    }

    /// Number of rows of tiles.
    pub fn count(&self) -> usize {
        self.rows.len() / bits::words(self.columns)
    }

    /// The bit set of columns of a row of tiles.
    pub fn row(&self, row: usize) -> &[u64] {
        let words = bits::words(self.columns);
        &self.rows[row * words..][..words]
    }

    /// The rows of texels from the first to the last tile in the set, in a texture of `height`
    /// rows.
    pub fn rows_between(&self, height: u32) -> Range<u32> {
        let mut rows =
            (0..self.count()).filter(|&row| bits::members(self.row(row)).next().is_some());
        let Some(first) = rows.next() else { return 0..0 };
        let last = rows.next_back().unwrap_or(first);
        first as u32 * TILE..((last as u32 + 1) * TILE).min(height)
    }

    /// Adds the tiles that a rectangle of texels touches.
    pub fn insert(&mut self, columns: &Range<u32>, rows: &Range<u32>) {
        let (columns, words) = (tiles(columns), bits::words(self.columns));
        for row in tiles(rows) {
            bits::insert_range(&mut self.rows[row as usize * words..][..words], &columns);
        }
    }

    /// Adds another set of tiles of the same texture.
    pub fn unite(&mut self, other: &Self) {
        bits::unite(&mut self.rows, &other.rows);
    }

    /// Dilates the set: adds all tiles with texels within `radius` of it, and some more.
    pub fn widened(&self, radius: u32) -> Self {
        let (words, beside) = (bits::words(self.columns), radius.div_ceil(TILE));
        let mut wide = Self { columns: self.columns, rows: vec![0; self.rows.len()] };
        for row in 0..self.count() {
            let near =
                row.saturating_sub(beside as usize)..(row + beside as usize + 1).min(self.count());
            for range in bits::ranges(self.row(row)) {
                let range =
                    range.start.saturating_sub(beside)..(range.end + beside).min(self.columns);
                for row in near.clone() {
                    bits::insert_range(&mut wide.rows[row * words..][..words], &range);
                }
            }
        }
        wide
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_touch_tiles_and_widen() {
        let mut tiles = Tiles::none(Size::new(100, 40));
        assert_eq!(tiles.count(), 3);
        // More columns than a word has bits.
        assert_eq!(Tiles::none(Size::new(70 * TILE, 40)).count(), 3);
        tiles.insert(&(31..33), &(16..17));
        tiles.insert(&(90..100), &(3..3));
        let row = |tiles: &Tiles, row| bits::members(tiles.row(row)).collect::<Vec<_>>();
        assert_eq!([0, 1, 2].map(|k| row(&tiles, k)), [vec![], vec![1, 2], vec![]]);
        let wide = tiles.widened(17);
        assert_eq!([0, 1, 2].map(|k| row(&wide, k)), [(); 3].map(|()| vec![0, 1, 2, 3, 4]));
    }
}
