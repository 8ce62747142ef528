//! Scalar curves: linear interpolation, smooth steps and bells.

/// Linear interpolation: `a` at `t = 0`, `b` at 1, and beyond both.
pub fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// 0 up to `from`, 1 from `to` on, smooth between; `from > to` falls instead.
pub fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// As [`smoothstep`], in 64 bits.
pub fn smoothstep_f64(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A bell of height 1 and the given half-width at `exp(-1)`.
pub fn bell(x: f32, width: f32) -> f32 {
    let t = x / width;
    (-t * t).exp()
}
