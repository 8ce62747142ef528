//! Operators and their options.

use super::TfliteError;
use super::flatbuffer::Table;

/// What an operator does, of those that face networks use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum OperatorKind {
    /// Sum of two tensors of one shape.
    Add {
        /// Applied to the sum.
        activation: Activation,
    },
    /// Tensors joined along an axis.
    Concatenation {
        /// Which one; negative numbers count from the last.
        axis: i32,
        /// Applied to the result.
        activation: Activation,
    },
    /// 2D convolution: input NHWC, kernel OHWI, bias.
    Convolution(Window),
    /// 2D convolution of each channel on its own: input NHWC, kernel 1HWC, bias.
    DepthwiseConvolution {
        /// How the kernel moves.
        window: Window,
        /// Output channels for each input channel.
        multiplier: u32,
    },
    /// Half-precision values as single-precision ones.
    Dequantize,
    /// Largest value in a window.
    MaxPooling {
        /// How the window moves.
        window: Window,
        /// Height and width of the window.
        size: [u32; 2],
    },
    /// A frame of zeros; the second input has the numbers before and after, for each axis.
    Pad,
    /// Negative values times a learned slope for each channel.
    Prelu,
    /// The function alone.
    Activation(Activation),
    /// The same values in another shape.
    Reshape,
}

/// How a kernel or window moves over its input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Whether the output has the size of the input, divided by the stride and rounded up; otherwise
    /// the window stays within the input.
    pub is_same: bool,
    /// Rows and columns from one place to the next.
    pub stride: [u32; 2],
    /// Rows and columns between neighbouring taps of the kernel.
    pub dilation: [u32; 2],
    /// Applied to the result.
    pub activation: Activation,
}

/// A function that is applied to every value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Activation {
    /// The value itself.
    #[default]
    None,
    /// Negative values become 0.
    Relu,
    /// Clamped to -1 and 1.
    ReluOne,
    /// Clamped to 0 and 6.
    ReluSix,
}

/// An operator of a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Operator {
    /// What it does.
    pub kind: OperatorKind,
    /// Indices of the tensors that it reads; `None` for an optional one that is left out.
    pub inputs: Vec<Option<usize>>,
    /// Indices of the tensors that it writes.
    pub outputs: Vec<usize>,
}

/// The kind of an operator with a code of the enum `BuiltinOperator`, and its options. Field numbers
/// are those of the tables `AddOptions`, `Conv2DOptions` and so on.
pub(super) fn kind(code: i32, options: Option<Table<'_>>) -> Result<OperatorKind, TfliteError> {
    let activation = |field: usize| -> Result<Activation, TfliteError> {
        match options.map_or(Ok(0), |options| options.u8(field))? {
            0 => Ok(Activation::None),
            1 => Ok(Activation::Relu),
            2 => Ok(Activation::ReluOne),
            3 => Ok(Activation::ReluSix),
            other => Err(TfliteError::Activation(other)),
        }
    };
    let int = |field, default| options.map_or(Ok(default), |options| options.i32(field, default));
    // A stride or a size.
    let positive = |field, default| -> Result<u32, TfliteError> {
        let value = int(field, default)?;
        u32::try_from(value)
            .ok()
            .filter(|value| (1..=MAX_STEP).contains(value))
            .ok_or(TfliteError::Step(value))
    };
    let window = |activation, dilation| -> Result<Window, TfliteError> {
        // 0 is SAME, 1 is VALID.
        let is_same = options.map_or(Ok(0), |options| options.u8(0))? == 0;
        Ok(Window { is_same, stride: [positive(2, 0)?, positive(1, 0)?], dilation, activation })
    };
    Ok(match code {
        0 => OperatorKind::Add { activation: activation(0)? },
        2 => OperatorKind::Concatenation { axis: int(0, 0)?, activation: activation(1)? },
        3 => OperatorKind::Convolution(window(activation(3)?, [positive(5, 1)?, positive(4, 1)?])?),
        4 => OperatorKind::DepthwiseConvolution {
            window: window(activation(4)?, [positive(6, 1)?, positive(5, 1)?])?,
            multiplier: positive(3, 0)?,
        },
        6 => OperatorKind::Dequantize,
        17 => OperatorKind::MaxPooling {
            window: window(activation(5)?, [1; 2])?,
            size: [positive(4, 0)?, positive(3, 0)?],
        },
        19 => OperatorKind::Activation(Activation::Relu),
        20 => OperatorKind::Activation(Activation::ReluOne),
        21 => OperatorKind::Activation(Activation::ReluSix),
        22 => OperatorKind::Reshape,
        34 => OperatorKind::Pad,
        54 => OperatorKind::Prelu,
        other => return Err(TfliteError::Operator(other)),
    })
}

/// Largest stride, dilation or window that is accepted, so that sums of them cannot overflow.
const MAX_STEP: u32 = 1 << 12;
