//! LPIPS with the real networks against the package `lpips` 0.1.4.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::collections::BTreeMap;
use std::sync::LazyLock;

use uvgraft::{Channels, Encoding, Size, Texels, Texture};
use uvgraft_metrics::Colors;
use uvgraft_metrics::lpips::{ConvolutionWeights, Lpips, LpipsNetwork, LpipsWeights};
use uvgraft_metrics::lpips_weights::{self, sdist};
use uvgraft_tests::fixtures::{self, Case};
use uvgraft_tests::{downloads, pictures, synthetic};

/// Both sum in 32-bit floats in different orders; the largest difference found was 1e-7.
const TOLERANCE: f64 = 1e-5;

/// Both networks, imported, saved and read back; `None`, with a message, if they have not been
/// fetched.
static NETWORKS: LazyLock<Option<[Lpips; 2]>> = LazyLock::new(|| {
    let both = sdist::read(&downloads::lpips_sdist()?).unwrap();
    let bytes = lpips_weights::encode(&both).unwrap();
    Some(
        LpipsNetwork::ALL
            .map(|network| Lpips::new(lpips_weights::decode(&bytes, network).unwrap())),
    )
});

#[test]
fn a_photograph_and_its_blur() {
    let Some([alex, vgg]) = &*NETWORKS else { return };
    let Some(original) = downloads::photograph("astronaut") else { return };
    let b = Colors::new(blurred(&original, 2.0)).unwrap();
    let a = Colors::new(original).unwrap();
    for (lpips, wanted) in [(alex, 0.320_953), (vgg, 0.287_248)] {
        let found = lpips.compare(&a, &b).unwrap().mean();
        println!("{}: {found:.6}, wanted {wanted}", lpips.network());
        assert!((found - wanted).abs() < TOLERANCE, "{}: {found}", lpips.network());
    }
}

/// Compares with the fixtures that `takes` selects, and returns the largest difference.
fn compare_with_fixtures(lpips: &Lpips, takes: impl Fn(&Case) -> bool) -> f64 {
    let name = format!("lpips-{}", lpips.network());
    let mut known = BTreeMap::new();
    let mut largest: f64 = 0.0;
    let cases = fixtures::metrics();
    for case in cases.iter().filter(|case| takes(case)) {
        let Case { picture, distortion, mask, values } = case;
        let compared = known.entry((picture, distortion)).or_insert_with(|| {
            let original = pictures::picture(picture)?;
            let size = original.size();
            let b = Colors::new(pictures::distorted(&original, distortion)).unwrap();
            let a = Colors::new(original).unwrap();
            Some((size, lpips.compare(&a, &b).unwrap()))
        });
        let Some((size, maps)) = compared else { continue };
        let found = match mask {
            None => maps.mean(),
            Some(mask) => maps.masked_mean(&pictures::mask(*size, mask)).unwrap(),
        };
        let (wanted, case) = (values[&name], format!("{picture}, {distortion}, {mask:?}"));
        largest = largest.max((found - wanted).abs());
        assert!((found - wanted).abs() < TOLERANCE, "{name} of {case}: {found}, wanted {wanted}");
    }
    largest
}

#[test]
fn alex_equals_the_official_package() {
    let Some([alex, _]) = &*NETWORKS else { return };
    println!("largest difference: {:.1e}", compare_with_fixtures(alex, |_| true));
}

#[test]
fn vgg_equals_the_official_package() {
    let Some([_, vgg]) = &*NETWORKS else { return };
    // Photographs take seconds each, so only one is compared.
    let painted = ["gradients", "shapes", "cells"];
    let largest = compare_with_fixtures(vgg, |case| {
        painted.contains(&&*case.picture) || case.picture == "chelsea" && case.distortion == "noise"
    });
    println!("largest difference: {largest:.1e}");
}

#[test]
fn threads_do_not_show() {
    let network = LpipsNetwork::Alex;
    let mut random = fastrand::Rng::with_seed(8);
    let mut values = |count: usize, scale: f32| -> Vec<f32> {
        (0..count).map(|_| (random.f32() - 0.5) * scale).collect()
    };
    let convolutions = network.kernel_shapes().into_iter().map(|shape| ConvolutionWeights {
        kernel: values(shape.iter().product(), 0.1),
        bias: values(shape[3], 0.1),
    });
    let convolutions = convolutions.collect();
    let linear = network.compared_channels().into_iter().map(|count| values(count, 1.0)).collect();
    let lpips = Lpips::new(LpipsWeights::new(network, convolutions, linear).unwrap());
    // More rows than one pass through the network takes.
    let size = Size::new(400, 700);
    let [a, b] = [3, 4].map(|seed| Colors::new(synthetic::detailed(size, seed)).unwrap());
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| lpips.compare(&a, &b).unwrap())
    };
    let one = with_threads(1);
    assert!(one == with_threads(2) && one == with_threads(5));
    assert!(one.mean() != 0.0);
}

/// A Gaussian blur like scikit-image's: truncated at four standard deviations, the outermost texels
/// repeated beyond the edges, rounded to 8 bits.
fn blurred(picture: &Texture, deviation: f64) -> Texture {
    let Texels::U8(values) = picture.texels() else { panic!("8-bit pictures only") };
    let radius = (4.0 * deviation).round() as i64;
    let weights: Vec<f64> =
        (-radius..=radius).map(|k| (-0.5 * (k as f64 / deviation).powi(2)).exp()).collect();
    let sum: f64 = weights.iter().sum();
    let size = picture.size();
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    let pass = |values: &[f64], dx: i64, dy: i64| -> Vec<f64> {
        let value = |index: i64| {
            let (x, y, channel) = (index / 3 % width, index / 3 / width, index % 3);
            let terms = weights.iter().zip(-radius..).map(|(weight, k)| {
                let x = (x + k * dx).clamp(0, width - 1);
                let y = (y + k * dy).clamp(0, height - 1);
                weight * values[((y * width + x) * 3 + channel) as usize]
            });
            terms.sum::<f64>() / sum
        };
        (0..values.len() as i64).map(value).collect()
    };
    let values: Vec<f64> = values.iter().map(|&value| f64::from(value)).collect();
    let values = pass(&pass(&values, 0, 1), 1, 0);
    let texels = Texels::U8(values.into_iter().map(|value| value.round() as u8).collect());
    Texture::new(size, Channels::Rgb, Encoding::Srgb, texels).unwrap()
}
