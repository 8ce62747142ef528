//! Window positions in the source for a batch of texels.

use fearless_simd::{Bytes, Simd, SimdBase, SimdInt, SimdInto, f32x8, i32x8, i64x4, u32x8};

use super::Walk;
use super::position::{before_window, fraction, halves, near_texture, split};
use crate::filter::Taps;
use crate::texture::Size;

/// Texels of a run that are processed together: their data fits the L1 cache.
pub(super) const BATCH: usize = 64;

/// Texels that are located at once.
const GROUP: usize = 8;

/// Window positions in the source for a batch of texels.
pub(super) struct Windows {
    /// Column and row of the window's first texel, for windows that may leave the source.
    pub corner: [[i32; BATCH]; 2],
    /// Index of that texel, for windows inside the source.
    pub start: [u32; BATCH],
    /// Distance of the position from the centre of the texel before it, on each axis.
    pub fraction: [[f32; BATCH]; 2],
}

impl Windows {
    pub fn new() -> Self {
        Self { corner: [[0; BATCH]; 2], start: [0; BATCH], fraction: [[0.0; BATCH]; 2] }
    }

    /// Locates the windows of sample `(a, b)` of `count` texels of a run from `first` on, by index.
    /// All windows must lie inside the source. Also writes some texels more, up to a whole group.
    #[inline(always)]
    pub fn find_starts<S: Simd, F: Taps>(
        &mut self,
        simd: S,
        source: Size,
        walk: &Walk<'_>,
        (first, count): (usize, usize),
        (a, b): (u32, u32),
    ) {
        let width = i32x8::splat(simd, source.width as i32);
        // A closure for both axes would not be inlined.
        let ([x, y], [step_x, step_y]) = (walk.sample(first as u32, a, b), walk.step());
        let mut x_line = Line::new(simd, x - before_window(F::TAPS), step_x);
        let mut y_line = Line::new(simd, y - before_window(F::TAPS), step_y);
        for group in (0..count).step_by(GROUP) {
            let (x, fraction) = x_line.split();
            fraction.store_slice(&mut self.fraction[0][group..][..GROUP]);
            let (y, fraction) = y_line.split();
            fraction.store_slice(&mut self.fraction[1][group..][..GROUP]);
            let start: u32x8<S> = (y * width + x).bitcast();
            start.store_slice(&mut self.start[group..][..GROUP]);
            x_line.advance();
            y_line.advance();
        }
    }

    /// Locates windows that may lie anywhere, by their corners.
    #[inline(always)]
    pub fn find_corners<F: Taps>(
        &mut self,
        source: Size,
        walk: &Walk<'_>,
        (first, count): (usize, usize),
        (a, b): (u32, u32),
    ) {
        let size = [source.width, source.height];
        for k in 0..count {
            let at = walk.sample((first + k) as u32, a, b);
            for axis in 0..2 {
                let (texel, bits) = split(near_texture(at[axis], size[axis]));
                self.corner[axis][k] = texel - (F::TAPS as i32 / 2 - 1);
                self.fraction[axis][k] = fraction(bits);
            }
        }
    }
}

/// The positions of one sample of a group of texels on one axis.
struct Line<S: Simd> {
    low: i64x4<S>,
    high: i64x4<S>,
    stride: i64x4<S>,
}

impl<S: Simd> Line<S> {
    #[inline(always)]
    fn new(simd: S, start: i64, step: i64) -> Self {
        // Lanes beyond the last texel of a run may hold anything, so overflow is harmless.
        let at = |k: i64| start.wrapping_add(k.wrapping_mul(step));
        Self {
            low: [at(0), at(1), at(2), at(3)].simd_into(simd),
            high: [at(4), at(5), at(6), at(7)].simd_into(simd),
            stride: i64x4::splat(simd, step.wrapping_mul(GROUP as i64)),
        }
    }

    #[inline(always)]
    fn advance(&mut self) {
        self.low += self.stride;
        self.high += self.stride;
    }

    /// The texels before the group's positions and the fractions beyond them; as [`split`] and
    /// [`fraction`].
    #[inline(always)]
    fn split(&self) -> (i32x8<S>, f32x8<S>) {
        let [low, high]: [i32x8<S>; 2] = [self.low.bitcast(), self.high.bitcast()];
        let (texels, fractions) = halves(low.unzip_low(high), low.unzip_high(high));
        let bits: u32x8<S> = fractions.bitcast();
        let fraction: i32x8<S> = (bits >> 8).bitcast();
        (texels, fraction.to_float::<f32x8<S>>() * (1.0 / 16_777_216.0))
    }
}
