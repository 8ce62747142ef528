//! One texture that holds the images of several UDIM tiles.
//!
//! Each image lies in a cell with a border of its own edge texels around it, so a filter that reaches
//! beyond an image's edge reads what it would read if the image were alone, as far as the border
//! goes, and never a neighbour.

use crate::mesh::Placement;
use crate::texture::{Size, Texels, TexelsMut, Texture, TextureError, Value};
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
    /// The atlas would be too large.
    #[error("{tiles} tiles of {tile_size} do not fit into one texture")]
    Size {
        /// How many tiles there are.
        tiles: usize,
        /// The size of each.
        tile_size: Size,
        /// Why not.
        #[source]
        reason: TextureError,
    },
    /// There are more or fewer images than tiles.
    #[error("an atlas of {tiles} tiles must have as many images, got {images}")]
    Count {
        /// How many tiles there are.
        tiles: usize,
        /// How many images.
        images: usize,
    },
    /// An image does not have the size of the atlas's tiles, or another format than the first.
    #[error("the image of tile {0} must have the size of the others and their format")]
    Image(Tile),
}

impl TileAtlas {
    /// Lays out tiles of one size, in this order, row by row.
    ///
    /// - `tiles`: distinct.
    /// - `tile_size`: of each image, in texels.
    ///
    /// # Errors
    /// [`TileAtlasError`] if there is no tile, one is repeated, or the sides of the atlas would be beyond
    /// [`Texture::MAX_SIDE`].
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
        let failure = if size.texels() == 0 {
            TextureError::Empty(size)
        } else if size.width.max(size.height) > Texture::MAX_SIDE {
            TextureError::TooLarge(size)
        } else {
            return Ok(atlas);
        };
        let tiles = atlas.tiles.len();
        Err(TileAtlasError::Size { tiles, tile_size, reason: failure })
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

    /// Width and height of an image with its border.
    fn cell(&self) -> [u32; 2] {
        let Size { width, height } = self.tile_size;
        [width, height].map(|side| side.saturating_add(2 * self.border_px))
    }

    /// The first texel of a tile's image.
    fn origin(&self, index: usize) -> [u32; 2] {
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

    /// Joins the images of the tiles.
    ///
    /// - `images`: `[tiles]`, of the atlas's tile size, all with the same channels, depth and encoding.
    ///
    /// # Errors
    /// [`TileAtlasError`] if there are more or fewer images than tiles, or if one has another size or
    /// format; [`TileAtlasError::Size`] if there is not enough memory.
    pub fn stitch(&self, images: &[Texture]) -> Result<Texture, TileAtlasError> {
        let tiles = self.tiles.len();
        let (Some(first), true) = (images.first(), images.len() == tiles) else {
            return Err(TileAtlasError::Count { tiles, images: images.len() });
        };
        let format = first.format();
        for (tile, image) in self.tiles.iter().zip(images) {
            if image.size() != self.tile_size || image.format() != format {
                return Err(TileAtlasError::Image(*tile));
            }
        }
        let clear = vec![0.0; format.channels.count()];
        let atlas =
            Texture::filled(self.size(), format.channels, format.encoding, format.depth, &clear);
        let tile_size = self.tile_size;
        let mut atlas =
            atlas.map_err(|reason| TileAtlasError::Size { tiles, tile_size, reason })?;
        for (index, image) in images.iter().enumerate() {
            match (atlas.texels_mut(), image.texels()) {
                (TexelsMut::U8(to), Texels::U8(from)) => self.lay(index, from, to),
                (TexelsMut::U16(to), Texels::U16(from)) => self.lay(index, from, to),
                (TexelsMut::F32(to), Texels::F32(from)) => self.lay(index, from, to),
                _ => unreachable!("all have the format of the first"),
            }
        }
        Ok(atlas)
    }

    /// Copies an image with its border, in which edge texels are repeated.
    fn lay<T: Value>(&self, index: usize, image: &[T], atlas: &mut [T]) {
        let [width, height] = [self.tile_size.width, self.tile_size.height].map(|k| k as usize);
        let channels = image.len() / (width * height);
        let border = self.border_px as usize;
        let [left, top] = self.origin(index).map(|start| start as usize - border);
        let stride = self.size().width as usize * channels;
        for row in 0..height + 2 * border {
            let from = row.saturating_sub(border).min(height - 1) * width * channels;
            let from = &image[from..from + width * channels];
            let to = (top + row) * stride + left * channels;
            let to = &mut atlas[to..to + (width + 2 * border) * channels];
            let (before, rest) = to.split_at_mut(border * channels);
            let (inner, after) = rest.split_at_mut(width * channels);
            inner.copy_from_slice(from);
            let repeat = |part: &mut [T], texel: &[T]| {
                part.chunks_exact_mut(channels).for_each(|to| to.copy_from_slice(texel));
            };
            repeat(before, &from[..channels]);
            repeat(after, &from[(width - 1) * channels..]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Encoding;
    use crate::filter::Filter;
    use crate::graft::Graft;
    use crate::mesh::Mesh;
    use crate::pair::{Direction, Pair};
    use crate::texture::{Channels, Depth, Sizes};

    fn tiles<const N: usize>(numbers: [&str; N]) -> Vec<Tile> {
        numbers.map(|number| number.parse().unwrap()).to_vec()
    }

    /// One square a tile, each filling its tile; in the target all lie side by side.
    fn squares(tiles: &[Tile]) -> Pair {
        let (mut from, mut to) = (Vec::new(), Vec::new());
        let count = tiles.len() as f32;
        for (index, tile) in tiles.iter().enumerate() {
            for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
                from.push([f32::from(tile.column()) + x, y - f32::from(tile.row())]);
                to.push([(index as f32 + x) / count, y]);
            }
        }
        let faces: Vec<[u32; 3]> = (0..tiles.len() as u32)
            .flat_map(|k| [[0, 1, 2], [0, 2, 3]].map(|face| face.map(|corner| corner + 4 * k)))
            .collect();
        let positions: Vec<[f32; 3]> = to.iter().map(|&[x, y]| [x, y, 0.0]).collect();
        let mesh = |uv| Mesh::from_triangles(positions.clone(), uv, &faces, &faces).unwrap();
        let ids: Vec<i64> = (0..positions.len() as i64).collect();
        Pair::by_vertex_map(mesh(from), mesh(to), &ids).unwrap()
    }

    fn image(size: Size, texels: Vec<u8>) -> Texture {
        Texture::new(size, Channels::Grey, Encoding::Srgb, Texels::U8(texels)).unwrap()
    }

    #[test]
    fn tiles_never_bleed_into_each_other() {
        let tiles = tiles(["1001", "1003", "1012", "1002", "1011"]);
        let values = [0u8, 255, 100, 30, 200];
        let pair = squares(&tiles);
        assert_eq!((pair.piece_count(), pair.pieces_in_other_tiles().len()), (2, 8));
        for (size, sides) in [(Size::new(7, 5), [29, 3, 1]), (Size::new(192, 160), [29, 6, 3])] {
            let atlas = TileAtlas::new(tiles.clone(), size).unwrap();
            let images = values.map(|value| image(size, vec![value; size.texels()]));
            let stitched = atlas.stitch(&images).unwrap();
            assert_eq!(stitched.size(), atlas.size());
            let pair = pair.in_tiles(Direction::Forward, &atlas, Tile::FIRST).unwrap();
            assert_eq!(pair.piece_count(), 10);
            // Many samples within half a texel of every edge, and shrunk ones, which reach further.
            for side in sides {
                for filter in [Filter::Bilinear, Filter::Lanczos3] {
                    let to = Size::new(side * 5, side);
                    let sizes = Sizes { from: atlas.size(), to };
                    let graft = Graft::builder(pair.clone(), sizes).filter(filter).build().unwrap();
                    let base =
                        Texture::filled(to, Channels::Grey, Encoding::Srgb, Depth::U8, &[0.5]);
                    let result = graft.apply(&stitched, base.unwrap()).unwrap();
                    let Texels::U8(found) = result.texels() else { panic!("8 bits") };
                    for (k, &value) in found.iter().enumerate() {
                        let tile = k % to.width as usize / side as usize;
                        assert_eq!(value, values[tile], "{filter:?} {side}: texel {k}");
                    }
                }
            }
        }
    }

    #[test]
    fn samples_are_those_of_the_image_alone() {
        let tiles = tiles(["1001", "1002"]);
        let size = Size::new(16, 16);
        let mut random = fastrand::Rng::with_seed(3);
        let images = [(); 2].map(|()| image(size, (0..256).map(|_| random.u8(..)).collect()));
        let atlas = TileAtlas::new(tiles.clone(), size).unwrap();
        let stitched = atlas.stitch(&images).unwrap();
        let pair = squares(&tiles);
        let to = Size::new(70, 35);
        let base = Texture::filled(to, Channels::Grey, Encoding::Srgb, Depth::U8, &[0.5]).unwrap();
        let carried = |pair: Pair, texture: &Texture| {
            let sizes = Sizes { from: texture.size(), to };
            let graft = Graft::builder(pair, sizes).filter(Filter::Bilinear).build().unwrap();
            graft.apply(texture, &base).unwrap()
        };
        let together = pair.in_tiles(Direction::Forward, &atlas, Tile::FIRST).unwrap();
        let together = carried(together, &stitched);
        for (index, image) in images.iter().enumerate() {
            let alone = TileAtlas::new(vec![tiles[index]], size).unwrap();
            assert_eq!(alone.stitch(std::slice::from_ref(image)).unwrap(), *image);
            let pair = pair.in_tiles(Direction::Forward, &alone, Tile::FIRST).unwrap();
            let alone = carried(pair, image);
            for y in 0..35 {
                for x in index as u32 * 35..(index as u32 + 1) * 35 {
                    let difference = (alone.get(x, y, 0) - together.get(x, y, 0)).abs();
                    // Coordinates are rounded to 32 bits in another place.
                    assert!(difference < 1.5 / 255.0, "{x} {y}: {difference}");
                }
            }
        }
    }

    #[test]
    fn unfit_images_are_refused() {
        let size = Size::square(4);
        let tile = Tile::FIRST;
        assert_eq!(TileAtlas::new(vec![], size), Err(TileAtlasError::Empty));
        assert_eq!(TileAtlas::new(vec![tile; 2], size), Err(TileAtlasError::Repeated(tile)));
        let huge = TileAtlas::new(tiles(["1001", "1002"]), Size::square(20_000));
        assert!(matches!(huge, Err(TileAtlasError::Size { tiles: 2, .. })));
        let endless = TileAtlas::new(tiles(["1001", "1002"]), Size::square(u32::MAX));
        assert!(matches!(endless, Err(TileAtlasError::Size { .. })));
        let atlas = TileAtlas::new(tiles(["1001", "1002"]), size).unwrap();
        let one = image(size, vec![0; 16]);
        let count = TileAtlasError::Count { tiles: 2, images: 1 };
        assert_eq!(atlas.stitch(std::slice::from_ref(&one)), Err(count));
        let other = image(Size::new(8, 2), vec![0; 16]);
        let wrong = TileAtlasError::Image("1002".parse().unwrap());
        assert_eq!(atlas.stitch(&[one, other]), Err(wrong));
    }
}
