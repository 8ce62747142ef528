//! The body's texture: clothes, skin, and a head without a face.

use std::f32::consts::TAU;

use glam::{Vec3, vec3};
use uvgraft::easing::{bell, smoothstep};
use uvgraft::{Size, Texture};
use uvgraft_avatar::paint::noise::{noise, noise2};

use super::Figure;
use super::arms::on_finger;
use super::bake::{Color, Spot, bake, blend, scaled};
use super::body_shape::{ARM, ARM_BACK, ARM_FRONT, SHOULDER};
use super::clothes::{HEM, SHIRT_CENTRE, collar};
use super::complexion::{flushed, skin};
use super::head_shape::EYE_LEVEL;
use super::surface::PartKind;
use crate::symmetry::Symmetry as _;

const BACKGROUND: Color = [0.36, 0.37, 0.40];
const CREAM: Color = [0.93, 0.905, 0.85];
const NAVY: Color = [0.115, 0.165, 0.29];
const DENIM: Color = [0.20, 0.245, 0.335];
const CANVAS: Color = [0.70, 0.20, 0.16];
const RUBBER: Color = [0.92, 0.91, 0.88];

/// Paints the figure's clothes and skin in the body's UV layout, as 8-bit sRGB. Its head is a
/// mannequin's, to be replaced by a face; the neck has the face's skin tone.
///
/// # Panics
/// If `size` has no texels or a side longer than [`Texture::MAX_SIDE`].
pub fn paint_body(figure: &Figure, size: Size) -> Texture {
    bake(&figure.body, &figure.body_parts, size, BACKGROUND, color)
}

/// Paints the body like [`paint_body`], with another skin tone.
///
/// - `gain`: factors for the skin's red, green and blue.
///
/// # Panics
/// As [`paint_body`].
pub fn paint_body_in_tone(figure: &Figure, size: Size, gain: [f32; 3]) -> Texture {
    bake(&figure.body, &figure.body_parts, size, BACKGROUND, |spot| {
        let color = color(spot);
        if !matches!(
            spot.part.kind,
            PartKind::Face | PartKind::Chest | PartKind::Arm | PartKind::Finger(_)
        ) {
            return color;
        }
        // Sleeves, nails and the mannequin's head are excluded by their colour distance from skin.
        let plain = skin(spot.position);
        let far = (0..3).map(|k| (color[k] - plain[k]).abs()).fold(0.0, f32::max);
        let share = smoothstep(0.16, 0.06, far);
        [0, 1, 2].map(|k| color[k] * (1.0 + (gain[k] - 1.0) * share))
    })
}

fn color(spot: &Spot) -> Color {
    let p = spot.position;
    match spot.part.kind {
        PartKind::Face => mannequin(p),
        PartKind::Eye | PartKind::Ear | PartKind::Hair => MANNEQUIN,
        PartKind::Chest => skin(p),
        PartKind::Shirt => shirt(p),
        PartKind::Sleeve => jersey(p),
        PartKind::Arm => arm(p, spot.normal),
        PartKind::Finger(number) => finger(p, number),
        PartKind::Leg => trousers(p, spot.normal),
        PartKind::Shoe => shoe(p.folded(), spot.normal),
    }
}

const MANNEQUIN: Color = [0.80, 0.755, 0.72];

fn mannequin(p: Vec3) -> Color {
    // The head is cut off along a plane that rises towards the nape.
    let neck = smoothstep(-11.8, -14.8, p.y + 0.26 * p.z - EYE_LEVEL);
    if neck > 0.0 { blend(MANNEQUIN, skin(p), neck) } else { MANNEQUIN }
}

/// Brightness of knitted threads, about 1 ± 0.05.
fn knit(p: Vec3) -> f32 {
    let around = p.x.atan2(p.z + 1.0) * 14.0;
    let wale = (around * TAU * 2.2).sin() * (p.y * TAU * 3.0).sin();
    1.0 + 0.02 * wale + 0.03 * noise(p * 9.0, 91)
}

fn striped(height: f32, threads: f32) -> Color {
    const PERIOD: f32 = 4.4;
    const EDGE: f32 = 0.03;
    let t = height.rem_euclid(PERIOD);
    let stripe = smoothstep(0.0, EDGE, t) * smoothstep(1.75 + EDGE, 1.75, t);
    scaled(blend(CREAM, NAVY, stripe), threads)
}

/// The cloth of shirt and sleeves. Whether a point belongs to one or the other is decided in space,
/// so both agree where their surfaces intersect.
fn jersey(p: Vec3) -> Color {
    let q = p.folded() - SHOULDER;
    let threads = knit(p);
    let along = q.dot(ARM);
    // Positive on the sleeve: beyond the shoulder and above the level of the armpit.
    let armhole = (q.x + 1.5).min(q.dot(ARM_BACK) + 8.6);
    let color = if armhole > 0.0 {
        let plain = scaled(CREAM, threads);
        let color = blend(plain, striped(along - 2.0, threads), smoothstep(6.2, 6.24, along));
        let color = blend(color, scaled(NAVY, threads), smoothstep(18.5, 18.55, along));
        scaled(color, 1.0 - 0.25 * bell(along - 18.4, 0.06))
    } else {
        // Plain over the shoulders, striped below.
        let yoke = smoothstep(137.6, 137.65, p.y);
        blend(striped(p.y, threads), scaled(CREAM, threads), yoke)
    };
    scaled(color, 1.0 - 0.24 * bell(armhole, 0.11))
}

/// Coverage by the heart stitched on the left of the chest.
fn heart(p: Vec3) -> f32 {
    if p.z < 0.0 {
        return 0.0;
    }
    let (x, y) = ((p.x - 8.0) / 1.35, (p.y - 140.0) / 1.25);
    let bend = y - 0.62 * x.abs().sqrt();
    smoothstep(1.02, 0.98, (x * x + bend * bend).sqrt())
}

fn shirt(p: Vec3) -> Color {
    let q = p - SHIRT_CENTRE;
    let degrees = q.y.atan2((q.x * q.x + q.z * q.z).sqrt()).to_degrees();
    let rib = 1.0 + 0.08 * (q.x.atan2(q.z) * 150.0).sin();
    let below = degrees - collar(q.x.atan2(q.z));
    let color = blend(jersey(p), scaled(NAVY, rib), smoothstep(-4.75, -4.65, below));
    let color = blend(color, scaled(CANVAS, 1.0 + 0.16 * noise(p * 11.0, 95)), heart(p));
    let hem = bell(p.y - HEM - 2.0, 0.05);
    scaled(color, 1.0 - 0.25 * hem)
}

fn arm(p: Vec3, normal: Vec3) -> Color {
    let q = p.folded() - SHOULDER;
    let (along, front) = (q.dot(ARM), q.dot(ARM_FRONT));
    let back = vec3(normal.x.abs(), normal.y, normal.z).dot(ARM_BACK);
    let elbow = bell(along - 27.0, 2.5) * smoothstep(0.2, 0.9, -normal.z);
    let knuckles = bell(along - 63.6, 0.8)
        * smoothstep(0.3, 0.8, back)
        * (0.5 + 0.5 * (front * TAU / 1.95).cos());
    let palm = smoothstep(54.0, 57.0, along) * smoothstep(0.0, -0.7, back);
    flushed(skin(p), 0.3 * elbow + 0.35 * knuckles + 0.3 * palm)
}

fn finger(p: Vec3, number: u8) -> Color {
    let (along, front, back) = on_finger(number, p.folded());
    let color = flushed(skin(p), 0.16 + 0.3 * smoothstep(0.7, 1.0, along));
    // Creases over the joints, and the nail.
    let joint = bell(along - 0.42, 0.012) + bell(along - 0.45, 0.01) + bell(along - 0.70, 0.012);
    let color = blend(color, [0.66, 0.42, 0.35], 0.35 * joint * smoothstep(-0.2, 0.4, back));
    let (x, y) = (front / 0.66, (along - 0.895) / 0.085);
    let nail = (x.powi(4) + y.powi(4)).sqrt().sqrt();
    let inside = smoothstep(1.0, 0.93, nail) * smoothstep(0.2, 0.3, back);
    let rim = bell(nail - 1.02, 0.08) * smoothstep(0.2, 0.3, back);
    let white = smoothstep(0.62, 0.72, y);
    let plate = blend([0.90, 0.66, 0.60], [0.95, 0.88, 0.82], white);
    blend(blend(color, [0.62, 0.38, 0.32], 0.4 * rim), plate, 0.85 * inside)
}

fn trousers(p: Vec3, normal: Vec3) -> Color {
    let around = (p.x.abs() - 9.3).atan2(p.z) * 6.0;
    let twill = ((around + p.y * 0.9) * TAU * 3.4).sin();
    let slub = noise2(around * 2.0, p.y * 14.0, 92);
    let worn = bell(p.y - 50.0, 9.0) + bell(p.y - 72.0, 12.0);
    let worn = worn * smoothstep(0.3, 0.95, normal.z);
    let mut color = blend(DENIM, [0.40, 0.46, 0.56], 0.32 * worn + 0.06 * noise(p * 0.5, 93));
    color = scaled(color, 1.0 + 0.07 * twill + 0.07 * slub);
    // The outer seam with its stitches.
    let outer = p.z + 0.6;
    if p.x.abs() > 11.0 {
        let stitch = smoothstep(0.05, 0.025, (outer.abs() - 0.32).abs())
            * smoothstep(-0.2, 0.1, (p.y * TAU * 2.6).sin());
        color = scaled(color, 1.0 - 0.3 * bell(outer, 0.08));
        color = blend(color, [0.78, 0.52, 0.25], 0.85 * stitch);
    }
    let dash = smoothstep(-0.2, 0.1, (around * TAU * 1.3).sin());
    let stitch = smoothstep(0.06, 0.035, (p.y - 6.3).abs()) * dash;
    color = blend(color, [0.78, 0.52, 0.25], 0.85 * stitch);
    scaled(color, 1.0 - 0.25 * bell(p.y - 6.0, 0.07))
}

fn shoe(p: Vec3, normal: Vec3) -> Color {
    let weave = 1.0 + 0.05 * noise(p * 9.0, 94);
    let mut color = scaled(CANVAS, weave);
    let toe_cap = smoothstep(11.6, 11.65, p.z);
    color = blend(color, RUBBER, toe_cap);
    let tongue =
        smoothstep(1.75, 1.7, (p.x - 10.4 - 0.1 * p.z).abs()) * smoothstep(0.2, 0.4, normal.y);
    if (1.0..9.8).contains(&p.z) {
        let lace = smoothstep(0.30, 0.26, ((p.z - 1.0).rem_euclid(1.7) - 0.85).abs());
        color = blend(color, scaled(CREAM, weave), tongue * lace);
    }
    let sole = smoothstep(3.0, 2.95, p.y);
    color = blend(color, RUBBER, sole);
    let stripe = smoothstep(0.16, 0.12, (p.y - 2.1).abs());
    color = blend(color, CANVAS, 0.9 * stripe * sole);
    let bottom = smoothstep(0.35, 0.3, p.y);
    blend(color, [0.55, 0.42, 0.30], bottom)
}
