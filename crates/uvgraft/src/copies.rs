//! Copies of textures on all threads: page faults of a large copy take as long as resampling it.

use std::borrow::Cow;

use uvgraft_surface::bits;
use uvgraft_surface::threads::for_each_chunk;

use crate::map::{TILE, Tiles};
use crate::texture::{Texels, Texture, Value};

/// Values copied per work item.
const CHUNK: usize = 1 << 20;

/// The texture itself if it is owned, or else a copy.
pub(crate) fn owned(texture: Cow<'_, Texture>) -> Texture {
    match texture {
        Cow::Owned(texture) => texture,
        Cow::Borrowed(texture) => with_texels(texture, &Copy::Whole),
    }
}

/// As [`owned`], but copies some tiles only: the other texels of a copy are 0.
pub(crate) fn owned_in(texture: Cow<'_, Texture>, tiles: &Tiles) -> Texture {
    match texture {
        Cow::Owned(texture) => texture,
        Cow::Borrowed(texture) => with_texels(texture, &Copy::Tiles(tiles)),
    }
}

/// What is copied.
enum Copy<'t> {
    Whole,
    Tiles(&'t Tiles),
}

fn with_texels(texture: &Texture, copy: &Copy<'_>) -> Texture {
    let texels = match texture.texels() {
        Texels::U8(values) => Texels::U8(copied(texture, values, copy)),
        Texels::U16(values) => Texels::U16(copied(texture, values, copy)),
        Texels::F32(values) => Texels::F32(copied(texture, values, copy)),
    };
    Texture::new(texture.size(), texture.channels(), texture.encoding(), texels)
        .expect("as many values as before")
}

fn copied<T: Value>(texture: &Texture, values: &[T], copy: &Copy<'_>) -> Vec<T> {
    // The system hands out zeros without touching them, page by page when they are written to.
    let mut copied = vec![T::default(); values.len()];
    match copy {
        Copy::Whole => for_each_chunk(&mut copied, CHUNK, |index, copied| {
            copied.copy_from_slice(&values[index * CHUNK..][..copied.len()]);
        }),
        Copy::Tiles(tiles) => {
            let (width, channels) = (texture.size().width, texture.channels().count());
            let row = width as usize * channels;
            let block = row * TILE as usize;
            for_each_chunk(&mut copied, block, |index, copied| {
                let values = &values[index * block..];
                for columns in bits::ranges(tiles.row(index)) {
                    let part = (columns.start * TILE) as usize * channels
                        ..(columns.end * TILE).min(width) as usize * channels;
                    for (copied, values) in copied.chunks_mut(row).zip(values.chunks(row)) {
                        copied[part.clone()].copy_from_slice(&values[part.clone()]);
                    }
                }
            });
        }
    }
    copied
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Encoding;
    use crate::texture::{Channels, Size};

    #[test]
    fn tiles_are_copied_and_nothing_else() {
        let size = Size::new(53, 37);
        let values: Vec<u16> = (0..53 * 37 * 3).map(|value| value + 1).collect();
        let texture =
            Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U16(values.clone())).unwrap();
        assert_eq!(owned(Cow::Borrowed(&texture)), texture);
        let mut tiles = Tiles::none(size);
        tiles.insert(&(20..21), &(0..1));
        tiles.insert(&(40..53), &(36..37));
        let copy = owned_in(Cow::Borrowed(&texture), &tiles);
        let Texels::U16(copied) = copy.texels() else { panic!("another depth") };
        for (index, (&copied, value)) in copied.iter().zip(values).enumerate() {
            let (x, y) = (index / 3 % 53, index / 3 / 53);
            let is_in = (y < 16 && (16..32).contains(&x)) || (y >= 32 && x >= 32);
            assert_eq!(copied, if is_in { value } else { 0 }, "{x}, {y}");
        }
        assert_eq!(owned_in(Cow::Owned(texture.clone()), &tiles), texture);
    }
}
