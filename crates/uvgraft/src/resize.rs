//! Another size for a whole texture: a transfer from the unit square to itself.

use crate::filter::Filter;
use crate::map::MapOptions;
use crate::mesh::Mesh;
use crate::pair::{Direction, Pair};
use crate::texture::{Size, Texture, TextureError};
use crate::transfer::{Transfer, TransferOptions};

impl Texture {
    /// The same picture with another number of texels, filtered like a transfer, whose options
    /// `filter` and `linear_light` are.
    ///
    /// # Errors
    /// [`TextureError`] for a size of 0 or beyond [`Texture::MAX_SIDE`].
    pub fn resized(
        self,
        size: Size,
        filter: Filter,
        linear_light: bool,
    ) -> Result<Self, TextureError> {
        if self.size() == size {
            return Ok(self);
        }
        let nothing = [0.0; 4];
        let channels = self.channels();
        let base = Self::filled(
            size,
            channels,
            self.encoding(),
            self.depth(),
            &nothing[..channels.count()],
        )?;
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let faces = [[0, 1, 2], [0, 2, 3]];
        let square = Mesh::from_triangles(vec![[0.0; 3]; 4], uv, &faces, &faces)
            .expect("two sound triangles");
        let pair =
            Pair::by_vertex_map(square.clone(), square, &[0, 1, 2, 3]).expect("a square is itself");
        let map = MapOptions::with_gutter(0);
        let options = TransferOptions { filter, map, linear_light, ..TransferOptions::default() };
        let transfer = Transfer::new(&pair, Direction::Forward, self.size(), size, &options);
        Ok(transfer.apply(self, base).expect("sizes are those of the transfer"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Encoding;
    use crate::texture::{Channels, Texels};

    #[test]
    fn a_ramp_stays_a_ramp() {
        let values = (0..64 * 3).map(|texel| ((texel % 64) * 4 + 2) as u8).collect();
        let ramp =
            Texture::new(Size::new(64, 3), Channels::Grey, Encoding::Srgb, Texels::U8(values));
        let small = ramp.unwrap().resized(Size::new(16, 5), Filter::Bilinear, false).unwrap();
        for x in 1..15 {
            // The mean of levels 16x + 2, + 6, + 10 and + 14.
            assert_eq!(small.get(x, 2, 0) * 255.0, (16 * x + 8) as f32);
        }
    }

    #[test]
    fn refuses_what_is_no_size() {
        let texel = Texels::U8(vec![1]);
        let one = Texture::new(Size::square(1), Channels::Grey, Encoding::Data, texel).unwrap();
        assert!(one.clone().resized(Size::new(0, 5), Filter::Nearest, false).is_err());
        assert!(one.resized(Size::new(5, 40_000), Filter::Nearest, false).is_err());
    }
}
