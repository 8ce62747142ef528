//! Repeatable noise: the same values on every machine and in every run.

use glam::{Vec3, vec3};

/// Odd multipliers that spread lattice coordinates over all bits.
const X: u32 = 0x8da6_b343;
const Y: u32 = 0xd816_3841;
const Z: u32 = 0xcb1a_b31f;
const SEED: u32 = 0x9e37_79b9;

/// A well-mixed hash of three lattice coordinates and a seed.
pub fn hash(x: i32, y: i32, z: i32, seed: u32) -> u32 {
    let spread = (x as u32).wrapping_mul(X) ^ (y as u32).wrapping_mul(Y);
    mixed(spread ^ (z as u32).wrapping_mul(Z) ^ seed.wrapping_mul(SEED))
}

fn mixed(mut bits: u32) -> u32 {
    bits ^= bits >> 15;
    bits = bits.wrapping_mul(0x2c1b_3c6d);
    bits ^ (bits >> 15)
}

/// The hash as a number in `0.0..1.0`.
pub fn random(x: i32, y: i32, z: i32, seed: u32) -> f32 {
    unit(hash(x, y, z, seed))
}

fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / 16_777_216.0
}

/// The hashed coordinates of the lattice cell around `x` and of the next one, and the fraction
/// between them, eased with smoothstep.
fn cell(x: f32, factor: u32) -> ([u32; 2], f32) {
    let whole = x.floor();
    let t = x - whole;
    let low = (whole as i32 as u32).wrapping_mul(factor);
    ([low, low.wrapping_add(factor)], t * t * (3.0 - 2.0 * t))
}

/// Value noise in `-1.0..1.0` with features about 1 apart: random values at the lattice points of a
/// cell, interpolated with smoothstep weights.
pub fn noise(p: Vec3, seed: u32) -> f32 {
    let ((x, fx), (y, fy), (z, fz)) = (cell(p.x, X), cell(p.y, Y), cell(p.z, Z));
    let seed = seed.wrapping_mul(SEED);
    let row = |rest: u32| {
        let (a, b) = (unit(mixed(x[0] ^ rest)), unit(mixed(x[1] ^ rest)));
        a + (b - a) * fx
    };
    let plane = |rest: u32| {
        let (a, b) = (row(y[0] ^ rest), row(y[1] ^ rest));
        a + (b - a) * fy
    };
    let (a, b) = (plane(z[0] ^ seed), plane(z[1] ^ seed));
    (a + (b - a) * fz) * 2.0 - 1.0
}

/// Two-dimensional value noise, cheaper than [`noise`].
pub fn noise2(x: f32, y: f32, seed: u32) -> f32 {
    let ((x, fx), (y, fy)) = (cell(x, X), cell(y, Y));
    let seed = seed.wrapping_mul(SEED);
    let row = |rest: u32| {
        let (a, b) = (unit(mixed(x[0] ^ rest)), unit(mixed(x[1] ^ rest)));
        a + (b - a) * fx
    };
    let (a, b) = (row(y[0] ^ seed), row(y[1] ^ seed));
    (a + (b - a) * fy) * 2.0 - 1.0
}

/// Fractal sum of a few octaves of [`noise`], about `-1.0..1.0`.
pub fn fractal(mut p: Vec3, octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut weight) = (0.0, 0.5);
    for octave in 0..octaves {
        sum += weight * noise(p, seed + octave);
        weight *= 0.5;
        p = p * 2.03 + vec3(7.1, 3.7, 1.9);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_smooth_and_equals_the_lattice_values() {
        let p = vec3(3.0, -2.0, 5.0);
        assert_eq!(noise(p, 7), random(3, -2, 5, 7) * 2.0 - 1.0);
        assert_eq!(noise2(3.0, -2.0, 7), random(3, -2, 0, 7) * 2.0 - 1.0);
        for k in 0..1000 {
            let q = p + vec3(0.013, 0.007, -0.011) * k as f32;
            let step = (noise(q + vec3(1e-3, 0.0, 0.0), 7) - noise(q, 7)).abs();
            assert!(step < 5e-3 && noise(q, 7).abs() <= 1.0);
        }
    }
}
