//! Gaze of an avatar: by rotating its eye joints, or by expressions if it has none.
//!
//! Source: VRM Consortium, "VRMC_vrm-1.0", `lookAt.md` (specification, 2022).

use glam::Vec3;
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::HumanBone;

use super::json;

/// Largest eye rotation, in degrees; beyond it, the head has to turn.
const HORIZONTAL: f32 = 35.0;
const VERTICAL: f32 = 25.0;

/// The expressions that move the eyes.
pub(super) const EXPRESSIONS: [&str; 4] = ["lookUp", "lookDown", "lookLeft", "lookRight"];

/// Range maps of the gaze. If both eyes are joints, they follow the target degree by degree up to
/// the limits. Otherwise the four expressions, if all exist, grow to full weight over the same
/// range. If neither is the case, there is no gaze control.
pub(super) fn json(avatar: &Avatar) -> Option<json::LookAt> {
    let place = |bone| {
        let joint = avatar.skeleton.human(bone)?;
        Some(Vec3::from(avatar.skeleton.joints()[joint].position))
    };
    let head = place(HumanBone::Head)?;
    let eyes = place(HumanBone::LeftEye).zip(place(HumanBone::RightEye));
    let (kind, center) = match eyes {
        Some((left, right)) => ("bone", (left + right) / 2.0),
        None => ("expression", moved_by_expressions(avatar)?),
    };
    let range = |degrees| json::RangeMap {
        input_max_value: degrees,
        output_scale: if kind == "bone" { degrees } else { 1.0 },
    };
    Some(json::LookAt {
        kind,
        offset_from_head_bone: (center - head).into(),
        range_map_horizontal_inner: range(HORIZONTAL),
        range_map_horizontal_outer: range(HORIZONTAL),
        range_map_vertical_down: range(VERTICAL),
        range_map_vertical_up: range(VERTICAL),
    })
}

/// The centroid of the vertices moved by the four expressions, weighted by displacement, which lies
/// between the eyes; `None` if an expression is missing or moves nothing.
fn moved_by_expressions(avatar: &Avatar) -> Option<Vec3> {
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for name in EXPRESSIONS {
        let is_it = |name_of: &str| name_of == name;
        let expression = avatar.expressions.iter().find(|expression| is_it(&expression.name))?;
        let before = weights;
        for &(morph, share) in &expression.morphs {
            for &(vertex, offset) in &avatar.morphs[morph].offsets {
                let weight = share.abs() * Vec3::from(offset).length();
                sum += weight * Vec3::from(avatar.mesh.positions()[vertex as usize]);
                weights += weight;
            }
        }
        if weights <= before {
            return None;
        }
    }
    (weights > 0.0).then(|| sum / weights)
}
