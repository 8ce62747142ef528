//! Colours of skin, hair and eyes as functions of the point in space, shared by face and body.

use glam::{Vec3, vec3};
use uvgraft::easing::{bell, smoothstep};
use uvgraft_avatar::paint::noise::{fractal, noise, noise2, random};

use super::bake::{Color, blend, scaled};
use super::features::ear_depth;
use super::hair::{Bearing, lock_middle};
use super::head_shape::{EYE, IRIS_RADIUS};

/// The skin's mean colour.
const SKIN: Color = [0.875, 0.680, 0.575];
const FLUSH: Color = [0.86, 0.50, 0.43];
pub(crate) const HAIR: Color = [0.30, 0.185, 0.115];

/// Skin without features: tone that varies over centimetres, blotches, and pores of a few tenths of
/// a millimetre. `p` is in centimetres.
pub(crate) fn skin(p: Vec3) -> Color {
    let tone = fractal(p * 0.28, 2, 21);
    let blotches = fractal(p * 1.7, 2, 31);
    let pores = noise(p * 14.0, 41);
    let grain = noise(p * 37.0, 42);
    let color = blend(SKIN, FLUSH, (0.10 + 0.10 * tone + 0.10 * blotches).max(0.0));
    scaled(color, 1.0 + 0.02 * tone + 0.028 * pores.min(0.4) + 0.022 * grain)
}

/// Skin with more blood under it.
pub(crate) fn flushed(color: Color, amount: f32) -> Color {
    blend(color, FLUSH, amount)
}

/// Opacity of scattered freckles; `density` is the fraction of cells that have one.
pub(crate) fn freckles(p: Vec3, density: f32) -> f32 {
    const CELL: f32 = 0.26;
    if density < 0.03 {
        return 0.0;
    }
    let (x, y) = (p.x / CELL, p.y / CELL);
    let (column, row) = (x.floor() as i32, y.floor() as i32);
    let mut shade: f32 = 0.0;
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (-1, 0), (0, -1)] {
        let (i, j) = (column + dx, row + dy);
        if random(i, j, 0, 51) > density {
            continue;
        }
        let centre = [i as f32 + random(i, j, 1, 51), j as f32 + random(i, j, 2, 51)];
        let size = 0.12 + 0.17 * random(i, j, 3, 51);
        let distance = ((x - centre[0]).powi(2) + (y - centre[1]).powi(2)).sqrt();
        let strength = 0.25 + 0.75 * random(i, j, 4, 51);
        shade = shade.max(strength * smoothstep(size, size * 0.45, distance));
    }
    shade
}

/// The ear: redder than the face and darker in its folds.
pub(crate) fn ear(p: Vec3) -> Color {
    let depth = ear_depth(p);
    let shade = smoothstep(0.35, -0.6, depth);
    let color = flushed(skin(p), 0.16 + 0.25 * shade);
    scaled(color, 1.0 - 0.42 * shade)
}

/// Locks and strands at a point of the hair, in head space.
pub(crate) fn hair(p: Vec3) -> Color {
    let bearing = Bearing::of(p);
    let lock = bearing.lock();
    let along = bearing.polar * 7.0;
    let strands =
        noise2(lock * 26.0, along * 0.5, 61) * 0.55 + noise2(lock * 61.0, along, 62) * 0.45;
    let tuft = noise2(lock * 5.0, along * 0.35, 63);
    let gloss = bell(bearing.polar - 0.55 - 0.06 * tuft, 0.2)
        + 0.5 * bell(bearing.polar - 1.35 - 0.05 * tuft, 0.22);
    let middle = lock_middle(lock).sqrt();
    let light = 0.62 + 0.34 * middle + 0.30 * strands + 0.14 * tuft + 0.28 * gloss * middle;
    let warm = blend(HAIR, [0.47, 0.29, 0.16], (0.35 * gloss + 0.25 * strands + 0.1).max(0.0));
    scaled(warm, light.max(0.18))
}

/// Coverage of the scalp by hair at a point in head space, 0 to 1; beyond the hairline only
/// single strands.
pub(crate) fn hair_cover(p: Vec3) -> f32 {
    // No hair grows on the face and the front of the neck.
    if (p.z > 2.5 && p.y < 1.0) || p.y < -12.0 {
        return 0.0;
    }
    let bearing = Bearing::of(p);
    let reach = bearing.reach();
    if !(0.8..1.12).contains(&reach) {
        return if reach < 1.0 { 1.0 } else { 0.0 };
    }
    let lock = bearing.lock();
    let strands = noise2(lock * 30.0, bearing.polar * 4.0, 65);
    let tuft = noise2(lock * 6.0, 0.0, 66);
    smoothstep(1.025, 0.985, reach - 0.045 * strands - 0.02 * tuft)
}

/// An eyeball with its iris and highlights; `side` is the sign of its `x`.
pub(crate) fn eye(p: Vec3, side: f32) -> Color {
    let q = p - vec3(side * EYE.x, EYE.y + 0.05, EYE.z);
    let across = (q.x * q.x + q.y * q.y).sqrt();
    let veins = smoothstep(0.78, 0.98, 1.0 - noise2(q.x * 6.0 + q.y, q.y * 9.0, 71).abs());
    let corners = smoothstep(0.75, 1.5, q.x.abs());
    let mut color = blend([0.95, 0.935, 0.915], [0.86, 0.66, 0.60], 0.55 * corners);
    color = blend(color, [0.80, 0.42, 0.38], 0.22 * veins * corners);
    // Shadow of the upper lid.
    color = scaled(color, 1.0 - 0.34 * smoothstep(0.15, 0.72, q.y) - 0.1 * corners);
    if q.z <= 0.0 || across > IRIS_RADIUS * 1.1 {
        return color;
    }
    let r = across / IRIS_RADIUS;
    let angle = q.y.atan2(q.x);
    let fibres = noise2(angle * 16.0, r * 2.2, 72) * 0.6 + noise2(angle * 37.0, r * 4.0, 73) * 0.4;
    let mut iris = blend([0.20, 0.42, 0.44], [0.36, 0.60, 0.56], smoothstep(0.9, 0.55, r));
    iris = blend(iris, [0.66, 0.50, 0.24], 0.85 * bell(r - 0.42 - 0.06 * fibres, 0.15));
    iris = scaled(iris, 0.95 + 0.42 * fibres);
    // Light that enters from above gathers at the bottom of the iris.
    iris =
        scaled(iris, 1.0 - 0.35 * smoothstep(-0.25, 0.6, q.y) + 0.25 * smoothstep(0.0, -0.5, q.y));
    iris = scaled(iris, 1.0 - 0.72 * smoothstep(0.80, 0.98, r));
    iris = blend(iris, [0.02, 0.018, 0.02], smoothstep(0.425, 0.385, r));
    color = blend(color, iris, smoothstep(1.04, 0.96, r));
    let glint = |x: f32, y: f32, radius: f32| {
        let distance = ((q.x - x).powi(2) + (q.y - y).powi(2)).sqrt();
        smoothstep(radius, radius * 0.8, distance)
    };
    color = blend(color, [1.0, 1.0, 1.0], glint(-0.24, 0.24, 0.135));
    blend(color, [0.93, 0.97, 1.0], 0.65 * glint(0.22, -0.28, 0.07))
}
