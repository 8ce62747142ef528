//! Repeatable noise: the same on every machine and in every run.

use crate::vector::{Vec3, vec3};

/// Well-mixed bits from three lattice coordinates and a seed.
pub(crate) fn hash(x: i32, y: i32, z: i32, seed: u32) -> u32 {
    let mut h = (x as u32).wrapping_mul(0x8da6_b343)
        ^ (y as u32).wrapping_mul(0xd816_3841)
        ^ (z as u32).wrapping_mul(0xcb1a_b31f)
        ^ seed.wrapping_mul(0x9e37_79b9);
    h ^= h >> 15;
    h = h.wrapping_mul(0x2c1b_3c6d);
    h ^ (h >> 15)
}

/// The hash as a number in `0.0..1.0`.
pub(crate) fn random(x: i32, y: i32, z: i32, seed: u32) -> f32 {
    (hash(x, y, z, seed) >> 8) as f32 / 16_777_216.0
}

/// Splits into whole part and eased fraction.
fn cell(x: f32) -> (i32, f32) {
    let whole = x.floor();
    let t = x - whole;
    (whole as i32, t * t * (3.0 - 2.0 * t))
}

/// Smooth noise in `-1.0..1.0` with features about 1 apart.
pub(crate) fn noise(p: Vec3, seed: u32) -> f32 {
    let ((x, fx), (y, fy), (z, fz)) = (cell(p.x), cell(p.y), cell(p.z));
    let row = |dy, dz| {
        let (a, b) = (random(x, y + dy, z + dz, seed), random(x + 1, y + dy, z + dz, seed));
        a + (b - a) * fx
    };
    let plane = |dz| {
        let (a, b) = (row(0, dz), row(1, dz));
        a + (b - a) * fy
    };
    let (a, b) = (plane(0), plane(1));
    (a + (b - a) * fz) * 2.0 - 1.0
}

/// Smooth noise over a plane, cheaper than [`noise`].
pub(crate) fn noise2(x: f32, y: f32, seed: u32) -> f32 {
    let ((x, fx), (y, fy)) = (cell(x), cell(y));
    let row = |dy| {
        let (a, b) = (random(x, y + dy, 0, seed), random(x + 1, y + dy, 0, seed));
        a + (b - a) * fx
    };
    let (a, b) = (row(0), row(1));
    (a + (b - a) * fy) * 2.0 - 1.0
}

/// A few octaves of [`noise`], about `-1.0..1.0`.
pub(crate) fn fractal(mut p: Vec3, octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut weight) = (0.0, 0.5);
    for octave in 0..octaves {
        sum += weight * noise(p, seed + octave);
        weight *= 0.5;
        p = p * 2.03 + vec3(7.1, 3.7, 1.9);
    }
    sum
}
