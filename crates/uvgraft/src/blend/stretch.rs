//! Composites spans of texels in stretches: what `compose::texel` does to one texel, as plain loops
//! over arrays, which compilers vectorise.
//!
//! Loops run over the actual number of texels, rounded up to full vectors: loops with a constant
//! count get fully unrolled into scalar instructions instead of being vectorised.

use std::ops::Range;

use fearless_simd::{Level, Simd};

use super::controls::{self, VALUES};
use super::field::Line;
use super::tone::toned;
use crate::simd::dispatch;
use crate::texture::Value;

/// Texels that are processed together, at most.
pub(super) const STRETCH: usize = 64;

/// Values in a stretch, at most.
const MAX_VALUES: usize = STRETCH * 4;

/// One value for each texel of a stretch.
pub(super) type Plane = [f32; STRETCH];

/// How many values of a plane are processed for a number of texels: rounded up to full vectors.
#[inline(always)]
pub(super) fn lanes(texels: usize) -> usize {
    texels.next_multiple_of(8).min(STRETCH)
}

/// De-interleaves texels into planes of levels, one per channel.
#[inline(always)]
pub(super) fn split<T: Value, const C: usize>(texels: &[T]) -> [Plane; C] {
    let mut levels = [0.0; MAX_VALUES];
    for (to, from) in levels.iter_mut().zip(texels) {
        *to = from.to_level();
    }
    let mut planes = [[0.0; STRETCH]; C];
    let texels = levels.chunks_exact(C).take(texels.len() / C);
    for (k, texel) in texels.enumerate().take(STRETCH) {
        for (plane, &level) in planes.iter_mut().zip(texel) {
            plane[k] = level;
        }
    }
    planes
}

/// Interleaves planes of levels and stores them as texels.
#[inline(always)]
pub(super) fn join<T: Value, const C: usize>(planes: &[Plane; C], texels: &mut [T]) {
    let mut levels = [0.0; MAX_VALUES];
    let of_texels = levels.chunks_exact_mut(C).take(texels.len() / C);
    for (k, texel) in of_texels.enumerate().take(STRETCH) {
        for (level, plane) in texel.iter_mut().zip(planes) {
            *level = plane[k];
        }
    }
    for (to, &level) in texels.iter_mut().zip(&levels) {
        *to = T::from_level(level);
    }
}

/// Consecutive texels in a row, from adjacent runs, which are short on their own: the
/// weights and gains of each.
#[derive(Debug, Default)]
pub(super) struct Span {
    /// The column after its last texel.
    end: usize,
    /// The weight of the layer at each texel.
    weights: Vec<f32>,
    gains: RowGains,
}

/// The gains of red, green and blue for consecutive texels in a row.
#[derive(Debug, Default)]
pub(super) struct RowGains([Vec<f32>; 3]);

impl RowGains {
    pub fn clear(&mut self) {
        self.0.iter_mut().for_each(Vec::clear);
    }

    /// The number of texels.
    pub fn len(&self) -> usize {
        self.0[0].len()
    }

    /// Adds a run of texels.
    pub fn push(&mut self, gains: &[Line; 3], len: usize) {
        for (values, gain) in self.0.iter_mut().zip(gains) {
            push(values, *gain, len);
        }
    }

    /// The gains of a channel, from texel `first` on.
    #[inline(always)]
    pub fn of(&self, channel: usize, first: usize) -> &[f32] {
        &self.0[channel][first..]
    }

    fn are_one(&self) -> bool {
        self.0.iter().flatten().all(|&gain| gain == 1.0)
    }
}

fn push(values: &mut Vec<f32>, line: Line, len: usize) {
    if line.is_level() {
        values.resize(values.len() + len, line.at(0));
    } else {
        values.extend((0..len as u32).map(|k| line.at(k)));
    }
}

impl Span {
    pub fn clear(&mut self) {
        self.weights.clear();
        self.gains.clear();
    }

    /// The columns of its texels; empty if there are none.
    pub fn columns(&self) -> Range<usize> {
        self.end - self.weights.len()..self.end
    }

    /// Adds a run of texels.
    ///
    /// - `columns`: must start where the span ends, unless it is empty.
    /// - `inside`: the signed distance from the boundary, or `None` where the layer has full
    ///   weight.
    /// - `feather`: must be positive if a distance is given.
    pub fn push(
        &mut self,
        columns: Range<usize>,
        inside: Option<Line>,
        feather: f32,
        gains: &[Line; 3],
    ) {
        let first = self.weights.len();
        push(&mut self.weights, inside.unwrap_or(Line::ONE), columns.len());
        if inside.is_some() {
            for value in &mut self.weights[first..] {
                *value = weight(*value, feather);
            }
        }
        self.gains.push(gains, columns.len());
        self.end = columns.end;
    }
}

/// Composites a layer without alpha over texels.
///
/// - `controls`: per-texel controls; empty if there are none.
pub(super) fn lay_span<T: Value, const C: usize>(
    level: Level,
    span: &Span,
    controls: &[u8],
    layer: &[T],
    texels: &mut [T],
) {
    if span.gains.are_one() {
        dispatch!(level, simd => lay::<_, T, C, false>(simd, span, controls, layer, texels));
    } else {
        dispatch!(level, simd => lay::<_, T, C, true>(simd, span, controls, layer, texels));
    }
}

/// Per channel `below + (lerp(layer, toned(layer), tone) - below) · weight`, in the order of
/// operations of `compose::texel`, so that both agree to the bit.
///
/// - `TONED`: whether any gain is not 1.
#[inline(always)]
fn lay<S: Simd, T: Value, const C: usize, const TONED: bool>(
    _: S,
    span: &Span,
    controls: &[u8],
    layer: &[T],
    texels: &mut [T],
) {
    let one = T::ONE.to_level();
    let stretches = layer.chunks(STRETCH * C).zip(texels.chunks_mut(STRETCH * C));
    for (index, (layer, texels)) in stretches.enumerate() {
        let first = index * STRETCH;
        let count = layer.len() / C;
        let mut weights = [1.0; STRETCH];
        weights[..count].copy_from_slice(&span.weights[first..][..count]);
        let mut tones = [1.0; STRETCH];
        if let Some(controls) = controls.get(first * VALUES..) {
            let of_texels = controls.chunks_exact(VALUES).zip(tones.iter_mut().zip(&mut weights));
            for (values, (tone, weight)) in of_texels.take(count) {
                let [of_tone, share] = controls::as_shares([values[0], values[1]]);
                *tone = of_tone;
                *weight *= share;
            }
        }
        let lanes = lanes(count);
        let (tones, weights) = (&tones[..lanes], &weights[..lanes]);
        let above: [Plane; C] = split(layer);
        let mut below: [Plane; C] = split(texels);
        for channel in 0..C {
            let mut levels = above[channel];
            let levels = &mut levels[..lanes];
            if TONED {
                let mut gains = [1.0; STRETCH];
                gains[..count].copy_from_slice(&span.gains.of(channel % 3, first)[..count]);
                for ((level, &gain), &tone) in levels.iter_mut().zip(&gains).zip(tones) {
                    *level = lerp(*level, toned(*level, gain, one), tone);
                }
            }
            let below = below[channel].iter_mut().zip(levels.iter()).zip(weights);
            for ((below, &level), &weight) in below {
                // A side without weight may be NaN, so it must not enter the sum.
                let mixed = *below + (level - *below) * weight;
                let whole = if weight < 1.0 { mixed } else { level };
                *below = if weight > 0.0 { whole } else { *below };
            }
        }
        join(&below, texels);
    }
}

/// The weight at a distance from the boundary: smoothstep from 0 there to 1 where the feather ends.
#[inline(always)]
pub(super) fn weight(inside: f32, feather: f32) -> f32 {
    #[expect(clippy::manual_clamp, reason = "NaN weighs nothing; `clamp` would keep it")]
    let t = (inside / feather).max(0.0).min(1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Linear interpolation that returns `to` bit for bit at a share of 1.
#[inline(always)]
pub(super) fn lerp(from: f32, to: f32, share: f32) -> f32 {
    if share < 1.0 { from + (to - from) * share } else { to }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_ends_at_its_ends_to_the_bit() {
        // Here the sum that interpolates is 0 at a share of 1.
        let (from, to) = (1e8, 0.1);
        assert_eq!([0.0, 1.0].map(|share| lerp(from, to, share)), [from, to]);
        assert_eq!(lerp(2.0, 4.0, 0.25), 2.5);
    }
}
