//! The texels of a run, a stretch of them at once: what `compose::texel` does to one, as plain loops over
//! arrays, which compilers turn into vectors.
//!
//! Loops have as many turns as there are texels, in full vectors: of loops that always have the same, compilers make one
//! instruction after the other, and no vectors.

use std::ops::Range;

use fearless_simd::{Level, Simd};

use super::controls::{self, VALUES};
use super::field::Line;
use super::tone::toned;
use crate::simd::dispatch;
use crate::texture::Value;

/// Texels that are worked on together, at most.
pub(super) const STRETCH: usize = 64;

/// Values of a stretch, at most.
const MOST: usize = STRETCH * 4;

/// A value of each texel.
pub(super) type Plane = [f32; STRETCH];

/// How many values of a plane are worked on for so many texels: no vector is left half full.
#[inline(always)]
pub(super) fn lanes(texels: usize) -> usize {
    texels.next_multiple_of(8).min(STRETCH)
}

/// The levels of texels, channel by channel.
#[inline(always)]
pub(super) fn split<T: Value, const C: usize>(texels: &[T]) -> [Plane; C] {
    let mut levels = [0.0; MOST];
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

/// Stores levels, texel by texel.
#[inline(always)]
pub(super) fn join<T: Value, const C: usize>(planes: &[Plane; C], texels: &mut [T]) {
    let mut levels = [0.0; MOST];
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

/// Texels in a row, of runs that are beside each other: runs are short. Values of each.
#[derive(Debug, Default)]
pub(super) struct Span {
    /// The column behind its last texel.
    end: usize,
    /// How much of the layer there is.
    weights: Vec<f32>,
    gains: RowGains,
}

/// The gains of red, green and blue for texels in a row.
#[derive(Debug, Default)]
pub(super) struct RowGains([Vec<f32>; 3]);

impl RowGains {
    pub fn clear(&mut self) {
        self.0.iter_mut().for_each(Vec::clear);
    }

    /// How many texels there are.
    pub fn len(&self) -> usize {
        self.0[0].len()
    }

    /// Adds a run of texels.
    pub fn push(&mut self, gains: &[Line; 3], len: usize) {
        for (values, gain) in self.0.iter_mut().zip(gains) {
            push(values, *gain, len);
        }
    }

    /// Those of a channel, from a texel on.
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

    /// The columns of its texels; none if there are none.
    pub fn columns(&self) -> Range<usize> {
        self.end - self.weights.len()..self.end
    }

    /// Adds a run of texels.
    ///
    /// - `columns`: from where the span ends, unless it is empty.
    /// - `inside`: the signed distance from the rim, or nothing where all of the layer is there.
    /// - `feather`: greater than 0 if there is a distance.
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

/// Lays texels without opacity over what is there.
///
/// - `controls`: what labels say about them; empty for nothing.
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
    let pieces = layer.chunks(STRETCH * C).zip(texels.chunks_mut(STRETCH * C));
    for (index, (layer, texels)) in pieces.enumerate() {
        let first = index * STRETCH;
        let count = layer.len() / C;
        let mut weights = [1.0; STRETCH];
        weights[..count].copy_from_slice(&span.weights[first..][..count]);
        let mut tones = [1.0; STRETCH];
        if let Some(controls) = controls.get(first * VALUES..) {
            let of_texels = controls.chunks_exact(VALUES).zip(tones.iter_mut().zip(&mut weights));
            for (values, (tone, weight)) in of_texels.take(count) {
                let [of_tone, carried] = controls::as_shares([values[0], values[1]]);
                *tone = of_tone;
                *weight *= carried;
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
                    *level = mixed(*level, toned(*level, gain, one), tone);
                }
            }
            let below = below[channel].iter_mut().zip(levels.iter()).zip(weights);
            for ((below, &level), &weight) in below {
                // Where one side is nothing, it may be no number.
                let mixed = *below + (level - *below) * weight;
                let whole = if weight < 1.0 { mixed } else { level };
                *below = if weight > 0.0 { whole } else { *below };
            }
        }
        join(&below, texels);
    }
}

/// From 0 at the rim to 1 where a feather ends, even at both.
#[inline(always)]
pub(super) fn weight(inside: f32, feather: f32) -> f32 {
    #[expect(
        clippy::manual_clamp,
        reason = "what is no number weighs nothing; `clamp` would keep it"
    )]
    let t = (inside / feather).max(0.0).min(1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A value on the way to another; the other to the bit where all of the way is gone.
#[inline(always)]
pub(super) fn mixed(from: f32, to: f32, share: f32) -> f32 {
    if share < 1.0 { from + (to - from) * share } else { to }
}
