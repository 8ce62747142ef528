//! VRM 1.0: the mapping from joints to human bones, expressions, and metadata.
//!
//! Source: VRM Consortium, "VRMC_vrm-1.0": `humanoid.md`, `expressions.md`, `lookAt.md`,
//! `firstPerson.md`, `meta.md` (specification, 2022).

mod humanoid;
pub(super) mod json;
mod look_at;
mod meta;

use std::collections::{BTreeMap, HashSet};

use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::HumanBone;

pub use self::meta::{AvatarPermission, CommercialUsage, Modification, Permissions, VrmMeta};
use super::nodes::MeshNode;

/// The extension's name.
pub(super) const EXTENSION: &str = "VRMC_vrm";

/// Why an avatar cannot be a VRM file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VrmError {
    /// Required metadata is missing.
    #[error("the avatar of a VRM file {problem}")]
    Meta {
        /// What is missing.
        problem: &'static str,
    },
    /// Required bones are missing.
    #[error("the skeleton of a VRM file must have the bones {}", names(bones))]
    MissingBones {
        /// The missing bones.
        bones: Vec<HumanBone>,
    },
    /// A bone is not a descendant of the required one.
    #[error(
        "the bone `{}` of a VRM file must be a descendant of the bone `{}`",
        bone.name(),
        parent.name()
    )]
    Hierarchy {
        /// The bone.
        bone: HumanBone,
        /// The ancestor it must have, direct or indirect.
        parent: HumanBone,
    },
    /// A bone is present without another, otherwise optional one that it depends on.
    #[error("the bone `{}` of a VRM file needs the bone `{}`", bone.name(), parent.name())]
    Alone {
        /// The bone.
        bone: HumanBone,
        /// The missing bone.
        parent: HumanBone,
    },
    /// Two expressions have the same VRM preset.
    #[error("duplicate VRM expression `{preset}`")]
    Preset {
        /// The preset.
        preset: &'static str,
    },
    /// A morph weight of an expression is outside 0 to 1.
    #[error("expression `{expression}`: morph weights must be 0 to 1, got {weight}")]
    Weight {
        /// Name of the expression.
        expression: String,
        /// Value of the weight.
        weight: f32,
    },
}

fn names(bones: &[HumanBone]) -> String {
    bones.iter().map(|bone| format!("`{}`", bone.name())).collect::<Vec<_>>().join(", ")
}

/// Checks VRM's requirements beyond glTF.
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

/// The extension's JSON for an avatar that passed [`check`]. Nodes have the indices of their
/// joints.
///
/// - `shown`: the mesh nodes.
/// - `thumbnail`: index of an image.
pub(super) fn extension(
    meta: &VrmMeta,
    avatar: &Avatar,
    shown: &[MeshNode],
    thumbnail: Option<usize>,
) -> json::Vrm {
    let annotation = |shown: &MeshNode| json::MeshAnnotation {
        node: shown.node,
        // For `auto`, readers use the skin weights to find the triangles that follow the head.
        kind: if shown.is_head { "thirdPersonOnly" } else { "auto" },
    };
    json::Vrm {
        spec_version: "1.0",
        meta: meta.json(thumbnail),
        humanoid: humanoid::json(&avatar.skeleton),
        first_person: json::FirstPerson {
            mesh_annotations: shown.iter().map(annotation).collect(),
        },
        look_at: look_at::json(avatar),
        expressions: expressions(avatar, shown),
    }
}

fn expressions(avatar: &Avatar, shown: &[MeshNode]) -> Option<json::Expressions> {
    if avatar.expressions.is_empty() {
        return None;
    }
    let mut all = json::Expressions::default();
    for expression in &avatar.expressions {
        let binds = expression.morphs.iter().flat_map(|&(index, weight)| {
            let moved = shown.iter().filter(move |shown| shown.moves[index]);
            moved.map(move |shown| json::MorphTargetBind { node: shown.node, index, weight })
        });
        let written = json::Expression {
            morph_target_binds: binds.collect(),
            is_binary: false,
            override_blink: "none",
            override_look_at: "none",
            override_mouth: "none",
        };
        let (list, name): (&mut BTreeMap<_, _>, _) = match expression.preset {
            Some(preset) => (&mut all.preset, preset.name().to_owned()),
            // Custom expressions must not have the names of presets.
            None if look_at::EXPRESSIONS.contains(&&*expression.name) => {
                (&mut all.preset, expression.name.clone())
            }
            None => (&mut all.custom, expression.name.clone()),
        };
        list.insert(name, written);
    }
    Some(all)
}
