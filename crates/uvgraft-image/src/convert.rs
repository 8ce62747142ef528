//! Converts the values of a texture to those that a format stores: depth, transfer function, alpha.

use std::borrow::Cow;
use std::ops::Range;

use uvgraft::color::{Encoding, linear_from_srgb, srgb_from_linear};
use uvgraft::texture::{Channels, Depth, Texels, Value};

use super::{Format, Loss, TextureSpec};

type Transfer = fn(f32) -> f32;

/// The conversion of textures of one format to stored values of depth `T`.
pub struct Conversion<T> {
    channels: Channels,
    curve: TransferCurve<T>,
    losses: Vec<Loss>,
    clamped: bool,
}

/// Tables, because transfer functions take a power: 256 or 65,536 evaluations instead of millions.
enum TransferCurve<T> {
    Same,
    Table { color: Vec<T>, alpha: Vec<T> },
    Curve(SrgbCurve),
    Function(Transfer),
}

impl<T: AtDepth> Conversion<T> {
    /// A conversion to what a format stores at this depth. Drops a profile that will no longer apply.
    pub fn new(spec: &TextureSpec, format: Format, icc: &mut Option<&[u8]>) -> Self {
        let (from, to) = (spec.depth, T::DEPTH);
        let mut losses = Vec::new();
        if to < from {
            losses.push(Loss::Precision { from, to });
        }
        let transfer = match (spec.encoding, format.codec().encoding(to)) {
            (Encoding::Linear, Encoding::Srgb) => Some(srgb_from_linear as Transfer),
            (Encoding::Srgb, Encoding::Linear) => Some(linear_from_srgb as Transfer),
            _ => None,
        };
        if transfer.is_some() && icc.take().is_some() {
            losses.push(Loss::IccOutdated);
        }
        let color = transfer.unwrap_or(|value| value);
        let curve = match from {
            _ if transfer.is_none() && from == to => TransferCurve::Same,
            Depth::U8 => TransferCurve::table((0..=u8::MAX).map(Value::to_unit), color),
            Depth::U16 => TransferCurve::table((0..=u16::MAX).map(Value::to_unit), color),
            // Integers are always stored as sRGB, so the conversion is to sRGB.
            Depth::F32 if transfer.is_some() && to != Depth::F32 => {
                TransferCurve::Curve(SrgbCurve::new())
            }
            Depth::F32 => TransferCurve::Function(color),
        };
        Self { channels: spec.channels, curve, losses, clamped: false }
    }

    /// Converts a range of whole texels; borrowed if nothing changes.
    pub fn apply<'a>(&mut self, texels: &'a Texels, range: Range<usize>) -> Cow<'a, [T]> {
        if let (TransferCurve::Same, Some(values)) = (&self.curve, T::borrowed(texels)) {
            return Cow::Borrowed(&values[range]);
        }
        let channels = self.channels;
        Cow::Owned(match (texels, &self.curve) {
            (Texels::U8(values), TransferCurve::Table { color, alpha }) => {
                let values = &values[range];
                map(values, channels, |v| color[usize::from(v)], |v| alpha[usize::from(v)])
            }
            (Texels::U16(values), TransferCurve::Table { color, alpha }) => {
                let values = &values[range];
                map(values, channels, |v| color[usize::from(v)], |v| alpha[usize::from(v)])
            }
            (Texels::F32(values), curve) => {
                let values = &values[range];
                self.clamped |=
                    T::DEPTH != Depth::F32 && values.iter().any(|v| !(0.0..=1.0).contains(v));
                match curve {
                    TransferCurve::Curve(curve) => {
                        map(values, channels, |v| T::from_unit(curve.at(v)), T::from_unit)
                    }
                    TransferCurve::Function(color) => {
                        map(values, channels, |v| T::from_unit(color(v)), T::from_unit)
                    }
                    TransferCurve::Same | TransferCurve::Table { .. } => {
                        unreachable!("made for float")
                    }
                }
            }
            _ => unreachable!("made for this depth"),
        })
    }

    /// Whether values converted so far were clamped.
    pub(super) fn is_clamped(&self) -> bool {
        self.clamped
    }

    /// Notes that values were clamped that another conversion converted.
    pub(super) fn note_clamped(&mut self, clamped: bool) {
        self.clamped |= clamped;
    }

    /// The losses of the values converted so far.
    pub fn losses(self) -> Vec<Loss> {
        let mut losses = self.losses;
        losses.extend(self.clamped.then_some(Loss::Range));
        losses
    }
}

impl<T: Value> TransferCurve<T> {
    fn table(units: impl Iterator<Item = f32> + Clone, color: Transfer) -> Self {
        Self::Table {
            color: units.clone().map(|unit| T::from_unit(color(unit))).collect(),
            alpha: units.map(T::from_unit).collect(),
        }
    }
}

/// A value type with its depth, and access to texels of that type.
pub trait AtDepth: Value {
    /// The depth.
    const DEPTH: Depth;
    /// The values of texels of this depth; `None` for others.
    fn borrowed(texels: &Texels) -> Option<&[Self]>;
}

impl AtDepth for u8 {
    const DEPTH: Depth = Depth::U8;
    fn borrowed(texels: &Texels) -> Option<&[Self]> {
        if let Texels::U8(values) = texels { Some(values) } else { None }
    }
}

impl AtDepth for u16 {
    const DEPTH: Depth = Depth::U16;
    fn borrowed(texels: &Texels) -> Option<&[Self]> {
        if let Texels::U16(values) = texels { Some(values) } else { None }
    }
}

impl AtDepth for f32 {
    const DEPTH: Depth = Depth::F32;
    fn borrowed(texels: &Texels) -> Option<&[Self]> {
        if let Texels::F32(values) = texels { Some(values) } else { None }
    }
}

/// [`srgb_from_linear`] in `0.0..=1.0`, approximated by 256 linear segments per octave, clamped
/// outside. The error is below 1e-6, a fifteenth of a 16-bit level, and it is several times as
/// fast.
pub(super) struct SrgbCurve {
    /// Intercept and slope of each segment, from [`SrgbCurve::START`] on.
    pieces: Vec<(f32, f32)>,
}

impl SrgbCurve {
    /// 2⁻⁹. Below, the curve is linear through 0.
    const START: f32 = 1.0 / 512.0;
    /// Bits of a float that vary within a segment.
    const FREE_BITS: u32 = 15;

    pub(super) fn new() -> Self {
        let first = Self::START.to_bits() >> Self::FREE_BITS;
        let end = 1f32.to_bits() >> Self::FREE_BITS;
        let piece = |index: u32| {
            let [x0, x1] = [index, index + 1].map(|index| f32::from_bits(index << Self::FREE_BITS));
            let slope = (srgb_from_linear(x1) - srgb_from_linear(x0)) / (x1 - x0);
            (srgb_from_linear(x0) - x0 * slope, slope)
        };
        Self { pieces: (first..end).map(piece).collect() }
    }

    pub(super) fn at(&self, linear: f32) -> f32 {
        let first = (Self::START.to_bits() >> Self::FREE_BITS) as usize;
        if linear >= 1.0 {
            1.0
        } else if linear >= Self::START {
            let (offset, slope) =
                self.pieces[(linear.to_bits() >> Self::FREE_BITS) as usize - first];
            offset + linear * slope
        } else {
            // NaN also ends here, and stays NaN.
            linear * 12.92
        }
    }
}

fn map<S: Copy, T>(
    values: &[S],
    channels: Channels,
    color: impl Fn(S) -> T,
    alpha: impl Fn(S) -> T,
) -> Vec<T> {
    if !channels.has_alpha() {
        return values.iter().map(|&value| color(value)).collect();
    }
    let mut mapped = Vec::with_capacity(values.len());
    for texel in values.chunks_exact(channels.count()) {
        if let Some((&opacity, colors)) = texel.split_last() {
            mapped.extend(colors.iter().map(|&value| color(value)));
            mapped.push(alpha(opacity));
        }
    }
    mapped
}

/// Premultiplies colours by alpha. Returns whether a colour was lost to an alpha of 0.
///
/// - `keeps_light`: whether colours stay where alpha is 0.
#[cfg(feature = "exr")]
pub(super) fn premultiply(values: &mut [f32], channels: Channels, keeps_light: bool) -> bool {
    let mut lost = false;
    for texel in values.chunks_exact_mut(channels.count()) {
        if let Some((&mut alpha, colors)) = texel.split_last_mut()
            && !(keeps_light && alpha == 0.0)
        {
            lost |= alpha == 0.0 && colors.iter().any(|&color| color != 0.0);
            colors.iter_mut().for_each(|color| *color *= alpha);
        }
    }
    lost
}

/// Divides colours by alpha. Where alpha is 0 they are kept: such texels add light without
/// coverage, and the original colour is unknown.
#[cfg(any(feature = "exr", feature = "tiff"))]
pub(super) fn unpremultiply<T: Value>(values: &mut [T], channels: Channels) {
    for texel in values.chunks_exact_mut(channels.count()) {
        if let Some((&mut alpha, colors)) = texel.split_last_mut()
            && alpha != T::default()
            && alpha != T::ONE
        {
            let opacity = alpha.to_unit();
            colors.iter_mut().for_each(|color| *color = T::from_unit(color.to_unit() / opacity));
        }
    }
}

#[cfg(test)]
mod tests {
    use uvgraft::texture::{Size, Texture};

    use super::*;

    fn texture(channels: Channels, encoding: Encoding, texels: Texels) -> Texture {
        let size = Size::new((texels.len() / channels.count()) as u32, 1);
        Texture::new(size, channels, encoding, texels).unwrap()
    }

    fn stored<T: AtDepth>(texture: &Texture, format: Format) -> (Vec<T>, Vec<Loss>) {
        let (spec, texels) = (TextureSpec::from(texture), texture.texels());
        let mut conversion = Conversion::new(&spec, format, &mut Some(b"profile"));
        let values = conversion.apply(texels, 0..texels.len()).into_owned();
        (values, conversion.losses())
    }

    #[test]
    fn every_16_bit_value_rounds_to_the_nearest_of_8_bits() {
        let texture = texture(
            Channels::Grey,
            Encoding::Srgb,
            Texels::U16((0..32_768).map(|value| value * 2).collect()),
        );
        let (even, losses) = stored::<u8>(&texture, Format::WEBP);
        for (value, found) in (0..65_536).step_by(2).zip(even) {
            assert_eq!(u32::from(found), (value * 255 + 32_767) / 65_535);
        }
        assert_eq!(losses, [Loss::Precision { from: Depth::U16, to: Depth::U8 }]);
    }

    #[test]
    fn linear_light_is_encoded_clamped_and_alpha_left_alone() {
        let texels = Texels::F32(vec![0.215, 0.5, 2.0, 0.25, -1.0, f32::NAN]);
        let texture = texture(Channels::GreyAlpha, Encoding::Linear, texels);
        let (values, losses) = stored::<u8>(&texture, Format::WEBP);
        assert_eq!(values, [128, 128, 255, 64, 0, 0]);
        let rounded = Loss::Precision { from: Depth::F32, to: Depth::U8 };
        assert_eq!(losses, [rounded, Loss::IccOutdated, Loss::Range]);
    }

    #[test]
    fn the_curve_in_pieces_is_the_curve() {
        let curve = SrgbCurve::new();
        for step in 0..=1_000_000u32 {
            let linear = step as f32 / 1e6;
            assert!((curve.at(linear) - srgb_from_linear(linear)).abs() < 1e-6, "{linear}");
        }
        for level in 0..=u16::MAX {
            assert_eq!(u16::from_unit(curve.at(linear_from_srgb(level.to_unit()))), level);
        }
        assert_eq!(u8::from_unit(curve.at(f32::NEG_INFINITY)), 0);
        assert_eq!(u8::from_unit(curve.at(f32::INFINITY)), 255);
    }

    #[cfg(feature = "exr")]
    #[test]
    fn data_is_never_converted() {
        let texture = texture(Channels::Rgb, Encoding::Data, Texels::U8(vec![0, 51, 255]));
        assert_eq!(stored::<f32>(&texture, Format::EXR), (vec![0.0, 0.2, 1.0], vec![]));
    }

    #[cfg(feature = "exr")]
    #[test]
    fn premultiplying_is_undone_except_under_full_transparency() {
        let mut values = [0.5, 0.25, 1.0, 0.0, 3.0, 1.0];
        let mut light = values;
        assert!(!premultiply(&mut light, Channels::GreyAlpha, true));
        assert_eq!(light, [0.125, 0.25, 1.0, 0.0, 3.0, 1.0]);
        assert!(premultiply(&mut values, Channels::GreyAlpha, false));
        assert_eq!(values, [0.125, 0.25, 0.0, 0.0, 3.0, 1.0]);
        unpremultiply(&mut values, Channels::GreyAlpha);
        assert_eq!(values, [0.5, 0.25, 0.0, 0.0, 3.0, 1.0]);
        let mut bytes = [100u8, 200, 30, 0];
        unpremultiply(&mut bytes, Channels::GreyAlpha);
        assert_eq!(bytes, [128, 200, 30, 0]);
    }
}
