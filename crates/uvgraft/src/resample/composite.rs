//! Compositing texels over those of a target, several at once.

use fearless_simd::{Simd, SimdBase, SimdInto, f32x4};

use crate::texture::Value;

/// Texels that are composited at once.
pub(super) const GROUP: usize = 8;

/// As [`super::store`] of texels with alpha, to the bit.
///
/// - `levels`: filtered, premultiplied levels; of each only the first `C` are used.
#[inline(always)]
pub(super) fn store_all<S: Simd, T: Value, const C: usize>(
    simd: S,
    levels: &[[f32; 4]],
    texels: &mut [T],
) {
    let (groups, rest) = levels.as_chunks::<GROUP>();
    let (whole, last) = texels.split_at_mut(groups.len() * GROUP * C);
    for (levels, texels) in groups.iter().zip(whole.chunks_exact_mut(GROUP * C)) {
        store_group::<S, T, C>(simd, levels, texels);
    }
    if !rest.is_empty() {
        let mut levels = [[0.0; 4]; GROUP];
        let mut texels = [T::default(); GROUP * 4];
        levels[..rest.len()].copy_from_slice(rest);
        texels[..last.len()].copy_from_slice(last);
        store_group::<S, T, C>(simd, &levels, &mut texels[..GROUP * C]);
        last.copy_from_slice(&texels[..last.len()]);
    }
}

#[inline(always)]
fn store_group<S: Simd, T: Value, const C: usize>(
    simd: S,
    levels: &[[f32; 4]; GROUP],
    texels: &mut [T],
) {
    let one = T::ONE.to_level();
    let (mut scale, mut below, mut total) = ([0.0; GROUP], [0.0; GROUP], [0.0; GROUP]);
    for k in 0..GROUP {
        below[k] = texels[k * C + C - 1].to_level();
    }
    // These divisions are vectors of texels, those of colours vectors of channels.
    for k in 0..GROUP {
        let level = levels[k][C - 1];
        let alpha = level.min(one);
        scale[k] = alpha / level * one;
        below[k] *= (one - alpha) / one;
        total[k] = alpha + below[k];
    }
    let mut values = [[0.0; 4]; GROUP];
    for k in 0..GROUP {
        let above: f32x4<S> = levels[k].simd_into(simd);
        let mut texel = [0.0; 4];
        for channel in 0..C {
            texel[channel] = texels[k * C + channel].to_level();
        }
        let texel: f32x4<S> = texel.simd_into(simd);
        let sum = above * scale[k] + texel * below[k];
        values[k] = (sum / f32x4::splat(simd, total[k])).into();
        values[k][C - 1] = total[k];
    }
    let mut stored = [T::default(); GROUP * 4];
    for (stored, &value) in stored.iter_mut().zip(values.as_flattened()) {
        *stored = T::from_level(value);
    }
    for k in 0..GROUP {
        // Written this way, so that it also holds for what is no number.
        let is_clear = levels[k][C - 1] <= 0.0;
        if !is_clear {
            texels[k * C..][..C].copy_from_slice(&stored[k * 4..][..C]);
        }
    }
}
