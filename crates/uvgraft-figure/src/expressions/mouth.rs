//! Jaw and lip morphs.

use glam::{Vec3, vec3};
use uvgraft::easing::{bell, smoothstep};

use super::Spot;
use crate::head_shape::{LIP_WIDTH, MOUTH_Y, lip_line};
use crate::rigging::head::{is_lower, jaw};
use crate::rigging::joints::JAW;

/// Rotates the jaw about its hinge, which opens the mouth; the corners of the mouth move together.
pub(super) fn jaw_open(spot: Spot) -> Vec3 {
    const ANGLE: f32 = 0.24;
    let p = spot.p;
    let share = jaw(p, spot.lip);
    let (sin, cos) = ANGLE.sin_cos();
    let q = p - JAW;
    let turned = vec3(q.x, q.y * cos - q.z * sin, q.y * sin + q.z * cos);
    let narrow = spot.slid(-0.16 * across(p.x) * near_lips(p, 1.8), 0.0);
    (turned - q) * share + narrow
}

/// Moves the corners of the mouth out and up, and raises the cheeks.
pub(super) fn smile(spot: Spot) -> Vec3 {
    let p = spot.p;
    let near = near_lips(p, 2.0);
    let a = across(p.x);
    let mut dx = 0.78 * a * near;
    let mut dy = (0.72 * a * a - 0.12 * (1.0 - a * a)) * near;
    let side = p.x.signum();
    let cheek = bell(p.x.abs() - 3.9, 1.7) * bell(p.y + 3.9, 1.7) * smoothstep(1.5, 4.5, p.z);
    dx += side * 0.12 * cheek;
    dy += 0.34 * cheek;
    spot.slid(dx, dy) + vec3(0.0, 0.0, 0.22 * cheek)
}

/// Lowers the corners of the mouth.
pub(super) fn frown(spot: Spot) -> Vec3 {
    let p = spot.p;
    let a = across(p.x);
    let near = near_lips(p, 1.6);
    spot.slid(-0.10 * a * near, (-0.42 * a * a + 0.10 * (1.0 - a * a)) * near)
}

/// Draws the lips together into a ring, and forward.
pub(super) fn lips_round(spot: Spot) -> Vec3 {
    let p = spot.p;
    let a = across(p.x);
    let near = near_lips(p, 1.5);
    // Beside the nose more of the cheek can follow, which then bends less.
    let beside = smoothstep(1.2, 3.4, p.x.abs());
    let off = (p.y - lip_line(p.x.clamp(-LIP_WIDTH, LIP_WIDTH))).abs();
    let wide = bell((off - 0.3).max(0.0), 2.3)
        * smoothstep(-2.2, -6.2, p.y)
        * smoothstep(MOUTH_Y - 4.8, MOUTH_Y - 1.8, p.y)
        * smoothstep(1.5, 4.0, p.z);
    let near = near + (wide - near) * beside;
    let middle = (1.0 - a * a) * near;
    let apart = if is_lower(p, spot.lip) { -0.20 } else { 0.12 };
    // Cheeks follow smoothly, less further out and up: lips pull them, nothing pushes them.
    let t = (p.x / LIP_WIDTH).abs();
    let pulled = smoothstep(1.95, 0.55, t) * near;
    spot.slid(-0.82 * a * near * smoothstep(2.1, 1.0, t), apart * middle)
        + vec3(0.0, 0.0, (0.32 + 0.25 * (1.0 - t.min(1.0).powi(2))) * pulled)
}

/// Moves the corners of the mouth out; the lips part a little.
pub(super) fn lips_wide(spot: Spot) -> Vec3 {
    let p = spot.p;
    let a = across(p.x);
    let near = near_lips(p, 1.7);
    let apart = if is_lower(p, spot.lip) { -0.22 } else { 0.13 };
    spot.slid(0.55 * a * near, apart * (1.0 - a * a) * near)
}

/// From -1 at the right corner of the mouth to 1 at the left one, falling back to 0 further out.
fn across(x: f32) -> f32 {
    let t = x.abs() / LIP_WIDTH;
    // Meets the straight part without a kink at the corners.
    let rise = t.min(1.0) * smoothstep(2.1, 0.95, t);
    x.signum() * rise
}

/// 1 on the lips, falling off above and below; the inside of the mouth is included.
fn near_lips(p: Vec3, reach: f32) -> f32 {
    let line = lip_line(p.x.clamp(-LIP_WIDTH, LIP_WIDTH));
    let off = (p.y - line).abs();
    // The nose does not move.
    bell((off - 0.7).max(0.0), reach * 0.75)
        * smoothstep(-4.7, -6.0, p.y + 0.15 * p.x.abs().min(4.0))
        * smoothstep(MOUTH_Y - 4.2, MOUTH_Y - 2.6, p.y)
        * smoothstep(1.5, 4.0, p.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::head::front_hit;
    use crate::symmetry::Symmetry as _;

    fn spot(x: f32, lower: bool) -> Spot {
        let along = 1.0 - (x / LIP_WIDTH).powi(2);
        Spot::new(front_hit(x, lip_line(x)), Some(if lower { along } else { -along }))
    }

    #[test]
    fn the_jaw_moves_the_lower_lip_and_not_the_upper_one() {
        let (upper, lower) = (jaw_open(spot(0.0, false)), jaw_open(spot(0.0, true)));
        assert!(upper.length() < 0.05, "{upper:?}");
        assert!((-2.6..-1.4).contains(&lower.y) && lower.z < -0.5, "{lower:?}");
        // At the corners both lips move alike.
        let corner = |lower| jaw_open(spot(LIP_WIDTH, lower));
        assert!((corner(true) - corner(false)).length() < 0.02);
        let nose = Spot::new(front_hit(0.0, -4.0), None);
        assert_eq!(jaw_open(nose), Vec3::default());
    }

    #[test]
    fn a_smile_lifts_the_corners_outwards() {
        let corner = smile(spot(LIP_WIDTH, false));
        assert!(corner.x > 0.5 && corner.y > 0.5 && corner.z < 0.0, "{corner:?}");
        let other = smile(spot(-LIP_WIDTH, false));
        assert!((other.mirrored() - corner).length() < 1e-3);
        assert!(frown(spot(LIP_WIDTH, false)).y < -0.3);
        assert!(lips_round(spot(LIP_WIDTH, false)).x < -0.5);
        assert!(lips_wide(spot(LIP_WIDTH, false)).x > 0.4);
    }
}
