//! Runs small convolutional networks on the processor, in single precision.
//!
//! A [`Network`] is built from a model of TensorFlow Lite ([`crate::tflite`]). Convolutions have a
//! scalar reference, which is the specification ([`Network::run_reference`]), and a fast path that
//! gives the same bits. A network runs on the calling thread, so its result cannot depend on their
//! number; callers run it on several inputs at once.

mod build;
mod fast;
mod layer;
mod reference;
#[cfg(test)]
mod tests;

use crate::tflite::Model;
use layer::{Convolution, Layer};

/// A network that is ready to run.
#[derive(Debug, Clone)]
pub struct Network {
    input: usize,
    input_length: usize,
    outputs: Vec<usize>,
    steps: Vec<Step>,
    tensors: usize,
    /// For each tensor, the last step that reads it; `None` for those that must be kept.
    last_use: Vec<Option<usize>>,
}

/// One layer and what it reads and writes.
#[derive(Debug, Clone)]
struct Step {
    layer: Layer,
    inputs: Vec<usize>,
    output: usize,
    /// Number of values of the output.
    length: usize,
}

/// Why a network could not be built or run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// An operator's shapes do not fit together, or it is of a kind that is not supported.
    #[error("the network's operator {index} has operands that do not fit it or are not supported")]
    Operator {
        /// Which one.
        index: usize,
    },
    /// The graph does not connect.
    #[error("the network's tensor {tensor} is read before it is computed")]
    Order {
        /// Which one.
        tensor: usize,
    },
    /// There must be one input.
    #[error("a network must have one input and at least one output, got {inputs} and {outputs}")]
    Ends {
        /// Number of inputs.
        inputs: usize,
        /// Number of outputs.
        outputs: usize,
    },
    /// The input, or an output, has another size than the caller's.
    #[error("the network's {what} must have {wanted} values, got {found}")]
    Length {
        /// Which.
        what: &'static str,
        /// Values that it must have.
        wanted: usize,
        /// Values that it has.
        found: usize,
    },
}

/// The convolutions, by reference or fast.
struct Kernels {
    convolve: fn(&Convolution, &[f32], &mut [f32]),
    convolve_depthwise: fn(&Convolution, &[f32], &mut [f32]),
}

impl Network {
    /// Prepares a model.
    ///
    /// # Errors
    /// [`NetworkError`] if the model's shapes contradict each other or an operator's variant is not
    /// supported.
    pub fn new(model: &Model) -> Result<Self, NetworkError> {
        let (inputs, outputs) = (model.inputs.len(), model.outputs.len());
        let (&[input], true) = (&model.inputs[..], outputs > 0) else {
            return Err(NetworkError::Ends { inputs, outputs });
        };
        let mut builder = build::Builder::new(model);
        let mut steps = Vec::new();
        for (index, operator) in model.operators.iter().enumerate() {
            steps.extend(builder.step(index, operator)?);
        }
        let missing = NetworkError::Length { what: "input", wanted: 1, found: 0 };
        let input_length = builder.length(input).ok_or(missing)?;
        let mut network = Self {
            input,
            input_length,
            outputs: model.outputs.clone(),
            steps,
            tensors: model.tensors.len(),
            last_use: vec![None; model.tensors.len()],
        };
        network.connect()?;
        Ok(network)
    }

    /// Checks that every tensor is computed, once, before it is read, and finds its last use.
    fn connect(&mut self) -> Result<(), NetworkError> {
        let mut is_known = vec![false; self.tensors];
        is_known[self.input] = true;
        for (index, step) in self.steps.iter().enumerate() {
            if let Some(&tensor) = step.inputs.iter().find(|&&tensor| !is_known[tensor]) {
                return Err(NetworkError::Order { tensor });
            }
            if is_known[step.output] {
                return Err(NetworkError::Order { tensor: step.output });
            }
            is_known[step.output] = true;
            for &tensor in &step.inputs {
                self.last_use[tensor] = Some(index);
            }
        }
        for &tensor in &self.outputs {
            if !is_known[tensor] {
                return Err(NetworkError::Order { tensor });
            }
            self.last_use[tensor] = None;
        }
        Ok(())
    }

    /// Number of values of the input.
    pub const fn input_length(&self) -> usize {
        self.input_length
    }

    /// Number of values of each output.
    pub fn output_lengths(&self) -> Vec<usize> {
        let length = |output: &usize| {
            let step = self.steps.iter().find(|step| step.output == *output);
            step.map_or(self.input_length, |step| step.length)
        };
        self.outputs.iter().map(length).collect()
    }

    /// Checks that the network is one of a kind.
    ///
    /// - `input`, `outputs`: numbers of values; outputs in ascending order of them.
    ///
    /// # Errors
    /// [`NetworkError::Length`] with what differs.
    pub fn check_lengths<const N: usize>(
        &self,
        input: usize,
        outputs: [usize; N],
    ) -> Result<(), NetworkError> {
        let check = |what, wanted, found| {
            if found == wanted { Ok(()) } else { Err(NetworkError::Length { what, wanted, found }) }
        };
        check("input", input, self.input_length)?;
        let mut lengths = self.output_lengths();
        lengths.sort_unstable();
        for (index, wanted) in outputs.into_iter().enumerate() {
            check("output", wanted, lengths.get(index).copied().unwrap_or(0))?;
        }
        Ok(())
    }

    /// Runs the network.
    ///
    /// - `input`: [`Network::input_length`] values, NHWC as in the model.
    ///
    /// Returns the outputs in the model's order.
    ///
    /// # Errors
    /// [`NetworkError::Length`] for another number of values.
    pub fn run(&self, input: &[f32]) -> Result<Vec<Vec<f32>>, NetworkError> {
        let (convolve, convolve_depthwise) = (fast::convolve, fast::convolve_depthwise);
        self.run_by(input, &Kernels { convolve, convolve_depthwise })
    }

    /// As [`Network::run`], by the scalar reference, which takes some twenty times as long.
    ///
    /// # Errors
    /// [`NetworkError::Length`] for another number of values.
    pub fn run_reference(&self, input: &[f32]) -> Result<Vec<Vec<f32>>, NetworkError> {
        let (convolve, convolve_depthwise) = (reference::convolve, reference::convolve_depthwise);
        self.run_by(input, &Kernels { convolve, convolve_depthwise })
    }

    fn run_by(&self, input: &[f32], kernels: &Kernels) -> Result<Vec<Vec<f32>>, NetworkError> {
        if input.len() != self.input_length {
            let (wanted, found) = (self.input_length, input.len());
            return Err(NetworkError::Length { what: "input", wanted, found });
        }
        let mut tensors: Vec<Vec<f32>> = vec![Vec::new(); self.tensors];
        tensors[self.input] = input.to_vec();
        for (index, step) in self.steps.iter().enumerate() {
            let mut output = vec![0.0; step.length];
            let inputs: Vec<&[f32]> = step.inputs.iter().map(|&at| &tensors[at][..]).collect();
            step.layer.apply(&inputs, &mut output, kernels);
            tensors[step.output] = output;
            for &tensor in &step.inputs {
                if self.last_use[tensor] == Some(index) {
                    tensors[tensor] = Vec::new();
                }
            }
        }
        // An output may be listed twice.
        Ok(self.outputs.iter().map(|&tensor| tensors[tensor].clone()).collect())
    }
}

impl Layer {
    fn apply(&self, inputs: &[&[f32]], output: &mut [f32], kernels: &Kernels) {
        let input = inputs[0];
        match self {
            Self::Convolution(layer) => (kernels.convolve)(layer, input, output),
            Self::DepthwiseConvolution(layer) => {
                (kernels.convolve_depthwise)(layer, input, output);
            }
            Self::Add(activation) => {
                for ((sum, a), b) in output.iter_mut().zip(input).zip(inputs[1]) {
                    *sum = reference::activate(*activation, a + b);
                }
            }
            Self::Prelu(slopes) => {
                let texels = output.chunks_exact_mut(slopes.len());
                for (to, from) in texels.zip(input.chunks_exact(slopes.len())) {
                    for ((to, &value), &slope) in to.iter_mut().zip(from).zip(slopes) {
                        *to = if value < 0.0 { value * slope } else { value };
                    }
                }
            }
            Self::Activation(activation) => {
                for (to, &value) in output.iter_mut().zip(input) {
                    *to = reference::activate(*activation, value);
                }
            }
            Self::MaxPooling { windows, activation } => {
                reference::max_pool(windows, *activation, input, output);
            }
            Self::Pad { input: from, output: to, before } => {
                reference::pad(*from, *to, *before, input, output);
            }
            Self::Concatenation { parts, activation } => {
                reference::concatenate(parts, *activation, inputs, output);
            }
            Self::Reshape => output.copy_from_slice(input),
        }
    }
}
