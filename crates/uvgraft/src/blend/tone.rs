//! How a colour takes on another tone: a gain with a shoulder.
//!
//! Skins differ by what they absorb, so a ratio carries shading, brows and pores along where a sum
//! would leave them grey or cut them off. A ratio above 1 would push highlights beyond white; these
//! are bent instead, so that full stays full. Values are those that the texture holds: of sRGB as it
//! is encoded, where ratios are nearly those of light to the power of 1/2.4; or light.

use crate::statistics::ColorMatch;

/// Where the shoulder of gains above 1 begins.
pub(super) const KNEE: f32 = 0.5;

/// The least and the greatest gain: from the darkest skin to the lightest takes 10, for the shoulder takes most away.
pub(super) const GAINS: [f32; 2] = [0.05, 40.0];

/// Added to both sides of ratios where what is divided by is black, so that it is no reason for wild ones:
/// two and a half levels of 255, and less up to [`DARK`].
const BLACK: f32 = 0.01;

/// From here on ratios are taken as they are.
const DARK: f32 = 0.1;

/// A level under a gain; `one` is full. A gain of 1 changes nothing.
#[inline(always)]
pub(super) fn toned(level: f32, gain: f32, one: f32) -> f32 {
    let plain = level * gain;
    if gain > 1.0 && plain > KNEE * one { bent(plain, bend(gain), one) } else { plain }
}

/// How much the shoulder of a gain above 1 bends.
#[inline(always)]
pub(super) fn bend(gain: f32) -> f32 {
    1.0 / (1.0 - KNEE) - 1.0 / (gain - KNEE)
}

/// A level beyond the knee: slope 1 there, and full where the gain takes what is full.
#[inline(always)]
pub(super) fn bent(plain: f32, bend: f32, one: f32) -> f32 {
    let beyond = plain - KNEE * one;
    KNEE * one + beyond / (1.0 + bend / one * beyond)
}

/// An affine change of colours: rows of a matrix, with what is added last. What is darker than skin changes
/// less and black not at all: hair and pupils would else get the colour that is added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Matrix {
    pub rows: [[f32; 4]; 3],
    /// From this sum of red, green and blue on, 1.0 each, it acts wholly.
    pub whole_from: f32,
}

impl Matrix {
    /// What a match of colours does, or a share of it.
    ///
    /// - `from`: the colours that were matched.
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

    /// The colour in place of another; 1.0 is full.
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

/// The gain that takes one value to another, within bounds.
pub(super) fn gain_between(from: f32, to: f32) -> f32 {
    let added = BLACK * (1.0 - from / DARK).max(0.0);
    let ratio = (to + added) / (from + added);
    if ratio <= 1.0 || ratio * from <= KNEE {
        return ratio.clamp(GAINS[0], GAINS[1]);
    }
    // The shoulder takes some away; more gain always gives more.
    let (mut low, mut high) = (1.0, GAINS[1]);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if toned(from, middle, 1.0) < to { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn takes_one_tone_to_the_other_and_keeps_full() {
        for from in [0.05, 0.3, 0.5, 0.8, 0.9] {
            assert_eq!(toned(from, gain_between(from, from), 1.0), from);
            for to in [0.1, 0.3, 0.7, 0.85, 0.93] {
                let gain = gain_between(from, to);
                if gain > GAINS[0] && gain < GAINS[1] {
                    // What is added beside black is the difference.
                    let added = BLACK * (1.0 - from / DARK).max(0.0) * (gain - 1.0).abs();
                    assert!((toned(from, gain, 1.0) - to).abs() < added + 1e-3, "{from} to {to}");
                }
            }
        }
        for gain in [1.0, 1.3, 2.0, 5.0] {
            assert!((toned(1.0, gain, 1.0) - 1.0).abs() < 1e-5);
            assert_eq!(toned(0.0, gain, 1.0), 0.0);
        }
        assert_eq!(toned(0.6, 0.5, 1.0), 0.3);
    }

    #[test]
    fn is_even_and_grows() {
        for gain in [0.5, 1.0, 1.2, 3.0] {
            let values: Vec<f32> =
                (0..=1000).map(|k| toned(k as f32 / 1000.0, gain, 1.0)).collect();
            let steps: Vec<f32> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert!(steps.iter().all(|&step| step > 0.0 && step < 0.001 * gain.max(1.0) + 1e-6));
            // No kink at the knee.
            assert!(steps.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 2e-4));
        }
    }
}
