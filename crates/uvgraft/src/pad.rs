//! Padding of a source texture: the texels around its islands that filters read.
//!
//! A filter near an island's edge reads texels outside the island, where a texture may hold
//! anything. Before resampling they are given the value of the nearest texel inside, as far
//! out as they are read.

use std::ops::Range;

use uvgraft_surface::bits;
use uvgraft_surface::threads::map_indices_with;

use crate::map::{BLOCK_ROWS, TILE, TexelSet, Tiles, tiles};
use crate::texture::{Size, TexelsMut, Texture};

/// For one layout and size: which texels outside the islands are padded, and from which texel
/// inside.
#[derive(Debug, Clone)]
pub struct Padding {
    size: Size,
    /// Blocks of rows, from top to bottom.
    blocks: Vec<Block>,
}

/// Padded texels of a block of rows.
#[derive(Debug, Clone)]
struct Block {
    stretches: Box<[Stretch]>,
    /// For each padded texel, the offset (right, down), in texels, to the texel whose value it
    /// takes.
    offsets: Box<[[i8; 2]]>,
}

/// Consecutive padded texels of a row.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    row: u32,
    x: u32,
    len: u32,
}

impl Padding {
    /// The maximum padding radius: offsets have to fit 8 bits, squared distances 16.
    const MAX_RADIUS: u32 = 96;

    /// Pads the texels in `read` that are outside the region and within `radius` of
    /// a texel inside it.
    pub(crate) fn new(region: &TexelSet, radius: u32, read: &Tiles) -> Self {
        assert!(radius <= Self::MAX_RADIUS, "padding of {radius} texels");
        let size = region.size();
        let blocks: Vec<Block> =
            map_indices_with(read.count(), Search::default, |search, block| {
                search.block(region, radius, read.row(block), block as u32)
            });
        Self { size, blocks }
    }

    /// The padding of a texture whose islands are not known: none.
    pub(crate) const fn none(size: Size) -> Self {
        Self { size, blocks: Vec::new() }
    }

    /// The texture size that the padding applies to.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Pads the texels around the islands.
    ///
    /// # Panics
    /// If the texture has another size.
    pub fn apply(&self, texture: &mut Texture) {
        assert_eq!(texture.size(), self.size, "padding is for one size");
        let channels = texture.channels().count();
        match texture.texels_mut() {
            TexelsMut::U8(values) => self.copy_channels(channels, values),
            TexelsMut::U16(values) => self.copy_channels(channels, values),
            TexelsMut::F32(values) => self.copy_channels(channels, values),
        }
    }

    /// As [`Padding::apply`], for plain values with `C` per texel.
    pub(crate) fn fill<const C: usize>(&self, values: &mut [f32]) {
        self.copy::<_, C>(values);
    }

    /// The transpose of [`Padding::fill`]: adds the values of padded texels to the texels that they
    /// take their value from, and sets the padded texels to 0.
    pub(crate) fn fill_transposed<const C: usize>(&self, values: &mut [f32]) {
        let (texels, _) = values.as_chunks_mut::<C>();
        self.for_each_copy(|outside, inside| {
            let given = std::mem::replace(&mut texels[outside], [0.0; C]);
            for (value, given) in texels[inside].iter_mut().zip(given) {
                *value += given;
            }
        });
    }

    fn copy_channels<T: Copy>(&self, channels: usize, values: &mut [T]) {
        match channels {
            1 => self.copy::<T, 1>(values),
            2 => self.copy::<T, 2>(values),
            3 => self.copy::<T, 3>(values),
            _ => self.copy::<T, 4>(values),
        }
    }

    fn copy<T: Copy, const C: usize>(&self, values: &mut [T]) {
        let (texels, _) = values.as_chunks_mut::<C>();
        self.for_each_copy(|outside, inside| texels[outside] = texels[inside]);
    }

    /// Calls `copy` with the index of each padded texel and the index of the texel whose value it
    /// takes.
    pub(crate) fn for_each_copy(&self, mut copy: impl FnMut(usize, usize)) {
        let width = self.size.width as isize;
        for block in &self.blocks {
            let mut offsets = block.offsets.iter();
            for stretch in &block.stretches {
                let first = stretch.row as isize * width + stretch.x as isize;
                let outside = first..first + stretch.len as isize;
                for (outside, &[right, down]) in outside.zip(&mut offsets) {
                    let inside = outside + isize::from(down) * width + isize::from(right);
                    copy(outside as usize, inside as usize);
                }
            }
        }
    }
}

/// Finds the nearest covered texels for a block of rows; buffers are reused from block to block.
///
/// A separable exact Euclidean distance transform, limited to the padding radius. The first pass
/// finds the nearest covered texel within each row (dx²), the second minimises dx² + dy² over the
/// rows above and below. A full 2D search per texel would cost the square of the radius.
#[derive(Default)]
struct Search {
    /// Tiles of the block that are read and not entirely covered.
    open: Vec<u64>,
    gaps: Vec<Range<u32>>,
    /// One for each row within the radius of the block, with one entry per open tile.
    lines: Vec<Vec<TileRow>>,
    stretches: Vec<Stretch>,
    offsets: Vec<[i8; 2]>,
}

const WIDTH: usize = TILE as usize;

/// For each column of an open tile, the nearest covered texel in one row.
#[derive(Clone)]
struct TileRow {
    /// Squared distances.
    squared: [i16; WIDTH],
    /// Offset to it, in texels to the right.
    right: [i8; WIDTH],
    /// Whether any column has one.
    any: bool,
}

impl TileRow {
    const EMPTY: Self = Self { squared: [FAR; WIDTH], right: [0; WIDTH], any: false };
}

/// Larger than any squared distance, and does not overflow when one is added to it.
const FAR: i16 = 20_000;

impl Search {
    /// Pads one block of rows: finds its open tiles, runs the first pass over all rows within the
    /// radius, and the second pass over the rows of the block.
    fn block(&mut self, region: &TexelSet, radius: u32, read: &[u64], block: u32) -> Block {
        let size = region.size();
        let rows = block * BLOCK_ROWS..((block + 1) * BLOCK_ROWS).min(size.height);
        self.stretches.clear();
        self.offsets.clear();
        self.open.clear();
        self.open.resize(read.len(), 0);
        if read.iter().any(|&word| word != 0) {
            for row in rows.clone() {
                self.gaps.clear();
                region.gaps(row as usize, &mut self.gaps);
                for gap in &self.gaps {
                    bits::insert_range(&mut self.open, &tiles(gap));
                }
            }
            for (open, read) in self.open.iter_mut().zip(read) {
                *open &= read;
            }
        }
        if self.open.iter().any(|&word| word != 0) {
            let near = rows.start.saturating_sub(radius)..(rows.end + radius).min(size.height);
            self.lines.resize_with(self.lines.len().max(near.len()), Vec::new);
            for (line, row) in self.lines.iter_mut().zip(near.clone()) {
                line.clear();
                let mut ranges = region.row(row as usize);
                for tile in bits::members(&self.open) {
                    let first = ranges.partition_point(|range| range.end + radius <= tile * TILE);
                    ranges = &ranges[first..];
                    line.push(TileRow::new(ranges, tile * TILE, radius));
                }
            }
            for row in rows {
                self.row(row, &near, size.width, radius);
            }
        }
        Block {
            stretches: self.stretches.as_slice().into(),
            offsets: self.offsets.as_slice().into(),
        }
    }

    /// Pads the texels of a row in its open tiles. Ties between equally near texels go to the
    /// nearest row, then to the upper row, then to the left texel.
    fn row(&mut self, row: u32, near: &Range<u32>, width: u32, radius: u32) {
        let Self { open, lines, stretches, offsets, .. } = self;
        let own = (row - near.start) as usize;
        let above = own.min(radius as usize);
        let below = ((near.end - 1 - row) as usize).min(radius as usize);
        let limit = (radius * radius) as i16;
        for (tile, index) in bits::members(open).zip(0..) {
            // A covered texel is its own nearest texel.
            let piece = &lines[own][index];
            let mut best = piece.squared.map(|squared| squared.min(limit + 1));
            let mut downs = [0i16; WIDTH];
            for away in 1..=above.max(below) {
                let squared = (away * away) as i16;
                if best.iter().all(|&best| best <= squared) {
                    break;
                }
                if away <= above {
                    lines[own - away][index].offer(squared, -(away as i16), &mut best, &mut downs);
                }
                if away <= below {
                    lines[own + away][index].offer(squared, away as i16, &mut best, &mut downs);
                }
            }
            for (k, x) in (tile * TILE..width.min((tile + 1) * TILE)).enumerate() {
                if piece.squared[k] == 0 || best[k] > limit {
                    continue;
                }
                match stretches.last_mut() {
                    Some(last) if last.row == row && last.x + last.len == x => last.len += 1,
                    _ => stretches.push(Stretch { row, x, len: 1 }),
                }
                let line = own.wrapping_add_signed(isize::from(downs[k]));
                offsets.push([lines[line][index].right[k], downs[k] as i8]);
            }
        }
    }
}

impl TileRow {
    /// - `ranges`: the covered ranges of the row, except those more than `radius` to the left.
    /// - `start`: first column of the tile.
    fn new(ranges: &[Range<u32>], start: u32, radius: u32) -> Self {
        let mut piece = Self::EMPTY;
        let end = start + TILE;
        let place = |x: u32| (x.clamp(start, end) - start) as usize;
        for range in ranges.iter().take_while(|range| range.start < end + radius) {
            piece.any = true;
            // The texel to the left was stored first and wins ties.
            for k in place(range.start.saturating_sub(radius))..place(range.start) {
                let away = (range.start - start) as i16 - k as i16;
                if away * away < piece.squared[k] {
                    piece.squared[k] = away * away;
                    piece.right[k] = away as i8;
                }
            }
            for k in place(range.start)..place(range.end) {
                (piece.squared[k], piece.right[k]) = (0, 0);
            }
            for k in place(range.end)..place(range.end + radius) {
                let away = (start as i64 + k as i64 - i64::from(range.end) + 1) as i16;
                piece.squared[k] = away * away;
                piece.right[k] = -away as i8;
            }
        }
        piece
    }

    /// Lowers the smallest squared distances so far to those of this row's texels, and records the
    /// row.
    ///
    /// - `squared_away`: squared distance of the row.
    /// - `down`: signed offset of the row.
    fn offer(
        &self,
        squared_away: i16,
        down: i16,
        best: &mut [i16; WIDTH],
        downs: &mut [i16; WIDTH],
    ) {
        if self.any {
            for k in 0..WIDTH {
                let squared = self.squared[k] + squared_away;
                let nearer = squared < best[k];
                best[k] = if nearer { squared } else { best[k] };
                downs[k] = if nearer { down } else { downs[k] };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;

    use super::*;
    use crate::color::Encoding;
    use crate::map::{Coverage, LayoutTriangles, Precedence, Prefer};
    use crate::texture::{Channels, Texels};

    #[test]
    fn takes_the_nearest_texel_within_the_radius() {
        let uv = vec![[0.3, 0.2], [0.72, 0.33], [0.4, 0.81], [0.9, 0.9], [0.95, 0.95], [0.9, 0.98]];
        let faces = [[0, 1, 2], [3, 4, 5]];
        let mesh = Mesh::from_triangles(vec![[0.0; 3]; 6], uv, &faces, &faces).unwrap();
        let size = Size::new(40, 31);
        let coverage = Coverage::new(
            &LayoutTriangles::new(&mesh, size),
            &Precedence::new(&mesh, Prefer::First),
        );
        let radius = 4;
        let mut covered = vec![false; size.texels()];
        for row in 0..size.height {
            for span in coverage.row(row) {
                covered[row as usize * 40..][span.start as usize..span.end as usize].fill(true);
            }
        }
        // Each covered texel holds its own index, uncovered texels hold -1.
        let values: Vec<f32> = (0..size.texels())
            .map(|texel| if covered[texel] { texel as f32 } else { -1.0 })
            .collect();
        let mut texture =
            Texture::new(size, Channels::Grey, Encoding::Data, Texels::F32(values)).unwrap();
        let mut all = Tiles::none(size);
        all.insert(&(0..size.width), &(0..size.height));
        Padding::new(&TexelSet::covered(&mesh, size, &all), radius, &all).apply(&mut texture);

        let squared = |a: usize, b: usize| {
            (a % 40).abs_diff(b % 40).pow(2) + (a / 40).abs_diff(b / 40).pow(2)
        };
        for texel in 0..size.texels() {
            let found = texture.get((texel % 40) as u32, (texel / 40) as u32, 0);
            let wanted = (0..size.texels())
                .filter(|&other| covered[other])
                .map(|other| squared(texel, other))
                .min()
                .filter(|&squared| squared <= 16);
            let found = (found >= 0.0).then(|| squared(texel, found as usize));
            assert_eq!(found, wanted, "texel {texel}");
        }
    }
}
