//! NaNs and infinities in float textures. Filters must never see them: one such value spoils the
//! result of every filter window that contains it.

use uvgraft_surface::threads::map_indices;

use crate::color::Encoding;
use crate::texture::{Channels, Depth, Size, Texels, Texture};

/// Texels per parallel task.
const CHUNK: usize = 1 << 14;

impl Texture {
    /// How many texels have a NaN or an infinity in any channel.
    pub fn non_finite(&self) -> usize {
        let Texels::F32(values) = self.texels() else { return 0 };
        let texels = values.chunks_exact(self.channels().count());
        texels.filter(|texel| !texel.iter().all(|value| value.is_finite())).count()
    }

    /// Replaces unknown texels, those with a NaN or an infinity in any channel, and returns how
    /// many there were. Integer textures and finite ones are returned unchanged.
    ///
    /// Unknown colours become black with alpha 0, so that the base shows there; a texture without
    /// alpha gets one. In [`Encoding::Data`] no channel is alpha: an unknown texel takes the value
    /// of a nearest known one (distance in steps between 4-neighbours), or 0 if no texel is known.
    #[must_use]
    pub fn without_non_finite(self) -> (Self, usize) {
        let Texels::F32(values) = self.texels() else { return (self, 0) };
        let channels = self.channels().count();
        let is_unknown = |texel: &[f32]| !texel.iter().all(|value| value.is_finite());
        let chunks = map_indices(values.len().div_ceil(CHUNK * channels), |chunk| {
            let values = &values[chunk * CHUNK * channels..];
            let texels = values.chunks_exact(channels).take(CHUNK).enumerate();
            let unknown = texels.filter(|(_, texel)| is_unknown(texel));
            unknown.map(|(index, _)| chunk * CHUNK + index).collect::<Vec<usize>>()
        });
        let unknown = chunks.concat();
        if unknown.is_empty() {
            return (self, 0);
        }
        let (size, encoding, count) = (self.size(), self.encoding(), unknown.len());
        let is_data = encoding == Encoding::Data;
        let channels = if is_data { self.channels() } else { self.channels().with_alpha() };
        let texture = self.converted(channels, Depth::F32);
        let Texels::F32(mut values) = texture.into_texels() else { unreachable!("it is float") };
        for &texel in &unknown {
            values[texel * channels.count()..][..channels.count()].fill(0.0);
        }
        if is_data {
            spread(&mut values, channels, size, unknown);
        }
        let texture = Self::new(size, channels, encoding, Texels::F32(values));
        (texture.expect("size and channels are those of a texture"), count)
    }
}

/// Copies known values into unknown texels, from the boundary of each hole inwards: a breadth-first
/// flood fill, in which each round fills the unknown texels with a known 4-neighbour. A round reads
/// only texels that were known before it, so the order within a round does not matter.
///
/// - `unknown`: in ascending order; values already 0.
fn spread(values: &mut [f32], channels: Channels, size: Size, mut unknown: Vec<usize>) {
    let (width, count) = (size.width as usize, channels.count());
    let mut is_unknown = vec![false; size.texels()];
    unknown.iter().for_each(|&texel| is_unknown[texel] = true);
    let neighbours = |texel: usize| {
        let (x, y) = (texel % width, texel / width);
        [
            (x > 0).then(|| texel - 1),
            (x + 1 < width).then_some(texel + 1),
            (y > 0).then(|| texel - width),
            (y + 1 < size.height as usize).then_some(texel + width),
        ]
    };
    // The texels to fill in this round, each with the known neighbour that it copies.
    let mut front: Vec<(usize, usize)> = Vec::new();
    let known_neighbour = |is_unknown: &[bool], texel: usize| {
        neighbours(texel).into_iter().flatten().find(|&neighbour| !is_unknown[neighbour])
    };
    for &texel in &unknown {
        front.extend(known_neighbour(&is_unknown, texel).map(|neighbour| (texel, neighbour)));
    }
    unknown.clear();
    while !front.is_empty() {
        for &(texel, neighbour) in &front {
            values.copy_within(neighbour * count..(neighbour + 1) * count, texel * count);
            is_unknown[texel] = false;
        }
        let next = front.iter().flat_map(|&(texel, _)| neighbours(texel).into_iter().flatten());
        unknown.extend(next.filter(|&texel| is_unknown[texel]));
        unknown.sort_unstable();
        unknown.dedup();
        front.clear();
        for texel in unknown.drain(..) {
            front.extend(known_neighbour(&is_unknown, texel).map(|neighbour| (texel, neighbour)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAN: f32 = f32::NAN;

    fn texture(width: u32, channels: Channels, encoding: Encoding, values: &[f32]) -> Texture {
        let height = (values.len() / channels.count()) as u32 / width;
        let texels = Texels::F32(values.to_vec());
        Texture::new(Size::new(width, height), channels, encoding, texels).unwrap()
    }

    #[test]
    fn unknown_colours_become_transparent() {
        let values = [0.1, 0.2, 0.3, 0.4, NAN, 0.6, 0.7, f32::INFINITY, f32::NEG_INFINITY];
        let colors = texture(3, Channels::Rgb, Encoding::Linear, &values);
        let (cleared, count) = colors.without_non_finite();
        let wanted = [[0.1, 0.2, 0.3, 1.0], [0.0; 4], [0.0; 4]].concat();
        assert_eq!(cleared, texture(3, Channels::Rgba, Encoding::Linear, &wanted));
        assert_eq!(count, 2);
        let translucent = [0.5, 0.25, 0.5, NAN];
        let grey = texture(2, Channels::GreyAlpha, Encoding::Srgb, &translucent);
        let wanted = texture(2, Channels::GreyAlpha, Encoding::Srgb, &[0.5, 0.25, 0.0, 0.0]);
        assert_eq!(grey.without_non_finite(), (wanted, 1));
    }

    #[test]
    fn unknown_data_take_the_nearest_value() {
        let values = [1.0, NAN, NAN, NAN, 5.0, NAN, NAN, NAN, NAN, NAN];
        let data = texture(5, Channels::Grey, Encoding::Data, &values);
        let wanted = [1.0, 1.0, 1.0, 5.0, 5.0, 1.0, 1.0, 1.0, 5.0, 5.0];
        let wanted = texture(5, Channels::Grey, Encoding::Data, &wanted);
        assert_eq!(data.without_non_finite(), (wanted, 8));
        let nothing = texture(1, Channels::GreyAlpha, Encoding::Data, &[NAN, 0.5]);
        let zero = texture(1, Channels::GreyAlpha, Encoding::Data, &[0.0, 0.0]);
        assert_eq!(nothing.without_non_finite(), (zero, 1));
    }

    #[test]
    fn finite_textures_stay_unchanged() {
        let colors = texture(1, Channels::Rgb, Encoding::Srgb, &[f32::MAX, -3.0, 0.0]);
        assert_eq!(colors.clone().without_non_finite(), (colors, 0));
        let bytes =
            Texture::filled(Size::square(3), Channels::Grey, Encoding::Srgb, Depth::U8, &[0.5]);
        let bytes = bytes.unwrap();
        assert_eq!(bytes.clone().without_non_finite(), (bytes, 0));
    }
}
