//! Timing of stages that run in turn.

use std::hint::black_box;
use std::time::Instant;

use serde::Serialize;

use super::stage::Stage;

/// Times of one stage, in milliseconds.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Times {
    pub(super) median_ms: f64,
    pub(super) min_ms: f64,
    pub(super) max_ms: f64,
    /// In order of measurement.
    pub(super) times_ms: Vec<f64>,
}

impl Times {
    fn new(seconds: &[f64]) -> Self {
        let times_ms: Vec<f64> = seconds.iter().map(|seconds| seconds * 1e3).collect();
        let mut sorted = times_ms.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let middle = sorted.len() / 2;
        let median_ms = match sorted.len() % 2 {
            0 => (sorted[middle - 1] + sorted[middle]) / 2.0,
            _ => sorted[middle],
        };
        Self { median_ms, min_ms: sorted[0], max_ms: sorted[sorted.len() - 1], times_ms }
    }
}

/// Runs every stage once per round, in `runs` rounds after one warm-up round, which finds cold
/// caches and unmapped memory.
pub(super) fn rounds(stages: &mut [Stage<'_>], runs: u32) -> anyhow::Result<Vec<Times>> {
    let mut seconds = vec![Vec::new(); stages.len()];
    for round in 0..=runs {
        for (stage, seconds) in stages.iter_mut().zip(&mut seconds) {
            let taken = (stage.work)()?;
            if round > 0 {
                seconds.push(taken);
            }
        }
    }
    Ok(seconds.iter().map(|seconds| Times::new(seconds)).collect())
}

/// The result of `work`, and its duration in seconds. The caller drops the result, outside the
/// timing.
pub(crate) fn time<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = black_box(work());
    (result, start.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        let odd = Times::new(&[0.003, 0.001, 0.002]);
        assert_eq!((odd.min_ms, odd.median_ms, odd.max_ms), (1.0, 2.0, 3.0));
        let even = Times::new(&[0.004, 0.001, 0.002, 0.003]);
        assert_eq!((even.min_ms, even.median_ms, even.max_ms), (1.0, 2.5, 4.0));
        assert_eq!(even.times_ms, [4.0, 1.0, 2.0, 3.0]);
    }
}
