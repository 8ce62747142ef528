//! Streams both pictures through a network, a strip of rows at a time.
//!
//! Whole feature maps of large pictures do not fit into memory: VGG16's first ones take 4 GiB for
//! each 4096² picture. So both pictures pass through all layers together, strip by strip; between
//! two layers only those rows are kept that a window still needs. Nothing is computed twice, and
//! the strip height affects at most the last bits of the result.

use uvgraft::threads;

use super::difference::append_differences;
use super::layer::advance;
use super::maps::Map;
use super::network::{Layer, LayerKind};
use super::rows::Rows;
use super::weights::ConvolutionWeights;
use crate::Colors;

/// Texels of a picture in one strip. The maps of the deep layers are 1/16 as wide and high; larger
/// strips give them enough texels to divide among threads, but need more memory.
const STRIP_TEXELS: usize = 1 << 17;

/// Offset and divisor of the official scaling layer, for values in `-1.0..=1.0`.
const SHIFT: [f32; 3] = [-0.030, -0.088, -0.188];
const SCALE: [f32; 3] = [0.458, 0.448, 0.450];

/// Rows of a picture in one strip. Depends only on the width, so that results depend
/// on nothing else.
pub(super) const fn strip_rows(width: u32) -> usize {
    STRIP_TEXELS.div_ceil(width as usize)
}

/// The difference maps of all compared layers, computed in strips of `strip` rows.
pub(super) fn differences(
    layers: &[Layer],
    convolutions: &[ConvolutionWeights],
    linear: &[Vec<f32>],
    pictures: [&Colors; 2],
    strip: usize,
) -> Vec<Map> {
    let size = pictures[0].size();
    let (width, height) = (size.width as usize, size.height as usize);
    let mut maps = vec![Rows::new(width, height, 3)];
    for (layer, before) in layers.iter().enumerate() {
        let input = &maps[layer];
        let [width, height] = [input.width, input.height].map(|side| before.window.outputs(side));
        maps.push(Rows::new(width, height, before.channels_after(input.channels)));
    }
    let mut found: Vec<Map> = layers
        .iter()
        .zip(&maps[1..])
        .filter(|(layer, _)| layer.compared)
        .map(|(_, rows)| Map::new(rows.width, rows.height))
        .collect();

    for start in (0..height).step_by(strip) {
        append_scaled(&mut maps[0], pictures, (start + strip).min(height));
        let (mut convolutions, mut compared) = (convolutions.iter(), found.iter_mut().zip(linear));
        for (index, layer) in layers.iter().enumerate() {
            let weights = match layer.kind {
                LayerKind::Convolution { .. } => convolutions.next(),
                LayerKind::Pool => None,
            };
            let (before, after) = maps.split_at_mut(index + 1);
            let (input, output) = (&mut before[index], &mut after[0]);
            let first_new = output.end();
            advance(layer, weights, input, output);
            if layer.compared
                && let Some((map, weights)) = compared.next()
            {
                append_differences(map, output, first_new, weights);
            }
        }
        let last = &mut maps[layers.len()];
        last.forget_before(last.end());
    }
    found
}

/// Appends the pictures' rows up to `end`, scaled from `0.0..=1.0` to the networks' input range.
fn append_scaled(rows: &mut Rows, pictures: [&Colors; 2], end: usize) {
    let (first, length) = (rows.end(), rows.row_length());
    let width = length / 3;
    threads::for_each_chunk(rows.extend_to(end), length, |index, values| {
        let start = (first + index / 2) * width;
        let texels = pictures[index % 2].values(start..start + width);
        for (scaled, texel) in values.chunks_exact_mut(3).zip(texels.chunks_exact(3)) {
            for channel in 0..3 {
                let signed = 2.0 * texel[channel] - 1.0;
                scaled[channel] = (signed - SHIFT[channel]) / SCALE[channel];
            }
        }
    });
}
