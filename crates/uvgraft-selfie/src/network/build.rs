//! From the operators of a model to layers: shapes are checked and constants are resolved here, once,
//! so that running a network cannot fail.

use crate::tflite::{Activation, Model, Operator, OperatorKind, Tensor, Values, Window};

use super::layer::{Convolution, Layer, Shape, Windows};
use super::{NetworkError, Step, fast};

/// Most values of a tensor; the largest in a face network has 150,000.
const MAX_VALUES: usize = 1 << 24;

/// A model while its layers are built.
pub(super) struct Builder<'m> {
    model: &'m Model,
    /// Values of constants, also of those that DEQUANTIZE makes.
    constants: Vec<Option<&'m [f32]>>,
}

impl<'m> Builder<'m> {
    pub(super) fn new(model: &'m Model) -> Self {
        let constant = |tensor: &'m Tensor| match &tensor.constant {
            Some(Values::F32(values)) => Some(&values[..]),
            _ => None,
        };
        Self { model, constants: model.tensors.iter().map(constant).collect() }
    }

    /// The step for an operator; `None` for one that only converts a constant.
    pub(super) fn step(
        &mut self,
        index: usize,
        operator: &Operator,
    ) -> Result<Option<Step>, NetworkError> {
        let wrong = || NetworkError::Operator { index };
        let &[output] = &operator.outputs[..] else { return Err(wrong()) };
        if operator.kind == OperatorKind::Dequantize {
            let input = operator.inputs.first().copied().flatten().ok_or_else(wrong)?;
            self.constants[output] = Some(self.constants[input].ok_or_else(wrong)?);
            return Ok(None);
        }
        let layer = self.layer(operator, output).ok_or_else(wrong)?;
        let count = match &layer {
            Layer::Add(_) => 2,
            Layer::Concatenation { parts, .. } => parts.len(),
            _ => 1,
        };
        let inputs = operator.inputs.get(..count).ok_or_else(wrong)?;
        let inputs = inputs.iter().copied().collect::<Option<Vec<_>>>().ok_or_else(wrong)?;
        let length = self.length(output).ok_or_else(wrong)?;
        Ok(Some(Step { layer, inputs, output, length }))
    }

    /// Number of values of a tensor.
    pub(super) fn length(&self, tensor: usize) -> Option<usize> {
        let shape = &self.model.tensors[tensor].shape;
        let length = shape.iter().try_fold(1_usize, |product, &side| product.checked_mul(side));
        length.filter(|length| (1..=MAX_VALUES).contains(length))
    }

    /// The shape of a tensor of one picture.
    fn shape(&self, tensor: usize) -> Option<Shape> {
        self.length(tensor)?;
        let &[1, height, width, channels] = &self.model.tensors[tensor].shape[..] else {
            return None;
        };
        Some(Shape { height, width, channels })
    }

    fn layer(&self, operator: &Operator, output: usize) -> Option<Layer> {
        let input = |index: usize| operator.inputs.get(index).copied().flatten();
        let first = input(0)?;
        let is_same_length = self.length(first)? == self.length(output)?;
        match operator.kind {
            OperatorKind::Add { activation } => {
                let is_right = is_same_length && self.length(input(1)?)? == self.length(output)?;
                is_right.then_some(Layer::Add(activation))
            }
            OperatorKind::Concatenation { axis, activation } => {
                self.concatenation(operator, output, axis, activation)
            }
            OperatorKind::Convolution(window) => self.convolution(operator, output, window),
            OperatorKind::DepthwiseConvolution { window, multiplier: 1 } => {
                self.depthwise_convolution(operator, output, window)
            }
            OperatorKind::MaxPooling { window, size } => {
                let windows =
                    self.windows(first, output, size.map(|side| side as usize), window)?;
                (windows.input.channels == windows.output.channels)
                    .then_some(Layer::MaxPooling { windows, activation: window.activation })
            }
            OperatorKind::Pad => self.pad(first, output, input(1)?),
            OperatorKind::Prelu => {
                let slopes = self.constants[input(1)?]?;
                let channels = *self.model.tensors[first].shape.last()?;
                let is_right = is_same_length
                    && (slopes.len() == channels || slopes.len() == self.length(output)?);
                is_right.then(|| Layer::Prelu(slopes.to_vec()))
            }
            OperatorKind::Activation(activation) => {
                is_same_length.then_some(Layer::Activation(activation))
            }
            OperatorKind::Reshape => is_same_length.then_some(Layer::Reshape),
            _ => None,
        }
    }

    fn convolution(&self, operator: &Operator, output: usize, window: Window) -> Option<Layer> {
        let input = |index: usize| operator.inputs.get(index).copied().flatten();
        let kernel = input(1)?;
        let &[_, height, width, _] = &self.model.tensors[kernel].shape[..] else {
            return None;
        };
        let windows = self.windows(input(0)?, output, [height, width], window)?;
        let outputs = windows.output.channels;
        let length = windows.taps() * windows.input.channels;
        let kernel = self.constants[kernel].filter(|k| k.len() == outputs * length)?.to_vec();
        let panels = fast::panels(&kernel, outputs);
        let bias = self.bias(input(2), outputs)?;
        let activation = window.activation;
        Some(Layer::Convolution(Convolution { windows, kernel, panels, bias, activation }))
    }

    fn depthwise_convolution(
        &self,
        operator: &Operator,
        output: usize,
        window: Window,
    ) -> Option<Layer> {
        let input = |index: usize| operator.inputs.get(index).copied().flatten();
        let kernel = input(1)?;
        let &[1, height, width, _] = &self.model.tensors[kernel].shape[..] else {
            return None;
        };
        let windows = self.windows(input(0)?, output, [height, width], window)?;
        let channels = windows.output.channels;
        let length = windows.taps() * channels;
        let kernel = self.constants[kernel].filter(|k| k.len() == length)?.to_vec();
        let bias = self.bias(input(2), channels)?;
        let (panels, activation) = (Vec::new(), window.activation);
        let convolution = Convolution { windows, kernel, panels, bias, activation };
        (convolution.windows.input.channels == channels)
            .then_some(Layer::DepthwiseConvolution(convolution))
    }

    fn bias(&self, tensor: Option<usize>, outputs: usize) -> Option<Vec<f32>> {
        let Some(tensor) = tensor else { return Some(vec![0.0; outputs]) };
        self.constants[tensor].filter(|bias| bias.len() == outputs).map(<[f32]>::to_vec)
    }

    fn windows(
        &self,
        input: usize,
        output: usize,
        size: [usize; 2],
        window: Window,
    ) -> Option<Windows> {
        let (input, output) = (self.shape(input)?, self.shape(output)?);
        let [stride, dilation] =
            [window.stride, window.dilation].map(|axes| axes.map(|step| step as usize));
        let mut before = [0; 2];
        let lengths = [(input.height, output.height), (input.width, output.width)];
        for (axis, (from, to)) in lengths.into_iter().enumerate() {
            let reach = size[axis].checked_sub(1)?.checked_mul(dilation[axis])?.checked_add(1)?;
            let outputs = if window.is_same {
                from.div_ceil(stride[axis])
            } else {
                from.checked_sub(reach)? / stride[axis] + 1
            };
            if outputs != to {
                return None;
            }
            if window.is_same {
                // An odd number of rows to add has the larger half below.
                before[axis] = ((to - 1) * stride[axis] + reach).saturating_sub(from) / 2;
            }
        }
        // A window as large as this cannot lie on so small an input; products stay small.
        let is_sound = size.iter().all(|&side| side <= 64);
        is_sound.then_some(Windows { input, output, size, stride, dilation, before })
    }

    fn pad(&self, input: usize, output: usize, padding: usize) -> Option<Layer> {
        let Some(Values::I32(padding)) = &self.model.tensors[padding].constant else {
            return None;
        };
        let (from, to) = (self.shape(input)?, self.shape(output)?);
        let padding = padding.iter().map(|&count| usize::try_from(count).ok());
        let padding = padding.collect::<Option<Vec<_>>>()?;
        let &[0, 0, top, bottom, left, right, front, back] = &padding[..] else { return None };
        let sides = [
            (from.height, top, bottom, to.height),
            (from.width, left, right, to.width),
            (from.channels, front, back, to.channels),
        ];
        let is_right = sides.into_iter().all(|(from, before, after, to)| {
            from.checked_add(before).and_then(|sum| sum.checked_add(after)) == Some(to)
        });
        is_right.then_some(Layer::Pad { input: from, output: to, before: [top, left, front] })
    }

    fn concatenation(
        &self,
        operator: &Operator,
        output: usize,
        axis: i32,
        activation: Activation,
    ) -> Option<Layer> {
        let whole = &self.model.tensors[output].shape;
        let axis =
            if axis < 0 { axis.checked_add(i32::try_from(whole.len()).ok()?)? } else { axis };
        let axis = usize::try_from(axis).ok().filter(|&axis| axis < whole.len())?;
        let mut along = 0;
        let mut parts = Vec::new();
        for &input in &operator.inputs {
            let shape = &self.model.tensors[input?].shape;
            let is_right = shape.len() == whole.len()
                && (0..whole.len()).all(|other| other == axis || shape[other] == whole[other]);
            if !is_right {
                return None;
            }
            self.length(input?)?;
            along += shape[axis];
            parts.push(shape[axis..].iter().product());
        }
        (along == whole[axis]).then_some(Layer::Concatenation { parts, activation })
    }
}
