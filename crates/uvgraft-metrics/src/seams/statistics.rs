//! Statistics of colour differences, weighted by length.

/// Distribution of colour differences in ΔE₀₀. Each point is weighted by the length of edge
/// that it represents.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct StepStatistics {
    /// The mean.
    pub mean: f64,
    /// Median: half of the length has at most this step.
    pub median: f64,
    /// 95th percentile by length.
    pub p95: f64,
    /// 99th percentile by length.
    pub p99: f64,
    /// The largest.
    pub max: f64,
}

impl StepStatistics {
    /// Statistics of `(step, weight)` pairs in any order; `None` if the total weight is zero.
    ///
    /// A percentile is the smallest step at which the cumulative weight reaches the
    /// requested share.
    pub(super) fn of(mut steps: Vec<(f64, f64)>) -> Option<Self> {
        steps.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let total: f64 = steps.iter().map(|(_, weight)| weight).sum();
        let sum: f64 = steps.iter().map(|(step, weight)| step * weight).sum();
        let &(max, _) = steps.last()?;
        if total <= 0.0 {
            return None;
        }
        let mut cumulated = steps.iter().scan(0.0, |reached, &(step, weight)| {
            *reached += weight;
            Some((*reached, step))
        });
        let mut last = (0.0, 0.0);
        let mut at = |share: f64| {
            // Slack for shares that a whole number of equal weights reaches except for rounding. A
            // share of 1.0 is reached without it, since the cumulative sum runs in the same order
            // as `total`.
            while last.0 < share * total * (1.0 - 1e-12) {
                match cumulated.next() {
                    Some(next) => last = next,
                    None => break,
                }
            }
            last.1
        };
        let [median, p95, p99] = [0.5, 0.95, 0.99].map(&mut at);
        Some(Self { mean: sum / total, median, p95, p99, max })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_length() {
        let even =
            StepStatistics::of((0..=100).rev().map(|k| (f64::from(k), 0.1)).collect()).unwrap();
        assert_eq!([even.median, even.p95, even.p99, even.max], [50.0, 95.0, 99.0, 100.0]);
        assert!((even.mean - 50.0).abs() < 1e-9);
        // A long edge with a small step, a short one with a large step.
        let StepStatistics { mean, median, p95, p99, max } =
            StepStatistics::of(vec![(20.0, 1.0), (1.0, 24.0)]).unwrap();
        assert_eq!([mean, median, p95, p99, max], [1.76, 1.0, 1.0, 20.0, 20.0]);
        let halves = StepStatistics::of(vec![(3.0, 0.7), (1.0, 0.7)]).unwrap();
        assert_eq!((halves.median, halves.p95), (1.0, 3.0));
    }

    #[test]
    fn none_of_nothing() {
        assert_eq!(StepStatistics::of(vec![]), None);
        assert_eq!(StepStatistics::of(vec![(1.0, 0.0)]), None);
    }
}
