//! The left arm with its hand and fingers; the right one is its mirror image.

use std::f32::consts::TAU;

use glam::{Vec3, vec3};
use uvgraft::easing::mix;

use super::body_shape::{ARM, ARM_BACK, ARM_FRONT, SHOULDER};
use super::clothes::tube;
use super::surface::{BodyPart, PartKind, Side, Surface};
use crate::curve::curve;

/// Distance of the wrist from the shoulder.
pub(crate) const WRIST: f32 = 52.0;

/// A point from arm coordinates: distance along the arm, towards the thumb and towards the back of
/// the hand.
pub(crate) fn on_arm(along: f32, front: f32, back: f32) -> Vec3 {
    SHOULDER + ARM * along + ARM_FRONT * front + ARM_BACK * back
}

/// Arm coordinates of a point: distance along the left arm, towards the thumb and towards the back
/// of the hand.
pub(crate) fn in_arm(p: Vec3) -> Vec3 {
    let q = p - SHOULDER;
    vec3(q.dot(ARM), q.dot(ARM_FRONT), q.dot(ARM_BACK))
}

/// `(distance from the shoulder, half-width, half-thickness)`.
const SECTIONS: [(f32, f32, f32); 14] = [
    (8.0, 4.9, 5.2),
    (14.0, 4.6, 4.9),
    (21.0, 4.2, 4.3),
    (27.5, 3.85, 3.8),
    (33.0, 4.15, 3.75),
    (40.0, 3.65, 3.2),
    (47.0, 2.95, 2.45),
    (WRIST, 2.7, 1.95),
    (55.0, 3.2, 1.85),
    (58.5, 3.85, 1.75),
    (61.5, 4.1, 1.55),
    (63.5, 4.05, 1.3),
    (64.8, 3.8, 1.0),
    (65.6, 3.2, 0.55),
];

fn left_arm(surface: &mut Surface) {
    const RINGS: usize = 30;
    let part = BodyPart { kind: PartKind::Arm, side: Side::Left };
    let widths: Vec<(f32, f32)> = SECTIONS.iter().map(|section| (section.0, section.1)).collect();
    let heights: Vec<(f32, f32)> = SECTIONS.iter().map(|section| (section.0, section.2)).collect();
    let (from, to) = (SECTIONS[0].0, SECTIONS[SECTIONS.len() - 1].0);
    let [_, knuckles] = tube(surface, part, 24, RINGS, |turn, ring| {
        let t = ring as f32 / (RINGS - 1) as f32;
        // Rings are denser on the hand.
        let along = mix(from, to, t * (1.25 - 0.25 * t));
        let (sin, cos) = (TAU * (turn - 0.25)).sin_cos();
        let palm = curve(&[(WRIST - 2.0, 1.0), (58.0, 0.72), (64.0, 0.7)], along);
        let squared = |value: f32| value.signum() * value.abs().powf(palm);
        // The palm is hollow and the back of the hand arched.
        let hollow = curve(&[(WRIST, 0.0), (59.0, 0.35), (64.0, 0.15)], along) * (1.0 - cos * cos);
        on_arm(
            along,
            curve(&widths, along) * squared(cos),
            curve(&heights, along) * squared(sin) + hollow,
        )
    });
    let tip = surface.knot(on_arm(to + 0.2, 0.0, 0.0), [0.5, 1.0]);
    surface.cap_below(part, &knuckles, tip);
}

struct Finger {
    /// In arm coordinates.
    base: Vec3,
    /// In arm coordinates.
    direction: Vec3,
    length: f32,
    radius: f32,
    curl: f32,
}

/// From the thumb to the little finger. The first centimetres are hidden inside the hand.
const FINGERS: [Finger; 5] = [
    finger(vec3(55.5, 2.1, -0.5), vec3(0.80, 0.56, -0.18), 9.0, 1.22, 0.3),
    finger(vec3(62.0, 2.95, 0.15), vec3(0.99, 0.10, -0.04), 10.2, 1.0, 0.42),
    finger(vec3(62.4, 1.0, 0.25), vec3(1.0, 0.02, -0.04), 11.0, 1.03, 0.45),
    finger(vec3(62.2, -0.95, 0.2), vec3(1.0, -0.05, -0.05), 10.3, 0.98, 0.50),
    finger(vec3(61.6, -2.75, 0.05), vec3(0.99, -0.13, -0.06), 8.5, 0.87, 0.52),
];

const fn finger(base: Vec3, direction: Vec3, length: f32, radius: f32, curl: f32) -> Finger {
    Finger { base, direction, length, radius, curl }
}

impl Finger {
    /// Unit vectors along the finger, towards the thumb and towards the back: a right-handed
    /// frame in arm coordinates, in which x runs along the arm, y towards the thumb and z
    /// towards the back.
    fn frame(&self) -> [Vec3; 3] {
        let along = self.direction.normalize_or_zero();
        let side = vec3(0.0, 0.0, 1.0).cross(along).normalize_or_zero();
        [along, side, along.cross(side)]
    }

    /// The centre line of the finger relative to its base, curling towards the palm; `t` runs from
    /// 0 to 1.
    fn spine(&self, t: f32) -> Vec3 {
        let [along, _, back] = self.frame();
        let bend = self.curl * t * t;
        (along * (t - 0.16 * bend) - back * (0.55 * bend)) * self.length
    }
}

/// Finger coordinates of a point of the left hand: position along the finger from 0 to 1, then the
/// offset towards the thumb and towards the back in finger radii.
pub(crate) fn on_finger(number: u8, p: Vec3) -> (f32, f32, f32) {
    let finger = &FINGERS[usize::from(number)];
    let local = in_arm(p) - finger.base;
    let [along, side, _] = finger.frame();
    let mut t = (local.dot(along) / finger.length).clamp(0.0, 1.0);
    // Fixed-point iteration to the nearest point of the curved centre line.
    for _ in 0..3 {
        let forward = (finger.spine(t + 0.01) - finger.spine(t - 0.01)).normalize_or_zero();
        t += (local - finger.spine(t)).dot(forward) / finger.length;
    }
    let forward = (finger.spine(t + 0.01) - finger.spine(t - 0.01)).normalize_or_zero();
    let off = (local - finger.spine(t)) * (1.0 / finger.radius);
    (t, off.dot(side), off.dot(forward.cross(side)))
}

/// The positions of a finger's three joints along it, from 0 at its base inside the hand to 1 at
/// its tip.
pub(crate) const fn finger_bends(number: usize) -> [f32; 3] {
    [if number == 0 { 0.04 } else { 0.16 }, 0.435, 0.70]
}

/// The positions of a finger's joints and tip.
pub(crate) fn finger_joints(number: usize) -> [Vec3; 4] {
    let [first, second, third] = finger_bends(number);
    let finger = &FINGERS[number];
    [first, second, third, 1.0].map(|t| {
        let p = finger.base + finger.spine(t);
        on_arm(p.x, p.y, p.z)
    })
}

/// Distance of a point of the left hand from the straight line between two positions along a
/// finger, and the nearest point on that line, from 0 to 1.
pub(crate) fn axis_distance(number: usize, from: f32, to: f32, p: Vec3) -> (f32, f32) {
    let finger = &FINGERS[number];
    let (a, b) = (finger.base + finger.spine(from), finger.base + finger.spine(to));
    let (line, off) = (b - a, in_arm(p) - a);
    let t = (off.dot(line) / line.dot(line)).clamp(0.0, 1.0);
    ((off - line * t).length(), t)
}

fn left_finger(surface: &mut Surface, number: u8, finger: &Finger) {
    const RINGS: usize = 11;
    let part = BodyPart { kind: PartKind::Finger(number), side: Side::Left };
    let [_, side, _] = finger.frame();
    let spine = |t: f32| finger.spine(t);
    let [_, end] = tube(surface, part, 10, RINGS, |turn, ring| {
        let t = ring as f32 / (RINGS - 1) as f32;
        let t = 0.985 * t * (1.35 - 0.35 * t);
        let middle = spine(t);
        let forward = (spine(t + 0.01) - spine(t - 0.01)).normalize_or_zero();
        let up = forward.cross(side);
        let knuckles = 0.05 * (TAU * (t * 2.1 + 0.1)).cos();
        let taper = mix(1.0, 0.74, t) * (1.0 + knuckles);
        let rounded = (1.0 - ((t - 0.88).max(0.0) / 0.12).powi(2)).max(0.0).sqrt();
        let radius = finger.radius * taper * rounded.max(0.16);
        let (sin, cos) = (TAU * (turn - 0.25)).sin_cos();
        let p = finger.base + middle + side * (cos * radius) + up * (sin * radius * 0.92);
        on_arm(p.x, p.y, p.z)
    });
    let tip = finger.base + spine(1.0);
    let tip = surface.knot(on_arm(tip.x, tip.y, tip.z), [0.5, 1.0]);
    surface.cap_below(part, &end, tip);
}

/// The figure's left arm, hand and fingers.
pub(crate) fn left(surface: &mut Surface) {
    left_arm(surface);
    for (number, finger) in FINGERS.iter().enumerate() {
        left_finger(surface, number as u8, finger);
    }
}
