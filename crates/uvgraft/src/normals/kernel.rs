//! Reorients the normals of a run of texels, eight at a time.
//!
//! With `T` and `N` the interpolated tangent and normal of a frame, neither normalised, and
//! `B = sign · N × T`, a decoded normal `(x, y, z)` stands for `x·T + y·B + z·N` in object
//! space. The components of an object-space normal `n` in another frame are its dot products
//! with the rows of that frame's inverse. Up to a positive factor, which the final
//! normalisation removes, these rows are `B × N`, `N × T` and `T × B` times the sign of the
//! determinant, which equals `sign`. With the `B` above, the components are
//!
//! ```text
//! x = (n·T) (N·N) − (n·N) (N·T)
//! y = sign · n·(N × T)
//! z = (n·N) (T·T) − (n·T) (N·T)
//! ```

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdFrom, f32x8};

use super::walk::Walk;

/// Texels processed at a time.
const LANES: usize = 8;

/// Shorter decoded normals have no meaningful direction: the rounding error of 8 bits is
/// forty times as large.
const SHORTEST: f32 = 1e-4;

/// Squared length below which a result is not normalised; the vectors of frames have
/// lengths near 1.
const MIN: f32 = 1e-30;

type Vector<S> = [f32x8<S>; 3];

/// Reorients the normals of texels with `C` channels, in place; a fourth channel is left as it is.
#[inline(always)]
pub(super) fn turn<S: Simd, const C: usize>(simd: S, walk: &Walk, texels: &mut [f32]) {
    let iota = f32x8::simd_from(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    let mut begin = 0.0;
    for group in texels.chunks_mut(LANES * C) {
        let mut decoded = [[0.0; LANES]; 3];
        for (lane, texel) in group.chunks_exact(C).enumerate() {
            for k in 0..3 {
                decoded[k][lane] = texel[k] * 2.0 - 1.0;
            }
        }
        let normal = [
            f32x8::simd_from(simd, decoded[0]),
            f32x8::simd_from(simd, decoded[1]),
            f32x8::simd_from(simd, decoded[2]),
        ];
        let [x, y, z] = reoriented(simd, walk, iota + begin, normal);
        let encoded: [[f32; LANES]; 3] =
            [(x * 0.5 + 0.5).into(), (y * 0.5 + 0.5).into(), (z * 0.5 + 0.5).into()];
        for (lane, texel) in group.chunks_exact_mut(C).enumerate() {
            for k in 0..3 {
                texel[k] = encoded[k][lane];
            }
        }
        begin += LANES as f32;
    }
}

/// Maps decoded normals from the source frame to the target frame, by the formula at the
/// top of this file. The result has length 1; it is (0, 0, 1) where the input or a frame is
/// degenerate or not finite.
#[inline(always)]
fn reoriented<S: Simd>(simd: S, walk: &Walk, at: f32x8<S>, [x, y, z]: Vector<S>) -> Vector<S> {
    let [src_sign, tgt_sign] = walk.signs;
    let tangent = along(simd, walk, 0, at);
    let normal = along(simd, walk, 1, at);
    let bitangent = cross(normal, tangent);
    let y_signed = y * src_sign;
    let object = [
        tangent[0] * x + bitangent[0] * y_signed + normal[0] * z,
        tangent[1] * x + bitangent[1] * y_signed + normal[1] * z,
        tangent[2] * x + bitangent[2] * y_signed + normal[2] * z,
    ];

    let tangent = along(simd, walk, 2, at);
    let normal = along(simd, walk, 3, at);
    let on_tangent = dot(object, tangent);
    let on_normal = dot(object, normal);
    let skew = dot(tangent, normal);
    let found = [
        on_tangent * dot(normal, normal) - on_normal * skew,
        dot(object, cross(normal, tangent)) * tgt_sign,
        on_normal * dot(tangent, tangent) - on_tangent * skew,
    ];

    // Comparisons with NaN are false.
    let decoded = x * x + y * y + z * z;
    let squared = dot(found, found);
    let is_sound = decoded.simd_gt(SHORTEST * SHORTEST)
        & squared.simd_gt(MIN)
        & squared.simd_lt(f32::INFINITY);
    let scale = 1.0 / squared.sqrt();
    let zero = f32x8::splat(simd, 0.0);
    [
        is_sound.select(found[0] * scale, zero),
        is_sound.select(found[1] * scale, zero),
        is_sound.select(found[2] * scale, f32x8::splat(simd, 1.0)),
    ]
}

/// One of the four vectors of [`Walk`]'s frames, at the texels `at`.
#[inline(always)]
fn along<S: Simd>(simd: S, walk: &Walk, vector: usize, at: f32x8<S>) -> Vector<S> {
    let (first, step) = (walk.first[vector], walk.step[vector]);
    [
        at * step[0] + f32x8::splat(simd, first[0]),
        at * step[1] + f32x8::splat(simd, first[1]),
        at * step[2] + f32x8::splat(simd, first[2]),
    ]
}

#[inline(always)]
fn dot<S: Simd>(a: Vector<S>, b: Vector<S>) -> f32x8<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<S: Simd>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use glam::{DVec3, Vec3};
    use uvgraft_surface::directions::direction;

    use super::*;
    use crate::normals::frames::Frames;

    fn turn_with<const C: usize>(walk: &Walk, texels: &mut [f32]) {
        dispatch!(Level::new(), simd => turn::<_, C>(simd, walk, texels));
    }

    /// The reference in 64 bits: to object space, and back by Cramer's rule.
    fn expected(frames: &Frames, signs: [f32; 2], texel: [f32; 3]) -> [f64; 3] {
        let wide = |vector: [f32; 3]| Vec3::from(vector).as_dvec3();
        let frame = |tangent: usize, sign: f32| {
            let (tangent, normal) = (wide(frames[tangent]), wide(frames[tangent + 1]));
            [tangent, normal.cross(tangent) * f64::from(sign), normal]
        };
        let decoded = wide(texel) * 2.0 - 1.0;
        let source = frame(0, signs[0]);
        let object: DVec3 = (0..3).map(|k| source[k] * decoded[k]).sum();
        let [t, b, n] = frame(2, signs[1]);
        let determinant = t.dot(b.cross(n));
        let parts = [b.cross(n), n.cross(t), t.cross(b)].map(|row| object.dot(row) / determinant);
        (direction(parts.into()).unwrap() * 0.5 + 0.5).to_array()
    }

    #[test]
    fn agrees_with_the_reference() {
        let mut rng = fastrand::Rng::with_seed(11);
        let mut random = |size: f32| [(); 3].map(|()| (rng.f32() - 0.5) * size);
        for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            let first = [(); 4].map(|()| random(2.0));
            let step = [(); 4].map(|()| random(0.01));
            let walk = Walk { first, step, signs };
            let texels: Vec<f32> =
                (0..21).flat_map(|_| random(1.0).map(|value| value + 0.5)).collect();
            let mut found = texels.clone();
            turn_with::<3>(&walk, &mut found);
            for (k, (texel, found)) in texels.chunks(3).zip(found.chunks(3)).enumerate() {
                let mut frames = first;
                for (value, step) in frames.as_flattened_mut().iter_mut().zip(step.as_flattened()) {
                    *value += step * k as f32;
                }
                let wanted = expected(&frames, signs, [texel[0], texel[1], texel[2]]);
                for (found, wanted) in found.iter().zip(wanted) {
                    // Random frames may be nearly degenerate, which costs precision.
                    assert!((f64::from(*found) - wanted).abs() < 1e-4, "{found} {wanted}");
                }
            }
        }
    }

    const UPRIGHT: Frames = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];

    fn still(first: Frames, signs: [f32; 2]) -> Walk {
        Walk { first, step: Frames::default(), signs }
    }

    #[test]
    fn a_quarter_turn_turns_red_to_green() {
        // The target's tangent is the source's bitangent, so what was green is red now, and what
        // was red points against the new bitangent.
        let mut frames = UPRIGHT;
        frames[2] = [0.0, 1.0, 0.0];
        let mut texels = [0.8, 0.5, 0.9, 0.25, 0.5, 0.8, 0.9, 0.75];
        turn_with::<4>(&still(frames, [1.0, 1.0]), &mut texels);
        let wanted = [0.5, 0.2, 0.9, 0.25, 0.8, 0.5, 0.9, 0.75];
        for (found, wanted) in texels.iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-6, "{texels:?}");
        }
        // In a mirrored chart green points the other way.
        let mut texels = [0.5, 0.8, 0.9];
        turn_with::<3>(&still(UPRIGHT, [1.0, -1.0]), &mut texels);
        assert!((texels[1] - 0.2).abs() < 1e-6, "{texels:?}");
    }

    #[test]
    fn normals_without_direction_become_flat() {
        let flat = [0.5, 0.5, 1.0];
        let near_zero = [0.5 + 3e-5, 0.5, 0.5];
        let broken =
            [[0.5; 3], near_zero, [f32::NAN, 0.5, 1.0], [f32::INFINITY, 0.5, 1.0], [1e30; 3]];
        for texel in broken {
            let mut texels = [texel, [0.5, 0.5, 0.9]].concat();
            turn_with::<3>(&still(UPRIGHT, [1.0; 2]), &mut texels);
            assert_eq!(texels, [flat, flat].concat(), "{texel:?}");
        }
        // So is everything where a frame is degenerate.
        let mut collapsed = UPRIGHT;
        collapsed[2] = [0.0; 3];
        for frames in [Frames::default(), collapsed, [[f32::NAN; 3]; 4]] {
            let mut texels = [0.6, 0.3, 0.8];
            turn_with::<3>(&still(frames, [1.0; 2]), &mut texels);
            assert_eq!(texels, flat);
        }
    }
}
