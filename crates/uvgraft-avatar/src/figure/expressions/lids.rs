//! Eyelids.

use super::Spot;
use crate::figure::head::seen;
use crate::figure::head_shape::{EYE, EYE_RADIUS, LID_RADIUS, LID_WIDTH, lower_lid, upper_lid};
use crate::vector::{Vec3, mix, smoothstep, vec3};

/// Where closed lids meet, from the upper lid's edge to the lower's.
const MEET: f32 = 0.82;

/// The lids of one eye close: `side` is 1 for the left one and -1 for the right one.
pub(super) fn blink(spot: Spot, side: f32) -> Vec3 {
    close(spot.p, side, 1.0)
}

/// What closes the lids of one eye by a share of the way; negative opens them wide.
pub(super) fn close(p: Vec3, side: f32, share: f32) -> Vec3 {
    let centre = vec3(side * EYE.x, EYE.y, EYE.z);
    let (dx, dy) = ((p.x - centre.x) * side, p.y - centre.y);
    if dx.abs() > 2.6 || dy.abs() > 2.6 || p.z < 4.0 {
        return Vec3::default();
    }
    let x = dx.clamp(-LID_WIDTH, LID_WIDTH);
    let (upper, lower) = (upper_lid(x), lower_lid(x));
    let closed = mix(upper, lower, MEET);
    let is_upper = dy > mix(upper, lower, 0.5);
    // Skin follows the lid's edge less and less up to the brow and down to the cheek.
    let shift = if is_upper {
        (closed - upper) * smoothstep(1.45, 0.0, dy - upper)
    } else {
        (closed - lower) * smoothstep(1.1, 0.0, lower - dy)
    };
    if shift == 0.0 {
        return Vec3::default();
    }
    let shift = shift * share;
    let from_centre = (p - centre).length();
    // The lid's underside lies in the ball's surface and moves with the edge.
    let depth =
        if from_centre < 0.5 * (EYE_RADIUS + LID_RADIUS) { from_centre / LID_RADIUS } else { 1.0 };
    let on_lid = if depth < 1.0 { centre + (p - centre) * (1.0 / depth) } else { p };
    let goal = seen(on_lid.x, on_lid.y + shift);
    (goal - on_lid) * depth
}
