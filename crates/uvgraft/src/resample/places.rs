//! Where the windows of a batch of texels lie.

use fearless_simd::{
    Bytes, Select, Simd, SimdBase, SimdInto, SimdNarrow, f32x8, f64x4, i32x8, i64x4, u32x8,
};

use super::{NEAR, WHOLE, Walk};
use crate::filter::Taps;
use crate::texture::Size;

/// Texels of a run that are worked on together: what is known about them fits the first cache.
pub(super) const BATCH: usize = 64;

/// Texels that are placed at once.
const GROUP: usize = 8;

/// Where the windows of a batch of texels lie.
pub(super) struct Places {
    /// Column and row of the window's first texel.
    pub corner: [[i32; BATCH]; 2],
    /// Its number in the source, for windows that lie in it.
    pub start: [u32; BATCH],
    /// How far the position lies beyond the centre of the texel before it, on each axis.
    pub fraction: [[f32; BATCH]; 2],
}

impl Places {
    pub fn new() -> Self {
        Self { corner: [[0; BATCH]; 2], start: [0; BATCH], fraction: [[0.0; BATCH]; 2] }
    }

    /// Places sample `(a, b)` of `count` texels of a run from `first` on, and of some more texels up
    /// to a whole group.
    ///
    /// - `clear`: whether all windows lie in the source; others are moved near to it.
    #[inline(always)]
    pub fn find<S: Simd, F: Taps>(
        &mut self,
        simd: S,
        source: Size,
        walk: &Walk,
        (first, count): (usize, usize),
        (a, b): (u32, u32),
        clear: bool,
    ) {
        let before = F::TAPS as i32 / 2 - 1;
        let width = i32x8::splat(simd, source.width as i32);
        let x_line = Line::new(simd, walk.line(0, a, b), source.width);
        let y_line = Line::new(simd, walk.line(1, a, b), source.height);
        for group in (0..count).step_by(GROUP) {
            let k = (first + group) as f64;
            let (x, fraction) = x_line.split(k, clear);
            fraction.store_slice(&mut self.fraction[0][group..][..GROUP]);
            let (y, fraction) = y_line.split(k, clear);
            fraction.store_slice(&mut self.fraction[1][group..][..GROUP]);
            let (x, y) = (x - before, y - before);
            if clear {
                let start: u32x8<S> = (y * width + x).bitcast();
                start.store_slice(&mut self.start[group..][..GROUP]);
            } else {
                x.store_slice(&mut self.corner[0][group..][..GROUP]);
                y.store_slice(&mut self.corner[1][group..][..GROUP]);
            }
        }
    }
}

/// The positions of one sample of a run's texels on one axis.
struct Line<S: Simd> {
    start: f64x4<S>,
    step: f64x4<S>,
    a: f64x4<S>,
    b: f64x4<S>,
    count: f64x4<S>,
    /// The positions between which a texel is near to the source.
    near: [f64x4<S>; 2],
}

impl<S: Simd> Line<S> {
    #[inline(always)]
    fn new(simd: S, [start, step, a, b]: [f64; 4], texels: u32) -> Self {
        Self {
            start: f64x4::splat(simd, start),
            step: f64x4::splat(simd, step),
            a: f64x4::splat(simd, a),
            b: f64x4::splat(simd, b),
            count: [0.0, 1.0, 2.0, 3.0].simd_into(simd),
            near: [f64x4::splat(simd, -NEAR), f64x4::splat(simd, f64::from(texels) + NEAR)],
        }
    }

    /// As [`split`](super::split) of a group of positions from texel `k` on.
    #[inline(always)]
    fn split(&self, k: f64, clear: bool) -> (i32x8<S>, f32x8<S>) {
        let (low, high) = (self.half(k, clear), self.half(k + 4.0, clear));
        (low.0.narrow(high.0), low.1.narrow(high.1))
    }

    /// The same for half a group; the texels are in the low halves of numbers.
    #[inline(always)]
    fn half(&self, k: f64, clear: bool) -> (i64x4<S>, f64x4<S>) {
        let mut position = self.start + (self.count + k) * self.step + self.a + self.b;
        if !clear {
            // As `near_texture`.
            let [least, most] = self.near;
            position = position.simd_lt(least).select(least, position);
            position = position.simd_gt(most).select(most, position);
        }
        let sum = position - 1.0 + WHOLE;
        (sum.bitcast(), position - 0.5 - (sum - WHOLE))
    }
}
