//! A palette for a set of pictures.
//!
//! # Source
//! Heckbert, "Color Image Quantization for Frame Buffer Display", 1982, with two changes: always
//! the box with the largest error is split, and at its mean. Then Lloyd's iteration moves each
//! colour to the mean of the colours nearest to it.

use std::collections::HashMap;

use uvgraft::threads;

/// Maximum number of colours; one more index is left for transparency.
pub(super) const MAX: usize = 255;

/// Colours with a lookup of the nearest.
#[derive(Debug)]
pub(super) struct Palette {
    colors: Vec<[u8; 3]>,
    /// One list per channel, for SIMD.
    channels: [Vec<i32>; 3],
}

#[derive(Debug, Clone, Copy)]
struct Bin {
    color: [f32; 3],
    count: f32,
}

/// Error weights of the channels: the eye is most sensitive to green and least to blue.
const WEIGHTS: [f32; 3] = [0.8, 1.2, 0.55];

impl Palette {
    /// Builds a palette for some pixels, which may be a sample.
    pub fn new(pixels: impl Iterator<Item = [u8; 3]>) -> Self {
        let mut counts: HashMap<[u8; 3], ([u32; 3], u32)> = HashMap::new();
        for pixel in pixels {
            // Six bits per channel are enough to distinguish colours.
            let (sum, count) = counts.entry(pixel.map(|value| value >> 2)).or_default();
            *sum = [0, 1, 2].map(|k| sum[k] + u32::from(pixel[k]));
            *count += 1;
        }
        let mut cells: Vec<_> = counts.into_iter().collect();
        // The order of a hash map is random.
        cells.sort_unstable_by_key(|cell| cell.0);
        let mut bins: Vec<Bin> = cells
            .into_iter()
            .map(|(_, (sum, count))| Bin {
                color: sum.map(|sum| sum as f32 / count as f32),
                // A power below 1 gives rare colours more weight, or small objects would lose
                // theirs.
                count: (count as f32).powf(0.7),
            })
            .collect();
        let mut centres = split(&mut bins);
        for _ in 0..4 {
            centres = refined(&bins, &centres);
        }
        let mut colors: Vec<[u8; 3]> =
            centres.iter().map(|color| color.map(|value| value.round() as u8)).collect();
        colors.sort_unstable();
        colors.dedup();
        if colors.is_empty() {
            colors.push([0; 3]);
        }
        let channels = [0, 1, 2].map(|k| colors.iter().map(|c| i32::from(c[k])).collect());
        Self { colors, channels }
    }

    pub fn colors(&self) -> &[[u8; 3]] {
        &self.colors
    }

    /// The index of the nearest colour.
    pub fn nearest(&self, color: [i32; 3]) -> u8 {
        let [reds, greens, blues] = &self.channels;
        let (mut best, mut least) = (0, i32::MAX);
        for (index, ((r, g), b)) in reds.iter().zip(greens).zip(blues).enumerate() {
            let [dr, dg, db] = [r - color[0], g - color[1], b - color[2]];
            let distance = 8 * dr * dr + 12 * dg * dg + 5 * db * db;
            if distance < least {
                (best, least) = (index, distance);
            }
        }
        best as u8
    }
}

/// The mean colours of boxes, split until there are enough.
fn split(bins: &mut [Bin]) -> Vec<[f32; 3]> {
    let mut boxes = vec![(error(bins), bins)];
    while boxes.len() < MAX {
        let worst =
            (0..boxes.len()).fold(0, |w, k| if boxes[k].0.0 > boxes[w].0.0 { k } else { w });
        if boxes.get(worst).is_none_or(|(error, bins)| error.0 <= 0.0 || bins.len() < 2) {
            break;
        }
        let ((_, axis), bins) = boxes.swap_remove(worst);
        bins.sort_by(|a, b| a.color[axis].total_cmp(&b.color[axis]));
        let cut = mean(bins)[axis];
        let at = bins.partition_point(|bin| bin.color[axis] < cut).clamp(1, bins.len() - 1);
        let (low, high) = bins.split_at_mut(at);
        boxes.push((error(low), low));
        boxes.push((error(high), high));
    }
    boxes.iter().map(|(_, bins)| mean(bins)).collect()
}

fn mean(bins: &[Bin]) -> [f32; 3] {
    let count: f32 = bins.iter().map(|bin| bin.count).sum();
    [0, 1, 2]
        .map(|k| bins.iter().map(|bin| bin.color[k] * bin.count).sum::<f32>() / count.max(1e-9))
}

/// The weighted sum of squared deviations, and the axis with the largest share.
fn error(bins: &[Bin]) -> (f32, usize) {
    let mean = mean(bins);
    let squares = [0, 1, 2].map(|k| {
        let square = |bin: &Bin| bin.count * (bin.color[k] - mean[k]).powi(2);
        WEIGHTS[k] * bins.iter().map(square).sum::<f32>()
    });
    let axis = (0..3).fold(0, |best, k| if squares[k] > squares[best] { k } else { best });
    (squares.iter().sum(), axis)
}

/// One step of Lloyd's iteration: moves each centre to the mean of the bins nearest to it.
fn refined(bins: &[Bin], centres: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let nearest = threads::map_indices(bins.len(), |bin| {
        let color = bins[bin].color;
        let distance = |centre: &[f32; 3]| {
            (0..3).map(|k| WEIGHTS[k] * (centre[k] - color[k]).powi(2)).sum::<f32>()
        };
        let mut best = (0, f32::MAX);
        for (index, centre) in centres.iter().enumerate() {
            let distance = distance(centre);
            if distance < best.1 {
                best = (index, distance);
            }
        }
        best.0
    });
    let mut sums = vec![([0.0; 3], 0.0); centres.len()];
    for (bin, &index) in bins.iter().zip(&nearest) {
        let (sum, count) = &mut sums[index];
        *sum = [0, 1, 2].map(|k| sum[k] + bin.color[k] * bin.count);
        *count += bin.count;
    }
    let moved = sums.into_iter().zip(centres);
    moved
        .map(|((sum, count), &centre)| if count > 0.0 { sum.map(|s| s / count) } else { centre })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_kept_as_they_are() {
        let colors = [[0, 0, 0], [255, 0, 0], [12, 200, 99], [255, 255, 255]];
        let palette = Palette::new(colors.into_iter().cycle().take(400));
        assert_eq!(palette.colors().len(), 4);
        for color in colors {
            let index = palette.nearest(color.map(i32::from));
            assert_eq!(palette.colors()[usize::from(index)], color);
        }
    }

    #[test]
    fn many_colours_are_met_closely() {
        let gradient = |k: u32| [(k % 256) as u8, (k / 256 * 4) as u8, 128];
        let palette = Palette::new((0..16_384).map(gradient));
        assert!(palette.colors().len() > 200);
        let worst = (0..16_384).map(gradient).map(|color| {
            let index = palette.nearest(color.map(i32::from));
            let near = palette.colors()[usize::from(index)];
            (0..3).map(|k| near[k].abs_diff(color[k])).max().unwrap()
        });
        // 255 squares over 256 × 256 colours are 16 wide.
        assert!(worst.max().unwrap() <= 20);
    }
}
