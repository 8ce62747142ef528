//! LPIPS 0.1: learned perceptual image patch similarity.
//!
//! Two pictures go through a network that was trained to name what pictures show; what its layers
//! respond with is compared channel by channel, weighted by what people saw as different.
//!
//! Source: Zhang, Isola, Efros, Shechtman and Wang, "The Unreasonable Effectiveness of Deep Features
//! as a Perceptual Metric", CVPR 2018, and the Python package `lpips` 0.1.4, whose values this
//! matches.

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

/// LPIPS with one network.
#[derive(Debug, Clone)]
pub struct Lpips {
    weights: LpipsWeights,
}

impl Lpips {
    /// LPIPS with the network that the weights belong to.
    pub const fn new(weights: LpipsWeights) -> Self {
        Self { weights }
    }

    /// Compares two pictures. Their values are taken as they are: display-referred sRGB with 1.0
    /// for white.
    ///
    /// What is held beside the pictures and the result does not grow with the pictures' height; for
    /// a width of 4096 texels it is below 500 MB with VGG16 and 30 MB with AlexNet. The result is
    /// the same to the bit for any number of threads.
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
        // The networks multiply what they see some hundredfold in each layer.
        const MOST: u32 = 1_000_000;
        for picture in [first, second] {
            if let Some(index) = picture.values().iter().position(|v| v.abs() > MOST as f32) {
                let (x, y) = ((index / 3) as u32 % size.width, (index / 3) as u32 / size.width);
                return Err(MetricError::OutOfRange { metric: "LPIPS", most: MOST, x, y });
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
