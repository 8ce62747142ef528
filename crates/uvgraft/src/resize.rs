//! Resizing a whole texture: the unit square resampled onto itself.

use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::pair::{Direction, Pair};
use uvgraft_surface::piece::Piece;

use crate::filter::Filter;
use crate::formats::{Averaging, Formats};
use crate::map::MapOptions;
use crate::resampler::{MapInputs, Overlap, Resampler, TexelShape};
use crate::texture::{Size, Texels, TexelsMut, Texture, TextureError, Value};

impl Texture {
    /// Resizes the texture with the filtering of a transfer.
    ///
    /// # Errors
    /// [`TextureError`] for a size of 0 or beyond [`Texture::MAX_SIDE`].
    pub fn resized(
        self,
        size: Size,
        filter: Filter,
        averaging: Averaging,
    ) -> Result<Self, TextureError> {
        if self.size() == size {
            return Ok(self);
        }
        let format = self.format();
        let base = Self::filled(
            size,
            format.channels,
            format.encoding,
            format.depth,
            &[0.0; 4][..format.channels.count()],
        )?;
        let pair = square();
        let map = MapOptions::with_gutter(0);
        let inputs =
            MapInputs { pair: &pair, direction: Direction::Forward, target_size: size, map };
        let resampler = Resampler::new(&inputs, inputs.maps(Overlap::First), self.size(), filter);
        let formats = Formats::new(format, format, averaging);
        let source = resampler.source(&formats, self);
        let shape = TexelShape {
            channels: formats.channels().count(),
            has_alpha: formats.has_alpha(),
            is_opaque: source.is_opaque,
        };
        fn fill<T: Value>(of: &Resampler, shape: TexelShape, source: &[T], rows: &mut [T]) {
            of.fill(shape, source, 0, rows, |_, _| {});
        }
        let mut result = formats.working(base);
        match (source.texture.texels(), result.texels_mut()) {
            (Texels::U8(source), TexelsMut::U8(rows)) => fill(&resampler, shape, source, rows),
            (Texels::U16(source), TexelsMut::U16(rows)) => fill(&resampler, shape, source, rows),
            (Texels::F32(source), TexelsMut::F32(rows)) => fill(&resampler, shape, source, rows),
            _ => unreachable!("both were converted to one depth"),
        }
        Ok(formats.restore(result))
    }
}

/// A pair that maps the unit square to itself.
fn square() -> Pair {
    let uv = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let faces = [[0, 1, 2], [0, 2, 3]];
    let square =
        Mesh::from_triangles(vec![[0.0; 3]; 4], uv, &faces, &faces).expect("two sound triangles");
    let itself = [0, 1].map(|face| Piece::whole(face, face, [0, 1, 2]));
    Pair::from_pieces(square.clone(), square, itself).expect("a square is itself")
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
        let small =
            ramp.unwrap().resized(Size::new(16, 5), Filter::Bilinear, Averaging::Encoded).unwrap();
        for x in 1..15 {
            // The mean of levels 16x + 2, + 6, + 10 and + 14.
            assert_eq!(small.get(x, 2, 0) * 255.0, (16 * x + 8) as f32);
        }
    }

    #[test]
    fn refuses_invalid_sizes() {
        let texel = Texels::U8(vec![1]);
        let one = Texture::new(Size::square(1), Channels::Grey, Encoding::Data, texel).unwrap();
        assert!(one.clone().resized(Size::new(0, 5), Filter::Nearest, Averaging::Encoded).is_err());
        assert!(one.resized(Size::new(5, 40_000), Filter::Nearest, Averaging::Encoded).is_err());
    }
}
