//! Compares the streaming network with a plain one: whole maps, nested loops, sums in `f64`.

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Size, Texels, Texture};

use super::network::{Layer, LayerKind, LpipsNetwork, Window};
use super::stream::differences;
use super::*;
use crate::testing::{mask, noise};

/// Streamed sums are `f32` and in a different order; the largest deviation seen is 1e-5.
const TOLERANCE: f64 = 1e-4;

/// A whole feature map: `[height, width, channels]`.
struct Features {
    width: usize,
    height: usize,
    channels: usize,
    values: Vec<f64>,
}

impl Features {
    fn of(picture: &Colors) -> Self {
        let values = picture.values(0..picture.size().texels());
        let scaled = values.chunks_exact(3).flat_map(|texel| {
            [
                (f64::from(texel[0]) * 2.0 - 1.0 + 0.030) / 0.458,
                (f64::from(texel[1]) * 2.0 - 1.0 + 0.088) / 0.448,
                (f64::from(texel[2]) * 2.0 - 1.0 + 0.188) / 0.450,
            ]
        });
        let Size { width, height } = picture.size();
        Self {
            width: width as usize,
            height: height as usize,
            channels: 3,
            values: scaled.collect(),
        }
    }

    /// A value, or `beside` outside the map.
    fn get(&self, y: isize, x: isize, channel: usize, beside: f64) -> f64 {
        let (Ok(y), Ok(x)) = (usize::try_from(y), usize::try_from(x)) else { return beside };
        if y >= self.height || x >= self.width {
            return beside;
        }
        self.values[(y * self.width + x) * self.channels + channel]
    }

    fn texel(&self, index: usize) -> &[f64] {
        &self.values[index * self.channels..(index + 1) * self.channels]
    }

    fn after(&self, layer: &Layer, weights: Option<&ConvolutionWeights>) -> Self {
        let Window { side, stride, padding } = layer.window;
        let [width, height] = [self.width, self.height].map(|side| layer.window.outputs(side));
        let channels = layer.channels_after(self.channels);
        let mut values = Vec::new();
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            for channel in 0..channels {
                let mut sum = weights.map_or(0.0, |weights| f64::from(weights.bias[channel]));
                let mut greatest = f64::NEG_INFINITY;
                for (down, right) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
                    let at = |place: usize, step: usize| {
                        (place * stride + step) as isize - padding as isize
                    };
                    let (y, x) = (at(y, down), at(x, right));
                    let Some(weights) = weights else {
                        greatest = greatest.max(self.get(y, x, channel, f64::NEG_INFINITY));
                        continue;
                    };
                    for input in 0..self.channels {
                        let place = ((down * side + right) * self.channels + input) * channels;
                        sum +=
                            f64::from(weights.kernel[place + channel]) * self.get(y, x, input, 0.0);
                    }
                }
                values.push(if weights.is_some() { sum.max(0.0) } else { greatest });
            }
        }
        Self { width, height, channels, values }
    }
}

/// The differences in each compared layer.
fn plain(
    layers: &[Layer],
    convolutions: &[ConvolutionWeights],
    linear: &[Vec<f32>],
    pictures: [&Colors; 2],
) -> Vec<Vec<f64>> {
    let mut features = pictures.map(Features::of);
    let (mut convolutions, mut linear) = (convolutions.iter(), linear.iter());
    let mut found = Vec::new();
    for layer in layers {
        let weights = match layer.kind {
            LayerKind::Convolution { .. } => convolutions.next(),
            LayerKind::Pool => None,
        };
        features = features.map(|features| features.after(layer, weights));
        if !layer.compared {
            continue;
        }
        let weights = linear.next().unwrap();
        let [a, b] = &features;
        let difference = |index: usize| {
            let [a, b] = [a, b].map(|features| {
                let texel = features.texel(index);
                let length = texel.iter().map(|value| value * value).sum::<f64>().sqrt() + 1e-10;
                texel.iter().map(|value| value / length).collect::<Vec<_>>()
            });
            let squared = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2));
            squared.zip(weights).map(|(squared, &weight)| squared * f64::from(weight)).sum()
        };
        found.push((0..a.width * a.height).map(difference).collect());
    }
    found
}

/// Random weights, scaled so that signals survive many layers.
fn random_weights(layers: &[Layer], seed: u64) -> (Vec<ConvolutionWeights>, Vec<Vec<f32>>) {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut values = |count: usize, low: f32, high: f32| -> Vec<f32> {
        (0..count).map(|_| low + (high - low) * random.f32()).collect()
    };
    let (mut convolutions, mut linear, mut channels) = (Vec::new(), Vec::new(), 3);
    for layer in layers {
        if let LayerKind::Convolution { inputs, outputs } = layer.kind {
            let seen = layer.window.side.pow(2) * inputs;
            let high = (6.0 / seen as f32).sqrt();
            convolutions.push(ConvolutionWeights {
                kernel: values(seen * outputs, -high, high),
                bias: values(outputs, -0.1, 0.1),
            });
        }
        channels = layer.channels_after(channels);
        if layer.compared {
            linear.push(values(channels, 0.0, 1.0));
        }
    }
    (convolutions, linear)
}

fn assert_near(found: &[super::maps::Map], wanted: &[Vec<f64>], case: &str) {
    assert_eq!(found.len(), wanted.len(), "{case}");
    for (layer, (found, wanted)) in found.iter().zip(wanted).enumerate() {
        assert_eq!(found.values.len(), wanted.len(), "{case}, map {layer}");
        for (place, (&found, &wanted)) in found.values.iter().zip(wanted).enumerate() {
            let far = (f64::from(found) - wanted).abs() > TOLERANCE;
            assert!(!far, "{case}, map {layer}, texel {place}: {found}, wanted {wanted}");
        }
    }
}

/// The window shapes of both networks with few channels, in numbers that are not multiples of
/// eight.
fn small_networks() -> [Vec<Layer>; 2] {
    [
        vec![
            Layer::convolution(3, 9, [11, 4, 2]).compared(),
            Layer::pool(3, 2),
            Layer::convolution(9, 10, [5, 1, 2]).compared(),
            Layer::pool(3, 2),
            Layer::convolution(10, 5, [3, 1, 1]).compared(),
            Layer::convolution(5, 7, [3, 1, 1]).compared(),
        ],
        vec![
            Layer::convolution(3, 4, [3, 1, 1]),
            Layer::convolution(4, 6, [3, 1, 1]).compared(),
            Layer::pool(2, 2),
            Layer::convolution(6, 11, [3, 1, 1]).compared(),
            Layer::pool(2, 2),
            Layer::convolution(11, 8, [3, 1, 1]),
            Layer::convolution(8, 8, [3, 1, 1]).compared(),
        ],
    ]
}

#[test]
fn strips_of_any_height_equal_whole_maps() {
    for (network, layers) in small_networks().iter().enumerate() {
        let (convolutions, linear) = random_weights(layers, 5);
        for (width, height) in [(31, 31), (32, 47), (45, 33), (70, 63), (35, 130)] {
            let size = Size::new(width, height);
            let (a, b) = (noise((size.width, size.height), 1), noise((size.width, size.height), 2));
            let wanted = plain(layers, &convolutions, &linear, [&a, &b]);
            for strip in [1, 2, 7, 16, 31, 1000] {
                let found = differences(layers, &convolutions, &linear, [&a, &b], strip);
                let case = format!("network {network}, {size}, strips of {strip}");
                assert_near(&found, &wanted, &case);
            }
        }
    }
}

#[test]
fn the_real_layers_at_their_least_sizes() {
    for network in LpipsNetwork::ALL {
        let layers = network.layers();
        let (convolutions, linear) = random_weights(layers, 9);
        let least = network.least_side();
        let size = Size::new(least, least + 3);
        let (a, b) = (noise((size.width, size.height), 1), noise((size.width, size.height), 2));
        let wanted = plain(layers, &convolutions, &linear, [&a, &b]);
        let weights = LpipsWeights::new(network, convolutions, linear).unwrap();
        let maps = Lpips::new(weights).compare(&a, &b).unwrap();
        let mean = wanted.iter().map(|map| map.iter().sum::<f64>() / map.len() as f64).sum::<f64>();
        assert!((maps.mean() - mean).abs() < TOLERANCE, "{network}");
        assert!(mean > 0.1, "{network}: the signal died");
    }
}

#[test]
fn equal_pictures_have_distance_zero() {
    let layers = LpipsNetwork::Alex.layers();
    let (convolutions, linear) = random_weights(layers, 3);
    let weights = LpipsWeights::new(LpipsNetwork::Alex, convolutions, linear).unwrap();
    let lpips = Lpips::new(weights);
    let size = Size::new(64, 40);
    let picture = noise((size.width, size.height), 4);
    let maps = lpips.compare(&picture, &picture).unwrap();
    let mask = mask((size.width, size.height), |_, _| true);
    assert_eq!((maps.mean(), maps.masked_mean(&mask).unwrap()), (0.0, 0.0));

    let other = noise((64, 41), 4);
    let refused = lpips.compare(&picture, &other).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "the second texture must have the size of the first texture, 64×40, got 64×41"
    );
    let small = noise((64, 30), 4);
    let refused = lpips.compare(&small, &small).unwrap_err();
    assert_eq!(refused.to_string(), "LPIPS needs images of at least 31 texels per side, got 64×30");
    let mut values = vec![0.5; size.texels() * 3];
    values[(64 * 5 + 7) * 3] = -2e6;
    let texture = Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::F32(values));
    let refused = lpips.compare(&Colors::new(texture.unwrap()).unwrap(), &picture).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "texel (7, 5) is outside the range of LPIPS, -1000000 to 1000000"
    );
}
