//! Linear light to 8-bit sRGB and back, by table.

use std::sync::LazyLock;

use uvgraft::Value;
use uvgraft::color::{linear_from_srgb, srgb_from_linear};

/// Steps from 0 to 1 in which the search for a level begins.
const STEPS: usize = 1 << 12;

/// For each level but the first, the smallest linear value that is rounded to it; and for each step,
/// the level at its start.
struct Levels {
    limits: [f32; 256],
    steps: Vec<u8>,
}

static LEVELS: LazyLock<Levels> = LazyLock::new(|| {
    let level = |value: f32| u8::from_unit(srgb_from_linear(value));
    let mut limits = [f32::INFINITY; 256];
    for (index, limit) in limits.iter_mut().take(255).enumerate() {
        // Bits of positive numbers are in the order of the numbers.
        let (mut below, mut above) = (0.0_f32.to_bits(), 1.0_f32.to_bits());
        while above - below > 1 {
            let middle = below.midpoint(above);
            let is_below = usize::from(level(f32::from_bits(middle))) <= index;
            (below, above) = if is_below { (middle, above) } else { (below, middle) };
        }
        *limit = f32::from_bits(above);
    }
    let steps = (0..=STEPS).map(|step| level(step as f32 / STEPS as f32)).collect();
    Levels { limits, steps }
});

/// An encoder from linear light to 8-bit sRGB.
#[derive(Clone, Copy)]
pub(crate) struct Encoder(&'static Levels);

impl Encoder {
    pub fn new() -> Self {
        Self(&LEVELS)
    }

    /// `u8::from_unit(srgb_from_linear(linear))`, without a power. NaN becomes 0.
    #[inline]
    pub fn encode(self, linear: f32) -> u8 {
        let value = linear.clamp(0.0, 1.0);
        let mut level = self.0.steps[(value * STEPS as f32) as usize];
        // The last limit is infinite.
        while value >= self.0.limits[usize::from(level)] {
            level += 1;
        }
        level
    }
}

/// Linear light from sRGB in `0.0..=1.0`, interpolated between exact values.
pub(crate) fn decode(value: f32) -> f32 {
    const STEPS: usize = 1024;
    static TABLE: LazyLock<Vec<f32>> = LazyLock::new(|| {
        (0..=STEPS + 1).map(|step| linear_from_srgb(step as f32 / STEPS as f32)).collect()
    });
    let at = value.clamp(0.0, 1.0) * STEPS as f32;
    let step = at as usize;
    let (low, high) = (TABLE[step], TABLE[step + 1]);
    low + (high - low) * (at - step as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_agree_with_the_formulas() {
        let encoder = Encoder::new();
        let exact = |value: f32| u8::from_unit(srgb_from_linear(value));
        for step in 0..=2_000_000 {
            let value = step as f32 / 2e6;
            assert_eq!(encoder.encode(value), exact(value), "{value}");
            assert!((decode(value) - linear_from_srgb(value)).abs() < 1e-6, "{value}");
        }
        for limit in &LEVELS.limits[..255] {
            for value in [limit.next_down(), *limit, limit.next_up()] {
                assert_eq!(encoder.encode(value), exact(value), "{value}");
            }
        }
        for value in [-1.0, -0.0, 1.5, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
            assert_eq!(encoder.encode(value), exact(value), "{value}");
        }
    }
}
