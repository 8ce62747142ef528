//! Skin weights of a base's texels, from a mask that may be coarser than the base.

use crate::color::Encoding;
use crate::filter::Filter;
use crate::formats::Averaging;
use crate::texture::{Channels, Depth, Size, Texels, Texture, TextureError};

use super::stretch::STRETCH;

/// A skin mask that is sampled bilinearly at the texels of a larger texture: resizing the mask
/// first would cost more than everything that is done with it.
#[derive(Debug, Clone)]
pub(crate) struct SkinMask {
    /// The mask with its edge texels repeated on all sides, so that every position lies between two
    /// texels.
    levels: Vec<u8>,
    stride: usize,
    /// Positions of the texture's columns and rows between those of the mask.
    positions: [Vec<Position>; 2],
}

/// A position between two columns or rows of a mask.
#[derive(Debug, Clone, Copy)]
struct Position {
    /// The column or row before it.
    first: u32,
    /// Fraction of the way from the first to the next, 0 to 1.
    share: f32,
}

impl SkinMask {
    /// Prepares a mask for textures of size `of`. A mask with more texels is averaged down.
    ///
    /// # Errors
    /// [`TextureError`] if there is not enough memory.
    pub fn new(mask: &Texture, of: Size) -> Result<Self, TextureError> {
        let mask = mask.clone().with_encoding(Encoding::Data);
        let Size { width, height } = mask.size();
        let size = Size { width: width.min(of.width), height: height.min(of.height) };
        let mask = if size == mask.size() {
            mask
        } else {
            mask.resized(size, Filter::Bilinear, Averaging::Encoded)?
        };
        let levels = match mask.converted(Channels::Grey, Depth::U8).into_texels() {
            Texels::U8(levels) => levels,
            Texels::U16(_) | Texels::F32(_) => unreachable!("it was converted to 8 bits"),
        };
        let levels = padded(&levels, size);
        let positions = [positions(size.width, of.width), positions(size.height, of.height)];
        Ok(Self { levels, stride: size.width as usize + 2, positions })
    }

    /// Whether the mask is black at all texels of a run.
    pub fn is_black(&self, [x, y]: [u32; 2], len: u32) -> bool {
        let row = self.positions[1][y as usize];
        let columns = [x, x + len - 1].map(|x| self.positions[0][x as usize].first as usize);
        [row.first, row.first + 1].into_iter().all(|row| {
            let levels = &self.levels[row as usize * self.stride..];
            levels[columns[0]..columns[1] + 2].iter().all(|&level| level == 0)
        })
    }

    /// The skin weights of consecutive texels in a row, 0 to 1.
    ///
    /// [`bilinear`](crate::sampler::bilinear) for whole rows: a mask is read for every texel of a transfer.
    ///
    /// - `[x, y]`: column and row of the first.
    /// - `weights`: output for at most [`STRETCH`] texels.
    #[inline(always)]
    pub fn weights(&self, [x, y]: [u32; 2], weights: &mut [f32]) {
        let row = self.positions[1][y as usize];
        let columns = &self.positions[0][x as usize..][..weights.len()];
        let [Some(first), Some(last)] = [columns.first(), columns.last()] else { return };
        let first = first.first as usize;
        // The mask has no more columns than the texture.
        let mut between = [0.0_f32; STRETCH + 2];
        let count = last.first as usize + 2 - first;
        let [above, below] = [0, 1].map(|next| {
            let row = (row.first + next) as usize * self.stride;
            &self.levels[row + first..][..count]
        });
        for ((between, &above), &below) in between.iter_mut().zip(above).zip(below) {
            let [above, below] = [above, below].map(|level| f32::from(level) * (1.0 / 255.0));
            *between = above + (below - above) * row.share;
        }
        for (weight, column) in weights.iter_mut().zip(columns) {
            let at = column.first as usize - first;
            // Never exceeded; stated so that indexing needs no bounds check.
            let at = at.min(STRETCH);
            *weight = between[at] + (between[at + 1] - between[at]) * column.share;
        }
    }
}

/// A mask with its edge texels repeated on all sides.
fn padded(levels: &[u8], size: Size) -> Vec<u8> {
    let [width, height] = [size.width, size.height].map(|side| side as usize);
    let mut padded = Vec::with_capacity((width + 2) * (height + 2));
    for y in 0..height + 2 {
        let row = &levels[y.saturating_sub(1).min(height - 1) * width..][..width];
        padded.push(row[0]);
        padded.extend_from_slice(row);
        padded.push(row[width - 1]);
    }
    padded
}

/// Positions of a texture's columns or rows between those of a mask.
fn positions(of_mask: u32, of_texture: u32) -> Vec<Position> {
    let scale = f64::from(of_mask) / f64::from(of_texture);
    let position = |at: u32| {
        let at = (f64::from(at) + 0.5).mul_add(scale, 0.5);
        Position { first: at as u32, share: at.fract() as f32 }
    };
    (0..of_texture).map(position).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(size: Size, level: impl Fn(u32, u32) -> u8) -> Texture {
        let texels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
        let levels = texels.map(|(x, y)| level(x, y)).collect();
        Texture::new(size, Channels::Grey, Encoding::Data, Texels::U8(levels)).unwrap()
    }

    /// Matches a mask that was resized, wherever a stretch begins.
    #[test]
    fn matches_a_resized_mask() {
        let mut rng = fastrand::Rng::with_seed(4);
        let noise: Vec<u8> = (0..13 * 9).map(|_| rng.u8(..)).collect();
        for (of, from) in [
            (Size::square(64), Size { width: 13, height: 9 }),
            (Size { width: 13, height: 40 }, Size { width: 13, height: 9 }),
            (Size { width: 30, height: 5 }, Size { width: 13, height: 9 }),
            (Size::square(3), Size { width: 1, height: 1 }),
        ] {
            let texture = mask(from, |x, y| noise[(y * from.width + x) as usize]);
            let wanted = texture.clone().resized(of, Filter::Bilinear, Averaging::Encoded).unwrap();
            let mask = SkinMask::new(&texture, of).unwrap();
            for y in 0..of.height {
                for first in 0..of.width {
                    let mut weights = [f32::NAN; STRETCH];
                    let count = (of.width - first).min(STRETCH as u32) as usize;
                    mask.weights([first, y], &mut weights[..count]);
                    for (x, weight) in (first..).zip(&weights[..count]) {
                        let wanted = wanted.get(x, y, 0);
                        assert!((weight - wanted).abs() < 0.006, "{x}, {y}: {weight}, {wanted}");
                    }
                }
            }
        }
    }
}
