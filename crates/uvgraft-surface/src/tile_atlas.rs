//! How one texture holds the images of several UDIM tiles.
//!
//! Each image lies in a cell with a border of its own edge texels around it, so a filter that reaches
//! beyond an image's edge reads what it would read if the image were alone, as far as the border
//! goes, and never a neighbour.

use crate::mesh::Placement;
use crate::size::Size;
use crate::tile::Tile;

/// Width of the border around each image, in texels. Samples of a target texel spread over at most 32
/// texels on each of its axes, so turned by 45 degrees they and the widest filter reach 26 beyond
/// its centre, and the centre may itself be half a target texel beyond the edge.
const BORDER_PX: u32 = 64;

/// How the images of some tiles lie in one texture. A single image is the whole texture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TileAtlas {
    tiles: Vec<Tile>,
    tile_size: Size,
    columns: u32,
    border_px: u32,
}

/// Why images do not make an atlas.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TileAtlasError {
    /// There is no tile.
    #[error("an atlas must have at least one tile")]
    Empty,
    /// A tile is given twice.
    #[error("tile {0} is given twice")]
    Repeated(Tile),
    /// The atlas would be too large, or empty.
    #[error(
        "{tiles} tiles of {tile_size} must fit into one texture with sides from 1 to {max} texels",
        max = Size::MAX_SIDE
    )]
    Size {
        /// How many tiles there are.
        tiles: usize,
        /// The size of each.
        tile_size: Size,
    },
}

impl TileAtlas {
    /// Lays out tiles of one size, in this order, row by row.
    ///
    /// - `tiles`: distinct.
    /// - `tile_size`: of each image, in texels.
    ///
    /// # Errors
    /// [`TileAtlasError`] if there is no tile, one is repeated, or the sides of the atlas would be beyond
    /// [`Size::MAX_SIDE`].
    pub fn new(tiles: Vec<Tile>, tile_size: Size) -> Result<Self, TileAtlasError> {
        if tiles.is_empty() {
            return Err(TileAtlasError::Empty);
        }
        for (index, tile) in tiles.iter().enumerate() {
            if tiles[..index].contains(tile) {
                return Err(TileAtlasError::Repeated(*tile));
            }
        }
        // Nearly square, so that as many tiles as possible fit within the longest side.
        let columns = (1..).find(|side| (side * side) as usize >= tiles.len()).unwrap_or(1);
        let border_px = if tiles.len() > 1 { BORDER_PX } else { 0 };
        let atlas = Self { tiles, tile_size, columns, border_px };
        let size = atlas.size();
        if size.texels() == 0 || size.width.max(size.height) > Size::MAX_SIDE {
            return Err(TileAtlasError::Size { tiles: atlas.tiles.len(), tile_size });
        }
        Ok(atlas)
    }

    /// The tiles, in their order.
    pub fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    /// The size of the atlas, in texels.
    pub fn size(&self) -> Size {
        let rows = (self.tiles.len() as u32).div_ceil(self.columns);
        let [width, height] = self.cell();
        Size::new(self.columns.saturating_mul(width), rows.saturating_mul(height))
    }

    /// The size of each image, in texels.
    pub const fn tile_size(&self) -> Size {
        self.tile_size
    }

    /// Width of the border around each image, in texels, where its edge texels are repeated.
    pub const fn border_px(&self) -> u32 {
        self.border_px
    }

    /// Width and height of an image with its border.
    fn cell(&self) -> [u32; 2] {
        let Size { width, height } = self.tile_size;
        [width, height].map(|side| side.saturating_add(2 * self.border_px))
    }

    /// The first texel of the image of the tile at `index`.
    pub fn origin(&self, index: usize) -> [u32; 2] {
        let index = index as u32;
        let [width, height] = self.cell();
        [index % self.columns * width, index / self.columns * height]
            .map(|start| start + self.border_px)
    }

    /// Where the UV coordinates of a tile lie in the atlas; `None` if it has no image.
    pub(crate) fn place(&self, tile: Tile) -> Option<Placement> {
        let index = self.tiles.iter().position(|found| *found == tile)?;
        let (origin, in_unit_square) = (self.origin(index), Placement::of_tile(tile));
        let whole = [self.size().width, self.size().height].map(f64::from);
        let side = [self.tile_size.width, self.tile_size.height].map(f64::from);
        let scale = [0, 1].map(|k| side[k] / whole[k]);
        let offset =
            [0, 1].map(|k| (f64::from(origin[k]) + in_unit_square.offset[k] * side[k]) / whole[k]);
        Some(Placement { scale, offset })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unfit_tiles_are_refused() {
        let size = Size::square(4);
        let tiles = ["1001", "1002"].map(|number| number.parse().unwrap());
        assert_eq!(TileAtlas::new(vec![], size), Err(TileAtlasError::Empty));
        let repeated = TileAtlas::new(vec![Tile::FIRST; 2], size);
        assert_eq!(repeated, Err(TileAtlasError::Repeated(Tile::FIRST)));
        for side in [20_000, u32::MAX] {
            let refused = TileAtlas::new(tiles.to_vec(), Size::square(side));
            assert!(matches!(refused, Err(TileAtlasError::Size { tiles: 2, .. })), "{side}");
        }
        let nothing = TileAtlas::new(vec![Tile::FIRST], Size::square(0));
        assert!(matches!(nothing, Err(TileAtlasError::Size { tiles: 1, .. })));
    }
}
