//! Fingernails, found from the tips of the fingers.

use glam::Vec3;
use uvgraft::easing::smoothstep;
use uvgraft_avatar::body::Shaped;
use uvgraft_avatar::paint::bake::Spot;
use uvgraft_avatar::paint::texel::{Color, blend};

use super::{CM, SkinTone, scaled};

/// First joints of the hands: five fingers of three joints each, the thumb last.
const HANDS: [usize; 2] = [25, 40];
/// Length and half width of nails, in centimetres.
const LENGTH: f32 = 1.05;
const HALF_WIDTH: f32 = 0.50;

struct Nail {
    tip: Vec3,
    /// Towards the tip.
    along: Vec3,
    /// Away from the palm.
    up: Vec3,
    size: f32,
}

/// The fingernails of both hands.
pub(super) struct Nails(Vec<Nail>);

impl Nails {
    pub(super) fn new(body: &Shaped<'_>) -> Self {
        let (skin, joints) = (body.model().skin(), body.skeleton().joints());
        let nail = |(joint, is_thumb): (usize, bool)| {
            let [from, to] = [joint - 1, joint].map(|at| Vec3::from(joints[at].position) * CM);
            let along = (to - from).try_normalize()?;
            let of_joint = (0..skin.vertices())
                .filter(|&vertex| skin.of(vertex)[0].0 as usize == joint)
                .map(|vertex| Vec3::from(body.positions()[vertex]) * CM);
            let reach = |place: Vec3| (place - to).dot(along);
            let far = of_joint.max_by(|a, b| reach(*a).total_cmp(&reach(*b)))?;
            // Palms face down; thumbs are turned forward.
            let up = if is_thumb { Vec3::new(0.0, 0.75, 0.65) } else { Vec3::Y };
            let up = up.reject_from(along).try_normalize()?;
            let size = if is_thumb { 1.3 } else { 1.0 };
            Some(Nail { tip: to + along * reach(far), along, up, size })
        };
        let ends = HANDS
            .into_iter()
            .flat_map(|first| (0..5).map(move |finger| (first + 3 * finger + 2, finger == 4)));
        Self(ends.filter_map(nail).collect())
    }

    /// Paints the nails over the skin.
    pub(super) fn over(&self, color: Color, spot: &Spot, tone: &SkinTone) -> Color {
        self.0.iter().fold(color, |color, nail| {
            let offset = spot.position - nail.tip;
            if offset.length_squared() > 4.0 {
                return color;
            }
            let back = -offset.dot(nail.along) / nail.size;
            let side = offset.dot(nail.along.cross(nail.up)).abs() / nail.size;
            let round = LENGTH - 0.35 * (side / HALF_WIDTH).powi(2);
            let cover = smoothstep(0.02, 0.10, back)
                * smoothstep(round + 0.05, round - 0.05, back)
                * smoothstep(HALF_WIDTH + 0.05, HALF_WIDTH - 0.05, side)
                * smoothstep(0.35, 0.55, spot.normal.dot(nail.up));
            let plate = blend(tone.color(), [0.93, 0.76, 0.72], 0.38);
            // The free edge, and the lunula.
            let plate = blend(plate, [0.95, 0.92, 0.88], smoothstep(0.22, 0.14, back));
            let plate = blend(plate, [0.96, 0.88, 0.85], 0.35 * smoothstep(0.85, 0.95, back));
            blend(color, scaled(plate, 1.0), cover)
        })
    }
}
