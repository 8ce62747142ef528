//! The head as a smooth solid, and the curves of eyelids and lips that mesh and paint share.
//!
//! Head space: centimetres, with the origin between the ears at the height of the pupils, Y up, Z
//! out of the face, and `+x` the figure's own left.

use glam::{Vec3, vec3};
use uvgraft::easing::{bell, mix};

use super::sdf::{capsule, carve, ellipsoid, join, sphere};
use crate::symmetry::Symmetry as _;

/// Height of the origin of head space above the ground, in centimetres.
pub(crate) const EYE_LEVEL: f32 = 163.0;

pub(crate) const EYE: Vec3 = vec3(3.25, 0.0, 6.5);
pub(crate) const EYE_RADIUS: f32 = 1.7;
/// Radius of the lids' outer surface around the eye's centre.
pub(crate) const LID_RADIUS: f32 = 1.87;
pub(crate) const IRIS_RADIUS: f32 = 0.75;
/// Half the width of the lid opening.
pub(crate) const LID_WIDTH: f32 = 1.62;

pub(crate) const MOUTH_Y: f32 = -7.2;
pub(crate) const LIP_WIDTH: f32 = 2.45;

/// Height of the upper lid's edge above the eye's centre; `dx` grows outwards.
pub(crate) fn upper_lid(dx: f32) -> f32 {
    lid_tilt(dx) + 0.72 * arch(dx / LID_WIDTH).powf(0.62)
}

/// Height of the lower lid's edge.
pub(crate) fn lower_lid(dx: f32) -> f32 {
    lid_tilt(dx) - 0.58 * arch(dx / LID_WIDTH).powf(0.62)
}

fn lid_tilt(dx: f32) -> f32 {
    0.11 * dx / LID_WIDTH
}

/// Height at which the lips meet.
pub(crate) fn lip_line(x: f32) -> f32 {
    let t = x / LIP_WIDTH;
    MOUTH_Y + 0.32 * t * t - 0.05 * bell(x, 0.5)
}

/// Upper edge of the upper lip.
pub(crate) fn lip_top(x: f32) -> f32 {
    lip_line(x) + 0.68 * arch(x / LIP_WIDTH).powf(0.8) - 0.13 * bell(x, 0.38)
}

/// Lower edge of the lower lip.
pub(crate) fn lip_bottom(x: f32) -> f32 {
    lip_line(x) - 0.88 * arch(x / LIP_WIDTH).powf(0.75)
}

fn arch(t: f32) -> f32 {
    (1.0 - t * t).max(0.0)
}

/// Point of the neck's axis at a height.
pub(crate) fn neck_axis(y: f32) -> Vec3 {
    vec3(0.0, y, mix(-2.6, -3.4, (-6.0 - y) / 13.0))
}

/// The neck without its muscles, extending far into the trunk.
pub(crate) fn neck(p: Vec3) -> f32 {
    capsule(p, neck_axis(-6.0), neck_axis(-19.0), 4.55, 4.95)
}

/// The skull without hair and face.
pub(crate) fn cranium(p: Vec3) -> f32 {
    ellipsoid(p, vec3(0.0, 2.6, -1.0), vec3(7.3, 9.0, 9.4))
}

/// The skin of the head; the spheres of the closed lids cover the eyes.
pub(crate) fn skin(p: Vec3) -> f32 {
    let q = p.folded();
    let mut d = contour(p);
    d = carve(d, ellipsoid(q, vec3(3.3, -0.1, 9.15), vec3(2.1, 1.6, 1.5)), 1.2);
    d = join(d, sphere(q, EYE, LID_RADIUS), 0.4);
    lips(nose(d, p, q), p, q)
}

/// The head without eyes, nose and lips: the surface over which skin slides.
pub(crate) fn contour(p: Vec3) -> f32 {
    let q = p.folded();
    let mut d = cranium(p);
    d = join(d, ellipsoid(p, vec3(0.0, -2.9, 2.2), vec3(5.75, 7.8, 6.5)), 2.5);
    d = join(d, capsule(q, vec3(4.0, -6.2, 0.6), vec3(1.1, -9.7, 6.2), 1.35, 1.4), 2.4);
    d = join(d, ellipsoid(p, vec3(0.0, -9.7, 6.8), vec3(1.9, 1.6, 1.75)), 1.6);
    d = join(d, ellipsoid(q, vec3(4.3, -2.5, 4.9), vec3(1.9, 1.4, 2.1)), 2.0);
    d = join(d, ellipsoid(q, vec3(2.9, -4.9, 5.9), vec3(2.0, 2.0, 1.9)), 2.0);
    d = join(d, capsule(q, vec3(1.2, 2.0, 7.4), vec3(4.3, 2.1, 6.2), 0.85, 0.6), 1.4);
    d = join(d, ellipsoid(p, vec3(0.0, -7.0, 6.3), vec3(3.0, 2.5, 2.65)), 1.6);
    d = join(d, neck(p), 2.0);
    join(d, capsule(q, vec3(4.2, -6.0, -2.6), vec3(1.2, -19.0, 0.5), 0.8, 0.8), 1.4)
}

fn nose(skin: f32, p: Vec3, q: Vec3) -> f32 {
    let mut d = join(skin, capsule(p, vec3(0.0, 1.2, 7.9), vec3(0.0, -3.1, 9.5), 0.55, 0.8), 1.0);
    d = join(d, ellipsoid(p, vec3(0.0, -3.7, 9.75), vec3(1.0, 0.85, 0.95)), 0.9);
    d = join(d, ellipsoid(q, vec3(1.05, -4.1, 8.85), vec3(0.62, 0.6, 0.9)), 0.55);
    d = join(d, ellipsoid(p, vec3(0.0, -4.35, 9.1), vec3(0.85, 0.45, 1.1)), 0.5);
    d
}

fn lips(skin: f32, p: Vec3, q: Vec3) -> f32 {
    let mut d =
        carve(skin, capsule(p, vec3(0.0, -5.3, 9.55), vec3(0.0, -6.2, 9.4), 0.25, 0.3), 0.4);
    d = join(d, capsule(q, vec3(0.3, -6.88, 8.95), vec3(2.1, -7.0, 7.9), 0.4, 0.15), 0.35);
    d = join(d, capsule(q, vec3(0.0, -7.72, 8.75), vec3(1.6, -7.4, 8.05), 0.52, 0.2), 0.35);
    carve(d, ellipsoid(p, vec3(0.0, -8.75, 9.4), vec3(1.3, 0.4, 0.6)), 0.7)
}
