//! VRM 1.0: which joints are which bones of a human, what expressions there are, and whose avatar it is.
//!
//! Source: VRM Consortium, "VRMC_vrm-1.0": `humanoid.md`, `expressions.md`, `lookAt.md`,
//! `firstPerson.md`, `meta.md` (specification, 2022).

mod humanoid;
pub(super) mod json;
mod meta;

use std::collections::{BTreeMap, HashSet};

use glam::Vec3;

pub use self::meta::{AvatarPermission, CommercialUsage, Modification, Permissions, VrmMeta};

use crate::Avatar;
use crate::rig::HumanBone;

/// The extension's name.
pub(super) const EXTENSION: &str = "VRMC_vrm";

/// Why an avatar cannot be a VRM file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VrmError {
    /// Something that a file must say about itself is not there.
    #[error("the avatar {problem}, which a VRM file must have")]
    Meta {
        /// What.
        problem: &'static str,
    },
    /// Bones that a file must have.
    #[error("the skeleton has no {}, which a VRM file must have", names(bones))]
    MissingBones {
        /// Which.
        bones: Vec<HumanBone>,
    },
    /// A bone does not hang on the one that it must hang on.
    #[error(
        "the bone `{}` does not hang on the bone `{}`, as it must in a VRM file",
        bone.name(),
        parent.name()
    )]
    Hierarchy {
        /// Which.
        bone: HumanBone,
        /// What it must hang on, directly or not.
        parent: HumanBone,
    },
    /// A bone needs another that may be missing otherwise.
    #[error("the skeleton has `{}` without `{}`, which VRM rules out", bone.name(), parent.name())]
    Alone {
        /// Which.
        bone: HumanBone,
        /// What is missing.
        parent: HumanBone,
    },
    /// Two expressions are the same one of VRM's.
    #[error("two expressions are VRM's `{preset}`")]
    Preset {
        /// Which.
        preset: &'static str,
    },
    /// Weights of expressions are parts of 1.
    #[error("expression `{expression}` mixes in a morph by {weight}, wanted 0 to 1")]
    Weight {
        /// Which.
        expression: String,
        /// What was found.
        weight: f32,
    },
}

fn names(bones: &[HumanBone]) -> String {
    bones.iter().map(|bone| format!("`{}`", bone.name())).collect::<Vec<_>>().join(", ")
}

/// Checks what VRM asks for beyond glTF.
pub(super) fn check(meta: &VrmMeta, avatar: &Avatar) -> Result<(), VrmError> {
    meta.check()?;
    humanoid::check(&avatar.skeleton)?;
    let mut presets = HashSet::new();
    for expression in &avatar.expressions {
        if let Some(preset) = expression.preset.filter(|&preset| !presets.insert(preset)) {
            return Err(VrmError::Preset { preset: preset.name() });
        }
        let wrong = |weight: &f32| !(0.0..=1.0).contains(weight);
        let mut weights = expression.morphs.iter().map(|&(_, weight)| weight);
        if let Some(weight) = weights.find(wrong) {
            return Err(VrmError::Weight { expression: expression.name.clone(), weight });
        }
    }
    Ok(())
}

/// The extension of an avatar that was checked. Nodes have the numbers of joints, and the mesh's is
/// the next.
pub(super) fn extension(meta: &VrmMeta, avatar: &Avatar) -> json::Vrm {
    let mesh_node = avatar.skeleton.joints().len();
    let annotation = json::MeshAnnotation { node: mesh_node, kind: "auto" };
    json::Vrm {
        spec_version: "1.0",
        meta: meta.json(),
        humanoid: humanoid::json(&avatar.skeleton),
        first_person: json::FirstPerson { mesh_annotations: vec![annotation] },
        look_at: look_at(avatar),
        expressions: expressions(avatar, mesh_node),
    }
}

/// How far eyes turn, in degrees; what is farther off, heads turn to.
const HORIZONTAL: f32 = 35.0;
const VERTICAL: f32 = 25.0;

/// Eyes follow what they look at, degree by degree, as far as they go, if both are joints.
fn look_at(avatar: &Avatar) -> Option<json::LookAt> {
    let place = |bone| {
        let joint = avatar.skeleton.human(bone)?;
        Some(Vec3::from(avatar.skeleton.joints()[joint].position))
    };
    let (left, right) = (place(HumanBone::LeftEye)?, place(HumanBone::RightEye)?);
    let offset = (left + right) / 2.0 - place(HumanBone::Head)?;
    let range = |degrees| json::RangeMap { input_max_value: degrees, output_scale: degrees };
    Some(json::LookAt {
        kind: "bone",
        offset_from_head_bone: offset.into(),
        range_map_horizontal_inner: range(HORIZONTAL),
        range_map_horizontal_outer: range(HORIZONTAL),
        range_map_vertical_down: range(VERTICAL),
        range_map_vertical_up: range(VERTICAL),
    })
}

fn expressions(avatar: &Avatar, node: usize) -> Option<json::Expressions> {
    if avatar.expressions.is_empty() {
        return None;
    }
    let mut all = json::Expressions::default();
    for expression in &avatar.expressions {
        let bind = |&(index, weight)| json::MorphTargetBind { node, index, weight };
        let written = json::Expression {
            morph_target_binds: expression.morphs.iter().map(bind).collect(),
            is_binary: false,
            override_blink: "none",
            override_look_at: "none",
            override_mouth: "none",
        };
        let (list, name): (&mut BTreeMap<_, _>, _) = match expression.preset {
            Some(preset) => (&mut all.preset, preset.name().to_owned()),
            None => (&mut all.custom, expression.name.clone()),
        };
        list.insert(name, written);
    }
    Some(all)
}
