//! Per-texel distance of two feature maps.

use uvgraft::threads;

use super::maps::Map;
use super::rows::Rows;

/// Keeps zero-length feature vectors finite, as the official code does.
const EPSILON: f32 = 1e-10;

/// Appends the differences of the two pictures' features, for the rows from `first` on.
pub(super) fn append_differences(map: &mut Map, features: &Rows, first: usize, weights: &[f32]) {
    let channels = features.channels;
    let new = map.extend_to(features.end());
    threads::for_each_chunk(new, features.width, |index, differences| {
        let [a, b] = [0, 1].map(|picture| features.row(Some(first + index), picture));
        let (Some(a), Some(b)) = (a, b) else { return };
        let texels = a.chunks_exact(channels).zip(b.chunks_exact(channels));
        for (difference, (a, b)) in differences.iter_mut().zip(texels) {
            *difference = weighted_difference(a, b, weights);
        }
    });
}

/// The weighted sum of squared differences of two feature vectors, each normalised to unit length.
fn weighted_difference(a: &[f32], b: &[f32], weights: &[f32]) -> f32 {
    let length = |values: &[f32]| {
        let squared = sum_in_lanes([values; 3], |value, _, _| value * value);
        squared.sqrt() + EPSILON
    };
    let (length_a, length_b) = (length(a), length(b));
    sum_in_lanes([a, b, weights], |a, b, weight| {
        let difference = a / length_a - b / length_b;
        weight * difference * difference
    })
}

/// The sum of a term over three equally long lists, in eight lanes. A single sum could not be
/// vectorised, because floating-point additions must keep their order.
fn sum_in_lanes(lists: [&[f32]; 3], term: impl Fn(f32, f32, f32) -> f32) -> f32 {
    let [(a, a_rest), (b, b_rest), (c, c_rest)] = lists.map(|list| list.as_chunks::<8>());
    let mut lanes = [0.0; 8];
    for ((a, b), c) in a.iter().zip(b).zip(c) {
        for lane in 0..8 {
            lanes[lane] += term(a[lane], b[lane], c[lane]);
        }
    }
    let rest = a_rest.iter().zip(b_rest).zip(c_rest);
    let rest: f32 = rest.map(|((&a, &b), &c)| term(a, b, c)).sum();
    lanes.iter().sum::<f32>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_matter_and_lengths_do_not() {
        let unit = |at: usize, length: f32| {
            let mut values = [0.0; 11];
            values[at] = length;
            values
        };
        let mut weights = [0.0; 11];
        (weights[2], weights[10]) = (3.0, 4.0);
        assert_eq!(weighted_difference(&unit(2, 5.0), &unit(2, 0.5), &weights), 0.0);
        assert_eq!(weighted_difference(&unit(2, 5.0), &unit(10, 9.0), &weights), 7.0);
        // A zero vector has no direction; its distance from a direction is that channel's weight.
        assert_eq!(weighted_difference(&[0.0; 11], &unit(10, 2.0), &weights), 4.0);
        assert_eq!(weighted_difference(&[0.0; 11], &[0.0; 11], &weights), 0.0);
    }
}
