//! Resamples from texels at the corners of a square to texels that tile it, unlike the core's
//! `bilinear`, whose texels tile what it reads too.

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Size, Texels, Texture, TextureError};

/// Vertical orientation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Upright {
    /// Row 0 is at the top.
    Yes,
    /// Row 0 is at the bottom.
    No,
}

/// Planes of `side` × `side` values, one for each channel. Value `i` of a row lies at `i / (side -
/// 1)` of the square's width.
pub(super) struct Planes {
    pub(super) values: Vec<f32>,
    pub(super) channels: usize,
    pub(super) side: usize,
    pub(super) upright: Upright,
}

/// The two values around a position on an axis, and the weight of the second.
#[derive(Clone, Copy)]
struct Between {
    first: usize,
    second: usize,
    fraction: f32,
}

/// The positions of the centres of `size` texels among `side` values.
fn positions(size: u32, side: usize) -> impl Iterator<Item = Between> {
    let last = side - 1;
    (0..size).map(move |texel| {
        let position = (f64::from(texel) + 0.5) / f64::from(size) * last as f64;
        let first = (position as usize).min(last);
        let fraction = (position - first as f64) as f32;
        Between { first, second: (first + 1).min(last), fraction }
    })
}

impl Planes {
    /// The colours of a square texture, or its single channel, mapped by `meaning`.
    pub(super) fn of_texture(
        texture: &Texture,
        channels: Channels,
        meaning: impl Fn(f32) -> f32,
    ) -> Self {
        let side = texture.size().width;
        let channels = channels.count();
        let has_color = texture.channels().has_color();
        let mut values = Vec::with_capacity(texture.size().texels() * channels);
        for channel in 0..channels {
            // Greyscale pictures have all colours in one channel.
            let channel = if has_color { channel } else { 0 };
            for y in 0..side {
                values.extend((0..side).map(|x| meaning(texture.get(x, y, channel))));
            }
        }
        Self { values, channels, side: side as usize, upright: Upright::Yes }
    }

    /// A texture of `size` × `size` texels of 32-bit floats: the planes interpolated linearly at
    /// texel centres and mapped by `finish`.
    pub(super) fn texture(
        &self,
        size: u32,
        finish: impl Fn(f32) -> f32,
    ) -> Result<Texture, TextureError> {
        let square = Size::square(size);
        if size == 0 {
            return Err(TextureError::Empty(square));
        }
        if size > Texture::MAX_SIDE {
            return Err(TextureError::TooLarge(square));
        }
        let mut texels = Vec::new();
        let reserved = texels.try_reserve_exact(square.texels().saturating_mul(self.channels));
        reserved.map_err(|_| TextureError::Memory(square))?;
        let columns: Vec<Between> = positions(size, self.side).collect();
        let mut rows = columns.clone();
        if self.upright == Upright::No {
            rows.reverse();
        }
        for row in rows {
            for column in &columns {
                for plane in self.values.chunks_exact(self.side * self.side) {
                    let along = |row: usize| {
                        let row = &plane[row * self.side..][..self.side];
                        mixed(row[column.first], row[column.second], column.fraction)
                    };
                    texels.push(finish(mixed(along(row.first), along(row.second), row.fraction)));
                }
            }
        }
        let (channels, encoding) = match self.channels {
            1 => (Channels::Grey, Encoding::Data),
            _ => (Channels::Rgb, Encoding::Srgb),
        };
        Texture::new(square, channels, encoding, Texels::F32(texels))
    }
}

fn mixed(first: f32, second: f32, fraction: f32) -> f32 {
    first + (second - first) * fraction
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A linear ramp over u and v, counted from the top.
    fn ramp(side: usize, upright: Upright) -> Planes {
        let at = |index: usize| index as f32 / (side - 1) as f32;
        let across = (0..side * side).map(|index| at(index % side));
        let down = (0..side * side).map(|index| match upright {
            Upright::Yes => at(index / side),
            Upright::No => 1.0 - at(index / side),
        });
        let level = std::iter::repeat_n(0.25, side * side);
        Planes { values: across.chain(down).chain(level).collect(), channels: 3, side, upright }
    }

    #[test]
    fn a_ramp_has_at_each_centre_what_belongs_there() {
        for (side, size) in [(8, 8), (8, 4), (8, 31), (512, 512), (2, 16), (512, 1024)] {
            for upright in [Upright::Yes, Upright::No] {
                let texture = ramp(side, upright).texture(size, |value| value).unwrap();
                for at in 0..size {
                    let centre = (at as f32 + 0.5) / size as f32;
                    let found = [texture.get(at, 0, 0), texture.get(0, at, 1)];
                    // A few rounding errors of values around 1.
                    let far = found.map(|value| (value - centre).abs());
                    assert!(far.iter().all(|&far| far < 1e-6), "{side} {size} {at}: {found:?}");
                    assert_eq!(texture.get(at, size - 1, 2), 0.25);
                }
            }
        }
    }

    #[test]
    fn one_value_is_everywhere_and_no_size_is_none() {
        let one = Planes { values: vec![0.5], channels: 1, side: 1, upright: Upright::No };
        let texture = one.texture(3, |value| value * 2.0).unwrap();
        assert_eq!(texture.texels(), &Texels::F32(vec![1.0; 9]));
        assert_eq!(texture.encoding(), Encoding::Data);
        assert!(one.texture(0, |value| value).is_err());
        assert!(one.texture(Texture::MAX_SIDE + 1, |value| value).is_err());
    }
}
