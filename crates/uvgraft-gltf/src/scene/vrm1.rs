//! The part of VRM 1.0's JSON that rendering needs.
//!
//! # Source
//! VRM Consortium, "VRMC_vrm 1.0": `humanoid` and `expressions`.

use std::collections::BTreeMap;

use serde::Deserialize;

/// The extension `VRMC_vrm`.
#[derive(Debug, Deserialize)]
pub(super) struct Vrm {
    #[serde(default)]
    pub humanoid: Humanoid,
    #[serde(default)]
    pub expressions: Expressions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Humanoid {
    #[serde(default)]
    pub human_bones: BTreeMap<String, HumanBone>,
}

#[derive(Debug, Deserialize)]
pub(super) struct HumanBone {
    pub node: u32,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct Expressions {
    #[serde(default)]
    pub preset: BTreeMap<String, Expression>,
    #[serde(default)]
    pub custom: BTreeMap<String, Expression>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Expression {
    #[serde(default)]
    pub morph_target_binds: Vec<MorphTargetBind>,
    #[serde(default)]
    pub is_binary: bool,
}

#[derive(Debug, Deserialize)]
pub(super) struct MorphTargetBind {
    pub node: u32,
    pub index: u32,
    pub weight: f32,
}
