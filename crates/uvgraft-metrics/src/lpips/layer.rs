//! One layer of the network: computes all output rows for which enough input rows are available.

use ndarray::linalg::general_mat_mul;
use ndarray::{ArrayView2, ArrayViewMut2};
use uvgraft::threads;

use super::network::{Layer, Window};
use super::rows::Rows;
use super::weights::ConvolutionWeights;

/// Output texels per task of a convolution. Each task packs the kernel again, which does not pay
/// for fewer texels; with more, small deep maps would give too few tasks.
const CHUNK: usize = 128;

/// Number of output rows whose windows lie within the available input. At the last input row there
/// is nothing left to wait for.
fn ready(window: Window, input: &Rows) -> usize {
    let all = window.outputs(input.height);
    if input.end() == input.height {
        return all;
    }
    let rest = (input.end() + window.padding).checked_sub(window.side);
    rest.map_or(0, |rest| rest / window.stride + 1).min(all)
}

/// Appends the output rows that can be computed to `output`, and drops the input rows that are no
/// longer needed.
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

/// Convolution, bias and ReLU as a matrix product ("im2col"): the matrix of patches has a row for
/// each output texel, with all values in its window, and is multiplied by the kernel.
fn convolve(
    window: Window,
    weights: &ConvolutionWeights,
    input: &Rows,
    output: &mut Rows,
    end: usize,
) {
    let (first, width, channels) = (output.end(), output.width, output.channels);
    let patch_length = window.side * window.side * input.channels;
    let kernel = ArrayView2::from_shape((patch_length, channels), &weights.kernel)
        .expect("weights were checked against the network");
    let values = output.extend_to(end);
    threads::for_each_chunk(values, CHUNK * channels, |chunk, values| {
        let texels = values.len() / channels;
        let mut patches = Vec::with_capacity(texels * patch_length);
        for index in chunk * CHUNK..chunk * CHUNK + texels {
            let (row, picture, x) = (first + index / width / 2, index / width % 2, index % width);
            gather(window, input, row, picture, x, &mut patches);
        }
        for texel in values.chunks_exact_mut(channels) {
            texel.copy_from_slice(&weights.bias);
        }
        let patches = ArrayView2::from_shape((texels, patch_length), &patches)
            .expect("every window gives the same number of values");
        let mut sums = ArrayViewMut2::from_shape((texels, channels), &mut *values)
            .expect("pieces are whole texels");
        general_mat_mul(1.0, &patches, &kernel, 1.0, &mut sums);
        for value in values {
            *value = value.max(0.0);
        }
    });
}

/// Appends the values in the window of one output texel, with zeros outside the map.
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

/// Max pooling: the largest value of each channel in each window. Pools have no padding.
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
