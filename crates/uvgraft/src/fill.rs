//! Fills the unknown areas of a texture from a mean texture in the same layout: most face textures
//! made from photographs have no data for the back of the head.

use uvgraft_surface::threads::for_each_chunk;

use crate::color::Encoding;
use crate::filter::Filter;
use crate::formats::Averaging;
use crate::texture::{Channels, Depth, Size, Texels, TexelsMut, Texture, TextureError, Value};

/// Texels per parallel task.
const CHUNK: usize = 1 << 14;

/// Why a texture was not filled.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FillError {
    /// Two textures of one layout may differ in size, but not in aspect ratio.
    #[error("{what} must have the aspect ratio of the source, which is {wanted}, got {found}")]
    Shape {
        /// `"the confidence mask"` or `"the mean texture"`.
        what: &'static str,
        /// Its size.
        found: Size,
        /// The source's size.
        wanted: Size,
    },
    /// A texture of data has no alpha channel.
    #[error("a confidence mask must be used with a colour source, got data")]
    Data,
    /// The mean texture or the mask could not be resized, or the result not be made.
    #[error(transparent)]
    Texture(#[from] TextureError),
}

/// Blends a texture over a mean texture, weighted by how well each texel is known: its alpha times
/// a confidence mask.
///
/// - `source`: the texture to fill. In [`Encoding::Data`] no channel is alpha, and all channels are
///   blended.
/// - `confidence`: grey, 1.0 for certain texels; any size with the source's aspect ratio, resized
///   bilinearly. Colours are reduced to their Rec. 709 grey, alpha is ignored, and NaN is 0.
/// - `mean`: any size with the source's aspect ratio, any format. It is resized with the default
///   filter of transfers and converted to the source's encoding, colour or grey, and depth.
///
/// The result has the source's size, depth and encoding. It has alpha only if `mean` has; the
/// source is then composited over `mean`. With the weight `c` of a texel, encoded values are
/// `c · source + (1 − c) · mean`, rounded to nearest; `c = 1` keeps the source and `c = 0` the mean
/// bit for bit.
///
/// # Errors
/// [`FillError::Shape`] if aspect ratios differ by more than rounding the sides to whole texels
/// explains; [`FillError::Texture`] if there is not enough memory to resize.
pub fn fill(
    source: Texture,
    confidence: Option<&Texture>,
    mean: &Texture,
) -> Result<Texture, FillError> {
    let (size, encoding, from) = (source.size(), source.encoding(), source.channels());
    let confidence = confidence.map(|mask| resized_mask(mask, size)).transpose()?;
    check_shape("the mean texture", mean.size(), size)?;
    let is_data = encoding == Encoding::Data;
    let to = if is_data {
        from
    } else if mean.channels().has_alpha() {
        from.with_alpha()
    } else {
        from.without_alpha()
    };
    let mean = mean
        .clone()
        .encoded_as(encoding)
        .resized(size, Filter::default(), Averaging::Encoded)?
        .converted(to, source.depth());
    let layout = TexelLayout {
        source: from.count(),
        result: to.count(),
        source_alpha: from.has_alpha() && !is_data,
        result_alpha: to.has_alpha() && !is_data,
    };
    let confidence = confidence.as_deref();
    let texels = match (source.into_texels(), mean.into_texels()) {
        (Texels::U8(source), Texels::U8(mean)) => Texels::U8(layout.mix(&source, confidence, mean)),
        (Texels::U16(source), Texels::U16(mean)) => {
            Texels::U16(layout.mix(&source, confidence, mean))
        }
        (Texels::F32(source), Texels::F32(mean)) => {
            Texels::F32(layout.mix(&source, confidence, mean))
        }
        _ => unreachable!("the mean was converted to the source's depth"),
    };
    Ok(Texture::new(size, to, encoding, texels)?)
}

/// Multiplies a texture's alpha by a confidence mask; a texture without alpha gets one.
///
/// - `mask`: as `confidence` in [`fill`].
///
/// # Errors
/// [`FillError::Shape`] and [`FillError::Texture`] as in [`fill`], [`FillError::Data`] if the
/// source is data.
pub fn with_confidence(source: Texture, mask: &Texture) -> Result<Texture, FillError> {
    fn multiply<T: Value>(values: &mut [T], channels: usize, mask: &[f32]) {
        for_each_chunk(values, CHUNK * channels, |chunk, values| {
            let mask = &mask[chunk * CHUNK..];
            for (texel, &share) in values.chunks_exact_mut(channels).zip(mask) {
                let alpha = &mut texel[channels - 1];
                *alpha = T::from_level(alpha.to_level() * share);
            }
        });
    }
    if source.encoding() == Encoding::Data {
        return Err(FillError::Data);
    }
    let mask = resized_mask(mask, source.size())?;
    let channels = source.channels().with_alpha();
    let depth = source.depth();
    let mut texture = source.converted(channels, depth);
    match texture.texels_mut() {
        TexelsMut::U8(values) => multiply(values, channels.count(), &mask),
        TexelsMut::U16(values) => multiply(values, channels.count(), &mask),
        TexelsMut::F32(values) => multiply(values, channels.count(), &mask),
    }
    Ok(texture)
}

/// The mask resized to `size`: one value in `0.0..=1.0` for each texel.
fn resized_mask(mask: &Texture, size: Size) -> Result<Vec<f32>, FillError> {
    /// More than the rounding error of a sum of weights; certain texels stay exactly 0 or 1.
    const ROUNDING: f32 = 1e-6;
    check_shape("the confidence mask", mask.size(), size)?;
    let is_resized = mask.size() != size;
    let mut mask = mask.clone().converted(Channels::Grey, Depth::F32).with_encoding(Encoding::Data);
    // Clamp before resizing: one NaN would spoil all texels around it.
    map_values(&mut mask, unit);
    let mut mask = mask.resized(size, Filter::Bilinear, Averaging::Encoded)?;
    if is_resized {
        map_values(&mut mask, |value| match value {
            value if value < ROUNDING => 0.0,
            value if value > 1.0 - ROUNDING => 1.0,
            value => value,
        });
    }
    let Texels::F32(values) = mask.into_texels() else { unreachable!("it was made float") };
    Ok(values)
}

/// Maps each value of a float texture.
fn map_values(texture: &mut Texture, by: impl Fn(f32) -> f32 + Send + Sync) {
    if let TexelsMut::F32(values) = texture.texels_mut() {
        for_each_chunk(values, CHUNK, |_, values| {
            values.iter_mut().for_each(|value| *value = by(*value));
        });
    }
}

/// Clamped to `0.0..=1.0`; NaN is 0.
fn unit(value: f32) -> f32 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

/// Checks that two sizes have the same aspect ratio.
fn check_shape(what: &'static str, found: Size, wanted: Size) -> Result<(), FillError> {
    if found.has_aspect_ratio_of(wanted) {
        Ok(())
    } else {
        Err(FillError::Shape { what, found, wanted })
    }
}

/// Values in a texel of the source and of the result, and whether their last one is alpha.
#[derive(Clone, Copy)]
struct TexelLayout {
    source: usize,
    result: usize,
    source_alpha: bool,
    result_alpha: bool,
}

impl TexelLayout {
    /// Composites the source over the mean, which already has the result's channels.
    fn mix<T: Value>(self, source: &[T], confidence: Option<&[f32]>, mut mean: Vec<T>) -> Vec<T> {
        for_each_chunk(&mut mean, CHUNK * self.result, |chunk, mean| {
            let first = chunk * CHUNK;
            let sources = source[first * self.source..].chunks_exact(self.source);
            for (index, (texel, source)) in
                mean.chunks_exact_mut(self.result).zip(sources).enumerate()
            {
                let confidence = confidence.map_or(1.0, |values| values[first + index]);
                self.mix_texel(source, confidence, texel);
            }
        });
        mean
    }

    /// Source-over compositing (Porter and Duff 1984) of values that are not premultiplied, with
    /// the source's alpha times its confidence. The weights 0 and 1 copy values, to keep them
    /// bit-exact.
    #[inline(always)]
    fn mix_texel<T: Value>(self, source: &[T], confidence: f32, texel: &mut [T]) {
        let opacity = if self.source_alpha { unit(source[self.source - 1].to_unit()) } else { 1.0 };
        let known = opacity * confidence;
        if known == 0.0 {
            return;
        }
        let colors = self.result - usize::from(self.result_alpha);
        let (colors, alpha) = texel.split_at_mut(colors);
        if known == 1.0 {
            colors.copy_from_slice(&source[..colors.len()]);
            alpha.fill(T::ONE);
            return;
        }
        let mut share = known;
        if let [alpha] = alpha {
            let covered = known + (1.0 - known) * unit(alpha.to_unit());
            share = known / covered;
            *alpha = T::from_unit(covered);
        }
        for (color, &source) in colors.iter_mut().zip(source) {
            *color = T::from_level(share * source.to_level() + (1.0 - share) * color.to_level());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(channels: Channels, values: Vec<u8>) -> Texture {
        let size = Size::new((values.len() / channels.count()) as u32, 1);
        Texture::new(size, channels, Encoding::Srgb, Texels::U8(values)).unwrap()
    }

    fn grey(values: &[u8]) -> Texture {
        row(Channels::Grey, values.to_vec())
    }

    #[test]
    fn bytes_blend_by_alpha_and_confidence() {
        let source = row(
            Channels::Rgba,
            [[10, 20, 30, 255], [10, 20, 30, 0], [200, 100, 0, 51], [200, 100, 0, 255]].concat(),
        );
        let mean = row(Channels::Rgb, [[100, 50, 251]; 4].concat());
        let filled = fill(source.clone(), None, &mean).unwrap();
        // 20 % of 200 and 80 % of 100 are 120; 20 + 40; 0 + 200.8.
        let wanted = [[10, 20, 30], [100, 50, 251], [120, 60, 201], [200, 100, 0]].concat();
        assert_eq!(filled, row(Channels::Rgb, wanted));
        let mask = grey(&[255, 255, 127, 0]);
        let filled = fill(source, Some(&mask), &mean).unwrap();
        // 0.2 · 127/255 = 0.0996: 109.96, 54.98, 226.0002.
        let wanted = [[10, 20, 30], [100, 50, 251], [110, 55, 226], [100, 50, 251]].concat();
        assert_eq!(filled, row(Channels::Rgb, wanted));
    }

    #[test]
    fn other_depths_keep_their_values() {
        let size = Size::new(3, 1);
        let source = Texels::U16(vec![1, 65_535, 40_000, 0, 40_000, 13_107]);
        let source = Texture::new(size, Channels::GreyAlpha, Encoding::Srgb, source).unwrap();
        let mean = row(Channels::Rgb, vec![100; 9]);
        let filled = fill(source, None, &mean).unwrap();
        // 100 of 255 is 25,700 of 65,535; 20 % of 40,000 and 80 % of 25,700 are 28,560.
        assert_eq!(*filled.texels(), Texels::U16(vec![1, 25_700, 28_560]));
        assert_eq!(filled.channels(), Channels::Grey);

        let source = Texels::F32(vec![f32::NAN, 0.0, 8.0, 0.25, -0.1, 1.0]);
        let source = Texture::new(size, Channels::GreyAlpha, Encoding::Linear, source).unwrap();
        let mean = Texels::F32(vec![2.0, 4.0, 5.0]);
        let mean = Texture::new(size, Channels::Grey, Encoding::Linear, mean).unwrap();
        let filled = fill(source, None, &mean).unwrap();
        assert_eq!(*filled.texels(), Texels::F32(vec![2.0, 5.0, -0.1]));
    }

    #[test]
    fn the_mean_is_converted_to_the_source_format() {
        let source = row(Channels::Rgba, [[1, 2, 3, 255], [0, 0, 0, 0]].concat().repeat(8));
        let source = {
            let texels = source.into_texels();
            Texture::new(Size::square(4), Channels::Rgba, Encoding::Srgb, texels).unwrap()
        };
        // Linear 0.6038273 is 0.8 in sRGB, which is 204 of 255.
        let mean = Texture::filled(
            Size::square(9),
            Channels::Grey,
            Encoding::Linear,
            Depth::F32,
            &[0.603_827_3],
        );
        let filled = fill(source, None, &mean.unwrap()).unwrap();
        let wanted = Texels::U8([[1, 2, 3], [204, 204, 204]].concat().repeat(8));
        assert_eq!((filled.texels(), filled.encoding()), (&wanted, Encoding::Srgb));
    }

    #[test]
    fn a_mean_with_alpha_lies_beneath() {
        let source = row(Channels::GreyAlpha, vec![200, 255, 200, 0, 200, 51, 200, 51]);
        let mean = row(Channels::GreyAlpha, vec![9, 7, 9, 7, 50, 0, 50, 51]);
        let filled = fill(source, None, &mean).unwrap();
        // 0.2 over 0 is all source; 0.2 over 0.2 covers 0.36, five ninths of it source: 200 · 5/9 +
        // 50 · 4/9 = 133.3.
        let wanted = vec![200, 255, 9, 7, 200, 51, 133, 92];
        assert_eq!(filled, row(Channels::GreyAlpha, wanted));
    }

    #[test]
    fn all_channels_of_data_are_values() {
        let data = |values| row(Channels::Rgba, values).with_encoding(Encoding::Data);
        let source = data(vec![10, 20, 30, 0, 10, 20, 30, 40]);
        let mean = row(Channels::Rgb, vec![110, 120, 130, 0, 0, 0]);
        assert_eq!(fill(source.clone(), None, &mean), Ok(source.clone()));
        let filled = fill(source.clone(), Some(&grey(&[51, 255])), &mean).unwrap();
        assert_eq!(filled, data(vec![90, 100, 110, 204, 10, 20, 30, 40]));
        assert_eq!(with_confidence(source, &grey(&[0, 0])), Err(FillError::Data));
    }

    #[test]
    fn confidence_lowers_alpha() {
        let mask = grey(&[255, 0, 51]);
        let opaque = with_confidence(grey(&[9, 8, 7]), &mask).unwrap();
        assert_eq!(opaque, row(Channels::GreyAlpha, vec![9, 255, 8, 0, 7, 51]));
        let source = row(Channels::Rgba, [[1, 2, 3, 100]; 3].concat());
        let lower = with_confidence(source, &mask).unwrap();
        let wanted = [[1, 2, 3, 100], [1, 2, 3, 0], [1, 2, 3, 20]].concat();
        assert_eq!(lower, row(Channels::Rgba, wanted));
        let size = Size::new(2, 1);
        let source = Texture::new(size, Channels::Grey, Encoding::Srgb, Texels::U16(vec![5, 6]));
        let mask = Texels::F32(vec![f32::NAN, 1.5]);
        let mask = Texture::new(size, Channels::Grey, Encoding::Linear, mask).unwrap();
        let lower = with_confidence(source.unwrap(), &mask).unwrap();
        assert_eq!(*lower.texels(), Texels::U16(vec![5, 0, 6, 65_535]));
    }

    #[test]
    fn masks_of_other_sizes_are_resized_bilinearly() {
        let side = 64;
        let filled = |size, value: f32| {
            Texture::filled(size, Channels::Grey, Encoding::Srgb, Depth::F32, &[value]).unwrap()
        };
        let mask = Texture::new(
            Size::new(2, 2),
            Channels::Grey,
            Encoding::Srgb,
            Texels::U8(vec![0, 255, 0, 255]),
        );
        let size = Size::square(side);
        let mixed = fill(filled(size, 1.0), Some(&mask.unwrap()), &filled(size, 0.0)).unwrap();
        for x in 0..side {
            // Constant up to the centres of the mask's texels, linear between them.
            let wanted = ((x as f32 + 0.5) / 32.0 - 0.5).clamp(0.0, 1.0);
            // Positions are rounded to 2⁻³² texels, values to 24 bits.
            assert!((mixed.get(x, 40, 0) - wanted).abs() < 1e-6, "{x}");
        }
    }

    #[test]
    fn certain_texels_stay_bit_exact() {
        let size = Size::new(30, 17);
        let values: Vec<f32> = (0..size.texels()).map(|k| (k as f32).sqrt()).collect();
        let texels = Texels::F32(values.clone());
        let source = Texture::new(size, Channels::Grey, Encoding::Linear, texels).unwrap();
        let mean = || Texture::filled(size, Channels::Grey, Encoding::Linear, Depth::U8, &[0.5]);
        for side in [1, 3, 100] {
            let mask_size = Size::new(30 * side, 17 * side);
            for (known, wanted) in [(1.0, &values), (0.0, &vec![128.0 / 255.0; size.texels()])] {
                let mask = Texture::filled(
                    mask_size,
                    Channels::Grey,
                    Encoding::Data,
                    Depth::F32,
                    &[known],
                );
                let filled = fill(source.clone(), Some(&mask.unwrap()), &mean().unwrap()).unwrap();
                assert_eq!(*filled.texels(), Texels::F32(wanted.clone()), "{side} {known}");
            }
        }
    }

    #[test]
    fn other_aspect_ratios_are_refused() {
        let sized = |width, height| {
            let size = Size::new(width, height);
            Texture::filled(size, Channels::Grey, Encoding::Srgb, Depth::U8, &[0.5]).unwrap()
        };
        let refused = fill(sized(64, 64), None, &sized(64, 32)).unwrap_err().to_string();
        assert_eq!(
            refused,
            "the mean texture must have the aspect ratio of the source, which is 64×64, got 64×32"
        );
        let refused = fill(sized(64, 64), Some(&sized(8, 16)), &sized(8, 8)).unwrap_err();
        assert!(refused.to_string().starts_with("the confidence mask must have"));
        assert!(with_confidence(sized(30, 10), &sized(30, 30)).is_err());
        // A third of 1000 is not a whole number.
        assert!(fill(sized(1000, 333), Some(&sized(300, 100)), &sized(3, 1)).is_ok());
    }

    #[test]
    #[cfg_attr(target_family = "wasm", ignore = "starts threads")]
    fn results_do_not_depend_on_threads() {
        let mut rng = fastrand::Rng::with_seed(4);
        let size = Size::new(311, 207);
        let mut noise = |channels: Channels| {
            let values = (0..size.texels() * channels.count()).map(|_| rng.u8(..)).collect();
            Texture::new(size, channels, Encoding::Srgb, Texels::U8(values)).unwrap()
        };
        let [source, mask, mean] = [Channels::Rgba, Channels::Grey, Channels::Rgba].map(&mut noise);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| fill(source.clone(), Some(&mask), &mean).unwrap())
        };
        let [one, four] = [with(1), with(4)];
        assert!(one == four);
        // The last texel is blended with its own confidence, wherever its chunk starts.
        let known = source.get(310, 206, 3) * mask.get(310, 206, 0);
        let alpha = known + (1.0 - known) * mean.get(310, 206, 3);
        assert!((one.get(310, 206, 3) - alpha).abs() < 0.51 / 255.0);
    }
}
