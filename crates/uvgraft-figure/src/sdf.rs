//! Signed distances to simple solids, smooth unions, and ray marching.
//!
//! Distances are in the caller's unit, negative inside. Blends are polynomial smooth minima, which
//! are exact away from the seam, so that distant solids do not affect each other.

use glam::{Vec3, vec3};

/// An axis-aligned ellipsoid; zero at the surface, approximate elsewhere.
pub(crate) fn ellipsoid(p: Vec3, centre: Vec3, radii: Vec3) -> f32 {
    let q = p - centre;
    let scaled = vec3(q.x / radii.x, q.y / radii.y, q.z / radii.z);
    let twice = vec3(scaled.x / radii.x, scaled.y / radii.y, scaled.z / radii.z);
    let (near, steep) = (scaled.length(), twice.length());
    if steep > 0.0 { near * (near - 1.0) / steep } else { -radii.x.min(radii.y).min(radii.z) }
}

pub(crate) fn sphere(p: Vec3, centre: Vec3, radius: f32) -> f32 {
    (p - centre).length() - radius
}

/// A capsule with a linearly varying radius.
pub(crate) fn capsule(p: Vec3, from: Vec3, to: Vec3, radius_from: f32, radius_to: f32) -> f32 {
    let (along, offset) = (to - from, p - from);
    let t = (offset.dot(along) / along.dot(along)).clamp(0.0, 1.0);
    (offset - along * t).length() - (radius_from + (radius_to - radius_from) * t)
}

/// Union with a seam rounded over about `blend`.
pub(crate) fn join(a: f32, b: f32, blend: f32) -> f32 {
    let overlap = (blend - (a - b).abs()).max(0.0) / blend;
    a.min(b) - overlap * overlap * blend * 0.25
}

/// `a` without `b`, the edge rounded over about `blend`.
pub(crate) fn carve(a: f32, b: f32, blend: f32) -> f32 {
    -join(-a, b, blend)
}

/// The first point where a ray from inside leaves the solid, at most `reach` away.
pub(crate) fn leave(
    distance: impl Fn(Vec3) -> f32,
    origin: Vec3,
    direction: Vec3,
    reach: f32,
) -> Vec3 {
    meet(|p| -distance(p), origin, direction, reach)
}

/// The first point where a ray from outside meets the solid, at most `reach` away.
///
/// Sphere tracing (Hart 1996): steps as long as the distance to the nearest surface
/// cannot cross it.
pub(crate) fn meet(
    distance: impl Fn(Vec3) -> f32,
    origin: Vec3,
    direction: Vec3,
    reach: f32,
) -> Vec3 {
    // Blends and ellipsoids overestimate the distance slightly, so steps are shortened; the last
    // one is refined by bisection.
    const CAREFUL: f32 = 0.8;
    const SHORTEST: f32 = 0.03;
    let (mut free, mut travelled) = (0.0, 0.0);
    while travelled < reach {
        let step = distance(origin + direction * travelled);
        if step <= 0.0 {
            for _ in 0..10 {
                let middle = 0.5 * (free + travelled);
                if distance(origin + direction * middle) > 0.0 {
                    free = middle;
                } else {
                    travelled = middle;
                }
            }
            return origin + direction * travelled;
        }
        free = travelled;
        travelled += (step * CAREFUL).max(SHORTEST);
    }
    origin + direction * reach
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_end_on_the_surface_from_either_side() {
        let ball = |p: Vec3| sphere(p, vec3(1.0, 0.0, 0.0), 2.0);
        let out = leave(ball, vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), 10.0);
        assert!((out - vec3(1.0, 0.0, 2.0)).length() < 1e-3);
        let into = meet(ball, vec3(1.0, 0.0, 9.0), vec3(0.0, 0.0, -1.0), 20.0);
        assert!((into - vec3(1.0, 0.0, 2.0)).length() < 1e-3);
        let miss = meet(ball, vec3(1.0, 9.0, 9.0), vec3(0.0, 0.0, -1.0), 20.0);
        assert_eq!(miss, vec3(1.0, 9.0, -11.0));
    }

    #[test]
    fn blends_leave_alone_what_is_far_apart() {
        assert_eq!(join(1.0, 5.0, 2.0), 1.0);
        assert_eq!(carve(1.0, 5.0, 2.0), 1.0);
        assert!(join(1.0, 1.0, 2.0) < 1.0);
    }
}
