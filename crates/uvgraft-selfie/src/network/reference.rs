//! The scalar reference: what each layer computes. Written to be read, never tuned; the fast path
//! adds in the same order and is tested to give the same bits.

use crate::tflite::Activation;

use super::layer::{Convolution, Shape, Windows};

/// A value after an activation.
#[inline(always)]
pub(super) fn activate(activation: Activation, value: f32) -> f32 {
    match activation {
        Activation::None => value,
        Activation::Relu => value.max(0.0),
        Activation::ReluOne => value.clamp(-1.0, 1.0),
        Activation::ReluSix => value.clamp(0.0, 6.0),
    }
}

/// Full convolution.
pub(super) fn convolve(layer: &Convolution, input: &[f32], output: &mut [f32]) {
    let Convolution { windows, kernel, bias, activation, .. } = layer;
    let (channels, outputs) = (windows.input.channels, windows.output.channels);
    for (index, value) in output.iter_mut().enumerate() {
        let (texel, to) = (index / outputs, index % outputs);
        let (row, column) = (texel / windows.output.width, texel % windows.output.width);
        let mut sum = bias[to];
        for tap in 0..windows.taps() {
            let (down, right) = (tap / windows.size[1], tap % windows.size[1]);
            let (y, x) = (windows.position(0, row, down), windows.position(1, column, right));
            let (Some(y), Some(x)) = (y, x) else { continue };
            for from in 0..channels {
                sum += input[(y * windows.input.width + x) * channels + from]
                    * kernel[(to * windows.taps() + tap) * channels + from];
            }
        }
        *value = activate(*activation, sum);
    }
}

/// Depthwise convolution.
pub(super) fn convolve_depthwise(layer: &Convolution, input: &[f32], output: &mut [f32]) {
    let Convolution { windows, kernel, bias, activation, .. } = layer;
    let channels = windows.input.channels;
    for (index, value) in output.iter_mut().enumerate() {
        let (texel, channel) = (index / channels, index % channels);
        let (row, column) = (texel / windows.output.width, texel % windows.output.width);
        let mut sum = bias[channel];
        for tap in 0..windows.taps() {
            let (down, right) = (tap / windows.size[1], tap % windows.size[1]);
            let (y, x) = (windows.position(0, row, down), windows.position(1, column, right));
            let (Some(y), Some(x)) = (y, x) else { continue };
            sum += input[(y * windows.input.width + x) * channels + channel]
                * kernel[tap * channels + channel];
        }
        *value = activate(*activation, sum);
    }
}

/// Max pooling. Texels outside the input do not count.
pub(super) fn max_pool(
    windows: &Windows,
    activation: Activation,
    input: &[f32],
    output: &mut [f32],
) {
    let channels = windows.input.channels;
    for (texel, values) in output.chunks_exact_mut(channels).enumerate() {
        let (row, column) = (texel / windows.output.width, texel % windows.output.width);
        values.fill(f32::NEG_INFINITY);
        for tap in 0..windows.taps() {
            let (down, right) = (tap / windows.size[1], tap % windows.size[1]);
            let (y, x) = (windows.position(0, row, down), windows.position(1, column, right));
            let (Some(y), Some(x)) = (y, x) else { continue };
            let start = (y * windows.input.width + x) * channels;
            for (value, &seen) in values.iter_mut().zip(&input[start..start + channels]) {
                *value = value.max(seen);
            }
        }
        values.iter_mut().for_each(|value| *value = activate(activation, *value));
    }
}

/// Zeros around a tensor.
pub(super) fn pad(from: Shape, to: Shape, before: [usize; 3], input: &[f32], output: &mut [f32]) {
    for row in 0..from.height {
        for column in 0..from.width {
            let start = (row * from.width + column) * from.channels;
            let place = (row + before[0]) * to.width + column + before[1];
            let place = place * to.channels + before[2];
            output[place..place + from.channels]
                .copy_from_slice(&input[start..start + from.channels]);
        }
    }
}

/// Parts of each input in turn.
pub(super) fn concatenate(
    parts: &[usize],
    activation: Activation,
    inputs: &[&[f32]],
    output: &mut [f32],
) {
    let whole: usize = parts.iter().sum();
    for (index, values) in output.chunks_exact_mut(whole).enumerate() {
        let mut rest = values;
        for (&part, input) in parts.iter().zip(inputs) {
            let (front, back) = rest.split_at_mut(part);
            front.copy_from_slice(&input[index * part..][..part]);
            rest = back;
        }
    }
    output.iter_mut().for_each(|value| *value = activate(activation, *value));
}
