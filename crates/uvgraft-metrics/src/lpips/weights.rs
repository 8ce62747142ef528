//! Trained weights of the networks.

use super::network::LpipsNetwork;

/// The weights of one network and of the five linear layers on top of it, with checked shapes.
#[derive(Debug, Clone, PartialEq)]
pub struct LpipsWeights {
    network: LpipsNetwork,
    pub(super) convolutions: Vec<ConvolutionWeights>,
    pub(super) linear: Vec<Vec<f32>>,
}

/// The weights of one convolution.
#[derive(Debug, Clone, PartialEq)]
pub struct ConvolutionWeights {
    /// `[height, width, inputs, outputs]`, row-major.
    pub kernel: Vec<f32>,
    /// `[outputs]`.
    pub bias: Vec<f32>,
}

/// Why weights were rejected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LpipsWeightsError {
    /// The number of values does not match the network.
    #[error("{what} must have {wanted} values, got {found}")]
    Length {
        /// Which weights.
        what: String,
        /// The actual number.
        found: usize,
        /// The number that the network has.
        wanted: usize,
    },
    /// A value is NaN or infinite.
    #[error("{0} must be finite")]
    NotFinite(
        /// Which weights.
        String,
    ),
}

impl LpipsWeights {
    /// Checks that weights match a network.
    ///
    /// - `convolutions`: from first to last, in the shapes of [`LpipsNetwork::kernel_shapes`].
    /// - `linear`: for each compared feature map the weights of its channels, as many as in
    ///   [`LpipsNetwork::compared_channels`].
    ///
    /// # Errors
    /// [`LpipsWeightsError`] if the number of values differs, or a value is not finite.
    pub fn new(
        network: LpipsNetwork,
        convolutions: Vec<ConvolutionWeights>,
        linear: Vec<Vec<f32>>,
    ) -> Result<Self, LpipsWeightsError> {
        let shapes = network.kernel_shapes();
        let channels = network.compared_channels();
        check_length("convolutions", convolutions.len(), shapes.len())?;
        check_length("linear layers", linear.len(), channels.len())?;
        for (index, (weights, shape)) in convolutions.iter().zip(shapes).enumerate() {
            let of = |what: &str| format!("the {what} of convolution {}", index + 1);
            check(&of("weights"), &weights.kernel, shape.iter().product())?;
            check(&of("biases"), &weights.bias, shape[3])?;
        }
        for (index, (weights, wanted)) in linear.iter().zip(channels).enumerate() {
            check(&format!("the weights of linear layer {}", index + 1), weights, wanted)?;
        }
        Ok(Self { network, convolutions, linear })
    }

    /// The network that they belong to.
    pub const fn network(&self) -> LpipsNetwork {
        self.network
    }

    /// The weights of the convolutions, from first to last.
    pub fn convolutions(&self) -> &[ConvolutionWeights] {
        &self.convolutions
    }

    /// The weights of the channels of each compared feature map.
    pub fn linear(&self) -> &[Vec<f32>] {
        &self.linear
    }
}

fn check(what: &str, values: &[f32], wanted: usize) -> Result<(), LpipsWeightsError> {
    check_length(what, values.len(), wanted)?;
    if values.iter().all(|value| value.is_finite()) {
        Ok(())
    } else {
        Err(LpipsWeightsError::NotFinite(what.to_owned()))
    }
}

fn check_length(what: &str, found: usize, wanted: usize) -> Result<(), LpipsWeightsError> {
    if found == wanted {
        Ok(())
    } else {
        Err(LpipsWeightsError::Length { what: what.to_owned(), found, wanted })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mismatched_weights_are_rejected() {
        let network = LpipsNetwork::Alex;
        let parts = || {
            let zeros = |shape: [usize; 4]| ConvolutionWeights {
                kernel: vec![0.0; shape.iter().product()],
                bias: vec![0.0; shape[3]],
            };
            let convolutions: Vec<_> = network.kernel_shapes().into_iter().map(zeros).collect();
            let linear: Vec<_> =
                network.compared_channels().into_iter().map(|count| vec![0.0; count]).collect();
            (convolutions, linear)
        };
        type Parts = (Vec<ConvolutionWeights>, Vec<Vec<f32>>);
        let refused = |change: fn(&mut Parts)| {
            let mut parts = parts();
            change(&mut parts);
            LpipsWeights::new(network, parts.0, parts.1).unwrap_err().to_string()
        };
        let (convolutions, linear) = parts();
        assert!(LpipsWeights::new(network, convolutions, linear).is_ok());
        assert_eq!(refused(|parts| parts.0.truncate(4)), "convolutions must have 5 values, got 4");
        assert_eq!(
            refused(|parts| parts.0[1].bias.truncate(191)),
            "the biases of convolution 2 must have 192 values, got 191"
        );
        assert_eq!(
            refused(|parts| parts.1[4][3] = f32::NAN),
            "the weights of linear layer 5 must be finite"
        );
        assert!(refused(|parts| parts.0[0].kernel[0] = f32::INFINITY).contains("convolution 1"));
    }
}
