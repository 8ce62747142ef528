//! Square crops of a photograph, as networks read them: rotated, scaled, and filtered when minified.
//!
//! The photograph is halved again and again by averages of 2 × 2 texels. A crop reads the level in
//! which its texels are one to two texels apart, with 2 × 2 bilinear samples for each, and the
//! photograph itself where it is magnified.

use uvgraft::sampler::{Beyond, bilinear};
use uvgraft::{Encoding, Size, Texels, Texture, color, threads};

/// A colour as networks expect it: sRGB in `0.0..=1.0`.
type Color = [f32; 3];

/// What transparent texels are laid over. Cut-out photographs have anything there, often black.
const BACKDROP: f32 = 0.5;

/// Levels larger than this a side are not stored; crops of huge photographs take more samples instead.
const MAX_STORED_SIDE: usize = 4096;

/// A photograph and its reductions, from which networks get their crops.
#[derive(Debug)]
pub(super) struct PhotoPyramid<'t> {
    texture: &'t Texture,
    levels: Vec<Level>,
}

/// A photograph reduced by averages of `scale` × `scale` texels.
#[derive(Debug)]
struct Level {
    scale: usize,
    width: usize,
    height: usize,
    colors: Vec<Color>,
}

/// A square in a photograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crop {
    /// Its centre, in pixels.
    pub(super) center: [f64; 2],
    /// Length of its sides, in pixels.
    pub(super) side: f64,
    /// Where its x-axis points, in radians from the photograph's towards the photograph's y-axis,
    /// clockwise as one sees it.
    pub(super) angle: f64,
}

impl Crop {
    /// The position in the photograph of a position in the crop, both sides of which have length 1.
    pub(super) fn position(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [x, y] = [(u - 0.5) * self.side, (v - 0.5) * self.side];
        let (sin, cos) = self.angle.sin_cos();
        [self.center[0] + cos * x - sin * y, self.center[1] + sin * x + cos * y]
    }

    /// The same square, further out or in.
    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { side: self.side * factor, ..self }
    }
}

impl<'t> PhotoPyramid<'t> {
    pub(super) fn new(texture: &'t Texture) -> Self {
        let size = texture.size();
        let longest = size.width.max(size.height) as usize;
        let mut scale = 2;
        while longest.div_ceil(scale) > MAX_STORED_SIDE {
            scale *= 2;
        }
        let mut levels: Vec<Level> = Vec::new();
        // Below this, a level would be smaller than what networks read.
        while longest / scale >= 64 {
            let level = match levels.last() {
                None => reduced_texture(texture, scale),
                Some(finer) => finer.halved(),
            };
            levels.push(level);
            scale *= 2;
        }
        Self { texture, levels }
    }

    /// Width and height in pixels.
    pub(super) fn size(&self) -> [f64; 2] {
        let size = self.texture.size();
        [f64::from(size.width), f64::from(size.height)]
    }

    /// A crop as `resolution` × `resolution` colours, row by row. Beyond the photograph it is black for
    /// the detector, as it was trained with.
    pub(super) fn crop(&self, crop: &Crop, resolution: usize, beyond: Beyond) -> Vec<Color> {
        let step = crop.side / resolution as f64;
        let level = self.levels.iter().rev().find(|level| level.scale as f64 <= step);
        let scale = level.map_or(1.0, |level| level.scale as f64);
        let samples = if step <= 1.0 { 1 } else { (step / scale).ceil().max(2.0) as usize };
        let weight = 1.0 / (samples * samples) as f32;
        let fine = (resolution * samples) as f64;
        let rows = threads::map_indices(resolution, |row| {
            let texel = |column: usize| {
                let mut sum = [0.0; 3];
                for index in 0..samples * samples {
                    let x = (column * samples + index % samples) as f64 + 0.5;
                    let y = (row * samples + index / samples) as f64 + 0.5;
                    let place = crop.position([x / fine, y / fine]);
                    let color = self.sample(level, place.map(|at| at / scale), beyond);
                    (0..3).for_each(|channel| sum[channel] += color[channel]);
                }
                sum.map(|value| value * weight)
            };
            (0..resolution).map(texel).collect::<Vec<_>>()
        });
        rows.concat()
    }

    /// The bilinear sample at a position in texels of a level, or of the photograph.
    fn sample(&self, level: Option<&Level>, at_px: [f64; 2], beyond: Beyond) -> Color {
        let full = self.texture.size();
        let size = level.map_or(full, |level| Size::new(level.width as u32, level.height as u32));
        bilinear(size, at_px, beyond, |x, y| {
            let index = y as usize * size.width as usize + x as usize;
            level.map_or_else(|| color_at(self.texture, index), |level| level.colors[index])
        })
    }
}

impl Level {
    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut colors = vec![[0.0; 3]; width * height];
        threads::for_each_chunk(&mut colors, width, |row, colors| {
            let rows = [2 * row, (2 * row + 1).min(self.height - 1)];
            let [above, below] = rows.map(|row| &self.colors[row * self.width..][..self.width]);
            for (column, color) in colors.iter_mut().enumerate() {
                let (left, right) = (2 * column, (2 * column + 1).min(self.width - 1));
                for channel in 0..3 {
                    let sum = above[left][channel] + above[right][channel];
                    let sum = sum + (below[left][channel] + below[right][channel]);
                    color[channel] = sum * 0.25;
                }
            }
        });
        Self { scale: self.scale * 2, width, height, colors }
    }
}

/// Averages of `scale` × `scale` texels, fewer at the right and bottom edges.
fn reduced_texture(texture: &Texture, scale: usize) -> Level {
    let (full_width, full_height) = (texture.size().width as usize, texture.size().height as usize);
    let (width, height) = (full_width.div_ceil(scale), full_height.div_ceil(scale));
    let mut colors = vec![[0.0; 3]; width * height];
    threads::for_each_chunk(&mut colors, width, |row, colors| {
        let rows = row * scale..((row + 1) * scale).min(full_height);
        for y in rows.clone() {
            for x in 0..full_width {
                let color = color_at(texture, y * full_width + x);
                (0..3).for_each(|channel| colors[x / scale][channel] += color[channel]);
            }
        }
        for (column, color) in colors.iter_mut().enumerate() {
            let columns = scale.min(full_width - column * scale);
            let weight = 1.0 / (columns * rows.len()) as f32;
            color.iter_mut().for_each(|value| *value *= weight);
        }
    });
    Level { scale, width, height, colors }
}

/// The colour of a texel, over [`BACKDROP`] where it is transparent.
#[inline(always)]
fn color_at(texture: &Texture, index: usize) -> Color {
    let channels = texture.channels();
    let count = channels.count();
    let start = index * count;
    let mut values = [1.0; 4];
    match texture.texels() {
        Texels::U8(texels) => {
            let texel = texels[start..start + count].iter();
            values.iter_mut().zip(texel).for_each(|(to, &value)| *to = f32::from(value) / 255.0);
        }
        Texels::U16(texels) => {
            let texel = texels[start..start + count].iter();
            values.iter_mut().zip(texel).for_each(|(to, &value)| *to = f32::from(value) / 65_535.0);
        }
        Texels::F32(texels) => {
            let texel = texels[start..start + count].iter();
            values.iter_mut().zip(texel).for_each(|(to, &value)| *to = value);
        }
    }
    let mut color =
        if channels.has_color() { [values[0], values[1], values[2]] } else { [values[0]; 3] };
    if texture.encoding() == Encoding::Linear {
        color = color.map(color::srgb_from_linear);
    }
    // NaN becomes 0; a network would spread it over everything.
    let clamped = |value: f32| if value > 0.0 { value.min(1.0) } else { 0.0 };
    if channels.has_alpha() {
        let alpha = clamped(values[count - 1]);
        color = color.map(|value| BACKDROP + (clamped(value) - BACKDROP) * alpha);
    }
    color.map(clamped)
}

#[cfg(test)]
mod tests {
    use uvgraft::{Channels, Size};

    use super::*;

    /// A texture whose red is x and whose green is y, in thousandths.
    fn ramp(width: u32, height: u32) -> Texture {
        let texel = |index: u32| [index % width, index / width, 0].map(|v| v as f32 / 1000.0);
        let values = (0..width * height).flat_map(texel).collect();
        let size = Size::new(width, height);
        Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::F32(values)).unwrap()
    }

    #[test]
    fn crops_read_what_lies_under_their_texels() {
        let texture = ramp(300, 200);
        let picture = PhotoPyramid::new(&texture);
        for (side, angle) in [(20.0, 0.0), (80.0, 0.3), (110.0, -2.0), (60.0, 1.57)] {
            let crop = Crop { center: [150.0, 100.0], side, angle };
            let colors = picture.crop(&crop, 16, Beyond::Zero);
            for (index, color) in colors.iter().enumerate() {
                let at = [index % 16, index / 16].map(|at| (at as f64 + 0.5) / 16.0);
                let wanted = crop.position(at).map(|at| (at - 0.5) / 1000.0);
                for axis in 0..2 {
                    let found = f64::from(color[axis]);
                    assert!((found - wanted[axis]).abs() < 1e-6, "{found} {wanted:?} at {side}");
                }
            }
        }
    }

    #[test]
    fn fine_stripes_turn_grey_when_reduced() {
        let size = Size::new(512, 512);
        let values = (0..512 * 512).map(|index: u32| (index % 2 * 255) as u8).collect();
        let texture =
            Texture::new(size, Channels::Grey, Encoding::Srgb, Texels::U8(values)).unwrap();
        let crop = Crop { center: [256.0; 2], side: 400.0, angle: 0.0 };
        for color in PhotoPyramid::new(&texture).crop(&crop, 128, Beyond::Zero) {
            assert!((color[0] - 0.5).abs() < 0.01, "{color:?}");
        }
    }

    #[test]
    fn outside_is_black_or_the_nearest_texel() {
        let size = Size::square(4);
        let texture =
            Texture::filled(size, Channels::Grey, Encoding::Srgb, uvgraft::Depth::U8, &[1.0]);
        let texture = texture.unwrap();
        let crop = Crop { center: [20.0; 2], side: 8.0, angle: 0.0 };
        let picture = PhotoPyramid::new(&texture);
        assert_eq!(picture.crop(&crop, 2, Beyond::Zero), [[0.0; 3]; 4]);
        assert_eq!(picture.crop(&crop, 2, Beyond::Edge), [[1.0; 3]; 4]);
    }

    #[test]
    fn every_kind_of_texture_gives_srgb_over_grey() {
        let color = |channels, encoding, values: &[f32]| {
            let texels = Texels::F32(values.to_vec());
            let texture = Texture::new(Size::square(1), channels, encoding, texels).unwrap();
            color_at(&texture, 0)
        };
        assert_eq!(color(Channels::Grey, Encoding::Srgb, &[0.25]), [0.25; 3]);
        assert_eq!(color(Channels::GreyAlpha, Encoding::Srgb, &[1.0, 0.5]), [0.75; 3]);
        assert_eq!(color(Channels::Rgba, Encoding::Srgb, &[1.0, 0.0, 0.0, 0.0]), [0.5; 3]);
        assert_eq!(color(Channels::Rgb, Encoding::Srgb, &[f32::NAN, -1.0, 9.0]), [0.0, 0.0, 1.0]);
        let linear = color(Channels::Grey, Encoding::Linear, &[0.214_041_14]);
        assert!((linear[0] - 0.5).abs() < 1e-5);
    }
}
