//! Scalar curves: linear interpolation, smoothstep and a Gaussian bell.

/// Linear interpolation: `a` at `t = 0`, `b` at `t = 1`, extrapolated beyond.
#[inline]
pub fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Hermite smoothstep: 0 up to `from`, 1 from `to` on. With `from > to` it falls from 1 to 0.
#[inline]
pub fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// As [`smoothstep`], in `f64`.
#[inline]
pub fn smoothstep_f64(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Gaussian bell `exp(−(x / width)²)`: height 1, half-width `width` at `exp(−1)`.
#[inline]
pub fn bell(x: f32, width: f32) -> f32 {
    let t = x / width;
    (-t * t).exp()
}
