//! Metrics against other implementations: `fixtures/metrics.json`.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::collections::BTreeMap;

use uvgraft_metrics::{self as metrics, Colors, Mask, MetricError};
use uvgraft_tests::fixtures::{self, Case};
use uvgraft_tests::{pictures, synthetic};

type Metric = fn(&Colors, &Colors, Option<&Mask>) -> Result<f64, MetricError>;

/// Metrics by their names in the fixtures, with the allowed difference.
const METRICS: &[(&str, Metric, f64)] = &[
    // Sums of floats; the remaining difference is that pictures are read as 32-bit floats.
    ("l1", metrics::l1, 1e-6),
    ("psnr", metrics::psnr, 1e-4),
    ("ssim", metrics::ssim, 1e-6),
    ("ssim-uniform", metrics::ssim_uniform, 1e-6),
    // In points out of 100. The other implementation blurs with a true Gaussian, this one with the
    // recursive filter of the metric's author; the largest difference found was 0.6.
    ("ssimulacra2", metrics::ssimulacra2, 1.0),
    // The same authors' code in two versions, both in 32-bit floats; the largest difference was
    // 5e-5.
    #[cfg(feature = "flip")]
    ("flip", metrics::flip, 1e-4),
];

#[test]
fn scores_equal_those_of_other_implementations() {
    let mut largest: BTreeMap<&str, f64> = BTreeMap::new();
    let mut pictures: BTreeMap<&str, Option<_>> = BTreeMap::new();
    let cases = fixtures::metrics();
    for Case { picture, distortion, mask, values } in &cases {
        let original = pictures.entry(picture).or_insert_with(|| pictures::picture(picture));
        let Some(original) = original.clone() else { continue };
        let mask = mask.as_ref().map(|name| pictures::mask(original.size(), name));
        let b = Colors::new(pictures::distorted(&original, distortion)).unwrap();
        let a = Colors::new(original).unwrap();
        for (name, metric, tolerance) in METRICS {
            // Not every implementation supports masks.
            let Some(wanted) = values.get(*name) else { continue };
            let found = metric(&a, &b, mask.as_ref()).unwrap();
            let difference = (found - wanted).abs();
            assert!(
                difference <= *tolerance,
                "{name} of {picture}, {distortion}, masked {}: {found}, wanted {wanted}",
                mask.is_some(),
            );
            let largest = largest.entry(name).or_default();
            *largest = largest.max(difference);
        }
    }
    println!("largest differences: {largest:?}");
    assert_eq!(largest.len(), METRICS.len(), "each metric was compared");
}

#[test]
fn threads_do_not_show() {
    let size = uvgraft::Size::new(700, 1300);
    let [a, b] = [3, 4].map(|seed| Colors::new(synthetic::detailed(size, seed)).unwrap());
    let mask = pictures::mask(size, "disc");
    for (name, metric, _) in METRICS {
        let with_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| [None, Some(&mask)].map(|mask| metric(&a, &b, mask).unwrap().to_bits()))
        };
        let one = with_threads(1);
        assert!(one == with_threads(2) && one == with_threads(5), "{name}");
    }
}
