//! A Gaussian model of colours in CIELAB.

use nalgebra::{Matrix3, Vector3};
use uvgraft::color::lab;
use uvgraft::statistics::median_color;

/// The distribution of the colours of one thing, such as hair.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ColorModel {
    center: Vector3<f64>,
    whitening: Matrix3<f64>,
    /// Median of the samples, sRGB.
    pub color: [f32; 3],
}

/// Standard deviations that are added: of lightness, which light changes, and of hue. With 3.5 for
/// lightness, 6 % less is known with glasses, and PSNR falls by 2.1 dB; with 14 it rises there by
/// 1.2 dB, and falls by 1.4 dB from the front.
const TOLERANCE: [f64; 3] = [7.0, 2.5, 3.0];

/// Fewest samples. Origin not recorded.
const FEWEST: usize = 60;

impl ColorModel {
    /// Fits samples (sRGB, 1.0 for white), of which those far from most don't count; `None` if there
    /// are too few.
    pub fn new(samples: &[[f32; 3]]) -> Option<Self> {
        const ROUNDS: usize = 4;
        if samples.len() < FEWEST {
            return None;
        }
        let points: Vec<Vector3<f64>> = samples.iter().map(|&color| point(color)).collect();
        let center = median_color(points.iter().map(|&point| <[f64; 3]>::from(point)))?.into();
        let color = median_color(samples.iter().copied())?;
        let tolerance = Matrix3::from_diagonal(&Vector3::from_fn(|k, _| TOLERANCE[k].powi(2)));
        let mut model = Self { center, whitening: whitening(tolerance * 4.0)?, color };
        for _ in 0..ROUNDS {
            let mut total = 1e-9;
            let (mut sum, mut squares) = (Vector3::zeros(), Matrix3::zeros());
            for point in &points {
                let distance = model.distance_to(point);
                let weight = 1.0 / (1.0 + (distance / 2.0).powi(4));
                let offset = point - model.center;
                total += weight;
                sum += offset * weight;
                squares += offset * offset.transpose() * weight;
            }
            let mean = sum / total;
            let covariance = squares / total - mean * mean.transpose();
            model.center += mean;
            model.whitening = whitening(covariance + tolerance)?;
        }
        Some(model)
    }

    /// How far a colour is from the model, in standard deviations.
    pub fn distance(&self, color: [f32; 3]) -> f64 {
        self.distance_to(&point(color))
    }

    fn distance_to(&self, point: &Vector3<f64>) -> f64 {
        (self.whitening * (point - self.center)).norm()
    }
}

fn point(color: [f32; 3]) -> Vector3<f64> {
    Vector3::from(lab(color).map(f64::from))
}

fn whitening(covariance: Matrix3<f64>) -> Option<Matrix3<f64>> {
    covariance.cholesky()?.l().try_inverse()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_skin_are_near_and_those_of_hair_far() {
        let mut random = fastrand::Rng::with_seed(1);
        let mut around = |color: [f32; 3]| color.map(|value| value + 0.06 * (random.f32() - 0.5));
        let skin: Vec<[f32; 3]> = (0..300)
            // One in six is something else.
            .map(|index| around(if index % 6 == 0 { [0.1, 0.1, 0.3] } else { [0.8, 0.6, 0.5] }))
            .collect();
        let model = ColorModel::new(&skin).unwrap();
        assert!(model.distance([0.8, 0.6, 0.5]) < 0.5);
        assert!(model.distance([0.68, 0.51, 0.42]) < 2.5, "{}", model.distance([0.68, 0.51, 0.42]));
        assert!(model.distance([0.3, 0.2, 0.15]) > 4.0);
        assert!(ColorModel::new(&skin[..20]).is_none());
    }
}
