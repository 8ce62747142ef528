//! Which colours of a body's texture are skin.
//!
//! Nothing here knows what colour skin has: colours along a face's border say so, most of which are
//! skin. Their densest half gives a first Gaussian, as in the minimum covariance determinant
//! (Rousseeuw and Van Driessen, "A fast algorithm for the minimum covariance determinant estimator",
//! Technometrics 1999). From there all colours of the body are weighted by it and make the next
//! one, a few times, so that it learns what skin is like on hands and legs.
//!
//! Colours are compared as `(r - g) / (s + d)`, `(b - g) / (s + d)` and `(s - m) / (s + m)`, where `s` is
//! `r + g + b`, `m` the skin's own, and `d` a little. Light and shadow scale all channels, also as
//! sRGB stores them (its curve is nearly a power), and leave the first two where they are; the third
//! is half the logarithm of how much lighter a colour is, nearly, at the cost of a division. `d` draws
//! colours near black, whose hue is noise, towards grey.

use nalgebra::{Matrix3, Vector3};

use super::statistics::{moments, quantile};

/// An estimate of which colours are skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinModel {
    /// `m`.
    lightness: f32,
    /// Where skin's colours are, hue and lightness.
    center: [f32; 3],
    /// What turns a distance from there into standard deviations; lower triangle, row by row.
    whiten: [f32; 6],
}

/// Why there is no estimate of skin.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SkinError {
    /// Too little to go by.
    #[error("{found} colours along the border to tell skin by, needs at least {needed}")]
    TooFew {
        /// Finite colours among the seeds.
        found: usize,
        /// How many there have to be.
        needed: usize,
    },
    /// Not even half of the seeds have something in common.
    #[error(
        "colours along the border have nothing in common to tell skin by: half of them are \
         {spread:.1} times as far apart as skin may be"
    )]
    Scattered {
        /// How far half of the seeds are apart; 1 is the most that is taken for skin.
        spread: f32,
    },
}

/// `d`, in units of `s`: below about 5 levels of 8 bits a channel, hue counts little.
const DARK: f32 = 0.06;
/// Within so many standard deviations a colour is wholly skin.
const NEAR: f32 = 2.5;
/// Beyond so many it is not skin at all.
const FAR: f32 = 4.0;
/// Standard deviations that are added to what colours show, for hue and lightness.
const TOLERANCE: [f64; 3] = [0.010, 0.010, 0.10];
/// Standard deviations beyond which what colours show does not count.
const MOST: [f64; 3] = [0.025, 0.025, 0.15];
/// How far from the middle of the seeds the nearest half of them may reach.
const REACH: [f64; 3] = [0.05, 0.05, 0.30];
/// Steps from the seeds' densest half to the estimate from all colours.
const STEPS: usize = 8;
/// The first of them look at seeds only.
const SEEDS_ONLY: usize = 2;
/// The least `m`; black is as light as this.
const LEAST_LIGHTNESS: f32 = 0.02;
/// At most so many seeds are tried as the middle, against at most so many.
const CANDIDATES: usize = 128;
const COMPARED: usize = 4096;

impl SkinModel {
    /// With fewer finite seeds there is no estimate.
    pub const LEAST_SEEDS: usize = 16;

    /// Estimates what skin looks like.
    ///
    /// - `seeds`: colours along a face's border, on the body's side. More than half have to be skin, of one
    ///   tone; the others may be hair, a collar, anything.
    /// - `others`: colours from all over the body, in any proportion; may be empty.
    ///
    /// All are sRGB values as stored, 1.0 for white. Those that are not finite are passed over, and
    /// values below 0 count as 0. The order of colours matters only for the candidates.
    ///
    /// # Errors
    /// [`SkinError`] if the seeds are too few, or so different that half of them are no single tone.
    pub fn new(seeds: &[[f32; 3]], others: &[[f32; 3]]) -> Result<Self, SkinError> {
        let [seeds, others] = [seeds, others].map(finite);
        if seeds.len() < Self::LEAST_SEEDS {
            return Err(SkinError::TooFew { found: seeds.len(), needed: Self::LEAST_SEEDS });
        }
        let (middle, spread) = densest(&seeds);
        if spread > 1.0 {
            return Err(SkinError::Scattered { spread: spread as f32 });
        }
        let lightness = sum(middle).max(LEAST_LIGHTNESS);
        let places = |colors: &[[f32; 3]]| -> Vec<Vector3<f64>> {
            colors.iter().map(|&rgb| place(rgb, lightness)).collect()
        };
        let (seeds, others) = (places(&seeds), places(&others));

        let middle = place(middle, lightness);
        let half = quantile(seeds.iter().map(|seed| reach(seed, &middle)).collect(), 0.5);
        let core = |seed: &Vector3<f64>| if reach(seed, &middle) <= half { 1.0 } else { 0.0 };
        let mut model = Self::from_moments(lightness, weighted(&seeds, &[], core));
        for step in 0..STEPS {
            let others: &[_] = if step < SEEDS_ONLY { &[] } else { &others };
            let weight =
                |place: &Vector3<f64>| f64::from(model.weight_at(place.map(|x| x as f32).into()));
            model = Self::from_moments(lightness, weighted(&seeds, others, weight));
        }
        Ok(model)
    }

    /// How far a colour is skin, from 0 to 1: 1 within 2.5 standard deviations of what skin looks like,
    /// 0 beyond 4, smooth between. 0 for colours that are not finite.
    ///
    /// Some thirty operations without a branch, so that compilers turn loops over texels into
    /// vectors.
    #[inline]
    pub fn weight(&self, rgb: [f32; 3]) -> f32 {
        self.weight_at(coordinates(rgb, self.lightness))
    }

    /// The colour in the middle of what is skin.
    pub fn color(&self) -> [f32; 3] {
        let [x, y, u] = self.center;
        let sum = self.lightness * (1.0 + u) / (1.0 - u);
        let g = (sum - (x + y) * (sum + DARK)) / 3.0;
        [g + x * (sum + DARK), g, g + y * (sum + DARK)]
    }

    #[inline]
    fn weight_at(&self, at: [f32; 3]) -> f32 {
        const SCALE: f32 = 1.0 / (FAR * FAR - NEAR * NEAR);
        let [x, y, u] = [0, 1, 2].map(|axis| at[axis] - self.center[axis]);
        let [xx, yx, yy, ux, uy, uu] = self.whiten;
        let a = xx * x;
        let b = yx * x + yy * y;
        let c = ux * x + uy * y + uu * u;
        let inside = (FAR * FAR - (a * a + b * b + c * c)) * SCALE;
        // NaN becomes 0.
        let inside = if inside > 0.0 { inside } else { 0.0 };
        let inside = if inside < 1.0 { inside } else { 1.0 };
        inside * inside * (3.0 - 2.0 * inside)
    }

    /// A model of a mean and a covariance, both bounded.
    fn from_moments(lightness: f32, (mean, covariance): (Vector3<f64>, Matrix3<f64>)) -> Self {
        // Shrinks what is spread too far along its axis, which keeps correlations.
        let shrink = Vector3::from_fn(|axis, _| {
            let deviation = covariance[(axis, axis)].max(0.0).sqrt();
            if deviation > MOST[axis] { MOST[axis] / deviation } else { 1.0 }
        });
        let shrink = Matrix3::from_diagonal(&shrink);
        let tolerance = Matrix3::from_diagonal(&Vector3::from(TOLERANCE).map(|x| x * x));
        let covariance = shrink * covariance * shrink + tolerance;
        // Positive definite by the tolerance, so both exist.
        let whiten = covariance
            .cholesky()
            .and_then(|lower| lower.l().try_inverse())
            .unwrap_or_else(|| Matrix3::from_diagonal(&Vector3::from(TOLERANCE).map(f64::recip)));
        let lower = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];
        Self {
            lightness,
            center: mean.map(|value| value as f32).into(),
            whiten: lower.map(|at| whiten[at] as f32),
        }
    }
}

#[inline]
fn positive(value: f32) -> f32 {
    // Not `max`, which would make a number of NaN.
    if value < 0.0 { 0.0 } else { value }
}

#[inline]
fn sum(rgb: [f32; 3]) -> f32 {
    let [r, g, b] = rgb.map(positive);
    r + g + b
}

/// Where a colour is beside skin of some lightness.
#[inline]
fn coordinates(rgb: [f32; 3], lightness: f32) -> [f32; 3] {
    let [r, g, b] = rgb.map(positive);
    let sum = r + g + b;
    let scale = 1.0 / (sum + DARK);
    [(r - g) * scale, (b - g) * scale, (sum - lightness) / (sum + lightness)]
}

fn place(rgb: [f32; 3], lightness: f32) -> Vector3<f64> {
    Vector3::from(coordinates(rgb, lightness).map(f64::from))
}

fn finite(colors: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let is_finite = |color: &&[f32; 3]| color.iter().all(|value| value.is_finite());
    colors.iter().filter(is_finite).copied().collect()
}

/// How far apart two places are; 1 is the most for skin of one tone.
fn reach(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    (a - b).component_div(&Vector3::from(REACH)).norm()
}

/// The seed that half of all seeds are closest around, and how far they reach from it.
fn densest(seeds: &[[f32; 3]]) -> ([f32; 3], f64) {
    let step = seeds.len().div_ceil(CANDIDATES);
    let others = seeds.iter().step_by(seeds.len().div_ceil(COMPARED));
    let around = |&candidate: &[f32; 3]| {
        let lightness = sum(candidate).max(LEAST_LIGHTNESS);
        let middle = place(candidate, lightness);
        let reaches = others.clone().map(|&seed| reach(&place(seed, lightness), &middle));
        (candidate, quantile(reaches.collect(), 0.5))
    };
    let reaches = seeds.iter().step_by(step).map(around);
    reaches.min_by(|(_, a), (_, b)| a.total_cmp(b)).unwrap_or(([0.0; 3], f64::INFINITY))
}

/// Mean and covariance of skin, where seeds count as much as all others together: so many garments
/// of nearly skin's colour move it half as far at most.
fn weighted(
    seeds: &[Vector3<f64>],
    others: &[Vector3<f64>],
    weight: impl Fn(&Vector3<f64>) -> f64,
) -> (Vector3<f64>, Matrix3<f64>) {
    let weights = |places: &[Vector3<f64>]| -> Vec<f64> { places.iter().map(&weight).collect() };
    let (mut by_seed, mut by_other) = (weights(seeds), weights(others));
    for weights in [&mut by_seed, &mut by_other] {
        let sum: f64 = weights.iter().sum();
        // A few stray colours of the body are no evidence.
        let share = if sum < SkinModel::LEAST_SEEDS as f64 / 2.0 { 0.0 } else { sum.recip() };
        weights.iter_mut().for_each(|weight| *weight *= share);
    }
    let points = seeds.iter().zip(&by_seed).chain(others.iter().zip(&by_other));
    moments(points.map(|(place, weight)| (*place, *weight)))
}
