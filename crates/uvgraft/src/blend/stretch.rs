//! The texels of a run, a stretch of them at once: what `compose::texel` does to one, as plain loops over
//! arrays, which compilers turn into vectors.

use fearless_simd::{Level, Simd};

use crate::simd::dispatch;
use crate::texture::Value;

use super::compose::mixed;
use super::controls;
use super::field::Line;
use super::tone::toned;

/// Texels that are worked on together.
const STRETCH: usize = 16;

/// Values of a stretch, at most.
const MOST: usize = STRETCH * 4;

/// How the texels of a run are laid over what is there.
#[derive(Clone, Copy)]
pub(super) struct Run<'a> {
    /// The signed distance from the rim.
    pub inside: Line,
    /// Greater than 0.
    pub feather: f32,
    /// The gain of each channel.
    pub gains: [Line; 3],
    /// What labels say about its texels; empty for nothing.
    pub controls: &'a [u8],
}

/// Lays a run of texels without opacity over what is there.
pub(super) fn lay_run<T: Value, const C: usize>(
    level: Level,
    run: &Run<'_>,
    layer: &[T],
    texels: &mut [T],
) {
    let len = (layer.len() / C) as u32;
    if run.gains.iter().any(|gain| !gain.is_constant(1.0, len)) {
        dispatch!(level, simd => in_vectors::<_, T, C, true>(simd, run, layer, texels));
    } else {
        dispatch!(level, simd => in_vectors::<_, T, C, false>(simd, run, layer, texels));
    }
}

/// As [`lay`], compiled for what a processor has.
#[inline(always)]
fn in_vectors<S: Simd, T: Value, const C: usize, const TONED: bool>(
    _: S,
    run: &Run<'_>,
    layer: &[T],
    texels: &mut [T],
) {
    lay::<T, C, TONED>(run, layer, texels);
}

/// - `TONED`: whether any gain is not 1.
#[inline(always)]
fn lay<T: Value, const C: usize, const TONED: bool>(run: &Run<'_>, layer: &[T], texels: &mut [T]) {
    let one = T::ONE.to_level();
    let pieces = layer.chunks(STRETCH * C).zip(texels.chunks_mut(STRETCH * C));
    for (index, (layer, texels)) in pieces.enumerate() {
        let first = (index * STRETCH) as u32;
        let (mut weights, mut gains, mut tones) = ([0.0; MOST], [1.0; MOST], [1.0; MOST]);
        for k in 0..STRETCH {
            let at = first + k as u32;
            let [tone, carried] = controls::at(run.controls, at as usize);
            let weight = weight(run.inside.at(at), run.feather) * carried;
            for channel in 0..C {
                weights[k * C + channel] = weight;
                tones[k * C + channel] = tone;
                gains[k * C + channel] = run.gains[channel % 3].at(at);
            }
        }
        let (mut above, mut below) = ([0.0; MOST], [0.0; MOST]);
        for (to, from) in above.iter_mut().zip(layer) {
            *to = from.to_level();
        }
        for (to, from) in below.iter_mut().zip(texels.iter()) {
            *to = from.to_level();
        }
        for i in 0..STRETCH * C {
            let level = if TONED { toned(above[i], gains[i], one) } else { above[i] };
            let level = mixed(above[i], level, tones[i]);
            // Where one side is nothing, it may be no number.
            let mixed = below[i] + (level - below[i]) * weights[i];
            let whole = if weights[i] < 1.0 { mixed } else { level };
            above[i] = if weights[i] > 0.0 { whole } else { below[i] };
        }
        for (to, &from) in texels.iter_mut().zip(&above) {
            *to = T::from_level(from);
        }
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
