//! The similarity transform that brings corresponding points closest together.
//!
//! Based on S. Umeyama, "Least-squares estimation of transformation parameters between two point
//! patterns", 1991.

use glam::{DMat3, DVec3};

use crate::rotation::Correlation;
use crate::statistics::median;

/// A rotation, a uniform scale and a translation: `p → scale · rotation · p + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// Factor of lengths, positive.
    pub scale: f64,
    /// A proper rotation: no reflection.
    pub rotation: DMat3,
    /// Added last.
    pub translation: DVec3,
}

impl Similarity {
    /// Leaves every point where it is.
    pub const IDENTITY: Self =
        Self { scale: 1.0, rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// The least-squares transform of the first points of `pairs` to the second ones.
    ///
    /// - `weights`: how much each pair counts, at least 0; as many as pairs.
    /// - `scales`: whether lengths may change; otherwise the scale is 1.
    ///
    /// `None` if fewer than three pairs count, or if either set of points lies on a line, so that
    /// no rotation is determined.
    pub fn between(pairs: &[[DVec3; 2]], weights: &[f64], scales: bool) -> Option<Self> {
        let total: f64 = weights.iter().sum();
        if weights.iter().filter(|&&weight| weight > 0.0).count() < 3 || !total.is_normal() {
            return None;
        }
        let mean = |side: usize| {
            let weighted = pairs.iter().zip(weights).map(|(pair, &weight)| pair[side] * weight);
            weighted.sum::<DVec3>() / total
        };
        let means = [mean(0), mean(1)];
        let mut correlation = Correlation::NONE;
        let mut spread = 0.0;
        for (pair, &weight) in pairs.iter().zip(weights) {
            let [from, to] = [pair[0] - means[0], pair[1] - means[1]];
            spread += weight * from.length_squared();
            correlation.add(from * weight, to);
        }
        if (0..2).any(|side| is_on_a_line(pairs, weights, side, means[side])) {
            return None;
        }
        let (rotation, agreement) = correlation.rotation();
        let scale = if scales { agreement / spread } else { 1.0 };
        let translation = means[1] - rotation * means[0] * scale;
        let is_sound = scale.is_normal() && scale > 0.0 && translation.is_finite();
        is_sound.then_some(Self { scale, rotation, translation })
    }

    /// As [`Similarity::between`], where some of the pairs are wrong: the median of the distances
    /// decides which ones count.
    pub fn robust(pairs: &[[DVec3; 2]], scales: bool) -> Option<Self> {
        /// Rounds of fitting and choosing; the choice settles within a few.
        const ROUNDS: usize = 5;
        /// Pairs farther apart than this many medians don't count. Origin not recorded.
        const REACH: f64 = 3.0;
        let mut weights = vec![1.0; pairs.len()];
        let mut found = Self::between(pairs, &weights, scales)?;
        for _ in 0..ROUNDS {
            let distances = found.distances(pairs);
            let reach = REACH * median(distances.iter().copied()).unwrap_or(0.0);
            for (weight, distance) in weights.iter_mut().zip(distances) {
                *weight = if distance <= reach { 1.0 } else { 0.0 };
            }
            found = Self::between(pairs, &weights, scales)?;
        }
        Some(found)
    }

    /// The transformed point.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.rotation * point * self.scale + self.translation
    }

    /// The transform as a homogeneous matrix, in rows.
    pub fn rows(&self) -> [[f64; 4]; 4] {
        let linear = self.rotation.transpose() * self.scale;
        let [x, y, z] = self.translation.to_array();
        [
            linear.x_axis.extend(x).to_array(),
            linear.y_axis.extend(y).to_array(),
            linear.z_axis.extend(z).to_array(),
            [0.0, 0.0, 0.0, 1.0],
        ]
    }

    /// How far each pair's points remain from each other, in the unit of the second ones.
    pub fn distances(&self, pairs: &[[DVec3; 2]]) -> Vec<f64> {
        pairs.iter().map(|&[from, to]| self.apply(from).distance(to)).collect()
    }
}

/// Whether the points of one side lie on a line through their mean, or at one place.
fn is_on_a_line(pairs: &[[DVec3; 2]], weights: &[f64], side: usize, mean: DVec3) -> bool {
    const THINNEST: f64 = 1e-6;
    let used = || pairs.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
    let edges = || used().map(|(pair, _)| pair[side] - mean);
    let longest = edges().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let Some(along) = longest.and_then(DVec3::try_normalize) else { return true };
    let length = longest.map_or(0.0, DVec3::length);
    edges().all(|edge| edge.cross(along).length() <= THINNEST * length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(seed: u64) -> Vec<DVec3> {
        let mut random = fastrand::Rng::with_seed(seed);
        (0..40).map(|_| DVec3::new(random.f64(), 2.0 * random.f64(), 3.0 * random.f64())).collect()
    }

    fn moved() -> Similarity {
        Similarity {
            scale: 250.0,
            rotation: DMat3::from_rotation_z(2.0) * DMat3::from_rotation_x(-1.0),
            translation: DVec3::new(3.0, -70.0, 9.0),
        }
    }

    #[test]
    fn a_transform_is_found_again_among_wrong_pairs() {
        let truth = moved();
        let mut pairs: Vec<[DVec3; 2]> =
            cloud(1).into_iter().map(|point| [point, truth.apply(point)]).collect();
        let close = |found: Similarity| {
            found.distances(&pairs[10..]).into_iter().all(|distance| distance < 1e-9)
        };
        assert!(close(Similarity::between(&pairs, &[1.0; 40], true).unwrap()));
        for (pair, wrong) in pairs.iter_mut().zip(cloud(2)).take(10) {
            pair[1] = wrong * 900.0;
        }
        let close = |found: Similarity| {
            found.distances(&pairs[10..]).into_iter().all(|distance| distance < 1e-9)
        };
        assert!(!close(Similarity::between(&pairs, &[1.0; 40], true).unwrap()));
        assert!(close(Similarity::robust(&pairs, true).unwrap()));
    }

    #[test]
    fn mirror_images_are_not_matched_by_a_reflection() {
        let pairs: Vec<[DVec3; 2]> = cloud(3)
            .into_iter()
            .map(|point| [point, DVec3::new(-point.x, point.y, point.z)])
            .collect();
        let found = Similarity::between(&pairs, &[1.0; 40], false).unwrap();
        assert!((found.rotation.determinant() - 1.0).abs() < 1e-12);
        assert!(median(found.distances(&pairs)).unwrap() > 0.1);
    }

    #[test]
    fn points_in_a_plane_are_enough_and_on_a_line_are_not() {
        let truth = moved();
        let of = |flat: fn(DVec3) -> DVec3| {
            let pairs: Vec<[DVec3; 2]> =
                cloud(4).into_iter().map(|point| [flat(point), truth.apply(flat(point))]).collect();
            let found = Similarity::between(&pairs, &[1.0; 40], true);
            found.map(|found| found.distances(&pairs).into_iter().fold(0.0, f64::max))
        };
        assert!(of(|point| DVec3::new(point.x, point.y, 0.0)).unwrap() < 1e-9);
        assert_eq!(of(|point| DVec3::new(point.x, 0.0, 0.0)), None);
        assert_eq!(of(|_| DVec3::ONE), None);
    }
}
