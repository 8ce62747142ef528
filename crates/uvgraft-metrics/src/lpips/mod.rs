//! LPIPS 0.1: learned perceptual image patch similarity.
//!
//! Both pictures go through a network trained for image classification. The responses of its layers
//! are compared channel by channel, with weights fitted to human judgements of similarity.
//!
//! Source: Zhang, Isola, Efros, Shechtman and Wang, "The Unreasonable Effectiveness of Deep
//! Features as a Perceptual Metric", CVPR 2018, and the Python package `lpips` 0.1.4, whose values
//! this matches.

mod difference;
mod layer;
mod maps;
mod network;
mod rows;
mod stream;
#[cfg(test)]
mod tests;
mod weights;

use super::{Colors, MetricError, same_size};
pub use maps::LpipsMaps;
pub use network::LpipsNetwork;
pub use weights::{ConvolutionWeights, LpipsWeights, LpipsWeightsError};

/// LPIPS with a given network.
#[derive(Debug, Clone)]
pub struct Lpips {
    weights: LpipsWeights,
}

impl Lpips {
    /// LPIPS with the network of the weights.
    pub const fn new(weights: LpipsWeights) -> Self {
        Self { weights }
    }

    /// Compares two pictures. Values are used as stored: display-referred sRGB with 1.0 for white.
    ///
    /// Memory beyond the pictures and the result does not grow with the height of the pictures; for
    /// a width of 4096 texels it is below 500 MB with VGG16 and 30 MB with AlexNet. The result is
    /// bit-identical for any number of threads.
    ///
    /// # Errors
    /// [`MetricError::Size`] for pictures of different sizes, [`MetricError::TooSmall`] for sides
    /// below [`LpipsNetwork::least_side`], [`MetricError::OutOfRange`] for values beyond a million.
    pub fn compare(&self, first: &Colors, second: &Colors) -> Result<LpipsMaps, MetricError> {
        same_size(first, second, None)?;
        let (size, network) = (first.size(), self.weights.network());
        let least = network.least_side();
        if size.width.min(size.height) < least {
            return Err(MetricError::TooSmall { metric: "LPIPS", least, found: size });
        }
        // The networks amplify their input some hundredfold in each layer.
        const MAX: u32 = 1_000_000;
        for picture in [first, second] {
            let out_of_range = |value: &f32| value.abs() > MAX as f32;
            if let Some((x, y)) = picture.position(out_of_range) {
                return Err(MetricError::OutOfRange { metric: "LPIPS", most: MAX, x, y });
            }
        }
        let LpipsWeights { convolutions, linear, .. } = &self.weights;
        let pictures = [first, second];
        let strip = stream::strip_rows(size.width);
        let maps = stream::differences(network.layers(), convolutions, linear, pictures, strip);
        Ok(LpipsMaps::new(size, maps))
    }

    /// The network.
    pub const fn network(&self) -> LpipsNetwork {
        self.weights.network()
    }
}
