//! VRM 1.0: which joints are which bones of a human, what expressions there are, and whose avatar it is.
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
use super::nodes::Shown;

/// The extension's name.
pub(super) const EXTENSION: &str = "VRMC_vrm";

/// Why an avatar cannot be a VRM file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VrmError {
    /// Something that a file must say about itself is not there.
    #[error("the avatar of a VRM file {problem}")]
    Meta {
        /// What.
        problem: &'static str,
    },
    /// Bones that a file must have.
    #[error("the skeleton of a VRM file must have the bones {}", names(bones))]
    MissingBones {
        /// Which.
        bones: Vec<HumanBone>,
    },
    /// A bone does not hang on the one that it must hang on.
    #[error(
        "the bone `{}` of a VRM file must be a descendant of the bone `{}`",
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
    #[error("the bone `{}` of a VRM file needs the bone `{}`", bone.name(), parent.name())]
    Alone {
        /// Which.
        bone: HumanBone,
        /// What is missing.
        parent: HumanBone,
    },
    /// Two expressions are the same one of VRM's.
    #[error("duplicate VRM expression `{preset}`")]
    Preset {
        /// Which.
        preset: &'static str,
    },
    /// Weights of expressions are parts of 1.
    #[error("expression `{expression}`: morph weights must be 0 to 1, got {weight}")]
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

/// The extension of an avatar that was checked. Nodes have the numbers of joints.
///
/// - `shown`: the nodes with meshes.
/// - `thumbnail`: the number of an image.
pub(super) fn extension(
    meta: &VrmMeta,
    avatar: &Avatar,
    shown: &[Shown],
    thumbnail: Option<usize>,
) -> json::Vrm {
    let annotation = |shown: &Shown| json::MeshAnnotation {
        node: shown.node,
        // Readers find out by weights which triangles of the others follow the head.
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

fn expressions(avatar: &Avatar, shown: &[Shown]) -> Option<json::Expressions> {
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
            // Custom expressions cannot have names of presets.
            None if look_at::EXPRESSIONS.contains(&&*expression.name) => {
                (&mut all.preset, expression.name.clone())
            }
            None => (&mut all.custom, expression.name.clone()),
        };
        list.insert(name, written);
    }
    Some(all)
}
