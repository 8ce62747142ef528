//! Layers of a network: what an operator of a model means for tensors of known shapes.

use crate::tflite::Activation;

/// Height, width and channels of an image-like tensor of one picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    pub(super) height: usize,
    pub(super) width: usize,
    pub(super) channels: usize,
}

/// How a window moves over its input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Windows {
    pub(super) input: Shape,
    pub(super) output: Shape,
    /// Rows and columns of the window.
    pub(super) size: [usize; 2],
    pub(super) stride: [usize; 2],
    pub(super) dilation: [usize; 2],
    /// Rows above and columns left of the input that the first window covers.
    pub(super) before: [usize; 2],
}

impl Windows {
    /// The input row or column that a tap of a window falls on; `None` outside the input.
    ///
    /// - `axis`: 0 for rows, 1 for columns.
    #[inline(always)]
    pub(super) fn position(&self, axis: usize, output: usize, tap: usize) -> Option<usize> {
        let length = [self.input.height, self.input.width][axis];
        let position = output * self.stride[axis] + tap * self.dilation[axis];
        position.checked_sub(self.before[axis]).filter(|&position| position < length)
    }

    /// Number of taps of a window.
    pub(super) const fn taps(&self) -> usize {
        self.size[0] * self.size[1]
    }
}

/// A convolution with its weights.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Convolution {
    pub(super) windows: Windows,
    /// `[output][row][column][input]` for a full convolution, `[row][column][channel]` for a
    /// depthwise one.
    pub(super) kernel: Vec<f32>,
    /// The kernel of a full convolution in panels of eight outputs, for the fast path.
    pub(super) panels: Vec<[f32; super::fast::LANES]>,
    pub(super) bias: Vec<f32>,
    pub(super) activation: Activation,
}

/// What is computed for one operator.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Layer {
    /// Sum of two tensors.
    Add(Activation),
    /// Parts of so many values from each input in turn.
    Concatenation {
        parts: Vec<usize>,
        activation: Activation,
    },
    Convolution(Convolution),
    DepthwiseConvolution(Convolution),
    MaxPooling {
        windows: Windows,
        activation: Activation,
    },
    /// Zeros around: numbers before, for rows, columns and channels.
    Pad {
        input: Shape,
        output: Shape,
        before: [usize; 3],
    },
    /// Slopes for negative values, repeated over the tensor.
    Prelu(Vec<f32>),
    Activation(Activation),
    Reshape,
}
