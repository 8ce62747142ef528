//! The pixels of a photograph, all of them or a part.

use uvgraft::Texture;
use uvgraft::sampler::{Beyond, bilinear};

/// What is kept of a photograph's pixels.
#[derive(Debug, Clone, Copy)]
pub struct Pixels<'a> {
    /// Colours: sRGB, of any depth.
    pub texture: &'a Texture,
    /// Where in the photograph the upper left corner of `texture` is, in the photograph's pixels.
    pub offset: [f64; 2],
    /// Pixels of `texture` per pixel of the photograph.
    pub scale: [f64; 2],
}

impl<'a> Pixels<'a> {
    /// All of a photograph.
    pub const fn whole(texture: &'a Texture) -> Self {
        Self { texture, offset: [0.0; 2], scale: [1.0; 2] }
    }

    /// The mean colour in a square, sRGB with 1.0 for white; outside, that of the nearest pixel.
    ///
    /// - `at`: its centre, in pixels of the photograph.
    /// - `side`: in the same unit.
    pub(crate) fn mean(&self, at: [f64; 2], side: f64) -> [f32; 3] {
        /// Most samples along a side; each is the mean of some two pixels along it.
        const MOST: f64 = 4.0;
        let samples = (side * self.scale[0] / 2.0).ceil().clamp(1.0, MOST) as usize;
        let step = side / samples as f64;
        let mut sum = [0.0; 3];
        for index in 0..samples * samples {
            let shift = [index % samples, index / samples]
                .map(|at| (at as f64 + 0.5 - 0.5 * samples as f64) * step);
            let color = self.sample([at[0] + shift[0], at[1] + shift[1]]);
            (0..3).for_each(|k| sum[k] += color[k]);
        }
        sum.map(|value| value / (samples * samples) as f32)
    }

    fn sample(&self, at: [f64; 2]) -> [f32; 3] {
        color(self.texture, [0, 1].map(|k| (at[k] - self.offset[k]) * self.scale[k]))
    }
}

/// The bilinear mean of the texels around a position in texels, whatever their alpha.
pub(crate) fn color(texture: &Texture, at_px: [f64; 2]) -> [f32; 3] {
    let channels = if texture.channels().has_color() { [0, 1, 2] } else { [0; 3] };
    bilinear(texture.size(), at_px, Beyond::Edge, |x, y| channels.map(|k| texture.get(x, y, k)))
}

#[cfg(test)]
mod tests {
    use uvgraft::{Channels, Encoding, Size, Texels};

    use super::*;

    #[test]
    fn a_part_of_a_photograph_answers_in_its_pixels() {
        let size = Size::new(20, 10);
        let values = (0..10).flat_map(|y| (0..20).flat_map(move |x| [x as f32, y as f32, 7.0]));
        let texels = Texels::F32(values.collect());
        let texture = Texture::new(size, Channels::Rgb, Encoding::Srgb, texels).unwrap();
        let part = Pixels { texture: &texture, offset: [100.0, 50.0], scale: [0.5; 2] };
        for side in [0.5, 3.0] {
            // Pixel 5, 4 of the part covers 2 × 2 of the photograph's.
            assert_eq!(part.mean([111.0, 59.0], side), [5.0, 4.0, 7.0]);
        }
        assert_eq!(part.mean([0.0, 0.0], 1.0), [0.0, 0.0, 7.0]);
        assert_eq!(Pixels::whole(&texture).mean([3.5, 2.5], 1.0), [3.0, 2.0, 7.0]);
    }
}
