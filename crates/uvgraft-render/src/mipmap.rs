//! Textures with smaller copies, for sampling over an area.
//!
//! # Source
//! Williams, "Pyramidal Parametrics", 1983. Long footprints are covered by several samples along
//! their longer axis, as in McCormack et al., "Feline: Fast Elliptical Lines for Anisotropic
//! Texture Mapping", 1999.

use glam::Vec4;
use uvgraft::color::{linear_from_srgb, srgb_from_linear};
use uvgraft::{Channels, Encoding, Texels, Texture, Value, threads};
use uvgraft_gltf::scene::{TextureUse, Wrap};

/// Levels as 8-bit sRGB with alpha; colours are averaged in linear light.
#[derive(Debug)]
pub(crate) struct Mipmap {
    levels: Vec<Level>,
    linear: [f32; 256],
}

#[derive(Debug)]
struct Level {
    width: usize,
    height: usize,
    texels: Vec<[u8; 4]>,
}

/// A point in a texture, and its derivatives per sample to the right and downwards.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Footprint {
    pub uv: [f32; 2],
    pub along_x: [f32; 2],
    pub along_y: [f32; 2],
}

/// Maximum number of samples along the longer axis of a footprint.
const MAX_TAPS: f32 = 8.0;

/// Size of the table from linear light to 8-bit sRGB: fine enough that all 256 values occur.
const STEPS: usize = 1 << 13;

impl Mipmap {
    /// For colours: texels are interpolated in linear light.
    pub fn new(texture: &Texture) -> Self {
        Self::by(texture, rgba(texture), linear_from_srgb, srgb_from_linear)
    }

    /// For data such as normals: values are interpolated as stored, and the texture's
    /// alpha is ignored.
    pub fn of_data(texture: &Texture) -> Self {
        let mut texels = rgba(&texture.clone().with_encoding(Encoding::Data));
        texels.iter_mut().for_each(|texel| texel[3] = 255);
        Self::by(texture, texels, |value| value, |value| value)
    }

    fn by(
        texture: &Texture,
        texels: Vec<[u8; 4]>,
        decode: fn(f32) -> f32,
        encode: fn(f32) -> f32,
    ) -> Self {
        let linear = std::array::from_fn(|level| decode((level as u8).to_unit()));
        let encode = |step: usize| u8::from_unit(encode(step as f32 / STEPS as f32));
        let encoded: Vec<u8> = (0..=STEPS).map(encode).collect();
        let mut levels = vec![Level {
            width: texture.size().width as usize,
            height: texture.size().height as usize,
            texels,
        }];
        while let Some(smaller) = levels.last().and_then(|last| last.halved(&linear, &encoded)) {
            levels.push(smaller);
        }
        Self { levels, linear }
    }

    /// Linear colour and alpha over a footprint.
    ///
    /// A single trilinear lookup would be blurred across the footprint or aliased along it. Instead
    /// `ceil(long / short)` lookups, at most [`MAX_TAPS`], are spread along the longer axis, each
    /// at level `log2(long / taps)`.
    pub fn sample(&self, footprint: &Footprint, texture: &TextureUse) -> [f32; 4] {
        let [x, y] = self.squares(footprint);
        let (long, short, along) =
            if x > y { (x, y, footprint.along_x) } else { (y, x, footprint.along_y) };
        let last = self.levels.len() - 1;
        let unit = Vec4::new(1.0, 1.0, 1.0, 255.0);
        let at = |level: usize, uv| self.levels[level].bilinear(uv, texture, &self.linear);
        if !long.is_finite() {
            return (at(last, footprint.uv) / unit).to_array();
        }
        if long <= 1.0 {
            return (at(0, footprint.uv) / unit).to_array();
        }
        // The short axis counts as at least one texel: finer detail does not exist.
        let ratio = (long / short.max(1.0)).sqrt().clamp(1.0, MAX_TAPS);
        let count = ratio as u32 + u32::from(ratio.fract() > 0.0);
        let taps = count as f32;
        let level = 0.5 * log2((long / (taps * taps)).max(1.0));
        let lower = (level as usize).min(last);
        // All taps are at the same level, so they are added up before levels are mixed.
        let sum = |level: usize| {
            let mut sum = Vec4::ZERO;
            for tap in 0..count {
                let t = (tap as f32 + 0.5) / taps - 0.5;
                sum += at(level, [0, 1].map(|k| footprint.uv[k] + along[k] * t));
            }
            sum
        };
        let mut mean = sum(lower);
        let t = level - lower as f32;
        if t > 0.0 && lower < last {
            mean += (sum(lower + 1) - mean) * t;
        }
        (mean / (unit * taps)).to_array()
    }

    /// The squares of a footprint's sides, in texels.
    fn squares(&self, footprint: &Footprint) -> [f32; 2] {
        let finest = &self.levels[0];
        let (width, height) = (finest.width as f32, finest.height as f32);
        [footprint.along_x, footprint.along_y].map(|[du, dv]| {
            let (x, y) = (du * width, dv * height);
            x * x + y * y
        })
    }

    /// Whether a footprint is no longer than a texel.
    pub fn is_magnified(&self, footprint: &Footprint) -> bool {
        let [x, y] = self.squares(footprint);
        x.max(y) <= 1.0
    }
}

impl Level {
    /// Half as wide and high, rounded down. Colours are averaged with their alpha as weight, so
    /// that the colour of transparent texels does not bleed in.
    fn halved(&self, linear: &[f32; 256], encoded: &[u8]) -> Option<Self> {
        if self.width.max(self.height) < 2 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut texels = vec![[0; 4]; width * height];
        threads::for_each_chunk(&mut texels, width, |y, row| {
            let rows = shares(y, self.height, height);
            for (x, texel) in row.iter_mut().enumerate() {
                let mut sum = [0.0; 4];
                let mut plain = [0.0; 3];
                for (row, by_row) in rows {
                    for (column, by_column) in shares(x, self.width, width) {
                        let share = by_row * by_column;
                        if share == 0.0 {
                            continue;
                        }
                        let [r, g, b, a] = self.texels[row * self.width + column];
                        let alpha = f32::from(a) * share;
                        for (k, value) in [r, g, b].into_iter().enumerate() {
                            sum[k] += linear[usize::from(value)] * alpha;
                            plain[k] += linear[usize::from(value)] * share;
                        }
                        sum[3] += alpha;
                    }
                }
                for k in 0..3 {
                    let mean = if sum[3] > 0.0 { sum[k] / sum[3] } else { plain[k] };
                    texel[k] = encoded[((mean * STEPS as f32 + 0.5) as usize).min(STEPS)];
                }
                texel[3] = (sum[3] + 0.5) as u8;
            }
        });
        Some(Self { width, height, texels })
    }

    /// Linear colour, and alpha times 255. Apart from the core's `bilinear`, since this is where rendering
    /// spends its time: bytes by a table into vectors, rows wrapped once, no calls of `floor`.
    #[inline]
    fn bilinear(&self, [u, v]: [f32; 2], texture: &TextureUse, linear: &[f32; 256]) -> Vec4 {
        let (x, y) = (u * self.width as f32 - 0.5, v * self.height as f32 - 0.5);
        let ((mut left, mut fx), (mut top, mut fy)) = (floor(x), floor(y));
        if texture.nearest {
            (left, top) = (floor(x + 0.5).0, floor(y + 0.5).0);
            (fx, fy) = (0.0, 0.0);
        }
        let [wrap_x, wrap_y] = texture.wrap;
        let columns = neighbours(left, self.width, wrap_x);
        let rows = neighbours(top, self.height, wrap_y);
        let rows = rows.map(|row| &self.texels[row * self.width..][..self.width]);
        let texel = |row: usize, column: usize| {
            let [r, g, b, a] = rows[row][columns[column]];
            let [r, g, b] = [r, g, b].map(|value| linear[usize::from(value)]);
            Vec4::new(r, g, b, f32::from(a))
        };
        let (a, b, c, d) = (texel(0, 0), texel(0, 1), texel(1, 0), texel(1, 1));
        let (upper, lower) = (a + (b - a) * fx, c + (d - c) * fx);
        upper + (lower - upper) * fy
    }
}

/// The logarithm of a number that is at least 1, within 0.01: levels need no more.
fn log2(value: f32) -> f32 {
    const MANTISSA: u32 = (1 << 23) - 1;
    let bits = value.to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let x = f32::from_bits(bits & MANTISSA | 1.0_f32.to_bits()) - 1.0;
    // A parabola through the ends.
    exponent as f32 + x * (1.344 - 0.344 * x)
}

/// The texels of a row of `count` that a texel of the `smaller` row covers, with their weights: two
/// texels where `count` is even; where it is odd, one whole and parts of two others.
fn shares(index: usize, count: usize, smaller: usize) -> [(usize, f32); 3] {
    if count == 1 {
        return [(0, 1.0), (0, 0.0), (0, 0.0)];
    }
    let first = 2 * index;
    if count.is_multiple_of(2) {
        return [(first, 0.5), (first + 1, 0.5), (first, 0.0)];
    }
    let (m, whole) = (smaller as f32, count as f32 / smaller as f32);
    let (start, end) = ((m - index as f32) / m, (index as f32 + 1.0) / m);
    [(first, start / whole), (first + 1, 1.0 / whole), (first + 2, end / whole)]
}

/// The next lower integer, and how far the value is above it. Far away from 0 the integer saturates.
#[inline]
fn floor(value: f32) -> (i32, f32) {
    // `f32::floor` is a call where the baseline target has no instruction for it.
    let towards_zero = value as i32;
    let integer = towards_zero.saturating_sub(i32::from((towards_zero as f32) > value));
    (integer, value - integer as f32)
}

/// The texels at an index and the next one.
#[inline]
fn neighbours(index: i32, count: usize, wrap: Wrap) -> [usize; 2] {
    if index >= 0 && (index as usize) < count - 1 {
        return [index as usize, index as usize + 1];
    }
    [0, 1].map(|k| wrapped(i64::from(index) + k, count, wrap))
}

fn wrapped(index: i64, count: usize, wrap: Wrap) -> usize {
    let count = count as i64;
    let index = match wrap {
        Wrap::Clamp => index.clamp(0, count - 1),
        Wrap::Repeat => index.rem_euclid(count),
        Wrap::Mirror => {
            let folded = index.rem_euclid(2 * count);
            if folded < count { folded } else { 2 * count - 1 - folded }
        }
    };
    index as usize
}

/// The texels as 8-bit RGBA, linear light encoded as sRGB. Grey is copied to all three colours;
/// without an alpha channel texels are opaque.
fn rgba(texture: &Texture) -> Vec<[u8; 4]> {
    fn collect<T: Value>(values: &[T], channels: Channels, encoding: Encoding) -> Vec<[u8; 4]> {
        let order = if channels.has_color() { [0, 1, 2] } else { [0, 0, 0] };
        let color = |value: T| match encoding {
            Encoding::Linear => u8::from_unit(srgb_from_linear(value.to_unit())),
            Encoding::Srgb | Encoding::Data => u8::from_unit(value.to_unit()),
        };
        values
            .chunks_exact(channels.count())
            .map(|texel| {
                let [r, g, b] = order.map(|k| color(texel[k]));
                let alpha = channels.has_alpha().then(|| texel[channels.count() - 1]);
                [r, g, b, alpha.map_or(255, |alpha| u8::from_unit(alpha.to_unit()))]
            })
            .collect()
    }
    let (channels, encoding) = (texture.channels(), texture.encoding());
    match texture.texels() {
        Texels::U8(values) => collect(values, channels, encoding),
        Texels::U16(values) => collect(values, channels, encoding),
        Texels::F32(values) => collect(values, channels, encoding),
    }
}

#[cfg(test)]
mod tests {
    use uvgraft::Size;

    use super::*;

    const PLAIN: TextureUse =
        TextureUse { index: 0, wrap: [Wrap::Clamp; 2], nearest: false, coordinates: 0 };

    fn grey(size: Size, values: &[u8]) -> Mipmap {
        let texels = Texels::U8(values.to_vec());
        Mipmap::new(&Texture::new(size, Channels::Grey, Encoding::Srgb, texels).unwrap())
    }

    fn over(uv: [f32; 2], along_x: [f32; 2], along_y: [f32; 2]) -> Footprint {
        Footprint { uv, along_x, along_y }
    }

    #[test]
    fn the_whole_texture_has_its_mean_light() {
        // Light of 0 and 1 in equal parts, also where the size is odd.
        for (size, values) in [
            (Size::new(2, 1), vec![0, 255]),
            (Size::new(4, 3), [0, 255, 255, 0].repeat(3)),
            (Size::new(1, 6), vec![0, 0, 255, 255, 0, 255]),
        ] {
            let mipmap = grey(size, &values);
            let all = mipmap.sample(&over([0.5; 2], [1.0, 0.0], [0.0, 1.0]), &PLAIN);
            // A level is rounded to 8 bits, in steps of 0.009 here.
            assert!((all[1] - 0.5).abs() < 0.01, "{size}: {all:?}");
            assert_eq!(all[3], 1.0);
        }
        // A row of five: the centre texel belongs to both halves.
        let five = grey(Size::new(5, 1), &[0, 0, 255, 0, 0]);
        assert_eq!((five.levels[1].width, five.levels.len()), (2, 3));
        let (left, right) = (five.levels[1].texels[0][0], five.levels[1].texels[1][0]);
        // Half of one texel in two and a half: light of 0.2.
        assert_eq!((left, right), (u8::from_unit(srgb_from_linear(0.2)), left));
    }

    #[test]
    fn what_is_seen_at_a_slant_stays_sharp_across() {
        // Stripes along v; the footprint is eight texels long in v and one in u.
        let stripes = grey(Size::new(16, 16), &[0, 255].repeat(128));
        let uv = [4.5 / 16.0, 0.5];
        let along = stripes.sample(&over(uv, [1.0 / 16.0, 0.0], [0.0, 8.0 / 16.0]), &PLAIN);
        assert!(along[0] < 0.01, "{along:?}");
        let across = stripes.sample(&over(uv, [8.0 / 16.0, 0.0], [0.0, 1.0 / 16.0]), &PLAIN);
        assert!((across[0] - 0.5).abs() < 0.07, "{across:?}");
    }

    #[test]
    fn logarithms_are_exact_enough() {
        for step in 0..100_000 {
            let value = 1.0003_f32.powi(step).min(1e20);
            assert!((log2(value) - value.log2()).abs() < 0.01, "{value}");
        }
        assert_eq!([1.0, 2.0, 1024.0].map(log2), [0.0, 1.0, 10.0]);
    }

    #[test]
    fn edges_go_on_as_the_texture_asks() {
        let of = |wrap| [-3, -1, 0, 3, 4, 5].map(|index| wrapped(index, 4, wrap));
        assert_eq!(of(Wrap::Clamp), [0, 0, 0, 3, 3, 3]);
        assert_eq!(of(Wrap::Repeat), [1, 3, 0, 3, 0, 1]);
        assert_eq!(of(Wrap::Mirror), [2, 0, 0, 3, 3, 2]);
    }

    #[test]
    fn lookups_that_are_no_numbers_do_no_harm() {
        let mipmap = grey(Size::square(4), &[7; 16]);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
            for wrap in [Wrap::Clamp, Wrap::Repeat, Wrap::Mirror] {
                let texture = TextureUse { wrap: [wrap; 2], ..PLAIN };
                mipmap.sample(&over([bad; 2], [0.1, 0.0], [0.0, 0.1]), &texture);
                mipmap.sample(&over([0.1; 2], [bad, 0.0], [0.0, bad]), &texture);
            }
        }
    }
}
