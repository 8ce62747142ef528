//! One layer's step: from the rows that came in, the rows that they suffice for.

use ndarray::linalg::general_mat_mul;
use ndarray::{ArrayView2, ArrayViewMut2};
use uvgraft::threads;

use super::network::{Layer, Window};
use super::rows::Rows;
use super::weights::ConvolutionWeights;

/// Output texels of one piece of a convolution. Each piece packs the kernel anew, which fewer
/// texels would not pay for; more would leave deep, small maps in too few pieces.
const PIECE: usize = 128;

/// How many output rows there can be: all whose windows lie in the rows that came in. Below the
/// last row there is nothing to wait for.
fn ready(window: Window, input: &Rows) -> usize {
    let all = window.outputs(input.height);
    if input.end() == input.height {
        return all;
    }
    let rest = (input.end() + window.padding).checked_sub(window.side);
    rest.map_or(0, |rest| rest / window.stride + 1).min(all)
}

/// Appends to `output` what `input` suffices for, and forgets the input rows that this used up.
pub(super) fn advance(
    layer: &Layer,
    weights: Option<&ConvolutionWeights>,
    input: &mut Rows,
    output: &mut Rows,
) {
    let first = output.end();
    let end = ready(layer.window, input).max(first);
    match weights {
        Some(weights) => convolve(layer.window, weights, input, output, end),
        None => pool(layer.window, input, output, end),
    }
    input.forget_before((end * layer.window.stride).saturating_sub(layer.window.padding));
}

/// Convolution, bias and ReLU as a matrix product: a row for each output texel with all that its
/// window sees, times the kernel.
fn convolve(
    window: Window,
    weights: &ConvolutionWeights,
    input: &Rows,
    output: &mut Rows,
    end: usize,
) {
    let (first, width, channels) = (output.end(), output.width, output.channels);
    let seen = window.side * window.side * input.channels;
    let kernel = ArrayView2::from_shape((seen, channels), &weights.kernel)
        .expect("weights were checked against the network");
    let values = output.extend_to(end);
    threads::for_each_chunk(values, PIECE * channels, |piece, values| {
        let texels = values.len() / channels;
        let mut patches = Vec::with_capacity(texels * seen);
        for index in piece * PIECE..piece * PIECE + texels {
            let (row, picture, x) = (first + index / width / 2, index / width % 2, index % width);
            gather(window, input, row, picture, x, &mut patches);
        }
        for texel in values.chunks_exact_mut(channels) {
            texel.copy_from_slice(&weights.bias);
        }
        let patches = ArrayView2::from_shape((texels, seen), &patches)
            .expect("every window gives the same number of values");
        let mut sums = ArrayViewMut2::from_shape((texels, channels), &mut *values)
            .expect("pieces are whole texels");
        general_mat_mul(1.0, &patches, &kernel, 1.0, &mut sums);
        for value in values {
            *value = value.max(0.0);
        }
    });
}

/// Appends what the window of one output texel sees, with zeros beside the map.
fn gather(
    window: Window,
    input: &Rows,
    row: usize,
    picture: usize,
    x: usize,
    patches: &mut Vec<f32>,
) {
    let channels = input.channels;
    let left = x * window.stride;
    let zeros_before = window.padding.saturating_sub(left).min(window.side);
    let start = (left + zeros_before - window.padding).min(input.width);
    let stop = (left + window.side - window.padding).min(input.width).max(start);
    let zeros_after = window.side - zeros_before - (stop - start);
    for step in 0..window.side {
        let y = (row * window.stride + step).checked_sub(window.padding);
        if let Some(values) = input.row(y, picture) {
            patches.resize(patches.len() + zeros_before * channels, 0.0);
            patches.extend_from_slice(&values[start * channels..stop * channels]);
            patches.resize(patches.len() + zeros_after * channels, 0.0);
        } else {
            patches.resize(patches.len() + window.side * channels, 0.0);
        }
    }
}

/// The greatest value of each channel in each window; pools have no padding.
fn pool(window: Window, input: &Rows, output: &mut Rows, end: usize) {
    let (first, channels) = (output.end(), output.channels);
    let row_length = output.row_length();
    let values = output.extend_to(end);
    threads::for_each_chunk(values, row_length, |index, values| {
        let (row, picture) = (first + index / 2, index % 2);
        values.fill(f32::NEG_INFINITY);
        for step in 0..window.side {
            let Some(seen) = input.row(Some(row * window.stride + step), picture) else { break };
            for (x, greatest) in values.chunks_exact_mut(channels).enumerate() {
                let start = x * window.stride * channels;
                for seen in seen[start..start + window.side * channels].chunks_exact(channels) {
                    for (greatest, &seen) in greatest.iter_mut().zip(seen) {
                        *greatest = greatest.max(seen);
                    }
                }
            }
        }
    });
}
