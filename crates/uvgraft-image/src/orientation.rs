//! The stored orientation of images, and how to undo it.

use uvgraft::texture::{Channels, Size, Texels};

use super::{exif, xmp};

/// A rotation or reflection: a transposition, followed by flips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Orientation {
    transposed: bool,
    flipped_x: bool,
    flipped_y: bool,
}

impl Orientation {
    /// The meaning of the TIFF and EXIF tag 274. Values outside `1..=8` are ignored.
    ///
    /// # Source
    /// TIFF 6.0, section 8, "Orientation".
    pub fn from_tag(value: u64) -> Self {
        let (transposed, flipped_x, flipped_y) = match value {
            2 => (false, true, false),
            3 => (false, true, true),
            4 => (false, false, true),
            5 => (true, false, false),
            6 => (true, true, false),
            7 => (true, true, true),
            8 => (true, false, true),
            _ => (false, false, false),
        };
        Self { transposed, flipped_x, flipped_y }
    }

    /// That of the first block that states one: EXIF, then XMP. Malformed blocks are ignored: the
    /// image itself may still be fine.
    ///
    /// - `exif`: with or without the prefix `Exif\0\0`.
    pub fn from_blocks(exif: &[u8], xmp: &[u8]) -> Self {
        let tag = exif::orientation(exif).or_else(|| xmp::orientation(xmp));
        Self::from_tag(tag.unwrap_or(1))
    }

    /// An EXIF block, without the prefix `Exif\0\0`, that states this and nothing else; `None` for images that are
    /// stored upright.
    pub(super) fn exif(self) -> Option<Vec<u8>> {
        let tag = (2..=8).find(|&tag| Self::from_tag(tag) == self)?;
        Some(exif::of_orientation(tag as u16))
    }

    /// Whether rows become columns.
    pub(super) const fn is_transposed(self) -> bool {
        self.transposed
    }

    /// The size of the upright image.
    pub(super) fn size(self, stored: Size) -> Size {
        if self.transposed { Size::new(stored.height, stored.width) } else { stored }
    }

    /// The values of the upright image; `stored` is the size before.
    pub(super) fn apply(self, texels: Texels, stored: Size, channels: Channels) -> Texels {
        if self == Self::default() {
            return texels;
        }
        match texels {
            Texels::U8(values) => Texels::U8(self.turn_channels(values, stored, channels)),
            Texels::U16(values) => Texels::U16(self.turn_channels(values, stored, channels)),
            Texels::F32(values) => Texels::F32(self.turn_channels(values, stored, channels)),
        }
    }

    fn turn_channels<T: Copy + Default>(
        self,
        values: Vec<T>,
        stored: Size,
        channels: Channels,
    ) -> Vec<T> {
        match channels {
            Channels::Grey => self.turn::<T, 1>(values, stored),
            Channels::GreyAlpha => self.turn::<T, 2>(values, stored),
            Channels::Rgb => self.turn::<T, 3>(values, stored),
            Channels::Rgba => self.turn::<T, 4>(values, stored),
        }
    }

    fn turn<T: Copy + Default, const N: usize>(self, mut values: Vec<T>, stored: Size) -> Vec<T> {
        if self.transposed {
            return self.transpose::<T, N>(&values, stored);
        }
        let width = stored.width as usize;
        let (texels, _) = values.as_chunks_mut::<N>();
        match (self.flipped_x, self.flipped_y) {
            (true, true) => texels.reverse(),
            (true, false) => texels.chunks_exact_mut(width).for_each(<[_]>::reverse),
            (false, true) => {
                let mut rows = texels.chunks_exact_mut(width);
                while let (Some(above), Some(below)) = (rows.next(), rows.next_back()) {
                    above.swap_with_slice(below);
                }
            }
            (false, false) => {}
        }
        values
    }

    /// Moves blocks through a buffer: where row strides are a power of two, as in most textures,
    /// walking down a column of the source would map to the same few cache lines.
    fn transpose<T: Copy + Default, const N: usize>(self, values: &[T], stored: Size) -> Vec<T> {
        const BLOCK: usize = 32;
        let (width, height) = (stored.height as usize, stored.width as usize);
        let (source, _) = values.as_chunks::<N>();
        let mut turned = vec![T::default(); values.len()];
        let (target, _) = turned.as_chunks_mut::<N>();
        let mut block = [[[T::default(); N]; BLOCK]; BLOCK];
        for top in (0..width).step_by(BLOCK) {
            let lines = top..width.min(top + BLOCK);
            for left in (0..height).step_by(BLOCK) {
                let columns = left..height.min(left + BLOCK);
                for (line, row) in lines.clone().zip(&mut block) {
                    let row = &mut row[..columns.len()];
                    let start = line * height;
                    row.copy_from_slice(&source[start + columns.start..start + columns.end]);
                }
                for (column, x) in columns.enumerate() {
                    let y = if self.flipped_y { height - 1 - x } else { x };
                    let row = &mut target[y * width..(y + 1) * width];
                    let texels = block.iter().map(|line| line[column]);
                    if self.flipped_x {
                        let row = row[width - lines.end..width - lines.start].iter_mut().rev();
                        row.zip(texels).for_each(|(texel, moved)| *texel = moved);
                    } else {
                        let row = row[lines.clone()].iter_mut();
                        row.zip(texels).for_each(|(texel, moved)| *texel = moved);
                    }
                }
            }
        }
        turned
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The eight ways to store the 3×2 image `123/456`, row by row.
    ///
    /// Derived by hand from TIFF 6.0: which side of the image the stored row 0 and column 0 are.
    const STORED: [(u64, u32, [u8; 6]); 8] = [
        (1, 3, [1, 2, 3, 4, 5, 6]),
        (2, 3, [3, 2, 1, 6, 5, 4]),
        (3, 3, [6, 5, 4, 3, 2, 1]),
        (4, 3, [4, 5, 6, 1, 2, 3]),
        (5, 2, [1, 4, 2, 5, 3, 6]),
        (6, 2, [3, 6, 2, 5, 1, 4]),
        (7, 2, [6, 3, 5, 2, 4, 1]),
        (8, 2, [4, 1, 5, 2, 6, 3]),
    ];

    #[test]
    fn all_eight_turn_the_right_way_at_every_depth_and_channel_count() {
        for (tag, width, stored) in STORED {
            let orientation = Orientation::from_tag(tag);
            let size = Size::new(width, 6 / width);
            assert_eq!(orientation.size(size), Size::new(3, 2));
            for channels in [Channels::Grey, Channels::GreyAlpha, Channels::Rgb, Channels::Rgba] {
                let spread = |values: &[u8]| -> Vec<u16> {
                    let texel =
                        |&value| (0..channels.count()).map(move |c| value as u16 * 300 + c as u16);
                    values.iter().flat_map(texel).collect()
                };
                let wanted = spread(&[1, 2, 3, 4, 5, 6]);
                let turned = orientation.apply(Texels::U16(spread(&stored)), size, channels);
                assert_eq!(turned, Texels::U16(wanted.clone()), "orientation {tag}");
                let float =
                    |values: Vec<u16>| Texels::F32(values.into_iter().map(f32::from).collect());
                let turned = orientation.apply(float(spread(&stored)), size, channels);
                assert_eq!(turned, float(wanted), "orientation {tag}");
            }
        }
    }

    #[test]
    fn blocks_meet_without_a_seam() {
        let size = Size::new(70, 45);
        let values: Vec<u16> = (0..size.texels() as u16).collect();
        for tag in 5..=8 {
            let orientation = Orientation::from_tag(tag);
            let Texels::U16(turned) =
                orientation.apply(Texels::U16(values.clone()), size, Channels::Grey)
            else {
                unreachable!()
            };
            for y in 0..70 {
                for x in 0..45 {
                    let row = if tag == 6 || tag == 7 { 44 - x } else { x };
                    let column = if tag == 7 || tag == 8 { 69 - y } else { y };
                    assert_eq!(turned[y * 45 + x], values[row * 70 + column]);
                }
            }
        }
    }

    #[test]
    fn written_blocks_are_read() {
        assert_eq!(Orientation::default().exif(), None);
        for tag in 2..=8 {
            let exif = Orientation::from_tag(tag).exif().unwrap();
            assert_eq!(Orientation::from_blocks(&exif, b""), Orientation::from_tag(tag));
        }
    }

    #[test]
    fn nonsense_in_exif_turns_nothing() {
        let good = b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
        assert_eq!(Orientation::from_blocks(good, b""), Orientation::from_tag(6));
        assert_eq!(good[6..], Orientation::from_tag(6).exif().unwrap());
        for cut in 0..26 {
            assert_eq!(Orientation::from_blocks(&good[..cut], b""), Orientation::default());
        }
        assert_eq!(Orientation::from_blocks(b"II*\0\xff\xff\xff\xff", b""), Orientation::default());
        assert_eq!(Orientation::from_tag(9), Orientation::default());
    }
}
