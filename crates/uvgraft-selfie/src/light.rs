//! The light of a photograph, and colours without it.
//!
//! Diffuse light from far away is, within a few per cent, a quadratic function of the normal: nine
//! spherical harmonics (R. Ramamoorthi and P. Hanrahan, "An efficient representation for irradiance
//! environment maps", 2001). They are fitted to skin, whose albedo is taken to be uniform; robustly,
//! since it is not, and with a prior towards even light, since a face has more reasons to be darker
//! below than light.

use glam::DVec3;
use nalgebra::{SMatrix, SVector};
use uvgraft::color::{linear_from_srgb, luminance, srgb_from_linear};
use uvgraft::statistics::median;

/// How much of the light is taken out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Relight {
    /// Nothing: the photograph's colours.
    Off,
    /// Brightness, most of it.
    #[default]
    Soft,
    /// Brightness and colour, all of it.
    Full,
}

uvgraft::choices!(Relight {
    Off => "off", "None of it: the colours of the photographs";
    Soft => "soft", "Most of the differences in brightness";
    Full => "full", "All differences in brightness and colour";
});

/// A colour seen on skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinSample {
    /// Unit normal in the head's space.
    pub normal: DVec3,
    /// sRGB, 1.0 for white.
    pub color: [f32; 3],
    /// How much it counts.
    pub weight: f64,
}

/// What a surface reflects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reflection {
    /// Unit normal of the surface, in the head's space.
    pub normal: DVec3,
    /// Of each channel, in linear space, by the surface's albedo.
    pub factors: [f64; 3],
    /// How much it counts.
    pub weight: f64,
}

/// The light on surfaces of all directions, for each channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Irradiance {
    /// Coefficients of the harmonics, for each channel.
    channels: [[f64; 9]; 3],
}

impl Irradiance {
    /// Fits the light to what surfaces reflect; `None` if there are too few.
    pub fn new(reflections: &[Reflection]) -> Option<Self> {
        if reflections.len() < FEWEST {
            return None;
        }
        let bases: Vec<Vector> =
            reflections.iter().map(|reflection| harmonics(reflection.normal)).collect();
        let weights: Vec<f64> = reflections.iter().map(|reflection| reflection.weight).collect();
        let mut channels = [[0.0; 9]; 3];
        for (channel, found) in channels.iter_mut().enumerate() {
            let values: Vec<f64> =
                reflections.iter().map(|reflection| reflection.factors[channel]).collect();
            found.copy_from_slice(fitted(&bases, &values, &weights)?.as_slice());
        }
        Some(Self { channels })
    }

    /// The light on a surface, for each channel.
    pub fn at(&self, normal: DVec3) -> [f64; 3] {
        let basis = harmonics(normal);
        self.channels.map(|channel| Vector::from(channel).dot(&basis))
    }
}

/// Light relative to that on a surface that faces forward, for each channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Coefficients of the harmonics, for each channel; the front has the value 1.
    channels: [[f64; 9]; 3],
    /// Luminance of plain skin that faces forward, in linear space.
    skin: f64,
}

type Vector = SVector<f64, 9>;

/// Weight of the priors towards even light, relative to the samples' total: by band. On five
/// photographs beside a window or a lamp, with true cameras (`selfie_report`), half and twice as
/// much of the first band change PSNR by up to 0.2 dB; of the second, half gives the lamp 0.6 dB,
/// and twice costs it 0.5 dB.
const PRIOR: [f64; 3] = [0.0, 0.002, 0.02];

/// Limits of the factor of light that is taken out. On the same, 1 as the upper one costs 4.8 dB
/// beside the lamp, and 4 changes nothing; the origin of the lower one is not recorded.
const LIMITS: [f64; 2] = [0.4, 2.0];

/// Share of the logarithm of the light that [`Relight::Soft`] takes out. Origin not recorded.
const SOFT: f64 = 0.75;

/// Luminance of the lightest skin. What is lighter is exposed too long. On the same, flat (0.3 dB)
/// from 0.28 to 1.1.
const LIGHTEST: f64 = 0.55;

/// How far skin may be lighter than plain skin, as a share; it shines more in a photograph. On the
/// same, flat (0.2 dB) from 0.2 to 0.8.
const SHEEN: f64 = 0.4;

/// Fewest samples. Origin not recorded.
const FEWEST: usize = 200;

impl Light {
    /// Fits the light to samples of skin; `None` if there are too few.
    ///
    /// - `forward`: the direction in which the face looks.
    pub fn of_skin(samples: &[SkinSample], forward: DVec3) -> Option<Self> {
        let linear = |sample: &SkinSample| Reflection {
            normal: sample.normal,
            factors: sample.color.map(|value| f64::from(linear_from_srgb(value))),
            weight: sample.weight,
        };
        let light = Irradiance::new(&samples.iter().map(linear).collect::<Vec<_>>())?;
        let ahead = light.at(forward);
        if !ahead.iter().all(|&ahead| ahead.is_finite() && ahead > 1e-4) {
            return None;
        }
        let channels =
            std::array::from_fn(|channel| light.channels[channel].map(|of| of / ahead[channel]));
        Some(Self { channels, skin: luminance(ahead) })
    }

    /// Light on a surface, for each channel, relative to the front.
    pub fn at(&self, normal: DVec3) -> [f64; 3] {
        let basis = harmonics(normal);
        self.channels.map(|channel| Vector::from(channel).dot(&basis).clamp(LIMITS[0], LIMITS[1]))
    }

    /// A colour (sRGB) as it would be in even light from the front: no skin is lighter than skin is,
    /// and it shines less. Above 1.0 what the photograph shows lighter than white.
    pub fn removed(&self, color: [f32; 3], normal: DVec3, how: Relight) -> [f32; 3] {
        let light = self.at(normal);
        let factors = match how {
            Relight::Off => return color,
            Relight::Full => light,
            Relight::Soft => [luminance(light).powf(SOFT); 3],
        };
        let even: [f64; 3] =
            std::array::from_fn(|k| f64::from(linear_from_srgb(color[k])) / factors[k]);
        let above = luminance(even) / self.skin - 1.0;
        let mut factor = (LIGHTEST / self.skin).min(1.0);
        if above > 0.0 {
            // Slope 1 at plain skin, so that highlights begin without an edge.
            factor *= (1.0 + SHEEN * (above / SHEEN).tanh()) / (1.0 + above);
        }
        even.map(|even| srgb_from_linear((even * factor) as f32))
    }
}

/// Weighted least squares, a few times, with weights that fade with the residual relative to the
/// median (Cauchy's).
fn fitted(bases: &[Vector], values: &[f64], weights: &[f64]) -> Option<Vector> {
    const ROUNDS: usize = 6;
    let mut robust = vec![1.0; values.len()];
    let mut found = Vector::zeros();
    for _ in 0..ROUNDS {
        let mut matrix = SMatrix::<f64, 9, 9>::zeros();
        let mut right = Vector::zeros();
        let mut total = 0.0;
        for (((basis, &value), &weight), &robust) in
            bases.iter().zip(values).zip(weights).zip(&robust)
        {
            let weight = weight * robust;
            matrix += basis * basis.transpose() * weight;
            right += basis * (value * weight);
            total += weight;
        }
        for k in 0..9 {
            let band = [0, 1, 1, 1, 2, 2, 2, 2, 2][k];
            // Samples face the camera: without priors, light from behind would be anything.
            matrix[(k, k)] += total * PRIOR[band] + 1e-9;
        }
        found = matrix.cholesky()?.solve(&right);
        let residuals: Vec<f64> = bases
            .iter()
            .zip(values)
            .map(|(basis, value)| (basis.dot(&found) - value).abs())
            .collect();
        let scale = (2.0 * median(residuals.iter().copied())?).max(1e-4);
        for (robust, residual) in robust.iter_mut().zip(residuals) {
            *robust = 1.0 / (1.0 + (residual / scale).powi(2));
        }
    }
    Some(found)
}

/// The nine real harmonics of bands 0 to 2, without their constant factors.
fn harmonics(normal: DVec3) -> Vector {
    let DVec3 { x, y, z } = normal;
    Vector::from([1.0, x, y, z, x * y, y * z, z * x, x * x - y * y, 3.0 * z * z - 1.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skin_of_one_colour_in_light_from_one_side_comes_out_even() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut value = || 2.0 * random.f64() - 1.0;
        let albedo = [0.55, 0.34, 0.26];
        let lit = |normal: DVec3, k: usize| {
            let light = [1.0, 0.95, 0.85][k];
            let from = DVec3::new(0.6, 0.4, 0.7).normalize();
            albedo[k] * light * (0.55 + 0.35 * normal.dot(from))
        };
        let color = |normal: DVec3| -> [f32; 3] {
            std::array::from_fn(|k| srgb_from_linear(lit(normal, k) as f32))
        };
        let mut samples = Vec::new();
        while samples.len() < 4000 {
            let normal = DVec3::new(value(), value(), value().abs() + 0.2).normalize();
            // One in ten is a mole or a shadow.
            let color = if samples.len() % 10 == 0 { [0.1; 3] } else { color(normal) };
            samples.push(SkinSample { normal, color, weight: 1.0 });
        }
        let light = Light::of_skin(&samples, DVec3::Z).unwrap();
        let front = color(DVec3::Z);
        for normal in [DVec3::new(-0.7, 0.0, 0.7), DVec3::new(0.0, -0.6, 0.7)] {
            let normal = normal.normalize();
            let seen = color(normal);
            let off =
                |shown: [f32; 3]| (0..3).map(|k| (shown[k] - front[k]).abs()).fold(0.0, f32::max);
            assert!(off(seen) > 0.03);
            assert!(off(light.removed(seen, normal, Relight::Full)) < 0.01);
            assert!(off(light.removed(seen, normal, Relight::Soft)) < 0.6 * off(seen));
            assert_eq!(light.removed(seen, normal, Relight::Off), seen);
        }
    }

    #[test]
    fn too_little_skin_tells_no_light() {
        assert_eq!(Light::of_skin(&[], DVec3::Z), None);
    }
}
