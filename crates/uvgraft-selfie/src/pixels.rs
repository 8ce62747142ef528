//! The pixels of a photograph, all of them or a part.

use uvgraft::Texture;

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
        let size = self.texture.size();
        let sides = [size.width, size.height].map(f64::from);
        let uv = [0, 1].map(|k| ((at[k] - self.offset[k]) * self.scale[k] / sides[k]) as f32);
        nearest_four(self.texture, uv)
    }
}

/// The bilinear mean of the texels around a UV coordinate.
pub(crate) fn nearest_four(texture: &Texture, uv: [f32; 2]) -> [f32; 3] {
    let size = texture.size();
    let is_grey = !texture.channels().has_color();
    let (x, y) = (uv[0] * size.width as f32 - 0.5, uv[1] * size.height as f32 - 0.5);
    let (left, top) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - top);
    let at = |dx: f32, dy: f32, channel: usize| {
        let x = (left + dx).clamp(0.0, (size.width - 1) as f32) as u32;
        let y = (top + dy).clamp(0.0, (size.height - 1) as f32) as u32;
        texture.get(x, y, if is_grey { 0 } else { channel })
    };
    std::array::from_fn(|k| {
        let above = at(0.0, 0.0, k) * (1.0 - fx) + at(1.0, 0.0, k) * fx;
        let below = at(0.0, 1.0, k) * (1.0 - fx) + at(1.0, 1.0, k) * fx;
        above * (1.0 - fy) + below * fy
    })
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
