//! The tone curve: a gain with a bent curve.
//!
//! Skins differ by what they absorb, so a ratio preserves shading, brows and pores where an offset
//! would turn them grey or cut them off. But a plain ratio flattens what becomes much darker,
//! multiplies the contrast of what becomes much lighter, and pushes highlights beyond white. So
//! small gains are ratios, and the larger a gain is, the more its curve is bent to preserve
//! contrast; full intensity is never exceeded. Values are encoded sRGB, where ratios are nearly
//! ratios of light to the power of 1/2.4.

use uvgraft_surface::statistics::ColorMatch;

/// The least and the greatest gain. Mapping the darkest skin to the lightest takes a gain of 10,
/// because the shoulder takes most of it away.
pub(super) const GAINS: [f32; 2] = [0.05, 40.0];

/// Added to both sides of a ratio at black, falling to 0 at [`DARK`], so that divisors near 0 do
/// not give wild ratios: two and a half levels of 255.
const BLACK: f32 = 0.01;

/// Values from here on are divided without [`BLACK`].
const DARK: f32 = 0.1;

/// The level at which the shoulder of a gain above 1 begins.
#[inline(always)]
fn knee(gain: f32) -> f32 {
    (0.65 - 0.15 * gain).max(0.0)
}

/// Applies a gain to a level; `one` is full intensity. A gain of 1 changes nothing, and a larger
/// gain always gives a larger result.
///
/// With levels `x` relative to full, gains `g` below 1 give `g x / (1 - 0.85 (1 - g)² x)`. Gains
/// above 1 give `g x` up to the knee `k` and `k + b w / (w + (g - 1) b)` beyond, where
/// `b = g x - k` and `w = (1 - k) (g - k)`: slope `g` at the knee, and 1 at `x = 1`.
///
/// Filter overshoot of float textures, below 0 or above full, is cut off as integer depths do; a
/// gain would amplify it. Written without branches so that loops vectorise.
#[inline(always)]
pub(super) fn toned(level: f32, gain: f32, one: f32) -> f32 {
    let is_same = gain == 1.0;
    let from = if level > 0.0 || is_same { level } else { 0.0 };
    let level = if from < one || is_same { from } else { one };
    let plain = level * gain;
    // Toe: the smaller the gain, the less it darkens highlights.
    let toe = 0.85 * (1.0 - gain) * (1.0 - gain);
    let share = level * (1.0 / one);
    // Shoulder: slope `gain` at the knee, and full intensity stays full.
    let knee = knee(gain);
    let whole = (1.0 - knee) * (gain - knee);
    let beyond = plain - knee * one;
    let below = whole + (gain - 1.0) * beyond * (1.0 / one);
    let is_bent = gain > 1.0 && beyond > 0.0;
    let of_shoulder = (knee * one * below + beyond * whole, below);
    let of_toe = (plain, if gain < 1.0 { 1.0 - toe * share } else { 1.0 });
    let (above, below) = if is_bent { of_shoulder } else { of_toe };
    above / below
}

/// An affine colour transform: rows of a matrix, each ending with the offset. Colours
/// darker than skin change less and black not at all: hair and pupils would otherwise
/// take on the offset's colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Matrix {
    pub rows: [[f32; 4]; 3],
    /// Sum of red, green and blue, each 1.0 at full, from which on the transform acts fully.
    pub whole_from: f32,
}

impl Matrix {
    /// The transform of a colour match, or a fraction of it.
    ///
    /// - `from`: the colours that were matched.
    /// - `share`: the fraction, 0 to 1.
    pub fn matching(found: &ColorMatch, from: &[[f32; 3]], share: f32) -> Self {
        let (rows, offset) = (found.matrix(), found.offset());
        let mean = from.iter().map(|rgb| rgb.iter().sum::<f32>()).sum::<f32>() / from.len() as f32;
        let row = |k: usize| {
            let unit = |column: usize| f32::from(u8::from(k == column));
            let part = |column: usize| unit(column) + share * (rows[k][column] - unit(column));
            [part(0), part(1), part(2), share * offset[k]]
        };
        Self { rows: [row(0), row(1), row(2)], whole_from: (0.5 * mean).max(1e-3) }
    }

    /// The transformed colour; 1.0 is full intensity.
    #[inline(always)]
    pub fn apply(&self, rgb: [f32; 3]) -> [f32; 3] {
        let share = ((rgb[0] + rgb[1] + rgb[2]) / self.whole_from).clamp(0.0, 1.0);
        let mut changed = [0.0; 3];
        for (channel, row) in self.rows.iter().enumerate() {
            let value = row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2] + row[3];
            changed[channel] = (rgb[channel] + (value - rgb[channel]) * share).max(0.0);
        }
        changed
    }
}

/// The gain that maps one value to another, within [`GAINS`].
pub(super) fn gain_between(from: f32, to: f32) -> f32 {
    let added = BLACK * (1.0 - from / DARK).max(0.0);
    let [from, to] = [from + added, to + added];
    // By bisection: a larger gain always gives a larger result.
    let [mut low, mut high] = GAINS;
    for _ in 0..32 {
        let middle = (low * high).sqrt();
        if toned(from, middle, 1.0) < to { low = middle } else { high = middle }
    }
    (low * high).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_one_tone_to_the_other_and_keeps_full_intensity() {
        for from in [0.05, 0.3, 0.5, 0.8, 0.9] {
            assert!((toned(from, gain_between(from, from), 1.0) - from).abs() < 1e-5);
            for to in [0.1, 0.3, 0.7, 0.85, 0.93] {
                let gain = gain_between(from, to);
                if gain > 1.01 * GAINS[0] && gain < 0.99 * GAINS[1] {
                    // The offset near black is the difference.
                    let added = BLACK * (1.0 - from / DARK).max(0.0) * (gain - 1.0).abs();
                    assert!((toned(from, gain, 1.0) - to).abs() < added + 1e-3, "{from} to {to}");
                }
            }
        }
        for gain in [1.0, 1.3, 2.0, 5.0] {
            assert!((toned(1.0, gain, 1.0) - 1.0).abs() < 1e-5);
            assert_eq!(toned(0.0, gain, 1.0), 0.0);
        }
        for level in [0.0, 0.3, 0.7, 1.0, 1.5] {
            assert_eq!(toned(level, 1.0, 1.0), level);
        }
    }

    #[test]
    fn small_gains_are_ratios() {
        for gain in [0.8_f32, 0.9, 1.1, 1.2] {
            for level in [0.1, 0.2, 0.3] {
                let found = toned(level, gain, 1.0);
                assert!((found / (level * gain) - 1.0).abs() < 0.02, "{level} by {gain}: {found}");
            }
        }
    }

    #[test]
    fn contrast_of_skin_is_kept_however_much_its_tone_changes() {
        for (from, to, most) in
            [(0.7, 0.35, 0.4), (0.35, 0.7, 0.2), (0.6, 0.2, 0.6), (0.2, 0.6, 0.6)]
        {
            let gain = gain_between(from, to);
            let [above, below] = [from + 0.02, from - 0.02].map(|level| toned(level, gain, 1.0));
            let contrast = (above - below) / 0.04;
            // A plain ratio gives 0.5, 2, 0.33 and 3.
            assert!((contrast - 1.0).abs() < most, "{from} to {to}: {contrast}");
        }
    }

    #[test]
    fn is_smooth_and_monotonic() {
        let gains: Vec<f32> = (0..400).map(|k| 0.05 * 800_f32.powf(k as f32 / 399.0)).collect();
        for &gain in &gains {
            let values: Vec<f32> =
                (0..=1000).map(|k| toned(k as f32 / 1000.0, gain, 1.0)).collect();
            let steps: Vec<f32> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert!(steps.iter().all(|&step| step > 0.0), "{gain}");
            // No kink at the knee.
            let bends = steps.windows(2).map(|pair| (pair[1] - pair[0]).abs());
            let most = if gain < 0.2 { 1e-3 } else { 2e-4 * gain.max(1.0) * gain.max(1.0) };
            assert!(bends.fold(0.0, f32::max) < most, "{gain}");
        }
        for level in [0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99] {
            let values = gains.iter().map(|&gain| toned(level, gain, 1.0));
            assert!(values.is_sorted(), "{level}");
        }
    }

    #[test]
    fn units_do_not_matter() {
        for (level, gain) in [(0.3, 0.4), (0.8, 0.4), (0.3, 3.0), (0.8, 1.7), (0.1, 1.2)] {
            let [unit, byte] = [toned(level, gain, 1.0), toned(level * 255.0, gain, 255.0) / 255.0];
            assert!((unit - byte).abs() < 1e-6);
        }
    }
}
