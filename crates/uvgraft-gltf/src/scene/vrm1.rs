//! The part of VRM 1.0's JSON that rendering needs.
//!
//! # Source
//! VRM Consortium, "VRMC_vrm 1.0": `humanoid` and `expressions`.

use std::collections::BTreeMap;

use serde::Deserialize;

/// The extension `VRMC_vrm`.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Vrm {
    pub humanoid: Humanoid,
    pub expressions: Expressions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Humanoid {
    pub human_bones: BTreeMap<String, HumanBone>,
}

#[derive(Debug, Deserialize)]
pub(super) struct HumanBone {
    pub node: u32,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Expressions {
    pub preset: BTreeMap<String, Expression>,
    pub custom: BTreeMap<String, Expression>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Expression {
    pub morph_target_binds: Vec<MorphTargetBind>,
    pub is_binary: bool,
}

#[derive(Debug, Deserialize)]
pub(super) struct MorphTargetBind {
    pub node: u32,
    pub index: u32,
    pub weight: f32,
}
