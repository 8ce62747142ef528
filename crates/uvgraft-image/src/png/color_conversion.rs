//! Converts the values of a PNG in another colour space to sRGB, as viewers show them: values outside
//! of it are clipped.

use uvgraft::color::linear_from_srgb;
use uvgraft::texture::{Channels, Depth, Value};

use super::color_space::{ColorSpace, Transfer};
use crate::color_space::Matrix;
use crate::convert::SrgbCurve;

/// The luminance, in cd/m², of what becomes white: that of a white diffuser in HDR content, by
/// ITU-R BT.2408, section 2. Brighter highlights are clipped.
const WHITE: f64 = 203.0;

/// The peak luminance of the display that hybrid log-gamma is shown on, and the gamma that goes with
/// it: the nominal ones of ITU-R BT.2100, table 5. White is then at 75 % of the signal, as BT.2408 has it.
const HLG_PEAK: f64 = 1000.0;
const HLG_GAMMA: f64 = 1.2;

/// A conversion of texels of one depth.
pub(super) struct ColorConversion {
    channels: Channels,
    way: Way,
}

enum Way {
    /// The channels stay apart: the result for each stored value.
    Curve(Vec<u16>),
    Mixed(Box<Mix>),
}

/// A conversion that mixes channels.
struct Mix {
    /// Light of each stored value.
    linear: Vec<f32>,
    /// Luminances of the primaries, if the display's gamma depends on luminance.
    hlg: Option<[f32; 3]>,
    matrix: [[f32; 3]; 3],
    curve: SrgbCurve,
}

impl ColorConversion {
    /// `None` if values stay as they are.
    pub(super) fn new(space: &ColorSpace, channels: Channels, depth: Depth) -> Option<Self> {
        let largest = if depth == Depth::U16 { u16::MAX } else { u16::from(u8::MAX) };
        // Validated with the chunk; greys have no primaries.
        let matrix = space.primaries.to_srgb().ok()?.filter(|_| channels.has_color());
        if matrix.is_none() && space.transfer == Transfer::Srgb && !space.is_narrow {
            return None;
        }
        let light = (0..=largest).map(|value| space.light(f64::from(value) / f64::from(largest)));
        let way = if matrix.is_none() && (space.transfer != Transfer::Hlg || !channels.has_color())
        {
            let curve = SrgbCurve::new();
            let stored = |light: f64| {
                let shown = space.transfer.shown(light) as f32;
                (curve.at(shown) * f32::from(largest) + 0.5) as u16
            };
            Way::Curve(light.map(stored).collect())
        } else {
            let hlg = space.primaries.luminances().ok();
            let scale = if space.transfer == Transfer::Hlg { 1.0 } else { space.transfer.scale() };
            Way::Mixed(Box::new(Mix {
                linear: light.map(|light| (light * scale) as f32).collect(),
                hlg: hlg.filter(|_| space.transfer == Transfer::Hlg).map(|l| l.map(|l| l as f32)),
                matrix: matrix.unwrap_or(IDENTITY).map(|row| row.map(|value| value as f32)),
                curve: SrgbCurve::new(),
            }))
        };
        Some(Self { channels, way })
    }

    /// Converts whole texels; alpha stays.
    pub(super) fn apply<T: Value + Into<u16> + TryFrom<u16>>(&self, values: &mut [T]) {
        let count = self.channels.count();
        let colors = count - usize::from(self.channels.has_alpha());
        for texel in values.chunks_exact_mut(count) {
            let texel = &mut texel[..colors];
            match (&self.way, &mut *texel) {
                (Way::Curve(curve), texel) => {
                    for value in texel {
                        let stored: u16 = (*value).into();
                        *value = T::try_from(curve[usize::from(stored)]).unwrap_or(T::ONE);
                    }
                }
                (Way::Mixed(mix), [r, g, b]) => {
                    let stored = [*r, *g, *b].map(|value| usize::from(Into::<u16>::into(value)));
                    [*r, *g, *b] = mix.apply(stored).map(T::from_unit);
                }
                (Way::Mixed(_), _) => unreachable!("greys are not mixed"),
            }
        }
    }
}

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl Mix {
    /// Encoded as sRGB.
    fn apply(&self, stored: [usize; 3]) -> [f32; 3] {
        let mut linear = stored.map(|value| self.linear[value]);
        if let Some(luminances) = self.hlg {
            let luminance: f32 = linear.iter().zip(luminances).map(|(value, y)| value * y).sum();
            let gain = luminance.powf(HLG_GAMMA as f32 - 1.0) * (HLG_PEAK / WHITE) as f32;
            linear = linear.map(|value| value * gain);
        }
        let [r, g, b] = linear;
        self.matrix.map(|[x, y, z]| self.curve.at((x * r + y * g + z * b).max(0.0)))
    }
}

impl ColorSpace {
    /// The light that a value in `0.0..=1.0` stands for, before [`Transfer::shown`].
    fn light(&self, value: f64) -> f64 {
        let value = if self.is_narrow { (value - 16.0 / 255.0) * 255.0 / 219.0 } else { value };
        self.transfer.light(value.clamp(0.0, 1.0))
    }
}

impl Transfer {
    /// Relative to white; with [`Transfer::Pq`] to its peak, with [`Transfer::Hlg`] of the scene.
    fn light(self, value: f64) -> f64 {
        match self {
            Self::Srgb => f64::from(linear_from_srgb(value as f32)),
            Self::Linear => value,
            Self::Power(power) => value.powf(power),
            Self::Bt709 if value < 0.081 => value / 4.5,
            Self::Bt709 => ((value + 0.099) / 1.099).powf(1.0 / 0.45),
            Self::Pq => perceptual(value),
            Self::Hlg => hybrid(value),
        }
    }

    /// What a light of a grey is relative to white.
    fn shown(self, light: f64) -> f64 {
        match self {
            Self::Hlg => light.powf(HLG_GAMMA) * self.scale(),
            _ => light * self.scale(),
        }
    }

    /// The brightest light relative to white.
    fn scale(self) -> f64 {
        match self {
            Self::Pq => 10_000.0 / WHITE,
            Self::Hlg => HLG_PEAK / WHITE,
            _ => 1.0,
        }
    }
}

/// SMPTE ST 2084: relative to 10,000 cd/m².
fn perceptual(value: f64) -> f64 {
    const M1: f64 = 1305.0 / 8192.0;
    const M2: f64 = 2523.0 / 32.0;
    const C1: f64 = 107.0 / 128.0;
    const C2: f64 = 2413.0 / 128.0;
    const C3: f64 = 2392.0 / 128.0;
    let root = value.powf(1.0 / M2);
    ((root - C1).max(0.0) / (C2 - C3 * root)).powf(1.0 / M1)
}

/// ITU-R BT.2100: light of the scene, relative to the brightest.
fn hybrid(value: f64) -> f64 {
    const A: f64 = 0.178_832_77;
    const B: f64 = 1.0 - 4.0 * A;
    // 0.5 − a ln 4a.
    const C: f64 = 0.559_910_73;
    if value <= 0.5 { value * value / 3.0 } else { (((value - C) / A).exp() + B) / 12.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color_space::Chromaticities;

    fn space(transfer: Transfer) -> ColorSpace {
        ColorSpace { transfer, primaries: Chromaticities::SRGB, is_narrow: false }
    }

    fn converted(space: &ColorSpace, values: &[u8]) -> Vec<u8> {
        let mut values = values.to_vec();
        let conversion = ColorConversion::new(space, Channels::Rgb, Depth::U8).unwrap();
        conversion.apply(&mut values);
        values
    }

    #[test]
    fn srgb_needs_no_conversion() {
        assert!(ColorConversion::new(&space(Transfer::Srgb), Channels::Rgb, Depth::U8).is_none());
    }

    #[test]
    fn published_points_of_the_curves() {
        // BT.2408, table 1: diffuse white of 203 cd/m² is 58 % PQ and 75 % HLG.
        assert!((perceptual(0.5807) * 10_000.0 - 203.0).abs() < 0.5);
        assert!((Transfer::Hlg.shown(hybrid(0.75)) - 1.0).abs() < 2e-3);
        assert!((hybrid(1.0) - 1.0).abs() < 1e-6);
        assert!((hybrid(0.5) - 1.0 / 12.0).abs() < 1e-9);
        assert!((perceptual(1.0) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn values_are_converted_and_clipped() {
        // Half the light is 188 in sRGB.
        assert_eq!(converted(&space(Transfer::Linear), &[0, 128, 255]), [0, 188, 255]);
        assert_eq!(converted(&space(Transfer::Pq), &[0, 148, 255]), [0, 255, 255]);
        let narrow = ColorSpace { is_narrow: true, ..space(Transfer::Srgb) };
        assert_eq!(converted(&narrow, &[10, 16, 235, 250, 126, 16]), [0, 0, 255, 255, 128, 0]);
    }

    #[test]
    fn a_grey_is_the_same_with_and_without_mixed_channels() {
        for transfer in [Transfer::Hlg, Transfer::Pq, Transfer::Power(1.8), Transfer::Bt709] {
            let wide = ColorSpace {
                primaries: Chromaticities { red: [0.7, 0.29], ..Chromaticities::SRGB },
                ..space(transfer)
            };
            for value in 0..=255 {
                let mut grey = [value];
                let conversion = ColorConversion::new(&wide, Channels::Grey, Depth::U8).unwrap();
                conversion.apply(&mut grey);
                for color in converted(&wide, &[value; 3]) {
                    assert!(color.abs_diff(grey[0]) <= 1, "{transfer:?} of {value}");
                }
            }
        }
    }

    #[test]
    fn alpha_stays() {
        let linear = space(Transfer::Linear);
        let mut values = [32_768u16, 32_768];
        let conversion = ColorConversion::new(&linear, Channels::GreyAlpha, Depth::U16).unwrap();
        conversion.apply(&mut values);
        assert_eq!(values, [48_192, 32_768]);
    }
}
