//! Interpolation filters: their support in texels on each axis, and their weights.

use std::sync::LazyLock;

use uvgraft_surface::choice::Choice;

/// Interpolation filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Filter {
    /// The texel that contains the position. For label masks: it never blends values.
    Nearest,
    /// Two texels on each axis.
    Bilinear,
    /// Four texels on each axis: the interpolating cubic with slopes from neighbouring texels.
    CatmullRom,
    /// Six texels on each axis: a sinc windowed by a wider sinc. Of all filters it preserved the
    /// most in round trips of photographs.
    #[default]
    Lanczos3,
}

uvgraft_surface::choices!(Filter {
    Nearest => "nearest", "Nearest texel, never blended; for label maps";
    Bilinear => "bilinear", "2 x 2 texels; never overshoots";
    CatmullRom => "catmull-rom", "4 x 4 texels; sharp, overshoots slightly at hard edges";
    Lanczos3 => "lanczos3", "6 x 6 texels; keeps the most detail, overshoots at hard edges";
});
#[cfg(feature = "serde")]
uvgraft_surface::serialize_by_name!(Filter);

/// Maximum number of texels that a filter reads on one axis.
pub const MAX_TAPS: usize = 6;

impl Filter {
    /// All filters, from the fastest to the slowest.
    pub const ALL: [Self; 4] = [Self::Nearest, Self::Bilinear, Self::CatmullRom, Self::Lanczos3];

    /// Number of texels that the filter reads on one axis.
    pub const fn taps(self) -> usize {
        match self {
            Self::Nearest => Nearest::TAPS,
            Self::Bilinear => Bilinear::TAPS,
            Self::CatmullRom => CatmullRom::TAPS,
            Self::Lanczos3 => Lanczos3::TAPS,
        }
    }

    /// The weights of the texels around a position on one axis. Only the first [`Filter::taps`] are
    /// used; they sum to 1 within rounding.
    ///
    /// - `fraction`: `0.0..=1.0`, the distance of the position from the centre of the last texel
    ///   before it, which is the tap with index `(taps - 1) / 2`.
    ///
    /// # Source
    /// Catmull and Rom 1974, as the cubic with B = 0, C = 1/2 of Mitchell and Netravali 1988.
    /// Lanczos as in Turkowski 1990, divided by the sum of its weights, which is not exactly 1.
    pub fn weights(self, fraction: f32) -> [f32; MAX_TAPS] {
        match self {
            Self::Nearest => Nearest::weights(fraction),
            Self::Bilinear => Bilinear::weights(fraction),
            Self::CatmullRom => CatmullRom::weights(fraction),
            Self::Lanczos3 => Lanczos3::weights(fraction),
        }
    }
}

/// A filter as a type, so that kernels are monomorphised for its number of taps.
pub(crate) trait Taps: Copy + Send + Sync {
    /// See [`Filter::taps`].
    const TAPS: usize;

    /// See [`Filter::weights`].
    fn weights(fraction: f32) -> [f32; MAX_TAPS];
}

#[derive(Clone, Copy)]
pub(crate) struct Nearest;
#[derive(Clone, Copy)]
pub(crate) struct Bilinear;
#[derive(Clone, Copy)]
pub(crate) struct CatmullRom;
#[derive(Clone, Copy)]
pub(crate) struct Lanczos3;

impl Taps for Nearest {
    const TAPS: usize = 1;

    #[inline(always)]
    fn weights(_: f32) -> [f32; MAX_TAPS] {
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    }
}

impl Taps for Bilinear {
    const TAPS: usize = 2;

    #[inline(always)]
    fn weights(t: f32) -> [f32; MAX_TAPS] {
        [1.0 - t, t, 0.0, 0.0, 0.0, 0.0]
    }
}

impl Taps for CatmullRom {
    const TAPS: usize = 4;

    #[inline(always)]
    fn weights(t: f32) -> [f32; MAX_TAPS] {
        [
            ((-0.5 * t + 1.0) * t - 0.5) * t,
            (1.5 * t - 2.5) * t * t + 1.0,
            ((-1.5 * t + 2.0) * t + 0.5) * t,
            (0.5 * t - 0.5) * t * t,
            0.0,
            0.0,
        ]
    }
}

impl Taps for Lanczos3 {
    const TAPS: usize = 6;

    #[inline(always)]
    fn weights(t: f32) -> [f32; MAX_TAPS] {
        let table = &*LANCZOS;
        let phase = t * LANCZOS_PHASES as f32;
        let index = (phase as usize).min(LANCZOS_PHASES - 1);
        let t = phase - index as f32;
        let (low, high) = (&table[index], &table[index + 1]);
        std::array::from_fn(|k| low[k] + (high[k] - low[k]) * t)
    }
}

/// Phases of the Lanczos table. Linear interpolation between 1024 phases is within 2e-6 of the
/// formula, which costs twelve sines.
const LANCZOS_PHASES: usize = 1024;

static LANCZOS: LazyLock<Box<[[f32; MAX_TAPS]; LANCZOS_PHASES + 1]>> = LazyLock::new(|| {
    let mut table = Box::new([[0.0; MAX_TAPS]; LANCZOS_PHASES + 1]);
    for (phase, weights) in table.iter_mut().enumerate() {
        *weights = lanczos3_exact(phase as f64 / LANCZOS_PHASES as f64);
    }
    table
});

/// The weights `sinc(x) · sinc(x / 3)` of the six taps, normalised to sum to 1. Without that, a
/// constant image would ripple with the phase.
fn lanczos3_exact(fraction: f64) -> [f32; MAX_TAPS] {
    use std::f64::consts::PI;
    let raw: [f64; MAX_TAPS] = std::array::from_fn(|k| {
        let x = fraction + 2.0 - k as f64;
        if x == 0.0 {
            1.0
        } else if fraction == 0.0 || fraction == 1.0 {
            // In floating point the sine of a multiple of π is not exactly 0.
            0.0
        } else {
            3.0 * (PI * x).sin() * (PI * x / 3.0).sin() / (PI * PI * x * x)
        }
    });
    let sum: f64 = raw.iter().sum();
    raw.map(|weight| (weight / sum) as f32)
}

impl std::fmt::Display for Filter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_add_up_to_one_and_pass_through_texels() {
        for filter in Filter::ALL {
            for k in 0..=64 {
                let sum: f32 = filter.weights(k as f32 / 64.0).iter().sum();
                assert!((sum - 1.0).abs() < 1e-6, "{filter} {k}: {sum}");
            }
            let at_texel = filter.weights(0.0);
            for (k, weight) in at_texel.iter().enumerate() {
                let wanted = if k == (filter.taps() - 1) / 2 { 1.0 } else { 0.0 };
                assert!((weight - wanted).abs() < 1e-6, "{filter}: {at_texel:?}");
            }
        }
    }

    #[test]
    fn known_weights_half_way() {
        assert_eq!(Filter::CatmullRom.weights(0.5)[..4], [-0.0625, 0.5625, 0.5625, -0.0625]);
        // 3 sin(πx) sin(πx/3) / (πx)² at 2.5, 1.5 and 0.5, divided by the sum of all six.
        let lanczos = Filter::Lanczos3.weights(0.5);
        for (weight, wanted) in lanczos.iter().zip([0.024_457, -0.135_87, 0.611_41]) {
            assert!((weight - wanted).abs() < 1e-4, "{lanczos:?}");
        }
    }

    #[test]
    fn the_lanczos_table_is_fine_enough() {
        for k in 0..=10_000 {
            let fraction = f64::from(k) / 10_000.0;
            let (table, exact) = (Lanczos3::weights(fraction as f32), lanczos3_exact(fraction));
            for (table, exact) in table.iter().zip(exact) {
                assert!((table - exact).abs() < 2e-6, "{fraction}: {table} {exact}");
            }
        }
    }
}
