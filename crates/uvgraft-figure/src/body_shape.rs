//! The trunk and its clothes as smooth solids, in world space: centimetres, the ground at 0.

use glam::{Vec3, vec3};
use uvgraft::easing::smoothstep;
use uvgraft_avatar::paint::noise::noise;

use super::head_shape::{EYE_LEVEL, neck};
use super::sdf::{capsule, carve, ellipsoid, join};
use crate::symmetry::Symmetry as _;

/// The left shoulder joint.
pub(crate) const SHOULDER: Vec3 = vec3(16.6, 141.0, -1.8);
/// Direction of the left arm in the rest pose: 40° down.
pub(crate) const ARM: Vec3 = vec3(0.766, -0.643, 0.0);
/// Direction of the back of the left arm and hand: up in the rest pose.
pub(crate) const ARM_BACK: Vec3 = vec3(0.643, 0.766, 0.0);
/// Direction of the thumb side of the left arm.
pub(crate) const ARM_FRONT: Vec3 = vec3(0.0, 0.0, 1.0);

/// Chest, shoulders, hips and neck, without arms and legs.
pub(crate) fn trunk(p: Vec3) -> f32 {
    let q = p.folded();
    let mut d = ellipsoid(p, vec3(0.0, 126.0, -1.4), vec3(14.6, 17.5, 10.2));
    d = join(d, ellipsoid(p, vec3(0.0, 106.0, -0.8), vec3(12.8, 15.0, 9.0)), 6.0);
    d = join(d, ellipsoid(p, vec3(0.0, 93.0, -1.2), vec3(15.6, 11.0, 10.2)), 5.0);
    d = join(d, capsule(q, vec3(5.0, 141.5, -2.4), vec3(15.4, 140.2, -1.9), 4.4, 4.6), 6.0);
    d = join(d, capsule(q, vec3(2.5, 149.5, -4.6), vec3(12.5, 143.0, -3.2), 2.4, 2.2), 4.0);
    d = join(d, ellipsoid(q, vec3(6.3, 129.5, 5.2), vec3(6.3, 5.4, 3.6)), 3.5);
    join(d, neck(p - vec3(0.0, EYE_LEVEL, 0.0)), 3.5)
}

/// The outer surface of the shirt, without sleeves.
pub(crate) fn shirt(p: Vec3) -> f32 {
    // Loose cloth hangs straight down from the chest, in shallow folds.
    let loose = ellipsoid(
        vec3(p.x, p.y.clamp(95.0, 122.0), p.z),
        vec3(0.0, 108.0, -0.9),
        vec3(15.3, 60.0, 10.5),
    );
    let loose = carve(loose, 130.0 - p.y, 8.0);
    let hips = ellipsoid(p, vec3(0.0, 92.0, -1.2), vec3(16.3, 14.0, 11.7));
    let folds = smoothstep(135.0, 100.0, p.y)
        * noise(vec3(p.x * 0.16, p.y * 0.07 + 0.03 * p.x, p.z * 0.16), 11);
    // The roots of the sleeves.
    let joint = capsule(p.folded(), SHOULDER - ARM * 5.0, SHOULDER - ARM * 0.5, 4.6, 4.2);
    let d = join(join(trunk(p) - 0.75, loose, 4.0), hips, 5.0);
    join(d, joint, 7.0) - 0.35 * folds
}

/// The outer surface of the shirt with its left sleeve.
pub(crate) fn sleeve(p: Vec3) -> f32 {
    let tube = capsule(p, SHOULDER, SHOULDER + ARM * 24.0, 5.7, 6.4);
    join(shirt(p), tube, 4.0) - 0.2 * noise(p * 0.3, 12)
}

/// Both trouser legs and the hips.
pub(crate) fn trousers(p: Vec3) -> f32 {
    let q = p.folded();
    let mut d = capsule(q, vec3(8.1, 89.0, -0.8), vec3(9.0, 50.0, 0.2), 7.9, 6.0);
    d = join(d, capsule(q, vec3(9.0, 50.0, 0.2), vec3(9.8, 5.0, -1.9), 5.9, 5.1), 2.0);
    d = join(d, ellipsoid(p, vec3(0.0, 95.0, -1.2), vec3(15.2, 12.0, 10.4)), 4.0);
    d = join(d, ellipsoid(q, vec3(6.8, 90.0, -5.2), vec3(7.0, 7.0, 6.0)), 3.0);
    let knee = smoothstep(30.0, 8.0, (p.y - 48.0).abs()) + 1.2 * smoothstep(25.0, 4.0, p.y);
    let hang = noise(vec3(p.x * 0.25, p.y * 0.16, p.z * 0.25), 13);
    d - 0.4 * hang * (0.35 + knee)
}

/// The left shoe, standing on the ground and pointing along +Z.
pub(crate) fn shoe(p: Vec3) -> f32 {
    let foot = p - vec3(10.2, 0.0, 0.0);
    let ball = vec3(foot.x - 0.25, foot.y, foot.z);
    let mut d = ellipsoid(ball, vec3(0.0, 2.4, 8.2), vec3(4.6, 4.4, 9.3));
    d = join(d, ellipsoid(foot, vec3(0.0, 3.6, -3.4), vec3(3.7, 6.2, 4.9)), 2.5);
    d = join(d, capsule(foot, vec3(0.0, 3.0, -3.0), vec3(0.2, 3.0, 9.0), 3.6, 3.6), 2.5);
    let sole = {
        let heel = capsule(flat(foot), vec3(0.0, 0.0, -3.6), vec3(0.1, 0.0, 2.0), 4.5, 4.2);
        let ball = capsule(flat(ball), vec3(-0.1, 0.0, 2.0), vec3(0.2, 0.0, 12.4), 4.2, 5.0);
        let slab = (p.y - 1.4).abs() - 1.3;
        -join(-join(heel, ball, 1.0), -slab, 1.2)
    };
    join(d, sole, 0.35).max(-p.y)
}

fn flat(p: Vec3) -> Vec3 {
    vec3(p.x, 0.0, p.z)
}
