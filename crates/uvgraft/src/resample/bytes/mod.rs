//! 8-bit textures without alpha, in integers: the arithmetic of [`reference()`] that all fast paths
//! share, and the loop over a map's runs.
//!
//! Weights have [`WEIGHT_BITS`] fraction bits. Each row of a window is filtered first and
//! truncated to [`ROW_BITS`] fraction bits, which fit 16 bits with the sign; then the filtered
//! rows are combined. So both passes multiply 16-bit values into 32-bit sums, which processors
//! do in one instruction for two taps, and a value is within 1/16 level of exact arithmetic
//! before both are rounded.
//!
//! [`reference()`]: super::reference::resample

#[cfg(target_arch = "x86_64")]
mod avx2;
mod weights;

use fearless_simd::Level;
use uvgraft_surface::threads::for_each_chunk;

use self::weights::{WEIGHT_BITS, WholeTaps};
use super::position::{near_texture, split};
use super::stretch::Job;
use super::{Paths, Walk};
use crate::filter::{Bilinear, CatmullRom, Filter, Lanczos3};
use crate::map::SamplingMap;
use crate::texture::Size;

/// Fraction bits of a filtered row: what 16 bits leave for values up to twice the range.
const ROW_BITS: u32 = 6;

/// Fraction bits of a window's value.
const VALUE_BITS: u32 = WEIGHT_BITS + ROW_BITS;

/// Fraction bits of the sum of a texel's samples, of which there may be 1024.
const SUM_BITS: u32 = 12;

/// Mean error of truncating the rows of a window, added back to its value. Half a unit of each row,
/// times weights that add up to 1.
const LOST: i32 = 1 << (WEIGHT_BITS - 1);

/// The filtered value at a position, with [`VALUE_BITS`] fraction bits.
///
/// - `window`: returns the texel at a column and row of the window.
#[inline(always)]
fn filtered<const C: usize, F: WholeTaps>(
    bits: [u32; 2],
    window: impl Fn(usize, usize) -> [u8; C],
) -> [i32; C] {
    // `map` over the two is a call for each sample where the compiler does not inline it.
    let (across, down) = (F::whole_weights(bits[0]), F::whole_weights(bits[1]));
    let mut value = [0; C];
    for b in 0..F::TAPS {
        let mut row = [0; C];
        for a in 0..F::TAPS {
            let texel = window(a, b);
            for channel in 0..C {
                row[channel] += i32::from(texel[channel]) * i32::from(across[a]);
            }
        }
        for channel in 0..C {
            value[channel] += (row[channel] >> (WEIGHT_BITS - ROW_BITS)) * i32::from(down[b]);
        }
    }
    value
}

/// The value of a texel whose windows may lie anywhere; taps beyond the texture read its edge.
fn texel_clamped<const C: usize, F: WholeTaps>(
    walk: &Walk<'_>,
    k: u32,
    source: &[u8],
    size: Size,
) -> [u8; C] {
    mean(walk.samples(), |a, b| {
        let at = walk.sample(k, a, b);
        let (x, bits_x) = split(near_texture(at[0], size.width));
        let (y, bits_y) = split(near_texture(at[1], size.height));
        let before = F::TAPS as i32 / 2 - 1;
        filtered::<C, F>([bits_x, bits_y], |a, b| {
            let x = (x + a as i32 - before).clamp(0, size.width as i32 - 1) as usize;
            let y = (y + b as i32 - before).clamp(0, size.height as i32 - 1) as usize;
            let start = (y * size.width as usize + x) * C;
            std::array::from_fn(|channel| source[start + channel])
        })
    })
}

/// The same for windows that lie inside the texture.
#[inline(always)]
fn texel_inside<const C: usize, F: WholeTaps>(
    walk: &Walk<'_>,
    k: u32,
    source: &[u8],
    size: Size,
) -> [u8; C] {
    mean(walk.samples(), |a, b| {
        let [(x, bits_x), (y, bits_y)] = walk.sample(k, a, b).map(split);
        let before = F::TAPS as i32 / 2 - 1;
        let start = (y - before) as usize * size.width as usize + (x - before) as usize;
        filtered::<C, F>([bits_x, bits_y], |a, b| {
            let texel = &source[(start + b * size.width as usize + a) * C..][..C];
            std::array::from_fn(|channel| texel[channel])
        })
    })
}

/// The mean of a texel's samples.
#[inline(always)]
fn mean<const C: usize>(
    [columns, rows]: [u32; 2],
    mut sample: impl FnMut(u32, u32) -> [i32; C],
) -> [u8; C] {
    if [columns, rows] == [1, 1] {
        let half = 1 << (VALUE_BITS - 1);
        return sample(0, 0).map(|value| ((value + half + LOST) >> VALUE_BITS).clamp(0, 255) as u8);
    }
    let mut sums = [0; C];
    for b in 0..rows {
        for a in 0..columns {
            for (sum, value) in sums.iter_mut().zip(sample(a, b)) {
                *sum += (value + LOST) >> (VALUE_BITS - SUM_BITS);
            }
        }
    }
    let share = share([columns, rows]);
    sums.map(|sum| (sum as f32 * share).round_ties_even().clamp(0.0, 255.0) as u8)
}

/// The factor that turns the sum of a texel's samples into their mean level.
#[inline(always)]
fn share([columns, rows]: [u32; 2]) -> f32 {
    1.0 / ((columns * rows) << SUM_BITS) as f32
}

/// As [`super::reference::resample`] on some rows of the target, for filters with several taps.
pub(super) fn resample<const C: usize>(
    #[cfg_attr(not(target_arch = "x86_64"), expect(unused_variables))] level: Level,
    map: &SamplingMap,
    paths: &Paths,
    source: &[u8],
    first_row: u32,
    rows: &mut [u8],
) {
    let job = Job { map, paths, source };
    let piece = super::ROWS;
    for_each_chunk(rows, map.size().width as usize * C * piece, |chunk, rows| {
        let first_row = first_row + (chunk * piece) as u32;
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = level.as_avx2() {
            return avx2::fill::<C>(level, avx2, &job, first_row, rows);
        }
        match paths.filter {
            Filter::Nearest => unreachable!("takes texels as they are"),
            Filter::Bilinear => plain::<C, Bilinear>(&job, first_row, rows),
            Filter::CatmullRom => plain::<C, CatmullRom>(&job, first_row, rows),
            Filter::Lanczos3 => plain::<C, Lanczos3>(&job, first_row, rows),
        }
    });
}

/// The path for processors without AVX2.
fn plain<const C: usize, F: WholeTaps>(job: &Job<'_, u8>, first_row: u32, rows: &mut [u8]) {
    let size = job.paths.source;
    let width = job.map.size().width as usize * C;
    for (row, target) in (first_row..).zip(rows.chunks_mut(width)) {
        for &run in job.map.row(row) {
            let walk = job.paths.walk(row, run);
            let texels = &mut target[run.x as usize * C..][..run.len as usize * C];
            let is_inside = walk.stays_inside(run.len, size);
            for (k, values) in (0..).zip(texels.chunks_exact_mut(C)) {
                let texel = if is_inside {
                    texel_inside::<C, F>(&walk, k, job.source, size)
                } else {
                    texel_clamped::<C, F>(&walk, k, job.source, size)
                };
                values.copy_from_slice(&texel);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::position::fraction;
    use super::*;
    use crate::filter::MAX_TAPS;

    /// The same filter in 64-bit floats.
    fn exact<F: WholeTaps>(bits: [u32; 2], window: impl Fn(usize, usize) -> u8) -> f64 {
        let [across, down] = bits.map(|bits| F::weights(fraction(bits)).map(f64::from));
        let mut value = 0.0;
        for b in 0..F::TAPS {
            for a in 0..F::TAPS {
                value += f64::from(window(a, b)) * across[a] * down[b];
            }
        }
        value
    }

    fn compare<F: WholeTaps>() {
        let mut rng = fastrand::Rng::with_seed(F::TAPS as u64);
        let mut worst: f64 = 0.0;
        for turn in 0..20_000 {
            // Half of the windows have maximum contrast.
            let texels: [u8; MAX_TAPS * MAX_TAPS] =
                std::array::from_fn(|_| if turn % 2 == 0 { rng.u8(..) } else { 255 * rng.u8(..2) });
            let window = |a: usize, b: usize| texels[b * MAX_TAPS + a];
            let bits = [rng.u32(..), rng.u32(..)];
            let [value] = filtered::<1, F>(bits, |a, b| [window(a, b)]);
            let value = f64::from(value + LOST) / f64::from(1 << VALUE_BITS);
            worst = worst.max((value - exact::<F>(bits, window)).abs());
        }
        assert!(worst < 1.0 / 16.0, "{} taps: {worst}", F::TAPS);
    }

    #[test]
    fn values_are_within_a_sixteenth_of_a_level() {
        compare::<Bilinear>();
        compare::<CatmullRom>();
        compare::<Lanczos3>();
    }

    #[test]
    fn constant_colours_are_preserved() {
        fn check<F: WholeTaps>() {
            for k in 0..1000 {
                let bits = [k * 4_294_967, u32::MAX - k * 4_000_000];
                for level in 0..=255 {
                    for samples in [[1, 1], [2, 3], [32, 32]] {
                        let texel = mean(samples, |_, _| filtered::<1, F>(bits, |_, _| [level]));
                        assert_eq!(texel, [level], "{bits:?} {samples:?}");
                    }
                    if k > 20 {
                        break;
                    }
                }
            }
        }
        check::<Bilinear>();
        check::<CatmullRom>();
        check::<Lanczos3>();
    }
}
