//! An estimate of which colours of a body's texture are skin.
//!
//! No skin colour is built in: the estimate starts from the colours along the boundary of a face,
//! most of which are skin. Their densest half gives a first Gaussian, as in the minimum covariance
//! determinant (Rousseeuw and Van Driessen, "A fast algorithm for the minimum covariance
//! determinant estimator", Technometrics 1999); this weights the seeds for the next Gaussian, a few
//! times. Later steps also use colours from all over the body, to learn the skin of hands and legs.
//!
//! Colours are compared as `(r - g) / (s + d)`, `(b - g) / (s + d)` and `(s - m) / (s + m)`, where
//! `s` is `r + g + b`, `m` the skin's own `s`, and `d` a small constant. Light and shadow scale all
//! channels, in sRGB too, since its curve is nearly a power, and leave the first two, the hue,
//! unchanged. The third approximates half the logarithm of the lightness ratio, at the cost of a
//! division. `d` pulls colours near black, whose hue is noise, towards grey.
//!
//! Colour is the only evidence. A beige shirt next to pale skin passes for skin, as does brown hair
//! next to dark skin, and in grey textures everything of about the same lightness.

use nalgebra::{Matrix3, Vector3};

use super::statistics::{moments, quantile};

/// A Gaussian model of skin colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinModel {
    /// `m` of the module documentation.
    lightness: f32,
    /// Mean of the skin's coordinates: two of hue, one of lightness.
    center: [f32; 3],
    /// Whitening matrix, which turns offsets from the mean into standard deviations: the lower
    /// triangle, row by row.
    whiten: [f32; 6],
}

/// How a colour differs from skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Deviation {
    /// Distance in hue, in standard deviations. A more saturated colour of the same hue, as where
    /// skin shades skin, has less weight.
    pub hue: f32,
    /// Loss of saturation, in standard deviations; 0 if the skin itself is grey.
    pub pale: f32,
    /// Logarithm of the lightness ratio to skin.
    pub light: f32,
}

/// Why there is no estimate of skin.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SkinError {
    /// Too few seeds.
    #[error("too few colours along the face's boundary: must be at least {needed}, got {found}")]
    TooFew {
        /// Number of finite colours among the seeds.
        found: usize,
        /// Required number.
        needed: usize,
    },
    /// Not even half of the seeds are similar.
    #[error(
        "the colours along the face's boundary are too different: half of them deviate by up to \
         {spread:.1} times the tolerance for skin"
    )]
    Scattered {
        /// Distance from the centre of the seeds within which the nearest half of them lies; at
        /// most 1 for skin.
        spread: f32,
    },
}

/// `d`, in units of `s`: below about 5 of 255 levels in each channel hue has little weight. At
/// 0.03, lips of a reddish face are found better (IoU 0.59 -> 0.68, as in `labels::find`), at 0.12
/// worse (0.35); no other label changes by 0.02 but lips.
const DARK: f32 = 0.06;
/// Added to sums of red, green and blue before taking logarithms.
const SHADE: f32 = 0.03;
/// Skin with a saturation below this (norm of the two hue coordinates) is grey and has no hue.
/// Origin not recorded.
const GREY: f32 = 0.02;
/// Weight of that part of a hue difference that makes a colour more saturated than skin. At 0.2,
/// the lips of a reddish face are skin (IoU 0.59 -> 0.19, as in `labels::find`); from 0.6 to 0.96,
/// lips of most faces are found better, by up to 0.17.
const MORE_SATURATED: f32 = 0.4;
/// Lower limit of `m`; darker skin is treated as this light. Origin not recorded.
const MIN_LIGHTNESS: f32 = 0.1;

/// Within this many standard deviations a colour is skin with weight 1. Generous, since palms,
/// knuckles and elbows lie farther out than the spread of the seeds.
const NEAR: f32 = 2.5;
/// Beyond this many its weight is 0.
const FAR: f32 = 4.0;
/// The same two limits during estimation; tighter, so that doubtful colours do not widen the
/// estimate.
const SURE: f32 = 1.5;
const DOUBTFUL: f32 = 3.0;

/// Standard deviation added to both hues, as a fraction of the skin's distance from grey, and its
/// limits: blood and sun change the hue of pale skin less than that of saturated skin. With an
/// upper limit of 0.014, lips of a reddish face are skin (IoU 0.59 -> 0.15, as in `labels::find`),
/// with 0.008 they are found better (0.75). The fraction moves lips and brows: halved, lips are
/// found better on that face (0.75) and worse on one lit from beside (0.71 -> 0.52).
const HUE_TOLERANCE: f64 = 0.1;
const HUE_RANGE: [f64; 2] = [0.007, 0.011];
/// Standard deviation added to lightness. By itself it accepts colours 0.6 to 1.7 times as light as
/// skin, and rejects those less than 0.4 or more than 2.3 times as light. Labels of faces do not
/// depend on it.
const LIGHTNESS_TOLERANCE: f64 = 0.10;
/// Upper limits of the colours' own standard deviations; wider spreads are scaled down to these.
/// Halved, lips of a reddish face are found better (IoU 0.59 -> 0.74), and those of a very light
/// one worse (0.75 -> 0.70); flat doubled.
const MAX_SPREAD: Vector3<f64> = Vector3::new(0.020, 0.020, 0.06);
/// Scale of the distance between the seeds and their centre: the nearest half must lie within 1.
const REACH: Vector3<f64> = Vector3::new(0.05, 0.05, 0.30);

/// Steps with the seeds alone, and then with all colours. Three times as many give the same
/// estimate to four digits.
const STEPS: usize = 4;
/// Number of seeds tried as the centre, and number of seeds that each is compared with, at most.
const CANDIDATES: usize = 128;
const COMPARED: usize = 2048;
/// Minimum total weight of the body's colours; less proves nothing. Origin not recorded.
const MIN_EVIDENCE: f64 = 8.0;

impl SkinModel {
    /// Minimum number of finite seeds.
    pub const MIN_SEEDS: usize = 16;

    /// Estimates the colour of skin.
    ///
    /// - `seeds`: colours along a face's boundary, on the body's side. More than half have to be
    ///   skin; the rest may be anything, such as hair or a collar.
    /// - `others`: colours from all over the body, skin or not; may be empty.
    ///
    /// All are sRGB values as stored, 1.0 for white. Colours that are not finite are skipped, and
    /// negative values are taken as 0. A few thousand of either are plenty and take milliseconds.
    /// The result depends only on the colours and their order.
    ///
    /// # Errors
    /// [`SkinError::TooFew`] below [`SkinModel::MIN_SEEDS`] finite seeds,
    /// [`SkinError::Scattered`] if not even half of them are similar.
    pub fn new(seeds: &[[f32; 3]], others: &[[f32; 3]]) -> Result<Self, SkinError> {
        let [seeds, others] = [seeds, others].map(finite);
        if seeds.len() < Self::MIN_SEEDS {
            return Err(SkinError::TooFew { found: seeds.len(), needed: Self::MIN_SEEDS });
        }
        let (center, spread) = densest(&seeds);
        if spread > 1.0 {
            return Err(SkinError::Scattered { spread: spread as f32 });
        }
        let lightness = sum(center).max(MIN_LIGHTNESS);
        let center = point(center, lightness);
        let points = |colors: &[[f32; 3]]| -> Vec<Vector3<f64>> {
            colors.iter().map(|&rgb| point(rgb, lightness)).collect()
        };
        let (seeds, others) = (points(&seeds), points(&others));

        let half = quantile(seeds.iter().map(|seed| distance(seed, &center)), 0.5).unwrap_or(0.0);
        let in_half = |seed: &Vector3<f64>| f64::from(distance(seed, &center) <= half);
        let mut model = Self::from_moments(lightness, weighted_moments(&seeds, &[], in_half));
        for _ in 0..STEPS {
            let next = weighted_moments(&seeds, &[], |at| model.membership(at));
            model = Self::from_moments(lightness, next);
        }
        // Colours that the seeds rule out never get weight: where skin fades into something else,
        // the estimate would follow the gradient step by step.
        let of_seeds = model;
        for _ in 0..STEPS {
            let in_both = |at: &_| model.membership(at).min(of_seeds.membership(at));
            let next = weighted_moments(&seeds, &others, in_both);
            model = Self::from_moments(lightness, next);
        }
        Ok(model)
    }

    /// Weight of an sRGB colour as skin: 1 within 2.5 standard deviations of the model, 0 beyond 4,
    /// smooth in between; 0 for colours that are not finite.
    ///
    /// About forty operations without a branch, which compilers vectorise in loops over texels.
    #[inline(always)]
    pub fn weight(&self, rgb: [f32; 3]) -> f32 {
        fade(self.squared_distance(coordinates(rgb, self.lightness)), NEAR, FAR)
    }

    /// The difference of an sRGB colour from skin.
    pub(crate) fn deviation(&self, rgb: [f32; 3]) -> Deviation {
        self.deviations()(rgb)
    }

    /// As [`SkinModel::deviation`], with the constants hoisted out, for many colours.
    pub(crate) fn deviations(&self) -> impl Fn([f32; 3]) -> Deviation {
        let model = *self;
        let whole = sum(model.color()) + SHADE;
        let saturation = model.center[0].hypot(model.center[1]);
        let is_grey = saturation < GREY;
        let outwards = [0, 1].map(|k| model.center[k] / saturation.max(GREY));
        let [xx, yx, yy, ..] = model.whiten;
        let whitened = move |x: f32, y: f32| {
            let (a, b) = (xx * x, yx * x + yy * y);
            (a * a + b * b).sqrt()
        };
        let pale = whitened(outwards[0], outwards[1]);
        move |rgb| {
            let [x, y, _] = coordinates(rgb, model.lightness);
            let [x, y] = [x - model.center[0], y - model.center[1]];
            let light = ((sum(rgb) + SHADE) / whole).ln();
            if is_grey {
                return Deviation { hue: whitened(x, y), pale: 0.0, light };
            }
            let along = x * outwards[0] + y * outwards[1];
            let shift = (MORE_SATURATED - 1.0) * along.max(0.0);
            let hue = whitened(x + shift * outwards[0], y + shift * outwards[1]);
            Deviation { hue, pale: -along * pale, light }
        }
    }

    /// Weight of a colour as skin in other lighting, from 0 to 1, for use where its surroundings
    /// suggest skin: heads shade necks, and shadows on skin are more saturated. Hair and cloth of
    /// another hue get 0.
    pub(crate) fn likeness(&self, rgb: [f32; 3]) -> f32 {
        let Deviation { hue, light, .. } = self.deviation(rgb);
        fade(hue * hue, 5.0, 9.0) * fade(light * light, 0.7, 1.2)
    }

    /// The mean skin colour.
    pub fn color(&self) -> [f32; 3] {
        let [x, y, u] = self.center;
        let sum = self.lightness * (1.0 + u) / (1.0 - u);
        let [r_over_g, b_over_g] = [x, y].map(|hue| hue * (sum + DARK));
        let g = (sum - r_over_g - b_over_g) / 3.0;
        [g + r_over_g, g, g + b_over_g]
    }

    /// Weight of a colour as skin during estimation, from its coordinates.
    fn membership(&self, at: &Vector3<f64>) -> f64 {
        let at = at.map(|value| value as f32);
        f64::from(fade(self.squared_distance(at.into()), SURE, DOUBTFUL))
    }

    /// Squared Mahalanobis distance from the mean.
    #[inline(always)]
    fn squared_distance(&self, at: [f32; 3]) -> f32 {
        // Closures would not be compiled with the vector instructions of the calling loop.
        let x = at[0] - self.center[0];
        let y = at[1] - self.center[1];
        let u = at[2] - self.center[2];
        let [xx, yx, yy, ux, uy, uu] = self.whiten;
        let a = xx * x;
        let b = yx * x + yy * y;
        let c = ux * x + uy * y + uu * u;
        a * a + b * b + c * c
    }

    /// The model of a mean and a covariance; the covariance is bounded from above and below.
    fn from_moments(lightness: f32, (mean, covariance): (Vector3<f64>, Matrix3<f64>)) -> Self {
        // Scale down axes with too wide a spread; this keeps correlations.
        let shrink = Vector3::from_fn(|axis, _| {
            MAX_SPREAD[axis] / covariance[(axis, axis)].max(0.0).sqrt().max(MAX_SPREAD[axis])
        });
        let shrink = Matrix3::from_diagonal(&shrink);
        let hue = (HUE_TOLERANCE * mean.xy().norm()).clamp(HUE_RANGE[0], HUE_RANGE[1]);
        let tolerance = Vector3::new(hue, hue, LIGHTNESS_TOLERANCE).map(|value| value * value);
        let covariance = shrink * covariance * shrink + Matrix3::from_diagonal(&tolerance);
        // Positive definite because of the tolerance. If rounding breaks that, fall back to the
        // tolerance alone.
        let whiten =
            covariance.cholesky().and_then(|factor| factor.l().try_inverse()).unwrap_or_else(
                || Matrix3::from_diagonal(&tolerance.map(|value| value.sqrt().recip())),
            );
        let lower = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];
        Self {
            lightness,
            center: mean.map(|value| value as f32).into(),
            whiten: lower.map(|at| whiten[at] as f32),
        }
    }
}

/// Smoothstep from 1 down to 0 as a squared distance goes from `near²` to `far²`; 0 for NaN.
#[inline(always)]
fn fade(squared: f32, near: f32, far: f32) -> f32 {
    let inside = (far * far - squared) / (far * far - near * near);
    let inside = if inside > 0.0 { inside } else { 0.0 };
    let inside = if inside < 1.0 { inside } else { 1.0 };
    inside * inside * (3.0 - 2.0 * inside)
}

/// Not `max`, which would swallow NaN.
#[inline(always)]
fn positive(value: f32) -> f32 {
    if value < 0.0 { 0.0 } else { value }
}

fn sum(rgb: [f32; 3]) -> f32 {
    rgb.into_iter().map(positive).sum()
}

/// Hue and lightness of a colour relative to skin of the given lightness; see the module.
#[inline(always)]
fn coordinates(rgb: [f32; 3], lightness: f32) -> [f32; 3] {
    let (r, g, b) = (positive(rgb[0]), positive(rgb[1]), positive(rgb[2]));
    let sum = r + g + b;
    let scale = 1.0 / (sum + DARK);
    [(r - g) * scale, (b - g) * scale, (sum - lightness) / (sum + lightness)]
}

fn point(rgb: [f32; 3], lightness: f32) -> Vector3<f64> {
    Vector3::from(coordinates(rgb, lightness).map(f64::from))
}

/// The colours whose values and sum are finite.
fn finite(colors: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let is_finite =
        |rgb: &[f32; 3]| rgb.iter().all(|value| value.is_finite()) && sum(*rgb).is_finite();
    colors.iter().copied().filter(is_finite).collect()
}

/// Distance between two colours' coordinates; the limit for skin is 1.
fn distance(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    (a - b).component_div(&REACH).norm()
}

/// The seed with the smallest median distance to all seeds, and that distance.
fn densest(seeds: &[[f32; 3]]) -> ([f32; 3], f64) {
    let compared = seeds.iter().step_by(seeds.len().div_ceil(COMPARED));
    let candidates = seeds.iter().step_by(seeds.len().div_ceil(CANDIDATES));
    let distances = candidates.map(|&candidate| {
        let lightness = sum(candidate).max(MIN_LIGHTNESS);
        let center = point(candidate, lightness);
        let distances = compared.clone().map(|&seed| distance(&point(seed, lightness), &center));
        (candidate, quantile(distances, 0.5).unwrap_or(0.0))
    });
    let nearest = distances.min_by(|(_, a), (_, b)| a.total_cmp(b));
    nearest.unwrap_or(([0.0; 3], f64::INFINITY))
}

/// Mean and covariance of skin. The seeds have as much weight as all other colours together, so
/// that a garment of nearly the colour of skin shifts them only half as far, however much of the
/// body it covers.
fn weighted_moments(
    seeds: &[Vector3<f64>],
    others: &[Vector3<f64>],
    weight: impl Fn(&Vector3<f64>) -> f64,
) -> (Vector3<f64>, Matrix3<f64>) {
    // Normalised to sum to 1; all 0 if the total weight is below `least`.
    let shares = |points: &[Vector3<f64>], least: f64| -> Vec<f64> {
        let weights: Vec<f64> = points.iter().map(&weight).collect();
        let sum: f64 = weights.iter().sum();
        let unit = if sum < least { 0.0 } else { sum.recip() };
        weights.into_iter().map(|weight| weight * unit).collect()
    };
    // Seeds are near the centre by construction, so their total weight is never zero.
    let (of_seeds, of_others) = (shares(seeds, f64::MIN_POSITIVE), shares(others, MIN_EVIDENCE));
    let points = seeds.iter().zip(&of_seeds).chain(others.iter().zip(&of_others));
    moments(points.map(|(point, share)| (*point, *share)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SKIN: [f32; 3] = [0.8, 0.6, 0.5];
    const NAVY: [f32; 3] = [0.12, 0.16, 0.30];

    /// Colours scaled by up to ±`shade`, each channel with up to ±`noise` added.
    fn around(rgb: [f32; 3], shade: f32, noise: f32, count: usize) -> Vec<[f32; 3]> {
        let mut rng = fastrand::Rng::with_seed(3);
        let colors = std::iter::repeat_with(|| {
            let light = 1.0 + shade * (2.0 * rng.f32() - 1.0);
            rgb.map(|value| value * light + noise * (2.0 * rng.f32() - 1.0))
        });
        colors.take(count).collect()
    }

    fn scaled(rgb: [f32; 3], factor: f32) -> [f32; 3] {
        rgb.map(|value| value * factor)
    }

    /// Uniform seeds leave the tolerances as they are, so weights can be computed by hand.
    #[test]
    fn weights_fall_as_stated() {
        let model = SkinModel::new(&[SKIN; 20], &[]).unwrap();
        assert_eq!(model.weight(SKIN), 1.0);
        for (channel, value) in model.color().into_iter().enumerate() {
            assert!((value - SKIN[channel]).abs() < 1e-6, "{channel}: {value}");
        }
        // 1.963 times as light is 0.325, or 3.25 standard deviations of 0.1, and the hues differ by
        // 0.0016 and 0.0008, with a standard deviation of 0.011: 10.587 in all. (16 - 10.587) / (16
        // - 6.25) = 0.5552, and 0.5552² · (3 - 2 · 0.5552) = 0.5825.
        let weight = model.weight(scaled(SKIN, 1.325 / 0.675));
        assert!((weight - 0.5825).abs() < 1e-3, "{weight}");
        assert_eq!(model.weight(scaled(SKIN, 0.62)), 1.0);
        assert_eq!(model.weight(scaled(SKIN, 0.36)), 0.0);
        // As far from skin in sRGB as 0.62 times it, but of another hue.
        assert_eq!(model.weight([0.8, 0.6, 0.8]), 0.0);
        assert_eq!(model.weight([0.68, 0.72, 0.5]), 0.0);
    }

    #[test]
    fn half_of_the_seeds_may_be_anything() {
        let clean = around(SKIN, 0.15, 0.01, 1000);
        let mut rng = fastrand::Rng::with_seed(8);
        for stranger in [NAVY, [0.02; 3], [1.0; 3], [0.2, 0.12, 0.08]] {
            let mut seeds = clean.clone();
            seeds.extend(around(stranger, 0.0, 0.004, 800));
            rng.shuffle(&mut seeds);
            let model = SkinModel::new(&seeds, &[]).unwrap();
            let least = clean.iter().map(|&rgb| model.weight(rgb)).fold(1.0, f32::min);
            assert!(least > 0.95, "{stranger:?}: {least}");
            assert_eq!(model.weight(stranger), 0.0, "{stranger:?}");
        }
    }

    /// The minimum number of seeds, with the fewest of them skin.
    #[test]
    fn a_few_seeds_are_enough() {
        for strangers in 0..8 {
            let mut seeds = around(SKIN, 0.15, 0.01, 16 - strangers);
            seeds.extend(around(NAVY, 0.5, 0.05, strangers));
            let model = SkinModel::new(&seeds, &[]).unwrap();
            let weight = model.weight(SKIN);
            assert!(weight > 0.9, "{strangers}: {weight}");
            assert_eq!(model.weight(NAVY), 0.0, "{strangers}");
        }
    }

    #[test]
    fn learns_from_the_rest_of_the_body() {
        let seeds = around(SKIN, 0.05, 0.005, 500);
        let palm = [0.815, 0.575, 0.49];
        let before = SkinModel::new(&seeds, &[]).unwrap();
        let mut others = around(SKIN, 0.2, 0.01, 2000);
        others.extend(around(palm, 0.2, 0.01, 2000));
        others.extend(around(NAVY, 0.2, 0.01, 6000));
        let after = SkinModel::new(&seeds, &others).unwrap();
        let edge = [0.83, 0.56, 0.48];
        assert!(before.weight(edge) < 0.5, "{}", before.weight(edge));
        assert!(after.weight(edge) > 0.9, "{}", after.weight(edge));
        assert_eq!(after.weight(NAVY), 0.0);
    }

    /// Skin that fades into a white shirt must not widen the model to the shirt.
    #[test]
    fn a_gradient_of_colors_does_not_widen_the_model() {
        let seeds = around(SKIN, 0.1, 0.01, 500);
        let cloth = [0.93, 0.91, 0.88];
        let others: Vec<[f32; 3]> = (0..20_000)
            .map(|k| {
                let t = (k as f32 / 6000.0).min(1.0);
                std::array::from_fn(|channel| SKIN[channel] + (cloth[channel] - SKIN[channel]) * t)
            })
            .collect();
        let model = SkinModel::new(&seeds, &others).unwrap();
        assert_eq!(model.weight(cloth), 0.0);
        assert_eq!(model.weight(SKIN), 1.0);
    }

    /// The seeds define skin, whatever their colour: dark, pale, tinted or grey.
    #[test]
    fn any_color_may_be_skin() {
        for skin in [
            [0.22, 0.13, 0.10],
            [0.95, 0.85, 0.80],
            [0.25, 0.45, 0.80],
            [0.35, 0.65, 0.28],
            [0.5; 3],
            [1.0; 3],
            [0.08, 0.05, 0.04],
        ] {
            // Noise like that of rounding to 8 bits.
            let seeds = around(skin, 0.1, 0.002, 300);
            let model = SkinModel::new(&seeds, &seeds).unwrap();
            let least = seeds.iter().map(|&rgb| model.weight(rgb)).fold(1.0, f32::min);
            assert!(least > 0.9, "{skin:?}: {least}");
            for other in [[0.85, 0.1, 0.1], [0.9, 0.8, 0.1], [0.6, 0.2, 0.7]] {
                assert_eq!(model.weight(other), 0.0, "{skin:?}, {other:?}");
            }
        }
        let black = SkinModel::new(&[[0.0; 3]; 20], &[]).unwrap();
        assert_eq!((black.weight([0.0; 3]), black.weight([0.2; 3])), (1.0, 0.0));
        // Without a hue only lightness decides.
        let grey = SkinModel::new(&around([0.6; 3], 0.05, 0.004, 300), &[]).unwrap();
        assert_eq!(grey.weight([0.2; 3]), 0.0);
        assert_eq!(grey.weight([0.5; 3]), 1.0);
    }

    #[test]
    fn useless_seeds_are_refused() {
        let few = SkinModel::new(&[SKIN; 15], &[SKIN; 1000]);
        assert_eq!(few, Err(SkinError::TooFew { found: 15, needed: 16 }));
        let mut seeds = vec![SKIN; 10];
        seeds.extend([[f32::NAN, 0.6, 0.5], [0.8, f32::INFINITY, 0.5], [f32::MAX; 3]].repeat(20));
        let broken = SkinModel::new(&seeds, &[]);
        assert_eq!(broken, Err(SkinError::TooFew { found: 10, needed: 16 }));
        assert_eq!(SkinModel::new(&[], &[]), Err(SkinError::TooFew { found: 0, needed: 16 }));
        let mut rng = fastrand::Rng::with_seed(1);
        let different: Vec<[f32; 3]> =
            (0..500).map(|_| std::array::from_fn(|_| rng.f32())).collect();
        let scattered = SkinModel::new(&different, &[SKIN; 1000]);
        let Err(SkinError::Scattered { spread }) = scattered else { panic!("{scattered:?}") };
        assert!(spread > 1.5, "{spread}");
    }

    #[test]
    fn non_finite_colors_are_ignored_and_not_skin() {
        let seeds = around(SKIN, 0.1, 0.01, 100);
        let model = SkinModel::new(&seeds, &seeds).unwrap();
        let broken = [[f32::NAN; 3], [f32::INFINITY, 0.0, 0.0], [0.8, f32::NEG_INFINITY, f32::NAN]];
        let mut mixed = seeds.clone();
        for (k, rgb) in broken.into_iter().enumerate() {
            mixed.insert(20 * k + 7, rgb);
        }
        assert_eq!(SkinModel::new(&mixed, &mixed), Ok(model));
        for rgb in broken {
            assert_eq!(model.weight(rgb), 0.0, "{rgb:?}");
        }
        for rgb in [[f32::MAX; 3], [-1.0; 3], [f32::MIN; 3], [1e30, 0.0, -1e30]] {
            assert_eq!(model.weight(rgb), 0.0, "{rgb:?}");
        }
    }
}
