//! What the networks learned.

use super::network::LpipsNetwork;

/// The weights of one network and of the five linear layers on top of it, checked to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct LpipsWeights {
    network: LpipsNetwork,
    pub(super) convolutions: Vec<ConvolutionWeights>,
    pub(super) linear: Vec<Vec<f32>>,
}

/// One convolution's weights.
#[derive(Debug, Clone, PartialEq)]
pub struct ConvolutionWeights {
    /// `[height, width, inputs, outputs]`, row-major.
    pub kernel: Vec<f32>,
    /// `[outputs]`.
    pub bias: Vec<f32>,
}

/// Why weights were refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LpipsWeightsError {
    /// There are more or fewer values than the network has.
    #[error("{what}: expected {wanted} values, got {found}")]
    Length {
        /// Which weights.
        what: String,
        /// How many there are.
        found: usize,
        /// How many the network has.
        wanted: usize,
    },
    /// A value that is no number, or infinite.
    #[error("{0} must be finite")]
    NotFinite(
        /// Which weights.
        String,
    ),
}

impl LpipsWeights {
    /// Checks that weights fit a network.
    ///
    /// - `convolutions`: first to last, of [`LpipsNetwork::kernel_shapes`].
    /// - `linear`: for each feature map that is compared the weight of each channel, of
    ///   [`LpipsNetwork::compared_channels`].
    ///
    /// # Errors
    /// [`LpipsWeightsError`] for another number of values, and for values that are not finite.
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

    /// Which network they belong to.
    pub const fn network(&self) -> LpipsNetwork {
        self.network
    }

    /// The convolutions' weights, first to last.
    pub fn convolutions(&self) -> &[ConvolutionWeights] {
        &self.convolutions
    }

    /// The weight of each channel of each feature map that is compared.
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
    fn weights_that_do_not_fit_are_refused() {
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
        assert_eq!(refused(|parts| parts.0.truncate(4)), "convolutions: expected 5 values, got 4");
        assert_eq!(
            refused(|parts| parts.0[1].bias.truncate(191)),
            "the biases of convolution 2: expected 192 values, got 191"
        );
        assert_eq!(
            refused(|parts| parts.1[4][3] = f32::NAN),
            "the weights of linear layer 5 must be finite"
        );
        assert!(refused(|parts| parts.0[0].kernel[0] = f32::INFINITY).contains("convolution 1"));
    }
}
