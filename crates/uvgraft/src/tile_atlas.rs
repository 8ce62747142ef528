//! One texture made of the images of several UDIM tiles.

use uvgraft_surface::tile::Tile;
use uvgraft_surface::tile_atlas::TileAtlas;

use crate::texture::{Texels, TexelsMut, Texture, TextureError, Value};

/// Why images do not fill an atlas.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StitchError {
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
    /// There is not enough memory.
    #[error(transparent)]
    Texture(#[from] TextureError),
}

/// Joins the images of the tiles.
///
/// - `images`: `[tiles]`, of the atlas's tile size, all with the same channels, depth and encoding.
///
/// # Errors
/// [`StitchError`] if there are more or fewer images than tiles, if one has another size or format, or
/// if there is not enough memory.
pub fn stitch(atlas: &TileAtlas, images: &[Texture]) -> Result<Texture, StitchError> {
    let tiles = atlas.tiles().len();
    let (Some(first), true) = (images.first(), images.len() == tiles) else {
        return Err(StitchError::Count { tiles, images: images.len() });
    };
    let format = first.format();
    for (tile, image) in atlas.tiles().iter().zip(images) {
        if image.size() != atlas.tile_size() || image.format() != format {
            return Err(StitchError::Image(*tile));
        }
    }
    let clear = vec![0.0; format.channels.count()];
    let mut stitched =
        Texture::filled(atlas.size(), format.channels, format.encoding, format.depth, &clear)?;
    for (index, image) in images.iter().enumerate() {
        match (stitched.texels_mut(), image.texels()) {
            (TexelsMut::U8(to), Texels::U8(from)) => lay(atlas, index, from, to),
            (TexelsMut::U16(to), Texels::U16(from)) => lay(atlas, index, from, to),
            (TexelsMut::F32(to), Texels::F32(from)) => lay(atlas, index, from, to),
            _ => unreachable!("all have the format of the first"),
        }
    }
    Ok(stitched)
}

/// Copies an image with its border, in which edge texels are repeated.
fn lay<T: Value>(atlas: &TileAtlas, index: usize, image: &[T], stitched: &mut [T]) {
    let size = atlas.tile_size();
    let [width, height] = [size.width, size.height].map(|side| side as usize);
    let channels = image.len() / (width * height);
    let border = atlas.border_px() as usize;
    let [left, top] = atlas.origin(index).map(|start| start as usize - border);
    let stride = atlas.size().width as usize * channels;
    for row in 0..height + 2 * border {
        let from = row.saturating_sub(border).min(height - 1) * width * channels;
        let from = &image[from..from + width * channels];
        let to = (top + row) * stride + left * channels;
        let to = &mut stitched[to..to + (width + 2 * border) * channels];
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

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;
    use uvgraft_surface::pair::{Direction, Pair};

    use super::*;
    use crate::color::Encoding;
    use crate::filter::Filter;
    use crate::graft::Graft;
    use crate::texture::{Channels, Depth, Size, Sizes};

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
            let stitched = stitch(&atlas, &images).unwrap();
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
        let stitched = stitch(&atlas, &images).unwrap();
        let pair = squares(&tiles);
        let to = Size::new(70, 35);
        let base = Texture::filled(to, Channels::Grey, Encoding::Srgb, Depth::U8, &[0.5]).unwrap();
        let transferred = |pair: Pair, texture: &Texture| {
            let sizes = Sizes { from: texture.size(), to };
            let graft = Graft::builder(pair, sizes).filter(Filter::Bilinear).build().unwrap();
            graft.apply(texture, &base).unwrap()
        };
        let together = pair.in_tiles(Direction::Forward, &atlas, Tile::FIRST).unwrap();
        let together = transferred(together, &stitched);
        for (index, image) in images.iter().enumerate() {
            let alone = TileAtlas::new(vec![tiles[index]], size).unwrap();
            assert_eq!(stitch(&alone, std::slice::from_ref(image)).unwrap(), *image);
            let pair = pair.in_tiles(Direction::Forward, &alone, Tile::FIRST).unwrap();
            let alone = transferred(pair, image);
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
        let atlas = TileAtlas::new(tiles(["1001", "1002"]), size).unwrap();
        let one = image(size, vec![0; 16]);
        let count = StitchError::Count { tiles: 2, images: 1 };
        assert_eq!(stitch(&atlas, std::slice::from_ref(&one)), Err(count));
        let other = image(Size::new(8, 2), vec![0; 16]);
        let wrong = StitchError::Image("1002".parse().unwrap());
        assert_eq!(stitch(&atlas, &[one, other]), Err(wrong));
    }
}
