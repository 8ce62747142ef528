//! Morphs of brows and forehead.

use glam::{Vec3, vec3};
use uvgraft::easing::{bell, smoothstep};

use super::{Spot, lids};

/// Raises both brows and opens the eyes wide.
pub(super) fn up(spot: Spot) -> Vec3 {
    let brow = near_brow(spot.p);
    let wide = lids::close(spot.p, spot.p.x.signum(), -0.16);
    spot.slid(0.0, 0.55 * brow) + wide
}

/// Lowers the inner ends of the brows and draws them together.
pub(super) fn angry(spot: Spot) -> Vec3 {
    let p = spot.p;
    let inner = bell(p.x.abs() - 1.6, 1.8);
    let outer = bell(p.x.abs() - 5.0, 1.3);
    let brow = near_brow(p);
    let together = -p.x.signum() * smoothstep(0.2, 1.4, p.x.abs()) * 0.26 * inner;
    spot.slid(together * brow, (0.16 * outer - 0.5 * inner) * brow)
        + vec3(0.0, 0.0, 0.12 * inner * brow)
        + lids::close(p, p.x.signum(), 0.10)
}

/// Raises the inner ends of the brows and draws them together.
pub(super) fn sad(spot: Spot) -> Vec3 {
    let p = spot.p;
    let inner = bell(p.x.abs() - 1.5, 1.6);
    let outer = bell(p.x.abs() - 5.0, 1.6);
    let brow = near_brow(p);
    let together = -p.x.signum() * smoothstep(0.2, 1.4, p.x.abs()) * 0.16 * inner;
    spot.slid(together * brow, (0.48 * inner - 0.18 * outer) * brow)
        + lids::close(p, p.x.signum(), 0.14)
}

/// 1 along the brows; 0 on the lids, the nose and under the hair.
fn near_brow(p: Vec3) -> f32 {
    let x = p.x.abs();
    smoothstep(0.75, 1.75, p.y)
        * smoothstep(5.2, 2.9, p.y)
        * smoothstep(7.0, 5.4, x)
        * smoothstep(2.0, 4.5, p.z)
}
