//! Order statistics of steps between colours, weighted by length.

/// How large steps between colours are, in ΔE₀₀; each point weighs as much as the length of edge
/// that it stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Steps {
    /// The mean.
    pub mean: f64,
    /// Half of the length is at most this.
    pub median: f64,
    /// 95 % of the length are at most this.
    pub p95: f64,
    /// 99 % of the length are at most this.
    pub p99: f64,
    /// The largest.
    pub max: f64,
}

impl Steps {
    /// Of steps and their weights, in any order; `None` if there is no weight at all.
    ///
    /// Percentiles are the smallest step at which the weight of all up to it reaches the share.
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
            // The sum of all in one order is `total` itself, so 1.0 would be found too; the slack is
            // for shares that whole numbers of equal weights reach but for rounding.
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
        let even = Steps::of((0..=100).rev().map(|k| (f64::from(k), 0.1)).collect()).unwrap();
        assert_eq!([even.median, even.p95, even.p99, even.max], [50.0, 95.0, 99.0, 100.0]);
        assert!((even.mean - 50.0).abs() < 1e-9);
        // A long edge with a small step, a short one with a large step.
        let Steps { mean, median, p95, p99, max } =
            Steps::of(vec![(20.0, 1.0), (1.0, 24.0)]).unwrap();
        assert_eq!([mean, median, p95, p99, max], [1.76, 1.0, 1.0, 20.0, 20.0]);
        let halves = Steps::of(vec![(3.0, 0.7), (1.0, 0.7)]).unwrap();
        assert_eq!((halves.median, halves.p95), (1.0, 3.0));
    }

    #[test]
    fn none_of_nothing() {
        assert_eq!(Steps::of(vec![]), None);
        assert_eq!(Steps::of(vec![(1.0, 0.0)]), None);
    }
}
