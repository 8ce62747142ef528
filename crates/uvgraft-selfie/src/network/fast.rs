//! Convolutions as the processor likes them.
//!
//! A row of a convolution is a matrix product: windows of the input, gathered as rows ("im2col"), times
//! the kernel. It is computed in tiles of four texels and eight outputs, which stay in registers while
//! the windows are walked once. Additions keep the reference's order and are not fused with
//! multiplications, so the result has the same bits at every SIMD level.

use super::layer::Convolution;
use super::reference::activate;

/// Outputs in a panel of the kernel.
pub(super) const LANES: usize = 8;

/// Texels in a tile.
const TEXELS: usize = 4;

/// A kernel `[output][tap and input]` as `[panel][tap and input][output in the panel]`; the last panel
/// is filled up with zeros.
pub(super) fn panels(kernel: &[f32], outputs: usize) -> Vec<[f32; LANES]> {
    let length = kernel.len() / outputs;
    let panel = |first: usize| {
        (0..length).map(move |at| {
            std::array::from_fn(|lane| {
                let to = first + lane;
                if to < outputs { kernel[to * length + at] } else { 0.0 }
            })
        })
    };
    (0..outputs).step_by(LANES).flat_map(panel).collect()
}

/// Runs a kernel, compiled for AVX2 where there is AVX2.
#[inline(always)]
fn vectorized(kernel: impl FnOnce()) {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = fearless_simd::Level::new().as_avx2() {
        use fearless_simd::Simd as _;
        return simd.vectorize(kernel);
    }
    kernel();
}

/// Full convolution.
pub(super) fn convolve(layer: &Convolution, input: &[f32], output: &mut [f32]) {
    vectorized(
        #[inline(always)]
        || convolve_rows(layer, input, output),
    );
}

#[inline(always)]
fn convolve_rows(layer: &Convolution, input: &[f32], output: &mut [f32]) {
    let windows = &layer.windows;
    let length = windows.taps() * windows.input.channels;
    let row_length = windows.output.width * windows.output.channels;
    let is_direct = windows.size == [1; 2] && windows.stride == [1; 2] && windows.before == [0; 2];
    let mut gathered = Vec::new();
    for (row, output) in output.chunks_exact_mut(row_length).enumerate() {
        let patches = if is_direct {
            let row_length = windows.input.width * length;
            &input[row * row_length..][..row_length]
        } else {
            gathered.clear();
            gather_row(layer, input, row, &mut gathered);
            &gathered
        };
        multiply(layer, length, patches, output);
    }
}

/// The windows of one row of the output, one after the other, with zeros outside the input.
fn gather_row(layer: &Convolution, input: &[f32], row: usize, patches: &mut Vec<f32>) {
    let windows = &layer.windows;
    let channels = windows.input.channels;
    for column in 0..windows.output.width {
        for down in 0..windows.size[0] {
            let y = windows.position(0, row, down);
            for right in 0..windows.size[1] {
                match (y, windows.position(1, column, right)) {
                    (Some(y), Some(x)) => {
                        let start = (y * windows.input.width + x) * channels;
                        patches.extend_from_slice(&input[start..start + channels]);
                    }
                    _ => patches.resize(patches.len() + channels, 0.0),
                }
            }
        }
    }
}

/// The product of a row's windows, each of `length` values, and the kernel.
#[inline(always)]
fn multiply(layer: &Convolution, length: usize, patches: &[f32], output: &mut [f32]) {
    let outputs = layer.windows.output.channels;
    let tiles = patches.chunks(TEXELS * length).zip(output.chunks_mut(TEXELS * outputs));
    for (patches, output) in tiles {
        for (index, panel) in layer.panels.chunks_exact(length).enumerate() {
            let first = index * LANES;
            let count = LANES.min(outputs - first);
            let mut bias = [0.0; LANES];
            bias[..count].copy_from_slice(&layer.bias[first..first + count]);
            let mut sums = [bias; TEXELS];
            if patches.len() == TEXELS * length {
                tile(panel, patches, length, &mut sums);
            } else {
                for (patch, sums) in patches.chunks_exact(length).zip(&mut sums) {
                    single(panel, patch, sums);
                }
            }
            for (texel, sums) in output.chunks_exact_mut(outputs).zip(&sums) {
                for (value, &sum) in texel[first..first + count].iter_mut().zip(sums) {
                    *value = activate(layer.activation, sum);
                }
            }
        }
    }
}

/// Adds the products of one panel and four windows.
#[inline(always)]
fn tile(panel: &[[f32; LANES]], patches: &[f32], length: usize, sums: &mut [[f32; LANES]; TEXELS]) {
    let (a, rest) = patches.split_at(length);
    let (b, rest) = rest.split_at(length);
    let (c, d) = rest.split_at(length);
    let mut local = *sums;
    for ((((weights, &a), &b), &c), &d) in panel.iter().zip(a).zip(b).zip(c).zip(d) {
        for (sums, value) in local.iter_mut().zip([a, b, c, d]) {
            for lane in 0..LANES {
                sums[lane] += value * weights[lane];
            }
        }
    }
    *sums = local;
}

/// Adds the products of one panel and one window.
#[inline(always)]
fn single(panel: &[[f32; LANES]], patch: &[f32], sums: &mut [f32; LANES]) {
    for (weights, &value) in panel.iter().zip(patch) {
        for lane in 0..LANES {
            sums[lane] += value * weights[lane];
        }
    }
}

/// Depthwise convolution: all channels of a texel at once.
pub(super) fn convolve_depthwise(layer: &Convolution, input: &[f32], output: &mut [f32]) {
    vectorized(
        #[inline(always)]
        || convolve_depthwise_texels(layer, input, output),
    );
}

#[inline(always)]
fn convolve_depthwise_texels(layer: &Convolution, input: &[f32], output: &mut [f32]) {
    let Convolution { windows, kernel, bias, activation, .. } = layer;
    let channels = windows.input.channels;
    for (texel, sums) in output.chunks_exact_mut(channels).enumerate() {
        let (row, column) = (texel / windows.output.width, texel % windows.output.width);
        sums.copy_from_slice(bias);
        for down in 0..windows.size[0] {
            let Some(y) = windows.position(0, row, down) else { continue };
            for right in 0..windows.size[1] {
                let Some(x) = windows.position(1, column, right) else { continue };
                let values = &input[(y * windows.input.width + x) * channels..][..channels];
                let weights = &kernel[(down * windows.size[1] + right) * channels..][..channels];
                for ((sum, &value), &weight) in sums.iter_mut().zip(values).zip(weights) {
                    *sum += value * weight;
                }
            }
        }
        sums.iter_mut().for_each(|sum| *sum = activate(*activation, *sum));
    }
}
