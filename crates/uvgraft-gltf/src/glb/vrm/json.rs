//! The JSON of the extension `VRMC_vrm`, limited to what avatars need.

use std::collections::BTreeMap;

use serde::Serialize;

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::glb) struct Vrm {
    pub spec_version: &'static str,
    pub meta: Meta,
    pub humanoid: Humanoid,
    pub first_person: FirstPerson,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look_at: Option<LookAt>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expressions: Option<Expressions>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::glb) struct Meta {
    pub name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
    pub authors: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub copyright_information: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_information: Option<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub references: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub third_party_licenses: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thumbnail_image: Option<usize>,
    pub license_url: &'static str,
    pub avatar_permission: &'static str,
    pub allow_excessively_violent_usage: bool,
    pub allow_excessively_sexual_usage: bool,
    pub commercial_usage: &'static str,
    pub allow_political_or_religious_usage: bool,
    pub allow_antisocial_or_hate_usage: bool,
    pub credit_notation: &'static str,
    pub allow_redistribution: bool,
    pub modification: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_license_url: Option<String>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::glb) struct Humanoid {
    pub human_bones: BTreeMap<&'static str, HumanBoneNode>,
}

#[derive(Serialize)]
pub(in crate::glb) struct HumanBoneNode {
    pub node: usize,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::glb) struct FirstPerson {
    pub mesh_annotations: Vec<MeshAnnotation>,
}

#[derive(Serialize)]
pub(in crate::glb) struct MeshAnnotation {
    pub node: usize,
    #[serde(rename = "type")]
    pub kind: &'static str,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::glb) struct LookAt {
    #[serde(rename = "type")]
    pub kind: &'static str,
    pub offset_from_head_bone: [f32; 3],
    pub range_map_horizontal_inner: RangeMap,
    pub range_map_horizontal_outer: RangeMap,
    pub range_map_vertical_down: RangeMap,
    pub range_map_vertical_up: RangeMap,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::glb) struct RangeMap {
    pub input_max_value: f32,
    pub output_scale: f32,
}

#[derive(Serialize, Default)]
pub(in crate::glb) struct Expressions {
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub preset: BTreeMap<String, Expression>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub custom: BTreeMap<String, Expression>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::glb) struct Expression {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub morph_target_binds: Vec<MorphTargetBind>,
    pub is_binary: bool,
    pub override_blink: &'static str,
    pub override_look_at: &'static str,
    pub override_mouth: &'static str,
}

#[derive(Serialize)]
pub(in crate::glb) struct MorphTargetBind {
    pub node: usize,
    pub index: usize,
    pub weight: f32,
}
