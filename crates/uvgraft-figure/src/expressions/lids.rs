//! Eyelid morphs.

use glam::{Vec3, vec3};
use uvgraft::easing::{mix, smoothstep};

use super::Spot;
use crate::head::front_hit;
use crate::head_shape::{EYE, EYE_RADIUS, LID_RADIUS, LID_WIDTH, lower_lid, upper_lid};

/// Where closed lids meet, from 0 at the upper lid's edge to 1 at the lower's.
const MEET: f32 = 0.82;

/// Closes the lids of one eye: `side` is 1 for the left one and -1 for the right one.
pub(super) fn blink(spot: Spot, side: f32) -> Vec3 {
    close(spot.p, side, 1.0)
}

/// Offset that closes the lids of one eye by a fraction; a negative one opens them wide.
///
/// The vertical shift at the lid's edge fades out towards brow and cheek. The shifted point
/// is projected back onto the skin, so that the lid slides over the eyeball instead of
/// cutting through it.
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
    // The skin follows the lid's edge with a weight that falls to zero at the brow and at the
    // cheek.
    let shift = if is_upper {
        (closed - upper) * smoothstep(1.35, 0.0, dy - upper)
    } else {
        (closed - lower) * smoothstep(1.1, 0.0, lower - dy)
    };
    if shift == 0.0 {
        return Vec3::default();
    }
    let shift = shift * share;
    let from_centre = (p - centre).length();
    // The lid's underside lies on the eyeball and moves with the edge.
    let depth =
        if from_centre < 0.5 * (EYE_RADIUS + LID_RADIUS) { from_centre / LID_RADIUS } else { 1.0 };
    let on_lid = if depth < 1.0 { centre + (p - centre) * (1.0 / depth) } else { p };
    let goal = front_hit(on_lid.x, on_lid.y + shift);
    (goal - on_lid) * depth
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::head_shape::LID_RADIUS;
    use crate::symmetry::Symmetry as _;

    fn on_lid(dx: f32, y: f32) -> Vec3 {
        EYE + vec3(dx, y, (LID_RADIUS * LID_RADIUS - dx * dx - y * y).sqrt())
    }

    #[test]
    fn lids_meet_outside_the_eyeball() {
        const CORNEA: f32 = 0.05;
        for dx in [-1.2, -0.6, 0.0, 0.6, 1.2] {
            let (upper, lower) = (on_lid(dx, upper_lid(dx)), on_lid(dx, lower_lid(dx)));
            let close = |p: Vec3, share: f32| p + blink(Spot::new(p, None), 1.0) * share;
            // Ray marching is accurate to a twentieth of a millimetre.
            assert!((close(upper, 1.0).y - close(lower, 1.0).y).abs() < 0.005, "{dx}");
            for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
                for lid in [upper, lower] {
                    let radius = (close(lid, share) - EYE).length();
                    assert!(radius > EYE_RADIUS + CORNEA, "{dx} {share} {radius}");
                }
            }
        }
    }

    #[test]
    fn brow_cheek_and_the_other_eye_stay() {
        for p in [front_hit(EYE.x, 2.1), front_hit(EYE.x, -1.75), on_lid(0.0, 0.72).mirrored()] {
            assert_eq!(blink(Spot::new(p, None), 1.0), Vec3::default());
        }
    }
}
