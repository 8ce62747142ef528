//! Eyeballs and ears: separate components, set into the head's skin.
//!
//! Both are discs on their charts, with parameters `0.5 + r / 2 · (cos, sin)`.

use std::f32::consts::TAU;

use glam::{Vec3, vec3};
use uvgraft::easing::{bell, mix, smoothstep};

use super::head_shape::{EYE, EYE_RADIUS, IRIS_RADIUS};
use super::surface::{BodyPart, Knot, PartKind, Side, Surface};
use crate::curve::curve;
use crate::symmetry::Symmetry as _;

/// Chart parameters of a point of the unit disc; `radius` is at most 1, the angle runs from +x to
/// up.
fn on_disc(radius: f32, angle: f32) -> [f32; 2] {
    [0.5 + 0.5 * radius * angle.cos(), 0.5 - 0.5 * radius * angle.sin()]
}

/// A disc of rings with `around` knots each, around a central knot; the outermost ring is last.
pub(crate) fn disc(
    surface: &mut Surface,
    part: BodyPart,
    around: usize,
    radii: &[f32],
    position: impl Fn(f32, f32) -> Vec3,
) {
    let middle = surface.knot(position(0.0, 0.0), [0.5, 0.5]);
    let mut inner = vec![middle; around];
    for &radius in radii {
        let outer: Vec<Knot> = (0..around)
            .map(|k| {
                let angle = TAU * k as f32 / around as f32;
                surface.knot(position(radius, angle), on_disc(radius, angle))
            })
            .collect();
        for k in 0..around {
            let next = (k + 1) % around;
            if inner[0] == middle {
                surface.polygon(part, &[middle, outer[k], outer[next]]);
            } else {
                surface.polygon(part, &[inner[k], outer[k], outer[next], inner[next]]);
            }
        }
        inner = outer;
    }
}

/// Polar angle from the eye's axis at which its disc ends.
pub(crate) const EYE_OPENING: f32 = 1.9;

/// The left eyeball, looking along +Z; open at the back.
pub(crate) fn eye() -> Surface {
    let mut surface = Surface::default();
    let part = BodyPart { kind: PartKind::Eye, side: Side::Left };
    let radii: Vec<f32> = (1..=9).map(|k| k as f32 / 9.0).collect();
    disc(&mut surface, part, 20, &radii, |radius, angle| {
        let polar = radius * EYE_OPENING;
        let across = EYE_RADIUS * polar.sin();
        let cornea = 0.05 * (1.0 - smoothstep(0.3 * IRIS_RADIUS, 1.25 * IRIS_RADIUS, across));
        let cornea = if polar < 1.0 { cornea } else { 0.0 };
        let towards = vec3(polar.sin() * angle.cos(), polar.sin() * angle.sin(), polar.cos());
        EYE + towards * (EYE_RADIUS + cornea)
    });
    surface
}

/// Attachment point of the ear; the two directions span its plane, forward and up.
pub(crate) const EAR: Vec3 = vec3(6.85, -1.3, -1.0);
const EAR_FORWARD: Vec3 = vec3(-0.27, 0.05, 0.96);
const EAR_UP: Vec3 = vec3(0.13, 0.98, -0.14);

/// Distance of the ear's plane from its attachment point.
const EAR_STAND: f32 = 0.8;

/// The fraction of an ear's disc radius that is its front; the rest is its back.
pub(crate) const EAR_FRONT: f32 = 0.72;

/// Relief of the ear's front: height above its plane in centimetres, at a radius up to 1 and an
/// angle (0 forward, a quarter turn up).
pub(crate) fn ear_relief(radius: f32, angle: f32) -> f32 {
    // The helix runs from the front over the top and down the back to the lobe.
    let turn = angle.rem_euclid(TAU) / TAU;
    let helix = smoothstep(0.0, 0.12, turn) * smoothstep(0.78, 0.6, turn);
    let (x, y) = (radius * angle.cos(), radius * angle.sin());
    let bowl = {
        let (dx, dy) = ((x - 0.08) / 0.42, (y + 0.1) / 0.36);
        (-(dx * dx + dy * dy).powi(2)).exp()
    };
    let antihelix =
        bell(radius - 0.58, 0.13) * smoothstep(0.1, 0.25, turn) * smoothstep(0.72, 0.6, turn);
    let tragus = bell(x - 0.52, 0.2) * bell(y + 0.1, 0.22);
    let lobe = smoothstep(-0.45, -0.75, y);
    0.42 * helix * bell(radius - 0.9, 0.12) + 0.3 * antihelix - 0.75 * bowl
        + 0.35 * tragus
        + 0.12 * lobe
        - 0.12 * helix * bell(radius - 0.75, 0.08)
}

/// The left ear.
pub(crate) fn ear() -> Surface {
    let mut surface = Surface::default();
    let part = BodyPart { kind: PartKind::Ear, side: Side::Left };
    let out = EAR_UP.cross(EAR_FORWARD).normalize_or_zero();
    let outline = |angle: f32| {
        let turn = angle.rem_euclid(TAU) / TAU;
        curve(
            &[
                (0.0, 1.2),
                (0.1, 1.6),
                (0.2, 2.35),
                (0.27, 2.65),
                (0.36, 2.45),
                (0.48, 1.95),
                (0.6, 1.75),
                (0.68, 2.05),
                (0.75, 2.3),
                (0.81, 2.1),
                (0.88, 1.55),
                (1.0, 1.2),
            ],
            turn,
        )
    };
    let fronts = 9;
    let radii: Vec<f32> = (1..=fronts)
        .map(|k| EAR_FRONT * k as f32 / fronts as f32)
        .chain([0.79, 0.9, 1.0])
        .collect();
    disc(&mut surface, part, 24, &radii, |radius, angle| {
        let front = (radius / EAR_FRONT).min(1.0);
        let back = ((radius - EAR_FRONT) / (1.0 - EAR_FRONT)).max(0.0);
        let reach = outline(angle) * mix(front, 0.5, smoothstep(0.2, 1.0, back));
        let reach = reach * (1.0 + 0.06 * bell(back - 0.2, 0.15));
        let relief = ear_relief(front, angle)
            - 0.45 * smoothstep(0.0, 0.3, back)
            - 1.6 * smoothstep(0.25, 1.0, back);
        EAR + EAR_FORWARD * (reach * angle.cos())
            + EAR_UP * (reach * angle.sin())
            + out * (EAR_STAND + relief)
    });
    // Seen from outside on the left, forward is to the left, so the disc's winding is reversed.
    for polygon in &mut surface.polygons {
        polygon.knots.reverse();
    }
    surface
}

/// Height of a point above the plane of the left or right ear, in head space.
pub(crate) fn ear_depth(p: Vec3) -> f32 {
    let out = EAR_UP.cross(EAR_FORWARD).normalize_or_zero();
    (p.folded() - EAR).dot(out) - EAR_STAND
}
