//! Repeatable noise, and the curves that define the painters' shapes.

use uvgraft::easing::{mix, smoothstep};

/// A point, in centimetres.
pub(super) type Point = [f32; 3];

/// Piecewise linear between knots, constant beyond.
pub(super) fn curve(knots: &[(f32, f32)], x: f32) -> f32 {
    let after = knots.partition_point(|knot| knot.0 <= x);
    match (after.checked_sub(1).map(|k| knots[k]), knots.get(after)) {
        (Some((x0, y0)), Some(&(x1, y1))) => mix(y0, y1, (x - x0) / (x1 - x0)),
        (Some((_, y)), None) | (None, Some(&(_, y))) => y,
        (None, None) => 0.0,
    }
}

fn lattice(x: i32, y: i32, z: i32, seed: u32) -> f32 {
    let mut bits = (x as u32).wrapping_mul(0x8da6_b343)
        ^ (y as u32).wrapping_mul(0xd816_3841)
        ^ (z as u32).wrapping_mul(0xcb1a_b31f)
        ^ seed.wrapping_mul(0x9e37_79b9);
    for _ in 0..2 {
        bits ^= bits >> 15;
        bits = bits.wrapping_mul(0x2c1b_3c6d);
    }
    ((bits ^ bits >> 13) >> 8) as f32 / 8_388_608.0 - 1.0
}

/// Smooth value noise in `-1.0..1.0`, on a lattice of spacing 1.
pub(super) fn noise(p: Point, seed: u32) -> f32 {
    let whole = p.map(f32::floor);
    let t = [0, 1, 2].map(|k| smoothstep(0.0, 1.0, p[k] - whole[k]));
    let [x, y, z] = whole.map(|value| value as i32);
    let row = |y, z| mix(lattice(x, y, z, seed), lattice(x + 1, y, z, seed), t[0]);
    let plane = |z| mix(row(y, z), row(y + 1, z), t[1]);
    mix(plane(z), plane(z + 1), t[2])
}

/// Three octaves of [`noise`], the coarsest with spacing `scale`; roughly in `-1.0..1.0`.
pub(super) fn fractal(p: Point, scale: f32, seed: u32) -> f32 {
    let mut q = p.map(|value| value / scale);
    let (mut sum, mut weight) = (0.0, 0.57);
    for octave in 0..3 {
        sum += weight * noise(q, seed + 7 * octave);
        weight *= 0.5;
        q = [q[0] * 2.03 + 7.1, q[1] * 2.03 + 3.7, q[2] * 2.03 + 1.9];
    }
    sum
}
