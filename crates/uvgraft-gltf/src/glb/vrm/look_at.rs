//! Where an avatar looks: by turning the joints of its eyes, or by expressions where it has none.
//!
//! Source: VRM Consortium, "VRMC_vrm-1.0", `lookAt.md` (specification, 2022).

use glam::Vec3;
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::HumanBone;

use super::json;

/// How far eyes turn, in degrees; what is farther off, heads turn to.
const HORIZONTAL: f32 = 35.0;
const VERTICAL: f32 = 25.0;

/// The expressions that turn eyes.
pub(super) const EXPRESSIONS: [&str; 4] = ["lookUp", "lookDown", "lookLeft", "lookRight"];

/// Eyes follow what they look at, degree by degree, as far as they go, if both are joints. Where they are not,
/// expressions grow in as many degrees to their full weight, if there are all four. Else they look ahead.
pub(super) fn json(avatar: &Avatar) -> Option<json::LookAt> {
    let place = |bone| {
        let joint = avatar.skeleton.human(bone)?;
        Some(Vec3::from(avatar.skeleton.joints()[joint].position))
    };
    let head = place(HumanBone::Head)?;
    let eyes = place(HumanBone::LeftEye).zip(place(HumanBone::RightEye));
    let (kind, middle) = match eyes {
        Some((left, right)) => ("bone", (left + right) / 2.0),
        None => ("expression", moved_by_expressions(avatar)?),
    };
    let range = |degrees| json::RangeMap {
        input_max_value: degrees,
        output_scale: if kind == "bone" { degrees } else { 1.0 },
    };
    Some(json::LookAt {
        kind,
        offset_from_head_bone: (middle - head).into(),
        range_map_horizontal_inner: range(HORIZONTAL),
        range_map_horizontal_outer: range(HORIZONTAL),
        range_map_vertical_down: range(VERTICAL),
        range_map_vertical_up: range(VERTICAL),
    })
}

/// The middle of what the four expressions move, each vertex by how far, which is between the eyes; `None` if one is
/// missing or moves nothing.
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
